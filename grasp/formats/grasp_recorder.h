/// Single records of a grasp file (grasp_file.h), for plans that are under way.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/formats/grasp_file.h"
#include "grasp/quality/object_mass.h"

#include <string>

namespace bullet_ccd::grasp
{
/// Beside the quaternion of a pose: its rotation matrix row by row, where every bit counts.
inline constexpr const char* kRotationKey = "rotation_rows";

/// That stands in "versions" of every record: that of this library.
[[nodiscard]] BULLET_CCD_API const char* recorderVersion();

/// Makes the records of a run one by one.
class BULLET_CCD_API GraspRecorder
{
public:
    /// Keeps references: all three must outlive it.
    GraspRecorder(const GraspRun& run, const HandModel& hand, const GraspObject& object);

    /// One line, without its end.
    [[nodiscard]] std::string ranked(const Grasp& grasp, int rank) const;
    /// For a plan that is under way: without a rank, but with the rotation matrices of poses, so
    /// that readGrasps() gives the grasp back bit by bit. (Of one that was never closed X_WH, which
    /// means nothing, is left out.)
    [[nodiscard]] std::string exact(const Grasp& grasp) const;

private:
    const GraspRun& m_run;
    const HandModel& m_hand;
    const GraspObject& m_object;
    std::string m_handHash;
    std::string m_objectHash;
    ObjectMass m_mass;
};
}  // namespace bullet_ccd::grasp
