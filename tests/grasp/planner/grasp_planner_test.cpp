#include "grasp/planner/grasp_planner.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/approach/approach_sampler.h"
#include "grasp/check/penetration_check.h"
#include "grasp/closing/closing.h"
#include "grasp/planner/plan_candidate.h"
#include "tests/grasp/contact_sets.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <mutex>
#include <numbers>
#include <random>
#include <set>

namespace bullet_ccd::grasp
{
namespace
{
using tests::makeGripper;
using tests::makeThreeFingers;

GraspObject makeObject(TriangleMesh mesh)
{
    transformMesh(mesh, Eigen::Affine3d(Eigen::Translation3d(0.02, -0.01, 0.03)));
    return makeGraspObject("object", std::move(mesh));
}

std::vector<Grasp> plan(const HandModel& hand, const GraspObject& object, PlannerOptions options)
{
    return planGrasps(hand, object, options, [] { return kinematicClosing(); });
}

std::size_t countOf(const std::vector<Grasp>& grasps, RejectReason reason)
{
    return static_cast<std::size_t>(std::count_if(
        grasps.begin(), grasps.end(), [&](const Grasp& grasp) { return grasp.reject == reason; }));
}

/// Unit vectors that cover the sphere evenly.
std::vector<Eigen::Vector3d> fibonacciSphere(int count)
{
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < count; ++i)
    {
        const double z = 1.0 - (2.0 * i + 1.0) / count;
        const double angle = 2.399963229728653 * i;  // the golden angle
        const double r = std::sqrt(1.0 - z * z);
        points.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    return points;
}

std::set<std::int32_t> linksOf(const Grasp& grasp)
{
    std::set<std::int32_t> links;
    for (const GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    return links;
}

void expectSameGrasp(const Grasp& a, const Grasp& b)
{
    EXPECT_EQ(a.candidate, b.candidate);
    EXPECT_EQ(a.reject, b.reject);
    EXPECT_EQ(a.X_WH.matrix(), b.X_WH.matrix());
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.quality.epsilon, b.quality.epsilon);
    EXPECT_EQ(a.quality.volume, b.quality.volume);
    ASSERT_EQ(a.contacts.size(), b.contacts.size());
    for (std::size_t k = 0; k < a.contacts.size(); ++k)
    {
        EXPECT_EQ(a.contacts[k].link, b.contacts[k].link);
        EXPECT_EQ(a.contacts[k].point, b.contacts[k].point);
        EXPECT_EQ(a.contacts[k].normal, b.contacts[k].normal);
        EXPECT_EQ(a.contacts[k].gap, b.contacts[k].gap);
    }
}

TEST(GraspPlanner, CoupledJawsGraspABoxFromBothSides)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = makeObject(makeBox({0.015, 0.03, 0.05}));
    const std::vector<Grasp> grasps = plan(hand, object, {.candidates = 12, .jobs = 1});
    ASSERT_GE(countOf(grasps, RejectReason::None), 3U);
    for (const Grasp& grasp : grasps)
    {
        if (grasp.reject == RejectReason::None)
        {
            EXPECT_TRUE(linksOf(grasp).contains(1));
            EXPECT_TRUE(linksOf(grasp).contains(2));
        }
    }
}

/// A block of 0.03 m x 0.03 m x 0.035 m with its top at z = 0; below it a wedge that widens too
/// steeply for friction 0.5. With its palm on the block the hand has the wedge between its tips.
TEST(GraspPlanner, CoupledJawsTryOtherDepths)
{
    TriangleMesh mesh = makeBox({0.015, 0.015, 0.0175});
    transformMesh(mesh, Eigen::Affine3d(Eigen::Translation3d(0.0, 0.0, -0.0175)));
    TriangleMesh wedge = makeBox({0.015, 0.015, 0.015});
    for (Eigen::Vector3d& vertex : wedge.vertices)
    {
        vertex.x() *= vertex.z() < 0.0 ? 0.035 / 0.015 : 1.0;
        vertex.z() -= 0.05;
    }
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (const Triangle& t : wedge.triangles)
    {
        mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    mesh.vertices.insert(mesh.vertices.end(), wedge.vertices.begin(), wedge.vertices.end());
    const GraspObject object = makeGraspObject("block on wedge", std::move(mesh));
    const HandModel hand = makeGripper(true);

    ApproachCandidate candidate{.distance = 0.3, .centerDistance = 0.3};
    candidate.X_WStart = Eigen::Translation3d(0.0, 0.0, 0.1) *
                         Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
    candidate.direction_W = -Eigen::Vector3d::UnitZ();
    const std::array bodies{RigidBody{.tree = &object.tree, .motion = {}}};
    Environment environment;
    environment.reset(bodies);
    const PlannerOptions options;
    const CloseHand close = kinematicClosing();
    PenetrationCheck check(hand, object);
    ToiWorkspace work;
    CandidateContext context{.hand = hand,
                             .object = object,
                             .environment = environment,
                             .options = options,
                             .close = close,
                             .check = check,
                             .work = work};
    const Grasp grasp = planCandidate(candidate, context);
    EXPECT_NEAR(grasp.approachDistance, 0.105, 1e-4);  // the palm's front is 5 mm behind the root
    EXPECT_EQ(grasp.reject, RejectReason::None);
    for (const GraspContact& contact : grasp.contacts)
    {
        EXPECT_GT(contact.point.z(), -0.035);
    }
    for (const double retreat : {0.0, 0.005, 0.015})  // on the wedge
    {
        Eigen::Isometry3d X_WH = candidate.X_WStart;
        X_WH.translation().z() -= grasp.approachDistance - retreat;
        Grasp deep;
        closeAndScore(deep, X_WH, hand.preshapes[0].positions, context);
        EXPECT_EQ(deep.reject, RejectReason::NoForceClosure) << retreat;
    }
}

TEST(GraspPlanner, ThreeFingersGraspABall)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 3));
    const std::vector<Grasp> grasps = plan(hand, object, {.candidates = 8, .jobs = 1});
    ASSERT_GE(countOf(grasps, RejectReason::None), 4U);
    EXPECT_GE(linksOf(grasps.front()).size(), 3U);
}

TEST(GraspPlanner, RejectsForceClosuresThatAreOutOfReach)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 3));
    const PlannerOptions options{.candidates = 8, .jobs = 2};
    const auto planReaching = [&](double least)
    {
        return planGrasps(hand,
                          object,
                          options,
                          [] { return kinematicClosing(); },
                          {.reach = [least](const Eigen::Isometry3d& X_WH)
                           { return X_WH.translation().z() > least; }});
    };
    const auto free = plan(hand, object, options);
    const auto halves = planReaching(object.centerOfMass.z());
    std::size_t above = 0;
    for (const Grasp& grasp : free)
    {
        above += grasp.reject == RejectReason::None &&
                         grasp.X_WH.translation().z() > object.centerOfMass.z()
                     ? 1
                     : 0;
    }
    ASSERT_GT(above, 0U);
    ASSERT_LT(above, countOf(free, RejectReason::None));
    EXPECT_EQ(countOf(halves, RejectReason::OutOfReach) + countOf(halves, RejectReason::None), 8U);
    for (const Grasp& grasp : halves)
    {
        EXPECT_EQ(grasp.reject == RejectReason::None,
                  grasp.X_WH.translation().z() > object.centerOfMass.z());
    }
    EXPECT_EQ(countOf(planReaching(10.0), RejectReason::None), 0U);
}

TEST(GraspPlanner, PosturesNeitherPenetrateNorReportWideGaps)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeCylinder(0.025, 0.08, 48));
    const PlannerOptions options{.candidates = 16, .jobs = 1};
    int contacts = 0;
    for (const Grasp& grasp : plan(hand, object, options))
    {
        ASSERT_FALSE(grasp.positions.empty());
        EXPECT_TRUE(checkPenetration(hand, object, grasp.X_WH, grasp.positions).clean());
        for (const GraspContact& contact : grasp.contacts)
        {
            EXPECT_LE(contact.gap, options.closing.contactThreshold);
            EXPECT_NEAR(contact.normal.norm(), 1.0, 1e-9);
            ++contacts;
        }
    }
    EXPECT_GT(contacts, 40);
}

TEST(GraspPlanner, NormalsPointIntoTheObject)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 3));
    const std::vector<Grasp> grasps = plan(hand, object, {.candidates = 4, .jobs = 1});
    int contacts = 0;
    for (const Grasp& grasp : grasps)
    {
        for (const GraspContact& contact : grasp.contacts)
        {
            EXPECT_GT(contact.normal.dot(object.centerOfMass - contact.point), 0.0);
            ++contacts;
        }
    }
    EXPECT_GT(contacts, 8);
}

TEST(GraspPlanner, ResultDoesNotDependOnTheNumberOfThreads)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeBox({0.02, 0.03, 0.04}));
    const std::vector<Grasp> one = plan(hand, object, {.candidates = 10, .jobs = 1});
    for (const int jobs : {2, 3})
    {
        const std::vector<Grasp> many = plan(hand, object, {.candidates = 10, .jobs = jobs});
        ASSERT_EQ(one.size(), many.size());
        for (std::size_t k = 0; k < one.size(); ++k)
        {
            expectSameGrasp(one[k], many[k]);
        }
    }
}

TEST(GraspPlanner, RanksForceClosuresByEpsilonThenTheRestByCandidate)
{
    const HandModel hand = makeGripper(false);
    const GraspObject object = makeObject(makeBox({0.02, 0.03, 0.05}));
    const std::vector<Grasp> grasps = plan(hand, object, {.candidates = 20, .jobs = 2});
    ASSERT_EQ(grasps.size(), 20U);
    std::set<std::int64_t> candidates;
    for (std::size_t k = 0; k < grasps.size(); ++k)
    {
        candidates.insert(grasps[k].candidate);
        if (k > 0 && grasps[k].reject == RejectReason::None)
        {
            EXPECT_EQ(grasps[k - 1].reject, RejectReason::None);
            EXPECT_LE(grasps[k].quality.epsilon, grasps[k - 1].quality.epsilon);
        }
    }
    EXPECT_EQ(candidates.size(), 20U);
    EXPECT_GT(countOf(grasps, RejectReason::None), 0U);
}

TEST(GraspPlanner, ReportsEveryCandidateOnce)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    std::atomic<int> calls = 0;
    static_cast<void>(planGrasps(hand,
                                 object,
                                 {.candidates = 6, .jobs = 2},
                                 [] { return kinematicClosing(); },
                                 {.progress = [&](const Grasp&) { ++calls; }}));
    EXPECT_EQ(calls, 6);
}

TEST(GraspPlanner, GoesOnWithWhatIsKnownAsIfItHadNeverStopped)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    const PlannerOptions options{.candidates = 9, .jobs = 2, .volumes = 2};
    const std::vector<Grasp> whole = plan(hand, object, options);
    ASSERT_GE(countOf(whole, RejectReason::None), 2U);
    std::vector<Grasp> known;
    for (const Grasp& grasp : whole)
    {
        if (grasp.candidate % 3 != 0)
        {
            known.push_back(grasp);
            known.back().quality.volume = 7.0;  // of other ranks, perhaps
        }
    }
    std::mutex mutex;
    std::set<std::int64_t> planned;
    const std::vector<Grasp> continued = planGrasps(hand,
                                                    object,
                                                    options,
                                                    [] { return kinematicClosing(); },
                                                    {.progress =
                                                         [&](const Grasp& grasp)
                                                     {
                                                         const std::scoped_lock lock(mutex);
                                                         planned.insert(grasp.candidate);
                                                     },
                                                     .known = known});
    EXPECT_EQ(planned, (std::set<std::int64_t>{0, 3, 6}));
    ASSERT_EQ(continued.size(), whole.size());
    for (std::size_t k = 0; k < whole.size(); ++k)
    {
        expectSameGrasp(continued[k], whole[k]);
    }
}

TEST(GraspPlanner, ATimeLimitLeavesOutTheLastCandidatesAndAlwaysPlansOne)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    PlannerOptions options{.candidates = 4, .jobs = 2};
    const std::vector<Grasp> whole = plan(hand, object, options);
    options.timeLimit = 1e-12;  // over before the second candidate
    std::vector<Grasp> found;
    for (std::size_t round = 1; round <= 4; ++round)
    {
        found =
            planGrasps(hand, object, options, [] { return kinematicClosing(); }, {.known = found});
        ASSERT_EQ(found.size(), round);
        for (const Grasp& grasp : found)
        {
            EXPECT_LT(grasp.candidate, static_cast<std::int64_t>(round));
        }
    }
    for (std::size_t k = 0; k < whole.size(); ++k)
    {
        expectSameGrasp(found[k], whole[k]);
    }
    // All known, nothing to do; a limit that is never met changes nothing.
    options.timeLimit = 1e9;
    EXPECT_EQ(planGrasps(hand, object, options, [] { return kinematicClosing(); }, {.known = found})
                  .size(),
              4U);
    EXPECT_EQ(plan(hand, object, options).size(), 4U);
}

TEST(GraspPlanner, RefusesKnownCandidatesThatAreNotOfThePlan)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    const auto planWith = [&](const std::vector<Grasp>& known)
    {
        static_cast<void>(planGrasps(
            hand, object, {.candidates = 2}, [] { return kinematicClosing(); }, {.known = known}));
    };
    Grasp grasp;
    grasp.candidate = 2;
    EXPECT_THROW(planWith({grasp}), std::invalid_argument);
    grasp.candidate = -1;
    EXPECT_THROW(planWith({grasp}), std::invalid_argument);
    grasp.candidate = 1;
    EXPECT_THROW(planWith({grasp, grasp}), std::invalid_argument);
    EXPECT_NO_THROW(planWith({grasp}));
}

TEST(GraspPlanner, NamesTheReasonWhenClosingFails)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    const auto failing = [](ToiStatus status)
    {
        return [status]() -> CloseHand
        {
            return [status](const HandModel&,
                            const GraspObject&,
                            const Eigen::Isometry3d&,
                            const std::vector<double>& positions,
                            const ClosingOptions&)
            { return ClosingResult{.status = status, .positions = positions, .stops = {}}; };
        };
    };
    const PlannerOptions options{.candidates = 5, .jobs = 1};
    const auto overlapping = planGrasps(hand, object, options, failing(ToiStatus::Overlapping));
    EXPECT_EQ(countOf(overlapping, RejectReason::SelfOverlap), 5U);
    const auto gaveUp = planGrasps(hand, object, options, failing(ToiStatus::IterationLimit));
    EXPECT_EQ(countOf(gaveUp, RejectReason::IterationLimit), 5U);
    // A hand that does not close touches with one link, where the approach ended.
    const auto open = planGrasps(hand, object, options, failing(ToiStatus::Separated));
    EXPECT_EQ(countOf(open, RejectReason::None), 0U);
    EXPECT_EQ(
        countOf(open, RejectReason::TooFewContacts) + countOf(open, RejectReason::NoForceClosure),
        5U);
}

TEST(GraspPlanner, PassesOnWhatAClosingEngineThrows)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    const MakeCloseHand broken = []() -> CloseHand { throw std::runtime_error("no engine"); };
    EXPECT_THROW(static_cast<void>(planGrasps(hand, object, {.candidates = 3}, broken)),
                 std::runtime_error);
}

TEST(GraspPlanner, EpsilonDoesNotDependOnTheFrameOfTheObject)
{
    std::mt19937 random(11);
    GraspObject object = makeObject(makeSphere(1.0, 1));
    object.radius = 1.0;
    const PlannerOptions pyramids{.coneEdges = 8};
    const auto isSame = [](double a, double b)
    { return std::abs(a - b) <= std::max(kEpsilonResolution, kEpsilonShare * std::max(a, b)); };
    int closures = 0;
    int changes = 0;
    for (int trial = 0; trial < 20; ++trial)
    {
        Grasp grasp;
        grasp.contacts = tests::randomGrasp(random, 5 + trial % 6);
        object.centerOfMass = Eigen::Vector3d::Zero();
        const double before = epsilonOf(grasp, object, {});
        const double roughly = epsilonOf(grasp, object, pyramids);
        // A pyramid holds the cone of friction mu cos(pi / 8), and is in that of mu.
        const double least =
            epsilonOf(grasp, object, {.friction = 0.5 * std::cos(std::numbers::pi / 8.0)});
        closures += before > 0.0 ? 1 : 0;
        for (int turn = 0; turn < 3; ++turn)
        {
            Eigen::Isometry3d X(Eigen::AngleAxisd(tests::randomVector(random).x() + 1.0,
                                                  tests::randomVector(random).normalized()));
            X.translation() = tests::randomVector(random);
            Grasp turned = grasp;
            for (GraspContact& contact : turned.contacts)
            {
                contact.point = X * contact.point;
                contact.normal = X.linear() * contact.normal;
            }
            object.centerOfMass = X.translation();
            EXPECT_TRUE(isSame(epsilonOf(turned, object, {}), before));
            const double otherwise = epsilonOf(turned, object, pyramids);
            changes += isSame(otherwise, roughly) ? 0 : 1;
            EXPECT_GE(otherwise, least - 1e-9);
            EXPECT_LE(otherwise, (before + kEpsilonResolution) / (1.0 - kEpsilonShare));
        }
    }
    EXPECT_GT(closures, 10);
    EXPECT_GT(changes, 10);  // pyramids do depend on it
}

TEST(GraspPlanner, RefusesOptionsThatMakeNoSense)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    const PlannerOptions good;
    for (int wrong = 0; wrong < 6; ++wrong)
    {
        PlannerOptions options = good;
        options.candidates = wrong == 0 ? 0 : options.candidates;
        options.jobs = wrong == 1 ? -1 : options.jobs;
        options.friction = wrong == 2 ? 0.0 : options.friction;
        options.coneEdges = wrong == 3 ? 2 : options.coneEdges;
        options.closing.contactThreshold = wrong == 4 ? 0.0 : options.closing.contactThreshold;
        options.timeLimit = wrong == 5 ? -1.0 : options.timeLimit;
        EXPECT_THROW(static_cast<void>(plan(hand, object, options)), std::invalid_argument);
    }
}

namespace
{
std::vector<Grasp> planAmong(const HandModel& hand,
                             const GraspObject& object,
                             std::span<const RigidBody> obstacles)
{
    return planGrasps(hand,
                      object,
                      {.candidates = 40, .jobs = 2, .approach = {.source = ApproachSource::Sphere}},
                      [obstacles] { return kinematicClosing(obstacles); },
                      {.obstacles = obstacles});
}
}  // namespace

TEST(GraspPlanner, ObstaclesOutOfReachChangeNothing)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 3));
    std::vector<RigidBody> obstacles;
    for (const Eigen::Vector3d& place : fibonacciSphere(40))
    {
        obstacles.push_back(
            {.tree = &object.tree,
             .motion = restAt(Eigen::Isometry3d(Eigen::Translation3d(1.5 * place)))});
    }
    const std::vector<Grasp> alone = planAmong(hand, object, {});
    const std::vector<Grasp> among = planAmong(hand, object, obstacles);
    ASSERT_EQ(alone.size(), among.size());
    for (std::size_t k = 0; k < alone.size(); ++k)
    {
        expectSameGrasp(alone[k], among[k]);
    }
}

TEST(GraspPlanner, ATableUnderTheObjectRejectsWhatTouchesIt)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 3));
    TriangleMesh slab = makeBox({0.5, 0.5, 0.01});
    transformMesh(slab,
                  Eigen::Affine3d(Eigen::Translation3d(object.centerOfMass -
                                                       Eigen::Vector3d(0.0, 0.0, 0.041))));
    const SsvTree table = buildSsvTree(slab);
    const std::vector<RigidBody> obstacles{{.tree = &table, .motion = {}}};
    const std::vector<Grasp> grasps = planAmong(hand, object, obstacles);
    EXPECT_GT(countOf(grasps, RejectReason::Obstacle), 5U);
    EXPECT_GT(countOf(grasps, RejectReason::None), 5U);
    for (const Grasp& grasp : grasps)
    {
        if (grasp.reject != RejectReason::None)
        {
            continue;
        }
        EXPECT_LT(grasp.approach_W.z(), 0.2) << "through the table";
        const std::vector<Eigen::Isometry3d> poses =
            linkPoses(hand.robot.tree, grasp.X_WH, grasp.positions);
        for (std::size_t link = 0; link < poses.size(); ++link)
        {
            EXPECT_TRUE(hand.linkTrees[link] == nullptr ||
                        treeDistance(*hand.linkTrees[link], table, poses[link], 1.0).distance >
                            0.0);
        }
    }
    EXPECT_EQ(countOf(planAmong(hand, object, {}), RejectReason::Obstacle), 0U);
}

/// A hand that would begin far away would begin in the roof; there is room below it.
TEST(GraspPlanner, BeginsNearerWhereObstaclesAreInItsWay)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 3));
    TriangleMesh shell = makeBox({1.0, 1.0, 0.01});
    transformMesh(shell,
                  Eigen::Affine3d(
                      Eigen::Translation3d(object.centerOfMass + Eigen::Vector3d(0.0, 0.0, 0.22))));
    const SsvTree roof = buildSsvTree(shell);
    const std::vector<RigidBody> obstacles{{.tree = &roof, .motion = {}}};
    const auto fromAbove = [&](std::span<const RigidBody> around)
    {
        return planGrasps(
            hand,
            object,
            {.candidates = 40,
             .jobs = 2,
             .approach = {.source = ApproachSource::Sphere, .tableTop = true, .maxTilt = 0.2}},
            [around] { return kinematicClosing(around); },
            {.obstacles = around});
    };
    const std::vector<Grasp> grasps = fromAbove(obstacles);
    EXPECT_EQ(countOf(grasps, RejectReason::OverlapAtStart), 0U);
    EXPECT_GT(countOf(grasps, RejectReason::None), 20U);
    EXPECT_GT(countOf(fromAbove({}), RejectReason::None), 20U);
    for (const Grasp& grasp : grasps)
    {
        const std::vector<Eigen::Isometry3d> poses = linkPoses(
            hand.robot.tree, grasp.X_WStart, findPreshape(hand, grasp.preshape)->positions);
        for (std::size_t link = 0; link < poses.size(); ++link)
        {
            EXPECT_TRUE(hand.linkTrees[link] == nullptr ||
                        treeDistance(*hand.linkTrees[link], roof, poses[link], 1.0).distance > 0.0);
        }
    }
}

/// A thin box in a well: open jaws do not go in, nearly closed ones do.
TEST(GraspPlanner, JawsTakeNarrowOpeningsAmongObstaclesOnly)
{
    const HandModel wide = makeGripper(true);
    HandModel hand = makeGripper(true);
    Preshape narrow = hand.preshapes.front();
    narrow.name = "near";
    narrow.positions[1] += 0.03;  // 20 mm apart
    narrow.positions[2] += 0.03;
    hand.preshapes.push_back(narrow);
    EXPECT_NEAR(openHand(hand, hand.preshapes[0]).opening, 0.08, 1e-9);
    EXPECT_NEAR(openHand(hand, narrow).opening, 0.02, 1e-9);
    const GraspObject object = makeObject(makeBox({0.004, 0.007, 0.03}));
    TriangleMesh well;
    for (const double side : {-0.03, 0.03})
    {
        for (const bool isAcross : {false, true})
        {
            TriangleMesh wall = makeBox(isAcross ? Eigen::Vector3d(0.035, 0.005, 0.03)
                                                 : Eigen::Vector3d(0.005, 0.035, 0.03));
            const Eigen::Vector3d at =
                object.centerOfMass +
                side * (isAcross ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX());
            transformMesh(wall, Eigen::Affine3d(Eigen::Translation3d(at)));
            appendMesh(well, wall);
        }
    }
    const SsvTree tree = buildSsvTree(well);
    const std::vector<RigidBody> obstacles{{.tree = &tree, .motion = {}}};
    const auto planned = [&](const HandModel& jaws, std::span<const RigidBody> around)
    {
        return planGrasps(
            jaws,
            object,
            {.candidates = 40, .jobs = 2, .approach = {.source = ApproachSource::Boxes}},
            [around] { return kinematicClosing(around); },
            {.obstacles = around});
    };
    EXPECT_EQ(countOf(planned(wide, obstacles), RejectReason::None), 0U);
    EXPECT_GT(countOf(planned(hand, obstacles), RejectReason::None), 3U);
    for (const Grasp& grasp : planned(hand, {}))
    {
        EXPECT_EQ(grasp.preshape, "open");
    }
}

class PlanCandidate : public ::testing::Test
{
protected:
    [[nodiscard]] Grasp planFrom(const ApproachCandidate& candidate)
    {
        const std::array bodies{RigidBody{.tree = &m_object.tree, .motion = {}}};
        const Environment environment(bodies);
        CandidateContext context{.hand = m_hand,
                                 .object = m_object,
                                 .environment = environment,
                                 .options = m_options,
                                 .close = m_close,
                                 .check = m_check,
                                 .work = m_work};
        return planCandidate(candidate, context);
    }

    HandModel m_hand = makeThreeFingers();
    GraspObject m_object = makeObject(makeSphere(0.03, 3));
    PlannerOptions m_options;
    CloseHand m_close = kinematicClosing();
    PenetrationCheck m_check{m_hand, m_object};
    ToiWorkspace m_work;
};

TEST_F(PlanCandidate, RejectsAStartThatOverlaps)
{
    ApproachCandidate candidate = sampleApproach(m_hand, m_object, 1, 0, 1);
    // The palm right in the ball.
    candidate.X_WStart.translation() = m_object.centerOfMass + Eigen::Vector3d(0.0, 0.0, 0.04);
    candidate.X_WStart.linear().setIdentity();
    EXPECT_EQ(planFrom(candidate).reject, RejectReason::OverlapAtStart);
}

TEST_F(PlanCandidate, RejectsAnApproachThatMisses)
{
    ApproachCandidate candidate = sampleApproach(m_hand, m_object, 1, 0, 1);
    candidate.direction_W = -candidate.direction_W;
    const Grasp grasp = planFrom(candidate);
    EXPECT_EQ(grasp.reject, RejectReason::NoApproachHit);
    EXPECT_TRUE(grasp.positions.empty());
}

TEST_F(PlanCandidate, TravelsUntilTheFirstContact)
{
    // Straight down on the ball: the palm's face at z = -0.01 of the hand meets its pole.
    ApproachCandidate candidate = sampleApproach(m_hand, m_object, 1, 0, 1);
    candidate.X_WStart = Eigen::Translation3d(m_object.centerOfMass + Eigen::Vector3d(0, 0, 0.3)) *
                         Eigen::AngleAxisd(3.14159265358979323846, Eigen::Vector3d::UnitX());
    candidate.direction_W = -Eigen::Vector3d::UnitZ();
    candidate.distance = 0.5;
    const Grasp grasp = planFrom(candidate);
    ASSERT_FALSE(grasp.positions.empty());
    double top = 0.0;  // of the ball's vertices: it is inscribed
    for (const Eigen::Vector3d& vertex : m_object.tree.mesh().vertices)
    {
        top = std::max(top, vertex.z() - m_object.centerOfMass.z());
    }
    const double exact = 0.3 + 0.01 - top;
    EXPECT_LE(grasp.approachDistance, exact);
    EXPECT_GE(grasp.approachDistance, exact - 2.0 * m_options.closing.tolerance);
}

TEST_F(PlanCandidate, ContactsOfALinkKeepTheirSpacing)
{
    m_options.minContactSpacing = 0.004;
    int pairs = 0;
    for (std::int64_t number = 0; number < 6; ++number)
    {
        const Grasp grasp = planFrom(sampleApproach(m_hand, m_object, 4, number, 6));
        for (std::size_t a = 0; a < grasp.contacts.size(); ++a)
        {
            for (std::size_t b = a + 1; b < grasp.contacts.size(); ++b)
            {
                if (grasp.contacts[a].link == grasp.contacts[b].link)
                {
                    EXPECT_GE((grasp.contacts[a].point - grasp.contacts[b].point).norm(),
                              m_options.minContactSpacing);
                    ++pairs;
                }
                EXPECT_LE(grasp.contacts[a].link, grasp.contacts[b].link);
            }
        }
    }
    EXPECT_GT(pairs, 0);
}
}  // namespace
}  // namespace bullet_ccd::grasp
