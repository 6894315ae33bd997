#include "bullet_ccd/distance/tree_distance.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/distance/ssv_pair.h"
#include "tests/support/flat_plate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Scene
{
    TriangleMesh a;
    TriangleMesh b;
    Eigen::Isometry3d X_BA;
    double scale = 1.0;
};

Scene randomScene(Random& random)
{
    const auto mesh = [&]() -> TriangleMesh
    {
        switch (random.integer(0, 3))
        {
            case 0:
                return sphereWithPole(1.0, random.direction(), random.integer(3, 6));
            case 1:
                return box(-random.inBox(1.0).cwiseAbs(), random.inBox(1.0).cwiseAbs());
            default:
                return soup(random, random.integer(1, 40), 1.0, random.logUniform(0.01, 0.8));
        }
    };
    Scene scene{.a = mesh(), .b = mesh(), .X_BA = random.pose(2.0)};
    scene.scale = random.logUniform(1e-4, 1e4);
    scene.a = scaled(scene.a, scene.scale);
    scene.b = scaled(scene.b, scene.scale);
    scene.X_BA.translation() *= scene.scale;
    return scene;
}

Corners placedCorners(const Scene& scene, std::size_t triangle)
{
    Corners corners = cornersOf(scene.a, triangle);
    for (Eigen::Vector3d& corner : corners)
    {
        corner = scene.X_BA * corner;
    }
    return corners;
}

TEST(TreeDistance, AgreesWithAllPairs)
{
    Random random(30);
    int apart = 0;
    constexpr int kScenes = 400;
    for (int i = 0; i < kScenes; ++i)
    {
        const Scene scene = randomScene(random);
        const double rounding = 1e-13 * scene.scale;
        const TrianglePair result =
            treeDistance(buildSsvTree(scene.a), buildSsvTree(scene.b), scene.X_BA, kInfinity);
        const OracleDistance expected = bruteForceMeshDistance(scene.a, scene.b, scene.X_BA);
        ASSERT_NEAR(result.distance, expected.distance, rounding) << i;
        apart += expected.distance > 0.0 ? 1 : 0;
        ASSERT_NE(result.triangleA, kNone);
        ASSERT_NE(result.triangleB, kNone);
        const Corners a = placedCorners(scene, static_cast<std::size_t>(result.triangleA));
        const Corners b = cornersOf(scene.b, static_cast<std::size_t>(result.triangleB));
        EXPECT_LE(distanceToTriangle(result.pointA, a), rounding) << i;
        EXPECT_LE(distanceToTriangle(result.pointB, b), rounding) << i;
        EXPECT_NEAR((result.pointA - result.pointB).norm(), result.distance, rounding) << i;
    }
    EXPECT_GT(apart, kScenes * 3 / 10);
    EXPECT_LT(apart, kScenes * 85 / 100);
}

TEST(DistanceWithin, EnclosesTheDistanceByItsAccuracy)
{
    Random random(31);
    int coarse = 0;
    constexpr int kScenes = 400;
    for (int i = 0; i < kScenes; ++i)
    {
        const Scene scene = randomScene(random);
        const double rounding = 1e-13 * scene.scale;
        const double accuracy = scene.scale * random.logUniform(1e-6, 1.0);
        const DistanceBounds found =
            distanceWithin(buildSsvTree(scene.a), buildSsvTree(scene.b), scene.X_BA, accuracy);
        const double truth = bruteForceMeshDistance(scene.a, scene.b, scene.X_BA).distance;
        ASSERT_TRUE(found.isComplete);
        ASSERT_LE(found.lowerBound, truth + rounding) << i;
        ASSERT_GE(found.nearest.distance, truth - rounding) << i;
        ASSERT_LE(found.nearest.distance,
                  found.lowerBound + accuracy + 2e-6 * found.nearest.distance + rounding)
            << i;
        // The pair that is named is as far apart as it is said to be.
        ASSERT_NE(found.nearest.triangleA, kNone);
        const Corners a = placedCorners(scene, static_cast<std::size_t>(found.nearest.triangleA));
        const Corners b = cornersOf(scene.b, static_cast<std::size_t>(found.nearest.triangleB));
        EXPECT_LE(distanceToTriangle(found.nearest.pointA, a), rounding) << i;
        EXPECT_LE(distanceToTriangle(found.nearest.pointB, b), rounding) << i;
        EXPECT_NEAR(
            (found.nearest.pointA - found.nearest.pointB).norm(), found.nearest.distance, rounding)
            << i;
        coarse += found.nearest.distance > truth + 10.0 * rounding ? 1 : 0;
    }
    EXPECT_GT(coarse, kScenes / 10);  // the accuracy is made use of
    const SsvTree tree = buildSsvTree(cube(1.0));
    for (const double bad : {0.0, -1.0, std::nan("")})
    {
        EXPECT_THROW(static_cast<void>(distanceWithin(tree, tree, poseOf({5, 0, 0}), bad)),
                     std::invalid_argument);
    }
}

TEST(TreeDistance, ReturnsTheUpperBoundWhereNothingIsNearer)
{
    const SsvTree tree = buildSsvTree(cube(1.0));
    const Eigen::Isometry3d X = poseOf({5.0, 0.25, 0.125});
    const TrianglePair far = treeDistance(tree, tree, X, 2.5);
    EXPECT_EQ(far.distance, 2.5);
    EXPECT_EQ(far.triangleA, kNone);
    EXPECT_EQ(far.triangleB, kNone);
    const TrianglePair near = treeDistance(tree, tree, X, 3.5);
    EXPECT_DOUBLE_EQ(near.distance, 3.0);
    EXPECT_NE(near.triangleA, kNone);
}

/// Triangles of the leaves below a node.
void collectTriangles(const SsvTree& tree, std::int32_t index, std::vector<std::int32_t>& below)
{
    const SsvNode& node = tree.nodes()[static_cast<std::size_t>(index)];
    if (node.isLeaf())
    {
        below.push_back(tree.triangle(node.first));
        return;
    }
    for (std::int32_t k = 0; k < node.count; ++k)
    {
        collectTriangles(tree, node.first + k, below);
    }
}

double distanceBelow(const SsvTree& a,
                     std::int32_t nodeA,
                     const SsvTree& b,
                     std::int32_t nodeB,
                     const Eigen::Isometry3d& X)
{
    std::vector<std::int32_t> listA;
    std::vector<std::int32_t> listB;
    collectTriangles(a, nodeA, listA);
    collectTriangles(b, nodeB, listB);
    double distance = kInfinity;
    for (const std::int32_t i : listA)
    {
        Corners corners = a.cornersOfTriangle(i);
        for (Eigen::Vector3d& corner : corners)
        {
            corner = X * corner;
        }
        for (const std::int32_t j : listB)
        {
            distance = std::min(
                distance, bruteForceTriangleDistance(corners, b.cornersOfTriangle(j)).distance);
        }
    }
    return distance;
}

TEST(Separation, NeverExceedsTheDistanceOfTheTrianglesBelow)
{
    Random random(32);
    int positive = 0;
    int tight = 0;
    constexpr int kPairs = 4000;
    for (int i = 0; i < kPairs; ++i)
    {
        // Flat, long and tiny ones too: the volumes' axes are only as good as single precision.
        const double size = random.logUniform(1e-4, 1.0);
        const SsvTree a =
            buildSsvTree(soup(random, random.integer(1, 6), random.uniform(0, 1), size));
        const SsvTree b =
            buildSsvTree(soup(random, random.integer(1, 6), random.uniform(0, 1), size));
        Eigen::Isometry3d X = random.chance(0.3) ? Eigen::Isometry3d::Identity() : random.pose(2.0);
        X.translation() = random.logUniform(1e-6, 3.0) * random.direction();
        const auto nodeA = random.integer(0, static_cast<int>(a.nodes().size()) - 1);
        const auto nodeB = random.integer(0, static_cast<int>(b.nodes().size()) - 1);
        const PlacedSsv volumeA =
            place(a.nodes()[static_cast<std::size_t>(nodeA)], X.linear(), X.translation());
        const PlacedSsv volumeB = place(b.nodes()[static_cast<std::size_t>(nodeB)]);
        const double distance = distanceBelow(a, nodeA, b, nodeB, X);
        forEachSeparatingAxis(volumeA,
                              volumeB,
                              [&](double gap, const auto&)
                              {
                                  EXPECT_LE(gap, distance) << i;
                                  return false;
                              });
        const double bound = separation(volumeA, volumeB);
        positive += bound > 0.0 ? 1 : 0;
        tight += bound > 0.8 * distance ? 1 : 0;
    }
    EXPECT_GT(positive, kPairs * 3 / 10);
    EXPECT_GT(tight, kPairs / 10);
}

TEST(TrianglePairsWithin, FindsExactlyThePairsWithinTheThreshold)
{
    Random random(31);
    std::size_t found = 0;
    std::size_t candidates = 0;
    int scenesWithPairs = 0;
    constexpr int kScenes = 150;
    for (int i = 0; i < kScenes; ++i)
    {
        const Scene scene = randomScene(random);
        const double threshold = scene.scale * random.uniform(0.0, 0.6);
        const double rounding = 1e-13 * scene.scale;
        std::vector<TrianglePair> pairs(1);  // what is there already stays
        trianglePairsWithin(
            buildSsvTree(scene.a), buildSsvTree(scene.b), scene.X_BA, threshold, pairs);
        std::size_t next = 1;
        for (std::size_t a = 0; a < scene.a.triangles.size(); ++a)
        {
            const Corners corners = placedCorners(scene, a);
            for (std::size_t b = 0; b < scene.b.triangles.size(); ++b)
            {
                const double distance =
                    bruteForceTriangleDistance(corners, cornersOf(scene.b, b)).distance;
                const bool listed = next < pairs.size() &&
                                    pairs[next].triangleA == static_cast<std::int32_t>(a) &&
                                    pairs[next].triangleB == static_cast<std::int32_t>(b);
                ++candidates;
                if (listed)
                {
                    ASSERT_NEAR(pairs[next].distance, distance, rounding);
                    ASSERT_LE(distance, threshold + rounding);
                    ++next;
                }
                else
                {
                    ASSERT_GE(distance, threshold - rounding) << i << ": " << a << ", " << b;
                }
            }
        }
        ASSERT_EQ(next, pairs.size()) << "pairs out of order or listed twice";
        found += pairs.size() - 1;
        scenesWithPairs += pairs.size() > 1 ? 1 : 0;
    }
    EXPECT_GT(found, candidates / 100);
    EXPECT_LT(found, candidates / 2);
    EXPECT_GT(scenesWithPairs, kScenes / 3);
}

TEST(MarkTrianglesWithin, MarksExactlyTheTrianglesOfThePairs)
{
    Random random(36);
    std::size_t marked = 0;
    std::size_t triangles = 0;
    for (int i = 0; i < 150; ++i)
    {
        const Scene scene = randomScene(random);
        const SsvTree a = buildSsvTree(scene.a);
        const SsvTree b = buildSsvTree(scene.b);
        const double threshold = scene.scale * random.uniform(0.0, 0.3);
        std::vector<Eigen::Isometry3d> poses{scene.X_BA, random.pose(2.0), random.pose(2.0)};
        poses[1].translation() *= scene.scale;
        poses[2].translation() *= scene.scale;
        std::vector<std::uint8_t> marksA(scene.a.triangles.size(), 0);
        std::vector<std::uint8_t> marksB(scene.b.triangles.size(), 0);
        marksA[marksA.size() / 2] = 1;  // what is marked already stays, and hides nothing
        std::vector<std::uint8_t> expectedA = marksA;
        std::vector<std::uint8_t> expectedB = marksB;
        for (const Eigen::Isometry3d& X_BA : poses)
        {
            std::vector<TrianglePair> pairs;
            trianglePairsWithin(a, b, X_BA, threshold, pairs);
            for (const TrianglePair& pair : pairs)
            {
                expectedA[static_cast<std::size_t>(pair.triangleA)] = 1;
                expectedB[static_cast<std::size_t>(pair.triangleB)] = 1;
            }
        }
        EXPECT_TRUE(markTrianglesWithin(a, b, poses, threshold, marksA, marksB));
        EXPECT_EQ(marksA, expectedA) << i;
        EXPECT_EQ(marksB, expectedB) << i;
        marked += static_cast<std::size_t>(std::count(marksB.begin(), marksB.end(), 1));
        triangles += marksB.size();
    }
    EXPECT_GT(marked, triangles / 20);
    EXPECT_LT(marked, triangles * 9 / 10);
}

TEST(TrianglePairsWithin, SayWhetherTheyWereStopped)
{
    const SsvTree plate = buildSsvTree(flatPlate(40, 1.0));
    const std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d::Identity()};
    const StopCondition now = stopAfter(0.0);
    std::vector<TrianglePair> pairs;
    EXPECT_FALSE(trianglePairsWithin(plate, plate, poses[0], 0.1, pairs, now));
    const std::size_t before = pairs.size();
    pairs.clear();
    EXPECT_TRUE(trianglePairsWithin(plate, plate, poses[0], 0.1, pairs));
    EXPECT_LT(before, pairs.size());
    std::vector<std::uint8_t> marksA(plate.mesh().triangles.size(), 0);
    std::vector<std::uint8_t> marksB = marksA;
    EXPECT_FALSE(markTrianglesWithin(plate, plate, poses, 0.1, marksA, marksB, now));
    EXPECT_EQ(std::count(marksA.begin(), marksA.end(), 0),
              static_cast<std::ptrdiff_t>(marksA.size()));
    EXPECT_TRUE(markTrianglesWithin(plate, plate, poses, 0.1, marksA, marksB));
    EXPECT_EQ(std::count(marksA.begin(), marksA.end(), 0), 0);
    marksA.pop_back();
    EXPECT_THROW(markTrianglesWithin(plate, plate, poses, 0.1, marksA, marksB),
                 std::invalid_argument);
}

TEST(TreeDistance, OfFlatPlatesIsThatOfTheLowestCorner)
{
    Random random(33);
    const SsvTree a = buildSsvTree(flatPlate(60, 1.0));
    const SsvTree b = buildSsvTree(flatPlate(70, 3.0));
    for (int i = 0; i < 200; ++i)
    {
        const double gap = random.logUniform(1e-9, 1.0);
        const double tilt = random.chance(0.5) ? 0.0 : random.logUniform(1e-12, 0.1);
        const PlateAbovePlate scene(random, gap, tilt);
        const TrianglePair pair = treeDistance(a, b, scene.X_BA, kInfinity);
        EXPECT_NEAR(pair.distance, gap, 1e-6 * gap + 1e-14) << i << ": tilt " << tilt;
        EXPECT_NEAR((pair.pointA - pair.pointB).norm(), pair.distance, 1e-14) << i;
    }
}

TEST(TreeDistance, OfFlatPlatesIsFoundWhereItIsBelowTheBound)
{
    Random random(34);
    const SsvTree a = buildSsvTree(flatPlate(60, 1.0));
    const SsvTree b = buildSsvTree(flatPlate(70, 3.0));
    std::vector<TrianglePair> pairs;
    for (int i = 0; i < 200; ++i)
    {
        const double gap = random.logUniform(1e-7, 1.0);
        const double tilt = random.chance(0.5) ? 0.0 : random.logUniform(1e-12, 0.1);
        const PlateAbovePlate scene(random, gap, tilt);
        const double share = random.logUniform(2e-6, 0.5);
        const TrianglePair above = treeDistance(a, b, scene.X_BA, gap * (1.0 + share));
        EXPECT_NE(above.triangleA, kNone) << i << ": gap " << gap << ", tilt " << tilt;
        EXPECT_NEAR(above.distance, gap, 1e-6 * gap + 1e-14) << i << ": tilt " << tilt;
        const TrianglePair below = treeDistance(a, b, scene.X_BA, gap * (1.0 - share));
        EXPECT_EQ(below.triangleA, kNone) << i << ": gap " << gap << ", tilt " << tilt;
        EXPECT_EQ(below.distance, gap * (1.0 - share)) << i;
        pairs.clear();
        trianglePairsWithin(a, b, scene.X_BA, gap * (1.0 - share), pairs);
        EXPECT_TRUE(pairs.empty()) << i;
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
