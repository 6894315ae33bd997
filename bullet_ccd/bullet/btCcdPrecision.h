/// Link-time guard of the floating-point precision.
///
/// btScalar is part of every Bullet type. So a program that is compiled for one precision and
/// linked to the adapter of the other would corrupt memory silently. Every header of the adapter
/// refers to a symbol that is named after the precision of the program, and each of the two
/// libraries defines only its own symbol. A mismatch is an undefined reference to
/// btCcdBuiltForSingle or btCcdBuiltForDouble.
#ifndef BT_CCD_PRECISION_H
#define BT_CCD_PRECISION_H

#include "bullet_ccd/export.h"

#ifdef BT_USE_DOUBLE_PRECISION
extern "C" BULLET_CCD_API const char btCcdBuiltForDouble;
#define BT_CCD_BUILT_FOR btCcdBuiltForDouble
#else
extern "C" BULLET_CCD_API const char btCcdBuiltForSingle;
#define BT_CCD_BUILT_FOR btCcdBuiltForSingle
#endif

namespace
{
// "used": the reference must reach the linker although nobody reads it.
[[gnu::used]] const char* const btCcdPrecisionGuard = &BT_CCD_BUILT_FOR;
}  // namespace

#undef BT_CCD_BUILT_FOR

#endif  // BT_CCD_PRECISION_H
