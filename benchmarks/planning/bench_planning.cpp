/// Motions and plans of an arm, alone, with a hand, and of two in clutter: certified, and by OMPL's
/// discrete validator on FCL at 1 % (its default) and 0.1 % of the extent of the space.
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/support/checkpoint.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/ompl/certified_planning.h"
#include "bullet_ccd/trajectory/trajectory.h"
#include "grasp/task/two_arms.h"
#include "tools/grasp_cli/options/robot_options.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>
#include <optional>
#include <tuple>

namespace bullet_ccd::benchmarks
{
namespace
{
namespace ob = ::ompl::base;
namespace og = ::ompl::geometric;

struct Options
{
    int scenes = 10;
    int edges = 300;
    int problems = 10;
    double limit = 0.25;
    std::string checkpoint;
    std::string arm = "seven_joint_arm";
    std::string hand = "three_finger_gripper";
};

using Configuration = std::vector<double>;  ///< of the planned joints

/// What is planned: bodies that joints move, and the pairs of them that are tested. The hierarchies
/// must outlive it.
struct PlannedRobot
{
    std::string name;
    KinematicTree tree;
    std::vector<const SsvTree*> links;
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;
    std::vector<std::int32_t> joints;
    std::vector<Eigen::Vector3d> feet{Eigen::Vector3d::Zero()};  ///< of the arms
};

std::vector<double> positionsOf(const PlanningScene& scene, std::span<const double> q)
{
    std::vector<double> positions = scene.positions;
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        positions[static_cast<std::size_t>(scene.joints[k])] = q[k];
    }
    applyMimics(*scene.body.tree, positions);
    return positions;
}

/// Rods and plates of 1 to 4 cm about the robot, which must outlive it. Their middles are clear of
/// the feet of its arms: what stands in an arm that cannot evade it would leave nothing free.
class ClutteredRobot
{
public:
    explicit ClutteredRobot(const PlannedRobot& robot, std::uint64_t seed, int obstacles = 24);
    ClutteredRobot(const ClutteredRobot&) = delete;
    ClutteredRobot& operator=(const ClutteredRobot&) = delete;

    [[nodiscard]] const std::shared_ptr<const CertifiedRobot>& robot() const { return m_robot; }

    /// Whether no two surfaces overlap that the planned joints move relative to each other, by FCL.
    [[nodiscard]] bool isFreeByFcl(std::span<const double> q) const;

    [[nodiscard]] Configuration freeConfiguration(reference::Random& random) const;

private:
    struct FclPart
    {
        FclModel model;
        Eigen::Vector3d center;  ///< of the sphere around it, in its own frame
        double radius;

        explicit FclPart(const SsvTree& tree)
            : model(tree.mesh()), center(tree.origin()), radius(tree.radius())
        {
        }
    };

    const PlannedRobot& m_planned;
    std::vector<SsvTree> m_obstacles;
    Environment m_environment;
    std::shared_ptr<const CertifiedRobot> m_robot;
    std::vector<std::optional<FclPart>> m_parts;  ///< links, if they have geometry, then obstacles
    /// Pairs of parts that move relative to each other.
    std::vector<std::pair<std::size_t, std::size_t>> m_pairs;
};
ClutteredRobot::ClutteredRobot(const PlannedRobot& robot, std::uint64_t seed, int obstacles)
    : m_planned(robot)
{
    reference::Random random(seed);
    std::vector<RigidBody> bodies;
    m_obstacles.reserve(static_cast<std::size_t>(obstacles));
    for (int i = 0; i < obstacles; ++i)
    {
        const double half = random.uniform(0.005, 0.02);
        const Eigen::Vector3d halves(
            half, random.chance(0.5) ? half : random.uniform(0.05, 0.15), random.uniform(0.1, 0.3));
        m_obstacles.push_back(buildSsvTree(makeBox(halves)));
        Eigen::Isometry3d X_WO = random.pose(0.0);
        const Eigen::Vector3d& foot = robot.feet[static_cast<std::size_t>(i) % robot.feet.size()];
        constexpr double kClear = 0.45;
        do
        {
            X_WO.translation() = foot + random.uniform(kClear, 1.1) * random.direction();
        } while (std::ranges::any_of(robot.feet,
                                     [&](const Eigen::Vector3d& each)
                                     { return (X_WO.translation() - each).norm() < kClear; }));
        bodies.push_back({.tree = &m_obstacles.back(), .motion = restAt(X_WO)});
    }
    m_environment.reset(bodies);
    m_robot = std::make_shared<const CertifiedRobot>(PlanningScene{
        .body = {.tree = &robot.tree, .linkTrees = robot.links, .selfPairs = robot.selfPairs},
        .environment = &m_environment,
        .joints = robot.joints});

    // The planned joints above each link, as bits: two links move relative to each other if these
    // differ, and what rests has none.
    std::vector<std::uint64_t> movedBy(robot.tree.size(), 0);
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        if (const std::int32_t parent = robot.tree.links[i].parent; parent != kNone)
        {
            movedBy[i] = movedBy[static_cast<std::size_t>(parent)];
        }
        const auto joint = std::ranges::find(robot.joints, static_cast<std::int32_t>(i));
        movedBy[i] |= joint == robot.joints.end() ? 0 : 1ULL << (joint - robot.joints.begin());
        const SsvTree* link = robot.links[i];
        m_parts.push_back(link != nullptr ? std::optional<FclPart>(*link) : std::nullopt);
        for (std::size_t k = 0; k < m_obstacles.size() && m_parts[i] && movedBy[i] != 0; ++k)
        {
            m_pairs.emplace_back(i, robot.tree.size() + k);
        }
    }
    for (const SsvTree& obstacle : m_obstacles)
    {
        m_parts.emplace_back(obstacle);
    }
    std::ranges::copy_if(robot.selfPairs,
                         std::back_inserter(m_pairs),
                         [&](const auto& pair)
                         {
                             return movedBy[static_cast<std::size_t>(pair.first)] !=
                                    movedBy[static_cast<std::size_t>(pair.second)];
                         });
}

bool ClutteredRobot::isFreeByFcl(std::span<const double> q) const
{
    std::vector<double> positions = positionsOf(m_robot->scene(), q);
    std::vector<Eigen::Isometry3d> X_WP =
        linkPoses(m_planned.tree, Eigen::Isometry3d::Identity(), positions);
    for (const RigidBody& body : m_environment.bodies())
    {
        X_WP.push_back(body.motion.X_W0);
    }
    std::vector<Eigen::Vector3d> centers(m_parts.size(), Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < m_parts.size(); ++i)
    {
        if (m_parts[i])
        {
            centers[i] = X_WP[i] * m_parts[i]->center;
        }
    }
    return std::ranges::none_of(
        m_pairs,
        [&](const auto& pair)
        {
            const auto [a, b] = pair;
            const double reach = m_parts[a]->radius + m_parts[b]->radius;
            return (centers[a] - centers[b]).squaredNorm() <= reach * reach &&
                   fclOverlap(m_parts[a]->model, X_WP[a], m_parts[b]->model, X_WP[b]);
        });
}

Configuration ClutteredRobot::freeConfiguration(reference::Random& random) const
{
    Configuration q(m_planned.joints.size());
    do
    {
        for (std::size_t k = 0; k < q.size(); ++k)
        {
            const Joint& joint =
                m_planned.tree.links[static_cast<std::size_t>(m_planned.joints[k])].joint;
            q[k] = random.uniform(joint.lower, joint.upper);
        }
    } while (!m_robot->isFree(q));
    return q;
}
/// The three that are compared; 0 stands for ours.
constexpr std::array<double, 3> kResolutions{0.0, 0.01, 0.001};

ob::SpaceInformationPtr spaceOf(const ClutteredRobot& arm, double resolution)
{
    if (resolution == 0.0)
    {
        return certifiedSpace(arm.robot());
    }
    auto information = std::make_shared<ob::SpaceInformation>(
        jointSpace(*arm.robot()->scene().body.tree, arm.robot()->scene().joints));
    information->setStateValidityChecker(
        [&arm, space = information.get()](const ob::State* state)
        {
            const double* q = state->as<ob::RealVectorStateSpace::StateType>()->values;
            return space->satisfiesBounds(state) &&
                   arm.isFreeByFcl({q, space->getStateDimension()});
        });
    information->setStateValidityCheckingResolution(resolution);
    information->setup();
    return information;
}

ob::ScopedState<> stateOf(const ob::SpaceInformationPtr& information, const Configuration& q)
{
    ob::ScopedState<> state(information);
    return state = q;
}

Configuration between(const Configuration& from, const Configuration& to, double t)
{
    Configuration q(from.size());
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        q[k] = std::lerp(from[k], to[k], t);
    }
    return q;
}

/// A contact by our query, behind which FCL finds an overlap at one of many samples.
bool isCollision(const ClutteredRobot& arm, const Configuration& from, const Configuration& to)
{
    const ArticulatedToiResult toi = arm.robot()->motionToi(from, to);
    bool isFree = true;
    for (double ahead = 1e-7; isContact(toi.status) && isFree && toi.time + ahead < 1.0;)
    {
        isFree = arm.isFreeByFcl(between(from, to, toi.time + ahead));
        ahead *= 1.01;
    }
    return !isFree;
}

/// What came of the motions and plans of one validator: microseconds of each by kind. Motions are
/// "free" or "blocked" by its answer, in truth some "collide" or are "missed" (blocked, certified
/// free). Of "plans" some "plansCollide"; ours are "certified" or not once more, in one query.
using Counts = std::map<std::string, std::vector<double>>;

void askEdges(const ClutteredRobot& arm,
              const Options& options,
              std::uint64_t seed,
              std::array<Counts, 3>& counts)
{
    std::array<ob::SpaceInformationPtr, 3> spaces;
    std::ranges::transform(kResolutions, spaces.begin(), [&](double r) { return spaceOf(arm, r); });
    reference::Random random(seed);
    for (int i = 0; i < options.edges; ++i)
    {
        const Configuration from = arm.freeConfiguration(random);
        Configuration to{};
        do
        {
            // About as long as the extensions of RRT-Connect: a fifth of the extent.
            to = between(from, arm.freeConfiguration(random), 0.4);
        } while (!arm.robot()->isFree(to));
        const bool isFree = arm.robot()->motionToi(from, to).status == ToiStatus::Separated;
        const bool collides = isCollision(arm, from, to);
        for (std::size_t m = 0; m < spaces.size(); ++m)
        {
            const ob::ScopedState<> start = stateOf(spaces[m], from);
            const ob::ScopedState<> end = stateOf(spaces[m], to);
            bool isValid = false;
            const double micros =
                microsecondsOf([&] { isValid = spaces[m]->checkMotion(start.get(), end.get()); });
            counts[m][isValid ? "free" : "blocked"].push_back(micros);
            if (isValid ? collides : m > 0 && isFree)
            {
                counts[m][isValid ? "collide" : "missed"].push_back(micros);
            }
        }
    }
}

/// Certifies a whole path in one query.
void certify(const PlanningScene& scene, std::span<const Configuration> path, Counts& counts)
{
    std::vector<Waypoint> waypoints;
    for (const Configuration& q : path)
    {
        waypoints.push_back({.time = double(waypoints.size()), .positions = positionsOf(scene, q)});
    }
    const Trajectory trajectory = trajectoryThrough(*scene.body.tree, scene.X_WR, waypoints);
    ToiWorkspace work;
    TrajectoryToiResult result;
    const auto ask = [&]
    {
        result = trajectoryToi(
            scene.body, *scene.environment, trajectory, {.toi = scene.toi}, std::span(&work, 1));
    };
    const double micros = microsecondsOf(ask);
    const bool isFree = result.status == ToiStatus::Separated;
    counts[isFree ? "certified" : "uncertified"].push_back(micros);
}

void plan(const ClutteredRobot& arm,
          const Options& options,
          std::uint64_t seed,
          std::array<Counts, 3>& counts)
{
    reference::Random random(seed);
    for (int i = 0; i < options.problems; ++i)
    {
        const Configuration from = arm.freeConfiguration(random);
        const Configuration to = arm.freeConfiguration(random);
        for (std::size_t turn = 0; turn < kResolutions.size(); ++turn)
        {
            // They take turns in who finds cold caches.
            const std::size_t m = (turn + static_cast<std::size_t>(i)) % kResolutions.size();
            // The same draws for all, so that they differ by their answers only.
            ::ompl::RNG::setSeed(
                static_cast<std::uint_fast32_t>(seed * 1000 + 1 + std::uint64_t(i)));
            og::SimpleSetup setup(spaceOf(arm, kResolutions[m]));
            const ob::SpaceInformationPtr information = setup.getSpaceInformation();
            setup.setStartAndGoalStates(stateOf(information, from), stateOf(information, to));
            setup.setPlanner(std::make_shared<og::RRTConnect>(information));
            setup.setup();
            ob::PlannerStatus status;
            // The same processor time for all, however busy the machine is.
            const std::clock_t end = std::clock() + std::clock_t(options.limit * CLOCKS_PER_SEC);
            const ob::PlannerTerminationCondition isLate([end] { return std::clock() > end; });
            const double micros = microsecondsOf([&] { status = setup.solve(isLate); });
            if (status != ob::PlannerStatus::EXACT_SOLUTION)
            {
                continue;
            }
            counts[m]["plans"].push_back(micros);
            std::vector<Configuration> path;
            for (const ob::State* state : setup.getSolutionPath().getStates())
            {
                information->getStateSpace()->copyToReals(path.emplace_back(), state);
            }
            for (std::size_t k = 0; k + 1 < path.size(); ++k)
            {
                if (isCollision(arm, path[k], path[k + 1]))
                {
                    counts[m]["plansCollide"].push_back(micros);
                    break;
                }
            }
            if (m == 0)
            {
                certify(arm.robot()->scene(), path, counts[m]);
            }
        }
    }
}

bool runRobot(const PlannedRobot& robot, const Options& options)
{
    std::array<Counts, 3> counts{};
    int scene = 0;
    const nlohmann::json settings{
        options.arm, options.hand, options.edges, options.problems, options.limit};
    nlohmann::json state =
        loadCheckpoint(options.checkpoint, settings).value_or(nlohmann::json::object());
    if (state.contains(robot.name))
    {
        std::tie(scene, counts) = state[robot.name].get<std::tuple<int, std::array<Counts, 3>>>();
    }
    for (; scene < options.scenes; ++scene)
    {
        fmt::print(stderr, "{}: scene {} of {}\n", robot.name, scene + 1, options.scenes);
        const auto seed = static_cast<std::uint64_t>(scene);
        const ClutteredRobot arm(robot, seed);
        askEdges(arm, options, seed + 1000, counts);
        plan(arm, options, seed + 2000, counts);
        state[robot.name] = std::tuple(scene + 1, counts);
        if (!options.checkpoint.empty())
        {
            saveCheckpoint(options.checkpoint, settings, state);
        }
    }
    std::size_t triangles = 0;
    for (const SsvTree* link : robot.links)
    {
        triangles += link != nullptr ? link->mesh().triangles.size() : 0;
    }
    fmt::print("\n{}: {} joints, {} triangles\n", robot.name, robot.joints.size(), triangles);
    const Table table(
        "validator:<14|valid:>6|collide:>8|free [us]=free:>10.1f|"
        "blocked [us]=blocked:>13.1f|plans:>6|collide=plansCollide:>8|median [ms]=median:>12.2f|"
        "mean [ms]=mean:>10.2f|certified [ms]=again:>15.2f|at most=most:>8.2f");
    bool isRight = true;
    for (std::size_t m = 0; m < 3; ++m)
    {
        Counts& c = counts[m];
        nlohmann::json row{{"validator", std::array{"certified", "FCL at 1 %", "FCL at 0.1 %"}[m]},
                           {"valid", c["free"].size()},
                           {"free", meanOf(c["free"])},
                           {"blocked", meanOf(c["blocked"])},
                           {"plans", c["plans"].size()},
                           {"median", 1e-3 * medianOf(c["plans"])},
                           {"mean", 1e-3 * meanOf(c["plans"])}};
        for (const char* kind : {"collide", "plansCollide"})
        {
            row[kind] = c[kind].size();
        }
        if (!c["certified"].empty())
        {
            row["again"] = 1e-3 * medianOf(c["certified"]);
            row["most"] = 1e-3 * std::ranges::max(c["certified"]);
        }
        table.print(row);
        const std::size_t wrong =
            c["collide"].size() + c["plansCollide"].size() + c["uncertified"].size();
        isRight = isRight && c["missed"].empty() && (m > 0 || wrong == 0);
    }
    static_cast<void>(std::fflush(stdout));
    return isRight;
}

/// One arm, without its hand or with it.
PlannedRobot oneArm(const grasp::ArmRobot& robot, bool hasHand)
{
    PlannedRobot planned{.name = hasHand ? "an arm with a hand" : "an arm",
                         .tree = robot.tree,
                         .links = robot.linkTrees,
                         .selfPairs = robot.selfPairs,
                         .joints = robot.joints};
    if (!hasHand)
    {
        const auto first = planned.links.begin() + robot.handRoot;
        std::fill(first, planned.links.end(), nullptr);
        std::erase_if(planned.selfPairs,
                      [&](const auto& pair)
                      { return std::max(pair.first, pair.second) >= robot.handRoot; });
    }
    return planned;
}

bool run(const Options& options)
{
    ::ompl::msg::noOutputHandler();
    tools::RobotArguments names;
    names.arm = options.arm;
    names.hand = options.hand;
    const tools::LoadedRobot robot = tools::loadRobot(names);
    const auto standing = [&](double y)
    {
        return grasp::PlacedArm{.hand = &robot.hand.hand,
                                .robot = &robot.robot,
                                .X_WR = Eigen::Isometry3d(Eigen::Translation3d(0.0, y, 0.0))};
    };
    const grasp::TwoArms two = grasp::joinArms({standing(0.4), standing(-0.4)});
    const PlannedRobot both{.name = "two arms with hands",
                            .tree = two.whole.robot.tree,
                            .links = two.whole.linkTrees,
                            .selfPairs = two.whole.selfPairs,
                            .joints = two.joints(),
                            .feet = {{0.0, 0.4, 0.0}, {0.0, -0.4, 0.0}}};
    bool isRight = runRobot(oneArm(robot.robot, false), options);
    isRight = runRobot(oneArm(robot.robot, true), options) && isRight;
    return runRobot(both, options) && isRight;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    Options options;
    const Program program{
        .name = "bench_planning",
        .about = "Motions and plans of three robots in clutter: certified, and at samples by FCL.",
        .options = {{"--arm", &options.arm, "A file, or the name of an arm that ships."},
                    {"--hand", &options.hand, "The same of its hand."},
                    {"--scenes", &options.scenes, "How many scenes for each robot."},
                    {"--edges", &options.edges, "How many motions to test in each."},
                    {"--problems", &options.problems, "How many plans to make in each.", 0},
                    {"--limit", &options.limit, "Processor time that a planner may take [s]."},
                    {"--checkpoint",
                     &options.checkpoint,
                     "Keeps what is done, and goes on from there."}},
        .run = [&] { return run(options); }};
    return runProgram(argc, argv, program);
}
