#include "bullet_ccd/hierarchy/ssv_tree.h"
