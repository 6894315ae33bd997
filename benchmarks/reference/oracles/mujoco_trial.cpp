#include "benchmarks/reference/oracles/mujoco_trial.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/trial/trial_start.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <mutex>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <unistd.h>

namespace bullet_ccd::reference
{
namespace
{
namespace fs = std::filesystem;
using grasp::TrialOutcome;
using Axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

// Of grasp_trial.cpp.
constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr double kStandTime = 0.25;           // [s]
constexpr double kCloseTime = 1.0;            // [s]
constexpr double kMostCloseTime = 2.0;        // [s]
constexpr double kCloseShare = 0.1;
constexpr double kLeastShare = 0.02;
constexpr double kTouchTime = 0.2;   // [s]
constexpr double kRampTime = 0.25;   // [s]
constexpr double kSettleTime = 1.0;  // [s]
constexpr double kRestSpeed = 5e-3;  // [m/s]
constexpr double kRestSpin = 0.1;    // [rad/s]
constexpr double kSkin = 1e-3;       // [m]

constexpr double kFollow = 0.02;  // of the error of a torque, in a step

constexpr int kTableBit = 2;  // of contype and conaffinity: tables meet the object alone

/// MuJoCo reads meshes from files alone. What is written here goes with it, whatever happens.
struct ScratchFolder
{
    std::string path = (fs::temp_directory_path() / "bullet_ccd_XXXXXX").string();

    ScratchFolder()
    {
        if (mkdtemp(path.data()) == nullptr)
        {
            throw std::runtime_error(path + ": cannot be made: set TMPDIR");
        }
    }
    ~ScratchFolder()
    {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
};

mjModel* compiled(const grasp::HandModel& hand,
                  const grasp::GraspObject& object,
                  const grasp::Grasp& grasp,
                  const grasp::Squeeze& squeeze,
                  const grasp::MjcfPieces& pieces)
{
    const ScratchFolder scratch;
    grasp::writeMjcfMeshes(fs::path(scratch.path) / "meshes", pieces);
    const std::string file = scratch.path + "/grasp.xml";
    std::ostringstream model;
    grasp::writeMjcf(model, hand, object, grasp, squeeze, pieces, {.mass = 1.0});
    std::string text = model.str();
    const std::string world = "<worldbody>";
    text.insert(text.find(world) + world.size(),
                R"(<geom name="table" type="plane" pos="0 0 -1" size="1 1 1" contype="0" )"
                R"(conaffinity="0"/>)");
    std::ofstream(file) << text;
    char error[1000] = "";
    static std::mutex mutex;  // MuJoCo keeps the last file that it read
    const std::scoped_lock lock(mutex);
    mjModel* compiled = mj_loadXML(file.c_str(), nullptr, error, sizeof error);
    if (compiled == nullptr)
    {
        throw std::runtime_error(hand.robot.name + ", " + object.name + ": MuJoCo: " + error);
    }
    return compiled;
}
}  // namespace

MujocoTrials::MujocoTrials(const grasp::HandModel& hand,
                           const grasp::GraspObject& object,
                           const grasp::Grasp& grasp,
                           const grasp::Squeeze& squeeze,
                           const grasp::MjcfPieces& pieces)
    : m_hand(hand),
      m_object(object),
      m_model(compiled(hand, object, grasp, squeeze, pieces), &mj_deleteModel),
      m_data(mj_makeData(m_model.get()), &mj_deleteData),
      m_joints(grasp::independentJoints(hand.robot.tree)),
      m_table(mj_name2id(m_model.get(), mjOBJ_GEOM, "table")),
      m_body(m_model->nbody - 1),
      m_inertia(m_model->body_inertia + 3 * m_body)
{
    for (int geom = 0; geom < m_model->ngeom; ++geom)
    {
        m_model->geom_conaffinity[geom] |= m_model->geom_bodyid[geom] == m_body ? kTableBit : 0;
    }
    for (const Link& link : hand.robot.tree.links)
    {
        const std::string name = link.joint.isMovable() ? link.joint.name : "";
        const int joint = mj_name2id(m_model.get(), mjOBJ_JOINT, name.c_str());
        m_places.push_back(joint < 0 ? -1 : m_model->jnt_qposadr[joint]);
    }
}

void MujocoTrials::begin(const std::vector<double>& positions,
                         double mass,
                         double friction,
                         double torsion)
{
    m_model->body_mass[m_body] = mass;
    Eigen::Map<Eigen::Vector3d>(m_model->body_inertia + 3 * m_body) = mass * m_inertia;
    for (int geom = 0; geom < m_model->ngeom; ++geom)
    {
        m_model->geom_friction[3 * geom] = friction;
        m_model->geom_friction[3 * geom + 1] = torsion;
        m_model->geom_condim[geom] = torsion > 0.0 ? 4 : 3;
    }
    mj_setConst(m_model.get(), m_data.get());
    mj_resetData(m_model.get(), m_data.get());
    for (std::size_t i = 0; i < m_places.size(); ++i)
    {
        if (m_places[i] >= 0)
        {
            m_data->qpos[m_places[i]] = positions[i];
        }
    }
    mj_forward(m_model.get(), m_data.get());
    refer();
}

void MujocoTrials::drive(std::size_t joint, double effort, double target)
{
    m_model->actuator_forcerange[2 * joint] = -effort;
    m_model->actuator_forcerange[2 * joint + 1] = effort;
    m_data->ctrl[joint] = target;
}

void MujocoTrials::step(const Eigen::Vector3d& force)
{
    Eigen::Map<Eigen::Vector3d>(m_data->xfrc_applied + 6 * m_body) = force;
    mj_step(m_model.get(), m_data.get());
}

Eigen::Vector3d MujocoTrials::center() const
{
    return Eigen::Map<const Eigen::Vector3d>(m_data->xipos + 3 * m_body);
}

double MujocoTrials::turned() const
{
    return Eigen::AngleAxisd(m_axes.transpose() * Axes(m_data->xmat + 9 * m_body)).angle();
}

void MujocoTrials::refer()
{
    m_center = center();
    m_axes = Axes(m_data->xmat + 9 * m_body);
}

bool MujocoTrials::touches() const
{
    return std::any_of(m_data->contact,
                       m_data->contact + m_data->ncon,
                       [this](const mjContact& c)
                       { return c.geom1 != m_table && c.geom2 != m_table; });
}

bool MujocoTrials::isAtRest() const
{
    mjtNum speed[6];
    mj_objectVelocity(m_model.get(), m_data.get(), mjOBJ_BODY, m_body, speed, 0);
    return mju_norm3(speed + 3) < kRestSpeed && mju_norm3(speed) < kRestSpin;
}

grasp::TrialResult MujocoTrials::run(const grasp::Grasp& grasp,
                                     const grasp::Squeeze& squeeze,
                                     const grasp::TrialProtocol& protocol,
                                     double mass,
                                     double friction,
                                     double torsion)
{
    grasp::TrialResult result;
    result.reason = squeeze.reason;
    if (!squeeze.exists())
    {
        return result;
    }
    const bool isHeld = protocol.start == grasp::TrialStart::Held;
    const grasp::TrialPosture start =
        isHeld ? grasp::heldStart(m_hand, m_object, grasp, kSkin)
               : grasp::openStart(m_hand, m_object, grasp, protocol, 1, kSkin);
    if (!start.blocked.empty())
    {
        result.outcome = TrialOutcome::NeverTouched;
        result.reason = start.blocked;
        return result;
    }
    const Eigen::Quaterniond q(start.X_WH.linear());
    Eigen::Map<Eigen::Vector3d>(m_model->body_pos + 3) = start.X_WH.translation();
    Eigen::Map<Eigen::Vector4d>(m_model->body_quat + 4) << q.w(), q.vec();
    const bool stands = protocol.start == grasp::TrialStart::Table;
    m_model->geom_contype[m_table] = stands ? kTableBit : 0;
    double& table = m_model->geom_pos[3 * m_table + 2];
    table = INFINITY;
    for (const Eigen::Vector3d& vertex : m_object.tree.mesh().vertices)
    {
        table = std::min(table, vertex.z());
    }
    begin(start.positions, mass, friction, torsion);
    const auto drives = [&](auto&& set)
    {
        for (std::size_t j = 0; j < m_joints.size(); ++j)
        {
            set(j, static_cast<std::size_t>(m_joints[j]));
        }
    };
    const Eigen::Vector3d weight(0.0, 0.0, stands ? -mass * kStandardGravity : 0.0);
    const double& time = m_data->time;
    const auto follow = [&](const std::vector<double>& end, double share)
    {
        drives(
            [&](std::size_t j, std::size_t link)
            {
                const double from = start.positions[link];
                drive(j,
                      std::max(kCloseShare * std::abs(squeeze.torques[j]),
                               kLeastShare * squeeze.efforts[j].limit),
                      from + share * (end[link] - from));
            });
        step(weight);
    };
    while (stands && time < kStandTime)
    {
        drives([&](std::size_t j, std::size_t link)
               { drive(j, squeeze.efforts[j].limit, start.positions[link]); });
        step(weight);
    }
    if (way() > protocol.heldWay || turned() > protocol.heldTurn)
    {
        result.outcome = TrialOutcome::NotSettled;
        result.reason = "the object does not stand on the table by itself";
        return result;
    }
    if (isHeld)
    {
        while (time < kTouchTime)
        {
            follow(grasp.positions, std::min(1.0, 2.0 * time / kTouchTime));
        }
    }
    else
    {
        // As fast as ours; joints that are stopped are pressed gently, and others may come.
        const std::vector<double> end = grasp::closedPositions(m_hand, start.positions);
        const double began = time;
        while (time < began + kMostCloseTime && way() <= protocol.lostWay)
        {
            follow(end, std::min(1.0, (time - began) / kCloseTime));
        }
    }
    const double pressed = time;
    std::vector<double> from;
    drives([&](std::size_t, std::size_t link) { from.push_back(m_data->qpos[m_places[link]]); });
    while (way() <= protocol.lostWay && time < pressed + kRampTime + kSettleTime &&
           !(time > pressed + 1.5 * kRampTime && isAtRest()))
    {
        const double share = std::min(1.0, (time - pressed) / kRampTime);
        drives(
            [&](std::size_t j, std::size_t)
            {
                // Contacts give way by more than skins do, so the targets go on until the
                // controllers press with the squeeze's torques; they never yield.
                const double torque = share * squeeze.torques[j];
                const double error = torque - m_data->actuator_force[j];
                from[j] += error * torque > 0.0 ? kFollow * error / squeeze.stiffness[j] : 0.0;
                drive(j, squeeze.efforts[j].limit, from[j] + torque / squeeze.stiffness[j]);
            });
        step(weight);
    }
    result.outcome = way() > protocol.lostWay ? TrialOutcome::Ejected
                     : !touches()             ? TrialOutcome::NeverTouched
                     : !isAtRest()            ? TrialOutcome::NotSettled
                                              : TrialOutcome::Held;
    refer();
    double end = time;
    for (const grasp::TrialPhase& phase : protocol.phases)
    {
        require(phase.kind == grasp::TrialPhase::Kind::Load ||
                    phase.kind == grasp::TrialPhase::Kind::Lift,
                "MujocoTrials: only loads and lifts are known: give another protocol");
        const double began = end;
        const double height = table;
        end += phase.time;
        while (result.outcome == TrialOutcome::Held && time < end)
        {
            Eigen::Vector3d acceleration =
                phase.amount * kStandardGravity * phase.direction.normalized();
            if (phase.kind == grasp::TrialPhase::Kind::Lift)
            {
                // The hand stays: the table sinks, and what accelerates the hand acts on the
                // object.
                const double omega = std::numbers::pi / phase.time;
                const double turn = omega * (time - began);
                table = height - 0.5 * phase.amount * (1.0 - std::cos(turn));
                acceleration.x() = acceleration.y() = 0.0;
                acceleration.z() =
                    -kStandardGravity - 0.5 * phase.amount * omega * omega * std::cos(turn);
            }
            step(mass * acceleration);
            result.slip = std::max(result.slip, way());
            result.turn = std::max(result.turn, turned());
            const bool isWithin =
                result.slip <= protocol.heldWay && result.turn <= protocol.heldTurn;
            if (!isWithin && result.reason.empty())
            {
                result.reason = fmt::format("first in phase {}, after {:.3g} s",
                                            &phase - protocol.phases.data() + 1,
                                            time - began);
            }
            if (!(way() <= protocol.lostWay))
            {
                result.outcome = TrialOutcome::Dropped;
            }
        }
    }
    if (result.outcome == TrialOutcome::Held && !result.reason.empty())
    {
        result.outcome = TrialOutcome::Slipped;
    }
    return result;
}
}  // namespace bullet_ccd::reference
