#include "tools/grasp_cli/answers/trial_films.h"

#include "grasp/report/grasp_model.h"
#include "grasp/report/grasp_picture.h"
#include "grasp/report/grasp_scene.h"
#include "tools/grasp_cli/inputs/table_under.h"

#include <algorithm>
#include <array>
#include <limits>

namespace bullet_ccd::tools
{
namespace
{
constexpr double kInterval = 1.0 / 30.0;  // [s]
}  // namespace

void TrialFilm::take(const grasp::TrialFrame& frame)
{
    if (frame.time <= m_last.time)
    {
        return;  // another pull
    }
    if (m_frames.empty() || frame.time >= m_frames.back().time + kInterval)
    {
        m_frames.push_back(frame);
    }
    m_last = frame;
    const std::size_t now = m_frames.size() - 1;
    m_contact = m_contact == 0 && frame.touches && frame.stage != "stand" ? now : m_contact;
    m_squeezed = frame.stage == "load" ? m_squeezed : now;
}

void TrialFilm::write(const std::filesystem::path& folder,
                      const std::string& name,
                      const grasp::HandModel& hand,
                      const grasp::GraspObject& object,
                      const std::optional<Eigen::Vector3d>& up) const
{
    std::vector<Obstacle> tables;
    if (up)
    {
        tables.push_back(shownTableUnder(object, *up));
    }
    const std::vector<RigidBody> beside = bodiesOf(tables);
    std::vector<grasp::Moment> moments;
    for (const grasp::TrialFrame* frame :
         {&m_frames.front(), &m_frames[m_contact], &m_frames[m_squeezed], &m_last})
    {
        moments.push_back(
            {.X_WH = frame->X_WH, .positions = frame->positions, .X_WO = frame->X_WO});
    }
    grasp::drawMoments(hand,
                       object,
                       moments,
                       {.width = 1600, .height = 480, .obstacles = beside},
                       folder / (name + ".png"));
    std::vector<float> times;
    std::vector<grasp::MotionTrack> tracks;
    for (std::size_t link = 0; link < hand.linkTrees.size(); ++link)
    {
        tracks.push_back({.name = hand.robot.tree.links[link].name,
                          .tree = hand.linkTrees[link],
                          .color = grasp::colorOf(hand, static_cast<std::int32_t>(link)),
                          .poses = {}});
    }
    grasp::MotionTrack moving{.name = "object: " + object.name,
                              .tree = &object.tree,
                              .color = grasp::kObjectColor,
                              .poses = {}};
    for (const grasp::TrialFrame& frame : m_frames)
    {
        const std::vector<Eigen::Isometry3d> poses =
            linkPoses(hand.robot.tree, frame.X_WH, frame.positions);
        for (std::size_t link = 0; link < poses.size(); ++link)
        {
            tracks[link].poses.push_back(poses[link]);
        }
        moving.poses.push_back(frame.X_WO);
        times.push_back(static_cast<float>(frame.time));
    }
    tracks.push_back(std::move(moving));
    for (const RigidBody& body : beside)
    {
        tracks.push_back({.name = "table",
                          .tree = body.tree,
                          .color = grasp::kObstacleColor,
                          .poses = {body.motion.X_W0}});
    }
    std::erase_if(tracks, [](const grasp::MotionTrack& track) { return track.tree == nullptr; });
    grasp::writeMotionModel("trial", times, tracks, folder / (name + ".glb"));
}
}  // namespace bullet_ccd::tools
