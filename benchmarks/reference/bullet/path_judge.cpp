#include "benchmarks/reference/bullet/path_judge.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
/// Between two samples no probe moves farther than this [m], nor turns farther than that [rad].
constexpr double kSampleLength = 0.001;
constexpr double kSampleAngle = 0.03;
constexpr int kMaxSamples = 2000;

/// The turn of a body between two records as angle times axis. Two poses do not tell whole turns;
/// the spin does, unless the integrator has cut it off.
Eigen::Vector3d turnBetween(const Eigen::Isometry3d& from,
                            const Eigen::Isometry3d& to,
                            const Eigen::Vector3d& spunAngle)
{
    constexpr double kTurn = 2.0 * std::numbers::pi;
    const Eigen::AngleAxisd shortest(Eigen::Quaterniond(to.linear() * from.linear().transpose()));
    const double whole = spunAngle.norm();
    // A body that is held keeps its spin and its pose.
    if (whole < std::numbers::pi || from.matrix() == to.matrix())
    {
        return shortest.angle() * shortest.axis();
    }
    const Eigen::Vector3d axis = spunAngle / whole;
    const double angle = shortest.angle() * (shortest.axis().dot(axis) < 0.0 ? -1.0 : 1.0);
    const double turned = angle + kTurn * std::round((whole - angle) / kTurn);
    return std::abs(turned - whole) < 0.01 ? Eigen::Vector3d(turned * axis)
                                           : Eigen::Vector3d(shortest.angle() * shortest.axis());
}

/// All that happened between two records.
struct Way
{
    Snapshot from;
    Snapshot to;
    std::vector<Eigen::Vector3d> turns;
};

Way wayBetween(const Snapshot& from, const Snapshot& to, double duration)
{
    Way way{from, to, {}};
    for (std::size_t i = 0; i < to.poses.size(); ++i)
    {
        const Eigen::Vector3d spin = i < to.spins.size() ? to.spins[i] : Eigen::Vector3d::Zero();
        way.turns.push_back(turnBetween(from.poses[i], to.poses[i], duration * spin));
    }
    return way;
}

Snapshot at(const Way& way, double s)
{
    Snapshot result = way.to;
    for (std::size_t i = 0; i < way.turns.size() && s < 1.0; ++i)
    {
        const Eigen::Isometry3d& start = way.from.poses[i];
        const double angle = way.turns[i].norm();
        if (angle > 0.0)
        {
            result.poses[i].linear() =
                Eigen::AngleAxisd(s * angle, way.turns[i] / angle) * start.linear();
        }
        result.poses[i].translation() =
            (1.0 - s) * start.translation() + s * way.to.poses[i].translation();
    }
    for (std::size_t i = 0; i < way.to.joints.size(); ++i)
    {
        result.joints[i] = (1.0 - s) * way.from.joints[i] + s * way.to.joints[i];
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

int samplesOf(const Watched& watched, const Way& way)
{
    // A turn may bring a probe back to where it was: angles count on their own.
    double angle = 0.0;
    for (const Eigen::Vector3d& turn : way.turns)
    {
        angle = std::max(angle, turn.norm());
    }
    for (std::size_t i = 0; i < way.to.joints.size(); ++i)
    {
        angle = std::max(angle, std::abs(way.to.joints[i] - way.from.joints[i]));
    }
    const std::vector<Eigen::Vector3d> start = probesInPlate(watched, way.from);
    const std::vector<Eigen::Vector3d> end = probesInPlate(watched, way.to);
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

void PathJudge::record(double sinceStep, bool isStepEnd)
{
    const Snapshot now = m_watched.read(sinceStep);
    if (!m_through)
    {
        watchWay(now, sinceStep - m_beforeTime);
    }
    if (m_measure)
    {
        noteDistance(now);
    }
    m_before = now;
    m_beforeTime = isStepEnd ? 0.0 : sinceStep;
}

void PathJudge::watchWay(const Snapshot& after, double duration)
{
    const Way way = wayBetween(m_before, after, m_wholeTurns ? duration : 0.0);
    const int samples = samplesOf(m_watched, way);
    std::vector<Eigen::Vector3d> last = probesInPlate(m_watched, m_before);
    for (int i = 1; i <= samples && !m_through; ++i)
    {
        const double s = static_cast<double>(i) / samples;
        std::vector<Eigen::Vector3d> next = probesInPlate(m_watched, at(way, s));
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
}  // namespace bullet_ccd::reference
