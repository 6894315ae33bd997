/// Umbrella of the readers of meshes and robots. Link bullet_ccd::io.
#pragma once

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/robot_file.h"
