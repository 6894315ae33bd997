// Compiled for AVX2 and FMA; called only where the processor has them.
#define BULLET_CCD_ISA avx2
#include "bullet_ccd/deformable/kernels/box_kernel.h"
#include "bullet_ccd/deformable/kernels/separation_kernel.h"
