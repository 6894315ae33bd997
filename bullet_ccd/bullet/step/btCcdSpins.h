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
/// stock Bullet; from the first impact on everything turns as fast as it says, in short pieces, of
/// which a few are enough: whole turns lead nowhere. But nothing turns by more than a dozen turns
/// up to the next impact or the end, for what spins faster costs ever more to ask for. The spins
/// themselves stay what they are.
class btCcdSpins
{
public:
    explicit btCcdSpins(btDiscreteDynamicsWorld& world);

    /// Shortens all spins that the whole step would be too long for. False if there is none.
    bool limit(btScalar timeStep);
    /// An impact sees all of a spin. To be called when what has one is where it is by then.
    void free(btCcdStepper& stepper);
    /// The body may have got a spin that is new.
    void add(const btCcdBody& body)
    {
        if (!body.isNone())
        {
            m_fast.insert(body);
        }
    }
    /// Shortens what is too much for the rest of the step, after an impact.
    void limitAgain(btScalar remaining);
    template <typename Visit>
    void forLimited(const Visit& visit) const
    {
        for (const Limited& spin : m_limited)
        {
            visit(*spin.m_collider);
        }
    }
    /// Integrates the body, or all multibodies (null), as far as they turn in this time:
    /// `integrate` moves them all by a part of it.
    template <typename Integrate>
    void move(btRigidBody* body, btScalar time, const Integrate& integrate)
    {
        const int pieces = shorten(body, double(time));
        for (int i = 0; i < pieces; ++i)
        {
            integrate(time / btScalar(pieces));
        }
        restore(m_shortened);
    }
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
    using Spins = std::vector<Limited>;

    btDiscreteDynamicsWorld& m_world;
    btMultiBodyDynamicsWorld* m_multiBodyWorld;  // the same, or null
    Spins m_limited;
    std::set<btCcdBody> m_fast;  // since the last impact, perhaps
    Spins m_shortened;           // by whole turns, while something is integrated

    template <typename Visit>
    void forMultiBodies(const Visit& visit) const;
    /// @param most angle that it may turn by, and what is left of a greater one
    void limit(const btCcdBody& body, btScalar time, btScalar most, btScalar left);
    /// Returns how many calls it takes.
    [[nodiscard]] int shorten(btRigidBody* body, double time);
    [[nodiscard]] int shorten(const btCcdBody& body, double time);
    /// Gives back those that nobody has changed.
    static void restore(Spins& spins);
};

#endif  // BT_CCD_SPINS_H
