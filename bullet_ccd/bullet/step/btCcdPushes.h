/// What Bullet's solver moves beside the velocities.
#ifndef BT_CCD_PUSHES_H
#define BT_CCD_PUSHES_H

#include "bullet_ccd/bullet/step/btCcdBody.h"

#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

class btDiscreteDynamicsWorld;

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
    };

    explicit btCcdPushes(btDiscreteDynamicsWorld& world) : m_world(world) {}

    /// Remembers all poses, at the end of a step. Costs nothing where nothing touches.
    void noteEnd();
    /// This body is where it is for another reason.
    void forget(const btCollisionObject& object);
    /// Finds what has been moved since then and has contacts so deep that they may have done it: no
    /// farther than twice the deepest. What is farther off has been put there by the user.
    /// @param integrated the velocities have been, too: they are part of the motion
    [[nodiscard]] const std::vector<Push>& find(btScalar timeStep, bool integrated);
    [[nodiscard]] const std::vector<Push>& found() const { return m_pushes; }

private:
    btDiscreteDynamicsWorld& m_world;
    std::unordered_map<const btRigidBody*, btTransform> m_ends;
    std::vector<Push> m_pushes;
    std::unordered_set<const btRigidBody*> m_looked;  // for them

    void look(btRigidBody* body, btScalar depth, btScalar timeStep, bool integrated);
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
