/// How far the rigid bodies of a world have come in the step that it is about to do.
#ifndef BT_CCD_PROGRESS_H
#define BT_CCD_PROGRESS_H

#include "bullet_ccd/bullet/step/btCcdSpins.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <functional>
#include <vector>

/// Bullet's own code moves bodies on, each one only when something has to know where it is: what no
/// impact comes near goes all of its way at once, as in stock Bullet. Between begin() and finish();
/// outside of that everything is where it is.
class btCcdProgress
{
public:
    /// Moves one body at its velocity for the given time, or all multibodies (null).
    using Integrate = std::function<void(btRigidBody*, btScalar)>;

    btCcdProgress(btDiscreteDynamicsWorld& world, btCcdSpins& spins)
        : m_world(world), m_spins(spins)
    {
    }

    /// `integrate` must outlive finish().
    void begin(const Integrate& integrate)
    {
        m_integrate = &integrate;
        m_now = 0;
        m_times.assign(std::size_t(m_world.getNumCollisionObjects()), btScalar(0));
    }
    /// This is the present time. Multibodies are there.
    void advance(btScalar time)
    {
        move(nullptr, time - m_now);
        m_now = time;
    }
    /// Moves the object to where it is at the present time, before its velocity changes or somebody
    /// asks for its pose.
    void bring(const btCollisionObject& object)
    {
        if (m_placeKinematic && object.isKinematicObject())
        {
            m_placeKinematic(object);
            return;
        }
        if (m_place)
        {
            m_place(object);
            return;
        }
        if (m_integrate == nullptr || object.isStaticOrKinematicObject())
        {
            return;
        }
        btRigidBody* body = btRigidBody::upcast(const_cast<btCollisionObject*>(&object));
        const auto index = std::size_t(object.getWorldArrayIndex());
        if (body == nullptr || index >= m_times.size() || !(m_times[index] < m_now))
        {
            return;
        }
        const btScalar time = m_now - m_times[index];
        m_times[index] = m_now;
        move(body, time);
    }
    /// While a motion that is done is looked at: how an object gets there; empty: it stays.
    void setPlace(const std::function<void(const btCollisionObject&)>& place) { m_place = place; }
    /// How a kinematic object gets there; empty: it stays.
    void setPlaceKinematic(const std::function<void(const btCollisionObject&)>& place)
    {
        m_placeKinematic = place;
    }
    void bringAll()
    {
        const btAlignedObjectArray<btRigidBody*>& bodies = m_world.getNonStaticRigidBodies();
        for (int i = 0; i < bodies.size(); ++i)
        {
            bring(*bodies[i]);
        }
        // Whoever is told of impacts may remove objects: others take their places.
        m_times.assign(std::size_t(m_world.getNumCollisionObjects()), m_now);
    }
    void finish(btScalar timeStep)
    {
        advance(timeStep);
        bringAll();
        m_integrate = nullptr;
    }

private:
    btDiscreteDynamicsWorld& m_world;
    btCcdSpins& m_spins;
    const Integrate* m_integrate = nullptr;
    std::function<void(const btCollisionObject&)> m_place;
    std::function<void(const btCollisionObject&)> m_placeKinematic;
    btScalar m_now = 0;
    std::vector<btScalar> m_times;  // by index in the world

    void move(btRigidBody* body, btScalar time) const
    {
        m_spins.move(body, time, [&](btScalar part) { (*m_integrate)(body, part); });
    }
};

#endif  // BT_CCD_PROGRESS_H
