/// The answer of a world to impacts in the middle of a step.
#ifndef BT_CCD_IMPACT_SOLVER_H
#define BT_CCD_IMPACT_SOLVER_H

#include "bullet_ccd/bullet/step/btCcdStepper.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <unordered_map>
#include <vector>

class btCcdProgress;
class btMultiBody;
class btMultiBodyDynamicsWorld;
class btRigidBody;

enum class btCcdAnswer
{
    Bounce,  ///< with restitution
    Calm,    ///< without, and thoroughly: for contacts that come again
    Part,    ///< the same, and errors of position are corrected as in a step
};

/// Solves the velocities of what takes part in an impact, and of all that is connected to it by
/// contacts and constraints, with the solver of the world. Of a large heap only what is nearest
/// takes part, by the number of contacts on the way; the rest follows in impacts of its own, or
/// when the solver sees its contacts in the next step. Only what is near is looked at, so the cost
/// of an impact does not depend on the size of the world.
///
/// An impact takes no time: forces, gravity, gyroscopic terms and motors contribute nothing to it
/// (the step's solution has their whole share already), and positions are not corrected, so it adds
/// no energy. Restitution and friction are Bullet's, with the velocities of impact. Objects outside
/// of the island are not touched. Contact points that existed before keep the impulses that the
/// step's solution found for them.
class btCcdImpactSolver
{
public:
    btCcdImpactSolver(btDiscreteDynamicsWorld& world, btCcdProgress& progress);

    void beginStep();
    /// Solves and returns one collider of every body that may have got another velocity.
    /// @param rigid for an action: nothing is solved if a multibody takes part
    const std::vector<btCollisionObject*>& solve(const std::vector<btCcdImpact>& impacts,
                                                 btCcdAnswer answer,
                                                 bool rigid = false);

private:
    /// A contact of two objects that are reached, by index in the world.
    struct Contact
    {
        int m_from;
        int m_to;
        btPersistentManifold* m_manifold;
    };

    btDiscreteDynamicsWorld& m_world;
    btCcdProgress& m_progress;
    btMultiBodyDynamicsWorld* m_multiBodyWorld;  // the same, or null
    bool m_isListed = false;                     // the two that follow are those of this step
    std::vector<std::vector<int>> m_touching;    // of what Bullet moves, by index in the world
    std::unordered_map<int, std::vector<btTypedConstraint*>> m_joints;
    std::size_t m_most = 0;                     // objects of a heap
    std::vector<int> m_reached;                 // what takes part, by index in the world,
    std::vector<char> m_isReached;              // and which those are
    std::vector<Contact> m_contacts;            // scratch memory
    std::vector<btCollisionObject*> m_objects;  // what takes part
    std::vector<btMultiBody*> m_multiBodies;
    std::vector<btPersistentManifold*> m_manifolds;
    std::vector<btPersistentManifold*> m_ownManifolds;   // for one impact
    std::vector<btCollisionAlgorithm*> m_ownAlgorithms;  // likewise

    [[nodiscard]] btCollisionObject& at(int index) const;
    [[nodiscard]] bool isIn(const btCollisionObject& object) const;
    void list();
    void noteContact(const btCollisionObject& a, const btCollisionObject& b);
    void findContacts(const std::vector<btCcdImpact>& impacts);
    void collect(const std::vector<btCcdImpact>& impacts, bool rigid);
    void reach(const btCollisionObject& object);
    void reachJoined(const btCollisionObject& object);
    void reachTouching(const btCollisionObject& object, bool met);
    [[nodiscard]] bool isContactKnown(const btCcdImpact& impact) const;
    void addMissingContacts(const std::vector<btCcdImpact>& impacts);
    void addContactsOfOverlap(const btCcdImpact& impact);
    void addWitness(const btCcdImpact& impact);
    void releaseOwnContacts();
    void solveIsland(btCcdAnswer answer);
};

#endif  // BT_CCD_IMPACT_SOLVER_H
