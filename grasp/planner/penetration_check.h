/// Independent check of a final pose: shares no code with the queries that produced it.
#pragma once

#include "grasp/grasp.h"
#include "grasp/hand/hand_model.h"

namespace bullet_ccd::grasp
{
struct PenetrationReport
{
    std::int64_t intersectingTriangles = 0;  ///< pairs (link triangle, object triangle)
    std::int64_t verticesInside = 0;         ///< link vertices inside a watertight object
    double deepest = 0.0;  ///< largest distance of an inside vertex from the object's surface [m]
    std::int32_t link = kNone;  ///< a link concerned
    [[nodiscard]] bool clean() const { return intersectingTriangles == 0 && verticesInside == 0; }
};

/// Intersects every triangle of every link with every triangle of the object (a uniform grid finds
/// the candidates) by segment-triangle tests, and casts rays from the links' vertices.
[[nodiscard]] PenetrationReport checkPenetration(const HandModel& hand,
                                                 const GraspObject& object,
                                                 const Eigen::Isometry3d& X_WH,
                                                 const std::vector<double>& positions);
}  // namespace bullet_ccd::grasp
