/// OMPL's planners over certified motions, against the queries of the core and by brute force.
#include "bullet_ccd/ompl/certified_planning.h"

#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/trajectory/trajectory.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/SO3StateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <stdexcept>
#include <thread>

namespace bullet_ccd::tests
{
using namespace reference;
namespace ob = ::ompl::base;

namespace
{
/// A box from x = 0 to `length`, `half` thick to each side.
SsvTree rod(double length, double half)
{
    TriangleMesh mesh = makeBox({0.5 * length, half, half});
    for (Eigen::Vector3d& vertex : mesh.vertices)
    {
        vertex.x() += 0.5 * length;
    }
    return buildSsvTree(std::move(mesh));
}

/// An arm of three rods of 0.4 m in a plane, which carries a plate if it is asked to, and a post
/// that it reaches.
struct PlanarArm
{
    KinematicTree tree = planarChain({0.4, 0.4, 0.4});
    SsvTree link = rod(0.36, 0.02);
    SsvTree plate = buildSsvTree(makeBox({0.02, 0.2, 0.02}));
    SsvTree post = buildSsvTree(makeBox({0.05, 0.05, 0.5}));
    std::vector<const SsvTree*> links{nullptr, &link, &link, &link};
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs{{1, 3}};
    Environment environment;

    explicit PlanarArm(bool carries = false)
    {
        if (carries)
        {
            tree.links.push_back({.name = "plate", .parent = 3});
            tree.links.back().X_PL0.translation().x() = 0.4;
            links.push_back(&plate);
        }
        RigidBody body{.tree = &post};
        body.motion.X_W0.translation() = Eigen::Vector3d(0.7, 0.3, 0.0);
        environment.reset(std::span(&body, 1));
    }
    PlanarArm(const PlanarArm&) = delete;
    PlanarArm& operator=(const PlanarArm&) = delete;

    [[nodiscard]] PlanningScene scene() const
    {
        return {.body = {.tree = &tree, .linkTrees = links, .selfPairs = selfPairs},
                .environment = &environment,
                .joints = {1, 2, 3}};
    }

    /// The smallest distance of all that is tested, by its definition.
    [[nodiscard]] double distanceAt(std::span<const double> q) const
    {
        std::vector<double> positions(tree.size(), 0.0);
        std::copy(q.begin(), q.end(), positions.begin() + 1);
        const auto X_W = linkPoses(tree, Eigen::Isometry3d::Identity(), positions);
        const Eigen::Isometry3d& X_WP = environment.bodies()[0].motion.X_W0;
        double least = treeDistance(link, link, X_W[3].inverse() * X_W[1], 10.0).distance;
        for (std::size_t i = 1; i < tree.size(); ++i)
        {
            least = std::min(least,
                             treeDistance(*links[i], post, X_WP.inverse() * X_W[i], 10.0).distance);
        }
        return least;
    }
};

std::array<double, 3> randomPlace(Random& random)
{
    return {random.uniform(-1.0, 2.0), random.uniform(-2.5, 2.5), random.uniform(-2.5, 2.5)};
}

ob::ScopedState<> stateOf(const ob::SpaceInformationPtr& information,
                          const std::array<double, 3>& q)
{
    ob::ScopedState<> state(information);
    state = std::vector<double>(q.begin(), q.end());
    return state;
}

TEST(CertifiedRobot, DistancesOfStatesAreThoseOfTheirPairs)
{
    for (const bool carries : {false, true})
    {
        const PlanarArm arm(carries);
        const CertifiedRobot robot(arm.scene());
        Random random(1);
        int isFree = 0;
        for (int i = 0; i < 300; ++i)
        {
            const std::array<double, 3> q = randomPlace(random);
            const double distance = arm.distanceAt(q);
            EXPECT_NEAR(robot.clearance(q, 10.0), distance, 1e-6 * distance + 1e-12);
            EXPECT_EQ(robot.clearance(q, 0.1), std::min(0.1, robot.clearance(q, 10.0)));
            EXPECT_EQ(robot.isFree(q), distance > 1e-3 * kDefaultTolerance);
            isFree += robot.isFree(q) ? 1 : 0;
        }
        EXPECT_GT(isFree, 100);
        EXPECT_LT(isFree, 280);
    }
}

/// Joints that are not planned stand where the scene says, and those that follow them, too.
TEST(CertifiedRobot, JointsThatFollowStandWhereTheyFollow)
{
    PlanarArm arm;
    arm.tree.links[3].joint.mimicOf = 2;
    arm.tree.links[3].joint.mimicMultiplier = -1.5;
    arm.tree.links[3].joint.mimicOffset = 0.2;
    Random random(5);
    for (int i = 0; i < 50; ++i)
    {
        const std::array<double, 3> drawn = randomPlace(random);
        const std::array<double, 3> q{drawn[0], drawn[1], 0.2 - 1.5 * drawn[1]};
        PlanningScene scene = arm.scene();
        scene.joints = {1, 2};
        const double distance = arm.distanceAt(q);
        EXPECT_NEAR(CertifiedRobot(scene).clearance(std::span(q).first(2), 10.0),
                    distance,
                    1e-6 * distance + 1e-12);
        // Where the first joint alone is planned, the links do not move relative to each other.
        scene.body.selfPairs = {};
        const double toPost = CertifiedRobot(scene).clearance(std::span(q).first(2), 10.0);
        scene.joints = {1};
        scene.positions = {0.0, 0.0, q[1], 0.0};
        EXPECT_NEAR(CertifiedRobot(scene).clearance(std::span(q).first(1), 10.0),
                    toPost,
                    1e-6 * toPost + 1e-12);
    }
}

TEST(CertifiedRobot, RefusesMotionsBetweenDifferentSpaces)
{
    const PlanarArm arm;
    const CertifiedRobot robot(arm.scene());
    const std::array<double, 3> q{1.5, 0.0, 0.0};
    const std::array<double, 4> longer{1.5, 0.0, 0.0, 0.0};
    EXPECT_THROW((void)robot.isFreeMotion(longer, q), std::invalid_argument);
    EXPECT_THROW((void)robot.isFreeMotion(q, longer), std::invalid_argument);
}

TEST(JointSpace, HasATurnWhereOneLimitIsMissing)
{
    KinematicTree tree = planarChain({0.4, 0.4});
    tree.links[1].joint.lower = 5.0;
    tree.links[1].joint.upper = std::numeric_limits<double>::infinity();
    tree.links[2].joint.lower = -std::numeric_limits<double>::infinity();
    tree.links[2].joint.upper = 1.0;
    const std::array<std::int32_t, 2> joints{1, 2};
    const ob::StateSpacePtr space = jointSpace(tree, joints);
    const ob::RealVectorBounds& bounds = space->as<ob::RealVectorStateSpace>()->getBounds();
    EXPECT_DOUBLE_EQ(bounds.low[0], 5.0);
    EXPECT_DOUBLE_EQ(bounds.high[0], 5.0 + 2.0 * std::numbers::pi);
    EXPECT_DOUBLE_EQ(bounds.low[1], 1.0 - 2.0 * std::numbers::pi);
    EXPECT_DOUBLE_EQ(bounds.high[1], 1.0);
}

/// Both forms agree with dense samples: what is free has no sample in contact, and up to the last
/// valid state there is none either; that state is valid.
TEST(CertifiedMotionValidator, AgreesWithDenseSamples)
{
    constexpr double kSamples = 60.0;
    for (const bool carries : {false, true})
    {
        const PlanarArm arm(carries);
        const auto robot = std::make_shared<const CertifiedRobot>(arm.scene());
        const ob::SpaceInformationPtr information = certifiedSpace(robot);
        Random random(2);
        int isFree = 0;
        int hits = 0;
        for (int i = 0; i < 200; ++i)
        {
            const std::array<double, 3> from = randomPlace(random);
            const std::array<double, 3> to = randomPlace(random);
            if (!robot->isFree(from))
            {
                continue;
            }
            const ob::ScopedState<> start = stateOf(information, from);
            const ob::ScopedState<> end = stateOf(information, to);
            ob::ScopedState<> last(information);
            std::pair<ob::State*, double> lastValid{last.get(), -1.0};
            const bool answer = information->checkMotion(start.get(), end.get());
            EXPECT_EQ(information->checkMotion(start.get(), end.get(), lastValid), answer);
            const double until = answer ? 1.0 : lastValid.second;
            EXPECT_EQ(lastValid.second, answer ? -1.0 : until);
            for (int k = 0; k <= int(kSamples); ++k)
            {
                std::array<double, 3> q{};
                for (std::size_t j = 0; j < 3; ++j)
                {
                    q[j] = std::lerp(from[j], to[j], until * k / kSamples);
                }
                EXPECT_GT(arm.distanceAt(q), 0.0);
            }
            if (!answer)
            {
                EXPECT_TRUE(information->isValid(last.get()));
                const std::array<double, 3> q{last[0], last[1], last[2]};
                EXPECT_LE(arm.distanceAt(q), 2.25 * kDefaultTolerance);
                // What a planner adds to its tree up to there is free when it is asked about again.
                EXPECT_TRUE(until == 0.0 || information->checkMotion(start.get(), last.get()));
                EXPECT_NEAR(q[0], std::lerp(from[0], to[0], until), 1e-12);
                hits += until > 0.0 ? 1 : 0;
            }
            isFree += answer ? 1 : 0;
        }
        EXPECT_GT(isFree, 10);
        EXPECT_GT(hits, 30);
        EXPECT_GT(information->getMotionValidator()->getInvalidMotionCount(), 60U);
    }
}

/// A needle that the arm passes between all states that are looked at first.
TEST(CertifiedRobot, ANeedleBetweenSamplesBlocks)
{
    PlanarArm arm;
    const SsvTree needle = buildSsvTree(makeBox({1e-4, 1e-4, 0.5}));
    for (const double angle : {0.1, 0.333, 0.617, 0.9})
    {
        RigidBody body{.tree = &needle};
        body.motion.X_W0.translation() =
            Eigen::Vector3d(1.1 * std::cos(angle), 1.1 * std::sin(angle), 0.0);
        arm.environment.reset(std::span(&body, 1));
        const CertifiedRobot robot(arm.scene());
        const std::array<double, 3> from{0.0, 0.0, 0.0};
        EXPECT_FALSE(robot.isFree(std::array<double, 3>{angle, 0.0, 0.0}));
        EXPECT_FALSE(robot.isFreeMotion(from, std::array<double, 3>{1.0, 0.0, 0.0}));
        EXPECT_TRUE(robot.isFreeMotion(from, std::array<double, 3>{-1.0, 0.0, 0.0}));
    }
}

TEST(CertifiedMotionValidator, ThreadsGiveTheSameAnswers)
{
    const PlanarArm arm;
    const ob::SpaceInformationPtr information =
        certifiedSpace(std::make_shared<const CertifiedRobot>(arm.scene()));
    constexpr std::size_t kMotions = 200;
    std::array<std::vector<int>, 3> answers;
    const auto run = [&](std::size_t thread)
    {
        Random random(3);
        for (std::size_t i = 0; i < kMotions; ++i)
        {
            const ob::ScopedState<> from = stateOf(information, randomPlace(random));
            const ob::ScopedState<> to = stateOf(information, randomPlace(random));
            answers[thread].push_back(information->checkMotion(from.get(), to.get()) ? 1 : 0);
        }
    };
    run(0);
    std::thread other(run, 1);
    run(2);
    other.join();
    EXPECT_EQ(answers[0], answers[1]);
    EXPECT_EQ(answers[0], answers[2]);
    EXPECT_EQ(information->getMotionValidator()->getCheckedMotionCount(), 3 * kMotions);
}

TEST(CertifiedMotionValidator, APlannedPathIsFreeAllAlong)
{
    ::ompl::msg::noOutputHandler();
    const PlanarArm arm(true);
    const auto robot = std::make_shared<const CertifiedRobot>(arm.scene());
    ::ompl::geometric::SimpleSetup setup(certifiedSpace(robot));
    setup.setStartAndGoalStates(stateOf(setup.getSpaceInformation(), {0.0, 0.0, 0.0}),
                                stateOf(setup.getSpaceInformation(), {0.9, 0.0, 0.0}));
    setup.setPlanner(std::make_shared<::ompl::geometric::RRTConnect>(setup.getSpaceInformation()));
    ASSERT_EQ(setup.solve(60.0), ob::PlannerStatus::EXACT_SOLUTION);
    std::vector<Waypoint> waypoints;
    for (const ob::State* state : setup.getSolutionPath().getStates())
    {
        const double* q = state->as<ob::RealVectorStateSpace::StateType>()->values;
        waypoints.push_back(
            {.time = double(waypoints.size()), .positions = {0.0, q[0], q[1], q[2], 0.0}});
    }
    std::array<ToiWorkspace, 1> work;
    EXPECT_EQ(trajectoryToi(robot->scene().body,
                            arm.environment,
                            trajectoryThrough(arm.tree, Eigen::Isometry3d::Identity(), waypoints),
                            {},
                            work)
                  .status,
              ToiStatus::Separated);
}

TEST(CertifiedRobot, RefusesWhatIsNoScene)
{
    const PlanarArm arm;
    const auto make = [](PlanningScene scene) { const CertifiedRobot robot(std::move(scene)); };
    PlanningScene scene = arm.scene();
    scene.joints = {1, 1};
    EXPECT_THROW(make(scene), std::invalid_argument);
    scene.joints = {0};
    EXPECT_THROW(make(scene), std::invalid_argument);
    scene = arm.scene();
    scene.environment = nullptr;
    EXPECT_THROW(make(scene), std::invalid_argument);
    scene = arm.scene();
    scene.positions = {0.0};
    EXPECT_THROW(make(scene), std::invalid_argument);
    const auto robot = std::make_shared<const CertifiedRobot>(arm.scene());
    const auto turns =
        std::make_shared<ob::SpaceInformation>(std::make_shared<ob::SO3StateSpace>());
    EXPECT_THROW(CertifiedMotionValidator(turns, robot), std::invalid_argument);
    EXPECT_THROW(CertifiedStateChecker(turns, robot), std::invalid_argument);
    scene = arm.scene();
    scene.joints.clear();
    EXPECT_THROW(make(scene), std::invalid_argument);
    EXPECT_THROW(CertifiedMotionValidator(certifiedSpace(robot), nullptr), std::invalid_argument);
    EXPECT_THROW(CertifiedStateChecker(nullptr, robot), std::invalid_argument);
    EXPECT_THROW((void)certifiedSpace(nullptr), std::invalid_argument);
}

TEST(CertifiedRobot, RefusesPositionsThatAreNotFinite)
{
    const PlanarArm arm;
    const CertifiedRobot robot(arm.scene());
    const std::array<double, 3> here{0.1, 0.2, 0.3};
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    {
        const std::array<double, 3> there{0.1, bad, 0.3};
        EXPECT_THROW((void)robot.isFree(there), std::invalid_argument);
        EXPECT_THROW((void)robot.clearance(there, 1.0), std::invalid_argument);
        EXPECT_THROW((void)robot.isFreeMotion(here, there), std::invalid_argument);
        EXPECT_THROW((void)robot.motionToi(there, here), std::invalid_argument);
        EXPECT_THROW((void)robot.freePart(here, there), std::invalid_argument);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
