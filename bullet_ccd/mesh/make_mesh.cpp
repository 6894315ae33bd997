#include "bullet_ccd/mesh/make_mesh.h"
