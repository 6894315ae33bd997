#include "grasp/closing/swept_boxes.h"

#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/grasp/closing/finger_hand.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::AlignedBox3d;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using grasp::HandModel;
using grasp::SweptBoxes;

const Vector3d kUp = Vector3d::UnitZ();
constexpr double kRound = 1e-12;

void expectBox(const AlignedBox3d& box, const Vector3d& lower, const Vector3d& upper)
{
    EXPECT_LT((box.min() - lower).norm(), kRound) << box.min().transpose();
    EXPECT_LT((box.max() - upper).norm(), kRound) << box.max().transpose();
}

/// A chain of all that joints can be, turned every way, with geometry on every link.
HandModel oddHand(Random& random)
{
    HandBuilder builder;
    builder.setPalm(cube(0.02));
    std::int32_t parent = 0;
    std::int32_t first = 0;
    for (int i = 0; i < 4; ++i)
    {
        Isometry3d X_PL0 = Isometry3d::Identity();
        X_PL0.linear() = random.rotation();
        X_PL0.translation() = random.inBox(0.05);
        const Vector3d axis = random.rotation().col(0);
        const double from = random.uniform(-3.0, 0.0);
        const Joint joint = i == 2 ? prismatic(axis, 0.0, 0.03)
                                   : revolute(axis, from, from + random.uniform(0.1, 7.0));
        parent = builder.add(parent,
                             X_PL0,
                             joint,
                             random.chance(0.5) ? 1 : -1,
                             shifted(cube(0.01), random.inBox(0.02)));
        first = i == 0 ? parent : first;
    }
    const auto follower = builder.add(0,
                                      poseOf(random.inBox(0.1)),
                                      revolute(random.rotation().col(1), -9.0, 9.0),
                                      1,
                                      shifted(cube(0.01), {0.04, 0.0, 0.0}));
    builder.mimic(follower, first, -0.7, 0.2);
    return builder.take();
}
}  // namespace

TEST(SweptBoxes, AFingerSweepsTheBoxOfItsSector)
{
    // From 0.5 rad on to 2 rad the tip passes the y axis: x from L cos 2 to L cos 0.5, y to L.
    constexpr double kL = 0.1;
    HandBuilder builder;
    builder.add(0, poseOf({1.0, 2.0, 3.0}), revolute(kUp, 0.5, 2.0), 1, finger(kL));
    const SweptBoxes boxes = grasp::sweptBoxes(builder.take(), {0.0, 0.5});
    EXPECT_TRUE(boxes.closing[0].isEmpty());
    expectBox(boxes.closing[1],
              Vector3d(1.0 + kL * std::cos(2.0), 2.0, 3.0),
              Vector3d(1.0 + kL * std::cos(0.5), 2.0 + kL, 3.0));
    expectBox(boxes.open[1],
              Vector3d(1.0, 2.0, 3.0),
              Vector3d(1.0 + kL * std::cos(0.5), 2.0 + kL * std::sin(0.5), 3.0));
}

TEST(SweptBoxes, AJawSweepsItsWay)
{
    HandBuilder builder;
    builder.add(0,
                poseOf({0.0, 0.0, 1.0}),
                prismatic(Vector3d::UnitX(), 0.0, 0.04),
                1,
                box({-0.05, -0.01, -0.01}, {-0.04, 0.01, 0.01}));
    const SweptBoxes boxes = grasp::sweptBoxes(builder.take(), {0.0, 0.01});
    expectBox(boxes.closing[1], {-0.04, -0.01, 0.99}, {0.0, 0.01, 1.01});
}

TEST(SweptBoxes, HoldEveryPostureOnTheWay)
{
    Random random(5);
    for (int trial = 0; trial < 200; ++trial)
    {
        const HandModel hand = oddHand(random);
        const KinematicTree& tree = hand.robot.tree;
        std::vector<double> open(tree.size());
        for (std::size_t i = 1; i < open.size(); ++i)
        {
            const Joint& joint = tree.links[i].joint;
            open[i] = random.uniform(joint.lower, joint.upper);
        }
        applyMimics(tree, open);
        const std::vector<double> closed = grasp::closedPositions(hand, open);
        const SweptBoxes boxes = grasp::sweptBoxes(hand, open);
        for (int sample = 0; sample < 20; ++sample)
        {
            std::vector<double> posture = open;
            for (std::size_t i = 1; i < open.size(); ++i)
            {
                posture[i] += random.uniform(0.0, 1.0) * (closed[i] - open[i]);
            }
            applyMimics(tree, posture);
            const std::vector<Isometry3d> poses = linkPoses(tree, Isometry3d::Identity(), posture);
            for (std::size_t link = 0; link < tree.size(); ++link)
            {
                AlignedBox3d wide = boxes.closing[link];
                wide.min().array() -= kRound;
                wide.max().array() += kRound;
                for (const Vector3d& vertex : hand.linkTrees[link]->mesh().vertices)
                {
                    ASSERT_TRUE(wide.contains(poses[link] * vertex)) << "link " << link;
                }
            }
        }
    }
}

TEST(SweptBoxes, OnlyWhatIsOnTheWayIsReachable)
{
    HandBuilder builder;
    builder.add(0, Isometry3d::Identity(), revolute(kUp, 0.0, 1.0), 1, finger(0.1));
    const HandModel hand = builder.take();
    const SweptBoxes boxes = grasp::sweptBoxes(hand, {0.0, 0.0});
    const SsvTree cubeTree = buildSsvTree(cube(0.02));
    const auto at = [&](const Vector3d& place)
    { return RigidBody{.tree = &cubeTree, .motion = restAt(poseOf(place))}; };
    // Beside the sector, in it, where only the approach brings the finger, and behind the start.
    const std::array bodies{
        at({0.15, 0.0, 0.0}), at({0.08, 0.03, 0.0}), at({0.05, 0.0, 0.5}), at({0.05, 0.0, -0.5})};
    using Indices = std::vector<std::int32_t>;
    EXPECT_EQ(grasp::reachable(boxes, Isometry3d::Identity(), Vector3d::Zero(), bodies),
              Indices({1}));
    EXPECT_EQ(grasp::reachable(boxes, Isometry3d::Identity(), 0.6 * kUp, bodies), Indices({1, 2}));
    // The same, with everything turned and moved.
    Random random(3);
    Isometry3d X = Isometry3d::Identity();
    X.linear() = random.rotation();
    X.translation() = random.inBox(2.0);
    std::array moved = bodies;
    for (RigidBody& body : moved)
    {
        body.motion = restAt(X * body.motion.X_W0);
    }
    EXPECT_EQ(grasp::reachable(boxes, X, X.linear() * (0.6 * kUp), moved), Indices({1, 2}));
}
}  // namespace bullet_ccd::tests
