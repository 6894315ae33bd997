#include "benchmarks/peers/fcl_peer.h"

#include <algorithm>
#include <fcl/config.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/motion/interp_motion.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/continuous_collision.h>
#include <fcl/narrowphase/distance.h>

namespace bullet_ccd::benchmarks
{
namespace
{
using Volume = fcl::OBBRSS<double>;

fcl::InterpMotion<double> fclMotion(const RigidMotion& motion)
{
    const Eigen::Isometry3d X0 = motion.X_W0;
    const Eigen::Isometry3d X1 = motion.at(1.0).X_W;
    return {X0.linear(), X0.translation(), X1.linear(), X1.translation(), motion.reference_B};
}
}  // namespace

struct FclModel::Data
{
    fcl::BVHModel<Volume> model;
};

namespace
{
FclAnswer collideContinuously(const FclBody& a,
                              const FclBody& b,
                              const fcl::ContinuousCollisionRequest<double>& request)
{
    const fcl::InterpMotion<double> motionA = fclMotion(a.motion);
    const fcl::InterpMotion<double> motionB = fclMotion(b.motion);
    motionA.integrate(0.0);
    motionB.integrate(0.0);
    fcl::ContinuousCollisionResult<double> result;
    fcl::continuousCollide<double>(
        &a.model.data().model, &motionA, &b.model.data().model, &motionB, request, result);
    return {.hit = result.is_collide, .time = result.is_collide ? result.time_of_contact : 1.0};
}
}  // namespace

std::string fclVersion()
{
    return std::string("FCL ") + FCL_VERSION;
}

FclModel::FclModel(const TriangleMesh& mesh)
{
    const auto data = std::make_shared<Data>();
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
    {
        triangles.emplace_back(static_cast<std::size_t>(t[0]),
                               static_cast<std::size_t>(t[1]),
                               static_cast<std::size_t>(t[2]));
    }
    data->model.beginModel();
    data->model.addSubModel(mesh.vertices, triangles);
    data->model.endModel();
    m_data = data;
}

FclAnswer fclNaive(const FclBody& a, const FclBody& b, int samples)
{
    const fcl::ContinuousCollisionRequest<double> request(static_cast<std::size_t>(samples),
                                                          1e-9,
                                                          fcl::CCDM_LINEAR,
                                                          fcl::GST_LIBCCD,
                                                          fcl::CCDC_NAIVE);
    return collideContinuously(a, b, request);
}

FclAnswer fclAdvancement(const FclBody& a, const FclBody& b, double timeTolerance, int iterations)
{
    const fcl::ContinuousCollisionRequest<double> request(static_cast<std::size_t>(iterations),
                                                          timeTolerance,
                                                          fcl::CCDM_LINEAR,
                                                          fcl::GST_LIBCCD,
                                                          fcl::CCDC_CONSERVATIVE_ADVANCEMENT);
    return collideContinuously(a, b, request);
}

bool fclOverlap(const FclModel& a,
                const Eigen::Isometry3d& X_WA,
                const FclModel& b,
                const Eigen::Isometry3d& X_WB)
{
    const fcl::CollisionRequest<double> request;
    fcl::CollisionResult<double> result;
    return fcl::collide<double>(&a.data().model, X_WA, &b.data().model, X_WB, request, result) > 0;
}

double fclDistance(const FclModel& a,
                   const Eigen::Isometry3d& X_WA,
                   const FclModel& b,
                   const Eigen::Isometry3d& X_WB)
{
    fcl::DistanceRequest<double> request(false);
    request.rel_err = 0.0;
    request.abs_err = 0.0;
    fcl::DistanceResult<double> result;
    const double distance =
        fcl::distance<double>(&a.data().model, X_WA, &b.data().model, X_WB, request, result);
    return std::max(0.0, distance);
}

std::optional<double> firstOverlap(double from,
                                   double end,
                                   const std::function<bool(double)>& overlaps)
{
    double low = from;
    double step = 1e-10;
    while (true)
    {
        const double next = std::min(end, from + step);
        if (overlaps(next))
        {
            double high = next;
            while (high - low > 1e-12)
            {
                const double middle = 0.5 * (low + high);
                (overlaps(middle) ? high : low) = middle;
            }
            return high;
        }
        if (next >= end)
        {
            return std::nullopt;
        }
        low = next;
        step *= 2.0;
    }
}
}  // namespace bullet_ccd::benchmarks
