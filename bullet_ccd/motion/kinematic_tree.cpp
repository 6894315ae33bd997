#include "bullet_ccd/motion/kinematic_tree.h"
