#include "benchmarks/reference/bullet/pile.h"

#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
constexpr double kGravity = 9.81;
constexpr double kSize = 0.02;

std::vector<btCollisionShape*> pileShapes(Scene& scene, bool meshes)
{
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Eigen::Vector3d& v : octahedron().vertices)
    {
        hull->addPoint(btCcdToBullet(Eigen::Vector3d(1.3 * kSize * v)));
    }
    hull->setMargin(btScalar(5e-4));
    std::vector<btCollisionShape*> shapes = {
        scene.box(vec(kSize, 0.8 * kSize, 0.6 * kSize)),
        scene.keep(std::make_unique<btSphereShape>(btScalar(0.8 * kSize))),
        scene.keep(std::move(hull))};
    if (meshes)
    {
        shapes.push_back(scene.boxMesh(vec(kSize, 0.6 * kSize, 0.4 * kSize)));
    }
    return shapes;
}

void addBin(Scene& scene, double half, double wallHeight)
{
    btCollisionShape* floor = scene.box(vec(half, half, 0.01));
    btCollisionShape* wall = scene.box(vec(0.01, half, 0.5 * wallHeight));
    scene.body(floor, 0.0, poseAt(vec(0, 0, -0.01)));
    for (int side = 0; side < 4; ++side)
    {
        const double angle = 0.5 * std::numbers::pi * side;
        scene.body(
            wall,
            0.0,
            poseAt(vec(half * std::cos(angle), half * std::sin(angle), 0.5 * wallHeight), angle));
    }
}
}  // namespace

void addPile(
    Scene& scene, int count, double binHalf, std::uint64_t seed, const PileOptions& options)
{
    scene.world().setGravity(vec(0, 0, -kGravity));
    addBin(scene, binHalf, options.wallHeight);
    const std::vector<btCollisionShape*> shapes = pileShapes(scene, options.meshes);
    Random random(seed);
    // Layers of a grid wide enough for all orientations.
    const double spacing = kPileSpacing;
    const int side = std::max(1, int(std::lround(2.0 * (binHalf - 0.01) / spacing)));
    for (int i = 0; i < count; ++i)
    {
        const int layer = i / (side * side);
        const int row = i / side % side;
        const int column = i % side;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.linear() = random.rotation();
        pose.translation() = Eigen::Vector3d(spacing * (column - 0.5 * (side - 1)),
                                             spacing * (row - 0.5 * (side - 1)),
                                             0.05 + spacing * layer);
        btRigidBody* body =
            scene.body(shapes[std::size_t(i) % shapes.size()], 0.1, btCcdToBullet(pose));
        body->setLinearVelocity(vec(random.uniform(-1, 1), random.uniform(-1, 1), -2.0));
        body->setAngularVelocity(btCcdToBullet(random.inBox(10.0)));
        body->setRestitution(btScalar(0.3));
    }
}

PileFall fallBesidePile(Kind kind)
{
    constexpr int kSteps = 240;
    constexpr double kTime = 1.0;
    Scene scene(kind);
    addPile(scene, 48, 0.12, 7);
    btRigidBody* falling =
        scene.body(scene.boxMesh(vec(kSize, kSize, kSize)), 0.1, poseAt(vec(0.4, 0, 2.0)));
    for (int i = 0; i < kSteps; ++i)
    {
        scene.step(kTime / kSteps);
    }
    return {.way = 2.0 - double(falling->getWorldTransform().getOrigin().z()),
            .expected = 0.5 * kGravity * kTime * kTime,
            .impacts = scene.counters().m_impacts};
}
}  // namespace bullet_ccd::reference
