/// Two volumes of two hierarchies at one relative pose, and the directions that may separate them.
///
/// For boxes these are the 15 classical axes: the face normals of both and the cross products of
/// their edges. Along any direction n, |n| = 1, the gap n.D - extent(A) - extent(B) is a lower
/// bound of the distance of the volumes; so is its maximum over the axes.
#pragma once

#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
/// A node's volume with its axes as double-precision vectors, in the frame it was placed in.
struct PlacedSsv
{
    Eigen::Vector3d center;
    Eigen::Matrix3d axes;
    Eigen::Vector3d half;
    double radius;
    double coreRadius;

    /// Circumscribed radius.
    [[nodiscard]] double size() const { return coreRadius + radius; }
};

/// The node's volume in the frame of its tree.
inline PlacedSsv place(const SsvNode& node)
{
    PlacedSsv volume;
    volume.center = Eigen::Map<const Eigen::Vector3f>(node.center).cast<double>();
    volume.axes.col(0) = Eigen::Map<const Eigen::Vector3f>(node.axis0).cast<double>();
    volume.axes.col(1) = Eigen::Map<const Eigen::Vector3f>(node.axis1).cast<double>();
    volume.axes.col(2) = volume.axes.col(0).cross(volume.axes.col(1));
    volume.half = Eigen::Map<const Eigen::Vector3f>(node.half).cast<double>();
    volume.radius = static_cast<double>(node.radius);
    volume.coreRadius = static_cast<double>(node.coreRadius);
    return volume;
}

/// The node's volume mapped by a rotation R and a translation p.
inline PlacedSsv place(const SsvNode& node, const Eigen::Matrix3d& R, const Eigen::Vector3d& p)
{
    PlacedSsv volume = place(node);
    volume.center = R * volume.center + p;
    volume.axes = R * volume.axes;
    return volume;
}

/// Calls visit(gap, projection) for every separating axis n, oriented from A to B, where
/// projection(x_A, x_B) is n.x for a vector x given in the axes of both (x_A = axesA^T x, x_B =
/// axesB^T x). Stops early when visit returns true; returns whether it did.
///
/// The formulas take the axes for orthonormal; they are so to 2e-7, divided by |n| >= 0.1 for a
/// cross product before it is normalised, and 4e-6 of the sizes involved is subtracted from every
/// gap for it.
template <class Visit>
inline bool forEachSeparatingAxis(const PlacedSsv& a, const PlacedSsv& b, Visit&& visit)
{
    const Eigen::Vector3d D = b.center - a.center;
    const Eigen::Vector3d T = a.axes.transpose() * D;
    const Eigen::Vector3d S = b.axes.transpose() * D;
    const Eigen::Matrix3d C = a.axes.transpose() * b.axes;
    const Eigen::Matrix3d absC = C.cwiseAbs();
    const double slack = a.radius + b.radius + 4e-6 * (a.size() + b.size() + D.norm());

    for (int i = 0; i < 3; ++i)
    {
        const double sign = T[i] < 0.0 ? -1.0 : 1.0;
        const double gap = sign * T[i] - a.half[i] - absC.row(i).dot(b.half) - slack;
        if (visit(gap,
                  [&](const Eigen::Vector3d& xA, const Eigen::Vector3d&) { return sign * xA[i]; }))
        {
            return true;
        }
    }
    for (int j = 0; j < 3; ++j)
    {
        const double sign = S[j] < 0.0 ? -1.0 : 1.0;
        const double gap = sign * S[j] - b.half[j] - absC.col(j).dot(a.half) - slack;
        if (visit(gap,
                  [&](const Eigen::Vector3d&, const Eigen::Vector3d& xB) { return sign * xB[j]; }))
        {
            return true;
        }
    }
    for (int i = 0; i < 3; ++i)
    {
        const int i1 = (i + 1) % 3;
        const int i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j)
        {
            // n = a_i x b_j; |n|^2 = 1 - C_ij^2. Almost parallel edges give no new direction.
            const double lengthSquared = 1.0 - C(i, j) * C(i, j);
            if (lengthSquared < 1e-2)
            {
                continue;
            }
            const double inverse = 1.0 / std::sqrt(lengthSquared);
            const int j1 = (j + 1) % 3;
            const int j2 = (j + 2) % 3;
            const double along = T[i2] * C(i1, j) - T[i1] * C(i2, j);
            const double sign = along < 0.0 ? -inverse : inverse;
            const double extent = a.half[i1] * absC(i2, j) + a.half[i2] * absC(i1, j) +
                                  b.half[j1] * absC(i, j2) + b.half[j2] * absC(i, j1);
            const double gap = sign * along - inverse * extent - slack;
            if (visit(gap,
                      [&](const Eigen::Vector3d& xA, const Eigen::Vector3d&)
                      { return sign * (xA[i2] * C(i1, j) - xA[i1] * C(i2, j)); }))
            {
                return true;
            }
        }
    }
    return false;
}

/// Lower bound of the distance of two volumes; negative if no axis separates them. Looks along the
/// line of centers, too: for volumes far apart for their size no face or edge gives a better bound.
/// The search for a larger one ends at the first beyond `enough`.
inline double separation(const PlacedSsv& a,
                         const PlacedSsv& b,
                         double enough = std::numeric_limits<double>::infinity())
{
    double best = -1.0;
    const Eigen::Vector3d D = b.center - a.center;
    const double distance = D.norm();
    const double sizes = a.size() + b.size();
    if (distance > sizes)
    {
        const double extent = (a.axes.transpose() * D).cwiseAbs().dot(a.half) +
                              (b.axes.transpose() * D).cwiseAbs().dot(b.half);
        best = distance - extent / distance - a.radius - b.radius - 4e-6 * (sizes + distance);
    }
    if (best > enough)
    {
        return best;
    }
    forEachSeparatingAxis(a,
                          b,
                          [&](double gap, const auto&)
                          {
                              best = std::max(best, gap);
                              return best > enough;
                          });
    return best;
}
}  // namespace bullet_ccd
