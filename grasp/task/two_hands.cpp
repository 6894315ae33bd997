#include "grasp/task/two_hands.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/planner/plan_candidate.h"
#include "grasp/task/firm_grasps.h"
#include "grasp/task/task_legs.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kStandardGravity = 9.80665;  // [m/s^2]
/// Candidates of an arm that are paired, and pairs of which epsilon is computed, at most.
constexpr std::size_t kReached = 40;
constexpr std::size_t kScored = 400;
/// Mean normals of two hands that press towards each other: their product is below this.
constexpr double kOpposed = -0.5;

Vector3d meanNormal(const Grasp& grasp)
{
    Vector3d sum = Vector3d::Zero();
    for (const GraspContact& contact : grasp.contacts)
    {
        sum += contact.normal;
    }
    return sum.normalized();
}

Vector3d meanPoint(const Grasp& grasp)
{
    Vector3d sum = Vector3d::Zero();
    for (const GraspContact& contact : grasp.contacts)
    {
        sum += contact.point;
    }
    return sum / double(grasp.contacts.size());
}

/// What one hand can do by itself: come straight, touch, and go up.
struct OneSide
{
    Grasp grasp;
    JointPositions posture;
    std::vector<JointPositions> approach;  // ends at the posture
    std::vector<JointPositions> lift;
};

struct ScoredPair
{
    std::array<const OneSide*, 2> sides;
    double epsilon;
};

class TwoHandPlanner
{
public:
    TwoHandPlanner(const TwoHandTask& task, const TwoHandOptions& options)
        : m_task(task),
          m_options(options.common),
          m_objection(options.objection),
          m_body(task.arms.whole)
    {
        for (const PlacedArm& arm : task.arms.arms)
        {
            m_kinematics.emplace_back(arm.robot->tree, arm.robot->handRoot, arm.X_WR);
        }
        for (std::size_t i = 0; i < task.obstacles.size(); ++i)
        {
            m_scene.add(
                *task.obstacles[i].tree, task.obstacles[i].motion.X_W0, task.obstacleNames[i]);
        }
        m_scene.finish();
        m_plan.mass = massOf(task.object, m_options.grasps.mass);
        m_options.grasps.mass = m_plan.mass.mass;
        m_options.grasps.efforts = task.arms.efforts;
        m_plan.X_WOStart = task.X_WO;
        m_plan.X_WOStart.translation().z() += m_options.gap;
        m_before = m_scene;
        m_before.add(task.object.tree, m_plan.X_WOStart, task.object.name);
        m_before.finish();
    }

    TwoHandPlan run()
    {
        requireFreeStart();
        const std::array<std::vector<OneSide>, 2> sides{sidesOf(0), sidesOf(1)};
        const std::vector<ScoredPair> pairs = pairsOf(sides);
        m_plan.pairs = std::ptrdiff_t(pairs.size());
        for (const ScoredPair& pair : pairs)
        {
            if (std::ptrdiff_t(m_plan.attempts.size()) == m_options.graspsTried || isStopped())
            {
                break;
            }
            const auto [leg, reason] = tryPair(pair);
            m_plan.attempts.push_back(
                {{pair.sides[0]->grasp.candidate, pair.sides[1]->grasp.candidate}, leg, reason});
            if (leg.empty())
            {
                m_plan.solved = true;
                return std::move(m_plan);
            }
        }
        m_plan.stopped = isStopped();
        m_plan.failure =
            m_plan.stopped ? "stopped after " + std::to_string(m_plan.attempts.size()) + " pairs"
            : m_plan.reached[0] == 0 || m_plan.reached[1] == 0
                ? "the " + std::string(m_plan.reached[0] == 0 ? "left" : "right") +
                      " arm brings its hand to no candidate that touches the object"
            : pairs.empty() ? "no two hands hold the object together"
                            : "none of the pairs that were tried (" +
                                  std::to_string(m_plan.attempts.size()) + ") can be carried out";
        return std::move(m_plan);
    }

private:
    [[nodiscard]] bool isStopped() const { return m_options.stop.isDue(); }
    [[nodiscard]] const PlacedArm& armOf(std::size_t side) const { return m_task.arms.arms[side]; }

    void requireFreeStart()
    {
        for (std::size_t i = 0; i < m_scene.bodies.size(); ++i)
        {
            const double distance =
                treeDistance(m_task.object.tree,
                             *m_scene.bodies[i].tree,
                             m_scene.bodies[i].motion.X_W0.inverse() * m_plan.X_WOStart,
                             m_options.gap)
                    .distance;
            require(distance > 0.5 * m_options.gap,
                    "two hands: " + m_task.object.name + " intersects " + m_scene.names[i] +
                        " where it starts: correct its pose");
        }
        std::array<JointPositions, 2> moved = m_task.start;
        moved[0][0] += 1e-6;
        moved[1][0] += 1e-6;
        const std::array open{armOf(0).hand->preshapes.front().positions,
                              armOf(1).hand->preshapes.front().positions};
        TaskLeg leg =
            legOf("start",
                  {m_task.arms.positions(m_task.start, open), m_task.arms.positions(moved, open)},
                  false);
        const std::string touched =
            certifyLeg(m_body, Isometry3d::Identity(), m_before, leg, 0.0, m_work);
        require(touched.empty(),
                "two hands: the robot is in collision where it starts: " + touched +
                    ": place the arms elsewhere");
    }

    /// Candidates that touch, hold nothing alone, and that the arm can bring the hand to.
    std::vector<OneSide> sidesOf(std::size_t side)
    {
        const HandModel& hand = *armOf(side).hand;
        const Isometry3d X_OW = m_plan.X_WOStart.inverse();
        std::vector<RigidBody> inObject;
        for (const RigidBody& body : m_scene.bodies)
        {
            inObject.push_back({.tree = body.tree, .motion = restAt(X_OW * body.motion.X_W0)});
        }
        PlannerOptions asked = m_options.grasps;
        asked.efforts.clear();
        const bool isSame = side == 1 && armOf(0).hand == armOf(1).hand;
        if (!isSame)
        {
            m_candidates =
                planGrasps(hand,
                           m_task.object,
                           asked,
                           [&] { return kinematicClosing(inObject); },
                           {.obstacles = inObject, .stop = [this] { return isStopped(); }});
            std::ranges::sort(m_candidates, {}, &Grasp::candidate);
        }
        std::vector<OneSide> sides;
        for (const Grasp& grasp : m_candidates)
        {
            if (grasp.reject == RejectReason::None)
            {
                m_plan.singleHanded += isSame ? 0 : 1;
                continue;
            }
            const bool touches = (grasp.reject == RejectReason::NoForceClosure ||
                                  grasp.reject == RejectReason::TooFewContacts) &&
                                 !grasp.contacts.empty();
            m_plan.touching[side] += touches ? 1 : 0;
            if (touches && sides.size() < kReached && !isStopped())
            {
                if (auto found = sideOf(side, grasp))
                {
                    sides.push_back(*std::move(found));
                }
            }
        }
        m_plan.reached[side] = std::ptrdiff_t(sides.size());
        return sides;
    }

    [[nodiscard]] std::optional<OneSide> sideOf(std::size_t side, const Grasp& grasp)
    {
        const ArmKinematics& arm = m_kinematics[side];
        const auto postures =
            arm.solve(m_plan.X_WOStart * grasp.X_WH, m_task.start[side], {.seed = m_options.seed});
        const Vector3d towards = m_plan.X_WOStart.linear() * grasp.approach_W;
        const std::vector<double>& open =
            findPreshape(*armOf(side).hand, grasp.preshape)->positions;
        for (const JointPositions& posture : postures)
        {
            OneSide found{.grasp = grasp,
                          .posture = posture,
                          .approach = straightPath(arm, posture, -m_options.approach * towards),
                          .lift = straightPath(arm, posture, {0.0, 0.0, m_options.lift})};
            if (found.approach.empty() || found.lift.empty())
            {
                continue;
            }
            std::ranges::reverse(found.approach);
            std::array<JointPositions, 2> joints = m_task.start;
            std::array hands{armOf(0).hand->preshapes.front().positions,
                             armOf(1).hand->preshapes.front().positions};
            hands[side] = open;
            std::vector<std::vector<double>> way;
            for (const JointPositions& q : found.approach)
            {
                joints[side] = q;
                way.push_back(m_task.arms.positions(joints, hands));
            }
            TaskLeg leg = legOf("approach", way, false);
            if (certifyLeg(m_body, Isometry3d::Identity(), m_before, leg, 0.0, m_work).empty())
            {
                return found;
            }
        }
        return std::nullopt;
    }

    /// As of one hand, closed.
    [[nodiscard]] Grasp unionOf(const std::array<const OneSide*, 2>& sides) const
    {
        Grasp both;
        both.X_WH = m_plan.X_WOStart.inverse();
        both.positions =
            m_task.arms.positions({sides[0]->posture, sides[1]->posture},
                                  {sides[0]->grasp.positions, sides[1]->grasp.positions});
        for (std::size_t side = 0; side < 2; ++side)
        {
            for (GraspContact contact : sides[side]->grasp.contacts)
            {
                contact.link = m_task.arms.linkOf(side, armOf(side).robot->ofHand(contact.link));
                both.contacts.push_back(contact);
            }
        }
        return both;
    }

    /// Force closures of one hand of each arm, best first.
    [[nodiscard]] std::vector<ScoredPair> pairsOf(
        const std::array<std::vector<OneSide>, 2>& sides) const
    {
        struct Chance
        {
            ScoredPair pair;
            double score;
        };
        std::vector<Chance> chances;
        for (const OneSide& left : sides[0])
        {
            for (const OneSide& right : sides[1])
            {
                const Vector3d a = meanNormal(left.grasp);
                const Vector3d b = meanNormal(right.grasp);
                // How well the line between the hands lies in the directions in which they press.
                const Vector3d line = (meanPoint(right.grasp) - meanPoint(left.grasp)).normalized();
                if (a.dot(b) < kOpposed)
                {
                    chances.push_back({{{&left, &right}, 0.0}, line.dot(a) - line.dot(b)});
                }
            }
        }
        std::ranges::stable_sort(
            chances, [](const Chance& x, const Chance& y) { return x.score > y.score; });
        std::vector<ScoredPair> pairs;
        for (std::size_t i = 0; i < std::min(chances.size(), kScored) && !isStopped(); ++i)
        {
            ScoredPair pair = chances[i].pair;
            pair.epsilon = epsilonOf(unionOf(pair.sides), m_task.object, m_options.grasps);
            if (pair.epsilon >= m_options.grasps.forceClosureThreshold)
            {
                pairs.push_back(pair);
            }
        }
        std::ranges::stable_sort(
            pairs, [](const ScoredPair& x, const ScoredPair& y) { return x.epsilon > y.epsilon; });
        return pairs;
    }

    [[nodiscard]] TaskLeg legOf(const std::string& name,
                                const std::vector<std::vector<double>>& positions,
                                bool carries) const
    {
        return {
            .name = name,
            .carries = carries,
            .waypoints = timedWaypoints(m_task.arms.whole.robot.tree, positions, 0.0, m_options)};
    }

    std::string certified(const RobotBody& body,
                          const NamedSurroundings& around,
                          TaskLeg leg,
                          double margin)
    {
        std::string touched = certifyLeg(body, Isometry3d::Identity(), around, leg, margin, m_work);
        m_plan.legs.push_back(std::move(leg));
        return touched;
    }

    /// Name of what fails and why; empty names: it is the plan.
    std::pair<std::string, std::string> tryPair(const ScoredPair& pair)
    {
        const TwoArms& arms = m_task.arms;
        m_plan.legs.clear();
        m_plan.grasp = unionOf(pair.sides);
        m_plan.grasp.quality.epsilon = pair.epsilon;
        m_plan.grasp.quality.forceClosure = true;
        for (std::size_t side = 0; side < 2; ++side)
        {
            m_plan.aloneEpsilon[side] = pair.sides[side]->grasp.quality.epsilon;
        }
        if (std::string weak = squeeze(); !weak.empty())
        {
            return {"squeeze", weak};
        }
        const auto& [left, right] = pair.sides;
        const std::array open{findPreshape(*armOf(0).hand, left->grasp.preshape)->positions,
                              findPreshape(*armOf(1).hand, right->grasp.preshape)->positions};
        const auto rowsOf = [&](const auto& a, const auto& b, const auto& hands)
        {
            std::vector<std::vector<double>> rows;
            for (std::size_t i = 0; i < a.size(); ++i)
            {
                rows.push_back(arms.positions({a[i], b[i]}, hands));
            }
            return rows;
        };
        m_plan.legs.emplace_back();  // transit, when all else is known to be possible
        if (std::string touched =
                certified(m_body,
                          m_before,
                          legOf("approach", rowsOf(left->approach, right->approach, open), false),
                          0.0);
            !touched.empty())
        {
            return {"approach", touched};
        }
        if (std::string touched =
                certified(m_body, m_before, legOf("close", closingRows(pair), false), 0.0);
            !touched.empty())
        {
            return {"close", touched};
        }
        const std::array closed{left->grasp.positions, right->grasp.positions};
        m_plan.X_HO = m_kinematics[0].poseAt(left->posture).inverse() * m_plan.X_WOStart;
        RobotBody carrying(arms.whole);
        std::vector<std::int32_t> tested;
        for (std::size_t side = 0; side < 2; ++side)
        {
            for (std::int32_t link = 0; link < armOf(side).robot->handRoot; ++link)
            {
                tested.push_back(arms.linkOf(side, link));
            }
        }
        carrying.carry(arms.handRoot(0), tested, m_task.object, m_plan.X_HO);
        if (std::string touched =
                certified(carrying,
                          m_scene,
                          legOf("lift", rowsOf(left->lift, right->lift, closed), true),
                          0.0);
            !touched.empty())
        {
            return {"lift", touched};
        }
        if (std::string failed = transit(open, {left->approach.front(), right->approach.front()});
            !failed.empty())
        {
            return {"transit", failed};
        }
        followOn(m_plan.legs);
        std::string objection = m_objection ? m_objection(m_plan) : "";
        return {objection.empty() ? "" : "simulation", objection};
    }

    /// Of all joints, and what it is for; or why there is none.
    std::string squeeze()
    {
        const TwoArms& arms = m_task.arms;
        const double mass = m_plan.mass.mass;
        m_plan.squeeze = squeezeOf(arms.whole,
                                   m_plan.grasp,
                                   {.mass = mass,
                                    .centerOfMass = m_task.object.centerOfMass,
                                    .friction = m_options.grasps.friction,
                                    .firmness = m_options.firmness,
                                    .efforts = arms.efforts});
        if (!m_plan.squeeze.exists())
        {
            return m_plan.squeeze.reason;
        }
        m_plan.grasp.quality.largestMass =
            massHeldBySqueeze(arms.whole, m_task.object, m_plan.grasp, m_options);
        if (!(*m_plan.grasp.quality.largestMass >= m_options.holds * mass))
        {
            return "holds " + std::to_string(*m_plan.grasp.quality.largestMass) + " kg, not " +
                   std::to_string(m_options.holds * mass);
        }
        ForceProblem problem{.contacts = m_plan.grasp.contacts,
                             .law = {.friction = m_options.grasps.friction},
                             .reference = m_task.object.centerOfMass,
                             .jacobian = handJacobian(arms.whole.robot.tree,
                                                      m_plan.grasp.X_WH,
                                                      m_plan.grasp.positions,
                                                      m_plan.grasp.contacts),
                             .torqueLimits = arms.efforts};
        problem.load.head<3>() =
            m_plan.X_WOStart.linear().transpose() * Vector3d(0.0, 0.0, -mass * kStandardGravity);
        const GraspForces forces = solveGraspForces(problem);
        if (forces.status != ForceStatus::Balanced)
        {
            return "the weight: " + forces.reason;
        }
        m_plan.forces = {.squeeze = m_plan.squeeze.normalForce};
        Vector3d left = Vector3d::Zero();
        for (std::size_t i = 0; i < forces.contacts.size(); ++i)
        {
            const bool isRight = m_plan.grasp.contacts[i].link >= arms.first[1];
            m_plan.forces.normal[isRight ? 1 : 0] += forces.contacts[i].normal;
            left += isRight ? Vector3d::Zero() : m_plan.squeeze.forces[i];
        }
        m_plan.forces.internal = left.norm();
        for (std::size_t j = 0; j < arms.efforts.size(); ++j)
        {
            m_plan.forces.effort =
                std::max(m_plan.forces.effort, std::abs(forces.jointTorques[j]) / arms.efforts[j]);
        }
        return {};
    }

    /// Both hands, whose joints begin and end when they do alone.
    [[nodiscard]] std::vector<std::vector<double>> closingRows(const ScoredPair& pair) const
    {
        const auto& [left, right] = pair.sides;
        const std::array spans{
            closingSpans(*armOf(0).hand, left->grasp, m_options.grasps.closing),
            closingSpans(*armOf(1).hand, right->grasp, m_options.grasps.closing)};
        std::vector<double> times = closingTimes(spans[0]);
        const std::vector<double> others = closingTimes(spans[1]);
        times.insert(times.end(), others.begin(), others.end());
        std::ranges::sort(times);
        std::vector<std::vector<double>> rows;
        for (const double time : times)
        {
            rows.push_back(
                m_task.arms.positions({left->posture, right->posture},
                                      {closingAt(spans[0], left->grasp.positions, time),
                                       closingAt(spans[1], right->grasp.positions, time)}));
        }
        return rows;
    }

    std::string transit(const std::array<std::vector<double>, 2>& hands,
                        const std::array<JointPositions, 2>& to)
    {
        const auto joined = [](const std::array<JointPositions, 2>& q)
        {
            JointPositions all = q[0];
            all.insert(all.end(), q[1].begin(), q[1].end());
            return all;
        };
        const std::vector<std::int32_t> joints = m_task.arms.joints();
        const JointPathResult found = planJointPath(
            {.body = m_body.body(),
             .environment = &m_before.environment,
             .joints = joints,
             .positions = m_task.arms.positions(m_task.start, hands),
             .toi = {.tolerance = kDefaultTolerance, .minimumSeparation = m_options.margin}},
            joined(m_task.start),
            joined(to),
            {.seed = m_options.seed, .stop = m_options.stop});
        if (!found.failure.empty())
        {
            return found.failure;
        }
        std::vector<std::vector<double>> rows;
        for (const JointPositions& q : found.waypoints)
        {
            const auto middle = q.begin() + std::ptrdiff_t(m_task.start[0].size());
            rows.push_back(
                m_task.arms.positions({{{q.begin(), middle}, {middle, q.end()}}}, hands));
        }
        TaskLeg leg = legOf("transit", rows, false);
        std::string touched =
            certifyLeg(m_body, Isometry3d::Identity(), m_before, leg, m_options.margin, m_work);
        m_plan.legs.front() = std::move(leg);
        return touched;
    }

    const TwoHandTask& m_task;
    PickPlaceOptions m_options;
    const std::function<std::string(const TwoHandPlan&)>& m_objection;
    RobotBody m_body;
    std::vector<ArmKinematics> m_kinematics;
    NamedSurroundings m_scene;   // without the object
    NamedSurroundings m_before;  // with the object where it starts
    std::vector<Grasp> m_candidates;
    ToiWorkspace m_work;
    TwoHandPlan m_plan;
};
}  // namespace

TwoHandPlan planTwoHands(const TwoHandTask& task, const TwoHandOptions& options)
{
    for (std::size_t side = 0; side < 2; ++side)
    {
        require(task.start[side].size() == task.arms.arms[side].robot->joints.size(),
                "two hands: give one start position for each joint of each arm");
        require(std::ranges::all_of(task.start[side], [](double q) { return std::isfinite(q); }),
                "two hands: a start position is not finite");
    }
    require(task.obstacles.size() == task.obstacleNames.size(),
            "two hands: give one name for each obstacle");
    require(task.X_WO.matrix().allFinite(), "two hands: the pose of the object is not finite");
    const PickPlaceOptions& common = options.common;
    require(common.gap > 0.0 && common.approach > 0.0 && common.lift > 0.0 &&
                common.acceleration > 0.0 && common.freeSpeed > 0.0,
            "two hands: the gap, the ways of approach and lift, the acceleration and the speed "
            "must be positive");
    return TwoHandPlanner(task, options).run();
}

TaskState stateAt(const TwoHandTask& task, const TwoHandPlan& plan, double time)
{
    TaskState state;
    while (state.leg + 1 < plan.legs.size() && plan.legs[state.leg].waypoints.back().time < time)
    {
        ++state.leg;
    }
    const TaskLeg& leg = plan.legs[state.leg];
    const KinematicTree& tree = task.arms.whole.robot.tree;
    std::vector<double> positions = leg.waypoints.front().positions;
    if (leg.waypoints.size() > 1)
    {
        positions =
            positionsAt(trajectoryThrough(tree, Isometry3d::Identity(), leg.waypoints), time);
        applyMimics(tree, positions);
    }
    state.X_W = linkPoses(tree, Isometry3d::Identity(), positions);
    state.X_WO = leg.carries
                     ? state.X_W[static_cast<std::size_t>(task.arms.handRoot(0))] * plan.X_HO
                     : plan.X_WOStart;
    return state;
}
}  // namespace bullet_ccd::grasp
