#include "grasp/trial/grasp_trial.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/sim/trial_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kRampTime = 0.25;            // [s]
constexpr double kSettleTime = 1.0;           // [s]
constexpr double kRestSpeed = 5e-3;           // [m/s]
constexpr double kRestSpin = 0.1;             // [rad/s]
constexpr double kHeldWay = 0.010;            // [m]
constexpr double kHeldTurn = 15.0 * std::numbers::pi / 180.0;
constexpr double kLostWay = 0.100;     // [m]
constexpr double kDampingTime = 0.02;  // damping over stiffness of the drives [s]
constexpr double kJointSpeed = 2.0;    // where the robot states none [rad/s or m/s]
constexpr double kShakeWay = 0.020;    // [m]
constexpr double kShakeRate = 2.0;     // [1/s]
constexpr double kShakeTime = 2.0;     // along each axis [s]

double loadTime(TrialProtocol protocol)
{
    switch (protocol)
    {
        case TrialProtocol::Six:
            return 6.0;
        case TrialProtocol::Hover:
            return 10.0;
        case TrialProtocol::Shake:
            break;
    }
    return 3.0 * kShakeTime;
}

/// Acceleration of the free object relative to the hand at `time` under load.
Eigen::Vector3d loadAt(TrialProtocol protocol, double time)
{
    const Eigen::Vector3d down(0.0, 0.0, -kStandardGravity);
    switch (protocol)
    {
        case TrialProtocol::Six:
        {
            const int direction = std::min(static_cast<int>(time), 5);
            return (direction % 2 == 0 ? kStandardGravity : -kStandardGravity) *
                   Eigen::Vector3d::Unit(direction / 2);
        }
        case TrialProtocol::Hover:
            return down;
        case TrialProtocol::Shake:
            break;
    }
    const int axis = std::min(static_cast<int>(time / kShakeTime), 2);
    const double omega = 2.0 * std::numbers::pi * kShakeRate;
    return down + kShakeWay * omega * omega * std::sin(omega * time) * Eigen::Vector3d::Unit(axis);
}

/// A trial under way.
class Trial
{
public:
    Trial(const HandModel& hand,
          const GraspObject& object,
          const Grasp& grasp,
          const Squeeze& squeeze,
          const TrialOptions& options)
        : m_hand(hand),
          m_grasp(grasp),
          m_squeeze(squeeze),
          m_joints(independentJoints(hand.robot.tree)),
          m_world(hand,
                  object,
                  {.mass = options.squeeze.mass, .friction = options.squeeze.friction},
                  grasp.X_WH,
                  grasp.positions),
          m_check(hand, object),
          m_timeStep(1.0 / options.rate)
    {
        m_result.peakTorques.assign(m_joints.size(), 0.0);
    }

    TrialResult run(TrialProtocol protocol)
    {
        m_result.outcome = squeezeAndLoad(protocol);
        m_result.inexactSolves = m_world.solverCounters().failures;
        checkPenetration();
        return m_result;
    }

private:
    TrialOutcome squeezeAndLoad(TrialProtocol protocol)
    {
        m_reference = m_world.objectPose();
        m_center = m_world.objectCenter();
        const Eigen::Vector3d none = Eigen::Vector3d::Zero();
        while (m_result.seconds < kRampTime + kSettleTime &&
               !(m_result.seconds > 1.5 * kRampTime && isAtRest()))
        {
            press(std::min(1.0, m_result.seconds / kRampTime));
            step(none);
            if (way() > kLostWay)
            {
                m_result.lostAt = m_result.seconds;
                return TrialOutcome::Ejected;
            }
        }
        if (!m_touched)
        {
            return TrialOutcome::NeverTouched;
        }
        if (!isAtRest())
        {
            return TrialOutcome::NotSettled;
        }
        m_reference = m_world.objectPose();
        m_center = m_world.objectCenter();
        double force = 0.0;
        const long steps = std::lround(loadTime(protocol) / m_timeStep);
        const long second = std::lround(1.0 / m_timeStep);
        for (long k = 0; k < steps; ++k)
        {
            step(loadAt(protocol, static_cast<double>(k) * m_timeStep));
            force += m_world.holdingForces().sum;
            m_result.meanForce = force / static_cast<double>(k + 1);
            m_result.slip = std::max(m_result.slip, way());
            const Eigen::Matrix3d turned =
                m_reference.linear().transpose() * m_world.objectPose().linear();
            m_result.turn = std::max(m_result.turn, Eigen::AngleAxisd(turned).angle());
            m_result.peakEnergy = std::max(m_result.peakEnergy, m_world.objectEnergy());
            if (way() > kLostWay)
            {
                m_result.lostAt = m_result.seconds;
                return TrialOutcome::Dropped;
            }
            if (k % second == second - 1)
            {
                checkPenetration();
            }
        }
        return m_result.slip > kHeldWay || m_result.turn > kHeldTurn ? TrialOutcome::Slipped
                                                                     : TrialOutcome::Held;
    }

    /// Drives the joints to this share of the squeeze.
    void press(double share)
    {
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            const auto link = static_cast<std::size_t>(m_joints[j]);
            const double stated = m_hand.robot.tree.links[link].joint.maxVelocity;
            const double from = m_grasp.positions[link];
            m_world.drive(
                m_joints[j],
                {.effort = m_squeeze.efforts[j].limit,
                 .stiffness = m_squeeze.stiffness[j],
                 .damping = kDampingTime * m_squeeze.stiffness[j],
                 .maxSpeed = stated > 0.0 && std::isfinite(stated) ? stated : kJointSpeed},
                from + share * (m_squeeze.targets[j] - from));
        }
    }

    void step(const Eigen::Vector3d& acceleration)
    {
        m_world.step(m_timeStep, acceleration, Eigen::Vector3d::Zero());
        m_result.seconds += m_timeStep;
        const HoldingForces forces = m_world.holdingForces();
        m_touched = m_touched || forces.points > 0;
        m_result.peakForce = std::max(m_result.peakForce, forces.largest);
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            m_result.peakTorques[j] =
                std::max(m_result.peakTorques[j], std::abs(m_world.torque(m_joints[j])));
        }
    }

    [[nodiscard]] double way() const { return (m_world.objectCenter() - m_center).norm(); }

    [[nodiscard]] bool isAtRest() const
    {
        return m_world.objectVelocity().norm() < kRestSpeed &&
               m_world.objectSpin().norm() < kRestSpin;
    }

    void checkPenetration()
    {
        const PenetrationReport report =
            m_check.at(m_world.objectPose().inverse() * m_grasp.X_WH, m_world.positions());
        if (m_result.penetration.clean() || report.deepest > m_result.penetration.deepest)
        {
            m_result.penetration = report;
        }
    }

    const HandModel& m_hand;
    const Grasp& m_grasp;
    const Squeeze& m_squeeze;
    std::vector<std::int32_t> m_joints;
    TrialWorld m_world;
    PenetrationCheck m_check;
    double m_timeStep;
    Eigen::Isometry3d m_reference = Eigen::Isometry3d::Identity();
    Eigen::Vector3d m_center = Eigen::Vector3d::Zero();
    bool m_touched = false;
    TrialResult m_result;
};
}  // namespace

const char* toString(TrialProtocol protocol)
{
    switch (protocol)
    {
        case TrialProtocol::Six:
            return "six";
        case TrialProtocol::Hover:
            return "hover";
        case TrialProtocol::Shake:
            break;
    }
    return "shake";
}

const char* toString(TrialOutcome outcome)
{
    switch (outcome)
    {
        case TrialOutcome::Held:
            return "held";
        case TrialOutcome::Slipped:
            return "slipped";
        case TrialOutcome::Dropped:
            return "dropped";
        case TrialOutcome::Ejected:
            return "ejected";
        case TrialOutcome::NeverTouched:
            return "never touched";
        case TrialOutcome::NotSettled:
            return "did not settle";
        case TrialOutcome::NoSqueeze:
            break;
    }
    return "no squeeze";
}

TrialResult runTrial(const HandModel& hand,
                     const GraspObject& object,
                     const Grasp& grasp,
                     TrialProtocol protocol,
                     const TrialOptions& options)
{
    require(grasp.positions.size() == hand.robot.tree.size(),
            "trial: candidate " + std::to_string(grasp.candidate) + " never closed (" +
                toString(grasp.reject) + "): choose another one");
    require(std::isfinite(options.rate) && options.rate >= 60.0,
            "trial: " + std::to_string(options.rate) + " steps per second: give 60 or more");
    const Squeeze squeeze = squeezeOf(hand, grasp, options.squeeze);
    if (!squeeze.exists())
    {
        TrialResult result;
        result.reason = squeeze.reason;
        return result;
    }
    return Trial(hand, object, grasp, squeeze, options).run(protocol);
}
}  // namespace bullet_ccd::grasp
