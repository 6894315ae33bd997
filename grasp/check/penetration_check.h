/// Independent check of a final pose: shares no code with the queries that produced it.
///
/// Surfaces intersect where an edge of one passes through a triangle of the other: signs of
/// determinants decide, each with a bound of its own rounding error. A body inside another is found
/// by the winding number of a closed surface about the vertices of the other. The resolution is a
/// nanometre: a link counts as intersecting if it does so when moved by that much, and also when
/// moved back by it. So surfaces that lie on each other, up to the rounding of poses, are clean,
/// and edges that run exactly through the seam of two triangles are found.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <memory>

namespace bullet_ccd::grasp
{
struct PenetrationReport
{
    std::int64_t intersectingTriangles = 0;  ///< pairs (link triangle, object triangle)
    /// Link vertices inside a watertight object, and object vertices inside a watertight link.
    std::int64_t verticesInside = 0;
    double deepest = 0.0;  ///< largest distance of such a vertex from the surface it is behind [m]
    std::int32_t link = kNone;  ///< the first link concerned
    [[nodiscard]] bool clean() const { return intersectingTriangles == 0 && verticesInside == 0; }
};

/// The check of one hand and object, for many postures: what does not depend on the posture is made
/// once. Refers to both, which must outlive it. Not for several threads at a time.
class BULLET_CCD_API PenetrationCheck
{
public:
    PenetrationCheck(const HandModel& hand, const GraspObject& object);
    ~PenetrationCheck();
    PenetrationCheck(PenetrationCheck&&) noexcept;

    /// Intersects every triangle of every link with every triangle of the object (a uniform grid
    /// finds the candidates), and looks for vertices of one inside the other.
    /// @param X_WH       pose of the hand's root link; the object's mesh frame is W
    /// @param positions  one entry a link
    [[nodiscard]] PenetrationReport at(const Eigen::Isometry3d& X_WH,
                                       const std::vector<double>& positions);

    /// What remains to be asked where no surface of a link is as near to the object's as
    /// kResolution: true if a whole part of a link is inside a watertight object, or a part of the
    /// object inside a watertight link. One vertex of each part tells, so this takes a hundredth of
    /// the time, and then says what at(X_WH, positions) does.
    [[nodiscard]] bool holdsInside(const Eigen::Isometry3d& X_WH,
                                   const std::vector<double>& positions);

    /// Intersections and depths up to this are contact [m].
    static constexpr double kResolution = 1e-9;

private:
    struct Parts;
    std::unique_ptr<Parts> m_parts;
};

/// The same for one posture.
[[nodiscard]] BULLET_CCD_API PenetrationReport
checkPenetration(const HandModel& hand,
                 const GraspObject& object,
                 const Eigen::Isometry3d& X_WH,
                 const std::vector<double>& positions);
}  // namespace bullet_ccd::grasp
