/// Steps along directions that turn with a body: never too long, and few where corners slide.
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/toi/search/pair_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

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
}  // namespace
}  // namespace bullet_ccd::tests
