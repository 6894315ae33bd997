/// Smaller models of a hand and an object for simulations that keep an accuracy.
#pragma once

#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"

#include <cstddef>
#include <map>
#include <string>

namespace bullet_ccd::tools
{
/// What was taken in place of the full meshes.
struct TrialModels
{
    std::map<std::string, int> shapes;  ///< how many of which kind: "box", "mesh"
    std::size_t triangles = 0;
    std::size_t ofTriangles = 0;
};

/// By how much a surface may be off, as a share of the accuracy: of two that keep apart, the full
/// meshes are inside each other by less than the accuracy.
inline constexpr double kModelShare = 0.4;

/// Replaces the object and every link by the cheapest model no point of which is farther from the
/// full surface, nor that from it, than this share of the accuracy [m]. The centre of mass of the
/// object stays.
TrialModels reduceForTrial(grasp::HandModel& hand, grasp::GraspObject& object, double accuracy);

/// "models: 1 box, 1 hull, 14 mesh; 3120 of 84512 triangles"
[[nodiscard]] std::string plainText(const TrialModels& models);
}  // namespace bullet_ccd::tools
