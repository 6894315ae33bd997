/// URDF + SRDF -> HandModel.
///
/// What URDF cannot say stands in an SRDF file, as MoveIt's users write it:
///   <group name="thumb"><chain base_link=".." tip_link=".."/></group>   a finger (one a group;
///   groups
///       without a chain, whose chain holds no movable joint or ends above another one's are
///       ignored)
///   <group_state name="open" group="..."><joint name=".." value=".."/></group_state>   a preshape;
///       states of one name are one preshape, joints that are not listed stay at 0 clamped into
///       their limits; the state "open" comes first, then the order of the file; states in which
///       the fingers are closed already are dropped
///   <disable_collisions link1=".." link2=".." reason=".."/>
///   <passive_joint name=".."/>   a joint that keeps its preshape (wrist, spread): frozen
/// and, as extensions that MoveIt ignores,
///   <closing joint=".." direction="+1|-1"/>
///   <grasp_frame link=".." xyz=".." rpy=".."/>   see HandModel::X_RG; at the first preshape
/// What is missing is inferred and noted: fingers (if no group is one), closing directions (of
/// finger joints that are neither passive nor listed as closing), a preshape, the grasp frame.
/// Links that overlap in every preshape are never tested against each other, and noted.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/hand/hand_model.h"

#include <filesystem>
#include <optional>

namespace bullet_ccd::grasp
{
/// Loads a hand. Without `srdf` one is looked for: <urdf stem>.srdf beside the URDF; then, if
/// `shareFolder` is given, robots/srdf/<name>.srdf in it, where the names tried are the URDF's
/// stem, the stem without a trailing "_mesh", the robot's name, and that without "_mesh". A file
/// found in the share folder that does not fit the robot is put aside with a note; one that was
/// named or lies beside the URDF must fit. If there is none, everything is inferred. Throws
/// std::runtime_error: "<file>: <element>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API HandModel
loadHand(const std::filesystem::path& urdf,
         const std::optional<std::filesystem::path>& srdf = std::nullopt,
         const std::filesystem::path& shareFolder = {});
}  // namespace bullet_ccd::grasp
