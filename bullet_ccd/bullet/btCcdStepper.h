/// First impact among everything that a Bullet world is about to move.
#ifndef BT_CCD_STEPPER_H
#define BT_CCD_STEPPER_H

#include "bullet_ccd/bullet/btCcdMultiBodyMotion.h"
#include "bullet_ccd/bullet/btCcdShapeCache.h"
#include "bullet_ccd/toi/first_contact.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

/// Two colliders that have come within the tolerance of each other.
struct btCcdImpact
{
    /// Link index of a collider that belongs to no multibody.
    static constexpr int kNoLink = -2;

    btCollisionObject* m_objectA;
    btCollisionObject* m_objectB;
    int m_linkA;  ///< -1: the base of a multibody
    int m_linkB;
    btScalar m_time;     ///< since the step began [s]
    btVector3 m_pointA;  ///< closest points at that time, in the world [m]
    btVector3 m_pointB;
    btVector3 m_normal;  ///< unit, from A to B
};

/// What a world asks: which objects, which pairs, how long.
struct btCcdQuery
{
    btCollisionObjectArray& m_objects;
    btDispatcher& m_dispatcher;
    btOverlappingPairCache& m_pairCache;
    btScalar m_timeStep;  ///< [s]
    double m_tolerance;   ///< [m]
};

struct btCcdAnswer
{
    bullet_ccd::ToiStatus m_status = bullet_ccd::ToiStatus::Separated;  ///< never Overlapping
    double m_fraction = 1.0;         ///< of the time step, free of contact
    std::int64_t m_overlaps = 0;     ///< pairs left out because they intersect already
    std::int64_t m_unsupported = 0;  ///< colliders left out: shape or joints not covered
    /// For Hit: the first impact and all that happen at the same time, m_time counted from the
    /// beginning of this query.
    std::vector<btCcdImpact> m_impacts;
};

/// Gathers the moving colliders of a world with the motion that Bullet is about to integrate
/// (linear in the joint positions, constant twist for free bodies), pairs them as Bullet would
/// (filter groups, user filters, parent-child and self-collision flags, contact response) and asks
/// for the first contact. Kinematic and static objects stand still. Keeps scratch memory and
/// converted shapes; one per world.
class btCcdStepper
{
public:
    [[nodiscard]] btCcdAnswer firstImpact(const btCcdQuery& query);
    btCcdShapeCache& shapes() { return m_shapes; }

private:
    struct Body
    {
        btCollisionObject* m_object = nullptr;
        const btCcdMultiBodyMotion* m_multiBodyMotion = nullptr;  // null: not a link
        int m_link = btCcdImpact::kNoLink;
        bool m_moves = false;
        bool m_stock = false;
        // Box around all that it passes through.
        Eigen::Vector3d m_low = Eigen::Vector3d::Zero();
        Eigen::Vector3d m_high = Eigen::Vector3d::Zero();
    };
    struct KnownMultiBody
    {
        const btMultiBody* m_body;
        bool m_covered;
        btCcdMultiBodyMotion m_motion;
    };
    using ObjectPair = std::pair<const btCollisionObject*, const btCollisionObject*>;

    btCcdShapeCache m_shapes;
    bullet_ccd::ToiWorkspace m_work;
    std::vector<std::unique_ptr<KnownMultiBody>> m_multiBodies;
    std::vector<bullet_ccd::MovingBody> m_moving;  // parallel to m_bodies
    std::vector<Body> m_bodies;
    std::vector<bullet_ccd::BodyPair> m_pairs;
    std::vector<std::int32_t> m_order;
    std::vector<ObjectPair> m_solverPairs;

    std::int64_t collect(const btCcdQuery& query);
    bool collectObject(btCollisionObject& object, btScalar timeStep);
    KnownMultiBody& known(const btMultiBody& body, btScalar timeStep);
    void addBody(const Body& body, bullet_ccd::MovingBody moving, double tolerance);
    void collectSolverPairs(const btCcdQuery& query);
    void pairUp(const btCcdQuery& query);
    bool wanted(const Body& a, const Body& b, const btCcdQuery& query) const;
    double gapAt(const bullet_ccd::BodyPair& pair, double time, double upperBound) const;
    void addSimultaneous(const bullet_ccd::FirstContactResult& first,
                         const btCcdQuery& query,
                         btCcdAnswer& answer) const;
    btCcdImpact makeImpact(const bullet_ccd::BodyPair& pair,
                           double seconds,
                           const Eigen::Vector3d& pointA,
                           const Eigen::Vector3d& pointB,
                           const Eigen::Vector3d& normal) const;
};

#endif  // BT_CCD_STEPPER_H
