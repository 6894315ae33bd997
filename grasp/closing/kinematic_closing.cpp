#include "bullet_ccd/math/check.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "grasp/closing/closing.h"
#include "grasp/closing/closing_drives.h"
#include "grasp/closing/closing_groups.h"
#include "grasp/closing/swept_boxes.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// Index in the environment; obstacles come after it.
constexpr std::int32_t kObject = 0;
/// So many are remembered: hands have fewer, but a caller may bring his own.
constexpr std::size_t kMaxPreshapes = 32;
constexpr double kNever = std::numeric_limits<double>::infinity();

/// What stops a group next.
struct Event
{
    double time = kNever;  ///< since closing began [s]
    ToiStatus status = ToiStatus::Separated;
    std::vector<LinkContact> contacts;  ///< none: a joint is at its limit
};

/// One closing. Every group has its next event; only those that an event changes are asked again.
class Closing
{
public:
    Closing(const HandModel& hand,
            const ClosingGroups& groups,
            const Environment& environment,
            const Eigen::Isometry3d& X_WH,
            const ClosingOptions& options,
            ClosingDrives& drives,
            ToiWorkspace& work)
        : m_hand(hand),
          m_groups(groups),
          m_environment(environment),
          m_drives(drives),
          m_work(work),
          // A query stops half a tolerance short: there is room to go on from. A tolerance that is
          // coarser than usual is an accuracy: nothing is looked at more closely.
          m_query{.toi = {.tolerance = options.tolerance,
                          .aim = 0.5,
                          .anyWithin = options.tolerance > kDefaultTolerance}},
          m_events(groups.groups.size())
    {
        m_motion.root = restAt(X_WH);
    }

    ClosingResult run()
    {
        for (std::size_t group = 0; group < m_events.size(); ++group)
        {
            ask(group);
        }
        while (!m_failed && m_drives.isRunning())
        {
            const auto next =
                std::min_element(m_events.begin(),
                                 m_events.end(),
                                 [](const Event& a, const Event& b) { return a.time < b.time; });
            Event event = crossing(next->time);
            if (event.time == kNever)
            {
                event = *next;
            }
            const std::vector<double> before = m_drives.speeds();
            take(event);
            m_failed = m_failed || m_drives.speeds() == before;
            m_drives.beginNext();
            askChanged(before);
        }
        m_result.positions = m_drives.positions();
        m_result.stops = m_drives.stops();
        return std::move(m_result);
    }

private:
    /// The motion of some links, the others at rest, from the present time to `end`.
    template <typename IsMoving>
    void setMotion(double end, const IsMoving& isMoving)
    {
        m_drives.positionsAt(m_time, m_motion.positions);
        m_motion.rates = m_drives.speeds();
        for (std::size_t link = 0; link < m_motion.rates.size(); ++link)
        {
            m_motion.rates[link] *= isMoving(m_groups.groupOf[link]) ? end - m_time : 0.0;
        }
    }

    Event askFor(std::span<const SsvTree* const> trees,
                 std::span<const LinkPair> pairs,
                 const Environment& environment,
                 double end)
    {
        const ArticulatedBody body{.tree = &m_hand.robot.tree,
                                   .linkTrees = trees,
                                   .motion = &m_motion,
                                   .selfPairs = pairs};
        ArticulatedToiResult found = articulatedToi(body, environment, m_query, m_work);
        ++m_result.steps;
        m_result.counters += found.counters;
        const bool ends = isContact(found.status) || gaveUp(found.status);
        return {.time = ends ? m_time + found.time * (end - m_time) : end,
                .status = found.status,
                .contacts = std::move(found.contacts)};
    }

    /// What a group meets if it goes on as it does now.
    void ask(std::size_t index)
    {
        const ClosingGroup& group = m_groups.groups[index];
        Event& event = m_events[index];
        const double end = m_drives.nextLimit(group.links);
        event = {};
        if (end < kNever)
        {
            setMotion(end, [&](std::int32_t g) { return g == static_cast<std::int32_t>(index); });
            event = askFor(group.linkTrees, group.selfPairs, m_environment, end);
        }
    }

    /// Contact of two groups between now and `end`.
    Event crossing(double end)
    {
        if (m_groups.crossPairs.empty() || !(end > m_time))
        {
            return {};
        }
        setMotion(end, [](std::int32_t g) { return g != kNone; });
        Event event = askFor(m_groups.crossTrees, m_groups.crossPairs, m_nothing, end);
        return isContact(event.status) || gaveUp(event.status) ? event : Event{};
    }

    void take(const Event& event)
    {
        m_time = event.time;
        m_drives.advanceTo(m_time);
        if (event.status == ToiStatus::Overlapping || gaveUp(event.status))
        {
            m_result.status = event.status;
            m_failed = true;
            return;
        }
        if (isContact(event.status))
        {
            m_result.status = ToiStatus::Hit;
            for (const LinkContact& contact : event.contacts)
            {
                const bool byObject = contact.obstacle == kObject;
                if (m_drives.stopLink(contact.link, m_time, byObject) && byObject)
                {
                    m_result.contacts.push_back({.link = contact.link,
                                                 .point = contact.pointOther,
                                                 .normal = contact.normal,
                                                 .gap = contact.gap});
                }
                m_result.touchedObstacle = m_result.touchedObstacle || contact.obstacle > kObject;
                if (contact.otherLink != kNone)
                {
                    m_drives.stopLink(contact.otherLink, m_time, false);
                }
            }
        }
    }

    void askChanged(const std::vector<double>& before)
    {
        for (std::size_t index = 0; index < m_events.size() && !m_failed; ++index)
        {
            const std::vector<std::int32_t>& links = m_groups.groups[index].links;
            const bool changed = std::any_of(links.begin(),
                                             links.end(),
                                             [&](std::int32_t link)
                                             {
                                                 const auto i = static_cast<std::size_t>(link);
                                                 return before[i] != m_drives.speeds()[i];
                                             });
            if (changed)
            {
                ask(index);
            }
        }
    }

    const HandModel& m_hand;
    const ClosingGroups& m_groups;
    const Environment& m_environment;
    const Environment m_nothing;
    ClosingDrives& m_drives;
    ToiWorkspace& m_work;
    ArticulatedToiOptions m_query;
    JointMotion m_motion;
    std::vector<Event> m_events;  // one a group
    double m_time = 0.0;
    bool m_failed = false;
    ClosingResult m_result;
};

/// What is kept from closing to closing.
class Engine
{
public:
    Engine(std::span<const RigidBody> obstacles, ModelUse* use) : m_obstacles(obstacles)
    {
        noteModelUse(m_work, use);
    }

    ClosingResult close(const HandModel& hand,
                        const GraspObject& object,
                        const Eigen::Isometry3d& X_WH,
                        const std::vector<double>& positions,
                        const ClosingOptions& options)
    {
        require(X_WH.matrix().allFinite(), "closing: the pose of the hand is NaN or infinite");
        require(options.tolerance > 0.0, "closing: the tolerance must be positive");
        lookAt(hand, object);
        ClosingDrives drives(
            hand, positions, closingTurns(hand, m_groups, options), closingSpeeds(hand, options));
        if (!m_obstacles.empty())
        {
            findNeighbours(X_WH, drives.positions());
        }
        if (handOverlaps(hand, object, X_WH, drives.positions()))
        {
            return {.status = ToiStatus::Overlapping, .positions = drives.positions(), .stops = {}};
        }
        return Closing(hand, m_groups, m_environment, X_WH, options, drives, m_work).run();
    }

private:
    void lookAt(const HandModel& hand, const GraspObject& object)
    {
        if (m_hand == &hand && m_bodies.front().tree == &object.tree)
        {
            return;
        }
        m_hand = &hand;
        m_bodies = {{.tree = &object.tree, .motion = {}}};
        m_environment.reset(m_bodies);
        m_groups = closingGroups(hand);
        m_boxes.clear();
    }

    const SweptBoxes& boxesOf(const std::vector<double>& preshape)
    {
        const auto known = std::find_if(m_boxes.begin(),
                                        m_boxes.end(),
                                        [&](const auto& entry) { return entry.first == preshape; });
        if (known != m_boxes.end())
        {
            return known->second;
        }
        if (m_boxes.size() == kMaxPreshapes)
        {
            m_boxes.clear();
        }
        return m_boxes.emplace_back(preshape, sweptBoxes(*m_hand, preshape)).second;
    }

    /// Of the obstacles only those stay that the hand can reach at all.
    void findNeighbours(const Eigen::Isometry3d& X_WH, const std::vector<double>& preshape)
    {
        std::vector<std::int32_t> near =
            reachable(boxesOf(preshape), X_WH, Eigen::Vector3d::Zero(), m_obstacles);
        if (near != m_near || m_bodies.size() != near.size() + 1)
        {
            m_near = std::move(near);
            m_bodies.resize(1);
            for (const std::int32_t index : m_near)
            {
                m_bodies.push_back(m_obstacles[static_cast<std::size_t>(index)]);
            }
            m_environment.reset(m_bodies);
        }
    }

    std::span<const RigidBody> m_obstacles;
    const HandModel* m_hand = nullptr;
    std::vector<std::pair<std::vector<double>, SweptBoxes>> m_boxes;  // by preshape
    std::vector<std::int32_t> m_near;                                 // obstacles among the bodies
    std::vector<RigidBody> m_bodies;                                  // the object first
    Environment m_environment;
    ClosingGroups m_groups;
    ToiWorkspace m_work;
};
}  // namespace

CloseHand kinematicClosing(std::span<const RigidBody> obstacles, ModelUse* use)
{
    return [engine = std::make_shared<Engine>(obstacles, use)](const HandModel& hand,
                                                               const GraspObject& object,
                                                               const Eigen::Isometry3d& X_WH,
                                                               const std::vector<double>& positions,
                                                               const ClosingOptions& options)
    { return engine->close(hand, object, X_WH, positions, options); };
}
}  // namespace bullet_ccd::grasp
