#include "benchmarks/reference/audit/exact_triangles.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/random.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

GridTriangle onGrid(const Corners& t)
{
    return {toGrid(t[0]), toGrid(t[1]), toGrid(t[2])};
}

const GridTriangle kFlat = {GridPoint{0, 0, 0}, GridPoint{1000, 0, 0}, GridPoint{0, 1000, 0}};

GridTriangle moved(GridTriangle t, const GridPoint& by)
{
    for (GridPoint& corner : t)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            corner[k] += by[k];
        }
    }
    return t;
}

TEST(ExactTriangles, OneGridPointApartIsApart)
{
    EXPECT_TRUE(trianglesMeet(kFlat, kFlat));
    EXPECT_FALSE(trianglesMeet(kFlat, moved(kFlat, {0, 0, 1})));
    EXPECT_TRUE(trianglesMeet(kFlat, moved(kFlat, {1000, 0, 0})));  // corner on corner
    EXPECT_FALSE(trianglesMeet(kFlat, moved(kFlat, {1001, 0, 0})));
    EXPECT_TRUE(trianglesMeet(kFlat, moved(kFlat, {500, 500, 0})));  // corner on edge
    EXPECT_FALSE(trianglesMeet(kFlat, moved(kFlat, {501, 500, 0})));
}

TEST(ExactTriangles, ATriangleInsideAnotherOfTheSamePlaneMeetsIt)
{
    const GridTriangle small = {
        GridPoint{100, 100, 0}, GridPoint{110, 100, 0}, GridPoint{100, 110, 0}};
    EXPECT_TRUE(trianglesMeet(kFlat, small));
    EXPECT_TRUE(trianglesMeet(small, kFlat));
}

TEST(ExactTriangles, ASpikeMeetsWhenItsTipReachesThePlane)
{
    const GridTriangle spike = {
        GridPoint{100, 100, 0}, GridPoint{200, 100, 900}, GridPoint{100, 200, 900}};
    EXPECT_TRUE(trianglesMeet(spike, kFlat));
    EXPECT_FALSE(trianglesMeet(moved(spike, {0, 0, 1}), kFlat));
    EXPECT_TRUE(trianglesMeet(moved(spike, {0, 0, -1}), kFlat));
    EXPECT_FALSE(trianglesMeet(moved(spike, {0, 0, -901}), kFlat));
    EXPECT_FALSE(trianglesMeet(moved(spike, {-101, 0, 0}), kFlat));
}

TEST(ExactTriangles, DegenerateTrianglesMeetByTheirEdges)
{
    const GridTriangle needle = {
        GridPoint{100, 100, -5}, GridPoint{100, 100, 5}, GridPoint{100, 100, 0}};
    EXPECT_TRUE(trianglesMeet(needle, kFlat));
    EXPECT_TRUE(trianglesMeet(kFlat, needle));
    EXPECT_FALSE(trianglesMeet(moved(needle, {0, 0, 6}), kFlat));
}

TEST(ExactTriangles, LargestCoordinatesDoNotOverflow)
{
    const Corners wide = {Vector3d(-16, -16, -16), Vector3d(16, -16, 16), Vector3d(-16, 16, 16)};
    const GridTriangle t = onGrid(wide);
    GridPoint above = t[0];
    above[2] += 1;
    EXPECT_EQ(sideOf(t[0], t[1], t[2], t[0]), 0);
    EXPECT_EQ(sideOf(t[0], t[1], t[2], above), 1);
    above[2] -= 2;
    EXPECT_EQ(sideOf(t[0], t[1], t[2], toGrid({16, 16, 16})),
              -sideOf(t[0], t[1], t[2], toGrid({-16, -16, 16})));
    EXPECT_THROW(static_cast<void>(toGrid({0, 0, 16.1})), std::invalid_argument);
}

TEST(ExactTriangles, AgreeWithTheDistanceOfRandomTriangles)
{
    Random random(7);
    constexpr int kTrials = 20000;
    int meetings = 0;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        Corners a;
        Corners b;
        for (std::size_t k = 0; k < 3; ++k)
        {
            a[k] = random.inBox(0.1);
            b[k] = random.inBox(0.1);
        }
        const double distance = bruteForceTriangleDistance(a, b).distance;
        const bool meet = trianglesMeet(onGrid(a), onGrid(b));
        EXPECT_EQ(trianglesMeet(onGrid(b), onGrid(a)), meet) << trial;
        if (distance > 1e-10)
        {
            EXPECT_FALSE(meet) << trial;
        }
        if (distance == 0.0)
        {
            EXPECT_TRUE(meet) << trial;
            ++meetings;
        }
    }
    EXPECT_GT(meetings, kTrials / 10);
    EXPECT_LT(meetings, kTrials * 9 / 10);
}
}  // namespace
}  // namespace bullet_ccd::tests
