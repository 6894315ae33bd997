#include "bullet_ccd/io/urdf_file.h"
