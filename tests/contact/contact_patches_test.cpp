#include "bullet_ccd/contact/contact_patches.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/contact/contacts.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kGap = 1e-4;
constexpr double kThreshold = 2e-4;
constexpr double kRounding = 1e-12;

struct Scene
{
    TriangleMesh meshA;
    Isometry3d X_WA;
    TriangleMesh meshB;
    Isometry3d X_WB = Isometry3d::Identity();
};

PatchWorkspace patchesOf(const Scene& scene, double threshold = kThreshold)
{
    const SsvTree treeA = buildSsvTree(scene.meshA);
    const SsvTree treeB = buildSsvTree(scene.meshB);
    PatchWorkspace work;
    findPatches(ContactSurface(treeA),
                scene.X_WA,
                ContactSurface(treeB),
                scene.X_WB,
                {.threshold = threshold},
                work);
    return work;
}

/// Smallest distance of x from a triangle of the mesh that holds the point.
double distanceAround(const Vector3d& x, const Vector3d& point, const TriangleMesh& mesh)
{
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const Corners c = cornersOf(mesh, i);
        const Vector3d low = c[0].cwiseMin(c[1]).cwiseMin(c[2]);
        const Vector3d high = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
        if (((low - point).array() <= 1e-11).all() && ((point - high).array() <= 1e-11).all() &&
            distanceToTriangle(point, c) <= 1e-11)
        {
            least = std::min(least, distanceToTriangle(x, c));
        }
    }
    return least;
}

/// What every contact of bodies apart promises: its points are on the surfaces, and each is the
/// nearest to the other on the triangles around it but for `lenience` of the gap.
void expectLocalMinima(const std::vector<Contact>& contacts,
                       const Scene& scene,
                       double threshold = kThreshold,
                       double lenience = 0.01)
{
    const Isometry3d X_AW = scene.X_WA.inverse();
    const Isometry3d X_BW = scene.X_WB.inverse();
    for (const Contact& c : contacts)
    {
        EXPECT_LE(c.gap, threshold + kRounding);
        EXPECT_NEAR((c.pointB - c.pointA).norm(), c.gap, kRounding);
        EXPECT_NEAR(c.normal.norm(), 1.0, 1e-12);
        EXPECT_NEAR(c.normal.dot(c.pointB - c.pointA), c.gap, 1e-9 * c.gap + kRounding);
        EXPECT_LE(distanceToTriangle(X_AW * c.pointA,
                                     cornersOf(scene.meshA, static_cast<std::size_t>(c.triangleA))),
                  kRounding);
        EXPECT_LE(distanceToTriangle(X_BW * c.pointB,
                                     cornersOf(scene.meshB, static_cast<std::size_t>(c.triangleB))),
                  kRounding);
        EXPECT_GE(distanceAround(X_AW * c.pointB, X_AW * c.pointA, scene.meshA),
                  (1.0 - lenience) * c.gap - kRounding);
        EXPECT_GE(distanceAround(X_BW * c.pointA, X_BW * c.pointB, scene.meshB),
                  (1.0 - lenience) * c.gap - kRounding);
    }
}

void expectNormals(const std::vector<Contact>& contacts, const Vector3d& normal)
{
    for (const Contact& contact : contacts)
    {
        EXPECT_LE((contact.normal - normal).norm(), 1e-9);
    }
}

double cross(const Vector2d& u, const Vector2d& v)
{
    return u.x() * v.y() - u.y() * v.x();
}

/// Area of the convex hull: of the lower and the upper chain of points from left to right.
double hullArea(std::vector<Vector2d> points)
{
    std::sort(points.begin(),
              points.end(),
              [](const Vector2d& p, const Vector2d& q)
              { return std::pair(p.x(), p.y()) < std::pair(q.x(), q.y()); });
    double area = 0.0;
    for (const double side : {1.0, -1.0})
    {
        std::vector<Vector2d> chain;
        for (const Vector2d& p : points)
        {
            while (chain.size() > 1 &&
                   side * cross(chain.back() - chain[chain.size() - 2], p - chain.back()) <= 0.0)
            {
                chain.pop_back();
            }
            chain.push_back(p);
        }
        for (std::size_t i = 2; i < chain.size(); ++i)
        {
            area += 0.5 * std::abs(cross(chain[i - 1] - chain[0], chain[i] - chain[0]));
        }
    }
    return area;
}

double spannedArea(const std::vector<Contact>& contacts)
{
    std::vector<Vector2d> points;
    for (const Contact& contact : contacts)
    {
        points.emplace_back(contact.pointA.head<2>());
    }
    return hullArea(points);
}

/// Points of a grid moved at random inside their plane, with diagonals at random: flat.
TriangleMesh raggedFloor(Random& random, int cells, double half)
{
    TriangleMesh mesh;
    const double size = 2.0 * half / cells;
    for (int i = 0; i <= cells; ++i)
    {
        for (int j = 0; j <= cells; ++j)
        {
            const bool inside = i > 0 && j > 0 && i < cells && j < cells;
            const double shake = inside ? 0.3 * size : 0.0;
            mesh.vertices.emplace_back(i * size - half + random.uniform(-shake, shake),
                                       j * size - half + random.uniform(-shake, shake),
                                       0.0);
        }
    }
    for (int i = 0; i < cells; ++i)
    {
        for (int j = 0; j < cells; ++j)
        {
            const int k = i * (cells + 1) + j;
            const int next = k + cells + 1;
            if (random.chance(0.5))
            {
                mesh.triangles.push_back({k, next, next + 1});
                mesh.triangles.push_back({k, next + 1, k + 1});
            }
            else
            {
                mesh.triangles.push_back({k, next, k + 1});
                mesh.triangles.push_back({k + 1, next, next + 1});
            }
        }
    }
    return mesh;
}

TEST(ContactPatches, ACubeOnAPlateTouchesWithItsFourCornersStraightDown)
{
    const Scene scene{cube(1), poseOf({0.3, -0.2, 1 + kGap}, 0.4), box({-5, -5, -1}, {5, 5, 0})};
    const PatchWorkspace work = patchesOf(scene);
    ASSERT_EQ(work.patches.size(), 1U);
    ASSERT_EQ(work.contacts.size(), 4U);
    expectLocalMinima(work.contacts, scene);
    expectNormals(work.contacts, -Vector3d::UnitZ());
    EXPECT_NEAR(spannedArea(work.contacts), 4.0, 1e-9);
}

TEST(ContactPatches, APlateThinnerThanTheThresholdTouchesWithTheSideThatFaces)
{
    const TriangleMesh thin = box({-5, -5, -0.2 * kGap}, {5, 5, 0});
    const Scene scene{cube(1), poseOf({0.3, -0.2, 1 + kGap}, 0.4), thin};
    const Scene swapped{thin, Isometry3d::Identity(), cube(1), poseOf({0.3, -0.2, 1 + kGap}, 0.4)};
    for (const auto& [s, normal] :
         {std::pair(scene, Vector3d(0, 0, -1)), std::pair(swapped, Vector3d(0, 0, 1))})
    {
        const PatchWorkspace work = patchesOf(s);
        ASSERT_EQ(work.contacts.size(), 4U);
        expectLocalMinima(work.raw, s);
        expectNormals(work.raw, normal);
        for (const Contact& contact : work.contacts)
        {
            EXPECT_NEAR(contact.gap, kGap, kRounding);
        }
    }
}

TEST(ContactPatches, TheOverlapOfTwoFacesIsSpannedByCornersAndCrossings)
{
    // A square on a square turned by 45 degrees and moved: an octagon with a corner cut off.
    const Scene scene{
        cube(1), poseOf({0, 0, 1 + kGap}, std::numbers::pi / 4), cube(1), poseOf({0, 0, -1})};
    const PatchWorkspace work = patchesOf(scene);
    expectLocalMinima(work.raw, scene);
    EXPECT_EQ(work.raw.size(), 8U);
    expectNormals(work.raw, -Vector3d::UnitZ());
    ASSERT_EQ(work.contacts.size(), 4U);
    // Corners of a regular octagon with inner radius 1; every second one is a square.
    const double outer = 1.0 / std::cos(std::numbers::pi / 8);
    EXPECT_NEAR(spannedArea(work.contacts), 2.0 * outer * outer, 1e-9);
}

TEST(ContactPatches, CrossedEdgesTouchOnce)
{
    const double half = std::sqrt(2.0);
    const Isometry3d X_WA = poseOf({0, 0, 2 * half + kGap}) *
                            Isometry3d(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ())) *
                            Isometry3d(Eigen::AngleAxisd(std::numbers::pi / 4, Vector3d::UnitX()));
    const Scene scene{
        cube(1), X_WA, cube(1), poseOf({0.1, 0.2, 0}, std::numbers::pi / 4, Vector3d::UnitX())};
    const PatchWorkspace work = patchesOf(scene);
    ASSERT_EQ(work.contacts.size(), 1U);
    expectLocalMinima(work.contacts, scene, kThreshold, 1e-9);
    EXPECT_LE((work.contacts[0].pointA - Vector3d(0, 0.2, half + kGap)).norm(), 1e-9);
    expectNormals(work.contacts, -Vector3d::UnitZ());
}

TEST(ContactPatches, TheTrianglesOfAFlatFloorAddNothing)
{
    Random random(31);
    const TriangleMesh ragged = raggedFloor(random, 40, 2.0);
    for (int trial = 0; trial < 30; ++trial)
    {
        // Floor and box turned as a whole: flat only but for rounding.
        const Isometry3d X = trial == 0 ? Isometry3d::Identity() : random.pose(1.0);
        const Isometry3d onFloor = poseOf(
            {random.uniform(-1, 1), random.uniform(-1, 1), 0.5 + kGap}, random.uniform(0, 6));
        const Scene scene{cube(0.5), X * onFloor, placed(ragged, X)};
        const PatchWorkspace work = patchesOf(scene);
        ASSERT_EQ(work.patches.size(), 1U);
        ASSERT_EQ(work.contacts.size(), 4U);
        expectNormals(work.raw, X.linear() * Vector3d(0, 0, -1));
        for (const Contact& contact : work.raw)
        {
            const Vector3d corner = (X * onFloor).inverse() * contact.pointA;
            EXPECT_LE((corner.cwiseAbs() - Vector3d::Constant(0.5)).norm(), 1e-9);
            EXPECT_NEAR(contact.gap, kGap, 1e-9);
        }
    }
}

TEST(ContactPatches, ACylinderStandsOnFourPointsOfItsRimAndLiesOnTheEndsOfALine)
{
    const TriangleMesh cylinder = makeCylinder(0.03, 0.1, 64);
    const Scene standing{cylinder, poseOf({0.01, 0.02, 0.05 + kGap}), floorAt(0, 1)};
    const PatchWorkspace rim = patchesOf(standing);
    EXPECT_EQ(rim.raw.size(), 64U);
    expectLocalMinima(rim.raw, standing);
    expectNormals(rim.raw, -Vector3d::UnitZ());
    ASSERT_EQ(rim.contacts.size(), 4U);
    EXPECT_NEAR(spannedArea(rim.contacts), 2.0 * 0.03 * 0.03, 1e-9);

    // On a line of vertices; the neighbours are lower by 1 - cos(2 pi / 64) of the radius: 0.14 mm.
    const Scene lying{cylinder,
                      poseOf({0, 0, 0.03 + kGap}, std::numbers::pi / 2, Vector3d::UnitX()),
                      floorAt(0, 1)};
    const PatchWorkspace line = patchesOf(lying);
    expectLocalMinima(line.raw, lying);
    expectNormals(line.raw, -Vector3d::UnitZ());
    ASSERT_EQ(line.contacts.size(), 2U);
    EXPECT_NEAR((line.contacts[0].pointA - line.contacts[1].pointA).norm(), 0.1, 1e-9);
}

TEST(ContactPatches, ARoundFootRingHoldsItsBowlUnderASlightTilt)
{
    // A ring of half a torus: no sharp edge touches. Tilted by 0.1 mm over 80 mm.
    const TriangleMesh ring = makeTorus(0.04, 0.005, 96, 24);
    for (const double tilt : {0.0, 1e-6, 1e-3})
    {
        const double lowest = 0.005 + kGap + 0.04 * std::sin(tilt);
        const Scene scene{ring, poseOf({0.2, 0.1, lowest}, tilt, Vector3d::UnitX()), floorAt(0, 1)};
        const PatchWorkspace work = patchesOf(scene);
        expectLocalMinima(work.raw, scene);
        expectNormals(work.raw, -Vector3d::UnitZ());
        // Four, and the deepest if it is not among them.
        ASSERT_GE(work.contacts.size(), 4U);
        ASSERT_LE(work.contacts.size(), 5U);
        EXPECT_LE(work.contacts[0].gap, kGap + 0.02 * kThreshold + 1e-6);
        EXPECT_GE(spannedArea(work.contacts), 0.95 * 2.0 * 0.04 * 0.04);
    }
}

TEST(ContactPatches, AnAngleOnAStepHasOnePatchForEachWall)
{
    // The step goes down at x = 0; a block lies on its upper level and hangs over with a leg.
    const TriangleMesh angle =
        merged({box({-1, -0.4, kGap}, {0.3, 0.4, 0.3}), box({kGap, -0.4, -0.5}, {0.3, 0.4, kGap})});
    const Scene scene{angle, Isometry3d::Identity(), box({-2, -2, -1}, {0, 2, 0})};
    const PatchWorkspace work = patchesOf(scene);
    expectLocalMinima(work.raw, scene);
    ASSERT_EQ(work.patches.size(), 2U);
    double up = 0.0;
    double across = 0.0;
    for (const ContactPatch& patch : work.patches)
    {
        EXPECT_EQ(patch.count, 4);
        up = std::max(up, -patch.normal.z());
        across = std::max(across, -patch.normal.x());
        for (std::int32_t i = 0; i < patch.count; ++i)
        {
            const Contact& c = work.contacts[static_cast<std::size_t>(patch.first + i)];
            EXPECT_LE((c.normal - patch.normal).norm(), 1e-9);
        }
    }
    EXPECT_NEAR(up, 1.0, 1e-12);
    EXPECT_NEAR(across, 1.0, 1e-12);
}

TEST(ContactPatches, PointsAndSegmentsTouchWithTheirEnds)
{
    const Vector3d tip(0.1, 0.2, 0.05);
    const Scene point{
        triangle(tip, tip, tip), Isometry3d::Identity(), box({-1, -1, -1}, {1, 1, 0})};
    const PatchWorkspace one = patchesOf(point, 0.06);
    ASSERT_EQ(one.raw.size(), 1U);
    EXPECT_NEAR(one.raw[0].gap, 0.05, kRounding);
    expectNormals(one.raw, -Vector3d::UnitZ());

    const Scene lying{segment({-0.3, 0, 0.05}, {0.4, 0.1, 0.05}),
                      Isometry3d::Identity(),
                      box({-1, -1, -1}, {1, 1, 0})};
    const PatchWorkspace two = patchesOf(lying, 0.06);
    ASSERT_EQ(two.contacts.size(), 2U);
    expectNormals(two.raw, -Vector3d::UnitZ());

    // Beyond the edge of the box: a segment crosses it in the air.
    const Scene crossing{segment({0.95, 0, 0.13}, {1.05, 0, 0.03}),
                         Isometry3d::Identity(),
                         box({-1, -1, -1}, {1, 1, 0})};
    const PatchWorkspace three = patchesOf(crossing, 0.06);
    ASSERT_EQ(three.contacts.size(), 1U);
    EXPECT_NEAR(three.contacts[0].gap, 0.08 / std::sqrt(2.0), 1e-9);
}

TEST(ContactPatches, ABoxSunkIntoAFloorIsPushedUpByItsCorners)
{
    Random random(7);
    const double depth = 0.3 * kThreshold;
    for (const TriangleMesh& ground :
         {floorAt(0, 5), box({-5, -5, -1}, {5, 5, 0}), raggedFloor(random, 30, 3.0)})
    {
        const Scene scene{cube(1), poseOf({0.3, -0.2, 1 - depth}, 0.4), ground};
        const Scene swapped{ground, Isometry3d::Identity(), cube(1), scene.X_WA};
        for (const auto& [s, normal] :
             {std::pair(scene, Vector3d(0, 0, -1)), std::pair(swapped, Vector3d(0, 0, 1))})
        {
            const PatchWorkspace work = patchesOf(s);
            ASSERT_EQ(work.patches.size(), 1U);
            ASSERT_EQ(work.contacts.size(), 4U);
            expectNormals(work.raw, normal);
            for (const Contact& contact : work.contacts)
            {
                EXPECT_NEAR(contact.gap, -depth, kRounding);
                EXPECT_NEAR(contact.normal.dot(contact.pointB - contact.pointA), -depth, kRounding);
            }
        }
    }
}

TEST(ContactPatches, EdgesPastEachOtherArePushedBackTheShortWay)
{
    const double half = std::sqrt(2.0);
    const double depth = 0.3 * kThreshold;
    const Isometry3d X_WA = poseOf({0, 0, 2 * half - depth}) *
                            Isometry3d(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ())) *
                            Isometry3d(Eigen::AngleAxisd(std::numbers::pi / 4, Vector3d::UnitX()));
    const Scene scene{
        cube(1), X_WA, cube(1), poseOf({0.1, 0.2, 0}, std::numbers::pi / 4, Vector3d::UnitX())};
    const PatchWorkspace work = patchesOf(scene);
    ASSERT_EQ(work.contacts.size(), 1U);
    EXPECT_NEAR(work.contacts[0].gap, -depth, kRounding);
    expectNormals(work.contacts, -Vector3d::UnitZ());
}

TEST(ContactPatches, WhatIsDeepInsideIsPushedBackToWhereItsMiddleIs)
{
    // A ball of fine triangles, and a box deeper than the threshold: no feature is just behind.
    for (const TriangleMesh& body : {makeSphere(1.0, 3), cube(1)})
    {
        const Scene scene{body, poseOf({0.3, -0.2, 0.9}, 0.4), floorAt(0, 5)};
        const Scene below{body, poseOf({0.3, -0.2, -0.9}, 0.4), floorAt(0, 5)};
        for (const auto& [s, normal] :
             {std::pair(scene, Vector3d(0, 0, -1)), std::pair(below, Vector3d(0, 0, 1))})
        {
            const PatchWorkspace work = patchesOf(s);
            ASSERT_EQ(work.contacts.size(), 4U);
            expectNormals(work.raw, normal);
            for (const Contact& contact : work.contacts)
            {
                EXPECT_EQ(contact.gap, 0.0);
            }
            EXPECT_GT(spannedArea(work.contacts), 0.3);
        }
    }
}

TEST(ContactPatches, FlatPlatesThroughEachOtherAreInContact)
{
    Random random(5);
    const TriangleMesh ground = raggedFloor(random, 20, 3.0);
    // Only edges inside flat parts are near.
    const Scene scene{ground, poseOf({0, 0, 0.3}, 1.2, Vector3d::UnitX()), ground};
    const PatchWorkspace work = patchesOf(scene);
    ASSERT_FALSE(work.contacts.empty());
    EXPECT_EQ(work.contacts[0].gap, 0.0);
}

/// The nearest points of a pair of triangles, if each is the nearest to the other on the surface
/// around it, and by how much the triangles around rise towards the other.
bool isStrictMinimum(const OracleDistance& pair, const TriangleMesh& a, const TriangleMesh& b)
{
    const double least = pair.distance * (1.0 - 1e-9);
    return distanceAround(pair.pointB, pair.pointA, a) >= least &&
           distanceAround(pair.pointA, pair.pointB, b) >= least;
}

TEST(ContactPatches, OfRandomBodiesAllLocalMinimaAreFound)
{
    Random random(17);
    int minima = 0;
    int scenes = 0;
    for (int trial = 0; trial < 400; ++trial)
    {
        Scene scene{randomMesh(random), random.pose(1.0), randomMesh(random)};
        const Vector3d direction = random.direction();
        scene.X_WA.translation() = 4.0 * direction;
        Isometry3d apart = scene.X_WA;
        // Towards each other until they are near.
        const double wanted = random.uniform(0.001, 0.02);
        for (int step = 0; step < 60; ++step)
        {
            const double d = bruteForceMeshDistance(scene.meshA, scene.meshB, apart).distance;
            apart.translation() -= (d - wanted) * direction;
            if (d - wanted < 1e-6)
            {
                break;
            }
        }
        scene.X_WA = apart;
        const OracleDistance nearest = bruteForceMeshDistance(scene.meshA, scene.meshB, scene.X_WA);
        if (nearest.distance < 1e-4 || nearest.distance > 0.03)
        {
            continue;
        }
        ++scenes;
        constexpr double kNear = 0.04;
        const PatchWorkspace work = patchesOf(scene, kNear);
        expectLocalMinima(work.raw, scene, kNear);
        ASSERT_FALSE(work.contacts.empty());
        EXPECT_NEAR(work.raw.front().gap, nearest.distance, 1e-10);
        const TriangleMesh inB = placed(scene.meshA, scene.X_WA);
        for (std::size_t i = 0; i < inB.triangles.size(); ++i)
        {
            for (std::size_t j = 0; j < scene.meshB.triangles.size(); ++j)
            {
                const OracleDistance pair =
                    bruteForceTriangleDistance(cornersOf(inB, i), cornersOf(scene.meshB, j));
                if (pair.distance <= 0.0 || pair.distance > kNear ||
                    !isStrictMinimum(pair, inB, scene.meshB))
                {
                    continue;
                }
                ++minima;
                EXPECT_TRUE(std::any_of(work.raw.begin(),
                                        work.raw.end(),
                                        [&](const Contact& c) {
                                            return (c.pointA - pair.pointA).norm() < 1e-6 &&
                                                   (c.pointB - pair.pointB).norm() < 1e-6;
                                        }))
                    << trial << ": " << pair.distance;
            }
        }
    }
    EXPECT_GT(scenes, 200);
    EXPECT_GT(minima, 2 * scenes);
}

TEST(ContactPatches, OnFlatGroundTheContactsAreThoseOfContactsAt)
{
    Random random(23);
    const TriangleMesh ground = raggedFloor(random, 12, 3.0);
    const std::vector<TriangleMesh> bodies{
        cube(0.5), makeCylinder(0.4, 0.6, 24), makeTorus(0.4, 0.1, 24, 12), octahedron()};
    std::size_t count = 0;
    for (int trial = 0; trial < 60; ++trial)
    {
        const TriangleMesh& body = bodies[static_cast<std::size_t>(trial) % bodies.size()];
        Isometry3d X =
            poseOf({random.uniform(-1, 1), random.uniform(-1, 1), 0.0}, random.uniform(0, 6));
        X.linear() =
            X.linear() * Eigen::AngleAxisd(random.uniform(-1e-4, 1e-4), random.direction());
        const double low = bounds(placed(body, X)).min().z();
        X.translation().z() = kGap - low;
        const Scene scene{body, X, ground};
        const PatchWorkspace work = patchesOf(scene);
        const SsvTree treeA = buildSsvTree(scene.meshA);
        const SsvTree treeB = buildSsvTree(scene.meshB);
        const std::vector<FeatureContact> reference =
            contactsAt({.tree = &treeA, .motion = restAt(X)},
                       {.tree = &treeB, .motion = restAt(scene.X_WB)},
                       0.0,
                       kThreshold);
        EXPECT_EQ(work.raw.size(), reference.size());
        for (const FeatureContact& r : reference)
        {
            EXPECT_TRUE(std::any_of(work.raw.begin(),
                                    work.raw.end(),
                                    [&](const Contact& c) {
                                        return (c.pointA - r.pointA).norm() < 1e-9 &&
                                               (c.normal - r.normal).norm() < 1e-6;
                                    }));
        }
        count += reference.size();
    }
    EXPECT_GT(count, 240U);
}

TEST(ContactPatches, NeitherTheFrameNorTheOrderOfTheBodiesMatters)
{
    Random random(41);
    const TriangleMesh ground = raggedFloor(random, 12, 3.0);
    const Scene scene{makeCylinder(0.4, 0.6, 24), poseOf({0.2, 0.1, 0.3 + kGap}), ground};
    const PatchWorkspace work = patchesOf(scene);
    ASSERT_EQ(work.raw.size(), 24U);
    for (int trial = 0; trial < 20; ++trial)
    {
        const Isometry3d X = random.pose(3.0);
        const PatchWorkspace moved =
            patchesOf({scene.meshA, X * scene.X_WA, scene.meshB, X * scene.X_WB});
        const PatchWorkspace swapped =
            patchesOf({scene.meshB, X * scene.X_WB, scene.meshA, X * scene.X_WA});
        ASSERT_EQ(moved.raw.size(), work.raw.size());
        ASSERT_EQ(swapped.raw.size(), work.raw.size());
        for (const Contact& c : work.raw)
        {
            EXPECT_TRUE(std::any_of(moved.raw.begin(),
                                    moved.raw.end(),
                                    [&](const Contact& m)
                                    { return (m.pointA - X * c.pointA).norm() < 1e-9; }));
            EXPECT_TRUE(std::any_of(swapped.raw.begin(),
                                    swapped.raw.end(),
                                    [&](const Contact& s)
                                    {
                                        return (s.pointB - X * c.pointA).norm() < 1e-9 &&
                                               (s.normal + X.linear() * c.normal).norm() < 1e-9;
                                    }));
        }
    }
}

TEST(ContactPatches, OfABumpyFootTheBumpsThatCanTouchAreKept)
{
    Random random(13);
    int tested = 0;
    for (int trial = 0; trial < 100; ++trial)
    {
        // Bumps at a height of up to half the threshold above the lowest, and a body that leans by
        // a few percent of it over the size of the foot.
        PatchWorkspace work;
        const int count = random.integer(10, 200);
        const Vector2d lean(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02));
        for (int i = 0; i < count; ++i)
        {
            const Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), 0.0);
            const double gap = 1e-3 * (0.4 + random.uniform(0.0, 0.5) + lean.dot(p.head<2>()));
            work.raw.push_back({.pointA = p,
                                .pointB = p - gap * Vector3d::UnitZ(),
                                .normal = -Vector3d::UnitZ(),
                                .gap = gap,
                                .triangleA = i,
                                .triangleB = 0});
        }
        reducePatches({.threshold = 1e-3}, work);
        ASSERT_LE(work.contacts.size(), static_cast<std::size_t>(kPointsPerPatch));
        // Whichever way it leans from here, what then is lowest is kept, or hardly lower than that.
        for (int k = 0; k < 24; ++k)
        {
            const double angle = 2.0 * std::numbers::pi * k / 24;
            const Vector2d slope(0.02 * std::cos(angle), 0.02 * std::sin(angle));
            const auto lowest = [&](const std::vector<Contact>& contacts)
            {
                double least = std::numeric_limits<double>::infinity();
                for (const Contact& c : contacts)
                {
                    least = std::min(least, c.gap + 1e-3 * slope.dot(c.pointA.head<2>()));
                }
                return least;
            };
            EXPECT_LE(lowest(work.contacts), lowest(work.raw) + 0.05 * 1e-3);
            ++tested;
        }
    }
    EXPECT_EQ(tested, 2400);
}

TEST(ContactPatches, APatchKeepsItsPointsWhileTheyHold)
{
    const TriangleMesh ring = makeTorus(0.04, 0.005, 96, 24);
    const SsvTree treeA = buildSsvTree(ring);
    const SsvTree treeB = buildSsvTree(floorAt(0, 1));
    const ContactSurface surfaceA(treeA);
    const ContactSurface surfaceB(treeB);
    PatchWorkspace work;
    std::vector<Vector3d> first;
    Isometry3d last = Isometry3d::Identity();
    Random random(3);
    for (int i = 0; i < 50; ++i)
    {
        // Rocks, turns and slides; in the frame of the ring the points stay.
        const Isometry3d X =
            poseOf({1e-3 * i, 0, 0.005 + kGap}, 0.02 * i) *
            Isometry3d(Eigen::AngleAxisd(random.uniform(-1e-4, 1e-4), random.direction()));
        work.former.clear();
        for (const Contact& c : work.contacts)
        {
            work.former.push_back({.onA = X * (last.inverse() * c.pointA), .onB = c.pointB});
        }
        last = X;
        findPatches(surfaceA, X, surfaceB, Isometry3d::Identity(), {.threshold = kThreshold}, work);
        ASSERT_EQ(work.contacts.size(), 4U);
        for (const Contact& c : work.contacts)
        {
            const Vector3d point = X.inverse() * c.pointA;
            if (i == 0)
            {
                first.push_back(point);
            }
            EXPECT_TRUE(std::any_of(first.begin(),
                                    first.end(),
                                    [&](const Vector3d& p) { return (p - point).norm() < 1e-9; }))
                << i;
        }
    }
    // Tilted so far that they are not deep enough any more.
    const Isometry3d X = poseOf({0, 0, 0.005 + kGap + 0.04 * std::sin(0.02)}, 0.02, {1, 0, 0});
    work.former.clear();
    for (const Vector3d& point : first)
    {
        work.former.push_back({.onA = X * point, .onB = X * point});
    }
    findPatches(surfaceA, X, surfaceB, Isometry3d::Identity(), {.threshold = kThreshold}, work);
    EXPECT_LE(work.contacts.front().gap, work.raw.front().gap + 0.02 * kThreshold);
}

/// All of them, bit by bit.
bool areSame(const std::vector<Contact>& x, const std::vector<Contact>& y)
{
    return std::ranges::equal(x,
                              y,
                              [](const Contact& a, const Contact& b)
                              {
                                  return a.pointA == b.pointA && a.pointB == b.pointB &&
                                         a.normal == b.normal && a.gap == b.gap &&
                                         a.triangleA == b.triangleA && a.triangleB == b.triangleB;
                              });
}

TEST(ContactPatches, KeptPairsOfTrianglesChangeNoAnswer)
{
    // Slow, then fast, then where nothing is near for a while.
    Random random(5);
    const SsvTree treeA = buildSsvTree(makeTorus(0.04, 0.005, 96, 24));
    const SsvTree treeB = buildSsvTree(raggedFloor(random, 40, 0.2));
    const ContactSurface surfaceA(treeA);
    const ContactSurface surfaceB(treeB);
    ContactSearchWorkspace freshWork;
    ContactSearchWorkspace keptWork;
    KeptSlots kept;
    Isometry3d X = poseOf({0.01, 0.02, 0.005 + kGap});
    std::size_t found = 0;
    std::size_t empty = 0;
    for (int k = 0; k < 900; ++k)
    {
        const double step = k % 300 < 200 ? 0.05 * kThreshold : 2.0 * kThreshold;
        X.translation() += step * random.direction();
        X.translation().z() =
            0.005 + (k / 300 == 1 ? 10.0 : 1.0) * kGap + step * random.uniform(-1.0, 1.0);
        X.rotate(Eigen::AngleAxisd(10.0 * step, random.direction()));
        std::vector<Contact> fresh;
        std::vector<Contact> again;
        appendContacts(surfaceA, X, surfaceB, Isometry3d::Identity(), kThreshold, freshWork, fresh);
        appendContacts(
            surfaceA, X, surfaceB, Isometry3d::Identity(), kThreshold, keptWork, again, &kept);
        ASSERT_TRUE(areSame(fresh, again)) << k;
        (fresh.empty() ? empty : found) += 1;
    }
    EXPECT_GT(found, 300);
    EXPECT_GT(empty, 100);
    // Bounds of distances tell more pairs apart than volumes do.
    EXPECT_LT(keptWork.pairs, 0.9 * static_cast<double>(freshWork.pairs));
}

TEST(ContactPatches, AWarmWorkspaceDoesNotGrow)
{
    Random random(3);
    const SsvTree treeA = buildSsvTree(makeTorus(0.04, 0.005, 96, 24));
    const SsvTree treeB = buildSsvTree(raggedFloor(random, 40, 0.2));
    const ContactSurface surfaceA(treeA);
    const ContactSurface surfaceB(treeB);
    PatchWorkspace work;
    const auto capacities = [&]
    {
        return std::array{work.raw.capacity(),
                          work.patchOf.capacity(),
                          work.members.capacity(),
                          work.patches.capacity(),
                          work.contacts.capacity(),
                          work.search.open.capacity(),
                          work.search.slots.capacity(),
                          work.search.pierced.capacity()};
    };
    for (const double height : {kGap, -0.5 * kGap, -0.004})
    {
        const Isometry3d X = poseOf({0.01, 0.02, 0.005 + height});
        const auto find = [&] {
            findPatches(
                surfaceA, X, surfaceB, Isometry3d::Identity(), {.threshold = kThreshold}, work);
        };
        find();
        EXPECT_FALSE(work.contacts.empty());
        const auto before = capacities();
        find();
        EXPECT_EQ(capacities(), before);
    }
}

TEST(ContactPatches, TheFourPointsOfAPatchSpanNearlyWhatAnyFourCan)
{
    Random random(11);
    for (int trial = 0; trial < 100; ++trial)
    {
        PatchWorkspace work;
        const int count = random.integer(5, 25);
        std::vector<Vector2d> points;
        for (int i = 0; i < count; ++i)
        {
            const Vector3d p(random.uniform(-1, 1), random.uniform(-0.3, 0.3), 0.0);
            points.emplace_back(p.head<2>());
            const double gap = 1e-3 * random.uniform(0.5, 1.0);
            work.raw.push_back({.pointA = p,
                                .pointB = p - gap * Vector3d::UnitZ(),
                                .normal = -Vector3d::UnitZ(),
                                .gap = gap,
                                .triangleA = i,
                                .triangleB = 0});
        }
        const double deepest =
            std::min_element(work.raw.begin(),
                             work.raw.end(),
                             [](const Contact& x, const Contact& y) { return x.gap < y.gap; })
                ->gap;
        const Vector2d first =
            std::min_element(work.raw.begin(),
                             work.raw.end(),
                             [](const Contact& x, const Contact& y) { return x.gap < y.gap; })
                ->pointA.head<2>();
        double largest = 0.0;
        for (std::size_t b = 0; b < points.size(); ++b)
        {
            for (std::size_t c = b + 1; c < points.size(); ++c)
            {
                for (std::size_t d = c + 1; d < points.size(); ++d)
                {
                    largest = std::max(largest, hullArea({first, points[b], points[c], points[d]}));
                }
            }
        }
        reducePatches({.threshold = 1e-3}, work);
        EXPECT_LE(work.contacts.front().gap, deepest + 0.02 * 1e-3);
        EXPECT_GE(spannedArea(work.contacts), 0.85 * largest);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
