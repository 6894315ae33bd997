/// The way of a world through a step.
#ifndef BT_CCD_STEP_H
#define BT_CCD_STEP_H

#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/step/btCcdBody.h"
#include "bullet_ccd/bullet/step/btCcdImpactSolver.h"
#include "bullet_ccd/bullet/step/btCcdProgress.h"
#include "bullet_ccd/bullet/step/btCcdPushes.h"
#include "bullet_ccd/bullet/step/btCcdSpins.h"
#include "bullet_ccd/bullet/step/btCcdStepper.h"
#include "bullet_ccd/bullet/step/btCcdTriggers.h"

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

class btCcdContext;

/// From impact to impact: what the worlds do while they integrate a step, and what the action does
/// to one that is done. btCcdControl says what that promises.
class btCcdStep
{
public:
    using Integrate = btCcdProgress::Integrate;
    /// An impact and where its colliders were then.
    struct SeenImpact
    {
        btCcdImpact m_impact;
        btTransform m_poseA;
        btTransform m_poseB;
    };

    explicit btCcdStep(btDiscreteDynamicsWorld& world);

    btCcdStepper& stepper() { return m_stepper; }
    const btCcdStepper& stepper() const { return m_stepper; }
    void setBudget(const btCcdBudget& budget) { m_budget = budget; }
    void setListener(btCcdImpactListener* listener) { m_listener = listener; }
    [[nodiscard]] const std::vector<btCcdPassage>& passages() const
    {
        return m_triggers.passages();
    }
    void teleported(const btCollisionObject& object);
    void stopOnFirstContact(btMultiBody* body, int link) { m_stopLinks.insert({body, link}); }
    [[nodiscard]] const btCcdCounters& counters() const { return m_counters; }
    [[nodiscard]] double lostTime(const btCollisionObject* object) const;
    void resetCounters();
    /// Of the last step, the first thousand.
    [[nodiscard]] const std::vector<SeenImpact>& impacts() const { return m_lastImpacts; }

    /// As btCcdControl has them.
    void noteBeforeSolving() { m_pushes.noteBeforeSolving(); }
    [[nodiscard]] bool begin(btScalar timeStep);
    void integrate(btScalar timeStep, const Integrate& integrate);
    void end();
    void rollBack(btScalar timeStep);

private:
    /// How a body fares in a step.
    struct Fate
    {
        int m_impacts = 0;
        btScalar m_instant = -1;  // the time of the last one,
        int m_atInstant = 0;      // and how many came then
        int m_carries = 0;
        int m_solvings = 0;
        std::optional<btCcdYield> m_yield;       // but settling
        std::optional<btCcdVelocities> m_own;    // before it was stopped
        std::optional<btCcdVelocities> m_after;  // of what is carried
        const btCollisionObject* m_carrier = nullptr;
        int m_chain = 0;  // of bodies between the carrier and what it carries
    };

    btDiscreteDynamicsWorld& m_world;
    btCcdContext& m_context;
    btCcdSpins m_spins;
    btCcdProgress m_progress;
    btCcdStepper m_stepper;
    btCcdImpactSolver m_solver;
    btCcdPushes m_pushes;
    btCcdTriggers m_triggers;
    btCcdImpactListener* m_listener = nullptr;
    btCcdBudget m_budget;
    btCcdCounters m_counters;
    std::vector<SeenImpact> m_lastImpacts;
    std::map<btCcdBody, double> m_lostTimes;
    std::set<std::pair<btMultiBody*, int>> m_stopLinks;
    std::map<btCcdBody, Fate> m_fates;  // of this step
    /// What meets something again and again: under the action, in the worlds kinematic objects and
    /// what meets its limit.
    struct Stuck
    {
        int m_count = 0;  // of steps,
        int m_step = 0;   // and the last one;
        int m_jams = 0;   // of steps in a row in which that came at once,
        int m_jamStep = 0;
    };
    std::map<btCcdBody, Stuck> m_stuck;
    std::vector<btCollisionObject*> m_pushed;  // by kinematic objects, at the present time
    int m_step = 1;
    int m_impacts = 0;
    btScalar m_timeStep = 0;
    std::chrono::steady_clock::time_point m_begin;
    std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, int> m_pairEvents;
    std::vector<std::pair<btRigidBody*, btScalar>> m_stockThresholds;

    [[nodiscard]] bool findImpacts(btScalar timeStep);
    void takeBack(btScalar timeStep);
    void beginTriggers(btScalar timeStep);
    void notePushed();
    void takeStarts();
    void takeBackPushes(btScalar timeStep);
    void suspendStockClamping();
    void releaseStopped();
    void respond(const btCcdStepper::Event& event, btScalar remaining);
    void solve(const std::vector<btCcdImpact>& impacts, btCcdAnswer answer);
    void calmDown(btCollisionObject* object);
    [[nodiscard]] bool isDone(const btCcdImpact& impact, btScalar remaining);
    [[nodiscard]] double share(const btCcdImpact& impact) const;
    [[nodiscard]] bool isSpent(double share) const;
    bool settle(const btCcdImpact& impact);
    void part(const btCcdImpact& impact, btScalar drag);
    [[nodiscard]] bool liesOnDriver(const btCcdImpact& impact);
    [[nodiscard]] bool isJammed(const btCcdImpact& impact);
    void forgetStuck();
    [[nodiscard]] Stuck countStuck(const btCcdImpact& impact, bool isEarly);
    [[nodiscard]] bool countSolving(const btCcdImpact& impact);
    [[nodiscard]] bool meetsLimit(const btCcdImpact& impact);
    bool stopWatchedLink(const btCollisionObject* object, int link);
    void yield(const btCcdImpact& impact, btScalar remaining);
    void holdBack(btCollisionObject* object, btScalar remaining);
    bool hold(const btCcdImpact& impact, btCollisionObject* object, btScalar remaining);
    [[nodiscard]] const btCollisionObject* carrierIn(const btCcdImpact& impact, int side);
    bool carry(const btCcdImpact& impact,
               int side,
               const btCollisionObject& carrier,
               btScalar remaining);
    void squeeze(const btCcdImpact& impact, btCollisionObject* object);
    void tell(const btCollisionObject* object, btCcdYield how, const btCcdImpact& impact);
    void keepStopped(const btCcdBody& body);
    void keepCarried(const btCcdBody& body);
    [[nodiscard]] static bool isStopped(const Fate& fate)
    {
        return fate.m_yield && fate.m_yield != btCcdYield::Carried;
    }
    bool placeBack(btCollisionObject* object);
    [[nodiscard]] bool isDriving(const btCollisionObject& object);
    void answerBack(const btCcdStepper::Event& event, btScalar remaining);
    [[nodiscard]] bool isPile(const btCcdImpact& impact, const std::vector<btCcdImpact>& impacts);
    void letGo(btCollisionObject* object, btScalar remaining);
    [[nodiscard]] bool isFirstPush(const btCcdImpact& impact);
    void push(const btCcdImpact& impact, btScalar remaining, bool isStuck);
    bool carryAlong(const btCcdImpact& impact, btScalar remaining);
    bool solveBack(const std::vector<btCcdImpact>& impacts, btCcdAnswer answer, btScalar remaining);
    void goOn(btCollisionObject* object, btScalar remaining);
    void countHold(const btCcdBody& body, btScalar remaining);
    void countQueries();
    void note(const btCcdImpact& impact);
};

#endif  // BT_CCD_STEP_H
