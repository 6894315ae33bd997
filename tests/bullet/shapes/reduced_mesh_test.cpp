/// Which shapes stand for bodies in a world of an accuracy.
#include "bullet_ccd/bullet/btCcdReducedMesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>

namespace bullet_ccd::tests
{
namespace
{
constexpr double kAccuracy = 2e-3;  // [m]

/// How far the box about the shape is from that about the mesh, at most.
double differenceOfBoxes(const TriangleMesh& mesh, const btCcdReducedMesh& reduced)
{
    const std::unique_ptr<btCollisionShape> shape = reduced.makeShape(btScalar(0));
    btVector3 low;
    btVector3 high;
    shape->getAabb(btTransform::getIdentity(), low, high);
    const Eigen::AlignedBox3d box = bounds(mesh);
    return std::max((btCcdToEigen(low) - box.min()).cwiseAbs().maxCoeff(),
                    (btCcdToEigen(high) - box.max()).cwiseAbs().maxCoeff());
}

TEST(ReducedMesh, IsAStockShapeWhereThatIsWithinItsShareOfTheAccuracy)
{
    Eigen::Affine3d place = Eigen::Affine3d::Identity();
    place.translation() = Eigen::Vector3d(0.1, -0.05, 0.02);
    TriangleMesh ball = makeSphere(0.05, 4);
    transformMesh(ball, place);
    place.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()));
    TriangleMesh pill = makeCapsule(0.03, 0.1, 64);
    transformMesh(pill, place);
    const TriangleMesh brick = makeBox({0.1, 0.05, 0.03});
    for (const auto& [mesh, name, type] : {std::tuple(ball, "sphere", SPHERE_SHAPE_PROXYTYPE),
                                           std::tuple(pill, "capsule", CAPSULE_SHAPE_PROXYTYPE),
                                           std::tuple(brick, "box", BOX_SHAPE_PROXYTYPE)})
    {
        const btCcdReducedMesh reduced(mesh, kAccuracy);
        EXPECT_EQ(reduced.name(), std::string(name));
        EXPECT_EQ(reduced.triangles(), 0U);
        EXPECT_LE(reduced.model().deviation(), btCcdReducedMesh::kShare * kAccuracy);
        EXPECT_LT(differenceOfBoxes(mesh, reduced), btCcdReducedMesh::kShare * kAccuracy);
        const std::unique_ptr<btCollisionShape> shape = reduced.makeShape();
        ASSERT_EQ(shape->getShapeType(), COMPOUND_SHAPE_PROXYTYPE);
        EXPECT_EQ(static_cast<const btCompoundShape&>(*shape).getChildShape(0)->getShapeType(),
                  type);
    }
}

TEST(ReducedMesh, IsAMeshOfFewerTrianglesWhereTheBodyIsHollow)
{
    const TriangleMesh cup = makeRevolved(
        {{0.0, 0.0}, {0.04, 0.0}, {0.04, 0.1}, {0.036, 0.1}, {0.036, 0.004}, {0.0, 0.004}}, 200);
    const btCcdReducedMesh reduced(cup, kAccuracy);
    EXPECT_EQ(reduced.name(), std::string("mesh"));
    EXPECT_LT(reduced.triangles(), cup.triangles.size() / 10);
    EXPECT_LT(differenceOfBoxes(cup, reduced), btCcdReducedMesh::kShare * kAccuracy);
    const std::unique_ptr<btCollisionShape> one = reduced.makeShape();
    const std::unique_ptr<btCollisionShape> other = reduced.makeShape();
    EXPECT_EQ(&dynamic_cast<btCcdMeshShape&>(*one).tree(),
              &dynamic_cast<btCcdMeshShape&>(*other).tree());
}
}  // namespace
}  // namespace bullet_ccd::tests
