#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdShapeCache.h"
#include "tests/bullet/scene.h"
#include "tests/support/random.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
namespace
{
/// Bounds of all parts of a shape in its frame.
Eigen::AlignedBox3d boundsOf(const std::vector<btCcdShapePart>& parts)
{
    Eigen::AlignedBox3d box;
    for (const btCcdShapePart& part : parts)
    {
        for (const Eigen::Vector3d& vertex : part.m_tree->mesh().vertices)
        {
            box.extend(part.X_SG * vertex);
        }
    }
    return box;
}

void expectBounds(const btCollisionShape& shape, const Eigen::Vector3d& half, double exact)
{
    btCcdShapeCache cache;
    std::vector<btCcdShapePart> parts;
    ASSERT_TRUE(cache.appendParts(&shape, parts));
    const Eigen::AlignedBox3d box = boundsOf(parts);
    EXPECT_LT((box.max() - half).cwiseAbs().maxCoeff(), exact);
    EXPECT_LT((box.min() + half).cwiseAbs().maxCoeff(), exact);
    EXPECT_TRUE(isWatertight(parts.front().m_tree->mesh()));
}
}  // namespace

TEST(ShapeCache, StockShapesBecomeMeshesOfTheirSize)
{
    expectBounds(btBoxShape(vec(0.1, 0.2, 0.3)), {0.1, 0.2, 0.3}, 1e-7);
    expectBounds(btSphereShape(btScalar(0.1)), {0.1, 0.1, 0.1}, 1e-4);
    expectBounds(btCapsuleShapeX(btScalar(0.1), btScalar(0.4)), {0.3, 0.1, 0.1}, 2e-4);
    expectBounds(btCapsuleShape(btScalar(0.1), btScalar(0.4)), {0.1, 0.3, 0.1}, 2e-4);
    expectBounds(btCylinderShapeZ(vec(0.1, 0.1, 0.3)), {0.1, 0.1, 0.3}, 2e-4);
    expectBounds(btCylinderShapeX(vec(0.3, 0.1, 0.1)), {0.3, 0.1, 0.1}, 2e-4);
}

TEST(ShapeCache, HullContainsItsPointsAndNothingOutsideThem)
{
    Random random(4);
    for (int trial = 0; trial < 20; ++trial)
    {
        btConvexHullShape hull;
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < 40; ++i)
        {
            points.push_back(btCcdToEigen(btCcdToBullet(random.inBox(0.05))));
            hull.addPoint(btCcdToBullet(points.back()));
        }
        btCcdShapeCache cache;
        std::vector<btCcdShapePart> parts;
        ASSERT_TRUE(cache.appendParts(&hull, parts));
        const TriangleMesh& mesh = parts.front().m_tree->mesh();
        EXPECT_TRUE(isWatertight(mesh));
        for (const Triangle& t : mesh.triangles)
        {
            const Eigen::Vector3d& a = mesh.vertices[std::size_t(t[0])];
            const Eigen::Vector3d normal = (mesh.vertices[std::size_t(t[1])] - a)
                                               .cross(mesh.vertices[std::size_t(t[2])] - a)
                                               .normalized();
            for (const Eigen::Vector3d& point : points)
            {
                EXPECT_LT(normal.dot(point - a), 1e-5);  // 1e-4 of the size
            }
        }
    }
}

TEST(ShapeCache, CompoundsAreFlattenedWithTheirPoses)
{
    Scene scene(Kind::Stock);
    btBoxShape box(vec(0.1, 0.1, 0.1));
    const btCcdMeshShape* mesh = scene.boxMesh(vec(0.2, 0.1, 0.1));
    btCompoundShape inner;
    inner.addChildShape(poseAt(vec(1, 0, 0)), &box);
    btCompoundShape outer;
    outer.addChildShape(poseAt(vec(0, 1, 0), SIMD_HALF_PI), &inner);
    outer.addChildShape(poseAt(vec(0, 0, 5)), const_cast<btCcdMeshShape*>(mesh));
    btCcdShapeCache cache;
    std::vector<btCcdShapePart> parts;
    ASSERT_TRUE(cache.appendParts(&outer, parts));
    ASSERT_EQ(parts.size(), 2U);
    EXPECT_LT((parts[0].X_SG.translation() - Eigen::Vector3d(0, 2, 0)).norm(), 1e-6);
    EXPECT_TRUE(parts[0].m_stock);
    EXPECT_EQ(parts[1].m_tree, &mesh->tree());
    EXPECT_FALSE(parts[1].m_stock);

    // One child that is not covered, and the whole is not.
    btConeShape cone(btScalar(0.1), btScalar(0.1));
    outer.addChildShape(btTransform::getIdentity(), &cone);
    EXPECT_FALSE(cache.appendParts(&outer, parts));
    EXPECT_EQ(parts.size(), 2U);
}

TEST(ShapeCache, ConversionsAreKeptWhileUsedAndRedoneWhenTheShapeChanges)
{
    btCcdShapeCache cache;
    btBoxShape box(vec(0.1, 0.1, 0.1));
    const auto treeOf = [&]
    {
        std::vector<btCcdShapePart> parts;
        EXPECT_TRUE(cache.appendParts(&box, parts));
        return parts.front().m_tree;
    };
    cache.beginRound();
    const SsvTree* first = treeOf();
    cache.beginRound();
    EXPECT_EQ(treeOf(), first);
    box.setLocalScaling(vec(2, 1, 1));
    EXPECT_NEAR(bounds(treeOf()->mesh()).max().x(), 0.2, 1e-7);
}

TEST(ShapeCache, PlaneIsWide)
{
    btCcdShapeCache cache;
    btStaticPlaneShape plane(vec(0, 0.6, 0.8), btScalar(0.5));
    std::vector<btCcdShapePart> parts;
    ASSERT_TRUE(cache.appendParts(&plane, parts));
    for (const Eigen::Vector3d& vertex : parts.front().m_tree->mesh().vertices)
    {
        EXPECT_NEAR(vertex.dot(Eigen::Vector3d(0, 0.6, 0.8)), 0.5, 1e-4);
        EXPECT_GT(vertex.norm(), 500.0);
    }
}
}  // namespace bullet_ccd::tests
