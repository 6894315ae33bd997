/// Umbrella of the grasp planner, which goes from a hand and an object to ranked grasps. Link
/// grasp::grasp.
///
/// The simulated closing is in grasp/sim/hand_simulation.h. It needs Bullet; link grasp::sim.
#pragma once

#include "grasp/approach/approach.h"
#include "grasp/check/penetration_check.h"
#include "grasp/closing/closing.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/formats/grasp_file.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/quality/object_mass.h"
#include "grasp/quality/wrench_space.h"
