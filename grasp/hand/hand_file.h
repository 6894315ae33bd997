/// Loads a hand from URDF and SRDF.
///
/// What URDF cannot say stands in an SRDF file, as MoveIt's users write it:
///   <group name="thumb"><chain base_link=".." tip_link=".."/></group>   a finger, one
///       per group; a group is ignored if it has no chain, or if its chain holds no movable joint
///       or ends above that of another group
///   <group_state name="open" group="..."><joint name=".." value=".."/></group_state>   a preshape;
///       states of one name are one preshape; joints that are not listed stay at 0, clamped into
///       their limits; the state "open" comes first, the others follow in the order of the file;
///       states in which the fingers are already closed are dropped
///   <disable_collisions link1=".." link2=".." reason=".."/>
///   <passive_joint name=".."/>   a joint that keeps its preshape (wrist, spread)
/// and, as extensions that MoveIt ignores,
///   <closing joint=".." direction="+1|-1"/>
///   <grasp_frame preshape=".." link=".." xyz=".." rpy=".."/>   see HandModel::X_RG; with a
///       preshape that of this one, without that of all others, at the first preshape
/// srdf_writer.h writes such a file.
/// What is missing is inferred and noted, piece by piece: fingers (if no group is one), closing
/// directions (of finger joints that are neither passive nor listed as closing), preshapes, and the
/// grasp frame, of which every preshape then has its own. Preshapes are searched by trial grasps,
/// which takes seconds (preshape_search.h), if there are joints below the palm that do not close,
/// passive ones among them.
/// Links that overlap in every preshape are never tested against each other; a note names them.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/hand/hand_model.h"

#include <filesystem>
#include <optional>

namespace bullet_ccd::grasp
{
/// Loads a hand. Without `srdf` the function looks for <urdf stem>.srdf beside the URDF. Then, if
/// `shareFolder` is given, it looks there for robots/srdf/<name>.srdf, where the name is the URDF's
/// stem, the stem without a trailing "_mesh", the robot's name, or that name without "_mesh". A
/// file in the share folder that does not fit the robot is put aside with a note. A file that was
/// named or is beside the URDF must fit. Without any SRDF everything is inferred.
/// Throws std::runtime_error: "<file>: <element>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API HandModel
loadHand(const std::filesystem::path& urdf,
         const std::optional<std::filesystem::path>& srdf = std::nullopt,
         const std::filesystem::path& shareFolder = {});

/// Loads a hand of which everything is inferred, whatever SRDF there is.
/// Throws as loadHand() does.
[[nodiscard]] BULLET_CCD_API HandModel inferHand(const std::filesystem::path& urdf);
}  // namespace bullet_ccd::grasp
