#include "tests/bullet/path_judge.h"

#include "tests/oracles/brute_force_distance.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bullet_ccd::tests
{
namespace
{
/// Between two samples no probe moves farther than this [m], nor turns farther than that [rad].
constexpr double kSampleLength = 0.001;
constexpr double kSampleAngle = 0.03;
constexpr int kMaxSamples = 2000;

Eigen::Isometry3d screw(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double s)
{
    const Eigen::AngleAxisd turn(Eigen::Quaterniond(to.linear() * from.linear().transpose()));
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = Eigen::AngleAxisd(s * turn.angle(), turn.axis()) * from.linear();
    result.translation() = (1.0 - s) * from.translation() + s * to.translation();
    return result;
}

Snapshot between(const Snapshot& from, const Snapshot& to, double s)
{
    Snapshot result = to;
    for (std::size_t i = 0; i < to.poses.size(); ++i)
    {
        result.poses[i] = screw(from.poses[i], to.poses[i], s);
    }
    for (std::size_t i = 0; i < to.joints.size(); ++i)
    {
        result.joints[i] = (1.0 - s) * from.joints[i] + s * to.joints[i];
    }
    return result;
}

std::vector<Eigen::Vector3d> probesInPlate(const Watched& watched, const Snapshot& snapshot)
{
    const WatchedPoses poses = watched.place(snapshot);
    const Eigen::Isometry3d X_PM = poses.X_WP.inverse() * poses.X_WM;
    std::vector<Eigen::Vector3d> points;
    points.reserve(watched.probes.size());
    for (const Eigen::Vector3d& probe : watched.probes)
    {
        points.push_back(X_PM * probe);
    }
    return points;
}

bool crosses(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector2d& half)
{
    if ((from.z() < 0.0) == (to.z() < 0.0))
    {
        return false;
    }
    const Eigen::Vector3d at = from + (to - from) * (from.z() / (from.z() - to.z()));
    return std::abs(at.x()) < half.x() && std::abs(at.y()) < half.y();
}

int samplesOf(const Watched& watched, const Snapshot& from, const Snapshot& to)
{
    // A quarter turn may bring a probe back to where it was: angles count on their own.
    double angle = 0.0;
    for (std::size_t i = 0; i < to.poses.size(); ++i)
    {
        angle = std::max(angle,
                         Eigen::Quaterniond(from.poses[i].linear())
                             .angularDistance(Eigen::Quaterniond(to.poses[i].linear())));
    }
    for (std::size_t i = 0; i < to.joints.size(); ++i)
    {
        angle = std::max(angle, std::abs(to.joints[i] - from.joints[i]));
    }
    const std::vector<Eigen::Vector3d> start = probesInPlate(watched, from);
    const std::vector<Eigen::Vector3d> end = probesInPlate(watched, to);
    double length = 0.0;
    for (std::size_t i = 0; i < start.size(); ++i)
    {
        length = std::max(length, (end[i] - start[i]).norm());
    }
    const double samples = std::max(length / kSampleLength, angle / kSampleAngle);
    return std::clamp(static_cast<int>(std::ceil(samples)), 1, kMaxSamples);
}
}  // namespace

PathJudge::PathJudge(Watched watched) : m_watched(std::move(watched)), m_before(m_watched.read(0.0))
{
}

void PathJudge::record(double sinceStep)
{
    const Snapshot now = m_watched.read(sinceStep);
    if (!m_through)
    {
        watchWay(now);
    }
    if (m_measure)
    {
        noteDistance(now);
    }
    m_before = now;
}

void PathJudge::watchWay(const Snapshot& after)
{
    const int samples = samplesOf(m_watched, m_before, after);
    std::vector<Eigen::Vector3d> last = probesInPlate(m_watched, m_before);
    for (int i = 1; i <= samples && !m_through; ++i)
    {
        const double s = static_cast<double>(i) / samples;
        std::vector<Eigen::Vector3d> next = probesInPlate(m_watched, between(m_before, after, s));
        for (std::size_t k = 0; k < next.size(); ++k)
        {
            m_through = m_through || crosses(last[k], next[k], m_watched.plateHalf);
        }
        last = std::move(next);
    }
}

void PathJudge::noteDistance(const Snapshot& now)
{
    const WatchedPoses poses = m_watched.place(now);
    const Eigen::Isometry3d X_SM = poses.X_WS.inverse() * poses.X_WM;
    const double distance =
        bruteForceMeshDistance(m_watched.mover, m_watched.plate, X_SM).distance -
        m_watched.plateRadius - m_watched.moverRadius;
    m_closest = std::min(m_closest, std::max(distance, 0.0));
}
}  // namespace bullet_ccd::tests
