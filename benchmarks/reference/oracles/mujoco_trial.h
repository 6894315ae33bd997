/// Trials of grasps in MuJoCo, by the protocols of our own trials: a second opinion.
#pragma once

#include "grasp/formats/mjcf_grasp_file.h"
#include "grasp/trial/grasp_trial.h"

#include <map>
#include <memory>
#include <mujoco/mujoco.h>
#include <utility>
#include <vector>

namespace bullet_ccd::reference
{
/// Pairs of geometries that MuJoCo did not compile.
struct PairMemory
{
    std::vector<int> numbers;
    std::vector<mjtNum> values;
};

/// A grasp, compiled once. It refers to hand and object. For one thread at a time.
class MujocoTrials
{
public:
    /// Pieces that do not come near each other on the way of this grasp take no part.
    /// @param squeeze  one of this grasp: the stiffness and efforts are those of the hand
    /// Throws std::runtime_error with what MuJoCo says of the model.
    MujocoTrials(const grasp::HandModel& hand,
                 const grasp::GraspObject& object,
                 const grasp::Grasp& grasp,
                 const grasp::Squeeze& squeeze,
                 const grasp::MjcfPieces& pieces);

    /// What grasp::runTrial() does, with its times, efforts and thresholds, for protocols without
    /// errors of the pose that load or lift, z up. The outcome has no forces, torques and
    /// penetration. Torsion is as in grasp::MjcfOptions.
    [[nodiscard]] grasp::TrialResult run(const grasp::Grasp& grasp,
                                         const grasp::Squeeze& squeeze,
                                         const grasp::TrialProtocol& protocol,
                                         double mass,
                                         double friction,
                                         double torsion);

private:
    void begin(const std::vector<double>& positions, double mass, double friction, double torsion);
    void drive(std::size_t joint, double effort, double target);
    void step(const Eigen::Vector3d& force);
    void refer();
    [[nodiscard]] Eigen::Vector3d center() const;
    [[nodiscard]] Eigen::Matrix3d axes() const;
    [[nodiscard]] double way() const { return (center() - m_center).norm(); }
    [[nodiscard]] double turned() const;
    [[nodiscard]] bool touches() const;
    [[nodiscard]] bool isAtRest() const;

    const grasp::HandModel& m_hand;
    const grasp::GraspObject& m_object;
    PairMemory m_pairMemory;  ///< of the model
    std::unique_ptr<mjModel, decltype(&mj_deleteModel)> m_model;
    std::unique_ptr<mjData, decltype(&mj_deleteData)> m_data;
    std::vector<std::int32_t> m_joints;
    std::vector<int> m_places;                   ///< in qpos, one entry per link
    std::map<std::pair<int, int>, int> m_pairs;  ///< by the numbers of their geometries
    int m_table;                ///< a plane that the object stands on where a protocol says so
    int m_body;                 ///< the object
    Eigen::Vector3d m_inertia;  ///< of 1 kg
    Eigen::Vector3d m_center;
    Eigen::Matrix3d m_axes;
};
}  // namespace bullet_ccd::reference
