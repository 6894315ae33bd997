/// What Bullet's solver moves beside the velocities.
#ifndef BT_CCD_PUSHES_H
#define BT_CCD_PUSHES_H

#include "bullet_ccd/bullet/step/btCcdBody.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <utility>
#include <vector>

/// With split impulses, which are Bullet's default, the solver of a step pushes rigid bodies out of
/// contacts that are deeper than m_splitImpulsePenetrationThreshold: it changes their poses before
/// they are integrated. Here is how they got where they are.
class btCcdPushes
{
public:
    struct Push
    {
        btRigidBody* m_body;
        btTransform m_from;
        btVector3 m_linear;  // that take it there in the time of the step
        btVector3 m_angular;
        btVector3 m_ownLinear;  // when it was found
        btVector3 m_ownAngular;
    };

    explicit btCcdPushes(btDiscreteDynamicsWorld& world) : m_world(world) {}

    /// Remembers the poses of what the solver of this step, which is about to begin, may push. For
    /// worlds, which know when that is.
    void noteBeforeSolving();
    /// Remembers all poses, at the end of a step, if anything touches, or may be deep in contact in
    /// the next step without having touched in this one. Not needed by who notes them before the
    /// solver begins.
    /// @param kinematic there are objects that move so: contacts see them where they will be
    void noteEnd(bool kinematic)
    {
        if (m_isNotedBefore)
        {
            return;
        }
        if (mayPush() || (kinematic && m_world.getSolverInfo().m_splitImpulse != 0))
        {
            notePoses();
        }
        else
        {
            m_ends.clear();
        }
    }
    /// This body is where it is for another reason.
    void forget(const btCollisionObject& object);
    /// Finds what has been moved since then and has contacts so deep that they may have done it: no
    /// farther than twice the deepest. What is farther off has been put there by the user.
    /// @param integrated the velocities have been, too: they are part of the motion
    [[nodiscard]] const std::vector<Push>& find(btScalar timeStep, bool integrated)
    {
        m_pushes.clear();
        m_far.clear();
        if (!m_isNotedBefore)
        {
            findDeep();
        }
        for (const Deep& deep : m_deep)
        {
            look(deep, timeStep, integrated);
        }
        return m_pushes;
    }
    [[nodiscard]] const std::vector<Push>& found() const { return m_pushes; }
    /// What has the velocity of its push, while btCcdPushed lives, gets its own.
    void giveOwnVelocity(const btCollisionObject& object) const;
    /// What may have been pushed farther than half of gContactBreakingThreshold, or from where is
    /// not known; after find().
    [[nodiscard]] const std::vector<const btRigidBody*>& far() const { return m_far; }

private:
    struct End
    {
        const btRigidBody* m_body = nullptr;
        btTransform m_pose;
        bool m_isLooked = false;  // in this step
    };

    /// A body in a contact that the solver may push it out of.
    struct Deep
    {
        btRigidBody* m_body;
        btScalar m_depth;
    };

    btDiscreteDynamicsWorld& m_world;
    std::vector<End> m_ends;   // of what Bullet moves, by index in the world
    std::vector<Deep> m_deep;  // in this step, once for every contact
    bool m_isNotedBefore = false;
    std::vector<Push> m_pushes;
    std::vector<const btRigidBody*> m_far;

    [[nodiscard]] bool mayPush() const
    {
        return m_world.getSolverInfo().m_splitImpulse != 0 &&
               m_world.getDispatcher()->getNumManifolds() != 0;
    }
    void notePoses();
    [[nodiscard]] End* endOf(const btCollisionObject& object);
    [[nodiscard]] static bool isNear(const btRigidBody& body, const btTransform& pose);
    void findDeep()
    {
        m_deep.clear();
        if (mayPush())
        {
            findDeepOnes();
        }
    }
    void findDeepOnes();
    void look(const Deep& deep, btScalar timeStep, bool integrated);
};

/// While this lives, the bodies have the velocities of the pushes, and, if so wanted, everything
/// else is at rest.
class btCcdPushed
{
public:
    btCcdPushed(btDiscreteDynamicsWorld& world,
                const std::vector<btCcdPushes::Push>& pushes,
                bool alone);
    ~btCcdPushed();
    btCcdPushed(const btCcdPushed&) = delete;
    btCcdPushed& operator=(const btCcdPushed&) = delete;

private:
    struct Saved
    {
        btCcdVelocities m_own;
        btVector3 m_linear;  // while this lives
        btVector3 m_angular;
    };
    std::vector<Saved> m_saved;
    std::vector<std::pair<btMultiBody*, std::vector<btScalar>>> m_multiBodies;  // with all rates
};

#endif  // BT_CCD_PUSHES_H
