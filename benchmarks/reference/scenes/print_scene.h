/// Parts of scenes as text, for programs that show one query.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <iosfwd>
#include <string>

namespace bullet_ccd::reference
{
/// As OBJ: vertices and faces counted from 1, after a line with their numbers.
void printMesh(std::ostream& out, const std::string& name, const TriangleMesh& mesh);

/// The pose with all digits, velocities with those of the stream.
void printMotion(std::ostream& out, const std::string& name, const RigidMotion& motion);
}  // namespace bullet_ccd::reference
