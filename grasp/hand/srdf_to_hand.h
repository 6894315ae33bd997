/// What an SRDF says about a robot, and inference of what it does not say.
#pragma once

#include "grasp/hand/hand_model.h"
#include "grasp/hand/srdf_file.h"

namespace bullet_ccd::grasp
{
/// Fills a hand of which `robot`, `trees` and `linkTrees` are set; see hand_model.h. An empty
/// `srdf` (with `file` set for messages) means: infer everything. Throws std::runtime_error:
/// "<file>: <element>: <what, value>: <remedy>".
/// @param cacheFolder keeps what trial grasps find (searched_hand.h); empty: nothing is kept
void applySrdf(const Srdf& srdf, HandModel& hand, const std::filesystem::path& cacheFolder);
}  // namespace bullet_ccd::grasp
