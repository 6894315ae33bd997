/// The way of a world through a step.
#ifndef BT_CCD_STEP_H
#define BT_CCD_STEP_H

#include "bullet_ccd/bullet/btCcdControl.h"
#include "bullet_ccd/bullet/step/btCcdBody.h"
#include "bullet_ccd/bullet/step/btCcdImpactSolver.h"
#include "bullet_ccd/bullet/step/btCcdSpins.h"
#include "bullet_ccd/bullet/step/btCcdStepper.h"

#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

class btCcdContext;

/// From impact to impact: what the worlds do while they integrate a step, and what the action does
/// to one that is done. btCcdControl says what that promises.
class btCcdStep
{
public:
    using Integrate = std::function<void(btScalar)>;
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
    void setMaxEvents(int maxEvents) { m_maxEvents = maxEvents; }
    void setListener(btCcdImpactListener* listener) { m_listener = listener; }
    void stopOnFirstContact(btMultiBody* body, int link) { m_stopLinks.insert({body, link}); }
    [[nodiscard]] const btCcdCounters& counters() const { return m_counters; }
    [[nodiscard]] double lostTime(const btCollisionObject* object) const;
    void resetCounters();
    /// Of the last step.
    [[nodiscard]] const std::vector<SeenImpact>& impacts() const { return m_lastImpacts; }

    /// As btCcdControl has them.
    [[nodiscard]] bool begin(btScalar timeStep);
    void integrate(btScalar timeStep, const Integrate& integrate);
    void end();
    void rollBack(btScalar timeStep);

private:
    btDiscreteDynamicsWorld& m_world;
    btCcdStepper m_stepper;
    btCcdImpactSolver m_solver;
    btCcdSpins m_spins;
    btCcdImpactListener* m_listener = nullptr;
    int m_maxEvents = btCcdControl::kDefaultMaxEvents;
    btCcdCounters m_counters;
    std::vector<SeenImpact> m_lastImpacts;
    std::map<btCcdBody, double> m_lostTimes;
    std::set<std::pair<btMultiBody*, int>> m_stopLinks;
    std::map<btCcdBody, int> m_events;  // of this step
    std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, int> m_pairEvents;
    std::vector<btCcdVelocities> m_held;  // at rest for the remainder of the step
    std::vector<std::pair<btRigidBody*, btScalar>> m_stockThresholds;

    void suspendStockClamping();
    void integrateInPieces(btScalar time, const Integrate& integrate);
    void releaseHeld();
    void respond(const btCcdStepper::Event& event, btScalar remaining);
    void solve(const std::vector<btCcdImpact>& impacts, bool bouncing);
    void calmDown(btCollisionObject* object);
    [[nodiscard]] bool isDone(const btCcdImpact& impact, btScalar remaining);
    bool settle(const btCcdImpact& impact);
    [[nodiscard]] bool meetsLimit(const btCcdImpact& impact);
    bool stopWatchedLink(const btCollisionObject* object, int link);
    void hold(btCollisionObject* object, btScalar remaining);
    void placeBack(btCollisionObject* object, btScalar remaining);
    void countHold(const btCcdBody& body, btScalar remaining);
    void countQueries();
    void note(const btCcdImpact& impact);
};

#endif  // BT_CCD_STEP_H
