// Compiled for whatever the compiler's default target is.
#define BULLET_CCD_ISA baseline
#include "bullet_ccd/toi/node_batch_kernel.h"
#include "bullet_ccd/toi/triangle_approach_kernel.h"
