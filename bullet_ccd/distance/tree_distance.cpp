#include "bullet_ccd/distance/tree_distance.h"
