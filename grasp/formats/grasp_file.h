/// Grasps as JSON Lines: one self-contained record a line, schema versioned.
///
/// The object's mesh frame is the frame of reference; lengths in metres, angles in radians; names
/// of keys say units and the order of quaternions. Joint values and links go by name. Numbers are
/// written with as many digits as a round trip needs to be exact. README.md in this folder lists
/// the keys.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/planner/grasp_planner.h"

#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>

namespace bullet_ccd::grasp
{
/// Written to "schema" of every record.
inline constexpr const char* kGraspSchema = "bullet_ccd.grasp/1";

/// What is common to the grasps of one run.
struct GraspRun
{
    std::filesystem::path handFile;
    std::filesystem::path srdfFile;  ///< that was used; empty: all was inferred
    std::filesystem::path objectFile;
    double objectScale = 1.0;
    std::string obstaclesHash{};  ///< contentHash() of what stood beside the object
    PlannerOptions options;
};

/// Writes the grasps in the order given; the first has rank 1.
BULLET_CCD_API void writeGrasps(std::ostream& out,
                                const GraspRun& run,
                                const HandModel& hand,
                                const GraspObject& object,
                                std::span<const Grasp> grasps);

/// What a file says about its hand and object: enough to load them and to notice that they changed.
struct GraspFileSource
{
    GraspRun run;
    std::string handHash;
    std::string objectHash;
    std::string version;  ///< of bullet_ccd that wrote it
};

/// Reads the first record of a file for its source.
/// Throws std::runtime_error: "<file>:<line>: <what>: <remedy>".
[[nodiscard]] BULLET_CCD_API GraspFileSource readGraspSource(const std::filesystem::path& path);

/// Reads all grasps of a file; `hand` must be the hand that it was written for.
/// Throws std::runtime_error: "<file>:<line>: <what>: <remedy>", also for lines of another hand or
/// object than the first line's.
[[nodiscard]] BULLET_CCD_API std::vector<Grasp> readGrasps(const std::filesystem::path& path,
                                                           const HandModel& hand);

/// Reads the preshapes that the grasps of a file started from, each once, in order of appearance;
/// one entry a link of `hand`. Records of versions that kept only the names give none.
/// Throws std::runtime_error: "<file>:<line>: <what>: <remedy>".
[[nodiscard]] BULLET_CCD_API std::vector<Preshape> readPreshapes(const std::filesystem::path& path,
                                                                 const HandModel& hand);
}  // namespace bullet_ccd::grasp
