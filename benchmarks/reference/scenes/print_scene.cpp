#include "benchmarks/reference/scenes/print_scene.h"

#include <ostream>

namespace bullet_ccd::reference
{
void printMesh(std::ostream& out, const std::string& name, const TriangleMesh& mesh)
{
    out << name << ": " << mesh.vertices.size() << " vertices, " << mesh.triangles.size()
        << " triangles\n";
    for (const Eigen::Vector3d& v : mesh.vertices)
    {
        out << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    }
    for (const Triangle& t : mesh.triangles)
    {
        out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    }
}

void printMotion(std::ostream& out, const std::string& name, const RigidMotion& motion)
{
    const Eigen::IOFormat rows(Eigen::FullPrecision, Eigen::DontAlignCols, ", ", "; ");
    out << name << ": pose " << motion.X_W0.matrix().topRows<3>().format(rows) << "\n  v "
        << motion.v_W.transpose() << "  w " << motion.w_W.transpose() << "  reference "
        << motion.reference_B.transpose() << '\n';
}
}  // namespace bullet_ccd::reference
