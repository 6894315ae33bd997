/// A hand that closes on one object and opens again, in a Bullet world under the exact check.
#pragma once

#include "benchmarks/reference/audit/world_audit.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/soak/bullet_soaks.h"
#include "benchmarks/soak/household_bin.h"
#include "bullet_ccd/examples/example_support.h"
#include "grasp/sim/hand_multi_body.h"
#include "grasp/sim/hand_pairs.h"

#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
using grasp::HandModel;
using reference::AuditMesh;
using reference::AuditResult;
using reference::Random;
using reference::WorldAudit;

/// One hand and one object, no gravity.
class HandScene
{
public:
    /// Refers to both.
    HandScene(const HandModel& hand, const HouseholdObject& object, const HandSoak& soak);
    ~HandScene();
    HandScene(const HandScene&) = delete;
    HandScene& operator=(const HandScene&) = delete;

    /// Puts the object before the hand, closes, holds, opens. True if the hand held something.
    bool close(Random& random);

    [[nodiscard]] const AuditResult& seen() const { return m_seen; }
    [[nodiscard]] const btCcdControl& control() { return m_world.ccd(); }
    [[nodiscard]] const std::vector<std::string>& names() const { return m_names; }
    [[nodiscard]] WorldAudit::Busiest busiest() const { return m_audit.busiestPair(); }

private:
    const HandModel& m_hand;
    double m_timeStep;
    grasp::HandPairs m_pairs;
    grasp::HandMultiBody m_body;
    std::vector<std::shared_ptr<const AuditMesh>> m_linkMeshes;  // one a link, null without
    examples::World m_world{examples::Engine::Ccd};
    WorldAudit m_audit;
    std::vector<std::string> m_names;              // by number in the audit
    std::vector<btMultiBodyJointMotor*> m_motors;  // one a link, null if fixed
    std::vector<std::unique_ptr<btMultiBodyConstraint>> m_constraints;
    std::vector<double> m_open;
    std::vector<double> m_closed;
    const HouseholdObject& m_kind;
    btRigidBody* m_object = nullptr;
    AuditResult m_seen;

    void addLinks();
    void addMotors();
    void place(Random& random);
    [[nodiscard]] bool isClear(const Eigen::Isometry3d& X_WO) const;
    void move(double seconds, double from, double to);
    [[nodiscard]] bool touches();
};
}  // namespace bullet_ccd::benchmarks
