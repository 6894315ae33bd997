/// URDF + SRDF -> HandModel.
///
/// What URDF cannot say stands in an SRDF file, as MoveIt's users write it:
///   <group name="thumb"><chain base_link=".." tip_link=".."/></group>   a finger (one a group;
///   groups
///       without a chain, or whose chain holds no movable joint, are ignored)
///   <group_state name="open" group="..."><joint name=".." value=".."/></group_state>   a preshape;
///       joints that are not listed stay at 0 clamped into their limits
///   <disable_collisions link1=".." link2=".." reason=".."/>
///   <passive_joint name=".."/>   a joint that keeps its preshape (wrist, spread): frozen
/// and, as extensions that MoveIt ignores,
///   <closing joint=".." direction="+1|-1"/>
///   <grasp_frame link=".." xyz=".." rpy=".."/>   see HandModel::X_RG
/// What is missing is inferred and noted.
#pragma once

#include "grasp/hand/hand_model.h"

#include <filesystem>
#include <optional>

namespace bullet_ccd::grasp
{
/// Loads a hand. `srdf` empty: <urdf stem>.srdf beside the URDF if it exists, else the project's
/// own for well-known hands (robots/srdf/<robot name>.srdf under `shareFolder`), else everything is
/// inferred. Throws std::runtime_error: "<file>: <element>: <what, value>: <remedy>".
[[nodiscard]] HandModel loadHand(const std::filesystem::path& urdf,
                                 const std::optional<std::filesystem::path>& srdf = std::nullopt,
                                 const std::filesystem::path& shareFolder = {});
}  // namespace bullet_ccd::grasp
