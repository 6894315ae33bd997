#include "bullet_ccd/distance/triangle_distance.h"
