/// A hand: a robot whose joints are sorted into fingers that close. It is loaded from URDF and
/// SRDF.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/io/robot_file.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// A chain of links from the palm (exclusive) to a tip. A link that carries several fingers belongs
/// to none of them.
struct Finger
{
    std::string name;
    std::vector<std::int32_t> links;  ///< proximal first; fixed links included
};

/// Joint positions before closing, one entry per link [rad or m].
struct Preshape
{
    std::string name;
    std::vector<double> positions;
    /// Its own grasp frame in the root link, in place of HandModel::X_RG.
    std::optional<Eigen::Isometry3d> X_RG{};
};

/// A hand. It can be moved but not copied, because `linkTrees` points into `trees`.
struct HandModel
{
    HandModel() = default;
    HandModel(HandModel&&) = default;
    HandModel& operator=(HandModel&&) = default;

    RobotModel robot;
    std::filesystem::path srdfFile;  ///< source of fingers and preshapes; empty: all inferred
    std::vector<SsvTree> trees;      ///< of links that have geometry
    /// One entry per link: its hierarchy in `trees`, or null without geometry.
    std::vector<const SsvTree*> linkTrees;
    std::int32_t palm = 0;  ///< link that all fingers hang from
    std::vector<Finger> fingers;
    /// One entry per link: +1 or -1 for a joint that closes towards its upper or lower limit, 0 for
    /// a joint that keeps its preshape (wrist, spread, fixed). A mimic joint has the direction that
    /// the joint it follows gives it.
    std::vector<int> closingDirections;
    /// One entry per link: how fast the joint closes, as a ratio > 0 to the usual speed
    /// (ClosingDrives). Empty: 1 for all.
    std::vector<double> closingSpeeds{};
    std::vector<Preshape> preshapes;  ///< at least one; the first is the default
    /// Pairs of links that can touch during closing, smaller link index first. They are all pairs
    /// that have geometry and a closing joint between them, except neighbours (with one closing
    /// joint between them), disabled pairs, and pairs that overlap in every preshape.
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;
    /// Pose of the grasp frame in the root link. Its origin is where the fingers meet, +z is the
    /// direction in which the hand approaches an object, and +x is the direction across which the
    /// fingers oppose each other. A preshape may have its own.
    Eigen::Isometry3d X_RG = Eigen::Isometry3d::Identity();
    std::vector<std::string> notes;  ///< what was inferred, one line each
};

/// Name of a link of the hand. It refers into `hand`.
[[nodiscard]] BULLET_CCD_API const std::string& linkName(const HandModel& hand, std::int32_t link);

/// The preshape of that name, or null if the hand has none. It points into `hand`.
[[nodiscard]] BULLET_CCD_API const Preshape* findPreshape(const HandModel& hand,
                                                          const std::string& name);

/// The grasp frame of the preshape in the root link: its own, or that of the hand.
[[nodiscard]] BULLET_CCD_API const Eigen::Isometry3d& graspFrame(const HandModel& hand,
                                                                 const Preshape& preshape);

/// True if every closing joint follows one and the same joint: a gripper whose jaws cannot centre
/// themselves on the object; the first jaw to touch stops both.
[[nodiscard]] BULLET_CCD_API bool fingersAreCoupled(const HandModel& hand);

/// Where the joints end if nothing stops them, one entry per link [rad or m]. A closing joint goes
/// to its limit in the closing direction, or by a full turn from `from` if it has no limits. Joints
/// that do not close keep `from`. Mimics are applied.
[[nodiscard]] BULLET_CCD_API std::vector<double> closedPositions(const HandModel& hand,
                                                                 const std::vector<double>& from);

// Loads a hand from URDF and SRDF.
//
// What URDF cannot say stands in an SRDF file, as MoveIt's users write it:
//   <group name="thumb"><chain base_link=".." tip_link=".."/></group>   a finger, one
//       per group; a group is ignored if it has no chain, or if its chain holds no movable joint
//       or ends above that of another group
//   <group_state name="open" group="..."><joint name=".." value=".."/></group_state>   a preshape;
//       states of one name are one preshape; joints that are not listed stay at 0, clamped into
//       their limits; the state "open" comes first, the others follow in the order of the file;
//       states in which the fingers are already closed are dropped
//   <disable_collisions link1=".." link2=".." reason=".."/>
//   <passive_joint name=".."/>   a joint that keeps its preshape (wrist, spread)
// and, as extensions that MoveIt ignores,
//   <closing joint=".." direction="+1|-1" speed="0.5"/>   speed is a ratio to the usual speed and
//       may be left out (1)
//   <grasp_frame preshape=".." link=".." xyz=".." rpy=".."/>   see HandModel::X_RG; with a
//       preshape that of this one, without that of all others, at the first preshape
// srdf_writer.h writes such a file.
// What is missing is inferred and noted, piece by piece: fingers (if no group is one), closing
// directions (of finger joints that are neither passive nor listed as closing), preshapes, and the
// grasp frame, of which every preshape then has its own. Preshapes are searched by trial grasps,
// which takes seconds (preshape_search.h), if there are joints below the palm that do not close,
// passive ones among them.
// Links that overlap in every preshape are never tested against each other; a note names them.

/// Loads a hand. Without `srdf` the function looks for <urdf stem>.srdf beside the URDF. Then, if
/// `shareFolder` is given, it looks there for robots/srdf/<name>.srdf, where the name is the URDF's
/// stem, the stem without a trailing "_mesh", the robot's name, or that name without "_mesh". A
/// file in the share folder that does not fit the robot is put aside with a note. A file that was
/// named or is beside the URDF must fit. Without any SRDF everything is inferred.
/// What trial grasps find is kept in `cacheFolder`, if it is given, and taken from there the next
/// time: the same hand, bit for bit. The name of its file depends on the content of robot, meshes
/// and SRDF. A damaged file is replaced; a folder that cannot be written does not matter.
/// Throws std::runtime_error: "<file>: <element>: <what, value>: <remedy>".
[[nodiscard]] BULLET_CCD_API HandModel
loadHand(const std::filesystem::path& urdf,
         const std::optional<std::filesystem::path>& srdf = std::nullopt,
         const std::filesystem::path& shareFolder = {},
         const std::filesystem::path& cacheFolder = {});

/// The hand that is a part of a robot (splitRobot()), by what the SRDF of the robot says of its
/// links and joints; what that says of others is left out. Without an SRDF everything is inferred.
/// @param whole the links of the robot
/// `cacheFolder` is as in loadHand().
/// Throws as loadHand() does.
[[nodiscard]] BULLET_CCD_API HandModel handOf(RobotModel part,
                                              const KinematicTree& whole,
                                              const std::optional<std::filesystem::path>& srdf,
                                              const std::filesystem::path& cacheFolder = {});

/// Loads a hand of which everything is inferred, whatever SRDF there is.
/// `cacheFolder` is as in loadHand().
/// Throws as loadHand() does.
[[nodiscard]] BULLET_CCD_API HandModel inferHand(const std::filesystem::path& urdf,
                                                 const std::filesystem::path& cacheFolder = {});
}  // namespace bullet_ccd::grasp
