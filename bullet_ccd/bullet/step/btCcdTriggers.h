/// What passes through objects without contact response in a step.
#ifndef BT_CCD_TRIGGERS_H
#define BT_CCD_TRIGGERS_H

#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/motion/btCcdNeighbours.h"
#include "bullet_ccd/bullet/motion/btCcdObjectMotion.h"

#include <map>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

class btCcdContext;
class btCcdStepper;
struct btCcdPairToi;
struct btCcdTracked;

/// Keeps how the triggers and what is near them move, piece by piece (a piece ends where the course
/// of one of them changes), and asks when the step is done. So nothing is integrated in other
/// parts than without triggers, and the paths are those that were taken.
class btCcdTriggers
{
public:
    explicit btCcdTriggers(btCollisionWorld& world);

    /// False if there has been no trigger in the last step either: then begin() need not be called.
    [[nodiscard]] bool isActive() const { return m_isActive; }
    /// A step begins, or is done and about to be taken back; after stepper.begin().
    void begin(btCcdStepper& stepper, btScalar timeStep);
    /// After stepper.refresh(), which saw what moves otherwise from this time on.
    void changed(btCcdStepper& stepper, btScalar time);
    /// Asks for all of the step.
    void end();
    /// Null: nobody is told.
    void tell(btCcdImpactListener* listener);
    [[nodiscard]] const std::vector<btCcdPassage>& passages() const { return m_passages; }

private:
    /// An object in a piece.
    struct Path
    {
        btCollisionObject* m_object = nullptr;
        int m_proxy = 0;  // of the broadphase: another one if the object was removed and added
        bool m_isTrigger = false;
        bool m_isFixed = false;      // a static object, or a trigger at rest
        btCcdObjectMotion m_motion;  // from the piece's begin to the end of the step
        btCcdBox m_box;              // of that
    };
    struct Piece
    {
        double m_time = 0.0;
        std::vector<Path> m_paths;  // triggers first
        std::size_t m_triggers = 0;
        std::vector<std::unique_ptr<btCcdMultiBodyMotion>> m_multiBodies;
    };
    /// A trigger and another object.
    struct Key
    {
        btCollisionObject* m_trigger;
        int m_triggerProxy;
        btCollisionObject* m_object;
        int m_objectProxy;
        friend auto operator<=>(const Key&, const Key&) = default;
    };
    struct State
    {
        bool m_isInside = false;
        bool m_isSeen = false;   // in this piece
        bool m_isNear = false;   // in this step
        bool m_isStill = false;  // neither moved when they were asked for last, and were there:
        Eigen::Isometry3d m_poseOfTrigger = Eigen::Isometry3d::Identity();
        Eigen::Isometry3d m_poseOfObject = Eigen::Isometry3d::Identity();
        bool m_hasPassage = false;
        btCcdPassage m_passage{};
    };
    /// Of a trigger that Bullet does not move by a velocity.
    struct Place
    {
        int m_proxy = 0;
        btTransform m_pose = btTransform::getIdentity();
        double m_length = 0.0;  // of the way to there [m]
    };

    btCollisionWorld& m_world;
    btCcdContext& m_context;
    double m_timeStep = 0.0;
    bool m_isActive = false;
    std::vector<Piece> m_pieces;
    std::map<Key, State> m_states;  // of what is or was near
    std::unordered_map<const btCollisionObject*, Place> m_places;
    std::unordered_map<const btCollisionObject*, bullet_ccd::RigidMotion> m_ways;  // of these
    std::vector<btCcdPassage> m_passages;

    void readWays(const btCcdStepper& stepper);
    void addPiece(btCcdStepper& stepper, double time, const std::vector<int>* others);
    [[nodiscard]] bool goOn(const btCcdTracked& tracked, Path& path) const;
    [[nodiscard]] bool readPath(btCcdStepper& stepper,
                                const btCcdTracked& tracked,
                                Piece& piece,
                                Path& path);
    void ask(const Piece& piece, double end);
    void ask(const Path& trigger, const Path& object, const Piece& piece, double end);
    [[nodiscard]] bool mayMeet(const btCollisionObject& a, const btCollisionObject& b) const;
    [[nodiscard]] btCcdPairToi touch(const Path& a, const Path& b);
    [[nodiscard]] double lastTouch(const Path& a, const Path& b, double last);
    btCcdPassage& passageOf(State& state, const Key& key) const;
    [[nodiscard]] static bool isAsBefore(State& state, const Path& trigger, const Path& object);
    [[nodiscard]] static Key keyOf(const Path& trigger, const Path& object)
    {
        return {trigger.m_object, trigger.m_proxy, object.m_object, object.m_proxy};
    }
};

#endif  // BT_CCD_TRIGGERS_H
