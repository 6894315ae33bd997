// Compiled for whatever the compiler's default target is.
#define BULLET_CCD_ISA baseline
#include "bullet_ccd/toi/kernels/node_batch_kernel.h"
#include "bullet_ccd/toi/kernels/triangle_approach_kernel.h"
