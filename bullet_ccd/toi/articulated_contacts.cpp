#include "bullet_ccd/math/check.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <algorithm>

namespace bullet_ccd
{
namespace
{
/// The sequence in hand.
class Sequence
{
public:
    Sequence(const ArticulatedBody& body,
             std::span<const RigidBody> obstacles,
             const ContactSequenceOptions& options,
             ToiWorkspace& work)
        : m_body(body),
          m_obstacles(obstacles),
          m_rule(options.rule),
          m_query(options.query),
          m_work(work),
          m_rest(*body.motion)
    {
        m_query.toi.aim = std::max(m_query.toi.aim, 0.5);
        m_result.stopTimes.assign(body.tree->size(), 1.0);
    }

    ContactSequence run()
    {
        const Environment environment(m_obstacles);
        double elapsed = 0.0;
        bool goesOn = step(environment, elapsed);
        while (goesOn)
        {
            goesOn = elapsed < 1.0 && isMoving() && stepFrom(environment, elapsed);
        }
        finish(elapsed);
        return std::move(m_result);
    }

private:
    /// The environment is made anew only if it moves.
    bool stepFrom(const Environment& environment, double& elapsed)
    {
        if (environment.movingCount() == 0)
        {
            return step(environment, elapsed);
        }
        std::vector<RigidBody> later(m_obstacles.begin(), m_obstacles.end());
        for (RigidBody& obstacle : later)
        {
            obstacle.motion = partOf(obstacle.motion, elapsed, 1.0);
        }
        return step(Environment(later), elapsed);
    }

    /// One query over what is left of the step. Returns false where the sequence ends.
    bool step(const Environment& environment, double& elapsed)
    {
        ArticulatedBody body = m_body;
        body.motion = &m_rest;
        const ArticulatedToiResult found = articulatedToi(body, environment, m_query, m_work);
        ++m_result.queries;
        m_result.counters += found.counters;
        const double left = 1.0 - elapsed;
        if (found.status == ToiStatus::Separated)
        {
            m_rest = partOf(m_rest, 1.0, 2.0);
            elapsed = 1.0;
            return false;
        }
        m_rest = partOf(m_rest, found.time, 1.0);  // what remains, still over [0, 1]
        elapsed += found.time * left;
        m_result.status = found.status;
        bool stopsSome = false;
        for (LinkContact contact : found.contacts)
        {
            contact.time = elapsed;
            m_result.contacts.push_back(contact);
            stopsSome = stop(contact, elapsed) || stopsSome;
        }
        // Where nothing can stop any more, an obstacle presses on: the motion ends there.
        return found.status == ToiStatus::Hit && stopsSome;
    }

    /// Stops what the rule says; false if all of that rests already.
    bool stop(const LinkContact& contact, double time)
    {
        if (m_rule == StopRule::NearestJoint)
        {
            return stopJoint(contact.stopJoint, time);
        }
        const KinematicTree& tree = *m_body.tree;
        const std::int32_t top = contact.otherLink == kNone
                                     ? kNone
                                     : commonAncestor(tree, contact.link, contact.otherLink);
        bool stopsSome = false;
        for (const std::int32_t link : {contact.link, contact.otherLink})
        {
            for (std::int32_t k = link; k != top && k != kNone;
                 k = tree.links[static_cast<std::size_t>(k)].parent)
            {
                stopsSome = stopJoint(k, time) || stopsSome;
            }
        }
        return stopsSome;
    }

    /// The joint, and all that it is coupled to.
    bool stopJoint(std::int32_t link, double time)
    {
        if (link == kNone)
        {
            return false;
        }
        bool stopsSome = false;
        const Joint& joint = m_body.tree->links[static_cast<std::size_t>(link)].joint;
        const std::int32_t driver = joint.mimicOf != kNone ? joint.mimicOf : link;
        for (std::int32_t k = 0; k < static_cast<std::int32_t>(m_body.tree->size()); ++k)
        {
            const auto index = static_cast<std::size_t>(k);
            if (k == driver || m_body.tree->links[index].joint.mimicOf == driver)
            {
                if (!rests(k))
                {
                    rest(k);
                    m_result.stopTimes[index] = time;
                    stopsSome = true;
                }
            }
        }
        return stopsSome;
    }

    /// True if the joint above the link does not move; for the root, if that does not.
    [[nodiscard]] bool rests(std::int32_t link) const
    {
        const auto index = static_cast<std::size_t>(link);
        const Link& here = m_body.tree->links[index];
        if (here.parent == kNone)
        {
            return m_rest.root.v_W.isZero(0.0) && m_rest.root.w_W.isZero(0.0);
        }
        return here.joint.type == JointType::Spherical ? m_rest.ball(link).rate.isZero(0.0)
                                                       : m_rest.path(link).isConstant();
    }

    void rest(std::int32_t link)
    {
        const auto index = static_cast<std::size_t>(link);
        m_rest.setPath(link, {{m_rest.positions[index]}});
        if (!m_rest.balls.empty())
        {
            m_rest.balls[index].rate.setZero();
        }
        if (m_body.tree->links[index].parent == kNone)
        {
            m_rest.root = restAt(m_rest.root.X_W0);
        }
    }

    [[nodiscard]] bool isMoving() const
    {
        for (std::int32_t link = 0; link < static_cast<std::int32_t>(m_body.tree->size()); ++link)
        {
            if (!rests(link))
            {
                return true;
            }
        }
        return std::any_of(
            m_obstacles.begin(),
            m_obstacles.end(),
            [](const RigidBody& obstacle)
            { return !obstacle.motion.v_W.isZero(0.0) || !obstacle.motion.w_W.isZero(0.0); });
    }

    void finish(double elapsed)
    {
        m_result.time = isMoving() ? elapsed : 1.0;
        for (std::int32_t link = 0; link < static_cast<std::int32_t>(m_body.tree->size()); ++link)
        {
            rest(link);
        }
        m_result.end = m_rest;
    }

    const ArticulatedBody& m_body;
    std::span<const RigidBody> m_obstacles;
    StopRule m_rule;
    ArticulatedToiOptions m_query;
    ToiWorkspace& m_work;
    JointMotion m_rest;  ///< what is left of the motion, over [0, 1]
    ContactSequence m_result;
};
}  // namespace

ContactSequence articulatedContacts(const ArticulatedBody& body,
                                    std::span<const RigidBody> obstacles,
                                    const ContactSequenceOptions& options,
                                    ToiWorkspace& work)
{
    for (const RigidBody& obstacle : obstacles)
    {
        require(obstacle.userMotion == nullptr,
                "articulatedContacts: an obstacle has a motion supplied by the user, which cannot "
                "be cut where a contact is: give it a RigidMotion");
    }
    return Sequence(body, obstacles, options, work).run();
}
}  // namespace bullet_ccd
