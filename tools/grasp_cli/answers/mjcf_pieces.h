/// A hand and an object in the pieces that MuJoCo collides.
#pragma once

#include "grasp/formats/mjcf_grasp_file.h"

namespace bullet_ccd::tools
{
/// Cuts the object and every link that has geometry, on all cores. Hands have many links and
/// contacts of each are few, so a link gets a quarter of the pieces of the object, at the most.
[[nodiscard]] grasp::MjcfPieces piecesOf(const grasp::HandModel& hand,
                                         const grasp::GraspObject& object,
                                         const ConvexPiecesOptions& options);
}  // namespace bullet_ccd::tools
