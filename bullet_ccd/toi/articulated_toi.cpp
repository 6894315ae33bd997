#include "bullet_ccd/toi/articulated_toi.h"
