#include "grasp/trial/grasp_trial.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/quality/object_mass.h"
#include "grasp/sim/trial_world.h"
#include "grasp/trial/trial_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <span>

namespace bullet_ccd::grasp
{
namespace
{
using Kind = TrialPhase::Kind;

constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kStandTime = 0.25;           // on the table, before the hand closes [s]
constexpr double kCloseTime = 1.0;            // [s]
constexpr double kMostCloseTime = 2.0;        // [s]
constexpr double kCloseShare = 0.1;           // of the squeeze's torques
constexpr double kLeastShare = 0.02;          // of the effort, of joints that do not squeeze
constexpr double kBeyond = 1e-3;              // of a joint beyond its limits [rad or m]
constexpr double kStalled = 0.05;             // of the speed of closing
constexpr double kTouchTime = 0.2;            // from the opened posture to that of the grasp [s]
constexpr double kRampTime = 0.25;            // [s]
constexpr double kSettleTime = 1.0;           // [s]
constexpr double kRestSpeed = 5e-3;           // [m/s]
constexpr double kRestSpin = 0.1;             // [rad/s]
constexpr double kPaceTime = 0.1;             // by which a pace is measured [s]
constexpr double kLeftWay = 1e-3;             // that may be left at that pace [m]
constexpr double kLeftTurn = std::numbers::pi / 180.0;  // same [rad]
constexpr double kDampingTime = 0.02;                   // damping over stiffness of the drives [s]
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kJointSpeed = 2.0;  // where the robot states none [rad/s or m/s]

/// Three digits.
std::string figure(double value)
{
    std::array<char, 32> buffer{};
    (void)std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
    return buffer.data();
}

/// A trial under way.
class Trial
{
public:
    Trial(const HandModel& hand,
          const GraspObject& object,
          const Grasp& grasp,
          const Squeeze& squeeze,
          const TrialProtocol& protocol,
          const TrialOptions& options,
          double mass,
          const TrialPosture& start,
          PenetrationCheck& check)
        : m_hand(hand),
          m_object(object),
          m_grasp(grasp),
          m_squeeze(squeeze),
          m_protocol(protocol),
          m_joints(independentJoints(hand.robot.tree)),
          m_X_WH(start.X_WH),
          m_from(start.positions),
          m_world(hand,
                  object,
                  {.mass = mass,
                   .friction = options.friction.value_or(options.squeeze.friction),
                   .margin = 0.5 * options.skin,
                   .stiffness = options.skinStiffness},
                  start.X_WH,
                  start.positions),
          m_check(check),
          m_timeStep(1.0 / options.rate),
          m_brief(options.brief),
          m_closesAsPlanned(options.closesAsPlanned),
          m_stop(options.stop),
          m_watch(options.watch)
    {
        m_R_WP = rotationBetween(Eigen::Vector3d::UnitZ(), options.up).toRotationMatrix();
        m_result.peakTorques.assign(m_joints.size(), 0.0);
        m_result.meanTorques.assign(m_joints.size(), 0.0);
        if (protocol.start == TrialStart::Table)
        {
            m_gravity = -kStandardGravity * m_R_WP.col(2);
            addTable(options.skin);
        }
    }

    /// @param before  how many phases of the protocol other worlds have
    TrialResult run(std::span<const TrialPhase> phases, std::ptrdiff_t before)
    {
        m_before = before;
        m_result.outcome = begin();
        if (m_result.outcome == TrialOutcome::Held)
        {
            m_result.outcome = load(phases);
        }
        if (m_isStopped)
        {
            m_result.outcome = TrialOutcome::Stopped;
            m_result.reason = "interrupted";
            return m_result;
        }
        if (isWithin())
        {
            m_result.moved = m_world.objectPose();
        }
        m_result.inexactSolves = m_world.solverCounters().failures;
        checkPenetration();
        return m_result;
    }

private:
    /// Held: the load may begin.
    TrialOutcome begin()
    {
        refer();
        checkPenetration();
        if (m_protocol.start == TrialStart::Table && !stands())
        {
            m_result.reason = "the object does not stand on the table by itself";
            return TrialOutcome::NotSettled;
        }
        if (m_protocol.start == TrialStart::Held || m_closesAsPlanned)
        {
            reach(m_protocol.start == TrialStart::Held ? kTouchTime : kCloseTime);
        }
        else
        {
            close();
        }
        checkPenetration();
        m_stage = "squeeze";
        const double began = m_result.seconds;
        while (goesOn() && m_result.seconds < began + kRampTime + kSettleTime &&
               !(m_result.seconds > began + 1.5 * kRampTime && isAtRest()))
        {
            press(std::min(1.0, (m_result.seconds - began) / kRampTime));
            step(m_gravity);
        }
        if (isLost())
        {
            m_result.lostAt = m_result.seconds;
            m_result.reason =
                m_result.seconds > began
                    ? "the squeeze pushed it away within " + figure(m_result.seconds - began) + " s"
                    : "closing pushed it away within " + figure(m_result.seconds) + " s";
            return TrialOutcome::Ejected;
        }
        if (!m_touched)
        {
            m_result.reason = "no contact pressed on it before the load";
            return TrialOutcome::NeverTouched;
        }
        if (!isAtRest())
        {
            m_result.reason = "it still moved at " + figure(1e3 * m_world.objectVelocity().norm()) +
                              " mm/s and " + figure(kDegrees * m_world.objectSpin().norm()) +
                              " degrees/s " + figure(m_result.seconds - began) +
                              " s after the squeeze began";
            return TrialOutcome::NotSettled;
        }
        return TrialOutcome::Held;
    }

    void addTable(double skin)
    {
        const Eigen::Vector3d up = m_R_WP.col(2);
        const double lowest = lowestHeight(m_object.tree, Eigen::Isometry3d::Identity(), up);
        m_world.addTable((lowest - skin) * up, up);
    }

    bool stands()
    {
        m_stage = "stand";
        holdJoints();
        while (!m_isStopped && m_result.seconds < kStandTime)
        {
            step(m_gravity);
        }
        return way() <= m_protocol.heldWay && turned() <= m_protocol.heldTurn;
    }

    /// Enough to move a joint, and too little to move the object much.
    [[nodiscard]] double gentle(std::size_t j) const
    {
        return std::max(kCloseShare * std::abs(m_squeeze.torques[j]),
                        kLeastShare * m_squeeze.efforts[j].limit);
    }

    /// In the first half of the time from the opened posture to that of the grasp, as far as the
    /// skins let the hand; from there the squeeze presses.
    void reach(double time)
    {
        m_stage = "close";
        const double began = m_result.seconds;
        while (!m_isStopped && m_result.seconds - began < time)
        {
            const double share = std::min(1.0, 2.0 * (m_result.seconds - began) / time);
            for (std::size_t j = 0; j < m_joints.size(); ++j)
            {
                const auto link = static_cast<std::size_t>(m_joints[j]);
                drive(
                    j, gentle(j), m_from[link] + share * (m_grasp.positions[link] - m_from[link]));
            }
            step(m_gravity);
        }
        m_from = m_world.positions();
    }

    /// Closes until all joints have stopped; the posture then is what the squeeze starts from.
    void close()
    {
        m_stage = "close";
        const std::vector<double> end = closedPositions(m_hand, m_from);
        const double began = m_result.seconds;
        holdJoints();
        std::vector<double> speeds(m_joints.size(), 0.0);
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            const auto link = static_cast<std::size_t>(m_joints[j]);
            if (m_hand.closingDirections[link] != 0 && end[link] != m_from[link])
            {
                speeds[j] = std::abs(end[link] - m_from[link]) / kCloseTime;
                drive(j, gentle(j), end[link], speeds[j]);
            }
        }
        bool isMoving = true;
        while (isMoving && goesOn() && m_result.seconds < began + kMostCloseTime)
        {
            const std::vector<double> before = m_world.positions();
            step(m_gravity);
            const std::vector<double> after = m_world.positions();
            isMoving = m_result.seconds < began + 0.25 * kCloseTime || !isAtRest();
            for (std::size_t j = 0; j < m_joints.size(); ++j)
            {
                const auto link = static_cast<std::size_t>(m_joints[j]);
                isMoving = isMoving || std::abs(after[link] - before[link]) >
                                           kStalled * speeds[j] * m_timeStep + 1e-9;
            }
        }
        m_from = m_world.positions();
    }

    TrialOutcome load(std::span<const TrialPhase> phases)
    {
        refer();
        m_stage = "load";
        const long paceSteps = std::lround(kPaceTime / m_timeStep);
        for (const TrialPhase& phase : phases)
        {
            const std::string place =
                "phase " + std::to_string(&phase - phases.data() + m_before + 1);
            TrialPull pull{.wrench = phase.wrench};
            if (phase.kind == Kind::Pull)
            {
                pull.wrench.normalize();
                m_normalForce = m_world.holdingForces().sum;
            }
            const double seconds = phase.kind == Kind::Pull ? 1.0 / kPullRate : phase.time;
            const long count = std::max(1L, std::lround(seconds / m_timeStep));
            Place before = objectPlace();
            for (long k = 0; k < count && !m_isStopped; ++k)
            {
                apply(phase, pull, static_cast<double>(k) * m_timeStep);
                addToMeans(1);
                const bool wasHeld = isWithin();
                watch();
                if (wasHeld && !isWithin())
                {
                    m_result.moved = m_world.objectPose();
                    m_result.reason = "first in " + place + ", after " +
                                      figure(static_cast<double>(k + 1) * m_timeStep) + " s";
                }
                const bool moved = way() > m_protocol.heldWay || turned() > m_protocol.heldTurn;
                if (phase.kind == Kind::Pull && moved)
                {
                    pull.slipped = true;
                    break;
                }
                if (isLost())
                {
                    m_result.lostAt = m_result.seconds;
                    return TrialOutcome::Dropped;
                }
                if (m_loadSteps % std::lround(1.0 / m_timeStep) == 0)
                {
                    checkPenetration();
                }
                if (phase.kind == Kind::Load && m_brief && (k + 1) % paceSteps == 0)
                {
                    const long left = count - 1 - k;
                    if (hardlyMoves(before,
                                    static_cast<double>(left) / static_cast<double>(paceSteps)))
                    {
                        addToMeans(left);
                        skip(left);
                        break;
                    }
                    before = objectPlace();
                }
            }
            m_world.moveTable(Eigen::Vector3d::Zero());
            m_base = phase.kind == Kind::Lift ? m_moved : m_base;
            m_moved = m_base;
            if (phase.kind == Kind::Pull && !m_isStopped)
            {
                m_result.pulls.push_back(pull);
            }
        }
        return isWithin() ? TrialOutcome::Held : TrialOutcome::Slipped;
    }

    /// Of so many steps under load in which forces and torques are what they are now.
    void addToMeans(long steps)
    {
        m_loadSteps += steps;
        const double share = static_cast<double>(steps) / static_cast<double>(m_loadSteps);
        m_result.meanForce += share * (m_world.holdingForces().sum - m_result.meanForce);
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            double& mean = m_result.meanTorques[j];
            mean += share * (std::abs(m_world.torque(m_joints[j])) - mean);
        }
    }

    /// It has been held so far.
    [[nodiscard]] bool isWithin() const
    {
        return m_result.slip <= m_protocol.heldWay && m_result.turn <= m_protocol.heldTurn;
    }

    /// One step of a phase, `time` after it began.
    void apply(const TrialPhase& phase, TrialPull& pull, double time)
    {
        const Eigen::Vector3d direction = m_R_WP * phase.direction.normalized();
        const Eigen::Vector3d up = m_R_WP.col(2);
        const Eigen::Vector3d down = -kStandardGravity * up;
        switch (phase.kind)
        {
            case Kind::Load:
                step(phase.amount * kStandardGravity * direction);
                return;
            case Kind::Shake:
            {
                const double omega = 2.0 * std::numbers::pi * phase.frequency;
                m_moved = m_base + phase.amount * std::sin(omega * time) * direction;
                step(down + phase.amount * omega * omega * std::sin(omega * time) * direction);
                return;
            }
            case Kind::Lift:
            {
                // By amount (1 - cos(pi t / T)) / 2.
                const double omega = std::numbers::pi / phase.time;
                const double size = 0.5 * phase.amount * omega;
                m_moved = m_base + 0.5 * phase.amount * (1.0 - std::cos(omega * time)) * up;
                m_world.moveTable(-size * std::sin(omega * time) * up);
                step(down - size * omega * std::cos(omega * time) * up);
                return;
            }
            case Kind::Pull:
                break;
        }
        const double size = kPullRate * time * m_normalForce;
        if (isAtRest())
        {
            pull.size = size;
            const double normals = m_world.holdingForces().sum;
            pull.share = normals > 0.0 ? size / normals : 0.0;
        }
        const Eigen::Vector3d force = size * (m_R_WP * pull.wrench.head<3>());
        const Eigen::Vector3d moment = size * m_object.radius * (m_R_WP * pull.wrench.tail<3>());
        step(Eigen::Vector3d::Zero(), force, moment);
    }

    void watch()
    {
        m_result.slip = std::max(m_result.slip, way());
        m_result.turn = std::max(m_result.turn, turned());
        m_result.peakEnergy = std::max(m_result.peakEnergy, m_world.objectEnergy());
    }

    void drive(std::size_t j,
               double effort,
               double target,
               double speed = std::numeric_limits<double>::infinity())
    {
        const auto link = static_cast<std::size_t>(m_joints[j]);
        const double stated = m_hand.robot.tree.links[link].joint.maxVelocity;
        const double most = stated > 0.0 && std::isfinite(stated) ? stated : kJointSpeed;
        m_world.drive(m_joints[j],
                      {.effort = effort,
                       .stiffness = m_squeeze.stiffness[j],
                       .damping = kDampingTime * m_squeeze.stiffness[j],
                       .maxSpeed = std::min(most, speed)},
                      target);
    }

    void holdJoints()
    {
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            drive(j, m_squeeze.efforts[j].limit, m_from[static_cast<std::size_t>(m_joints[j])]);
        }
    }

    /// Drives the joints to this share of the squeeze.
    void press(double share)
    {
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            const double from = m_from[static_cast<std::size_t>(m_joints[j])];
            drive(j,
                  m_squeeze.efforts[j].limit,
                  from + share * m_squeeze.torques[j] / m_squeeze.stiffness[j]);
        }
    }

    void step(const Eigen::Vector3d& acceleration,
              const Eigen::Vector3d& force = Eigen::Vector3d::Zero(),
              const Eigen::Vector3d& moment = Eigen::Vector3d::Zero())
    {
        m_isStopped = m_isStopped || m_stop.isDue();
        if (m_isStopped)
        {
            return;
        }
        m_world.step(m_timeStep, acceleration, force, moment);
        const HoldingForces forces = m_world.holdingForces();
        m_touched = m_touched || forces.points > 0;
        m_result.peakForce = std::max(m_result.peakForce, forces.largest);
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            m_result.peakTorques[j] =
                std::max(m_result.peakTorques[j], std::abs(m_world.torque(m_joints[j])));
        }
        tick(forces);
    }

    /// So many steps in which hardly anything moves.
    void skip(long steps)
    {
        m_result.skipped += steps;
        const HoldingForces forces = m_world.holdingForces();
        for (long k = 0; k < steps; ++k)
        {
            tick(forces);
        }
    }

    void tick(const HoldingForces& forces)
    {
        ++m_result.steps;
        m_result.seconds = static_cast<double>(m_result.steps) * m_timeStep;
        if (m_watch)
        {
            const Eigen::Translation3d moved(m_moved);
            m_watch({.stage = m_stage,
                     .time = m_result.seconds,
                     .X_WH = moved * m_X_WH,
                     .X_WO = moved * m_world.objectPose(),
                     .positions = m_world.positions(),
                     .touches = forces.points > 0});
        }
    }

    /// Of the object.
    struct Place
    {
        Eigen::Vector3d center;
        Eigen::Matrix3d axes;
    };
    [[nodiscard]] Place objectPlace() const
    {
        return {m_world.objectCenter(), m_world.objectPose().linear()};
    }
    /// @param paces  how often the way and the turn since `before` may come again
    [[nodiscard]] bool hardlyMoves(const Place& before, double paces) const
    {
        const Place now = objectPlace();
        const double way = paces * (now.center - before.center).norm();
        const double turn = paces * Eigen::AngleAxisd(before.axes.transpose() * now.axes).angle();
        return way <= kLeftWay && turn <= kLeftTurn && m_result.slip + way <= m_protocol.heldWay &&
               m_result.turn + turn <= m_protocol.heldTurn;
    }

    /// Motion is measured from here.
    void refer()
    {
        m_reference = m_world.objectPose();
        m_center = m_world.objectCenter();
    }
    [[nodiscard]] double way() const { return (m_world.objectCenter() - m_center).norm(); }
    [[nodiscard]] double turned() const
    {
        const Eigen::Matrix3d R = m_reference.linear().transpose() * m_world.objectPose().linear();
        return Eigen::AngleAxisd(R).angle();
    }
    [[nodiscard]] bool isLost() const { return !(way() <= m_protocol.lostWay); }
    [[nodiscard]] bool goesOn() const { return !m_isStopped && !isLost(); }
    [[nodiscard]] bool isAtRest() const
    {
        return m_world.objectVelocity().norm() < kRestSpeed &&
               m_world.objectSpin().norm() < kRestSpin;
    }

    void checkPenetration()
    {
        const PenetrationReport report =
            m_check.at(m_world.objectPose().inverse() * m_X_WH, m_world.positions());
        if (m_result.penetration.clean() || report.deepest > m_result.penetration.deepest)
        {
            m_result.penetration = report;
        }
    }

    const HandModel& m_hand;
    const GraspObject& m_object;
    const Grasp& m_grasp;
    const Squeeze& m_squeeze;
    const TrialProtocol& m_protocol;
    std::vector<std::int32_t> m_joints;
    Eigen::Isometry3d m_X_WH;
    std::vector<double> m_from;  ///< where the drives press from, one entry per link
    TrialWorld m_world;
    PenetrationCheck& m_check;
    double m_timeStep;
    bool m_brief;
    bool m_closesAsPlanned;
    Eigen::Matrix3d m_R_WP = Eigen::Matrix3d::Identity();
    Eigen::Vector3d m_gravity = Eigen::Vector3d::Zero();  ///< before the load
    Eigen::Isometry3d m_reference = Eigen::Isometry3d::Identity();
    Eigen::Vector3d m_center = Eigen::Vector3d::Zero();
    double m_normalForce = 0.0;  ///< before a pull [N]
    std::ptrdiff_t m_before = 0;
    bool m_touched = false;
    const StopCondition& m_stop;
    const std::function<void(const TrialFrame&)>& m_watch;
    std::string_view m_stage;
    Eigen::Vector3d m_base = Eigen::Vector3d::Zero();   ///< how far it was lifted before
    Eigen::Vector3d m_moved = Eigen::Vector3d::Zero();  ///< how far it is lifted or shaken
    bool m_isStopped = false;
    long m_loadSteps = 0;
    TrialResult m_result;
};

/// Adds what another world of the same trial came to.
void merge(TrialResult& all, const TrialResult& part)
{
    if (all.outcome == TrialOutcome::Held || part.outcome == TrialOutcome::Stopped)
    {
        all.outcome = part.outcome;
        all.reason = part.reason;
        all.lostAt = part.lostAt;
        all.moved = part.moved;
    }
    const double before = all.seconds;
    const double seconds = before + part.seconds;
    const double share = part.seconds / std::max(seconds, std::numeric_limits<double>::min());
    all.meanForce += share * (part.meanForce - all.meanForce);
    all.slip = std::max(all.slip, part.slip);
    all.turn = std::max(all.turn, part.turn);
    all.peakForce = std::max(all.peakForce, part.peakForce);
    all.peakEnergy = std::max(all.peakEnergy, part.peakEnergy);
    all.peakTorques.resize(part.peakTorques.size(), 0.0);
    all.meanTorques.resize(part.meanTorques.size(), 0.0);
    for (std::size_t j = 0; j < part.peakTorques.size(); ++j)
    {
        all.peakTorques[j] = std::max(all.peakTorques[j], part.peakTorques[j]);
        all.meanTorques[j] += share * (part.meanTorques[j] - all.meanTorques[j]);
    }
    all.pulls.insert(all.pulls.end(), part.pulls.begin(), part.pulls.end());
    if (all.penetration.clean() || part.penetration.deepest > all.penetration.deepest)
    {
        all.penetration = part.penetration;
    }
    all.seconds = seconds;
    all.steps += part.steps;
    all.skipped += part.skipped;
    all.inexactSolves += part.inexactSolves;
}
}  // namespace

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
        case TrialOutcome::Stopped:
            return "stopped";
        case TrialOutcome::NoSqueeze:
            break;
    }
    return "no squeeze";
}

namespace
{
void requireWithinLimits(const HandModel& hand, const Grasp& grasp)
{
    for (std::size_t i = 0; i < grasp.positions.size(); ++i)
    {
        const Joint& joint = hand.robot.tree.links[i].joint;
        const double q = grasp.positions[i];
        const bool hasLimits =
            joint.isMovable() && joint.mimicOf == kNone && joint.lower < joint.upper;
        require(std::isfinite(q) &&
                    (!hasLimits || (q >= joint.lower - kBeyond && q <= joint.upper + kBeyond)),
                "trial: candidate " + std::to_string(grasp.candidate) + ": joint " + joint.name +
                    " is at " + figure(q) + ", outside of its limits " + figure(joint.lower) +
                    " to " + figure(joint.upper) + ": correct the record");
    }
}
}  // namespace

TrialResult runTrial(const HandModel& hand,
                     const GraspObject& object,
                     const Grasp& grasp,
                     const TrialProtocol& protocol,
                     const TrialOptions& options)
{
    require(grasp.positions.size() == hand.robot.tree.size(),
            "trial: candidate " + std::to_string(grasp.candidate) + " never closed (" +
                toString(grasp.reject) + "): choose another one");
    requireWithinLimits(hand, grasp);
    require(std::isfinite(options.rate) && options.rate >= 60.0,
            "trial: " + std::to_string(options.rate) + " steps per second: give 60 or more");
    require(options.skin >= 1e-4 && options.skin <= 1e-2 && options.skinStiffness > 0.0 &&
                std::isfinite(options.skinStiffness),
            "trial: skins must be 0.1 to 10 mm thick and have a positive stiffness");
    require(options.up.allFinite() && options.up.norm() > 0.0,
            "trial: the direction that is up is 0 or not finite: give another one");
    checkProtocol(protocol);
    TrialResult result;
    SqueezeOptions squeezing = options.squeeze;
    squeezing.mass = massOf(object, options.squeeze.mass).mass;
    squeezing.centerOfMass = object.centerOfMass;
    const Squeeze squeeze = squeezeOf(hand, grasp, squeezing);
    if (!squeeze.exists())
    {
        result.reason = squeeze.reason;
        return result;
    }
    const TrialPosture start = protocol.start == TrialStart::Held
                                   ? heldStart(hand, object, grasp, options.skin)
                                   : openStart(hand,
                                               object,
                                               grasp,
                                               protocol,
                                               options.seed,
                                               options.skin,
                                               options.up.normalized());
    std::optional<PenetrationCheck> own;
    PenetrationCheck& check = options.check != nullptr ? *options.check : own.emplace(hand, object);
    if (!start.blocked.empty())
    {
        result.outcome = TrialOutcome::NeverTouched;
        result.reason = start.blocked;
        if (protocol.start == TrialStart::Held)
        {
            result.penetration = check.at(start.X_WH, start.positions);
        }
        return result;
    }
    result.outcome = TrialOutcome::Held;
    const auto isPull = [](const TrialPhase& phase) { return phase.kind == Kind::Pull; };
    // Every pull has a world of its own, and so has what is between pulls.
    auto first = protocol.phases.begin();
    while (first != protocol.phases.end())
    {
        const auto end =
            isPull(*first) ? first + 1 : std::find_if(first, protocol.phases.end(), isPull);
        Trial trial(hand, object, grasp, squeeze, protocol, options, *squeezing.mass, start, check);
        merge(result, trial.run({first, end}, first - protocol.phases.begin()));
        if (result.outcome == TrialOutcome::Stopped)
        {
            break;
        }
        first = end;
    }
    return result;
}
}  // namespace bullet_ccd::grasp
