/// Conversions between Bullet (btScalar) and the core (double). Numbers cross nowhere else.
#ifndef BT_CCD_CONVERSIONS_H
#define BT_CCD_CONVERSIONS_H

#include "bullet_ccd/bullet/btCcdPrecision.h"

#include <Eigen/Geometry>
#include <LinearMath/btTransform.h>

#include <cmath>

inline Eigen::Vector3d btCcdToEigen(const btVector3& v)
{
    return {v.x(), v.y(), v.z()};
}

inline btVector3 btCcdToBullet(const Eigen::Vector3d& v)
{
    return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

/// The result is normalised in double precision, because a single-precision quaternion has unit
/// length to 1e-7 only.
inline Eigen::Quaterniond btCcdToEigen(const btQuaternion& q)
{
    return Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
}

inline btQuaternion btCcdToBullet(const Eigen::Quaterniond& q)
{
    return {btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())};
}

/// The rotation is made orthonormal to double precision.
inline Eigen::Isometry3d btCcdToEigen(const btTransform& X)
{
    const btMatrix3x3& basis = X.getBasis();
    Eigen::Matrix3d rotation;
    for (int row = 0; row < 3; ++row)
    {
        rotation.row(row) = btCcdToEigen(basis[row]).transpose();
    }
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
    result.translation() = btCcdToEigen(X.getOrigin());
    return result;
}

inline btTransform btCcdToBullet(const Eigen::Isometry3d& X)
{
    return btTransform(btCcdToBullet(Eigen::Quaterniond(X.linear())),
                       btCcdToBullet(Eigen::Vector3d(X.translation())));
}

/// The largest btScalar that is not above `value`, for value >= 0. A time of impact that is rounded
/// up would no longer be before the impact.
inline btScalar btCcdRoundDown(double value)
{
    btScalar rounded = btScalar(value);
    if (double(rounded) > value)
    {
        rounded = std::nextafter(rounded, btScalar(0));
    }
    return rounded;
}

#endif  // BT_CCD_CONVERSIONS_H
