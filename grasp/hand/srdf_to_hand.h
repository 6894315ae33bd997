/// What an SRDF says about a robot, and inference of what it does not say.
#pragma once

#include "grasp/hand/hand_model.h"
#include "grasp/hand/srdf_file.h"

namespace bullet_ccd::grasp
{
/// Fills a hand of which `robot`, `trees` and `linkTrees` are set; see hand_model.h. An empty
/// `srdf` (with `file` set for messages) means: infer everything. Throws std::runtime_error:
/// "<file>: <element>: <what, value>: <remedy>".
void applySrdf(const Srdf& srdf, HandModel& hand);
}  // namespace bullet_ccd::grasp
