#include "bullet_ccd/motion/rigid_motion.h"

#include <cmath>

namespace bullet_ccd
{
MotionState RigidMotion::at(double t) const
{
    MotionState state{.X_W = X_W0, .v_W = v_W, .w_W = w_W};
    state.X_W.translation() += t * v_W;
    const double rate = w_W.norm();
    if (rate > 0.0 && t == 0.0)
    {
        state.v_W -= w_W.cross(X_W0.linear() * reference_B);
    }
    else if (rate > 0.0)
    {
        const double angle = t * rate;
        const Eigen::Vector3d axis = w_W / rate;
        state.X_W.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * X_W0.linear();
        // The reference is `arm` from the origin. (turn - 1) arm, written so that a far reference
        // (a screw of little rotation has one) does not cancel.
        const Eigen::Vector3d arm = X_W0.linear() * reference_B;
        const double half = std::sin(0.5 * angle);
        const Eigen::Vector3d across = axis.cross(arm);
        const Eigen::Vector3d turned =
            std::sin(angle) * across + 2.0 * half * half * axis.cross(across);
        state.X_W.translation() -= turned;
        state.v_W -= w_W.cross(arm + turned);
    }
    return state;
}

AccelerationBound RigidMotion::accelerationBound() const
{
    // Centripetal: |w x (w x r)| <= |w|^2 |r|, r counted from the reference.
    const double perRadius = w_W.squaredNorm() * (1.0 + 1e-12);
    return {.constant = perRadius * reference_B.norm(), .perRadius = perRadius};
}

RigidMotion restAt(const Eigen::Isometry3d& X_W)
{
    return {.X_W0 = X_W};
}

RigidMotion partOf(const RigidMotion& motion, double begin, double end)
{
    RigidMotion part = motion;
    part.X_W0 = motion.at(begin).X_W;
    part.v_W = (end - begin) * motion.v_W;
    part.w_W = (end - begin) * motion.w_W;
    return part;
}

namespace
{
/// Flips the axis of a half turn, whose sign the poses leave open, to a fixed choice.
Eigen::Vector3d canonicalHalfTurn(const Eigen::Vector3d& axis)
{
    for (int k = 0; k < 3; ++k)
    {
        if (std::abs(axis[k]) > 1e-9)
        {
            return axis[k] > 0.0 ? axis : Eigen::Vector3d(-axis);
        }
    }
    return axis;
}
}  // namespace

RigidMotion motionBetween(const Eigen::Isometry3d& X_W0, const Eigen::Isometry3d& X_W1)
{
    // q = cos(angle/2) + sin(angle/2) axis. atan2 keeps all digits at both ends, acos would not.
    Eigen::Quaterniond q(X_W1.linear() * X_W0.linear().transpose());
    if (q.w() < 0.0)
    {
        q.coeffs() = -q.coeffs();
    }
    const double sine = q.vec().norm();
    const double angle = 2.0 * std::atan2(sine, q.w());
    RigidMotion motion{.X_W0 = X_W0, .v_W = X_W1.translation() - X_W0.translation()};
    // Equal orientations differ by the rounding of their matrices; that is not a rotation.
    if (sine > 1e-15)
    {
        const Eigen::Vector3d axis = q.vec() / sine;
        const bool isHalfTurn = q.w() < 1e-12;
        motion.w_W = angle * (isHalfTurn ? canonicalHalfTurn(axis) : axis);
    }
    return motion;
}

RigidMotion screwBetween(const Eigen::Isometry3d& X_W0, const Eigen::Isometry3d& X_W1)
{
    RigidMotion motion = motionBetween(X_W0, X_W1);
    const double angle = motion.w_W.norm();
    if (angle < 1e-9)
    {
        return motion;
    }
    // The axis passes through c = (x0 + x1 + cot(angle/2) u x (x1 - x0)) / 2 (Chasles).
    const Eigen::Vector3d axis = motion.w_W / angle;
    const Eigen::Vector3d shift = motion.v_W;
    const Eigen::Vector3d point_W =
        0.5 * (X_W0.translation() + X_W1.translation() + axis.cross(shift) / std::tan(0.5 * angle));
    motion.reference_B = X_W0.inverse() * point_W;
    motion.v_W = axis.dot(shift) * axis;
    return motion;
}
}  // namespace bullet_ccd
