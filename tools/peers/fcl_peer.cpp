#include "tools/peers/peer.h"

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

PeerAnswer collide(const RigidScene& scene, fcl::CCDSolverType solver)
{
    const auto a = modelOf(scene.meshA);
    const auto b = modelOf(scene.meshB);
    fcl::InterpMotion<double> motionA = motionOf(scene.motionA);
    fcl::InterpMotion<double> motionB = motionOf(scene.motionB);
    motionA.integrate(0.0);
    motionB.integrate(0.0);
    const fcl::ContinuousCollisionRequest<double> request(
        1001, 1e-6, fcl::CCDM_LINEAR, fcl::GST_LIBCCD, solver);
    fcl::ContinuousCollisionResult<double> result;
    fcl::continuousCollide<double>(a.get(), &motionA, b.get(), &motionB, request, result);
    return {.contact = result.is_collide, .time = result.is_collide ? result.time_of_contact : 1.0};
}
}  // namespace

PeerAnswer fclSampling(const RigidScene& scene)
{
    return collide(scene, fcl::CCDC_NAIVE);
}

PeerAnswer fclAdvancement(const RigidScene& scene)
{
    return collide(scene, fcl::CCDC_CONSERVATIVE_ADVANCEMENT);
}

bool hasFcl()
{
    return true;
}
}  // namespace bullet_ccd::tests

#else

namespace bullet_ccd::tests
{
PeerAnswer fclSampling(const RigidScene&)
{
    return {};
}

PeerAnswer fclAdvancement(const RigidScene&)
{
    return {};
}

bool hasFcl()
{
    return false;
}
}  // namespace bullet_ccd::tests

#endif
