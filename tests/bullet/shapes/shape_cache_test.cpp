#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeOutline.h"
#include "bullet_ccd/convex/support.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <malloc.h>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kExact = kDouble ? 1e-12 : 1e-6;

const btCcdShapePart& onlyPart(btCcdShapeCache& cache, const btCollisionShape& shape)
{
    const btCcdShapeModel* model = cache.find(&shape);
    if (model == nullptr || model->m_parts.size() != 1U)
    {
        throw std::logic_error("not covered by one part");
    }
    return model->m_parts.front();
}

/// Bounds of all parts of a model in the shape's frame, radii included.
Eigen::AlignedBox3d boundsOf(const btCcdShapeModel& model)
{
    Eigen::AlignedBox3d box;
    for (const btCcdShapePart& part : model.m_parts)
    {
        for (const Eigen::Vector3d& vertex : part.m_tree->mesh().vertices)
        {
            const Eigen::Vector3d point = part.X_SG * vertex;
            box.extend(Eigen::Vector3d(point.array() - part.m_radius));
            box.extend(Eigen::Vector3d(point.array() + part.m_radius));
        }
    }
    return box;
}

void expectBounds(const btCollisionShape& shape, const Eigen::Vector3d& half, double exact)
{
    btCcdShapeCache cache;
    const btCcdShapeModel* model = cache.find(&shape);
    ASSERT_NE(model, nullptr) << shape.getName();
    const Eigen::AlignedBox3d box = boundsOf(*model);
    EXPECT_LT((box.max() - half).cwiseAbs().maxCoeff(), exact) << shape.getName();
    EXPECT_LT((box.min() + half).cwiseAbs().maxCoeff(), exact) << shape.getName();
    EXPECT_FALSE(model->m_hasMesh);
    EXPECT_EQ(model->m_parts.front().m_margin, 0.0);
}

/// Largest n.x over the part, by its vertices and radius.
double support(const TriangleMesh& mesh, double radius, const Eigen::Vector3d& direction)
{
    double largest = -1e30;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        largest = std::max(largest, direction.dot(vertex));
    }
    return largest + radius;
}

/// The same over an exact shape.
double support(const btCcdExactShape& exact, const Eigen::Vector3d& direction)
{
    const Eigen::Vector3d inE = exact.X_GE.linear().transpose() * direction;
    return direction.dot(exact.X_GE.translation()) + supportHeight(exact.m_shape, inE) +
           exact.m_shape.radius;
}

/// Fills in shapes of all convex kinds, of random sizes.
void forRandomConvexShapes(Random& random, const std::function<void(const btConvexShape&)>& visit)
{
    const auto size = [&] { return btScalar(random.uniform(0.02, 0.3)); };
    const auto point = [&] { return btCcdToBullet(random.inBox(0.2)); };
    visit(btBoxShape(btVector3(size(), size(), size())));
    visit(btSphereShape(size()));
    visit(btCapsuleShape(size(), size()));
    visit(btCapsuleShapeX(size(), size()));
    visit(btCapsuleShapeZ(size(), size()));
    btConvexHullShape hull;
    btConvexPointCloudShape cloud;
    btAlignedObjectArray<btVector3> points;
    for (int i = random.integer(4, 30); i > 0; --i)
    {
        points.push_back(point());
        hull.addPoint(points[points.size() - 1]);
    }
    hull.setMargin(size() * btScalar(0.2));
    visit(hull);
    hull.setLocalScaling(vec(0.5, 2, 1));
    visit(hull);
    cloud.setPoints(&points[0], points.size());
    visit(cloud);
    visit(btTriangleShape(point(), point(), point()));
    visit(btBU_Simplex1to4(point(), point(), point(), point()));
    const btScalar radii[] = {btScalar(0.1), btScalar(0.1), btScalar(0.1)};
    visit(btMultiSphereShape(&points[0], radii, 1));
    visit(btMultiSphereShape(&points[0], radii, 2));
    visit(btMultiSphereShape(&points[0], radii, 3));
}
}  // namespace

TEST(ShapeCache, ConvexShapesHaveTheSupportFunctionOfTheirModel)
{
    Random random(41);
    int shapes = 0;
    for (int trial = 0; trial < 20; ++trial)
    {
        forRandomConvexShapes(random,
                              [&](const btConvexShape& shape)
                              {
                                  btCcdShapeCache cache;
                                  const btCcdShapePart& part = onlyPart(cache, shape);
                                  for (int i = 0; i < 50; ++i)
                                  {
                                      const Eigen::Vector3d n = random.direction();
                                      const btVector3 vertex =
                                          shape.localGetSupportingVertex(btCcdToBullet(n));
                                      EXPECT_NEAR(support(part.m_tree->mesh(), part.m_radius, n),
                                                  n.dot(btCcdToEigen(vertex)),
                                                  kDouble ? 1e-12 : 1e-6)
                                          << shape.getName();
                                  }
                                  ++shapes;
                              });
    }
    EXPECT_EQ(shapes, 20 * 13);
}

TEST(ShapeCache, RoundSolidsAreInscribedPolyhedra)
{
    expectBounds(btCylinderShape(vec(0.1, 0.3, 0.1)), {0.1, 0.3, 0.1}, 2e-4);
    expectBounds(btCylinderShapeZ(vec(0.1, 0.1, 0.3)), {0.1, 0.1, 0.3}, 2e-4);
    expectBounds(btCylinderShapeX(vec(0.3, 0.1, 0.1)), {0.3, 0.1, 0.1}, 2e-4);
    const double margin = CONVEX_DISTANCE_MARGIN;
    const double r = 0.1 + margin;
    expectBounds(btConeShape(btScalar(0.1), btScalar(0.4)), {r, 0.2 + margin, r}, 2e-4);
    expectBounds(btConeShapeX(btScalar(0.1), btScalar(0.4)), {0.2 + margin, r, r}, 2e-4);
    expectBounds(btConeShapeZ(btScalar(0.1), btScalar(0.4)), {r, r, 0.2 + margin}, 2e-4);

    // The tip of a cone is up.
    btCcdShapeCache cache;
    btConeShape cone(btScalar(0.1), btScalar(0.4));
    const btCcdShapePart& part = onlyPart(cache, cone);
    EXPECT_EQ(part.m_radius, double(cone.getMargin()));
    int up = 0;
    for (const Eigen::Vector3d& vertex : part.m_tree->mesh().vertices)
    {
        up += vertex.y() > 0.0 ? 1 : 0;
    }
    EXPECT_EQ(up, 1);
}

TEST(ShapeCache, SpheresAndCapsulesAreNotTessellated)
{
    btCcdShapeCache cache;
    btSphereShape sphere(btScalar(0.25));
    EXPECT_EQ(onlyPart(cache, sphere).m_tree->mesh().triangles.size(), 1U);
    EXPECT_EQ(onlyPart(cache, sphere).m_radius, 0.25);
    btCapsuleShape capsule(btScalar(0.25), btScalar(0.5));
    EXPECT_EQ(onlyPart(cache, capsule).m_tree->mesh().triangles.size(), 1U);
    EXPECT_EQ(onlyPart(cache, capsule).m_radius, 0.25);
    EXPECT_EQ(bounds(onlyPart(cache, capsule).m_tree->mesh()).max().y(), 0.25);
}

TEST(ShapeCache, EveryPointOfACoreIsAsDeepInsideAsStated)
{
    Random random(42);
    int solid = 0;
    const auto check = [&](const btConvexShape& shape)
    {
        btCcdShapeCache cache;
        const btCcdShapePart& part = onlyPart(cache, shape);
        if (part.m_core == nullptr)
        {
            EXPECT_EQ(part.m_depth, 0.0);
            return;
        }
        ++solid;
        EXPECT_GT(part.m_depth, 0.0);
        // A ball of that depth about every core point lies inside: no direction in which the core
        // reaches farther than the shape less the depth.
        double slack = 1e30;
        for (int i = 0; i < 200; ++i)
        {
            const Eigen::Vector3d n = random.direction();
            const double outer = support(part.m_tree->mesh(), part.m_radius, n);
            const double inner = support(part.m_core->mesh(), part.m_coreRadius, n);
            ASSERT_GE(outer - inner, part.m_depth) << shape.getName();
            slack = std::min(slack, outer - inner - part.m_depth);
            if (part.m_exact && part.m_exactCore)
            {
                const double exact = support(*part.m_exact, n);
                ASSERT_GE(exact - support(*part.m_exactCore, n), part.m_depth) << shape.getName();
                ASSERT_NEAR(exact, outer, 1e-3 * std::abs(outer) + 1e-9) << shape.getName();
                ASSERT_GE(exact, outer - 1e-9) << shape.getName();
            }
        }
        // Not needlessly shallow: about half the size.
        EXPECT_LT(slack, part.m_depth + 0.1) << shape.getName();
    };
    for (int trial = 0; trial < 20; ++trial)
    {
        forRandomConvexShapes(random, check);
    }
    check(btCylinderShape(vec(0.1, 0.3, 0.1)));
    check(btConeShape(btScalar(0.1), btScalar(0.4)));
    EXPECT_GT(solid, 200);

    btCcdShapeCache cache;
    btBoxShape box(vec(0.5, 0.25, 1));
    EXPECT_NEAR(onlyPart(cache, box).m_depth, 0.125, 1e-4);
    // Inset, not scaled: a long box has its core up to near its ends.
    EXPECT_NEAR(bounds(onlyPart(cache, box).m_core->mesh()).max().z(), 0.875, 1e-3);
    btSphereShape sphere(btScalar(0.5));
    EXPECT_NEAR(onlyPart(cache, sphere).m_depth, 0.25, 1e-8);
    EXPECT_EQ(onlyPart(cache, sphere).m_coreRadius, 0.25);
    // Flat and without margin: no inside.
    btTriangleShape triangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0));
    triangle.setMargin(0);
    EXPECT_EQ(onlyPart(cache, triangle).m_core, nullptr);
    EXPECT_TRUE(cache.find(&triangle)->m_hasMesh);
}

TEST(ShapeCache, ReachContainsTheShapeAboutItsOrigin)
{
    btCcdShapeCache cache;
    btSphereShape sphere(btScalar(0.25));
    EXPECT_NEAR(cache.find(&sphere)->m_reach, 0.25, kExact);
    btCompoundShape compound;
    compound.addChildShape(poseAt(vec(3, 4, 0)), &sphere);
    EXPECT_NEAR(cache.find(&compound)->m_reach, 5.25, kExact);
    btTriangleMesh triangles;
    triangles.addTriangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 2, 0));
    btBvhTriangleMeshShape mesh(&triangles, true);
    mesh.setMargin(btScalar(0.125));
    EXPECT_NEAR(cache.find(&mesh)->m_reach, 2.125, kExact);
    EXPECT_EQ(onlyPart(cache, mesh).m_margin, 0.125);
}

TEST(ShapeCache, SimpleOutlinesAreThoseOfTheModels)
{
    Random random(43);
    int simple = 0;
    const auto check = [&](const btCollisionShape& shape, double slack)
    {
        const auto outline = btCcdSimpleOutline(shape);
        if (!outline)
        {
            return;
        }
        btCcdShapeCache cache;
        const btCcdShapeModel* model = cache.find(&shape);
        ASSERT_NE(model, nullptr) << shape.getName();
        EXPECT_GE(outline->m_reach, model->m_reach * (1.0 - 1e-12)) << shape.getName();
        EXPECT_LE(outline->m_reach, model->m_reach * (slack + 1e-9)) << shape.getName();
        EXPECT_NEAR(outline->m_reserve, model->m_reserve, 1e-12) << shape.getName();
        EXPECT_NEAR(outline->m_depth, model->m_depth, 1e-12) << shape.getName();
        EXPECT_EQ(outline->m_ownMargin, model->m_ownMargin) << shape.getName();
        EXPECT_EQ(outline->m_hasMesh, model->m_hasMesh) << shape.getName();
        ++simple;
    };
    for (int trial = 0; trial < 20; ++trial)
    {
        forRandomConvexShapes(random, [&](const btConvexShape& shape) { check(shape, 1.0); });
    }
    EXPECT_EQ(simple, 20 * 5);
    btTriangleMesh triangles;
    triangles.addTriangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 2, 0));
    btBvhTriangleMeshShape mesh(&triangles, true);
    mesh.setMargin(btScalar(0.125));
    check(mesh, 1.5);
    check(btScaledBvhTriangleMeshShape(&mesh, vec(2, 1, 1)), 1.6);
    check(btStaticPlaneShape(vec(0, 0, 1), btScalar(0.5)), 1.0);
    btSphereShape sphere(btScalar(0.25));
    btBoxShape box(vec(0.5, 0.25, 1));
    btCompoundShape compound;
    compound.addChildShape(poseAt(vec(3, 4, 0)), &sphere);
    compound.addChildShape(poseAt(vec(0, 0, 1)), &box);
    check(compound, 1.2);
    compound.addChildShape(poseAt(vec(0, 0, 1)), &mesh);
    check(compound, 1.2);
    EXPECT_EQ(simple, 20 * 5 + 5);
    // Only the model can tell whether these are covered.
    EXPECT_FALSE(btCcdSimpleOutline(btSphereShape(btScalar(0))));
    EXPECT_FALSE(btCcdSimpleOutline(btEmptyShape()));
    EXPECT_FALSE(btCcdSimpleOutline(btCompoundShape()));
}

TEST(ShapeCache, MeshesOfEveryKindKeepTheirTrianglesAndMargin)
{
    const TriangleMesh torus = makeTorus(0.05, 0.02, 12, 8);
    btTriangleMesh triangles;
    for (const Triangle& t : torus.triangles)
    {
        triangles.addTriangle(btCcdToBullet(torus.vertices[std::size_t(t[0])]),
                              btCcdToBullet(torus.vertices[std::size_t(t[1])]),
                              btCcdToBullet(torus.vertices[std::size_t(t[2])]));
    }
    btBvhTriangleMeshShape plain(&triangles, true);
    btScaledBvhTriangleMeshShape scaled(&plain, vec(2, 1, 0.5));
    btGImpactMeshShape gimpact(&triangles);
    gimpact.setLocalScaling(vec(2, 1, 0.5));
    btCcdShapeCache cache;
    const auto expect = [&](btConcaveShape& shape, const Eigen::Vector3d& half)
    {
        shape.setMargin(btScalar(0.001));
        const btCcdShapePart& part = onlyPart(cache, shape);
        EXPECT_EQ(part.m_tree->mesh().triangles.size(), torus.triangles.size());
        EXPECT_LT((bounds(part.m_tree->mesh()).max() - half).norm(), 1e-8);
        EXPECT_TRUE(isWatertight(part.m_tree->mesh()));
        EXPECT_EQ(part.m_margin, double(btScalar(0.001)));
        EXPECT_EQ(part.m_core, nullptr);
        EXPECT_TRUE(cache.find(&shape)->m_hasMesh);
        EXPECT_EQ(cache.find(&shape)->m_depth, 0.0);
    };
    const Eigen::Vector3d half = bounds(torus).max();
    expect(plain, half);
    expect(scaled, half.cwiseProduct(Eigen::Vector3d(2, 1, 0.5)));
    // GImpact's own boxes are not even made yet.
    const btCcdShapePart& part = onlyPart(cache, gimpact);
    EXPECT_EQ(part.m_tree->mesh().triangles.size(), torus.triangles.size());
    EXPECT_EQ(part.m_margin, double(gimpact.getMargin()));
    EXPECT_EQ(onlyPart(cache, *gimpact.getMeshPart(0)).m_tree, part.m_tree);
    EXPECT_TRUE(part.m_tree == onlyPart(cache, scaled).m_tree) << "one mesh, two hierarchies";

    btConvexTriangleMeshShape hull(&triangles);
    EXPECT_TRUE(isWatertight(onlyPart(cache, hull).m_tree->mesh()));
    EXPECT_LT(onlyPart(cache, hull).m_tree->mesh().triangles.size(), torus.triangles.size());

    btScalar heights[12] = {0, 1, 0, 2, 0, 0, 0, 0, 0, 0, 0, 3};
    btHeightfieldTerrainShape terrain(
        4, 3, heights, btScalar(1), btScalar(0), btScalar(4), 2, PHY_FLOAT, false);
    const TriangleMesh& ground = onlyPart(cache, terrain).m_tree->mesh();
    EXPECT_EQ(ground.triangles.size(), 2U * 3U * 2U);
    EXPECT_EQ(bounds(ground).sizes(), Eigen::Vector3d(3, 2, 3));
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
    const btCcdShapeModel* model = cache.find(&outer);
    ASSERT_NE(model, nullptr);
    ASSERT_EQ(model->m_parts.size(), 2U);
    EXPECT_LT((model->m_parts[0].X_SG.translation() - Eigen::Vector3d(0, 2, 0)).norm(), 1e-6);
    EXPECT_NE(model->m_parts[0].m_core, nullptr);
    EXPECT_EQ(model->m_parts[1].m_tree.get(), &mesh->tree());
    EXPECT_EQ(model->m_parts[1].m_margin, double(mesh->getMargin()));
    EXPECT_TRUE(model->m_hasMesh);
    EXPECT_EQ(model->m_depth, 0.0);

    // What changes below is seen above.
    inner.updateChildTransform(0, poseAt(vec(2, 0, 0)));
    EXPECT_LT((cache.find(&outer)->m_parts[0].X_SG.translation() - Eigen::Vector3d(0, 3, 0)).norm(),
              1e-6);
    box.setLocalScaling(vec(2, 2, 2));
    EXPECT_NEAR(bounds(cache.find(&outer)->m_parts[0].m_tree->mesh()).max().x(), 0.2, 1e-7);

    // What is not covered takes nothing from the others, and is named; what is empty is missed by
    // nobody.
    const std::size_t before = cache.find(&outer)->m_parts.size();
    btEmptyShape empty;
    inner.addChildShape(btTransform::getIdentity(), &empty);
    ASSERT_NE(cache.find(&outer), nullptr);
    EXPECT_EQ(cache.find(&outer)->m_parts.size(), before);
    EXPECT_EQ(cache.find(&outer)->m_uncovered, nullptr);
    const btVector3 centers[] = {vec(0, 0, 0), vec(1, 0, 0)};
    const btScalar radii[] = {btScalar(0.1), btScalar(0.2)};
    btMultiSphereShape pear(centers, radii, 2);
    inner.addChildShape(btTransform::getIdentity(), &pear);
    EXPECT_EQ(cache.find(&outer)->m_parts.size(), before);
    EXPECT_EQ(cache.find(&outer)->m_uncovered, &pear);
    inner.removeChildShape(&pear);
    EXPECT_EQ(cache.find(&outer)->m_uncovered, nullptr);
    btCompoundShape none;
    EXPECT_TRUE(btCcdIsEmpty(none));
    EXPECT_FALSE(btCcdIsEmpty(inner));
}

TEST(ShapeCache, WhatHasNoExactModelIsNotCovered)
{
    btCcdShapeCache cache;
    const btVector3 centers[] = {vec(0, 0, 0), vec(1, 0, 0)};
    const btScalar radii[] = {btScalar(0.1), btScalar(0.2)};
    btMultiSphereShape pear(centers, radii, 2);
    EXPECT_EQ(cache.find(&pear), nullptr);
    btMultiSphereShape egg(centers, radii, 1);
    EXPECT_NE(cache.find(&egg), nullptr);
    egg.setLocalScaling(vec(1, 2, 1));
    EXPECT_EQ(cache.find(&egg), nullptr);
    btConvexHullShape nothing;
    EXPECT_EQ(cache.find(&nothing), nullptr);
    btConvexHullShape lost;
    lost.addPoint(vec(0, 0, 0));
    lost.addPoint(vec(std::nan(""), 0, 0));
    EXPECT_EQ(cache.find(&lost), nullptr);
    btCompoundShape hollow;
    EXPECT_EQ(cache.find(&hollow), nullptr);
}

TEST(ShapeCache, ModelsAreKeptWhileUsedAndRedoneWhenTheShapeChanges)
{
    btCcdShapeCache cache;
    const auto expectChange = [&](btCollisionShape& shape, const std::function<void()>& change)
    {
        const std::shared_ptr<const SsvTree> first = onlyPart(cache, shape).m_tree;
        const double radius = onlyPart(cache, shape).m_radius;
        cache.endRound();
        EXPECT_EQ(onlyPart(cache, shape).m_tree, first);
        change();
        EXPECT_TRUE(onlyPart(cache, shape).m_tree != first ||
                    onlyPart(cache, shape).m_radius != radius)
            << shape.getName();
    };
    btBoxShape box(vec(0.1, 0.1, 0.1));
    expectChange(box, [&] { box.setLocalScaling(vec(2, 1, 1)); });
    btSphereShape sphere(btScalar(0.1));
    expectChange(sphere, [&] { sphere.setUnscaledRadius(btScalar(0.2)); });
    btCapsuleShape capsule(btScalar(0.1), btScalar(0.2));
    expectChange(capsule, [&] { capsule.setLocalScaling(vec(2, 2, 2)); });
    btCylinderShape cylinder(vec(0.1, 0.2, 0.1));
    expectChange(cylinder, [&] { cylinder.setLocalScaling(vec(1, 2, 1)); });
    btConeShape cone(btScalar(0.1), btScalar(0.2));
    expectChange(cone, [&] { cone.setMargin(btScalar(0.01)); });
    btConvexHullShape hull;
    hull.addPoint(vec(0, 0, 0));
    hull.addPoint(vec(1, 0, 0));
    hull.addPoint(vec(0, 1, 0));
    hull.addPoint(vec(0, 0, 1));
    expectChange(hull, [&] { hull.addPoint(vec(0.5, 0.5, 0.5)); });
    expectChange(hull, [&] { hull.setMargin(btScalar(0.01)); });
    btTriangleShape triangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0));
    expectChange(triangle, [&] { triangle.m_vertices1[1] = vec(1, 0, 0.5); });
    btTriangleMesh triangles;
    triangles.addTriangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0));
    btGImpactMeshShape gimpact(&triangles);
    expectChange(gimpact, [&] { gimpact.setLocalScaling(vec(1, 2, 1)); });
    btBvhTriangleMeshShape mesh(&triangles, true);
    expectChange(mesh, [&] { mesh.setLocalScaling(vec(1, 3, 1)); });
}

TEST(ShapeCache, EqualShapesShareTheirHierarchiesEvenWhenMadeAtDifferentTimes)
{
    btCcdShapeCache cache;
    btBoxShape a(vec(0.1, 0.1, 0.1));
    btBoxShape b(vec(0.1, 0.1, 0.1));
    btBoxShape c(vec(0.1, 0.1, 0.2));
    EXPECT_EQ(onlyPart(cache, a).m_tree, onlyPart(cache, b).m_tree);
    EXPECT_NE(onlyPart(cache, a).m_tree, onlyPart(cache, c).m_tree);
}

TEST(ShapeCache, AHullThatAnotherWorldHadIsNotConvertedAgain)
{
    const auto hull = [](double scale, double margin, double corner)
    {
        auto shape = std::make_unique<btConvexHullShape>();
        for (const Eigen::Vector3d& point : makeTorus(0.04, 0.01, 24, 12).vertices)
        {
            shape->addPoint(btCcdToBullet(point));
        }
        shape->addPoint(vec(0, 0, corner));
        shape->setLocalScaling(vec(scale, scale, scale));
        shape->setMargin(btScalar(margin));
        return shape;
    };
    const auto treeOf = [&](double scale, double margin, double corner)
    {
        btCcdShapeCache cache;
        return onlyPart(cache, *hull(scale, margin, corner)).m_core;
    };
    const auto first = treeOf(1.0, 0.001, 0.03);
    EXPECT_EQ(treeOf(1.0, 0.001, 0.03), first);
    EXPECT_NE(treeOf(2.0, 0.001, 0.03), first);
    EXPECT_NE(treeOf(1.0, 0.001, 0.031), first);
    btCcdShapeCache cache;
    EXPECT_EQ(onlyPart(cache, *hull(1.0, 0.002, 0.03)).m_radius, double(btScalar(0.002)));
}

TEST(ShapeCache, UnusedModelsAreDroppedAndForgottenOnesMadeAnew)
{
    btCcdShapeCache cache;
    btBoxShape box(vec(0.1, 0.1, 0.1));
    std::weak_ptr<const SsvTree> tree = onlyPart(cache, box).m_tree;
    for (int i = 0; i < 999; ++i)
    {
        cache.endRound();
    }
    EXPECT_FALSE(tree.expired());
    for (int i = 0; i < 2000; ++i)
    {
        cache.endRound();
    }
    EXPECT_TRUE(tree.expired());

    btTriangleMesh triangles;
    triangles.addTriangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0));
    triangles.addTriangle(vec(0, 0, 0), vec(1, 0, 0), vec(0.5, 0.5, 0));
    btBvhTriangleMeshShape mesh(&triangles, true);
    btCompoundShape compound;
    compound.addChildShape(btTransform::getIdentity(), &mesh);
    const auto last = [&]
    { return cache.find(&compound)->m_parts.front().m_tree->mesh().vertices.back(); };
    const Eigen::Vector3d before = last();
    unsigned char* vertices = nullptr;
    unsigned char* indices = nullptr;
    int count = 0;
    int stride = 0;
    int faces = 0;
    int indexStride = 0;
    PHY_ScalarType type = PHY_FLOAT;
    PHY_ScalarType indexType = PHY_INTEGER;
    triangles.getLockedVertexIndexBase(
        &vertices, count, type, stride, &indices, indexStride, faces, indexType);
    reinterpret_cast<btScalar*>(vertices + (count - 1) * stride)[0] = btScalar(0.25);
    EXPECT_EQ(last(), before);
    cache.forget(&compound);
    EXPECT_NE(last(), before);
}

TEST(ShapeCache, HierarchiesHoldAtMost200BytesPerTriangle)
{
    for (const int level : {5, 7})
    {
        TriangleMesh mesh = makeSphere(1.0, level);
        const auto count = double(mesh.triangles.size());
        const auto held = []
        {
            const struct mallinfo2 all = mallinfo2();
            return double(all.uordblks) + double(all.hblkhd);
        };
        const double before = held();
        const SsvTree tree = buildSsvTree(std::move(mesh));
        // What the mesh itself holds is in both.
        EXPECT_LT((held() - before) / count, 200.0) << count << " triangles";
    }
}

TEST(ShapeCache, DistancesFromAPlaneAreExactHoweverFarOut)
{
    Random random(43);
    btCcdShapeCache cache;
    const SsvTree ball = buildSsvTree(makeSphere(0.02, 2));
    for (int trial = 0; trial < 100; ++trial)
    {
        const btVector3 normal =
            trial == 0 ? vec(0, 0, -1) : btCcdToBullet(random.direction()).normalized();
        btStaticPlaneShape plane(normal, btScalar(random.uniform(-1.0, 1.0)));
        const btCcdShapePart& part = onlyPart(cache, plane);
        EXPECT_TRUE(part.m_isPlane);
        EXPECT_EQ(part.m_margin, 0.0);
        EXPECT_GT(cache.find(&plane)->m_reach, 1e5);
        // A ball above a point up to 100 km from the plane's origin.
        const Eigen::Vector3d n = btCcdToEigen(plane.getPlaneNormal()).normalized();
        const double far = random.logUniform(1e-3, 1e5);
        const Eigen::Vector3d side = n.cross(random.direction()).normalized() * far;
        const double height = random.uniform(0.021, 0.1);
        Eigen::Isometry3d X_SB = Eigen::Isometry3d::Identity();
        X_SB.translation() = n * (double(plane.getPlaneConstant()) + height) + side;
        const Eigen::Isometry3d X_SG = btCcdMeshPose(part, X_SB.translation());
        const double distance =
            treeDistance(ball, *part.m_tree, X_SG.inverse() * X_SB, 1.0).distance;
        EXPECT_NEAR(distance, height - support(ball.mesh(), 0.0, -n), far < 1e3 ? 1e-12 : 1e-9);
    }
    // Every other mesh stays where it is.
    btBoxShape box(vec(1, 1, 1));
    EXPECT_TRUE(btCcdMeshPose(onlyPart(cache, box), {3, 4, 5}).isApprox(onlyPart(cache, box).X_SG));
}
TEST(ShapeCache, KeepsNothingOfSmallHullsThatAreReplaced)
{
    Random random(7);
    btCcdShapeCache cache;
    std::size_t before = 0;
    for (int i = 0; i < 1200; ++i)
    {
        btConvexHullShape hull;
        for (int k = 0; k < 12; ++k)
        {
            hull.addPoint(btCcdToBullet(Eigen::Vector3d(0.1 * random.direction())));
        }
        ASSERT_NE(cache.find(&hull), nullptr);
        cache.forget(&hull);
        cache.endRound();
        before = i == 200 ? mallinfo2().uordblks : before;
    }
    // It was 10 kB of each.
    EXPECT_LT(double(mallinfo2().uordblks) - double(before), 2e5);
}
}  // namespace bullet_ccd::tests
