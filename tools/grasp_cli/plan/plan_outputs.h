/// The files of a run: records, pictures, models, page.
#pragma once

#include "grasp/formats/grasp_file.h"
#include "tools/grasp_cli/plan/output_folder.h"
#include "tools/grasp_cli/plan/plan_run.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// How many of the best grasps that have a final posture are drawn.
struct DrawingOptions
{
    int pictures = 5;
    std::optional<int> models;            ///< not given: as many as pictures
    bool sweptBoxes = false;              ///< in the pictures; models always have them
    std::vector<std::string> scene = {};  ///< files of the obstacles, for the command in the page
    /// If there are some, needed.json and needed.ply say what the closings needed (see
    /// closingReport() and writeNeededPicture(), in the posture of the best grasp).
    const ClosingUses* uses = nullptr;
    const ObstacleList* obstacles = nullptr;  ///< of those uses
};

/// Writes grasps.jsonl, grasps.isaac.yaml, the pictures, the models and report.html, all at once or
/// none, and removes drawings of an earlier run that are not replaced. Returns one line for each
/// file, or range of files, that was written. The report is in three dimensions if the viewer is in
/// shareFolder(), else it shows the pictures.
/// @param obstacles  at rest; shown in pictures, models and a report in three dimensions
/// Throws std::runtime_error "<file>: <what>: <remedy>".
std::vector<std::string> writePlanOutputs(OutputFolder& output,
                                          const grasp::GraspRun& run,
                                          const grasp::HandModel& hand,
                                          const grasp::GraspObject& object,
                                          const std::vector<grasp::Grasp>& grasps,
                                          const DrawingOptions& drawing,
                                          std::span<const RigidBody> obstacles = {});
}  // namespace bullet_ccd::tools
