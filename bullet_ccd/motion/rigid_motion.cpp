#include "bullet_ccd/motion/rigid_motion.h"
