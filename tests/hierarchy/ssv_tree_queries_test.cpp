// Queries must not depend on how the volumes came about: a refitted hierarchy gives the answers of
// one that was built.
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/tree_check.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

TEST(SsvTreeQueries, ARefittedTreeGivesTheAnswersOfOneBuiltAnew)
{
    Random random(2);
    for (int i = 0; i < 3; ++i)
    {
        const TriangleMesh mesh = makeTorus(1.0, 0.3, 32, 16);
        SsvTree refitted = buildSsvTree(mesh);
        TriangleMesh moved = mesh;
        for (Vector3d& p : moved.vertices)
        {
            p = Vector3d(p.x() * (1.0 + 0.4 * p.y()), 0.8 * p.y(), p.z() + 0.5 * p.x() * p.x()) +
                random.inBox(0.02);
        }
        refitted.refit(moved.vertices);
        expectSameAnswers(refitted, buildSsvTree(moved), random, 30);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
