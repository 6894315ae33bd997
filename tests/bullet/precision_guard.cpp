// Linked to the wrong adapter on purpose; see CMakeLists.txt.
#include "bullet_ccd/bullet/btCcdPrecision.h"

int main()
{
    return 0;
}
