/// What moves as one: a rigid body or a multibody.
#ifndef BT_CCD_BODY_H
#define BT_CCD_BODY_H

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>

#include <compare>
#include <vector>

struct btCcdBody
{
    static constexpr int kBase = -1;

    btRigidBody* m_rigidBody = nullptr;
    btMultiBody* m_multiBody = nullptr;

    /// None for a collider of neither kind.
    [[nodiscard]] static btCcdBody of(btCollisionObject* object);
    friend auto operator<=>(const btCcdBody&, const btCcdBody&) = default;

    [[nodiscard]] bool isNone() const { return m_rigidBody == nullptr && m_multiBody == nullptr; }
    /// One of its colliders; null for a multibody without.
    [[nodiscard]] const btCollisionObject* collider() const;
    /// Bullet moves it, and an impact may stop it.
    [[nodiscard]] bool isFree() const;
    /// Nothing of it has a velocity.
    [[nodiscard]] bool isStill() const;
    /// Of the base.
    [[nodiscard]] btVector3 velocity() const;
    /// One over the mass of what slides as one; zero for what does not.
    [[nodiscard]] btScalar mobility() const;
    /// Angular velocity of what may turn about any axis: the body or base (kBase), or a spherical
    /// joint, by its link.
    [[nodiscard]] btVector3 spin(int link) const;
    void setSpin(int link, const btVector3& spin) const;
    /// Slower by this factor: the turn of a rigid body or base, and all joints that the user does
    /// not move.
    void calm(btScalar factor) const;
    /// Without any turn, at the velocity of its base after the impulse.
    void slide(const btVector3& impulse) const;
    /// Joints stand. Has no effect on what is fixed.
    void setVelocity(const btVector3& linear, const btVector3& angular) const;
    /// Visits all links with a spin(), kBase first.
    template <typename Visit>
    void forSpins(const Visit& visit) const
    {
        visit(kBase);
        for (int i = 0; m_multiBody != nullptr && i < m_multiBody->getNumLinks(); ++i)
        {
            if (m_multiBody->getLink(i).m_jointType == btMultibodyLink::eSpherical)
            {
                visit(i);
            }
        }
    }
};

/// The velocities of a body.
class btCcdVelocities
{
public:
    explicit btCcdVelocities(const btCcdBody& body);
    [[nodiscard]] const btCcdBody& body() const { return m_body; }
    /// Gives them back, but for what the user moves.
    void restore() const;

private:
    btCcdBody m_body;
    btVector3 m_linear;
    btVector3 m_angular;
    std::vector<btScalar> m_joints;
};

/// Nothing of the body moves any more.
void btCcdStop(const btCcdBody& body);

#endif  // BT_CCD_BODY_H
