/// A triangle as the search for contacts sees it. Internal to contact_search.cpp.
#pragma once

#include "bullet_ccd/contact/contact_surface.h"
#include "bullet_ccd/distance/triangle_distance.h"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bullet_ccd
{
/// Sine of the angle by which a direction may be off the cone of a feature: 0.1 rad.
inline constexpr double kLenient = 0.0998;
inline constexpr double kExact = 1e-6;
/// Half a right angle.
inline constexpr double kWide = 0.7;

/// A triangle of either body in the frame F, the tree's of B.
struct Face
{
    const ContactSurface* surface = nullptr;
    const Eigen::Matrix3d* R_FG = nullptr;  ///< rotation of the body's tree frame
    std::int32_t index = kNone;             ///< of the slot
    const ContactSurface::Slot* slot = nullptr;
    TriangleCorners corners;
    Eigen::Vector3d normal;
    bool isB = false;

    [[nodiscard]] bool owns(std::size_t vertex) const
    {
        return (slot->ownVertices >> vertex & 1U) != 0;
    }
    [[nodiscard]] bool ownsEdge(std::size_t edge) const
    {
        return (slot->ownEdges >> edge & 1U) != 0;
    }
    [[nodiscard]] Eigen::Vector3d edge(std::size_t k) const
    {
        return corners[(k + 1) % 3] - corners[k];
    }

    /// True if no direction of the surface rises above the plane across `direction` by more than
    /// the limit. Directions along `axis` (unit) may rise by kLenient.
    [[nodiscard]] bool vertexCone(std::size_t k,
                                  const Eigen::Vector3d& direction,
                                  double limit,
                                  const Eigen::Vector3d& axis = Eigen::Vector3d::Zero()) const
    {
        const Eigen::Vector3f n = (R_FG->transpose() * direction).cast<float>();
        const Eigen::Vector3f e = (R_FG->transpose() * axis).cast<float>();
        for (const Eigen::Vector3f& t : surface->aroundVertex(slot->vertices[k]))
        {
            if (n.dot(t) > static_cast<float>(limit + kLenient * std::abs(double(e.dot(t)))))
            {
                return false;
            }
        }
        return true;
    }
    [[nodiscard]] bool edgeCone(std::size_t k, const Eigen::Vector3d& direction, double limit) const
    {
        const Eigen::Vector3f n = (R_FG->transpose() * direction).cast<float>();
        for (const Eigen::Vector3f& t : surface->aroundEdge(slot->edges[k]))
        {
            if (n.dot(t) > static_cast<float>(limit))
            {
                return false;
            }
        }
        return true;
    }
    /// Facets that stand for something round may have a limit of their own.
    [[nodiscard]] bool crossingCone(std::size_t k,
                                    const Eigen::Vector3d& direction,
                                    double sharp,
                                    double smooth) const
    {
        return edgeCone(k, direction, surface->isSmooth(slot->edges[k]) ? smooth : sharp);
    }
    /// Weights of the corners at a point of the plane, all at least `least`.
    [[nodiscard]] bool covers(const Eigen::Vector3d& point, double least = -kOnBoundary) const
    {
        const double twiceArea = edge(0).cross(edge(1)).dot(normal);
        for (std::size_t k = 0; k < 3; ++k)
        {
            if (edge(k).cross(point - corners[k]).dot(normal) < least * twiceArea)
            {
                return false;
            }
        }
        return !normal.isZero(0.0);
    }
};

/// Closest points of two lines p + s u and q + t v.
struct Crossing
{
    double s = -1.0;  ///< outside of both segments if they are parallel
    double t = -1.0;

    Crossing(const Eigen::Vector3d& p,
             const Eigen::Vector3d& u,
             const Eigen::Vector3d& q,
             const Eigen::Vector3d& v)
    {
        const Eigen::Vector3d n = u.cross(v);
        const double uu = u.squaredNorm();
        const double vv = v.squaredNorm();
        const double nn = n.squaredNorm();
        if (nn > kOnBoundary * kOnBoundary * uu * vv)
        {
            // The projections afterwards make the error of almost parallel edges one along them.
            s = (q - p).cross(v).dot(n) / nn;
            t = v.dot(p + s * u - q) / vv;
            s = u.dot(q + t * v - p) / uu;
        }
    }
    [[nodiscard]] bool isInside() const
    {
        constexpr double kLow = -kOnBoundary;
        constexpr double kHigh = 1.0 + kOnBoundary;
        return s >= kLow && s <= kHigh && t >= kLow && t <= kHigh;
    }
};

/// Of B, whose tree has the frame F.
inline Face faceOf(const ContactSurface& surface,
                   const Eigen::Matrix3d& identity,
                   std::int32_t slot)
{
    return {.surface = &surface,
            .R_FG = &identity,
            .index = slot,
            .slot = &surface.slot(slot),
            .corners = surface.corners(slot),
            .normal = surface.slot(slot).normal,
            .isB = true};
}

/// Of A.
inline Face faceOf(const ContactSurface& surface,
                   const Eigen::Matrix3d& R_FA,
                   const Eigen::Vector3d& p_FA,
                   std::int32_t slot)
{
    Face face = faceOf(surface, R_FA, slot);
    face.normal = R_FA * face.normal;
    for (Eigen::Vector3d& corner : face.corners)
    {
        corner = R_FA * corner + p_FA;
    }
    face.isB = false;
    return face;
}
}  // namespace bullet_ccd
