#include "benchmarks/peers/bullet_peer.h"

#include <limits>
#include <stdexcept>

#ifdef BULLET_CCD_PEER_BULLET
#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>
#endif

namespace bullet_ccd::benchmarks
{
#ifdef BULLET_CCD_PEER_BULLET
namespace
{
btTransform transformOf(const Eigen::Isometry3d& X)
{
    const Eigen::Matrix3d R = X.linear();
    const Eigen::Vector3d p = X.translation();
    const btMatrix3x3 basis(
        R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2));
    return btTransform(basis, btVector3(p.x(), p.y(), p.z()));
}
}  // namespace

struct BulletHull::Data
{
    btConvexHullShape shape;
};

bool isBulletPresent()
{
    return true;
}

BulletHull::BulletHull(const TriangleMesh& mesh, double margin)
{
    const auto data = std::make_shared<Data>();
    std::vector<bool> isAdded(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t corner : t)
        {
            const auto i = static_cast<std::size_t>(corner);
            const Eigen::Vector3d& v = mesh.vertices[i];
            if (!isAdded[i])
            {
                data->shape.addPoint(btVector3(v.x(), v.y(), v.z()), false);
                isAdded[i] = true;
            }
        }
    }
    data->shape.recalcLocalAabb();
    data->shape.setMargin(margin);
    m_data = data;
}

BulletAnswer bulletCast(BulletCast cast,
                        const BulletHull& a,
                        const RigidMotion& motionA,
                        const BulletHull& b,
                        const RigidMotion& motionB)
{
    const btConvexShape* shapeA = &a.data().shape;
    const btConvexShape* shapeB = &b.data().shape;
    btVoronoiSimplexSolver simplex;
    btConvexCast::CastResult result;
    const auto run = [&](btConvexCast& query) -> BulletAnswer
    {
        const bool hit = query.calcTimeOfImpact(transformOf(motionA.X_W0),
                                                transformOf(motionA.at(1.0).X_W),
                                                transformOf(motionB.X_W0),
                                                transformOf(motionB.at(1.0).X_W),
                                                result);
        return {.hit = hit, .time = hit ? result.m_fraction : 1.0};
    };
    switch (cast)
    {
        case BulletCast::Continuous:
        {
            btGjkEpaPenetrationDepthSolver penetration;
            btContinuousConvexCollision query(shapeA, shapeB, &simplex, &penetration);
            return run(query);
        }
        case BulletCast::Gjk:
        {
            btGjkConvexCast query(shapeA, shapeB, &simplex);
            return run(query);
        }
        case BulletCast::Subsimplex:
        {
            btSubsimplexConvexCast query(shapeA, shapeB, &simplex);
            return run(query);
        }
    }
    return {};
}

double bulletDistance(const BulletHull& a,
                      const Eigen::Isometry3d& X_WA,
                      const BulletHull& b,
                      const Eigen::Isometry3d& X_WB)
{
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver penetration;
    btGjkPairDetector detector(&a.data().shape, &b.data().shape, &simplex, &penetration);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = transformOf(X_WA);
    input.m_transformB = transformOf(X_WB);
    btPointCollector closest;
    detector.getClosestPoints(input, closest, nullptr);
    return closest.m_hasResult ? closest.m_distance : std::numeric_limits<double>::infinity();
}

#else

// Without a hull there is nothing to ask: only the constructor can be reached.
struct BulletHull::Data
{
};

bool isBulletPresent()
{
    return false;
}

BulletHull::BulletHull(const TriangleMesh& /*mesh*/, double /*margin*/)
{
    throw std::logic_error(
        "Bullet is not part of this build: configure with "
        "BULLET_CCD_BULLET_PRECISION=both or double");
}

BulletAnswer bulletCast(BulletCast /*cast*/,
                        const BulletHull& /*a*/,
                        const RigidMotion& /*motionA*/,
                        const BulletHull& /*b*/,
                        const RigidMotion& /*motionB*/)
{
    return {};
}

double bulletDistance(const BulletHull& /*a*/,
                      const Eigen::Isometry3d& /*X_WA*/,
                      const BulletHull& /*b*/,
                      const Eigen::Isometry3d& /*X_WB*/)
{
    return 0.0;
}
#endif
}  // namespace bullet_ccd::benchmarks
