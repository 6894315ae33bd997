/// A hand: a robot whose joints are sorted into fingers that close.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/io/urdf_file.h"

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
}  // namespace bullet_ccd::grasp
