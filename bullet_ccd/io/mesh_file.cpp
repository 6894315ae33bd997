#include "bullet_ccd/io/mesh_file.h"
