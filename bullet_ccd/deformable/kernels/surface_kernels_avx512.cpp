// Compiled for AVX-512 (F, BW, DQ, VL); called only where the processor has them.
#define BULLET_CCD_ISA avx512
#include "bullet_ccd/deformable/kernels/box_kernel.h"
#include "bullet_ccd/deformable/kernels/separation_kernel.h"
