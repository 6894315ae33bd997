/// What trials looked like: strips of pictures and animations.
#pragma once

#include "grasp/trial/grasp_trial.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
/// The moments of one trial, 30 of them a second of simulated time; of pulls those of the first.
class TrialFilm
{
public:
    /// In the order in which the trial gives them.
    void take(const grasp::TrialFrame& frame);
    [[nodiscard]] bool isEmpty() const { return m_frames.empty(); }

    /// Writes NAME.png (four moments: the start, the first contact of the hand, the end of the
    /// squeeze, the end) and NAME.glb, an animation. Throws std::runtime_error if a file cannot be
    /// written.
    /// @param up  [W]; with it the object stands on a table at the start
    void write(const std::filesystem::path& folder,
               const std::string& name,
               const grasp::HandModel& hand,
               const grasp::GraspObject& object,
               const std::optional<Eigen::Vector3d>& up) const;

private:
    std::vector<grasp::TrialFrame> m_frames;
    grasp::TrialFrame m_last;  ///< may not be among them
    std::size_t m_contact = 0;
    std::size_t m_squeezed = 0;
};
}  // namespace bullet_ccd::tools
