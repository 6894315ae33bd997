#include "bullet_ccd/toi/articulated/body_boxes.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::AlignedBox3d;
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
}  // namespace bullet_ccd
