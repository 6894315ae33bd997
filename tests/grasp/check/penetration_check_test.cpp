#include "grasp/check/penetration_check.h"

#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/check/box_grid.h"
#include "grasp/check/closed_surface.h"
#include "grasp/check/sign_test.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kSmall = 1e-6;

/// A hand of loose links: all hang from the world by prismatic joints along x.
HandModel handOf(const std::vector<TriangleMesh>& meshes)
{
    HandModel hand;
    for (std::size_t i = 0; i < meshes.size(); ++i)
    {
        Link& link = hand.robot.tree.links.emplace_back();
        link.parent = i == 0 ? kNone : 0;
        link.joint.type = i == 0 ? JointType::Fixed : JointType::Prismatic;
    }
    hand.robot.linkMeshes = meshes;
    return hand;
}

PenetrationReport check(const TriangleMesh& link,
                        const TriangleMesh& object,
                        const Eigen::Isometry3d& pose)
{
    return checkPenetration(handOf({link}), makeGraspObject("object", object), pose, {0.0});
}

PenetrationReport checkAt(const TriangleMesh& link,
                          const TriangleMesh& object,
                          const Eigen::Vector3d& place)
{
    return check(link, object, Eigen::Isometry3d(Eigen::Translation3d(place)));
}

Eigen::Vector3d randomVector(std::mt19937& random, double size)
{
    std::uniform_real_distribution<double> uniform(-size, size);
    return {uniform(random), uniform(random), uniform(random)};
}

Eigen::Isometry3d randomPose(std::mt19937& random, double size)
{
    Eigen::Isometry3d pose(Eigen::Translation3d(randomVector(random, size)));
    pose.rotate(Eigen::AngleAxisd(std::uniform_real_distribution<double>(0.0, 3.0)(random),
                                  randomVector(random, 1.0).normalized()));
    return pose;
}

TriangleMesh reversed(TriangleMesh mesh)
{
    for (Triangle& triangle : mesh.triangles)
    {
        std::swap(triangle[1], triangle[2]);
    }
    return mesh;
}

Corners cornersOf(const TriangleMesh& mesh, const Triangle& t, const Eigen::Isometry3d& pose)
{
    return {pose * mesh.vertices[static_cast<std::size_t>(t[0])],
            pose * mesh.vertices[static_cast<std::size_t>(t[1])],
            pose * mesh.vertices[static_cast<std::size_t>(t[2])]};
}

TEST(PenetrationCheck, BoxOnBoxIsCleanAboveAndFoundBelowTheSurface)
{
    const TriangleMesh object = makeBox({1.0, 1.0, 1.0});
    const TriangleMesh small = makeBox({0.3, 0.2, 0.1});
    for (const TriangleMesh& link : {small, object})
    {
        const double contact = 1.0 + bounds(link).max().z();
        for (const Eigen::Vector2d& offset : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.1, 0.17)})
        {
            const auto at = [&](double z)
            { return Eigen::Vector3d(offset.x(), offset.y(), contact + z); };
            EXPECT_TRUE(checkAt(link, object, at(kSmall)).clean());
            EXPECT_TRUE(checkAt(link, object, at(0.0)).clean());
            EXPECT_FALSE(checkAt(link, object, at(-kSmall)).clean());
        }
    }
}

TEST(PenetrationCheck, SphereOnBoxIsCleanAboveAndFoundBelowTheSurface)
{
    const TriangleMesh object = makeBox({1.0, 1.0, 1.0});
    const TriangleMesh sphere = makeSphere(0.2, 3);
    std::mt19937 random(1);
    for (int trial = 0; trial < 20; ++trial)
    {
        Eigen::Isometry3d pose = randomPose(random, 0.5);
        double lowest = 1.0;
        for (const Eigen::Vector3d& vertex : sphere.vertices)
        {
            lowest = std::min(lowest, (pose.linear() * vertex).z());
        }
        pose.translation().z() = 1.0 - lowest + kSmall;
        EXPECT_TRUE(check(sphere, object, pose).clean());
        pose.translation().z() = 1.0 - lowest - kSmall;
        const PenetrationReport report = check(sphere, object, pose);
        EXPECT_GE(report.intersectingTriangles, 1);
        EXPECT_EQ(report.verticesInside, 1);
        EXPECT_NEAR(report.deepest, kSmall, 1e-12);
        EXPECT_EQ(report.link, 0);
    }
}

// Edge against edge at right angles: no vertex is near the other body.
TEST(PenetrationCheck, CrossedEdgesAreCleanApartAndFoundTogether)
{
    const TriangleMesh bar = makeBox({1.0, 0.1, 0.1});
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const double contact = 0.2 * std::sqrt(2.0);  // two square bars standing on an edge
    const Eigen::AngleAxisd onEdge(std::numbers::pi / 4.0, Eigen::Vector3d::UnitX());
    TriangleMesh object = bar;
    transformMesh(object, Eigen::Affine3d(onEdge));
    pose.linear() =
        Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ()) * onEdge.matrix();
    pose.translation() = Eigen::Vector3d(0.013, 0.021, contact + kSmall);
    EXPECT_TRUE(check(bar, object, pose).clean());
    pose.translation().z() = contact - kSmall;
    const PenetrationReport report = check(bar, object, pose);
    EXPECT_GE(report.intersectingTriangles, 1);
    EXPECT_EQ(report.verticesInside, 0);
}

// Axis-aligned bars: edges meet faces exactly on the diagonals of their two triangles.
TEST(PenetrationCheck, EdgesThatRunThroughSeamsAreFound)
{
    const TriangleMesh object = makeBox({1.0, 0.1, 0.1});
    const TriangleMesh across = makeBox({0.1, 1.0, 0.1});
    for (const double offset : {0.0, 0.05, 0.1, 0.199})
    {
        const PenetrationReport report = checkAt(across, object, {0.0, 0.0, offset});
        EXPECT_GE(report.intersectingTriangles, 1) << offset;
    }
    EXPECT_TRUE(checkAt(across, object, {0.0, 0.0, 0.2}).clean());
}

// Touching, up to the rounding of the pose, in random directions.
TEST(PenetrationCheck, BoxesThatTouchAreCleanInAnyOrientation)
{
    const TriangleMesh box = makeBox({0.1, 0.2, 0.3});
    std::mt19937 random(3);
    for (int trial = 0; trial < 50; ++trial)
    {
        const Eigen::Isometry3d common = randomPose(random, 0.3);
        TriangleMesh object = box;
        transformMesh(object, Eigen::Affine3d(common));
        EXPECT_TRUE(check(box, object, common * Eigen::Translation3d(0.05, 0.4, 0.1)).clean());
        EXPECT_FALSE(
            check(box, object, common * Eigen::Translation3d(0.05, 0.4 - kSmall, 0.1)).clean());
    }
}

TEST(PenetrationCheck, BoxesThatCoincideOrShareSideFacesAreFound)
{
    const TriangleMesh box = makeBox({0.1, 0.2, 0.3});
    EXPECT_FALSE(checkAt(box, box, {0.0, 0.0, 0.0}).clean());
    EXPECT_FALSE(checkAt(box, box, {0.05, 0.0, 0.0}).clean());
    EXPECT_FALSE(checkAt(box, box, {0.0, 0.4 - kSmall, 0.0}).clean());
    EXPECT_TRUE(checkAt(box, box, {0.0, 0.4 + kSmall, 0.0}).clean());
}

TEST(PenetrationCheck, LinkInsideTheObjectIsFoundByItsVertices)
{
    const TriangleMesh object = makeBox({1.0, 1.0, 1.0});
    const TriangleMesh link = makeBox({0.1, 0.1, 0.1});
    const PenetrationReport report = checkAt(link, object, {0.3, 0.0, 0.0});
    EXPECT_EQ(report.intersectingTriangles, 0);
    EXPECT_EQ(report.verticesInside, 8);
    EXPECT_NEAR(report.deepest, 0.8, 1e-14);
}

TEST(PenetrationCheck, ObjectInsideALinkIsFoundByItsVertices)
{
    const TriangleMesh object = makeBox({0.1, 0.1, 0.1});
    const TriangleMesh link = makeBox({1.0, 1.0, 1.0});
    const PenetrationReport report = checkAt(link, object, {0.3, 0.0, 0.0});
    EXPECT_EQ(report.intersectingTriangles, 0);
    EXPECT_EQ(report.verticesInside, 8);
    EXPECT_NEAR(report.deepest, 0.8, 1e-14);
}

TEST(PenetrationCheck, LinkInTheCavityOfAnObjectIsClean)
{
    TriangleMesh object = makeBox({1.0, 1.0, 1.0});
    appendMesh(object, reversed(makeBox({0.5, 0.5, 0.5})));
    const TriangleMesh link = makeBox({0.1, 0.1, 0.1});
    EXPECT_TRUE(checkAt(link, object, {0.2, 0.1, 0.0}).clean());
    EXPECT_EQ(checkAt(link, object, {0.75, 0.0, 0.0}).verticesInside, 8);
}

TEST(PenetrationCheck, InsideOfAnOpenObjectIsNotClaimed)
{
    TriangleMesh object = makeBox({1.0, 1.0, 1.0});
    object.triangles.pop_back();
    EXPECT_TRUE(checkAt(makeBox({0.1, 0.1, 0.1}), object, {0.0, 0.0, 0.0}).clean());
    EXPECT_FALSE(checkAt(makeBox({0.1, 0.1, 0.1}), object, {0.0, 0.95, 0.0}).clean());
}

TEST(PenetrationCheck, LinkedToriAreCleanUntilTheirTubesMeet)
{
    const TriangleMesh torus = makeTorus(1.0, 0.2, 64, 24);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
    for (double x = 0.45; x < 1.6; x += 0.04)
    {
        pose.translation().x() = x;
        // The tube centres of the linked rings are nearest on the x axis: |x - 0| and 2 - x apart.
        const double apart = std::min(x, 2.0 - x);
        if (apart > 0.4)
        {
            EXPECT_TRUE(check(torus, torus, pose).clean()) << x;
        }
    }
    pose.translation().x() = 0.38;
    EXPECT_FALSE(check(torus, torus, pose).clean());
    pose.translation().x() = 1.62;
    EXPECT_FALSE(check(torus, torus, pose).clean());
}

TEST(PenetrationCheck, TheFirstLinkConcernedIsNamed)
{
    const TriangleMesh box = makeBox({0.1, 0.1, 0.1});
    const HandModel hand = handOf({box, {}, box, box});
    const GraspObject object = makeGraspObject("object", box);
    const Eigen::Isometry3d away(Eigen::Translation3d(1.0, 0.03, 0.04));
    EXPECT_TRUE(checkPenetration(hand, object, away, {0, 0, 0.5, -0.5}).clean());
    EXPECT_EQ(checkPenetration(hand, object, away, {0, 0, 0.5, -0.5}).link, kNone);
    const PenetrationReport report = checkPenetration(hand, object, away, {0, 0, 0.5, -0.85});
    EXPECT_FALSE(report.clean());
    EXPECT_EQ(report.link, 3);
}

// Every pair of triangles, by a distance query that knows neither signs nor grids.
TEST(PenetrationCheck, RandomPosesAgreeWithAllPairsOfTriangles)
{
    const TriangleMesh link = makeTorus(0.3, 0.1, 14, 8);
    const TriangleMesh object = makeSphere(0.4, 2);
    std::mt19937 random(5);
    int intersecting = 0;
    constexpr int kTrials = 30;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const Eigen::Isometry3d pose = randomPose(random, 0.6);
        std::int64_t expected = 0;
        for (const Triangle& a : link.triangles)
        {
            const Corners corners = cornersOf(link, a, pose);
            for (const Triangle& b : object.triangles)
            {
                const Corners other = cornersOf(object, b, Eigen::Isometry3d::Identity());
                expected += triangleDistance(corners, other).distance == 0.0 ? 1 : 0;
            }
        }
        EXPECT_EQ(check(link, object, pose).intersectingTriangles, expected);
        intersecting += expected > 0 ? 1 : 0;
    }
    EXPECT_GE(intersecting, 3 * kTrials / 10);
    EXPECT_LE(intersecting, 7 * kTrials / 10);
}

// Where no surfaces cross, one vertex of each part tells what all vertices do.
TEST(PenetrationCheck, OneVertexOfEachPartTellsWhatIsInside)
{
    TriangleMesh object = makeBox({0.5, 0.5, 0.5});
    appendMesh(object, reversed(makeBox({0.3, 0.3, 0.3})));  // a cavity
    TriangleMesh link = makeTorus(0.08, 0.02, 8, 6);
    for (const Eigen::Vector3d& place : {Eigen::Vector3d(0.0, 0.8, 0.0), Eigen::Vector3d(0, 0, 2)})
    {
        TriangleMesh part = makeBox({0.02, 0.03, 0.04});
        for (Eigen::Vector3d& vertex : part.vertices)
        {
            vertex += place;
        }
        appendMesh(link, part);
    }
    const TriangleMesh shell = makeBox({2.5, 2.5, 2.5});
    const HandModel hand = handOf({link, shell});
    const GraspObject target = makeGraspObject("object", object);
    PenetrationCheck check(hand, target);
    std::mt19937 random(11);
    std::array<int, 2> apart{};
    for (int trial = 0; trial < 300; ++trial)
    {
        const Eigen::Isometry3d pose = randomPose(random, 1.0);
        // The shell is either around the object or far away.
        const std::vector<double> positions{0.0, trial % 2 == 0 ? 0.0 : 20.0};
        const PenetrationReport report = check.at(pose, positions);
        if (report.intersectingTriangles == 0)
        {
            EXPECT_EQ(check.holdsInside(pose, positions), report.verticesInside > 0);
            ++apart[report.verticesInside > 0 ? 1 : 0];
        }
    }
    EXPECT_GE(apart[0], 30);
    EXPECT_GE(apart[1], 30);
}

TEST(BoxGrid, FindsExactlyTheBoxesThatOverlap)
{
    std::mt19937 random(7);
    std::vector<Eigen::AlignedBox3d> boxes;
    for (int i = 0; i < 500; ++i)
    {
        const Eigen::Vector3d low = randomVector(random, 1.0);
        boxes.emplace_back(low, low + 0.2 * randomVector(random, 1.0).cwiseAbs());
    }
    BoxGrid grid(boxes);
    std::vector<std::int32_t> found;
    std::size_t hits = 0;
    for (int i = 0; i < 500; ++i)
    {
        const Eigen::Vector3d low = randomVector(random, 1.2);
        const Eigen::AlignedBox3d box(low, low + 0.2 * randomVector(random, 1.0).cwiseAbs());
        std::vector<std::int32_t> expected;
        for (std::size_t k = 0; k < boxes.size(); ++k)
        {
            if (boxes[k].intersects(box))
            {
                expected.push_back(static_cast<std::int32_t>(k));
            }
        }
        grid.query(box, found);
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, expected);
        hits += expected.size();
    }
    EXPECT_GT(hits, 100U);
}

TEST(BoxGrid, WithoutBoxesFindsNothing)
{
    BoxGrid grid({});
    std::vector<std::int32_t> found = {1};
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    grid.query(Eigen::AlignedBox3d(zero, zero), found);
    EXPECT_TRUE(found.empty());
}

// The box's corners, edges and face diagonals lie on many a ray.
TEST(ClosedSurface, ContainsThePointsOfABoxAlsoOnALattice)
{
    const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
    ClosedSurface surface(box);
    for (int x = -5; x <= 5; ++x)
    {
        for (int y = -5; y <= 5; ++y)
        {
            for (int z = -5; z <= 5; ++z)
            {
                const Eigen::Vector3d point = Eigen::Vector3d(x, y, z) / 4.0;
                const double reach = point.cwiseAbs().maxCoeff();
                EXPECT_EQ(surface.contains(point), reach < 1.0) << point.transpose();
            }
        }
    }
}

TEST(ClosedSurface, ContainsThePointsOfATorus)
{
    constexpr double kMinor = 0.3;
    const TriangleMesh torus = makeTorus(1.0, kMinor, 96, 48);
    ClosedSurface surface(torus);
    std::mt19937 random(9);
    int inside = 0;
    int decided = 0;
    for (int i = 0; i < 5000; ++i)
    {
        const Eigen::Vector3d point =
            randomVector(random, 1.0).cwiseProduct(Eigen::Vector3d(1.3, 1.3, 0.3));
        const double fromTube = std::hypot(point.head<2>().norm() - 1.0, point.z());
        if (std::abs(fromTube - kMinor) < 0.005)
        {
            continue;  // between the torus and its inscribed mesh
        }
        ++decided;
        inside += fromTube < kMinor ? 1 : 0;
        EXPECT_EQ(surface.contains(point), fromTube < kMinor) << point.transpose();
        EXPECT_NEAR(surface.distance(point), std::abs(fromTube - kMinor), 0.005);
    }
    EXPECT_GT(inside, 3 * decided / 10);
    EXPECT_LT(inside, 7 * decided / 10);
}

/// Exact sign for integer points; the products stay far below 2^62.
int exactOrient3d(const std::array<std::array<std::int64_t, 3>, 4>& p)
{
    const auto at = [&](std::size_t point, std::size_t axis)
    { return p[point][axis] - p[3][axis]; };
    const std::int64_t determinant = at(0, 0) * (at(1, 1) * at(2, 2) - at(2, 1) * at(1, 2)) -
                                     at(1, 0) * (at(0, 1) * at(2, 2) - at(2, 1) * at(0, 2)) +
                                     at(2, 0) * (at(0, 1) * at(1, 2) - at(1, 1) * at(0, 2));
    return determinant > 0 ? 1 : (determinant < 0 ? -1 : 0);
}

// Four points of a small lattice are often coplanar, and all their differences and products are
// exact in double precision.
TEST(SignTest, SignsAreThoseOfExactArithmetic)
{
    std::mt19937 random(11);
    std::uniform_int_distribution<std::int64_t> lattice(-3, 3);
    int flat = 0;
    constexpr int kTrials = 20000;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        std::array<std::array<std::int64_t, 3>, 4> p{};
        std::array<Eigen::Vector3d, 4> q;
        for (std::size_t i = 0; i < 4; ++i)
        {
            for (std::size_t k = 0; k < 3; ++k)
            {
                p[i][k] = lattice(random);
                q[i][static_cast<Eigen::Index>(k)] = 1.0 + 0x1p-20 * static_cast<double>(p[i][k]);
            }
        }
        const int expected = exactOrient3d(p);
        flat += expected == 0 ? 1 : 0;
        EXPECT_EQ(orient3d(q[0], q[1], q[2], q[3]), expected);
    }
    EXPECT_GT(flat, kTrials / 100);
    EXPECT_LT(flat, kTrials / 2);
}

TEST(SignTest, ASignIsGivenOnlyIfRoundingLeavesNoDoubt)
{
    const Eigen::Vector3d a(0.1, 0.2, 0.3);
    const Eigen::Vector3d b(0.7, 0.1, 0.9);
    const Eigen::Vector3d c(0.4, 0.8, 0.2);
    const Eigen::Vector3d up = (b - a).cross(c - a).normalized();
    std::mt19937 random(12);
    for (int i = 0; i < 1000; ++i)
    {
        const Eigen::Vector3d weights = randomVector(random, 1.0);
        const Eigen::Vector3d flat = a + weights.x() * (b - a) + weights.y() * (c - a);
        EXPECT_EQ(orient3d(a, b, c, flat + 1e-14 * up), -1);
        EXPECT_EQ(orient3d(a, b, c, flat - 1e-14 * up), 1);
    }
}

TEST(SignTest, PointTriangleDistanceAgreesWithTheTriangleOfOnePoint)
{
    std::mt19937 random(13);
    for (int i = 0; i < 2000; ++i)
    {
        const Corners corners = {
            randomVector(random, 1.0), randomVector(random, 1.0), randomVector(random, 1.0)};
        const Eigen::Vector3d point = randomVector(random, 1.5);
        const double expected = triangleDistance({point, point, point}, corners).distance;
        EXPECT_NEAR(pointTriangleDistance(point, corners), expected, 1e-12);
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
