#include "grasp/closing/closing_drives.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace bullet_ccd::grasp
{
std::vector<double> closingSpeeds(const HandModel& hand, const ClosingOptions& options)
{
    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> speeds = hand.closingSpeeds;
    speeds.resize(tree.size(), 1.0);
    for (const auto& [name, ratio] : options.speeds)
    {
        const std::int32_t link = tree.findJoint(name);
        require(link != kNone, "closing: a speed is given for a joint that the hand does not have");
        const auto i = static_cast<std::size_t>(link);
        require(hand.closingDirections[i] != 0 && tree.links[i].joint.mimicOf == kNone,
                "closing: a speed is given for a joint that does not close by itself");
        speeds[i] = ratio;
    }
    require(std::ranges::all_of(speeds,
                                [](double ratio) { return ratio > 0.0 && std::isfinite(ratio); }),
            "closing: speeds must be finite and > 0");
    return speeds;
}

ClosingDrives::ClosingDrives(const HandModel& hand,
                             const std::vector<double>& positions,
                             std::vector<std::int32_t> turns,
                             const std::vector<double>& speeds)
    : m_hand(hand), m_start(positions), m_turns(std::move(turns))
{
    const KinematicTree& tree = hand.robot.tree;
    require(positions.size() == tree.size(),
            "closing: positions: one entry a link is needed, as in the hand's preshapes");
    require(std::all_of(positions.begin(),
                        positions.end(),
                        [](double position) { return std::isfinite(position); }),
            "closing: a position of the hand is NaN or infinite");
    applyMimics(tree, m_start);
    m_closed = closedPositions(hand, m_start);
    m_positions = m_start;
    m_drives.resize(tree.size());
    m_speeds.assign(tree.size(), 0.0);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        const int direction = hand.closingDirections[i];
        if (!joint.isMovable() || joint.mimicOf != kNone || direction == 0)
        {
            continue;
        }
        Drive& drive = m_drives[i];
        const std::vector<double>& ratios = speeds.empty() ? hand.closingSpeeds : speeds;
        drive.speed =
            direction * (joint.type == JointType::Revolute ? kRevoluteSpeed : kPrismaticSpeed);
        drive.ratio = ratios.empty() ? 1.0 : ratios[i];
        drive.speed *= drive.ratio;
        drive.limitTime = (m_closed[i] - m_start[i]) / drive.speed;
        drive.waiting = drive.limitTime > 0.0;
    }
    beginNext();
}

void ClosingDrives::beginNext()
{
    if (isRunning())
    {
        return;
    }
    const auto turnOf = [&](std::size_t link) { return m_turns.empty() ? 0 : m_turns[link]; };
    constexpr std::int32_t kNoTurn = std::numeric_limits<std::int32_t>::max();
    std::int32_t turn = kNoTurn;
    for (std::size_t i = 0; i < m_drives.size(); ++i)
    {
        turn = m_drives[i].waiting ? std::min(turn, turnOf(i)) : turn;
    }
    for (std::size_t i = 0; i < m_drives.size() && turn != kNoTurn; ++i)
    {
        Drive& drive = m_drives[i];
        if (drive.waiting && turnOf(i) == turn)
        {
            drive.waiting = false;
            drive.running = true;
            drive.beginTime = m_time;
            drive.limitTime += m_time;
        }
    }
    const KinematicTree& tree = m_hand.robot.tree;
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const Drive& drive = m_drives[driverOf(i)];
        if (tree.links[i].joint.isMovable() && drive.running)
        {
            const double ratio = driverOf(i) == i ? 1.0 : tree.links[i].joint.mimicMultiplier;
            m_speeds[i] = ratio * drive.speed;
        }
    }
}

/// The joint that moves the joint above the link: itself or the one that it mimics.
std::size_t ClosingDrives::driverOf(std::size_t link) const
{
    const Joint& joint = m_hand.robot.tree.links[link].joint;
    return joint.mimicOf == kNone ? link : static_cast<std::size_t>(joint.mimicOf);
}

double ClosingDrives::nextLimit() const
{
    double next = std::numeric_limits<double>::infinity();
    for (const Drive& drive : m_drives)
    {
        if (drive.running)
        {
            next = std::min(next, drive.limitTime);
        }
    }
    return next;
}

double ClosingDrives::nextLimit(std::span<const std::int32_t> links) const
{
    double next = std::numeric_limits<double>::infinity();
    for (const std::int32_t link : links)
    {
        const Drive& drive = m_drives[driverOf(static_cast<std::size_t>(link))];
        if (drive.running)
        {
            next = std::min(next, drive.limitTime);
        }
    }
    return next;
}

bool ClosingDrives::isRunning() const
{
    return std::any_of(
        m_drives.begin(), m_drives.end(), [](const Drive& drive) { return drive.running; });
}

double ClosingDrives::pace() const
{
    double pace = 0.0;
    for (const Drive& drive : m_drives)
    {
        pace = drive.running ? std::max(pace, drive.ratio) : pace;
    }
    return pace > 0.0 ? pace : 1.0;
}

void ClosingDrives::positionsAt(double time, std::vector<double>& positions) const
{
    positions = m_positions;
    for (std::size_t i = 1; i < m_speeds.size(); ++i)
    {
        const Drive& drive = m_drives[driverOf(i)];
        if (m_speeds[i] != 0.0)
        {
            positions[i] = time < drive.limitTime
                               ? m_start[i] + m_speeds[i] * (time - drive.beginTime)
                               : m_closed[i];
        }
    }
}

void ClosingDrives::advanceTo(double time)
{
    positionsAt(time, m_positions);
    m_time = time;
    for (std::size_t driver = 0; driver < m_drives.size(); ++driver)
    {
        if (m_drives[driver].running && time >= m_drives[driver].limitTime)
        {
            stopDrive(driver);
        }
    }
}

void ClosingDrives::stopDrive(std::size_t driver)
{
    m_drives[driver].running = false;
    m_drives[driver].waiting = false;
    for (std::size_t i = 1; i < m_speeds.size(); ++i)
    {
        if (driverOf(i) == driver)
        {
            m_speeds[i] = 0.0;
        }
    }
}

bool ClosingDrives::stopLink(std::int32_t link, double time, bool byObject)
{
    const KinematicTree& tree = m_hand.robot.tree;
    // A link that another contact at this very time has stopped is in contact all the same.
    bool stopped = !m_stops.empty() && m_stops.back().time == time;
    for (std::int32_t i = link; i > 0; i = tree.links[static_cast<std::size_t>(i)].parent)
    {
        const std::size_t driver = driverOf(static_cast<std::size_t>(i));
        if (m_drives[driver].running || m_drives[driver].waiting)
        {
            stopDrive(driver);
            stopped = true;
        }
    }
    const bool known = std::any_of(
        m_stops.begin(), m_stops.end(), [&](const StopEvent& event) { return event.link == link; });
    if (!stopped || known)
    {
        return false;
    }
    m_stops.push_back({.link = link, .time = time, .byObject = byObject});
    return true;
}
}  // namespace bullet_ccd::grasp
