/// What trial grasps found of a hand, kept in a file: the part of inference that takes seconds.
#pragma once

#include "grasp/hand/hand_model.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// What was not searched is empty.
struct SearchedHand
{
    std::vector<Preshape> preshapes{};  ///< searchPreshapes()
    std::vector<Eigen::Isometry3d>
        frames{};                  ///< searchGraspFrame(), of preshapes without, in order
    std::vector<double> speeds{};  ///< searchClosingSpeeds()
};

/// Name of the file for such a hand: it depends on the links, joints and meshes of the robot, on
/// the bytes of the SRDF (or of whatever file is read in its place), and on the sources of this
/// room: whatever changes there is searched anew.
[[nodiscard]] std::string searchedHandFileName(const RobotModel& robot,
                                               const std::filesystem::path& srdf);

/// What saveSearchedHand() wrote, bit for bit. Nothing if the file is missing, damaged, or of
/// another robot.
/// @param links of the robot: every list of joint positions has so many entries
[[nodiscard]] BULLET_CCD_API std::optional<SearchedHand> loadSearchedHand(
    const std::filesystem::path& file, std::size_t links);

/// Folders above the file are made. Others who read it meanwhile see all of it or nothing. Where it
/// cannot be written, nothing happens: it would be found again.
BULLET_CCD_API void saveSearchedHand(const SearchedHand& hand, const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
