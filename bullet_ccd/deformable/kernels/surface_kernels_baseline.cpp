// Compiled for whatever the compiler's default target is.
#define BULLET_CCD_ISA baseline
#include "bullet_ccd/deformable/kernels/box_kernel.h"
#include "bullet_ccd/deformable/kernels/separation_kernel.h"
