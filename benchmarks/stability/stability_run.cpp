#include "benchmarks/stability/stability_run.h"

#include "benchmarks/reference/bullet/direct_solver.h"
#include "benchmarks/reference/bullet/mechanics.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btLemkeSolver.h>
#ifdef BT_USE_DOUBLE_PRECISION
#include "grasp/sim/holding_solver.h"
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;

/// How often the exact check looks at a world: all that happens before it rests, and less often
/// then, for it takes longer than a step.
constexpr int kBusyLooks = 120;       // [1/s]
constexpr int kRestLooks = 10;        // [1/s]
constexpr double kBesideHand = 0.04;  ///< fingers do not reach what is so far off [m]
constexpr double kGone = 0.5;         ///< what is so far from the hand does not come back [m]
constexpr double kFar = 2.0;          ///< nothing gets there [m]

/// In place of Bullet's sweeps; null: the scene keeps those.
std::unique_ptr<btMultiBodyConstraintSolver> useSolver(btDiscreteDynamicsWorld& world,
                                                       StabilitySolver kind)
{
    std::unique_ptr<btMultiBodyConstraintSolver> solver;
    if (kind == StabilitySolver::Dantzig)
    {
        solver = std::make_unique<reference::DirectSolver<btDantzigSolver>>();
    }
    else if (kind == StabilitySolver::Lemke)
    {
        solver = std::make_unique<reference::DirectSolver<btLemkeSolver>>();
    }
#ifdef BT_USE_DOUBLE_PRECISION
    else if (kind == StabilitySolver::Holding)
    {
        solver = std::make_unique<grasp::HoldingSolver>();
        grasp::HoldingSolver::configure(world.getSolverInfo());
    }
#endif
    if (solver)
    {
        static_cast<btMultiBodyDynamicsWorld&>(world).setMultiBodyConstraintSolver(solver.get());
    }
    return solver;
}

class Run
{
public:
    Run(const StabilityWorld& world, const StabilitySetting& setting)
        : m_world(world),
          m_setting(setting),
          m_trial(world.make(setting.kind)),
          m_timeStep(1.0 / setting.rate),
          m_steps(static_cast<std::int64_t>(std::lround(setting.seconds * setting.rate)))
    {
        m_trial->scene.world().getSolverInfo().m_numIterations = setting.iterations;
        m_solver = useSolver(m_trial->scene.world(), setting.solver);
        m_trial->scene.addHooks();
        m_startEnergy = reference::energyOf(m_trial->scene, 0.0);
    }

    StabilityOutcome go()
    {
        double micros = 0.0;
        for (std::int64_t step = 0; step < m_steps && !m_isOver; ++step)
        {
            const double time = static_cast<double>(step) * m_timeStep;
            m_trial->control(time, m_timeStep);
            micros += microsecondsOf([this] { m_trial->scene.step(m_timeStep); });
            m_outcome.simulated = time + m_timeStep;
            look(step);
        }
        m_outcome.realTime = 1e-6 * micros / std::max(m_outcome.simulated, m_timeStep);
        m_outcome.counters = m_trial->scene.counters();
        m_outcome.lostTime = m_trial->scene.lostTime();
        m_outcome.meanKinetic /= static_cast<double>(std::max<std::int64_t>(m_looks, 1));
        judge();
        return m_outcome;
    }

private:
    const StabilityWorld& m_world;
    const StabilitySetting& m_setting;
    std::unique_ptr<btMultiBodyConstraintSolver> m_solver;
    std::unique_ptr<Trial> m_trial;
    double m_timeStep;
    std::int64_t m_steps;
    double m_startEnergy = 0.0;
    StabilityOutcome m_outcome;
    Isometry3d m_restPose = Isometry3d::Identity();
    bool m_isResting = false;
    bool m_isThrough = false;
    bool m_isOver = false;  // exploded, or what was held is gone
    std::int64_t m_looks = 0;

    [[nodiscard]] Isometry3d objectPose() const
    {
        return btCcdToEigen(m_trial->object->getWorldTransform());
    }

    /// False for what nothing in these worlds can have come to by itself.
    [[nodiscard]] bool isSane(const reference::BodyPoses& poses, double kinetic) const
    {
        const bool isNear = std::ranges::all_of(
            poses,
            [](const Isometry3d& X)
            { return X.matrix().allFinite() && X.translation().norm() < kFar; });
        const btRigidBody* object = m_trial->object;
        const double speed = object != nullptr ? double(object->getLinearVelocity().length()) : 0.0;
        const bool gains = m_world.isPassive && !(kinetic < 2.0 * m_startEnergy);
        return isNear && std::isfinite(kinetic) && speed < kRunaway && !gains;
    }

    void look(std::int64_t step)
    {
        reference::BodyPoses poses;
        for (const btCollisionObject* object : m_trial->audited)
        {
            poses.push_back(btCcdToEigen(object->getWorldTransform()));
        }
        const double kinetic = reference::energyOf(m_trial->scene, 0.0);
        if (m_world.isPassive)
        {
            m_outcome.energyGain = std::max(m_outcome.energyGain, kinetic / m_startEnergy - 1.0);
        }
        if (!isSane(poses, kinetic))
        {
            m_outcome.verdict = StabilityVerdict::Exploded;
            m_isOver = true;
            return;
        }
        m_isThrough = m_isThrough || m_trial->isThrough();
        m_isOver = m_trial->object != nullptr && objectPose().translation().norm() > kGone;
        const bool isResting = m_outcome.simulated >= m_trial->readyAt;
        if (isResting)
        {
            noteRest(kinetic);
        }
        const int every = std::max(1, m_setting.rate / (isResting ? kRestLooks : kBusyLooks));
        if (m_world.isPassive || step % every == 0 || step + 1 == m_steps)
        {
            const double depth =
                reference::auditPoses(m_trial->audit, poses, m_outcome.simulated).worst.depth;
            m_outcome.depth = std::max(m_outcome.depth, depth);
            m_outcome.restDepth = std::max(m_outcome.restDepth, isResting ? depth : 0.0);
        }
    }

    void noteRest(double kinetic)
    {
        ++m_looks;
        m_outcome.meanKinetic += kinetic;
        m_outcome.maxKinetic = std::max(m_outcome.maxKinetic, kinetic);
        if (!m_isResting && m_trial->object != nullptr)
        {
            m_restPose = objectPose();
        }
        m_isResting = true;
    }

    void judge()
    {
        if (m_outcome.verdict == StabilityVerdict::Exploded)
        {
            return;
        }
        if (m_trial->object != nullptr)
        {
            const Isometry3d moved = m_restPose.inverse() * objectPose();
            m_outcome.drift = moved.translation().norm();
            m_outcome.turn = Eigen::AngleAxisd(moved.linear()).angle();
            // It may have been lost before rest was expected.
            const double away = std::abs(objectPose().translation().z());
            if (m_outcome.drift > kSlip)
            {
                m_outcome.verdict = StabilityVerdict::Slipped;
            }
            if (m_outcome.drift > kDrop || away > kBesideHand)
            {
                m_outcome.verdict = StabilityVerdict::Dropped;
            }
        }
        if (m_isThrough)
        {
            m_outcome.verdict = StabilityVerdict::Through;
        }
    }
};
}  // namespace

const char* toString(StabilityVerdict verdict)
{
    constexpr std::array kNames{"held", "slipped", "dropped", "through", "exploded"};
    return kNames[static_cast<std::size_t>(verdict)];
}

StabilityOutcome runStability(const StabilityWorld& world, const StabilitySetting& setting)
{
    return Run(world, setting).go();
}

nlohmann::json toJson(const StabilityWorld& world,
                      const StabilitySetting& setting,
                      const StabilityOutcome& outcome)
{
    constexpr std::array kSolvers{"", ", holding solver", ", Dantzig", ", Lemke"};
    const std::string solver = kSolvers[static_cast<std::size_t>(setting.solver)];
    nlohmann::json row{{"world", world.name},
                       {"method", reference::nameOf(setting.kind) + solver},
                       {"rate", setting.rate},
                       {"iterations", setting.iterations},
                       {"seconds", setting.seconds},
                       {"verdict", toString(outcome.verdict)}};
    const auto add = [&](const char* name, double value)
    {
        if (std::isfinite(value))
        {
            row[name] = value;
        }
    };
    add("simulated", outcome.simulated);
    add("drift", outcome.drift);
    add("turn", outcome.turn);
    add("meanKinetic", outcome.meanKinetic);
    add("maxKinetic", outcome.maxKinetic);
    add("energyGain", outcome.energyGain);
    add("depth", outcome.depth);
    add("restDepth", outcome.restDepth);
    add("realTime", outcome.realTime);
    if (reference::isOurs(setting.kind))
    {
        row["impacts"] = outcome.counters.m_impacts;
        row["clamps"] = outcome.counters.m_clamps;
        row["overlaps"] = outcome.counters.m_overlaps;
        row["iterationLimits"] = outcome.counters.m_iterationLimits;
        add("lostTime", outcome.lostTime);
    }
    return row;
}
}  // namespace bullet_ccd::benchmarks
