#include "bullet_ccd/toi/rigid_toi.h"
