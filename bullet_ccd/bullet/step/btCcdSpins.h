/// What turns faster than Bullet's integrator turns anything in one call.
#ifndef BT_CCD_SPINS_H
#define BT_CCD_SPINS_H

#include "bullet_ccd/bullet/step/btCcdBody.h"

#include <set>
#include <vector>

class btCcdStepper;
class btDiscreteDynamicsWorld;
class btMultiBodyDynamicsWorld;

/// Bullet turns a body by an eighth of a turn at most in one call of its integrator, so a step in
/// two parts would turn it further than the whole. A step without impacts turns no further than
/// stock Bullet; from the first impact on everything turns as fast as it says, in short pieces.
class btCcdSpins
{
public:
    explicit btCcdSpins(btDiscreteDynamicsWorld& world);

    /// Shortens all spins that the whole step would be too long for. False if there is none.
    bool limit(btScalar timeStep);
    /// Gives back those that nobody has changed.
    void restore();
    /// An impact sees all of a spin. To be called when what has one is where it is by then.
    void free(btCcdStepper& stepper);
    template <typename Visit>
    void forLimited(const Visit& visit) const
    {
        for (const Limited& spin : m_limited)
        {
            visit(*spin.m_collider);
        }
    }
    /// The body may have got a spin that is to be taken as it is.
    void add(const btCcdBody& body)
    {
        if (!body.isNone())
        {
            m_free.insert(body);
        }
    }
    /// How many calls it takes to integrate the body this long,
    [[nodiscard]] int pieces(btRigidBody& body, btScalar time) const;
    /// and all multibodies.
    [[nodiscard]] int pieces(btScalar time) const;
    void endStep();

private:
    struct Limited
    {
        btCcdBody m_body;
        int m_link;
        const btCollisionObject* m_collider;  // of the body
        btVector3 m_wanted;
        btVector3 m_limited;
    };

    btDiscreteDynamicsWorld& m_world;
    btMultiBodyDynamicsWorld* m_multiBodyWorld;  // the same, or null
    std::vector<Limited> m_limited;
    std::set<btCcdBody> m_free;  // since an impact of this step

    void limit(const btCcdBody& body, btScalar timeStep);
    [[nodiscard]] static int pieces(const btCcdBody& body, btScalar time);
};

#endif  // BT_CCD_SPINS_H
