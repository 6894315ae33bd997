#include "benchmarks/peers/fcl_peer.h"

#include <algorithm>
#include <fcl/config.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/motion/interp_motion.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/continuous_collision.h>
#include <fcl/narrowphase/detail/traversal/collision/mesh_continuous_collision_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/collision_node.h>
#include <fcl/narrowphase/distance.h>
#include <limits>

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

template <typename Model>
void build(const TriangleMesh& mesh, Model& model)
{
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
    {
        triangles.emplace_back(static_cast<std::size_t>(t[0]),
                               static_cast<std::size_t>(t[1]),
                               static_cast<std::size_t>(t[2]));
    }
    model.beginModel();
    model.addSubModel(mesh.vertices, triangles);
    model.endModel();
}
}  // namespace

std::string fclVersion()
{
    return std::string("FCL ") + FCL_VERSION;
}

FclModel::FclModel(const TriangleMesh& mesh)
{
    const auto data = std::make_shared<Data>();
    build(mesh, data->model);
    m_data = data;
}

struct FclSurface::Data
{
    fcl::BVHModel<fcl::AABB<double>> model;
};

FclSurface::FclSurface(const TriangleMesh& mesh) : m_data(std::make_shared<Data>())
{
    build(mesh, m_data->model);
}

void FclSurface::setEnd(const std::vector<Eigen::Vector3d>& end)
{
    m_data->model.beginUpdateModel();
    m_data->model.updateSubModel(end);
    m_data->model.endUpdateModel();
}

FclAnswer fclSurfaces(const FclSurface& a, const FclSurface& b)
{
    fcl::detail::MeshContinuousCollisionTraversalNode<fcl::AABB<double>> node;
    const fcl::Transform3d still = fcl::Transform3d::Identity();
    const fcl::CollisionRequest<double> all(std::numeric_limits<std::size_t>::max());
    fcl::CollisionResult<double> result;
    node.result = &result;
    fcl::detail::initialize(node, a.data().model, still, b.data().model, still, all);
    fcl::detail::collide(&node);
    return {.hit = !node.pairs.empty(), .time = node.pairs.empty() ? 1.0 : node.time_of_contact};
}

FclAnswer fclFeatures(const ElementaryPair& pair)
{
    using Cubic = fcl::detail::Intersect<double>;
    const auto& [a0, b0, c0, d0] = pair.start;
    const auto& [a1, b1, c1, d1] = pair.end;
    double time = 1.0;
    Eigen::Vector3d place;
    const bool hit = pair.kind == ElementaryKind::VertexFace
                         ? Cubic::intersect_VF(b0, c0, d0, a0, b1, c1, d1, a1, &time, &place)
                         : Cubic::intersect_EE(a0, b0, c0, d0, a1, b1, c1, d1, &time, &place);
    return {.hit = hit, .time = hit ? time : 1.0};
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
