/// A hand: a robot whose joints are sorted into fingers that close.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/io/urdf_file.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// A chain of links from the palm (exclusive) to a tip; links that carry several fingers belong to
/// none.
struct Finger
{
    std::string name;
    std::vector<std::int32_t> links;  ///< proximal first; fixed links included
};

/// Joint positions before closing, one entry a link.
struct Preshape
{
    std::string name;
    std::vector<double> positions;
};

/// Moves but does not copy: `linkTrees` points into `trees`.
struct HandModel
{
    HandModel() = default;
    HandModel(HandModel&&) = default;
    HandModel& operator=(HandModel&&) = default;

    RobotModel robot;
    std::filesystem::path srdfFile;  ///< that fingers and preshapes come from; empty: all inferred
    std::vector<SsvTree> trees;      ///< of links that have geometry
    /// One entry a link: its hierarchy in `trees`, or null.
    std::vector<const SsvTree*> linkTrees;
    std::int32_t palm = 0;  ///< link that all fingers hang from
    std::vector<Finger> fingers;
    /// One entry a link: +1 or -1 for a joint that closes towards its upper or lower limit, 0 for a
    /// joint that keeps its preshape (wrist, spread, fixed). A mimic joint has the direction that
    /// the joint it follows gives it.
    std::vector<int> closingDirections;
    std::vector<Preshape> preshapes;  ///< at least one; the first is the default
    /// Pairs of links that can touch during closing, smaller link index first: all pairs with
    /// geometry that a closing joint lies between, less neighbours (one closing joint between
    /// them), less the disabled ones, less those that overlap in every preshape.
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;
    /// Grasp frame in the root link: origin where the fingers meet, +z the direction in which the
    /// hand approaches an object, +x the direction across which the fingers oppose each other.
    Eigen::Isometry3d X_RG = Eigen::Isometry3d::Identity();
    std::vector<std::string> notes;  ///< what was inferred, one line each
};

[[nodiscard]] BULLET_CCD_API const std::string& linkName(const HandModel& hand, std::int32_t link);

/// The preshape of that name; null if the hand has none. Points into `hand`.
[[nodiscard]] BULLET_CCD_API const Preshape* findPreshape(const HandModel& hand,
                                                          const std::string& name);

/// Target of a closing joint: its limit in the closing direction (a joint without limits: a full
/// turn from `from`). One entry a link; joints that do not close keep `from`; mimics applied.
[[nodiscard]] BULLET_CCD_API std::vector<double> closedPositions(const HandModel& hand,
                                                                 const std::vector<double>& from);
}  // namespace bullet_ccd::grasp
