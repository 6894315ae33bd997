#include "benchmarks/peers/bullet_peer.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <BulletSoftBody/btSoftBodyInternals.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <array>
#include <limits>

namespace bullet_ccd::benchmarks
{
struct BulletHull::Data
{
    btConvexHullShape shape;
};

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
                data->shape.addPoint(btCcdToBullet(v), false);
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
        const bool hit = query.calcTimeOfImpact(btCcdToBullet(motionA.X_W0),
                                                btCcdToBullet(motionA.at(1.0).X_W),
                                                btCcdToBullet(motionB.X_W0),
                                                btCcdToBullet(motionB.at(1.0).X_W),
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
    input.m_transformA = btCcdToBullet(X_WA);
    input.m_transformB = btCcdToBullet(X_WB);
    btPointCollector closest;
    detector.getClosestPoints(input, closest, nullptr);
    return closest.m_hasResult ? closest.m_distance : std::numeric_limits<double>::infinity();
}

BulletAnswer bulletVertexFace(const ElementaryPair& pair)
{
    std::array<btSoftBody::Node, 4> nodes;
    for (std::size_t k = 0; k < 4; ++k)
    {
        nodes[k].m_x = btCcdToBullet(pair.start[k]);
        nodes[k].m_v = btCcdToBullet(pair.end[k] - pair.start[k]);
    }
    btSoftBody::Face face;
    std::ranges::transform(
        nodes.begin() + 1, nodes.end(), face.m_n, [](btSoftBody::Node& node) { return &node; });
    const auto meets = [&](double until)
    {
        btVector3 weights;
        return continuousCollisionDetection(&face, nodes.data(), until, 1e-6, weights);
    };
    if (!meets(1.0))
    {
        return {};
    }
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 20; ++i)
    {
        const double middle = 0.5 * (low + high);
        (meets(middle) ? high : low) = middle;
    }
    return {.hit = true, .time = high};
}
}  // namespace bullet_ccd::benchmarks
