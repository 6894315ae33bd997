#include "benchmarks/peers/bullet_peer.h"

#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>

namespace bullet_ccd::benchmarks
{
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

BulletHull::BulletHull(const TriangleMesh& mesh, double margin) : m_data(std::make_unique<Data>())
{
    for (const Eigen::Vector3d& v : mesh.vertices)
    {
        m_data->shape.addPoint(btVector3(v.x(), v.y(), v.z()), false);
    }
    m_data->shape.recalcLocalAabb();
    m_data->shape.setMargin(margin);
}

BulletHull::~BulletHull() = default;
BulletHull::BulletHull(BulletHull&&) noexcept = default;
BulletHull& BulletHull::operator=(BulletHull&&) noexcept = default;

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
}  // namespace bullet_ccd::benchmarks
