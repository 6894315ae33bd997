/// Grasps as JSON Lines: one self-contained record per line, with a versioned schema.
///
/// The frame of reference is the object's mesh frame. Lengths are in metres, angles in radians. The
/// names of keys say units and the order of quaternions. Joint values and links are named. Numbers
/// have as many digits as an exact round trip needs. README.md in this folder lists the keys.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/squeeze/squeeze.h"

#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <span>
#include <string>

namespace bullet_ccd::grasp
{
/// The value of "schema" in every record.
inline constexpr const char* kGraspSchema = "bullet_ccd.grasp/1";

/// What a trial of a grasp came to.
struct TrialNote
{
    std::string protocol;
    std::string outcome;  ///< such as "held" or "dropped"
    std::string reason;   ///< of every outcome but "held"
    bool held = false;
    double slip = 0.0;  ///< [m]
    double turn = 0.0;  ///< [rad]
};

/// What is common to the grasps of one run.
struct GraspRun
{
    std::filesystem::path handFile;
    std::filesystem::path srdfFile;  ///< the SRDF that was used; empty: all was inferred
    std::filesystem::path objectFile;
    double objectScale = 1.0;
    std::string obstaclesHash{};  ///< contentHash() of what stood beside the object
    std::string robot{};  ///< the arm that had to bring the hand there, and its pose; empty: none
    PlannerOptions options;
    /// What the squeezes in the records are for; without it there are none.
    std::optional<SqueezeOptions> squeeze{};
    /// Of the grasps that were tried in a simulation, by candidate. Neither is read back.
    std::map<std::int64_t, std::vector<TrialNote>> trials{};
};

/// The grasp as it is when its record is read back: rotations have been through quaternions, which
/// moves their last bits.
[[nodiscard]] BULLET_CCD_API Grasp asRecorded(Grasp grasp);

/// Writes the grasps in the order given; the first has rank 1.
BULLET_CCD_API void writeGrasps(std::ostream& out,
                                const GraspRun& run,
                                const HandModel& hand,
                                const GraspObject& object,
                                std::span<const Grasp> grasps);

/// What a file says about its hand and object. It is enough to load them and to notice changes.
struct GraspFileSource
{
    GraspRun run;
    std::string handHash;
    std::string objectHash;
    std::string version;  ///< of bullet_ccd that wrote it
};

/// Reads hand, object and options from the first record of a file.
/// @param skipDamaged  from the first record that can be read
/// Throws std::runtime_error: "<file>:<line>: <what>: <remedy>".
[[nodiscard]] BULLET_CCD_API GraspFileSource readGraspSource(const std::filesystem::path& path,
                                                             bool skipDamaged = false);

/// Reads all grasps of a file; `hand` must be the hand that it was written for.
/// @param damaged  not null: lines that cannot be read are left out, and what would have been
///                 thrown is added here
/// @param ranks    not null: those of the grasps are added here, their lines for records without
/// Throws std::runtime_error: "<file>:<line>: <what>: <remedy>", also if a line has another hand or
/// object than the first line, or, with `ranks`, the rank of another line.
[[nodiscard]] BULLET_CCD_API std::vector<Grasp> readGrasps(
    const std::filesystem::path& path,
    const HandModel& hand,
    std::vector<std::string>* damaged = nullptr,
    std::vector<int>* ranks = nullptr);

/// Reads the grasp of one record, a line of a file, which was written for `hand`.
/// Throws as readGrasps() does, with "record" in place of the file.
[[nodiscard]] BULLET_CCD_API Grasp readGrasp(const std::string& record, const HandModel& hand);

/// Reads the preshapes that the grasps of a file started from, each once, in the order in which
/// they appear. Positions have one entry per link of `hand`. Records of old versions, which kept
/// only the names, give no preshape.
/// Throws std::runtime_error: "<file>:<line>: <what>: <remedy>".
[[nodiscard]] BULLET_CCD_API std::vector<Preshape> readPreshapes(const std::filesystem::path& path,
                                                                 const HandModel& hand);
}  // namespace bullet_ccd::grasp
