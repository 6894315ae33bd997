#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "tests/bullet/scene.h"
#include "tests/support/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace bullet_ccd::tests
{
namespace
{
constexpr double kExact = kDouble ? 1e-12 : 1e-5;

struct Collector : btTriangleCallback
{
    std::multiset<int> m_triangles;
    Eigen::AlignedBox3d m_bounds;

    void processTriangle(btVector3* corners, int part, int index) override
    {
        EXPECT_EQ(part, 0);
        m_triangles.insert(index);
        for (int k = 0; k < 3; ++k)
        {
            m_bounds.extend(btCcdToEigen(corners[k]));
        }
    }
};
}  // namespace

TEST(MeshShape, ReportsEveryTriangleThatMeetsTheBox)
{
    Scene scene(Kind::Stock);
    TriangleMesh torus = makeTorus(0.05, 0.02, 24, 12);
    transformMesh(torus, Eigen::Affine3d(Eigen::Translation3d(0.3, -0.1, 0.2)));
    const btCcdMeshShape* shape = scene.mesh(torus);
    Random random(5);
    std::size_t reported = 0;
    for (int trial = 0; trial < 50; ++trial)
    {
        const Eigen::Vector3d center = Eigen::Vector3d(0.3, -0.1, 0.2) + random.inBox(0.07);
        const Eigen::Vector3d half = Eigen::Vector3d::Constant(random.uniform(0.002, 0.04));
        Collector collector;
        shape->processAllTriangles(&collector,
                                   btCcdToBullet(Eigen::Vector3d(center - half)),
                                   btCcdToBullet(Eigen::Vector3d(center + half)));
        const Eigen::AlignedBox3d box(center - half, center + half);
        for (int i = 0; i < int(torus.triangles.size()); ++i)
        {
            // A corner inside: certainly met.
            const Triangle& triangle = torus.triangles[std::size_t(i)];
            const bool inside =
                std::any_of(triangle.begin(),
                            triangle.end(),
                            [&](std::int32_t vertex)
                            { return box.contains(torus.vertices[std::size_t(vertex)]); });
            EXPECT_LE(collector.m_triangles.count(i), 1U);
            EXPECT_TRUE(!inside || collector.m_triangles.count(i) == 1U);
        }
        reported += collector.m_triangles.size();
    }
    EXPECT_GT(reported, 50U);
    EXPECT_LT(reported, 50U * torus.triangles.size() / 2U);  // the tree did cull

    Collector all;
    const btVector3 large(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    shape->processAllTriangles(&all, -large, large);
    EXPECT_EQ(all.m_triangles.size(), torus.triangles.size());
    EXPECT_LT((all.m_bounds.min() - bounds(torus).min()).norm(), kExact);
}

TEST(MeshShape, BoundsInertiaAndScalingAreThoseOfTheSolid)
{
    Scene scene(Kind::Stock);
    btCcdMeshShape* shape = scene.boxMesh(vec(0.1, 0.2, 0.3));
    EXPECT_EQ(shape->getShapeType(), int(FAST_CONCAVE_MESH_PROXYTYPE));
    EXPECT_TRUE(shape->isConcave());
    shape->setMargin(btScalar(0.01));
    btVector3 low;
    btVector3 high;
    shape->getAabb(poseAt(vec(1, 2, 3), SIMD_HALF_PI), low, high);
    EXPECT_LT(double((high - vec(1.21, 2.11, 3.31)).length()), 1e-6);
    EXPECT_LT(double((low - vec(0.79, 1.89, 2.69)).length()), 1e-6);

    btVector3 inertia;
    shape->calculateLocalInertia(btScalar(3), inertia);
    // m / 3 (b^2 + c^2) of the half edges.
    EXPECT_LT(double((inertia - vec(0.13, 0.10, 0.05)).length()), 1e-6);

    shape->setLocalScaling(vec(2, 1, 0.5));
    shape->getAabb(btTransform::getIdentity(), low, high);
    EXPECT_LT(double((high - vec(0.21, 0.21, 0.16)).length()), 1e-6);
    shape->setLocalScaling(vec(1, 1, 1));
    EXPECT_NEAR(bounds(shape->tree().mesh()).max().x(), 0.1, 1e-7);
}

TEST(MeshShape, RaysHitIt)
{
    Scene scene(Kind::Stock);
    btRigidBody* body = scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 0.0, poseAt(vec(1, 0, 0)));
    const btVector3 from = vec(0, 0.01, 0.02);
    const btVector3 to = vec(3, 0.01, 0.02);
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    scene.world().rayTest(from, to, hit);
    ASSERT_TRUE(hit.hasHit());
    EXPECT_EQ(hit.m_collisionObject, body);
    EXPECT_NEAR(double(hit.m_hitPointWorld.x()), 0.9, 1e-6);
}
}  // namespace bullet_ccd::tests
