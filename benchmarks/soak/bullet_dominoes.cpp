// A row of tiles two millimetres thick, hit by a small block at 50 m/s. In one step of 1/60 s the
// block would travel 0.8 m, farther than the row is long. Everything is a triangle mesh, which
// stock Bullet lets pass through each other; here no two of them ever intersect.
#include "benchmarks/reference/audit/world_audit.h"
#include "bullet_ccd/examples/example_support.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <cstdio>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::examples;
using bullet_ccd::reference::AuditMesh;
using bullet_ccd::reference::AuditResult;
using bullet_ccd::reference::WorldAudit;

constexpr int kTiles = 12;
constexpr double kTimeStep = 1.0 / 60.0;  // [s]
constexpr double kSpeed = 50.0;           // of the block [m/s]
const Eigen::Vector3d kHalfTile(0.001, 0.010, 0.020);
const Eigen::Vector3d kHalfBlock(0.006, 0.008, 0.006);
const Eigen::Vector3d kHalfGround(3.0, 3.0, 0.05);  // top at z = 0

/// Adds a box of triangles, resting in the world and watched by the audit.
btRigidBody* addBox(World& world,
                    WorldAudit& audit,
                    const Eigen::Vector3d& half,
                    double mass,
                    const btTransform& pose)
{
    btRigidBody* body = world.add(meshShape(makeBox(half)), mass, pose);
    audit.add(body, std::make_shared<const AuditMesh>(makeBox(half)));
    return body;
}
}  // namespace

int main()
{
    World world(Engine::Ccd);
    world->setGravity(btVector3(0, 0, btScalar(-9.81)));
    // Half the thickness of a tile: what passes through one is seen in it.
    WorldAudit audit(*world, {.longestMove = 0.5 * kHalfTile.x(), .mostSamples = 4000});
    world.ccd().setCcdImpactListener(&audit);

    addBox(world, audit, kHalfGround, 0.0, poseAt(0.0, 0.0, -kHalfGround.z()));
    const double gap = 2.0 * btCcdMeshShape::kDefaultMargin;
    std::vector<btRigidBody*> tiles;
    for (int i = 0; i < kTiles; ++i)
    {
        tiles.push_back(
            addBox(world, audit, kHalfTile, 0.004, poseAt(0.015 * i, 0.0, kHalfTile.z() + gap)));
    }
    btRigidBody* block = addBox(world, audit, kHalfBlock, 0.006, poseAt(-0.1, 0.0, 0.03));
    block->setLinearVelocity(btVector3(btScalar(kSpeed), 0, 0));

    AuditResult seen = audit.start();
    for (int step = 0; step < 120; ++step)
    {
        seen.add(audit.step(kTimeStep));
    }

    const btCcdCounters& counters = world.ccd().getCcdCounters();
    std::printf("%lld impacts, %lld poses looked at, %lld pairs of bodies near each other\n",
                static_cast<long long>(counters.m_impacts),
                static_cast<long long>(seen.poses),
                static_cast<long long>(seen.pairs));
    int standing = 0;
    for (const btRigidBody* tile : tiles)
    {
        const bool upright = tile->getWorldTransform().getBasis()[2].z() > btScalar(0.9);
        const bool inPlace = tile->getWorldTransform().getOrigin().z() > 0.9 * kHalfTile.z();
        standing += upright && inPlace ? 1 : 0;
    }
    if (!seen.clean())
    {
        std::printf("bodies %d and %d are %.2e m inside each other at %.4f s, (%.4f, %.4f, %.4f)\n",
                    seen.bodyA,
                    seen.bodyB,
                    seen.worst.depth,
                    seen.time,
                    seen.worst.point_W.x(),
                    seen.worst.point_W.y(),
                    seen.worst.point_W.z());
    }
    check(counters.m_impacts >= 1, "the block hits");
    check(seen.clean(), "no two bodies intersect, at no time");
    check(standing == 0, "no tile stands any more");
    return exitCode();
}
