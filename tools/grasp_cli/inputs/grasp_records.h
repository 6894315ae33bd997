/// Grasps of a file with the hand and the object that they were planned for.
#pragma once

#include "grasp/formats/grasp_file.h"
#include "tools/grasp_cli/inputs/catalogue.h"

#include <cstdint>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// Which file, and what of it has moved.
struct RecordArguments
{
    std::string file;
    std::string hand;    ///< where it is now; empty: where the file says
    std::string object;  ///< same
};

struct GraspRecords
{
    grasp::GraspFileSource source;
    LoadedHand hand;
    LoadedObject object;
    std::vector<grasp::Grasp> grasps;  ///< as in the file: rank 1 first
    std::vector<int> ranks;            ///< of the grasps, as their records say
    bool isDamaged = false;            ///< lines were left out

    /// The exit code of a command that has done its work: kBadInput if lines were left out.
    [[nodiscard]] int exitCode(int code) const;
};

/// Lines that cannot be read, or have the rank of another one, are named on stderr and left out;
/// the others keep their ranks. Throws std::runtime_error "<file>: <what>: <remedy>", also where
/// hand or object have another content than the grasps were planned with.
[[nodiscard]] GraspRecords loadGraspRecords(const RecordArguments& arguments);

/// Which grasps of a file a command is about.
struct RecordChoice
{
    std::vector<int> ranks;
    std::vector<std::int64_t> candidates;
};

/// Indices of the chosen grasps, ascending; without a choice those of all force closures.
/// Throws std::runtime_error for a rank or candidate that the file does not have.
[[nodiscard]] std::vector<std::size_t> chosenGrasps(const GraspRecords& records,
                                                    const RecordArguments& arguments,
                                                    const RecordChoice& choice);
}  // namespace bullet_ccd::tools
