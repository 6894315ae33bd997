/// Motions and plans of an arm, alone, with a hand, and of two in clutter: certified, and by OMPL's
/// discrete validator on FCL at 1 % (its default) and 0.1 % of the extent of the space.
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/ompl/certified_planning.h"
#include "bullet_ccd/trajectory/trajectory.h"
#include "grasp/task/two_arms.h"
#include "tools/grasp_cli/options/robot_options.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

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
    double limit = 1.0;
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
};

/// Rods and plates of 1 to 4 cm about the robot, which must outlive it.
class ClutteredRobot
{
public:
    explicit ClutteredRobot(const PlannedRobot& robot, std::uint64_t seed, int obstacles = 24);
    ClutteredRobot(const ClutteredRobot&) = delete;
    ClutteredRobot& operator=(const ClutteredRobot&) = delete;

    [[nodiscard]] const std::shared_ptr<const CertifiedRobot>& robot() const { return m_robot; }

    /// Whether no two surfaces overlap that the planned joints move relative to each other, by FCL.
    [[nodiscard]] bool isFreeByFcl(std::span<const double> q) const;

    /// One that is free.
    [[nodiscard]] Configuration freeConfiguration(reference::Random& random) const;

private:
    struct FclPart
    {
        FclModel model;
        Eigen::Vector3d center;  ///< of the sphere around it, in its own frame
        double radius;
    };
    static FclPart partOf(const SsvTree& tree)
    {
        return {FclModel(tree.mesh()), tree.origin(), tree.radius()};
    }

    const PlannedRobot& m_planned;
    std::vector<SsvTree> m_obstacles;
    Environment m_environment;
    std::shared_ptr<const CertifiedRobot> m_robot;
    std::vector<FclPart> m_parts;  ///< links with geometry, then obstacles
    /// Pairs of parts that move relative to each other.
    std::vector<std::pair<std::size_t, std::size_t>> m_pairs;
    std::vector<std::size_t> m_linkOfPart;
};
ClutteredRobot::ClutteredRobot(const PlannedRobot& robot, std::uint64_t seed, int obstacles)
    : m_planned(robot)
{
    reference::Random random(seed);
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i < obstacles; ++i)
    {
        const double half = random.uniform(0.005, 0.02);
        const Eigen::Vector3d halves(
            half, random.chance(0.5) ? half : random.uniform(0.05, 0.15), random.uniform(0.1, 0.3));
        m_obstacles.push_back(buildSsvTree(makeBox(halves)));
        Eigen::Isometry3d X_WO = random.pose(0.0);
        X_WO.translation() = random.uniform(0.45, 1.1) * random.direction();
        poses.push_back(X_WO);
    }
    std::vector<RigidBody> bodies;
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        bodies.push_back({.tree = &m_obstacles[i], .motion = restAt(poses[i])});
    }
    m_environment.reset(bodies);
    m_robot = std::make_shared<const CertifiedRobot>(PlanningScene{
        .body = {.tree = &robot.tree, .linkTrees = robot.links, .selfPairs = robot.selfPairs},
        .environment = &m_environment,
        .joints = robot.joints});

    // The planned joints above each link, as bits: two links move relative to each other if these
    // differ, and what rests has none.
    std::vector<std::uint64_t> movedBy(robot.tree.size(), 0);
    std::vector<std::size_t> partOfLink(robot.tree.size());
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        if (const std::int32_t parent = robot.tree.links[i].parent; parent != kNone)
        {
            movedBy[i] = movedBy[static_cast<std::size_t>(parent)];
        }
        const auto joint = std::ranges::find(robot.joints, static_cast<std::int32_t>(i));
        movedBy[i] |= joint == robot.joints.end() ? 0 : 1ULL << (joint - robot.joints.begin());
        if (robot.links[i] != nullptr)
        {
            partOfLink[i] = m_parts.size();
            m_linkOfPart.push_back(i);
            m_parts.push_back(partOf(*robot.links[i]));
        }
    }
    for (std::size_t k = 0; k < m_obstacles.size(); ++k)
    {
        for (std::size_t part = 0; part < m_linkOfPart.size(); ++part)
        {
            if (movedBy[m_linkOfPart[part]] != 0)
            {
                m_pairs.emplace_back(part, m_parts.size());
            }
        }
        m_parts.push_back(partOf(m_obstacles[k]));
    }
    for (const auto& [a, b] : robot.selfPairs)
    {
        if (movedBy[static_cast<std::size_t>(a)] != movedBy[static_cast<std::size_t>(b)])
        {
            m_pairs.emplace_back(partOfLink[static_cast<std::size_t>(a)],
                                 partOfLink[static_cast<std::size_t>(b)]);
        }
    }
}

bool ClutteredRobot::isFreeByFcl(std::span<const double> q) const
{
    std::vector<double> positions(m_planned.tree.size(), 0.0);
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        positions[static_cast<std::size_t>(m_planned.joints[k])] = q[k];
    }
    applyMimics(m_planned.tree, positions);
    const std::vector<Eigen::Isometry3d> X_WL =
        linkPoses(m_planned.tree, Eigen::Isometry3d::Identity(), positions);
    std::vector<Eigen::Isometry3d> X_WP;
    std::vector<Eigen::Vector3d> centers;
    for (std::size_t part = 0; part < m_parts.size(); ++part)
    {
        const std::size_t links = m_linkOfPart.size();
        X_WP.push_back(part < links ? X_WL[m_linkOfPart[part]]
                                    : m_environment.bodies()[part - links].motion.X_W0);
        centers.push_back(X_WP.back() * m_parts[part].center);
    }
    return std::ranges::none_of(
        m_pairs,
        [&](const auto& pair)
        {
            const auto [a, b] = pair;
            const double reach = m_parts[a].radius + m_parts[b].radius;
            return (centers[a] - centers[b]).squaredNorm() <= reach * reach &&
                   fclOverlap(m_parts[a].model, X_WP[a], m_parts[b].model, X_WP[b]);
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
    state = q;
    return state;
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

/// What is known of one edge.
enum class Truth
{
    Free,      ///< certified
    Collides,  ///< FCL finds an overlap at one of many samples
    NearMiss,  ///< within the tolerance, and no sample overlaps
};

Truth truthOf(const ClutteredRobot& arm, const Configuration& from, const Configuration& to)
{
    const ArticulatedToiResult toi = arm.robot()->motionToi(from, to);
    if (toi.status == ToiStatus::Separated)
    {
        return Truth::Free;
    }
    // From the contact on, first in steps that double, then evenly.
    for (double ahead = 1e-6; toi.time + ahead < 1.0; ahead *= 2.0)
    {
        if (!arm.isFreeByFcl(between(from, to, toi.time + ahead)))
        {
            return Truth::Collides;
        }
    }
    constexpr int kSamples = 20000;
    for (int k = 0; k <= kSamples; ++k)
    {
        if (!arm.isFreeByFcl(between(from, to, std::lerp(toi.time, 1.0, double(k) / kSamples))))
        {
            return Truth::Collides;
        }
    }
    return Truth::NearMiss;
}

/// What came of the motions and plans of one validator. Times in microseconds.
struct Counts
{
    int collide = 0;
    int nearMisses = 0;  ///< refused, but nothing overlaps
    int missed = 0;      ///< refused, but certified free
    std::vector<double> free;
    std::vector<double> blocked;
    int plansCollide = 0;
    int uncertified = 0;            ///< plans of ours that are not free as a whole
    std::vector<double> plans;      ///< those that were found
    std::vector<double> certified;  ///< to certify each of ours once more, in one query
};

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
        const Truth truth = truthOf(arm, from, to);
        for (std::size_t m = 0; m < spaces.size(); ++m)
        {
            const ob::ScopedState<> start = stateOf(spaces[m], from);
            const ob::ScopedState<> end = stateOf(spaces[m], to);
            bool isValid = false;
            const double micros =
                microsecondsOf([&] { isValid = spaces[m]->checkMotion(start.get(), end.get()); });
            Counts& count = counts[m];
            (isValid ? count.free : count.blocked).push_back(micros);
            count.collide += isValid && truth == Truth::Collides ? 1 : 0;
            count.nearMisses += !isValid && truth == Truth::NearMiss ? 1 : 0;
            count.missed += m > 0 && !isValid && truth == Truth::Free ? 1 : 0;
        }
    }
}

/// Certifies a whole path in one query.
void certify(const PlanningScene& scene, std::span<const Configuration> path, Counts& counts)
{
    std::vector<Waypoint> waypoints;
    for (const Configuration& q : path)
    {
        waypoints.push_back({.time = double(waypoints.size()), .positions = scene.positions});
        for (std::size_t k = 0; k < q.size(); ++k)
        {
            waypoints.back().positions[static_cast<std::size_t>(scene.joints[k])] = q[k];
        }
    }
    const Trajectory trajectory = trajectoryThrough(*scene.body.tree, scene.X_WR, waypoints);
    ToiWorkspace work;
    TrajectoryToiResult result;
    const auto ask = [&]
    {
        result = trajectoryToi(
            scene.body, *scene.environment, trajectory, {.toi = scene.toi}, std::span(&work, 1));
    };
    counts.certified.push_back(microsecondsOf(ask));
    counts.uncertified += result.status == ToiStatus::Separated ? 0 : 1;
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
            // A limit as a number would start a thread, whose end takes ten milliseconds.
            const double micros = microsecondsOf(
                [&] { status = setup.solve(ob::timedPlannerTerminationCondition(options.limit)); });
            if (status != ob::PlannerStatus::EXACT_SOLUTION)
            {
                continue;
            }
            counts[m].plans.push_back(micros);
            const std::vector<ob::State*>& states = setup.getSolutionPath().getStates();
            std::vector<Configuration> path;
            for (const ob::State* state : states)
            {
                const double* q = state->as<ob::RealVectorStateSpace::StateType>()->values;
                path.emplace_back(q, q + from.size());
            }
            bool collides = false;
            for (std::size_t k = 0; k + 1 < path.size() && !collides; ++k)
            {
                collides = truthOf(arm, path[k], path[k + 1]) == Truth::Collides;
            }
            if (m == 0)
            {
                certify(arm.robot()->scene(), path, counts[m]);
            }
            counts[m].plansCollide += collides ? 1 : 0;
        }
    }
}

bool runRobot(const PlannedRobot& robot, const Options& options)
{
    std::array<Counts, 3> counts{};
    for (int scene = 0; scene < options.scenes; ++scene)
    {
        const auto seed = static_cast<std::uint64_t>(scene);
        const ClutteredRobot arm(robot, seed);
        askEdges(arm, options, seed + 1000, counts);
        plan(arm, options, seed + 2000, counts);
    }
    std::size_t triangles = 0;
    for (const SsvTree* link : robot.links)
    {
        triangles += link != nullptr ? link->mesh().triangles.size() : 0;
    }
    fmt::print("\n{}: {} joints, {} triangles\n", robot.name, robot.joints.size(), triangles);
    const Table table(
        "validator:<14|valid:>6|collide:>8|near miss=nearMisses:>10|free [us]=free:>10.1f|"
        "blocked [us]=blocked:>13.1f|plans:>6|collide=plansCollide:>8|median [ms]=median:>12.2f|"
        "mean [ms]=mean:>10.2f|certified [ms]=again:>15.2f|at most=most:>8.2f");
    bool isRight = counts[0].collide + counts[0].plansCollide + counts[0].uncertified == 0;
    for (std::size_t m = 0; m < 3; ++m)
    {
        const Counts& c = counts[m];
        nlohmann::json row{{"validator", std::array{"certified", "FCL at 1 %", "FCL at 0.1 %"}[m]},
                           {"valid", c.free.size()},
                           {"collide", c.collide},
                           {"nearMisses", c.nearMisses},
                           {"free", meanOf(c.free)},
                           {"blocked", meanOf(c.blocked)},
                           {"plans", c.plans.size()},
                           {"plansCollide", c.plansCollide},
                           {"median", 1e-3 * medianOf(c.plans)},
                           {"mean", 1e-3 * meanOf(c.plans)}};
        if (!c.certified.empty())
        {
            row["again"] = 1e-3 * medianOf(c.certified);
            row["most"] = 1e-3 * std::ranges::max(c.certified);
        }
        table.print(row);
        isRight = isRight && c.missed == 0;
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
                            .joints = two.joints()};
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
                    {"--limit", &options.limit, "How long a planner may try [s]."}},
        .run = [&] { return run(options); }};
    return runProgram(argc, argv, program);
}
