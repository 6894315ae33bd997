#include "bullet_ccd/motion/joint_motion.h"
