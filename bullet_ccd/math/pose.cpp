#include "bullet_ccd/math/pose.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace bullet_ccd
{
namespace
{
constexpr double kDrift = 1e-4;
constexpr double kOpposite = 1e-8;  // [rad] from opposite, where the sum of the two is all rounding
}  // namespace

bool isPose(const Eigen::Isometry3d& X)
{
    const auto x = X.linear().col(0);
    const auto y = X.linear().col(1);
    const auto z = X.linear().col(2);
    // NaN fails every comparison. Without branches: every query asks this of every body.
    const auto isSmall = [](double lack) { return static_cast<int>(std::abs(lack) <= kDrift); };
    const Eigen::Vector3d lack = x.cross(y) - z;
    const int isRotation = isSmall(x.squaredNorm() - 1.0) & isSmall(y.squaredNorm() - 1.0) &
                           isSmall(x.dot(y)) & isSmall(lack.x()) & isSmall(lack.y()) &
                           isSmall(lack.z());
    // Zero times NaN and infinity is NaN.
    return isRotation != 0 && (0.0 * X.translation()).sum() == 0.0;
}

void failPose(const std::string& where, const Eigen::Isometry3d& X)
{
    if (!X.matrix().allFinite())
    {
        throw std::invalid_argument(where + ": a number of the pose is NaN or infinite");
    }
    const Eigen::Matrix3d R = X.linear();
    char text[200];
    std::snprintf(text,
                  sizeof(text),
                  ": the pose is no rotation and translation: axes of length %.7g, %.7g, %.7g, "
                  "determinant %.7g",
                  R.col(0).norm(),
                  R.col(1).norm(),
                  R.col(2).norm(),
                  R.determinant());
    throw std::invalid_argument(
        where + text +
        ": scale or mirror the mesh instead, and normalise rotations that have drifted");
}

Eigen::Quaterniond rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
    const Eigen::Vector3d a = from.normalized();
    // Halfway between the two: half of the rotation takes `a` there.
    Eigen::Vector3d middle = a + to.normalized();
    if (middle.norm() < kOpposite)
    {
        Eigen::Index least = 0;
        a.cwiseAbs().minCoeff(&least);
        middle = a.cross(Eigen::Vector3d::Unit(least));
    }
    middle.normalize();
    const Eigen::Vector3d axis = a.cross(middle);
    return {a.dot(middle), axis.x(), axis.y(), axis.z()};
}
}  // namespace bullet_ccd
