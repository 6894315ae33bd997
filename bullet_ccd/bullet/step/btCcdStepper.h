/// The impacts of one time step, in the order in which they happen.
#ifndef BT_CCD_STEPPER_H
#define BT_CCD_STEPPER_H

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/motion/btCcdNeighbours.h"
#include "bullet_ccd/bullet/motion/btCcdObjectMotion.h"
#include "bullet_ccd/bullet/motion/btCcdSweptBoxes.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

class btCcdProgress;
class btCcdTracker;
struct btCcdNeighbourPair;
struct btCcdTracked;

/// Finds the impacts of all that a world is about to move (or has just moved), through the
/// registered collision algorithms.
///
/// An object is fast if it moves more in the step than half of what it could lose without being
/// passed: half the depth of the core of a convex shape, a part of the margin of a mesh. Only pairs
/// with a fast object are ever asked: two slow ones cannot cross, and Bullet's discrete contacts
/// see them. Nor can two that move relative to each other by no more than that together, or less
/// than they are apart. Pairs come from Bullet's broadphase or a list of neighbours (btCcdTracker),
/// after an impact by the boxes that objects sweep, and are filtered as Bullet does (groups,
/// user filters, parent-child and self-collision flags, contact response). Nothing is asked of a
/// shape but its outline before a pair needs a query, and that is not asked before it is the turn
/// of the earliest time at which the outlines may meet: most pairs of what is hit again have
/// another course by then. Keeps scratch memory; one per world.
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
    };
    struct Event
    {
        bool m_found = false;
        bool m_gaveUp = false;               ///< the query did, the time is certified all the same
        btScalar m_time = 0;                 ///< since the step began [s]
        std::vector<btCcdImpact> m_impacts;  ///< all at that time; the first is the earliest
    };

    btCcdStepper(btCollisionWorld& world, btCcdProgress& progress);
    ~btCcdStepper() override;
    btCcdStepper(const btCcdStepper&) = delete;
    btCcdStepper& operator=(const btCcdStepper&) = delete;

    /// Null: none, which says which pairs are swept.
    void setListener(btCcdImpactListener* listener) { m_listener = listener; }
    /// Shapes have been changed in place, or settings.
    void forgetShapes();

    /// Looks at what is there already, so that no step has to begin with that.
    void prepare();
    /// To be called once before the first begin() of a step, and after all of it.
    void newStep();
    void endStep();
    /// The next step takes the object to be where it is, whatever its velocity says.
    void teleported(const btCollisionObject& object);
    /// The solver may have moved the object beside its velocity. Until newStep().
    void mayBePushed(const btCollisionObject& object);
    [[nodiscard]] const btCcdTracker& tracker() const { return *m_tracker; }
    /// Where the motion of this object began, if that is done and was not its velocity alone. Until
    /// newStep().
    void startsAt(const btCollisionObject& object, const btTransform& pose)
    {
        m_starts.insert_or_assign(&object, pose);
    }
    /// Looks at all objects. False if no pair can be lost in this step: then that is all there is
    /// to do. May be called again if velocities have been changed.
    /// @param kinematicStands what is kinematic has not begun to move
    [[nodiscard]] bool begin(btScalar timeStep, Motion motion, bool kinematicStands = false);
    /// To be called after begin() by who asks for motions but not for pairs.
    void readyMotions();
    /// Gets ready to ask for the pairs that begin() has found. To be called before next().
    void getReady();
    /// The earliest impact that is still to come.
    [[nodiscard]] Event next();
    /// The world is at this time of the step now; call changed() for what no longer moves as it
    /// did.
    void advance(btScalar time);
    /// The velocities of everything that moves with the object are no longer what they were. For a
    /// motion that is done: it has been placed where it was at the present time and stays there.
    void changed(const btCollisionObject& object);
    /// Of a motion that is done: it has been placed where it would come to from the present time on
    /// at its new velocity, without any spin. To be called after changed().
    void goesOn(const btCollisionObject& object);
    /// Leaves the pairs of all that moves with the object and what is fixed or kinematic to Bullet
    /// for the rest of the step.
    void squeezed(const btCollisionObject& object);
    /// Looks again for all pairs that changed() concerns. To be called before next().
    void refresh();
    /// What moves on by another course since the last refresh(), by index in the world. To be
    /// called right after it.
    [[nodiscard]] const std::vector<int>& changedObjects() const { return m_changed; }
    void end();

    [[nodiscard]] double tolerance() const;
    /// Since begin().
    [[nodiscard]] const Counts& counts() const { return m_counts; }
    /// Colliders of shapes that are not covered.
    [[nodiscard]] std::int64_t unsupported() const;
    /// True if the object is covered and enabled; after begin().
    [[nodiscard]] bool covers(const btCollisionObject& object) const;
    /// True if Bullet's own motion clamping is on for any such object that moves.
    [[nodiscard]] bool seesStockClamping() const;
    const btCcdObjectMotion* motionOf(const btCollisionObject& object) override;
    /// The same for the whole multibody that a link belongs to; null for others.
    const btCcdMultiBodyMotion* multiBodyMotionOf(const btCollisionObject& object);

    /// Box around all that the object passes through from now on, for debug drawing.
    [[nodiscard]] bool sweptBox(const btCollisionObject& object, btVector3& low, btVector3& high);

private:
    /// How an object moves in the rest of the step, as the core takes it.
    struct Pose
    {
        int m_epoch = -1;
        btCcdObjectMotion m_motion;
    };
    struct KnownMultiBody
    {
        const btMultiBody* m_body = nullptr;
        bool m_covered = false;
        int m_epoch = -1;
        btCcdMultiBodyMotion m_motion;
    };
    struct Pair
    {
        int m_a;
        int m_b;
        double m_time;  // of impact, since the step began [s]; infinite without
        btCcdPairToi m_toi;
        double m_window = 0.0;   // impacts that come so much later come at the same time [s]
        bool m_isLooked = true;  // false: see btCcdStepper::look()
        bool m_isAsked = false;  // else there is no impact before m_time
        bool m_met = false;      // the impact has happened
    };
    class Candidates;
    struct Question;

    btCollisionWorld& m_world;
    btCcdContext& m_context;
    btCcdProgress& m_progress;
    std::unique_ptr<btCcdTracker> m_tracker;
    btCcdImpactListener* m_listener = nullptr;
    std::vector<Pose> m_poses;  // by index in the world
    std::vector<std::unique_ptr<KnownMultiBody>> m_multiBodies;
    std::size_t m_multiBodyCount = 0;
    std::unordered_map<const btCollisionObject*, btTransform> m_starts;
    std::vector<int> m_fast;
    std::vector<int> m_slow;     // the others, if they are few
    btCcdSweptBoxes m_swept;     // of the fast ones, or of the strays, one after the other
    std::vector<int> m_changed;  // since the last refresh(), and what that saw
    std::vector<int> m_near;     // by the lists, of all objects, one after the other
    std::vector<std::size_t> m_nearEnds;
    std::vector<Pair> m_pairs;
    Counts m_counts;
    Motion m_motion = Motion::ToCome;
    double m_timeStep = 0.0;
    double m_time = 0.0;
    int m_epoch = 0;
    double m_slowMotion = 0.0;  // the most that an object that is not fast moves [m]
    bool m_fewSlow = false;
    bool m_isNearListed = false;  // m_near is that of this step

    [[nodiscard]] double remaining() const { return m_timeStep - m_time; }
    [[nodiscard]] btCcdTracked& at(int index);
    [[nodiscard]] const btCcdTracked& at(int index) const;
    [[nodiscard]] int indexOf(const btCcdTracked& tracked) const;
    void findPairs(std::vector<btCcdNeighbourPair>& neighbours);
    KnownMultiBody& known(const btMultiBody& body);
    void readPose(const btCcdTracked& tracked, btCcdObjectMotion& pose);
    [[nodiscard]] double wayToCome(const btCcdTracked& a, const btCcdTracked& b) const;
    [[nodiscard]] double wayApart(const btCcdTracked& a, const btCcdTracked& b) const;
    [[nodiscard]] double earliestTime(const btCcdTracked& a, const btCcdTracked& b) const;
    [[nodiscard]] double boxesMeet(const btCcdTracked& a, const btCcdTracked& b) const;
    [[nodiscard]] bool isKnown(const btCcdTracked& a, const btCcdTracked& b) const;
    [[nodiscard]] double approach(const btCcdTracked& a, const btCcdTracked& b) const;
    void sweep(btCcdTracked& tracked);
    void findFast();
    void findSlow();
    bool takeNewCourse(btCcdTracked& tracked);
    void note(btCcdTracked& tracked);
    void addCandidates(int index);
    [[nodiscard]] static bool sweepsTo(const btCcdTracked& tracked, const btCcdTracked& other);
    void addNear(int index);
    void addSwept(int index);
    void listSwept(const std::vector<int>& objects);
    [[nodiscard]] bool sweepsBox(const btCcdTracked& tracked) const;
    void listNear();
    void addPair(int a, int b);
    Pair& push(int a, int b, double time);
    void look(Pair& pair);
    template <typename Visit>
    void forParts(const btCollisionObject& object, const Visit& visit);
    [[nodiscard]] static bool isSqueezed(const btCcdTracked& a, const btCcdTracked& b);
    [[nodiscard]] bool wanted(const btCcdTracked& a, const btCcdTracked& b) const;
    [[nodiscard]] bool canCross(const btCcdTracked& a, const btCcdTracked& b, double mayLose);
    [[nodiscard]] Question questionOf(Pair& pair);
    [[nodiscard]] bool isForThreads(const Question& question) const;
    void ask(std::span<Question> questions);
    [[nodiscard]] double askEarliest();
    [[nodiscard]] btCcdImpact impactOf(const Pair& pair, btScalar time) const;
};

#endif  // BT_CCD_STEPPER_H
