/// Independent check of a final pose. It shares no code with the queries that produced the pose.
///
/// Surfaces intersect where an edge of one passes through a triangle of the other. The signs of
/// determinants decide, each with a bound of its own rounding error. A body inside another one is
/// found by the winding number of a closed surface about the vertices of the other. The resolution
/// is a nanometre: a link counts as intersecting if it does so when moved by that much, and also
/// when moved back by it. So surfaces that lie on each other, up to the rounding of poses, do not
/// count, and edges that run exactly through the seam of two triangles are found.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <memory>

namespace bullet_ccd::grasp
{
/// What the check found.
struct PenetrationReport
{
    std::int64_t intersectingTriangles = 0;  ///< pairs (link triangle, object triangle)
    /// Link vertices inside a watertight object, and object vertices inside a watertight link.
    std::int64_t verticesInside = 0;
    double deepest = 0.0;  ///< largest distance of such a vertex from the surface it is behind [m]
    std::int32_t link = kNone;  ///< the first link concerned
    [[nodiscard]] bool clean() const { return intersectingTriangles == 0 && verticesInside == 0; }
};

/// The check of one hand and one object for many postures. What does not depend on the posture is
/// made once. The check refers to hand and object, which must outlive it. Only one thread may use
/// it at a time.
class BULLET_CCD_API PenetrationCheck
{
public:
    PenetrationCheck(const HandModel& hand, const GraspObject& object);
    ~PenetrationCheck();
    PenetrationCheck(PenetrationCheck&&) noexcept;

    /// Intersects the triangles of all links with the triangles of the object, with candidates from
    /// a uniform grid, and looks for vertices of one inside the other.
    /// @param X_WH       pose of the hand's root link; the object's mesh frame is W
    /// @param positions  one entry per link [rad or m]
    [[nodiscard]] PenetrationReport at(const Eigen::Isometry3d& X_WH,
                                       const std::vector<double>& positions);

    /// True if a whole part of a link is inside a watertight object, or a whole part of the object
    /// is inside a watertight link. One vertex per part decides, so this takes a hundredth of the
    /// time of at().
    ///
    /// Guarantee: it agrees with at() where no surface of a link is within kResolution of the
    /// object's.
    [[nodiscard]] bool holdsInside(const Eigen::Isometry3d& X_WH,
                                   const std::vector<double>& positions);

    /// Intersections up to this depth are contact [m].
    static constexpr double kResolution = 1e-9;

private:
    struct Parts;
    std::unique_ptr<Parts> m_parts;
};

/// PenetrationCheck::at() for a single posture.
[[nodiscard]] BULLET_CCD_API PenetrationReport
checkPenetration(const HandModel& hand,
                 const GraspObject& object,
                 const Eigen::Isometry3d& X_WH,
                 const std::vector<double>& positions);
}  // namespace bullet_ccd::grasp
