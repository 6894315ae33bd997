#include "bullet_ccd/bullet/btCcdPrecision.h"

#ifdef BT_USE_DOUBLE_PRECISION
extern "C" const char btCcdBuiltForDouble = 1;
#else
extern "C" const char btCcdBuiltForSingle = 1;
#endif
