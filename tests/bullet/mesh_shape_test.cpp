#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/bullet/recording_drawer.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <set>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

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

TEST(MeshShape, RaysHitTheTriangleTheyPointAt)
{
    Scene scene(Kind::Stock);
    btCcdMeshShape* shape = scene.mesh(makeTorus(0.5, 0.2, 24, 12));
    btRigidBody* body = scene.body(shape, 0.0, poseAt(vec(1, 2, 0), 0.3));
    const auto cast = [&](double x)
    {
        const btVector3 from = vec(x, 2, 3);
        const btVector3 to = vec(x, 2, -3);
        btCollisionWorld::ClosestRayResultCallback hit(from, to);
        scene.world().rayTest(from, to, hit);
        return hit;
    };
    const auto onRing = cast(1.5);
    ASSERT_TRUE(onRing.hasHit());
    EXPECT_EQ(onRing.m_collisionObject, body);
    EXPECT_NEAR(double(onRing.m_hitPointWorld.z()), 0.2, 5e-3);  // a polygon of 12 sides
    EXPECT_GT(double(onRing.m_hitNormalWorld.z()), 0.9);
    EXPECT_FALSE(cast(1.0).hasHit()) << "the hole";
    EXPECT_FALSE(cast(1.75).hasHit());
    shape->setLocalScaling(vec(2, 2, 2));
    scene.world().updateSingleAabb(body);
    const auto scaled = cast(2.0);
    ASSERT_TRUE(scaled.hasHit());
    EXPECT_NEAR(double(scaled.m_hitPointWorld.z()), 0.4, 1e-2);
}

TEST(MeshShape, ConvexShapesSweptAtItStopAtIt)
{
    Scene scene(Kind::Stock);
    btRigidBody* body =
        scene.body(scene.mesh(makeTorus(0.5, 0.2, 24, 12)), 0.0, poseAt(vec(1, 2, 0)));
    const auto sweep = [&](double x, double radius)
    {
        const btSphereShape ball{btScalar(radius)};
        const btTransform from = poseAt(vec(x, 2, 3));
        const btTransform to = poseAt(vec(x, 2, -3));
        btCollisionWorld::ClosestConvexResultCallback hit(from.getOrigin(), to.getOrigin());
        scene.world().convexSweepTest(&ball, from, to, hit);
        return hit;
    };
    const auto onRing = sweep(1.5, 0.1);
    ASSERT_TRUE(onRing.hasHit());
    EXPECT_EQ(onRing.m_hitCollisionObject, body);
    // Touching at height 0.2 + 0.1; the polygon, Bullet's tolerance.
    EXPECT_NEAR(3.0 - 6.0 * double(onRing.m_closestHitFraction), 0.3, 1e-2);
    EXPECT_FALSE(sweep(1.0, 0.2).hasHit()) << "through the hole";
    EXPECT_TRUE(sweep(1.0, 0.4).hasHit()) << "too large for the hole";
    EXPECT_FALSE(sweep(2.0, 0.2).hasHit());
}

TEST(MeshShape, StockBulletDrawsItsTriangles)
{
    Scene scene(Kind::Stock);
    scene.body(scene.boxMesh(vec(0.1, 0.2, 0.3)), 0.0, poseAt(vec(1, 0, 0)));
    RecordingDrawer drawer;
    scene.world().setDebugDrawer(&drawer);
    scene.world().debugDrawWorld();
    Eigen::AlignedBox3d box;
    for (const auto& [from, to] : drawer.m_lines)
    {
        box.extend(from);
        box.extend(to);
    }
    scene.world().setDebugDrawer(nullptr);
    EXPECT_GE(drawer.m_lines.size(), 12U * 3U);
    EXPECT_LT((box.min() - Eigen::Vector3d(0.9, -0.2, -0.3)).norm(), 1e-6);
    EXPECT_LT((box.max() - Eigen::Vector3d(1.1, 0.2, 0.3)).norm(), 1e-6);
}

TEST(MeshShape, MarginIsWhatDiscreteContactsKeep)
{
    for (const double margin : {0.0005, 0.02})
    {
        Scene scene(Kind::Stock);
        btCcdMeshShape* ground = scene.boxMesh(vec(1, 1, 0.1));
        ground->setMargin(btScalar(margin));
        EXPECT_EQ(ground->getMargin(), btScalar(margin));
        scene.body(ground, 0.0, poseAt(vec(0, 0, 0)));
        scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0.1, 0.2, 0.201)));
        scene.world().performDiscreteCollisionDetection();
        ASSERT_EQ(scene.world().getDispatcher()->getNumManifolds(), 1);
        const auto& manifold = *scene.world().getDispatcher()->getManifoldByIndexInternal(0);
        // Bullet does not even look at triangles that are farther away than the margin.
        EXPECT_EQ(manifold.getNumContacts() > 0, margin > 0.001);
        for (int i = 0; i < manifold.getNumContacts(); ++i)
        {
            EXPECT_NEAR(double(manifold.getContactPoint(i).getDistance()), 0.001 - margin, 1e-5);
        }
    }
}

TEST(MeshShape, HierarchiesAreSharedUntilScaled)
{
    const auto tree = std::make_shared<const SsvTree>(buildSsvTree(makeBox({0.1, 0.2, 0.3})));
    btCcdMeshShape a(tree);
    btCcdMeshShape b(tree, btScalar(0.01));
    EXPECT_EQ(&a.tree(), tree.get());
    EXPECT_EQ(&a.tree(), &b.tree());
    EXPECT_EQ(b.getMargin(), btScalar(0.01));
    a.setLocalScaling(vec(1, 1, 3));
    EXPECT_NE(&a.tree(), tree.get());
    EXPECT_EQ(&b.tree(), tree.get());
    EXPECT_NEAR(bounds(a.tree().mesh()).max().z(), 0.9, 1e-7);
    a.setLocalScaling(vec(1, 1, 1));
    EXPECT_EQ(&a.tree(), tree.get());
}

TEST(MeshShape, NegativeScalingMirrors)
{
    TriangleMesh wedge = makeBox({0.1, 0.1, 0.1});
    wedge.vertices[0] *= 2.0;
    const auto shape = btCcdMeshShape::fromMesh(wedge);
    const double volume = massProperties(shape->tree().mesh()).volume;
    shape->setLocalScaling(vec(-1, 1, 1));
    EXPECT_NEAR(bounds(shape->tree().mesh()).max().x(), -bounds(wedge).min().x(), 1e-7);
    EXPECT_NEAR(massProperties(shape->tree().mesh()).volume, volume, 1e-9) << "inside out";
}

TEST(MeshShape, IsMadeFromBulletsMeshInterface)
{
    btTriangleMesh triangles;
    const TriangleMesh box = makeBox({0.1, 0.2, 0.3});
    for (const Triangle& t : box.triangles)
    {
        triangles.addTriangle(btCcdToBullet(box.vertices[std::size_t(t[0])]),
                              btCcdToBullet(box.vertices[std::size_t(t[1])]),
                              btCcdToBullet(box.vertices[std::size_t(t[2])]));
    }
    triangles.setScaling(vec(1, 1, 2));
    const auto shape = btCcdMeshShape::fromInterface(&triangles, btScalar(0.01));
    EXPECT_EQ(shape->getMargin(), btScalar(0.01));
    EXPECT_EQ(shape->tree().mesh().vertices.size(), 8U);
    EXPECT_TRUE(isWatertight(shape->tree().mesh()));
    EXPECT_NEAR(bounds(shape->tree().mesh()).max().z(), 0.6, 1e-7);

    // The original is not referred to.
    triangles.setScaling(vec(1, 1, 1));
    EXPECT_NEAR(bounds(shape->tree().mesh()).max().z(), 0.6, 1e-7);
}

TEST(MeshShape, WhatItCannotBeMadeOfIsSaid)
{
    const auto expectMessage = [](const std::function<void()>& call, const std::string& part)
    {
        try
        {
            call();
            FAIL() << "no exception: " << part;
        }
        catch (const std::invalid_argument& error)
        {
            EXPECT_THAT(error.what(), testing::HasSubstr(part));
        }
    };
    const auto shape = btCcdMeshShape::fromMesh(makeBox({0.1, 0.1, 0.1}));
    const double nan = std::nan("");
    // Bullet calls these, and it knows no exceptions: they say it, and nothing changes.
    const auto expectRefused = [](const std::function<void()>& call, const std::string& part)
    {
        testing::internal::CaptureStderr();
        call();
        EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr(part));
    };
    expectRefused([&] { shape->setLocalScaling(vec(1, 0, 1)); }, "factor 1 is 0");
    expectRefused([&] { shape->setLocalScaling(vec(1, 1, nan)); }, "factor 2 is nan");
    expectRefused([&] { shape->setLocalScaling(vec(INFINITY, 1, 1)); }, "factor 0 is inf");
    EXPECT_EQ(shape->getLocalScaling(), vec(1, 1, 1));
    EXPECT_NEAR(bounds(shape->tree().mesh()).max().x(), 0.1, 1e-7);
    const btScalar margin = shape->getMargin();
    expectRefused([&] { shape->setMargin(btScalar(-1)); }, "not negative");
    expectRefused([&] { shape->setMargin(btScalar(nan)); }, "finite");
    EXPECT_EQ(shape->getMargin(), margin);
    expectMessage([&] { btCcdMeshShape(shape->sharedTree(), btScalar(-1)); }, "not negative");
    expectMessage([] { btCcdMeshShape(nullptr); }, "null");
    expectMessage([] { btCcdMeshShape::fromInterface(nullptr); }, "null");
    const btTriangleMesh empty;
    expectMessage([&] { btCcdMeshShape::fromInterface(&empty); }, "no triangles");
    expectMessage([] { btCcdMeshShape::fromMesh({}); }, "no triangles");
}
}  // namespace bullet_ccd::tests
