#include "bullet_ccd/mesh/triangle_mesh.h"
