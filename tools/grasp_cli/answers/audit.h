/// What a grasp is worth when it is looked at afresh: penetration, and the gaps of its contacts.
#pragma once

#include "grasp/check/penetration_check.h"

namespace bullet_ccd::tools
{
/// Every distance is measured again, triangle by triangle, without hierarchies.
struct GraspAudit
{
    grasp::PenetrationReport penetration;
    double largestGap = 0.0;     ///< from a contact's point to the surface of its link [m]
    double largestOffset = 0.0;  ///< from a contact's point to the surface of the object [m]
    int links = 0;               ///< links in contact
    int fingers = 0;             ///< fingers in contact
};

/// @pre the grasp was closed: it has joint positions
[[nodiscard]] GraspAudit auditGrasp(const grasp::HandModel& hand,
                                    const grasp::GraspObject& object,
                                    const grasp::Grasp& grasp);
}  // namespace bullet_ccd::tools
