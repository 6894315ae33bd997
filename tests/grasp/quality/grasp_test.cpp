#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/grasp_types.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

namespace bullet_ccd::grasp
{
namespace
{
TEST(GraspObject, ClosedBoxHasItsCenterAndHalfDiagonal)
{
    TriangleMesh mesh = makeBox({0.1, 0.2, 0.3});
    transformMesh(mesh, Eigen::Affine3d(Eigen::Translation3d(1.0, 2.0, 3.0)));
    const GraspObject object = makeGraspObject("box", mesh);
    EXPECT_EQ(object.name, "box");
    EXPECT_TRUE(object.watertight);
    EXPECT_LT((object.centerOfMass - Eigen::Vector3d(1.0, 2.0, 3.0)).norm(), 1e-12);
    EXPECT_NEAR(object.radius, std::sqrt(0.14), 1e-12);
    EXPECT_EQ(object.tree.mesh().triangles.size(), 12U);
}

TEST(GraspObject, OpenMeshIsTakenForItsBoundingBox)
{
    TriangleMesh mesh = makeBox({0.1, 0.1, 0.1});
    mesh.triangles.pop_back();
    const GraspObject object = makeGraspObject("open box", mesh);
    EXPECT_FALSE(object.watertight);
    EXPECT_LT(object.centerOfMass.norm(), 1e-12);
}

TEST(GraspObject, MeshThatNoQuerySurvivesIsRefusedByName)
{
    try
    {
        static_cast<void>(makeGraspObject("nothing.obj", {}));
        FAIL() << "no exception";
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_EQ(std::string(error.what()).find("nothing.obj"), 0U);
    }
}

TEST(RejectReason, EveryReasonHasItsOwnName)
{
    std::set<std::string> names;
    for (int i = 0; i <= static_cast<int>(RejectReason::IterationLimit); ++i)
    {
        names.insert(toString(static_cast<RejectReason>(i)));
    }
    EXPECT_EQ(names.size(), 8U);
    EXPECT_EQ(names.count("unknown"), 0U);
}
}  // namespace
}  // namespace bullet_ccd::grasp
