/// Where the benchmarks find their files, and which hands and objects they take.
#pragma once

#include <array>
#include <filesystem>

namespace bullet_ccd::benchmarks
{
/// The data folder: $BULLET_CCD_TEST_DATA, or ../shared/data beside the checkout.
[[nodiscard]] std::filesystem::path defaultDataFolder();

/// Hands whose collision geometry is the detailed mesh, polygon soups with cracks and all: URDF
/// files below hands/ of the data folder, without their ending.
inline constexpr std::array kDetailedHands{"allegro/allegro_right_mesh",
                                           "barrett/barrett_mesh",
                                           "leap/leap_right_mesh",
                                           "panda_gripper/panda_gripper_mesh",
                                           "schunk_sah/schunk_sah_right_mesh",
                                           "schunk_sdh/schunk_sdh_mesh",
                                           "schunk_svh/schunk_svh_right_mesh",
                                           "shadow/shadow_right_mesh"};
}  // namespace bullet_ccd::benchmarks
