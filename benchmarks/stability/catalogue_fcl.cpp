#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/stability/catalogue_peer.h"

#ifdef BULLET_CCD_PEER_FCL

#include <fcl/fcl.h>
#include <memory>
#include <vector>

namespace bullet_ccd::tests
{
namespace
{
using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

std::shared_ptr<Model> modelOf(const TriangleMesh& mesh)
{
    std::vector<fcl::Triangle> triangles;
    for (const Triangle& t : mesh.triangles)
    {
        triangles.emplace_back(static_cast<std::size_t>(t[0]),
                               static_cast<std::size_t>(t[1]),
                               static_cast<std::size_t>(t[2]));
    }
    auto model = std::make_shared<Model>();
    model->beginModel();
    model->addSubModel(mesh.vertices, triangles);
    model->endModel();
    return model;
}

/// The one constructor of InterpMotion that sets velocities and the reference point.
fcl::InterpMotion<double> motionOf(const RigidMotion& motion)
{
    const Eigen::Isometry3d end = motion.at(1.0).X_W;
    const Eigen::Matrix3d R0 = motion.X_W0.linear();
    const Eigen::Matrix3d R1 = end.linear();
    const Eigen::Vector3d x0 = motion.X_W0.translation();
    const Eigen::Vector3d x1 = end.translation();
    return {R0, x0, R1, x1, motion.reference_B};
}

PeerAnswer collide(const RigidScene& scene, fcl::CCDSolverType solver, int steps)
{
    const auto a = modelOf(scene.meshA);
    const auto b = modelOf(scene.meshB);
    fcl::InterpMotion<double> motionA = motionOf(scene.motionA);
    fcl::InterpMotion<double> motionB = motionOf(scene.motionB);
    motionA.integrate(0.0);
    motionB.integrate(0.0);
    const fcl::ContinuousCollisionRequest<double> request(
        static_cast<std::size_t>(steps) + 1, 1e-6, fcl::CCDM_LINEAR, fcl::GST_LIBCCD, solver);
    fcl::ContinuousCollisionResult<double> result;
    fcl::continuousCollide<double>(a.get(), &motionA, b.get(), &motionB, request, result);
    return result.is_collide ? contactAt(result.time_of_contact) : PeerAnswer{};
}
}  // namespace

PeerAnswer fclSampling(const RigidCase& tested, int steps)
{
    return collide(tested.scene, fcl::CCDC_NAIVE, steps);
}

PeerAnswer fclAdvancement(const RigidCase& tested)
{
    // The number of steps is that of its iterations.
    return collide(tested.scene, fcl::CCDC_CONSERVATIVE_ADVANCEMENT, 1000);
}

PeerAnswer fclSampling(const ArticulatedCase& tested, int steps)
{
    std::vector<std::shared_ptr<Model>> links;
    for (const TriangleMesh& mesh : tested.linkMeshes)
    {
        links.push_back(mesh.triangles.empty() ? nullptr : modelOf(mesh));
    }
    std::vector<std::shared_ptr<Model>> obstacles;
    for (const TriangleMesh& mesh : tested.obstacles)
    {
        obstacles.push_back(modelOf(mesh));
    }
    const auto poseAt = [&](std::size_t link, double t)
    { return oracleLinkPose(tested.tree, tested.motion, static_cast<std::int32_t>(link), t); };
    const std::vector<MovingPair> pairs = movingPairs(tested);
    const fcl::CollisionRequest<double> request;
    for (int i = 0; i <= steps; ++i)
    {
        const double t = static_cast<double>(i) / steps;
        for (const MovingPair& pair : pairs)
        {
            const Model& other = *(pair.isObstacle ? obstacles : links)[pair.other];
            const Eigen::Isometry3d X_WO =
                pair.isObstacle ? Eigen::Isometry3d::Identity() : poseAt(pair.other, t);
            fcl::CollisionResult<double> result;
            if (fcl::collide<double>(
                    links[pair.link].get(), poseAt(pair.link, t), &other, X_WO, request, result) >
                0)
            {
                return contactAt(t);
            }
        }
    }
    return {};
}

bool hasFcl()
{
    return true;
}
}  // namespace bullet_ccd::tests

#else

namespace bullet_ccd::tests
{
PeerAnswer fclSampling(const RigidCase&, int)
{
    return {};
}

PeerAnswer fclAdvancement(const RigidCase&)
{
    return {};
}

PeerAnswer fclSampling(const ArticulatedCase&, int)
{
    return {};
}

bool hasFcl()
{
    return false;
}
}  // namespace bullet_ccd::tests

#endif
