/// The impacts of one time step, in the order in which they happen.
#ifndef BT_CCD_STEPPER_H
#define BT_CCD_STEPPER_H

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdObjectMotion.h"
#include "bullet_ccd/bullet/btCcdShapeOutline.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

/// Two colliders that have come too near each other.
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

/// Finds the impacts of all that a world is about to move (or has just moved), through the
/// registered collision algorithms.
///
/// An object is fast if it moves more in the step than half of what it could lose without being
/// passed: half the depth of the core of a convex shape, a part of the margin of a mesh. Only pairs
/// with a fast object are ever asked: two slow ones cannot cross, and Bullet's discrete contacts
/// see them. Nor can two that move relative to each other by no more than that together. Pairs come
/// from the broadphase, by the boxes that fast objects sweep, and are filtered as Bullet does
/// (groups, user filters, parent-child and self-collision flags, contact response). Nothing is
/// asked of a shape but its outline before a pair needs a query. Keeps scratch memory; one per
/// world.
class btCcdStepper : public btCcdMotionSource
{
public:
    /// Which motion the velocities of a world stand for.
    enum class Motion
    {
        ToCome,  ///< the next time step
        Done,    ///< the last one, which ended where everything is now
    };
    /// What was seen in a step.
    struct Counts
    {
        std::int64_t m_queries = 0;
        std::int64_t m_overlaps = 0;
        std::int64_t m_unsupported = 0;
    };
    struct Event
    {
        bool m_found = false;
        bool m_gaveUp = false;               ///< the query did, the time is certified all the same
        btScalar m_time = 0;                 ///< since the step began [s]
        std::vector<btCcdImpact> m_impacts;  ///< all at that time; the first is the earliest
    };

    explicit btCcdStepper(btCollisionWorld& world);

    /// Objects that are left to Bullet.
    void setEnabled(const btCollisionObject* object, bool enabled);
    [[nodiscard]] bool isEnabled(const btCollisionObject* object) const;

    /// Shapes have been changed in place.
    void forgetShapes()
    {
        m_objects.clear();
        m_quiet = false;
    }

    /// Looks at all objects. False if nothing is fast: then no pair can be lost in this step.
    [[nodiscard]] bool begin(btScalar timeStep, Motion motion);
    /// The earliest impact that is still to come.
    [[nodiscard]] Event next();
    /// The world is at this time of the step now; call changed() for what no longer moves as it
    /// did.
    void advance(btScalar time);
    /// The velocities of everything that moves with the object are no longer what they were. For a
    /// motion that is done: it has been placed where it was at the present time and stays there.
    void changed(const btCollisionObject& object);
    /// Asks again for all pairs that changed() concerns. To be called before next().
    void refresh();
    void end();

    [[nodiscard]] const Counts& counts() const { return m_counts; }
    const btCcdObjectMotion* motionOf(const btCollisionObject& object) override;
    /// The same for the whole multibody that a link belongs to; null for others.
    const btCcdMultiBodyMotion* multiBodyMotionOf(const btCollisionObject& object);

    /// Box around all that the object passes through from now on, for debug drawing.
    [[nodiscard]] bool sweptBox(const btCollisionObject& object, btVector3& low, btVector3& high);

private:
    /// What there is to know about the shape of an object, while that stays the same.
    struct Shape
    {
        const btCollisionShape* m_shape = nullptr;
        btVector3 m_scaling;
        btScalar m_margin = 0;
        int m_revision = 0;  // of a compound
        bool m_covered = false;
        btCcdShapeOutline m_outline;

        [[nodiscard]] bool isOf(const btCollisionShape& shape) const;
    };
    /// Every point moves with m_velocity, and beside that no faster than m_turning [m/s].
    struct Course
    {
        btVector3 m_velocity = btVector3(0, 0, 0);
        btVector3 m_spin = btVector3(0, 0, 0);  // of what is no link
        double m_turning = 0.0;
    };
    struct Tracked
    {
        btCollisionObject* m_object = nullptr;
        Shape m_shape;
        bool m_tracked = false;
        bool m_fast = false;
        bool m_changed = false;
        bool m_pressed = false;  // some contact is deep
        bool m_stopped = false;  // has been placed for the rest of a motion that is done
        double m_motion = 0.0;   // bound of what any point of it moves in the rest of the step [m]
        Course m_course;         // since m_since
        double m_since = 0.0;
        btVector3 m_shift = btVector3(0, 0, 0);  // by then in this step, in the same two parts
        double m_turned = 0.0;
        int m_epoch = -1;  // of m_pose
        btCcdObjectMotion m_pose;
        btVector3 m_low;  // of the box that it sweeps, if fast
        btVector3 m_high;
    };
    struct KnownMultiBody
    {
        const btMultiBody* m_body = nullptr;
        bool m_covered = false;
        int m_epoch = -1;
        btCcdMultiBodyMotion m_motion;
        std::vector<double> m_speeds;  // bounds of the links' own frames, two a link
    };
    struct Pair
    {
        int m_a;
        int m_b;
        double m_time;  // of impact, since the step began [s]; infinite without
        btCcdPairToi m_toi;
        bool m_met = false;  // the impact has happened
    };
    class Candidates;

    btCollisionWorld& m_world;
    btCcdContext& m_context;
    std::set<const btCollisionObject*> m_disabled;
    std::vector<Tracked> m_objects;  // by index in the world
    std::vector<std::unique_ptr<KnownMultiBody>> m_multiBodies;
    std::size_t m_multiBodyCount = 0;
    std::vector<int> m_fast;
    std::vector<int> m_slow;  // the others, if they are few
    std::vector<Pair> m_pairs;
    std::vector<std::pair<int, int>> m_pressedPairs;
    Counts m_counts;
    Motion m_motion = Motion::ToCome;
    double m_timeStep = 0.0;
    double m_time = 0.0;
    int m_epoch = 0;
    double m_smallestOwnMargin = 0.0;
    double m_slowMotion = 0.0;  // the most that an object that is not fast moves [m]
    bool m_fewSlow = false;
    bool m_quiet = false;  // nothing could cross in the last step

    [[nodiscard]] double remaining() const { return m_timeStep - m_time; }
    [[nodiscard]] Tracked* find(const btCollisionObject& object);
    [[nodiscard]] bool staysQuiet();
    void lookAtShape(Tracked& tracked);
    void lookAt(Tracked& tracked, btCollisionObject& object);
    double track(Tracked& tracked);
    [[nodiscard]] double beyondUnseen(const Tracked& tracked, double motion) const;
    [[nodiscard]] double reserveOf(const Tracked& tracked) const;
    [[nodiscard]] Course courseOf(const Tracked& tracked);
    void take(Tracked& tracked, const Course& course);
    KnownMultiBody& known(const btMultiBody& body);
    void markPressed();
    [[nodiscard]] bool isPressed(const btPersistentManifold& manifold, Tracked*& a, Tracked*& b);
    [[nodiscard]] double wayApart(const Tracked& a, const Tracked& b) const;
    void sweep(Tracked& tracked);
    void findSlow();
    void findPairs();
    bool takeNewCourse(Tracked& tracked);
    void addCandidates(int index, bool onlyChanged);
    void addPair(int a, int b);
    [[nodiscard]] bool wanted(const Tracked& a, const Tracked& b) const;
    [[nodiscard]] bool canCross(const Tracked& a, const Tracked& b);
    void ask(Pair& pair);
    [[nodiscard]] btCcdImpact impactOf(const Pair& pair, btScalar time) const;
};

#endif  // BT_CCD_STEPPER_H
