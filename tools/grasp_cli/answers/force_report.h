/// Answers of `grasp force`, for people and for programs.
#pragma once

#include "grasp/force/robust_forces.h"
#include "grasp/hand/hand_model.h"

#include <optional>
#include <string>

namespace bullet_ccd::tools
{
/// One grasp with its question and its answer.
struct ForceRecord
{
    int rank = 0;
    std::int64_t candidate = 0;
    grasp::ForceProblem problem{};
    grasp::ForceOptions options{};
    grasp::GraspForces forces{};  ///< with a disturbance: of its worst corner
    std::optional<grasp::Disturbance> disturbance{};
    grasp::RobustForces robust{};  ///< of the disturbance

    [[nodiscard]] grasp::ForceStatus status() const
    {
        return disturbance ? robust.status : forces.status;
    }
};

/// A line on the outcome, then a table of contacts and one of joints.
[[nodiscard]] std::string forceText(const ForceRecord& record, const grasp::HandModel& hand);

/// The same as one line of JSON.
[[nodiscard]] std::string forceJson(const ForceRecord& record, const grasp::HandModel& hand);
}  // namespace bullet_ccd::tools
