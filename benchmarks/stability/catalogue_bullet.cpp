#include "benchmarks/stability/catalogue_peer.h"

#ifdef BULLET_CCD_PEER_BULLET

#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>

namespace bullet_ccd::tests
{
namespace
{
btTransform toBullet(const Eigen::Isometry3d& X)
{
    const Eigen::Quaterniond q(X.linear());
    const Eigen::Vector3d p = X.translation();
    return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), btVector3(p.x(), p.y(), p.z()));
}

void fill(btConvexHullShape& shape, const TriangleMesh& mesh)
{
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t index : t)
        {
            const Eigen::Vector3d& v = mesh.vertices[static_cast<std::size_t>(index)];
            shape.addPoint(btVector3(v.x(), v.y(), v.z()), false);
        }
    }
    shape.recalcLocalAabb();
    shape.setMargin(0.0);
}
}  // namespace

PeerAnswer bulletCast(const RigidCase& tested, BulletCast cast)
{
    const RigidScene& scene = tested.scene;
    btConvexHullShape a;
    btConvexHullShape b;
    fill(a, scene.meshA);
    fill(b, scene.meshB);
    btVoronoiSimplexSolver simplex;
    btConvexCast::CastResult result;
    const auto run = [&](btConvexCast& query)
    {
        return query.calcTimeOfImpact(toBullet(scene.motionA.X_W0),
                                      toBullet(scene.motionA.at(1.0).X_W),
                                      toBullet(scene.motionB.X_W0),
                                      toBullet(scene.motionB.at(1.0).X_W),
                                      result)
                   ? contactAt(result.m_fraction)
                   : PeerAnswer{};
    };
    switch (cast)
    {
        case BulletCast::Continuous:
        {
            btGjkEpaPenetrationDepthSolver depth;
            btContinuousConvexCollision query(&a, &b, &simplex, &depth);
            return run(query);
        }
        case BulletCast::Gjk:
        {
            btGjkConvexCast query(&a, &b, &simplex);
            return run(query);
        }
        case BulletCast::Subsimplex:
        {
            btSubsimplexConvexCast query(&a, &b, &simplex);
            return run(query);
        }
    }
    return {};
}

PeerAnswer bulletSampling(const RigidCase& tested, int steps)
{
    const RigidScene& scene = tested.scene;
    btConvexHullShape a;
    btConvexHullShape b;
    fill(a, scene.meshA);
    fill(b, scene.meshB);
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
    for (int i = 0; i <= steps; ++i)
    {
        const double t = static_cast<double>(i) / steps;
        btGjkPairDetector detector(&a, &b, &simplex, &depth);
        btGjkPairDetector::ClosestPointInput input;
        input.m_transformA = toBullet(scene.motionA.at(t).X_W);
        input.m_transformB = toBullet(scene.motionB.at(t).X_W);
        btPointCollector closest;
        detector.getClosestPoints(input, closest, nullptr);
        if (closest.m_hasResult && closest.m_distance <= tested.answer.finest())
        {
            return contactAt(t);
        }
    }
    return {};
}

bool hasBullet()
{
    return true;
}
}  // namespace bullet_ccd::tests

#else

namespace bullet_ccd::tests
{
PeerAnswer bulletCast(const RigidCase&, BulletCast)
{
    return {};
}

PeerAnswer bulletSampling(const RigidCase&, int)
{
    return {};
}

bool hasBullet()
{
    return false;
}
}  // namespace bullet_ccd::tests

#endif
