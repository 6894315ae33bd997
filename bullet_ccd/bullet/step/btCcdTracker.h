/// What every object of a world is, and how far it moves in a step.
#ifndef BT_CCD_TRACKER_H
#define BT_CCD_TRACKER_H

#include "bullet_ccd/bullet/motion/btCcdNeighbours.h"
#include "bullet_ccd/bullet/motion/btCcdObjectMotion.h"
#include "bullet_ccd/bullet/motion/btCcdWay.h"
#include "bullet_ccd/bullet/shapes/btCcdKnownShape.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

class btCcdContext;
class btMultiBodyLinkCollider;

/// True if Bullet moves the object in a step.
[[nodiscard]] inline bool btCcdIsMoved(const btCollisionObject& object)
{
    constexpr int kNone = btCollisionObject::CF_NO_CONTACT_RESPONSE;
    const int flags = object.getCollisionFlags();
    const bool mayMove = (flags & (btCollisionObject::CF_STATIC_OBJECT | kNone)) == 0 ||
                         ((flags & kNone) == 0 && object.isKinematicObject());
    return mayMove && object.isActive() && object.getBroadphaseHandle() != nullptr;
}

/// Every point moves with m_velocity, and beside that no faster than m_turning [m/s].
struct btCcdCourse
{
    btVector3 m_velocity = btVector3(0, 0, 0);
    btVector3 m_spin = btVector3(0, 0, 0);  // of what is no link; in a step with pairs to ask
    double m_turning = 0.0;
};

/// Where a list of neighbours has an object that moves.
struct btCcdListed
{
    btVector3 m_origin = btVector3(0, 0, 0);
    double m_room = -1.0;  // how far from there it may pass through; negative: not listed [m]
};

/// A collision object in a step.
struct btCcdTracked
{
    btCollisionObject* m_object = nullptr;
    const btCollisionShape* m_collisionShape = nullptr;
    int m_proxy = 0;  // of the broadphase: another one if the object was removed and added
    btCcdKnownShape* m_shape = nullptr;
    bool m_usable = false;   // covered and not switched off
    bool m_tracked = false;  // usable, and its numbers are finite
    bool m_moves = false;    // in this step
    bool m_turns = true;     // while it moves (btCcdMode)
    bool m_fast = false;
    bool m_changed = false;
    bool m_pressed = false;   // some contact is deep
    bool m_jumped = false;    // a kinematic object that has been put where it is
    bool m_squeezed = false;  // what nothing can stop goes on into it
    bool m_stopped = false;   // has been placed for the rest of a motion that is done
    bool m_isStray = false;   // may leave its place among its neighbours in this step
    bool m_isDue = false;     // has crept so far that all stock meshes that it touches are asked
    /// How far it may have come since they were asked; at first nothing is known of that [m].
    double m_crept = std::numeric_limits<double>::infinity();
    double m_slow = 0.0;    // what it may move and not be fast [m]
    double m_unseen = 0.0;  // what it may move unseen, whatever it meets [m]
    double m_motion = 0.0;  // bound of what any point of it moves in the rest of the step [m]
    double m_around = 0.0;  // of the box about its origin that it stays in, if it moves [m]
    btVector3 m_origin = btVector3(0, 0, 0);  // when the step began, if it moves
    double m_beyond = 0.0;                    // how far it moves beyond m_unseen
    btCcdCourse m_course;                     // since m_since
    const btCcdWay* m_way = nullptr;          // of a kinematic object that moves
    double m_since = 0.0;
    btVector3 m_shift = btVector3(0, 0, 0);  // by then in this step, in the same two parts
    double m_turned = 0.0;
    bool m_isMover = false;                 // when the neighbours were listed
    btCcdListed m_listed;                   // among what was at rest then,
    btCcdListed m_along;                    // and among the movers, which may move along together
    const btCcdBox* m_listedBox = nullptr;  // of what was at rest then
    btCcdBox m_sweep;    // what it passes through from its last impact on, if it is fast
    int m_sweptAt = -1;  // among those that btCcdStepper goes through

    [[nodiscard]] const btCcdShapeOutline& outline() const { return m_shape->m_outline; }
    /// How far from its place in the step Bullet's contacts may have it: what it moves itself, or
    /// what Bullet has it ahead.
    [[nodiscard]] double farthest() const
    {
        return m_way != nullptr ? std::max(m_motion, m_way->m_ahead) : m_motion;
    }
    /// Reads the velocity anew, at this time of the step.
    void take(const btCcdCourse& course, double time, double remaining);
};

/// Two objects that are near each other.
struct btCcdNeighbourPair
{
    btCcdTracked* m_a;
    btCcdTracked* m_b;
    double m_mayLose = -1.0;  ///< see btCcdMayLose(); negative: not asked yet
    const btMultiBodyLinkCollider* m_child =
        nullptr;  ///< one of the two, if the other is its parent
};

/// Looks at all objects at the begin of a step, and costs next to nothing where nothing is fast:
/// shapes are looked at again only if something about them has changed.
class btCcdTracker
{
public:
    /// Of what a pair can lose before it crosses, slow motion may use up this part unseen.
    static constexpr double kUnseen = 0.5;

    explicit btCcdTracker(btCollisionWorld& world);

    /// Shapes have been changed in place, or settings.
    void forgetShapes() { m_isStale = true; }

    /// A new step is about to begin.
    void newStep()
    {
        ++m_step;
        m_pushable.clear();
    }
    void endStep()
    {
        if (!m_teleported.empty() || !m_ways.empty() || m_hasStockMeshes)
        {
            noteEnd();
        }
    }
    /// In this step the object may have been moved otherwise than by its velocity.
    void mayBePushed(const btCollisionObject& object) { m_pushable.push_back(&object); }
    /// In the step to come it has jumped to where it is.
    void teleported(const btCollisionObject& object) { m_teleported.insert(&object); }
    /// Looks at all objects and makes the models of simple shapes, before the first step.
    void prepare();
    /// Reads how everything moves. False if no two objects can cross each other, wherever they are.
    /// @param kinematicStands what is kinematic is where its part of this step begins, and stays
    [[nodiscard]] bool look(double timeStep, bool kinematicStands);
    /// Lists all pairs that may meet in this step, and some more; after look().
    /// @param done the motion is, and everything is where it ended
    void findNeighbours(bool done);
    /// True if the pairs are those of Bullet's broadphase: all that moves stays in the boxes that
    /// it has there in this step, but for a few strays. Then present() has the pairs; else movers()
    /// and others(), and what has been listed stays in boxes of the lists.
    [[nodiscard]] bool isInBoxes() const { return m_isInBoxes; }
    [[nodiscard]] std::vector<btCcdNeighbourPair>& present() { return m_present; }
    /// True if the lists have all pairs, wherever they are.
    [[nodiscard]] bool listsAll() const { return m_listsAll; }
    /// What may leave its place among its neighbours, by index.
    [[nodiscard]] const std::vector<int>& strays() const { return m_strays; }
    void stray(btCcdTracked& tracked)
    {
        if (!tracked.m_isStray)
        {
            tracked.m_isStray = true;
            m_strays.push_back(int(&tracked - m_objects.data()));
        }
    }
    /// Of two that moved when the list was made; and all others.
    [[nodiscard]] std::vector<btCcdNeighbourPair>& movers() { return m_movers; }
    [[nodiscard]] std::vector<btCcdNeighbourPair>& others() { return m_others; }
    /// False if no two objects that move can cross each other: they move along together.
    [[nodiscard]] bool moversCanCross() const
    {
        return !(m_apart <= m_moversMayLose) || !m_pressedPairs.empty();
    }
    /// True if the lists of neighbours hold for the object, whose course is new, until the end of
    /// the step.
    [[nodiscard]] bool staysInPlace(const btCcdTracked& tracked,
                                    double time,
                                    double remaining) const;
    /// True if the two are in boxes that do not meet.
    [[nodiscard]] static bool areBoxesApart(const btCcdTracked& a, const btCcdTracked& b)
    {
        return a.m_moves && b.m_moves
                   ? a.m_origin.distance2(b.m_origin) >
                         btScalar((a.m_around + b.m_around) * (a.m_around + b.m_around))
                   : isBoxApart(a.m_moves ? a : b, a.m_moves ? b : a);
    }
    /// A box about all that the object passes through in the step.
    [[nodiscard]] btCcdBox placeOf(const btCcdTracked& tracked) const;
    /// Changes are about to be noted in the objects, for the rest of the step.
    void noteChanges() { m_touched = true; }
    /// How the object moves now. Velocities of multibodies are read once until forgetBodies().
    [[nodiscard]] btCcdCourse courseOf(const btCcdTracked& tracked);
    void forgetBodies()
    {
        m_bodyCount = 0;
        m_lastBody = nullptr;
    }

    [[nodiscard]] std::vector<btCcdTracked>& objects() { return m_objects; }
    [[nodiscard]] const std::vector<btCcdTracked>& objects() const { return m_objects; }
    [[nodiscard]] btCcdTracked* find(const btCollisionObject& object)
    {
        return const_cast<btCcdTracked*>(std::as_const(*this).find(object));
    }
    [[nodiscard]] const btCcdTracked* find(const btCollisionObject& object) const;
    /// What the two may move relative to each other in this step and not cross, as their contacts
    /// say [m]: negative if these do not tell, infinite if they are not pressed.
    [[nodiscard]] double leftOf(int a, int b) const;
    /// What a query has found out about the two: if they are deep, they are asked again, however
    /// slowly they move, until a query or the broadphase says otherwise.
    void noteDeep(int a, int b, bool isDeep);
    [[nodiscard]] std::int64_t unsupported() const { return m_unsupported; }
    /// True if Bullet's own motion clamping is on for some body that moves.
    [[nodiscard]] bool seesStockClamping() const { return m_isClamped; }
    /// True if there is an object without contact response.
    [[nodiscard]] bool seesTriggers() const { return m_hasTriggers; }
    /// That are active, in this step.
    [[nodiscard]] bool seesKinematic() const { return !m_ways.empty(); }
    [[nodiscard]] bool isTeleported(const btCollisionObject& object) const
    {
        return m_teleported.count(&object) != 0;
    }

private:
    struct Speeds
    {
        const btMultiBody* m_body = nullptr;
        bool m_covered = false;
        std::vector<double> m_links;                // as btCcdReadSpeeds() gives them
        btVector3 m_velocity = btVector3(0, 0, 0);  // that all links have in common,
        double m_common = 0.0;                      // and its magnitude
    };

    btCollisionWorld& m_world;
    btCcdContext& m_context;
    std::set<const btCollisionObject*> m_teleported;
    std::unordered_map<const btCollisionObject*, int> m_proxies;  // of all that have been seen
    std::unordered_map<const btCollisionObject*, btCcdWay> m_ways;
    int m_step = 0;
    std::vector<btCcdTracked> m_objects;  // by index in the world
    std::unordered_map<const btCollisionShape*, std::unique_ptr<btCcdKnownShape>> m_shapes;
    std::vector<std::unique_ptr<Speeds>> m_bodies;
    std::size_t m_bodyCount = 0;
    const Speeds* m_lastBody = nullptr;
    struct PressedPair
    {
        std::pair<int, int> m_indices;
        double m_left;  // see leftOf()
    };
    std::vector<PressedPair> m_pressedPairs;
    /// Two objects, which are compared and never read, and where they were among all.
    struct DeepPair
    {
        std::array<int, 2> m_indices;
        std::array<const btCollisionObject*, 2> m_objects;
    };
    std::vector<DeepPair> m_deepPairs;  // see noteDeep()
    static constexpr double kSteps = 24.0;
    /// A list of neighbours, good for about kSteps, for fewer if it had too many pairs.
    struct List
    {
        btCcdNeighbours m_boxes;
        double m_steps = kSteps;
        int m_patience = 0;  // lists to be made before one for more steps is tried
    };
    List m_restList;                   // of movers and what is at rest; of few objects all
    List m_moverList;                  // of movers, as seen from what most of them move along with
    std::vector<int> m_group;          // the movers of the lists, then everything else
    std::vector<btVector3> m_samples;  // scratch memory
    std::size_t m_moverCount = 0;
    std::vector<btCcdNeighbourPair> m_movers;
    std::vector<btCcdNeighbourPair> m_others;
    std::vector<btCcdNeighbourPair> m_present;
    std::vector<int> m_strays;
    btCcdNeighbours m_strayBoxes;
    std::vector<const btCollisionObject*> m_pushable;  // see mayBePushed()
    std::int64_t m_unsupported = 0;
    double m_listedTolerance = -1.0;
    double m_timeStep = 0.0;
    double m_beyondAtRest = 0.0;  // the most of any object that does not move
    double m_beyondTwo = 0.0;     // of the two that go farthest beyond what they may move unseen
    int m_epoch = 0;
    bool m_isStale = false;  // to be looked at anew
    bool m_kinematicStands = false;
    bool m_touched = false;  // see noteChanges()

    double m_moversMayLose = 0.0;  // at least, of any two
    double m_apart = 0.0;     // the most that any two that move may move relative to each other [m]
    bool m_compares = false;  // worth the while
    bool m_isAlongListed = false;
    bool m_isAlongUsed = false;                  // the list of movers holds in this step,
    btVector3 m_common = btVector3(0, 0, 0);     // in which they have this velocity in common,
    btVector3 m_commonWay = btVector3(0, 0, 0);  // and have come so far together
    bool m_isClamped = false;  // some body that moves, by Bullet's own motion clamping
    bool m_hasTriggers = false;
    bool m_hasStockMeshes = false;
    bool m_listsAll = false;  // wherever objects are
    bool m_isListed = false;  // everything is in its box of the list with what is at rest
    bool m_isInBoxes = false;

    [[nodiscard]] static bool isBoxApart(const btCcdTracked& mover, const btCcdTracked& other);
    [[nodiscard]] bool isAlone() const;
    void clearStep();
    void lookAtAll();
    void lookAt(btCcdTracked& tracked, btCollisionObject& object);
    void lookAtShape(btCcdKnownShape& shape);
    [[nodiscard]] bool isAsSeen(btCcdTracked& tracked, const btCollisionObject& object) const;
    [[nodiscard]] bool readMotions(bool check);
    [[nodiscard]] bool read(btCcdTracked& tracked, double tolerance);
    void readKinematic(btCcdTracked& tracked);
    [[nodiscard]] bool readAtRest(btCcdTracked& tracked);
    [[nodiscard]] static bool isInside(const btCcdTracked& tracked);
    void compareMotions();
    void readLink(btCcdTracked& tracked, const btMultiBodyLinkCollider& collider);
    [[nodiscard]] const Speeds& speedsOf(const btMultiBody& body)
    {
        // Colliders of a body usually follow each other.
        return m_lastBody != nullptr && m_lastBody->m_body == &body ? *m_lastBody
                                                                    : findSpeeds(body);
    }
    [[nodiscard]] const Speeds& findSpeeds(const btMultiBody& body);
    void findPressed(btPersistentManifold** manifolds, int count);
    void press(int a, int b, double left);
    void pressDeep();
    [[nodiscard]] bool isThere(DeepPair& pair) const;
    [[nodiscard]] bool isDue(const btPersistentManifold& manifold,
                             const btCcdTracked*& a,
                             const btCcdTracked*& b);
    [[nodiscard]] bool isPressed(const btPersistentManifold& manifold,
                                 const btCcdTracked*& a,
                                 const btCcdTracked*& b,
                                 double& left) const;
    void group();
    void listWithRest();
    [[nodiscard]] bool listsMoversApart() const;
    [[nodiscard]] btVector3 commonVelocity();
    [[nodiscard]] double motionAlong(const btCcdTracked& tracked, const btVector3& common) const;
    [[nodiscard]] bool isAlongGood(const btVector3& common);
    void listMovers(const btVector3& common);
    template <typename Make>
    void makeList(List& list, const Make& make) const;
    void forgetStrays()
    {
        if (!m_strays.empty())
        {
            forgetAllStrays();
        }
    }
    void forgetAllStrays();
    void noteEnd();
    [[nodiscard]] bool findStrays(bool done);
    [[nodiscard]] bool staysInBox(const btCcdTracked& tracked, bool done) const;
    void takePresent();
    void addPresent(btCcdTracked& a, btCcdTracked& b);
    void takePairs(const List& list, std::vector<btCcdNeighbourPair>& pairs);
    void listAllPairs();
    void splitPairs();
};

#endif  // BT_CCD_TRACKER_H
