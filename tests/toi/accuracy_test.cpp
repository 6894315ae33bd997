/// Queries that any contact within the tolerance will do for (ToiOptions::anyWithin): what they
/// promise, judged on the full meshes, and that they look at less.
#include "benchmarks/reference/queries/accuracy_queries.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/toi/model_use.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "tests/support/test_parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

/// A square in z = 0 of half edge 1, of 2 n^2 triangles.
TriangleMesh sheet(int n)
{
    TriangleMesh mesh;
    for (int i = 0; i <= n; ++i)
    {
        for (int j = 0; j <= n; ++j)
        {
            mesh.vertices.emplace_back(2.0 * i / n - 1.0, 2.0 * j / n - 1.0, 0.0);
        }
    }
    for (std::int32_t i = 0; i < n; ++i)
    {
        for (std::int32_t j = 0; j < n; ++j)
        {
            const std::int32_t a = i * (n + 1) + j;
            mesh.triangles.push_back({a, a + n + 1, a + 1});
            mesh.triangles.push_back({a + 1, a + n + 1, a + n + 2});
        }
    }
    return mesh;
}

/// A flies past or into B.
RigidMotion randomFlight(Random& random)
{
    const Vector3d away = 3.0 * random.direction();
    RigidMotion motion{.X_W0 = random.pose(0.0)};
    motion.X_W0.translation() = away;
    motion.v_W = -1.5 * away + random.inBox(5.0);
    motion.w_W = random.uniform(0.0, 3.0) * random.direction();
    return motion;
}

class Accuracy : public testing::TestWithParam<ToiStrategy>
{
protected:
    [[nodiscard]] ToiResult ask(const RigidBody& a, const RigidBody& b, double accuracy)
    {
        return rigidToi(
            a, b, {.tolerance = accuracy, .anyWithin = true, .strategy = GetParam()}, m_work);
    }

    ToiWorkspace m_work;
};

INSTANTIATE_TEST_SUITE_P(Strategies, Accuracy, kAllStrategies, nameOfStrategy);

TEST_P(Accuracy, IsKeptOnTheFullMeshesByLessOfThem)
{
    const SsvTree treeA = buildSsvTree(wavyBall(60, 1.0, 0.0));
    const SsvTree treeB = buildSsvTree(wavyBall(90, 1.0, 1.0));
    Random random(7);
    std::array<ModelUse, 2> use;  // at a hundredth of the size, and as exact as usual
    int hits = 0;
    for (int k = 0; k < 60; ++k)
    {
        const RigidBody a{.tree = &treeA, .motion = randomFlight(random)};
        const RigidBody b{.tree = &treeB};
        noteModelUse(m_work, &use[1]);
        const ToiResult exact = rigidToi(a, b, {.tolerance = 1e-7, .strategy = GetParam()}, m_work);
        noteModelUse(m_work, nullptr);
        for (const double accuracy : {1e-5, 1e-3, 1e-2, 5e-2})
        {
            noteModelUse(m_work, accuracy == 1e-2 ? &use[0] : nullptr);
            const ToiResult found = ask(a, b, accuracy);
            if (found.status == ToiStatus::Separated)
            {
                EXPECT_EQ(exact.status, ToiStatus::Separated) << k << ' ' << accuracy;
                continue;
            }
            ASSERT_EQ(found.status, ToiStatus::Hit);
            ++hits;
            EXPECT_LE(found.time, exact.time) << k << ' ' << accuracy;
            const double gap =
                treeDistance(treeA, treeB, a.motion.at(found.time).X_W, 10.0).distance;
            EXPECT_GT(gap, 0.0) << k << ' ' << accuracy;
            EXPECT_LE(gap, accuracy) << k << ' ' << accuracy;
            EXPECT_GE(found.gap, gap - 1e-12) << k << ' ' << accuracy;
            EXPECT_LE(found.gap, accuracy) << k << ' ' << accuracy;
            EXPECT_NEAR((found.pointA - found.pointB).norm(), found.gap, 1e-12);
        }
    }
    EXPECT_GT(hits, 60);
    EXPECT_LT(hits, 240);
    if (GetParam() != ToiStrategy::Interval)
    {
        // Depth first, many contacts are found of which each is a little earlier than the one
        // before.
        EXPECT_LT(2 * use[0].count(), use[1].count());
    }
}

/// A sheet that slides along another one within the accuracy was there before, and may go on.
TEST_P(Accuracy, WhatStartsWithinItMaySlideAndLeave)
{
    const SsvTree sheetA = buildSsvTree(sheet(12));
    const SsvTree sheetB = buildSsvTree(sheet(17));
    for (const Vector3d& velocity :
         {Vector3d(0.7, 0.2, 0.0), Vector3d(0.5, 0.0, 1.0), Vector3d(0.3, 0.0, -0.2)})
    {
        RigidBody a{.tree = &sheetA, .motion = {.v_W = velocity}};
        a.motion.X_W0.translation() = Vector3d(0.01, 0.02, 0.06);
        const ToiResult found = ask(a, {.tree = &sheetB}, 0.1);
        if (velocity.z() >= 0.0)
        {
            EXPECT_EQ(found.status, ToiStatus::TouchingLeaving) << velocity.transpose();
            continue;
        }
        EXPECT_EQ(found.status, ToiStatus::TouchingPressing);
        const double gap = 0.06 + found.time * velocity.z();
        EXPECT_LE(gap, 0.75 * 0.06 + 1e-12);
        EXPECT_GT(gap, 0.0);
    }
}

TEST(ModelUse, CountsEachTriangleOnce)
{
    const SsvTree box = buildSsvTree(cube(1.0));
    const SsvTree point = buildSsvTree(triangle({0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}));
    RigidBody a{.tree = &point, .motion = {.v_W = {0, 0, -4}}};
    a.motion.X_W0.translation() = Vector3d(0.3, 0.4, 3.0);
    ModelUse use;
    ToiWorkspace work;
    noteModelUse(work, &use);
    std::size_t once = 0;
    for (int k = 0; k < 2; ++k)
    {
        ASSERT_EQ(rigidToi(a, {.tree = &box}, {}, work).status, ToiStatus::Hit);
        once = k == 0 ? use.count() : once;
    }
    EXPECT_EQ(use.count(), once);
    EXPECT_EQ(use.count(point), 1U);
    EXPECT_EQ(use.count(), use.count(point) + use.count(box));
    EXPECT_EQ(use.trees(), 2U);
    EXPECT_EQ(use.marks(box).size(), 12U);
    EXPECT_EQ(static_cast<std::size_t>(
                  std::count(use.marks(box).begin(), use.marks(box).end(), std::uint8_t{1})),
              use.count(box));
    EXPECT_TRUE(use.marks(buildSsvTree(cube(1.0))).empty());
    noteModelUse(work, nullptr);
    a.motion.X_W0.translation().x() = -0.3;
    ASSERT_EQ(rigidToi(a, {.tree = &box}, {}, work).status, ToiStatus::Hit);
    EXPECT_EQ(use.count(), once);
}
}  // namespace
}  // namespace bullet_ccd::tests
