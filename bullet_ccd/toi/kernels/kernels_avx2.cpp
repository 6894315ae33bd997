// Compiled for AVX2 and FMA; called only where the processor has them.
#define BULLET_CCD_ISA avx2
#include "bullet_ccd/toi/kernels/node_batch_kernel.h"
#include "bullet_ccd/toi/kernels/triangle_approach_kernel.h"
