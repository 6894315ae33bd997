#include "bullet_ccd/toi/articulated_environment.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bullet_ccd
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Isometry3d;
using Eigen::Vector3d;

MotionState stateAt(const RigidBody& body, double t)
{
    return body.userMotion != nullptr ? body.userMotion->at(t) : body.motion.at(t);
}

AlignedBox3d widened(const AlignedBox3d& box, double by)
{
    return {box.min() - Vector3d::Constant(by), box.max() + Vector3d::Constant(by)};
}

/// Hull of boxes at a few times, widened by what a curved path can leave a chord: an eighth of its
/// acceleration times the square of the time in between.
AlignedBox3d boundsOfSamples(const RigidBody& body,
                             const OrientedBox& box,
                             double begin,
                             double end)
{
    constexpr double kWide = 0.05;  // of the size, that is not worth another sample
    constexpr double kMostSamples = 32.0;
    const AccelerationBound bound = body.userMotion != nullptr
                                        ? body.userMotion->accelerationBound()
                                        : body.motion.accelerationBound();
    const double size = box.half.norm() + box.radius;
    const double acceleration =
        bound.constant + bound.perRadius * (box.center.norm() + size) * (1.0 + 1e-6);
    const double span = end - begin;
    const double sagitta = 0.125 * acceleration * span * span;
    const double parts =
        std::clamp(std::ceil(std::sqrt(sagitta / (kWide * size + 1e-300))), 1.0, kMostSamples);
    AlignedBox3d result;
    for (int i = 0; i <= static_cast<int>(parts); ++i)
    {
        result.extend(boundsOf(stateAt(body, begin + span * (i / parts)).X_W, box));
    }
    return widened(result, sagitta / (parts * parts) * (1.0 + 1e-9));
}

/// A ball about the reference, which moves straight; for bodies that spin fast.
AlignedBox3d boundsOfBall(const RigidMotion& motion,
                          const OrientedBox& box,
                          double begin,
                          double end)
{
    const double radius =
        (box.center - motion.reference_B).norm() + box.half.norm() * (1.0 + 1e-6) + box.radius;
    const Vector3d start = motion.X_W0 * motion.reference_B;
    const Vector3d first = start + begin * motion.v_W;
    const Vector3d last = start + end * motion.v_W;
    const double slack = 1e-14 * (first.norm() + last.norm() + radius);
    return widened({first.cwiseMin(last), first.cwiseMax(last)}, radius + slack);
}

bool isFinite(const RigidBody& body)
{
    const RigidMotion& m = body.motion;
    return body.userMotion != nullptr || (m.X_W0.matrix().allFinite() && m.v_W.allFinite() &&
                                          m.w_W.allFinite() && m.reference_B.allFinite());
}
}  // namespace

OrientedBox rootBox(const SsvTree& tree)
{
    const SsvNode& node = tree.nodes()[0];
    const auto vector = [](const float(&v)[3]) { return Vector3d(v[0], v[1], v[2]); };
    OrientedBox box;
    box.center = tree.origin() + vector(node.center);
    box.axes.col(0) = vector(node.axis0);
    box.axes.col(1) = vector(node.axis1);
    box.axes.col(2) = vector(node.axis0).cross(vector(node.axis1));
    box.half = vector(node.half);
    box.radius = node.radius;
    return box;
}

AlignedBox3d boundsOver(const RigidBody& body, double begin, double end)
{
    const OrientedBox box = rootBox(*body.tree);
    const bool rests =
        body.userMotion == nullptr && body.motion.v_W.isZero(0.0) && body.motion.w_W.isZero(0.0);
    if (rests)
    {
        return boundsOf(body.motion.X_W0, box);
    }
    const AlignedBox3d bySamples = boundsOfSamples(body, box, begin, end);
    return body.userMotion != nullptr
               ? bySamples
               : bySamples.intersection(boundsOfBall(body.motion, box, begin, end));
}

void Environment::reset(std::span<const RigidBody> bodies)
{
    m_bodies.assign(bodies.begin(), bodies.end());
    m_moves.resize(bodies.size());
    m_boxes.resize(bodies.size());
    m_order.resize(bodies.size());
    m_nodes.clear();
    m_movingCount = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        const RigidBody& body = bodies[i];
        require(isFinite(body),
                "time of impact: a pose, velocity or joint position is NaN or infinite");
        const bool rests = body.userMotion == nullptr && body.motion.v_W.isZero(0.0) &&
                           body.motion.w_W.isZero(0.0);
        m_moves[i] = rests ? 0 : 1;
        m_movingCount += rests ? 0U : 1U;
        m_boxes[i] = boundsOver(body, 0.0, 1.0);
    }
    std::iota(m_order.begin(), m_order.end(), 0);
    if (!m_order.empty())
    {
        build(0, m_order.size());
    }
}

/// Appends the tree over order()[begin, end), parents before their children.
void Environment::build(std::size_t begin, std::size_t end)
{
    const std::size_t index = m_nodes.size();
    m_nodes.push_back({.first = static_cast<std::int32_t>(begin),
                       .count = static_cast<std::int32_t>(end - begin)});
    AlignedBox3d centers;
    AlignedBox3d box;
    for (std::size_t i = begin; i < end; ++i)
    {
        centers.extend(this->box(m_order[i]).center());
        box.extend(this->box(m_order[i]));
    }
    m_nodes[index].box = box;
    if (end - begin <= kLeaf)
    {
        return;
    }
    Eigen::Index axis = 0;
    centers.sizes().maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return m_order.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin),
                     at(middle),
                     at(end),
                     [&](std::int32_t a, std::int32_t b)
                     {
                         const double x = this->box(a).center()[axis];
                         const double y = this->box(b).center()[axis];
                         return x != y ? x < y : a < b;
                     });
    build(begin, middle);
    m_nodes[index].right = static_cast<std::int32_t>(m_nodes.size());
    build(middle, end);
}
}  // namespace bullet_ccd
