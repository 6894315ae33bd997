/// A small hand of boxes around a ball, for pictures.
#pragma once

#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <filesystem>
#include <string>

namespace bullet_ccd::tests
{
/// Palm above the origin, two fingers that reach down at x = -0.06 and x = +0.06.
[[nodiscard]] grasp::HandModel makeBoxHand();

/// The hand at its place, and `contactCount` contacts around the equator of a ball of radius 0.05.
[[nodiscard]] grasp::Grasp makeBoxGrasp(int contactCount);

/// A file in a folder of this test program, which is created.
[[nodiscard]] std::filesystem::path outputFile(const std::string& name);
}  // namespace bullet_ccd::tests
