/// Judges from outside whether one body went through another: only positions that Bullet commits
/// are read, none of the code under test is asked.
///
/// Two bodies are watched, a plate (or what can be taken for one) and a mover. Between two records
/// the motion is what Bullet integrates: a screw of a free body, a straight line in joint
/// positions. That path is sampled finely; a point inside the mover that crosses the middle of the
/// plate within its edges has gone through, a mover that bounced back has not. Whether they have
/// come near at all is seen from the distance of all triangles at the records.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <functional>
#include <vector>

namespace bullet_ccd::reference
{
/// All that moves in a scene, at one moment.
struct Snapshot
{
    std::vector<Eigen::Isometry3d> poses = {};  ///< free bodies, about their centres of mass
    /// What the bodies turned with since the last record [rad/s]; may be left out where that is
    /// less than half a turn.
    std::vector<Eigen::Vector3d> spins = {};
    std::vector<double> joints = {};
};

/// Poses in the world.
struct WatchedPoses
{
    Eigen::Isometry3d X_WP = Eigen::Isometry3d::Identity();  ///< the plate: its middle is z = 0
    Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();  ///< the plate's surface
    Eigen::Isometry3d X_WM = Eigen::Isometry3d::Identity();  ///< the mover
};

struct Watched
{
    std::function<Snapshot(double)> read;  ///< at a time since the step began [s]
    std::function<WatchedPoses(const Snapshot&)> place;
    Eigen::Vector2d plateHalf = Eigen::Vector2d::Zero();  ///< of the middle, along x and y
    std::vector<Eigen::Vector3d> probes = {};             ///< points inside the mover
    // Surfaces: all points within the radius of the triangles; only for the distance.
    TriangleMesh plate = {};
    TriangleMesh mover = {};
    double plateRadius = 0.0;
    double moverRadius = 0.0;
};

class PathJudge
{
public:
    /// Records the start.
    explicit PathJudge(Watched watched);

    /// At the end of a step, and at any moment within at which velocities change.
    /// @param sinceStep since the step began [s]
    void record(double sinceStep, bool isStepEnd);
    /// When the program has moved something, before the step: Bullet looks for contacts with it
    /// where it will be when the step ends.
    void recordContacts(double timeStep)
    {
        if (m_measure)
        {
            noteDistance(m_watched.read(timeStep));
        }
    }
    [[nodiscard]] bool isThrough() const { return m_through; }
    /// Smallest distance of the surfaces at a record of either kind so far [m]; 0 if they cross.
    [[nodiscard]] double closest() const { return m_closest; }
    /// Off where nobody asks for the distance: it is slow.
    void measureDistance(bool on) { m_measure = on; }
    /// On where bodies may turn more than half a turn between two records; Bullet's own step turns
    /// none by as much, whatever its spin.
    void expectWholeTurns(bool on) { m_wholeTurns = on; }

private:
    Watched m_watched;
    Snapshot m_before;
    double m_beforeTime = 0.0;  // since its step began, 0 if the step has ended [s]
    bool m_through = false;
    bool m_measure = true;
    bool m_wholeTurns = false;
    double m_closest = 1e9;

    void watchWay(const Snapshot& after, double duration);
    void noteDistance(const Snapshot& now);
};
}  // namespace bullet_ccd::reference
