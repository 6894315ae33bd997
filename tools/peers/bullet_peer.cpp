#include "tools/peers/peer.h"

#ifdef BULLET_CCD_PEER_BULLET

#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
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

PeerAnswer bulletConvexCast(const RigidScene& scene)
{
    btConvexHullShape a;
    btConvexHullShape b;
    fill(a, scene.meshA);
    fill(b, scene.meshB);
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
    btContinuousConvexCollision cast(&a, &b, &simplex, &depth);
    btConvexCast::CastResult result;
    const bool contact = cast.calcTimeOfImpact(toBullet(scene.motionA.X_W0),
                                               toBullet(scene.motionA.at(1.0).X_W),
                                               toBullet(scene.motionB.X_W0),
                                               toBullet(scene.motionB.at(1.0).X_W),
                                               result);
    return {.contact = contact, .time = contact ? result.m_fraction : 1.0};
}

bool hasBullet()
{
    return true;
}
}  // namespace bullet_ccd::tests

#else

namespace bullet_ccd::tests
{
PeerAnswer bulletConvexCast(const RigidScene&)
{
    return {};
}

bool hasBullet()
{
    return false;
}
}  // namespace bullet_ccd::tests

#endif
