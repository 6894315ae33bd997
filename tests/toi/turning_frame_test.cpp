/// Steps along directions that turn with a body, and across the plane of all accelerations: never
/// too long, and few where corners and faces slide.
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/search/pair_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

TriangleMesh randomTriangle(Random& random, double size)
{
    return triangle(size * random.uniform(0.0, 1.0) * random.direction(),
                    size * random.uniform(0.0, 1.0) * random.direction(),
                    size * random.uniform(0.0, 1.0) * random.direction());
}

TriangleCorners cornersAt(const MovingBody& body, double t)
{
    const Eigen::Isometry3d X = geometryPoseAt(body, t);
    TriangleCorners corners;
    for (std::size_t k = 0; k < 3; ++k)
    {
        corners[k] = X * body.tree->mesh().vertices[k];
    }
    return corners;
}

TEST(TurningFrame, StepsAreNeverTooLong)
{
    Random random(7);
    PairScene scene;
    ToiCounters counters;
    int turned = 0;
    int longer = 0;
    double closest = 1.0;
    for (int i = 0; i < 1500; ++i)
    {
        const KinematicTree tree = randomBallTree(random, 5, 0.3);
        JointMotion motion = randomJointMotion(random, tree, random.logUniform(0.01, 0.6));
        addRandomCurves(random, 0.2, motion);
        const SsvTree first = buildSsvTree(randomTriangle(random, 0.5));
        const SsvTree second = buildSsvTree(randomTriangle(random, 0.5));
        std::array<MovingBody, 2> bodies{
            MovingBody{.tree = &first,
                       .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 4}},
            MovingBody{.tree = &second,
                       .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 2}}};
        if (random.chance(0.4))
        {
            RigidMotion other = randomRigidMotion(random, random.uniform(0.0, 0.5));
            other.X_W0.translation() = geometryPoseAt(bodies[0], 0.0).translation() +
                                       random.uniform(0.0, 1.0) * random.direction();
            bodies[1].motion = other;
            if (random.chance(0.5))
            {
                bodies[0].motion = randomRigidMotion(random, random.uniform(0.0, 0.5));
                other.X_W0.translation() = geometryPoseAt(bodies[0], 0.0).translation() +
                                           random.uniform(0.0, 1.0) * random.direction();
                bodies[1].motion = other;
            }
        }
        if (random.chance(0.5))
        {
            std::swap(bodies[0], bodies[1]);
        }
        const std::array<BodyPair, 1> pairs{BodyPair{.bodyA = 0, .bodyB = 1}};
        scene.reset(bodies, pairs, {.tolerance = 1e-9});
        const double t = random.uniform(0.0, 0.9);
        const TriangleDistance apart =
            triangleDistance(cornersAt(bodies[0], t), cornersAt(bodies[1], t));
        if (apart.distance < 1e-3)
        {
            continue;
        }
        const double margin = random.uniform(0.5, 0.999) * apart.distance;
        for (const TurningWith with : {TurningWith::A, TurningWith::B})
        {
            const PairState* state = scene.turnedStateAt(0, t, with, counters);
            if (state == nullptr)
            {
                continue;
            }
            ++turned;
            const bool ofB = with == TurningWith::B;
            const MovingBody& a = bodies[ofB ? 0 : 1];
            const MovingBody& b = bodies[ofB ? 1 : 0];
            const Vector3d across = geometryPoseAt(b, t).linear().transpose() *
                                    (ofB ? Vector3d(apart.pointB - apart.pointA)
                                         : Vector3d(apart.pointA - apart.pointB));
            const double step = slidingStep(*a.tree, *b.tree, *state, margin, 0, 0, across);
            const double still = slidingStep(
                *bodies[0].tree,
                *bodies[1].tree,
                scene.stateAt(0, t, counters),
                margin,
                0,
                0,
                geometryPoseAt(bodies[1], t).linear().transpose() * (apart.pointB - apart.pointA));
            longer += step > 1.5 * still ? 1 : 0;
            constexpr int kSamples = 60;
            for (int k = 1; k <= kSamples; ++k)
            {
                const double at = t + std::min(step, 1.0 - t) * k / kSamples;
                const double distance =
                    triangleDistance(cornersAt(a, at), cornersAt(b, at)).distance;
                ASSERT_GE(distance, margin * (1.0 - 1e-9)) << i << ", at " << at << " from " << t;
                closest = std::min(closest, (distance - margin) / margin);
            }
        }
    }
    // The test has something to say: steps come near to what they may not pass.
    EXPECT_GT(turned, 1500);
    EXPECT_GT(longer, 40);
    EXPECT_LT(closest, 1e-3);
}

TEST(TurningFrame, APointThatCrossesATurningFaceIsNotPassed)
{
    // In the frame of the face, which turns at w about z, the point at (v t, h) is at the height
    // h cos wt - v t sin wt: it starts at rest there, and comes down because it goes outwards.
    constexpr double v = 2.0;
    constexpr double w = 0.1;
    constexpr double h = 0.05;
    constexpr double kSize = 1e-5;
    KinematicTree tree;
    tree.links.resize(2);
    tree.links[1].parent = 0;
    tree.links[1].joint.type = JointType::Revolute;
    tree.links[1].joint.axis = Vector3d::UnitZ();
    const JointMotion motion{.root = {}, .positions = {0.0, 0.0}, .rates = {0.0, w}};
    const SsvTree face =
        buildSsvTree(triangle(Vector3d(-8, 0, -3), Vector3d(8, 0, -3), Vector3d(0, 0, 6)));
    const SsvTree point =
        buildSsvTree(triangle(Vector3d(0, h, 0), Vector3d(kSize, h, 0), Vector3d(0, h, kSize)));
    const std::array<MovingBody, 2> bodies{
        MovingBody{.tree = &point, .motion = RigidMotion{.v_W = Vector3d(v, 0, 0)}},
        MovingBody{.tree = &face,
                   .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 1}}};
    const std::array<BodyPair, 1> pairs{BodyPair{.bodyA = 0, .bodyB = 1}};
    PairScene scene;
    ToiCounters counters;
    scene.reset(bodies, pairs, {.tolerance = 1e-9});
    const PairState* state = scene.turnedStateAt(0, 0.0, TurningWith::B, counters);
    ASSERT_NE(state, nullptr);
    const double margin = 0.5 * h;
    const double step = slidingStep(point, face, *state, margin, 0, 0, Vector3d(0, -h, 0));
    EXPECT_GT(step, 0.05);
    EXPECT_GE(h * std::cos(w * step) - (v * step + kSize) * std::sin(w * step), margin);
}

/// Two bars that cross, end faces and sides in common planes: an edge of the lower one lies just
/// below the lower face of the other, which turns about an axis 5 cm further down.
FirstContactResult turnOverEdge(bool swap)
{
    const SsvTree turning =
        buildSsvTree(box(Vector3d(-0.05, -0.37, 0.05), Vector3d(0.05, 0.37, 0.25)));
    const TriangleMesh lower = box(Vector3d(-0.05, 0.0, -0.7), Vector3d(0.05, 0.2, 0.0));
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.rotate(Eigen::AngleAxisd(-0.4, Vector3d::UnitX()));
    X.translation().z() = 0.05 - 1e-6;
    const SsvTree resting = buildSsvTree(lower);
    KinematicTree tree;
    tree.links.resize(2);
    tree.links[1].parent = 0;
    tree.links[1].joint.type = JointType::Revolute;
    const JointMotion motion{.root = {}, .positions = {0.0, 0.0}, .rates = {0.0, 0.04}};
    std::array<MovingBody, 2> bodies{
        MovingBody{.tree = &turning,
                   .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 1}},
        MovingBody{.tree = &resting, .motion = RigidMotion{.X_W0 = X}}};
    if (swap)
    {
        std::swap(bodies[0], bodies[1]);
    }
    const std::array<BodyPair, 1> pairs{BodyPair{.bodyA = 0, .bodyB = 1}};
    ToiWorkspace work;
    return firstContact(bodies, pairs, {.tolerance = 2e-4}, work);
}

TEST(TurningFrame, ACornerThatSlidesAlongATurningFaceTakesFewSteps)
{
    for (const bool swap : {false, true})
    {
        const FirstContactResult result = turnOverEdge(swap);
        EXPECT_EQ(result.status, ToiStatus::Separated);
        EXPECT_TRUE(result.startsTouching);
        EXPECT_LT(result.counters.trianglePairs, 2500) << swap;
    }
}

/// Joints about and across z, and along it at constant speed.
KinematicTree planarTree(Random& random, int links)
{
    KinematicTree tree;
    tree.links.resize(static_cast<std::size_t>(links));
    for (int i = 1; i < links; ++i)
    {
        Link& link = tree.links[static_cast<std::size_t>(i)];
        link.parent = random.chance(0.7) ? i - 1 : random.integer(0, i - 1);
        link.X_PL0.translation() = 0.3 * random.direction();
        link.X_PL0.rotate(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Vector3d::UnitZ()));
        if (random.chance(0.3))
        {
            link.X_PL0.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
        }
        link.joint.type = random.chance(0.7) ? JointType::Revolute : JointType::Prismatic;
        link.joint.axis = Vector3d::UnitZ();
        if (link.joint.type == JointType::Prismatic && random.chance(0.7))
        {
            const double angle = random.uniform(-3.0, 3.0);
            link.joint.axis = Vector3d(std::cos(angle), std::sin(angle), 0.0);
        }
    }
    return tree;
}

TEST(PlanarMotion, StepsAreNeverTooLong)
{
    Random random(8);
    PairScene scene;
    ToiCounters counters;
    int planar = 0;
    int whole = 0;
    int close = 0;
    for (int i = 0; i < 3000; ++i)
    {
        const KinematicTree tree = planarTree(random, 5);
        JointMotion motion = randomJointMotion(random, tree, random.logUniform(0.1, 5.0));
        motion.root = restAt(random.pose(0.5));
        if (random.chance(0.5))
        {
            addRandomCurves(random, 2.0, motion);
        }
        const SsvTree first = buildSsvTree(randomTriangle(random, 0.5));
        const SsvTree second = buildSsvTree(randomTriangle(random, 0.5));
        const Vector3d up = motion.root.X_W0.linear().col(2);
        const double apart = random.uniform(0.01, 1.5);
        RigidMotion other = restAt(random.pose(0.3));
        if (random.chance(0.6))
        {
            other.v_W = random.direction();
            other.w_W = random.uniform(-4.0, 4.0) * up;
            other.reference_B = 0.3 * random.direction();
        }
        std::array<MovingBody, 2> bodies{
            MovingBody{.tree = &first,
                       .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 4},
                       .X_BG = random.pose(0.2)},
            MovingBody{.tree = &second,
                       .motion = LinkMotion{.tree = &tree, .motion = &motion, .link = 2},
                       .X_BG = random.pose(0.2)}};
        if (random.chance(0.6))
        {
            bodies[1].motion = other;
        }
        if (random.chance(0.2))
        {
            bodies[0].motion = RigidMotion{.X_W0 = random.pose(0.3),
                                           .v_W = random.direction(),
                                           .w_W = random.uniform(-4.0, 4.0) * up};
        }
        // The second is moved along the normal until it is some way below the first.
        const double t = random.uniform(0.0, 0.9);
        const auto heights = [&](const MovingBody& body)
        {
            const TriangleCorners c = cornersAt(body, t);
            return std::minmax({up.dot(c[0]), up.dot(c[1]), up.dot(c[2])});
        };
        const double lower = heights(bodies[1]).second - heights(bodies[0]).first + apart;
        bodies[1].X_BG.pretranslate(
            -lower *
            (geometryPoseAt(bodies[1], t) * bodies[1].X_BG.inverse()).linear().transpose() * up);
        if (random.chance(0.5))
        {
            std::swap(bodies[0], bodies[1]);
        }
        const std::array<BodyPair, 1> pairs{BodyPair{.bodyA = 0, .bodyB = 1}};
        scene.reset(bodies, pairs, {.tolerance = 1e-9});
        const PairState& state = scene.stateAt(0, t, counters);
        const Vector3d plane = Eigen::Map<const Vector3d>(state.motion.plane);
        if (plane.isZero(0.0))
        {
            continue;
        }
        ++planar;
        // Along the normal, or near it.
        const Vector3d tilt = random.chance(0.5)
                                  ? Vector3d(Vector3d::Zero())
                                  : Vector3d(random.logUniform(1e-8, 0.3) * random.direction());
        Vector3d n = geometryPoseAt(bodies[1], t).linear().transpose() * up;
        ASSERT_NEAR(std::abs(n.dot(plane)), 1.0, 1e-12);
        const TriangleDistance now =
            triangleDistance(cornersAt(bodies[0], t), cornersAt(bodies[1], t));
        n = (n * ((now.pointB - now.pointA).dot(up) < 0.0 ? -1.0 : 1.0) + tilt).normalized();
        TriangleApproach approach{};
        approachAlong(state.motion,
                      bodies[0].tree->corners(0)[0].data(),
                      bodies[1].tree->corners(0)[0].data(),
                      n.data(),
                      0.25 * apart,
                      approach);
        whole += approach.time >= 1.0 - t ? 1 : 0;
        constexpr int kSamples = 60;
        for (int k = 1; k <= kSamples; ++k)
        {
            const double at = t + std::min(approach.time, 1.0 - t) * k / kSamples;
            const double distance =
                triangleDistance(cornersAt(bodies[0], at), cornersAt(bodies[1], at)).distance;
            ASSERT_GE(distance, 0.25 * apart * (1.0 - 1e-9)) << i << ", at " << at << " from " << t;
        }
        // Directions are at rest in W here: how far the gap along n has come down.
        if (scene.pair(0).base == 0 && !scene.pair(0).isRigid && approach.time > 0.0 &&
            approach.time < 1.0 - t)
        {
            const Vector3d n_W = geometryPoseAt(bodies[1], t).linear() * n;
            const TriangleCorners a = cornersAt(bodies[0], t + approach.time);
            const TriangleCorners b = cornersAt(bodies[1], t + approach.time);
            const double gap = std::min({n_W.dot(b[0]), n_W.dot(b[1]), n_W.dot(b[2])}) -
                               std::max({n_W.dot(a[0]), n_W.dot(a[1]), n_W.dot(a[2])});
            ASSERT_GE(gap, 0.25 * apart * (1.0 - 1e-9)) << i;
            close += gap < 0.3 * apart ? 1 : 0;
        }
    }
    EXPECT_GT(planar, 1000);
    EXPECT_GT(whole, 300);
    EXPECT_GT(close, 10);
}

/// Boxes that a planar arm slides over others, faces in common planes a nanometre apart.
TEST(PlanarMotion, FacesThatSlideOverEachOtherTakeFewPairs)
{
    constexpr double kGap = 1e-9;
    KinematicTree tree;
    tree.links.resize(4);
    for (std::int32_t i = 1; i < 4; ++i)
    {
        Link& link = tree.links[static_cast<std::size_t>(i)];
        link.parent = i - 1;
        link.X_PL0.translation().x() = i == 1 ? 0.0 : 0.3;
        link.joint.type = i == 3 ? JointType::Prismatic : JointType::Revolute;
        link.joint.axis = i == 3 ? Vector3d::UnitX() : Vector3d::UnitZ();
    }
    JointMotion motion{
        .root = {}, .positions = {0.0, -0.5, 0.3, 0.0}, .rates = {0.0, 3.0, -5.0, 0.1}};
    const SsvTree link = buildSsvTree(makeBox({0.2, 0.1, 0.05}));
    const SsvTree table = buildSsvTree(makeBox({0.5, 0.5, 0.05}));
    const std::array<const SsvTree*, 4> trees{nullptr, nullptr, &link, &link};
    const std::array<RigidBody, 2> obstacles{
        RigidBody{.tree = &table, .motion = restAt(poseOf({0.5, 0.2, -0.1 - kGap}))},
        RigidBody{.tree = &table,
                  .motion = {.X_W0 = poseOf({0.3, -0.2, 0.1 + kGap}), .w_W = {0.0, 0.0, 0.7}}}};
    const Environment environment(obstacles);
    for (const bool curves : {false, true})
    {
        if (curves)
        {
            motion.curves.assign(4, {0.5, -0.3, 0.1, 0.0});
        }
        const ArticulatedBody body{
            .tree = &tree, .linkTrees = trees, .motion = &motion, .selfPairs = {}};
        for (const ToiStrategy strategy :
             {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
        {
            ToiWorkspace work;
            const ArticulatedToiResult result = articulatedToi(
                body, environment, {.toi = {.tolerance = 1e-8, .strategy = strategy}}, work);
            EXPECT_EQ(result.status, ToiStatus::Separated);
            EXPECT_LT(result.counters.trianglePairs, strategy == ToiStrategy::C2A ? 50000 : 3000)
                << curves << static_cast<int>(strategy);
        }
    }
}

/// Boxes that are within the tolerance of a table where the motion begins, and slide on it: they do
/// not close in, so all strategies say that they are not in contact.
TEST(PlanarMotion, WhatTouchesAtTheStartAndSlidesIsNoContactToAnyStrategy)
{
    Random random(9);
    const SsvTree table = buildSsvTree(makeBox({3.0, 3.0, 0.05}));
    for (int i = 0; i < 100; ++i)
    {
        KinematicTree tree = planarTree(random, 4);
        for (Link& link : tree.links)
        {
            link.X_PL0.translation().z() = 0.0;
            link.joint.type = JointType::Revolute;
            link.joint.axis = Vector3d::UnitZ();
        }
        JointMotion motion = randomJointMotion(random, tree, 4.0);
        motion.root = restAt(Eigen::Isometry3d::Identity());
        const SsvTree link =
            buildSsvTree(makeBox({random.uniform(0.05, 0.4), random.uniform(0.02, 0.2), 0.05}));
        const std::array<const SsvTree*, 4> trees{nullptr, nullptr, nullptr, &link};
        const double tolerance = random.logUniform(1e-7, 1e-3);
        const double gap = random.uniform(0.1, 0.95) * tolerance;
        const std::array<RigidBody, 1> obstacles{
            RigidBody{.tree = &table, .motion = restAt(poseOf({0.1, 0.2, -0.1 - gap}))}};
        const double aim = random.chance(0.5) ? 0.5 : ToiOptions{}.aim;
        for (const ToiStrategy strategy :
             {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
        {
            ToiWorkspace work;
            const ArticulatedToiResult result = articulatedToi(
                {.tree = &tree, .linkTrees = trees, .motion = &motion, .selfPairs = {}},
                obstacles,
                {.tolerance = tolerance, .aim = aim, .strategy = strategy},
                work);
            EXPECT_EQ(result.status, ToiStatus::Separated)
                << i << ", " << static_cast<int>(strategy) << ": " << result.time;
        }
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
