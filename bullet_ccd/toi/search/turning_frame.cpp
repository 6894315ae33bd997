#include "bullet_ccd/toi/search/turning_frame.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kUp = 1.0 + 1e-12;
/// A turn in the rest of the step beyond which nothing is gained [rad].
constexpr double kFarthestTurn = 1.0;
/// Of axes that count as parallel, as in AccelerationPlane.
constexpr double kDeviation = 1e-12;

Vector3d vector(const double (&v)[3])
{
    return Map<const Vector3d>(v);
}

Matrix3d rotationOf(const RelativeMotion& m)
{
    return Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
}

void copy(const Vector3d& from, double (&to)[3])
{
    std::copy_n(from.data(), 3, to);
}
}  // namespace

std::optional<RelativeMotion> seenFromB(const RelativeMotion& motion,
                                        const TurningBody& b,
                                        double radius,
                                        double rest)
{
    const double spin = std::sqrt(b.perRadius) * kUp;
    if (!(spin > 0.0) || !(spin * rest <= kFarthestTurn))
    {
        return std::nullopt;
    }
    const Vector3d wB = vector(motion.wB);
    const Vector3d place = rotationOf(motion) * vector(motion.armA) + vector(motion.p);
    const Vector3d w = vector(motion.wA) - wB;
    const Vector3d velocity =
        vector(motion.velocity) - wB.cross(vector(motion.p) + vector(motion.armB));
    // Of the points of A, relative to B, at this time: how fast and how far from B's reference.
    const double speed = velocity.norm() + w.norm() * (radius + vector(motion.armA).norm());
    const double distance = (place + b.arm).norm() + radius;
    const double own =
        motion.constant + motion.perRadiusA * (radius + vector(motion.radiusArmA).norm());
    // d|u|/dt <= |x''| + |b''| + |wB| |u|. A bound that it does not reach by itself holds.
    const double growth = std::exp(spin * rest);
    const double fastest = 2.0 * growth * (speed + (own + b.perRadius * distance) * rest) + 1e-290;
    const double farthest = distance + fastest * rest;
    if (!(growth * (speed + (own + b.perRadius * farthest) * rest) < fastest))
    {
        return std::nullopt;
    }
    RelativeMotion seen = motion;
    copy(velocity, seen.velocity);
    copy(w, seen.wA);
    copy(Vector3d::Zero(), seen.wB);
    seen.spinA = w.norm();
    seen.spinB = 0.0;
    seen.perRadiusB = 0.0;
    // What is added is in the plane, too: B turns about its normal.
    seen.acrossPlane += kDeviation * fastest * spin;
    seen.constant = (motion.constant + b.perRadius * farthest + 2.0 * spin * fastest) * kUp;
    return seen;
}

RelativeMotion swapped(const RelativeMotion& motion)
{
    const Matrix3d toA = rotationOf(motion).transpose();
    const Vector3d wB = vector(motion.wB);
    RelativeMotion other = motion;
    for (int i = 0; i < 9; ++i)
    {
        other.R[i] = toA(i / 3, i % 3);
    }
    copy(-(toA * vector(motion.p)), other.p);
    copy(toA * (wB.cross(vector(motion.armB)) - vector(motion.velocity)), other.velocity);
    copy(toA * wB, other.wA);
    copy(toA * vector(motion.wA), other.wB);
    copy(toA * vector(motion.plane), other.plane);
    copy(Vector3d::Zero(), other.armB);
    copy(vector(motion.armB), other.radiusArmA);
    other.spinA = motion.spinB;
    other.spinB = motion.spinA;
    other.perRadiusA = motion.perRadiusB;
    other.perRadiusB = motion.perRadiusA;
    return other;
}
}  // namespace bullet_ccd
