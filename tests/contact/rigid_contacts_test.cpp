#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/contact/contacts.h"
#include "bullet_ccd/math/pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
constexpr double kGap = 1e-4;
constexpr double kThreshold = 2e-4;
constexpr double kRounding = 1e-12;

RigidScene atRest(const TriangleMesh& a,
                  const Isometry3d& X_WA,
                  const TriangleMesh& b,
                  const Isometry3d& X_WB = Isometry3d::Identity())
{
    return {.meshA = a, .meshB = b, .motionA = restAt(X_WA), .motionB = restAt(X_WB)};
}

std::vector<FeatureContact> contactsOf(const RigidScene& scene,
                                       double threshold = kThreshold,
                                       double time = 0.0)
{
    const SsvTree treeA = buildSsvTree(scene.meshA);
    const SsvTree treeB = buildSsvTree(scene.meshB);
    return contactsAt({.tree = &treeA, .motion = scene.motionA},
                      {.tree = &treeB, .motion = scene.motionB},
                      time,
                      threshold);
}

/// Such as "vertex-face 4, edge-edge 2": how many of each kind, ordered by kinds.
std::string summary(const std::vector<FeatureContact>& contacts)
{
    constexpr std::array<const char*, 3> kNames{"vertex", "edge", "face"};
    std::map<std::pair<FeatureKind, FeatureKind>, int> counts;
    for (const FeatureContact& c : contacts)
    {
        ++counts[{c.featureA.kind, c.featureB.kind}];
    }
    std::string text;
    for (const auto& [kinds, count] : counts)
    {
        text += (text.empty() ? "" : ", ") +
                std::string(kNames[static_cast<std::size_t>(kinds.first)]) + "-" +
                kNames[static_cast<std::size_t>(kinds.second)] + " " + std::to_string(count);
    }
    return text;
}

Vector3d vertexOf(const TriangleMesh& mesh, std::int32_t index)
{
    return mesh.vertices[static_cast<std::size_t>(index)];
}

/// Distance of a point from the feature itself; also checks that the vertices are as documented.
double distanceToFeature(const Vector3d& point, const Feature& feature, const TriangleMesh& mesh)
{
    const auto count = static_cast<std::size_t>(feature.kind) + 1;
    for (std::size_t k = 0; k < 3; ++k)
    {
        EXPECT_EQ(feature.vertices[k] == kNone, k >= count);
        EXPECT_TRUE(k == 0 || k >= count || feature.vertices[k - 1] < feature.vertices[k]);
    }
    Corners corners{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        corners[k] = vertexOf(mesh, feature.vertices[std::min(k, count - 1)]);
    }
    return distanceToTriangle(point, corners);
}

bool isOf(const Feature& feature, const Triangle& triangle)
{
    return std::all_of(
        feature.vertices.begin(),
        feature.vertices.end(),
        [&](std::int32_t v)
        { return v == kNone || std::find(triangle.begin(), triangle.end(), v) != triangle.end(); });
}

bool isOfTriangles(const FeatureContact& c,
                   const RigidScene& scene,
                   std::int32_t triangleA,
                   std::int32_t triangleB)
{
    return isOf(c.featureA, scene.meshA.triangles[static_cast<std::size_t>(triangleA)]) &&
           isOf(c.featureB, scene.meshB.triangles[static_cast<std::size_t>(triangleB)]);
}

/// What every list of contacts promises. Meshes without vertices at equal positions.
void expectSound(const std::vector<FeatureContact>& contacts,
                 const RigidScene& scene,
                 double threshold = kThreshold,
                 double time = 0.0)
{
    const Isometry3d X_AW = scene.motionA.at(time).X_W.inverse();
    const Isometry3d X_BW = scene.motionB.at(time).X_W.inverse();
    std::set<std::pair<Feature, Feature>> seen;
    double last = 0.0;
    for (const FeatureContact& c : contacts)
    {
        EXPECT_TRUE(seen.insert({c.featureA, c.featureB}).second) << "twice";
        EXPECT_GE(c.gap, last);
        last = c.gap;
        EXPECT_LE(c.gap, threshold + kRounding);
        EXPECT_NEAR((c.pointB - c.pointA).norm(), c.gap, kRounding);
        EXPECT_NEAR(c.normal.norm(), 1.0, 1e-9);
        if (c.gap > 1e-7)
        {
            EXPECT_NEAR(c.normal.dot(c.pointB - c.pointA), c.gap, 1e-6 * c.gap);
        }
        EXPECT_LE(distanceToFeature(X_AW * c.pointA, c.featureA, scene.meshA), kRounding);
        EXPECT_LE(distanceToFeature(X_BW * c.pointB, c.featureB, scene.meshB), kRounding);
        EXPECT_TRUE(isOfTriangles(c, scene, c.triangleA, c.triangleB));
    }
}

/// Contacts without what rounding may change.
std::vector<std::pair<Feature, Feature>> featuresOf(const std::vector<FeatureContact>& contacts)
{
    std::vector<std::pair<Feature, Feature>> features;
    for (const FeatureContact& c : contacts)
    {
        features.emplace_back(c.featureA, c.featureB);
    }
    std::sort(features.begin(), features.end());
    return features;
}

/// Rotation that puts the diagonal of a cube upright.
Isometry3d onItsCorner(const Vector3d& at)
{
    Isometry3d X = Isometry3d::Identity();
    X.linear() = rotationBetween(Vector3d(1, 1, 1), Vector3d::UnitZ()).toRotationMatrix();
    X.translation() = at;
    return X;
}

/// Half the diagonal of a cube of half edge 1.
const double kHalfDiagonal = std::sqrt(3.0);

TEST(RigidContacts, ACubeOnItsCornerTouchesAPlateWithOneVertex)
{
    // Off the diagonal of the plate, which runs through the origin.
    const RigidScene scene =
        atRest(cube(1), onItsCorner({1, -2, kHalfDiagonal + kGap}), floorAt(0, 5));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    ASSERT_EQ(summary(contacts), "vertex-face 1");
    EXPECT_EQ(vertexOf(scene.meshA, contacts[0].featureA.vertices[0]), Vector3d(-1, -1, -1));
    EXPECT_EQ(contacts[0].featureB.vertices, (Triangle{0, 1, 2}));
    EXPECT_EQ(contacts[0].triangleB, 0);
    EXPECT_NEAR(contacts[0].gap, kGap, kRounding);
    EXPECT_LT((contacts[0].normal + Vector3d::UnitZ()).norm(), 1e-9);
    EXPECT_LT((contacts[0].pointB - Vector3d(1, -2, 0)).norm(), kRounding);
}

TEST(RigidContacts, ACornerOverTheDiagonalOfAPlateTouchesThatEdge)
{
    const RigidScene scene =
        atRest(cube(1), onItsCorner({1, 1, kHalfDiagonal + kGap}), floorAt(0, 5));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    ASSERT_EQ(summary(contacts), "vertex-edge 1");
    EXPECT_EQ(contacts[0].featureB.vertices, (Triangle{0, 2, kNone}));
    EXPECT_LT((contacts[0].normal + Vector3d::UnitZ()).norm(), 1e-9);
}

TEST(RigidContacts, ACornerJustInsideTheRimOfAFaceTouchesTheFaceOnly)
{
    // The rim is 1.00125 gaps away.
    const RigidScene scene = atRest(cube(1),
                                    onItsCorner({5 - 0.05 * kGap, -2, kHalfDiagonal + kGap}),
                                    box({-5, -5, -1}, {5, 5, 0}));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    EXPECT_EQ(summary(contacts), "vertex-face 1");
    EXPECT_EQ(summary(contactsOf(swapped(scene))), "face-vertex 1");
}

TEST(RigidContacts, ACubeOnItsEdgeTouchesAPlateWithBothEndsOfIt)
{
    // The edge crosses the plate's diagonal: that is no contact of its own.
    const RigidScene scene =
        atRest(cube(1),
               poseOf({0.5, 0, std::sqrt(2.0) + kGap}, std::numbers::pi / 4, Vector3d::UnitX()),
               floorAt(0, 5));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    ASSERT_EQ(summary(contacts), "vertex-face 2");
    std::set<double> x;
    for (const FeatureContact& c : contacts)
    {
        x.insert(std::round(c.pointA.x() * 1e6) / 1e6);
    }
    EXPECT_EQ(x, (std::set<double>{-0.5, 1.5}));
}

TEST(RigidContacts, ACubeOnItsFaceTouchesALargerPlateWithFourCorners)
{
    for (const double turn : {0.0, 0.3})
    {
        const RigidScene scene = atRest(cube(1), poseOf({0.3, 0.2, 1 + kGap}, turn), floorAt(0, 5));
        const auto contacts = contactsOf(scene);
        expectSound(contacts, scene);
        ASSERT_EQ(summary(contacts), "vertex-face 4");
        for (const FeatureContact& c : contacts)
        {
            EXPECT_NEAR(c.gap, kGap, kRounding);
            EXPECT_LT((c.normal + Vector3d::UnitZ()).norm(), 1e-9);
        }
    }
}

TEST(RigidContacts, TheOverlapOfTwoFacesIsBoundedByCornersAndCrossingEdges)
{
    // Squares of edge 2, one shifted by (0.5, 0.7): the overlap has a corner of each and two
    // crossings of their edges.
    const RigidScene shifted = atRest(cube(1), poseOf({0.5, 0.7, 2 + kGap}), cube(1));
    const auto overlap = contactsOf(shifted);
    expectSound(overlap, shifted);
    EXPECT_EQ(summary(overlap), "vertex-face 1, edge-edge 2, face-vertex 1");
    // Turned by an eighth: the overlap is an octagon.
    const RigidScene turned =
        atRest(cube(1), poseOf({0, 0, 2 + kGap}, std::numbers::pi / 4), cube(1));
    const auto octagon = contactsOf(turned);
    expectSound(octagon, turned);
    EXPECT_EQ(summary(octagon), "edge-edge 8");
    // Flush.
    const RigidScene stacked = atRest(cube(1), poseOf({0, 0, 2 + kGap}), cube(1));
    const auto corners = contactsOf(stacked);
    expectSound(corners, stacked);
    EXPECT_EQ(summary(corners), "vertex-vertex 4");
    for (const auto& contacts : {overlap, octagon, corners})
    {
        for (const FeatureContact& c : contacts)
        {
            EXPECT_LT((c.normal + Vector3d::UnitZ()).norm(), 1e-9);
        }
    }
}

TEST(RigidContacts, ASlightTiltKeepsAllCornersWithinTheThreshold)
{
    // The corners are between 0.5 and 1.5 gaps above the plate, two beyond its edge.
    const RigidScene scene =
        atRest(cube(1), poseOf({4.6, 0.2, 1 + kGap}, 0.5 * kGap, Vector3d::UnitY()), floorAt(0, 5));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    EXPECT_EQ(summary(contacts), "vertex-face 2, edge-edge 2");
    EXPECT_EQ(summary(contactsOf(scene, 1.2 * kGap)), "edge-edge 2");
}

TEST(RigidContacts, CrossedEdgesOfTwoCubesTouchOnce)
{
    const double height = 2 * std::sqrt(2.0) + kGap;
    const Isometry3d upper = poseOf({0.1, 0.2, height}, std::numbers::pi / 4, Vector3d::UnitX());
    const Isometry3d lower = poseOf({0, 0, 0}, std::numbers::pi / 4, Vector3d::UnitY());
    const RigidScene scene = atRest(cube(1), upper, cube(1), lower);
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    ASSERT_EQ(summary(contacts), "edge-edge 1");
    EXPECT_NEAR(contacts[0].gap, kGap, kRounding);
    EXPECT_LT((contacts[0].pointA - Vector3d(0, 0.2, std::sqrt(2.0) + kGap)).norm(), kRounding);
    EXPECT_LT((contacts[0].normal + Vector3d::UnitZ()).norm(), 1e-9);
}

TEST(RigidContacts, TwoCubesTipToTipTouchWithTwoVertices)
{
    const RigidScene scene = atRest(
        cube(1), onItsCorner({0, 0, 2 * kHalfDiagonal + kGap}), cube(1), onItsCorner({0, 0, 0}));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    ASSERT_EQ(summary(contacts), "vertex-vertex 1");
    EXPECT_EQ(vertexOf(scene.meshB, contacts[0].featureB.vertices[0]), Vector3d(1, 1, 1));
}

TEST(RigidContacts, APlateThinnerThanTheThresholdTouchesWithItsNearSideOnly)
{
    const RigidScene scene =
        atRest(box({-1, -1, 0}, {1, 1, 0.2 * kGap}), poseOf({0.3, 0.2, kGap}), floorAt(0, 5));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    EXPECT_EQ(summary(contacts), "vertex-face 4");
    EXPECT_NEAR(contacts.back().gap, kGap, kRounding);
}

TEST(RigidContacts, AFineGridInsideAFlatFaceAddsNothing)
{
    TriangleMesh grid;
    constexpr int kCells = 12;
    for (int i = 0; i <= kCells; ++i)
    {
        for (int j = 0; j <= kCells; ++j)
        {
            grid.vertices.emplace_back(i - 0.5 * kCells, j - 0.5 * kCells, 0.0);
        }
    }
    for (int i = 0; i < kCells; ++i)
    {
        for (int j = 0; j < kCells; ++j)
        {
            const int k = i * (kCells + 1) + j;
            grid.triangles.push_back({k, k + kCells + 1, k + kCells + 2});
            grid.triangles.push_back({k, k + kCells + 2, k + 1});
        }
    }
    // Turned as a whole, so that it is flat only but for rounding.
    const Isometry3d X = poseOf({3, -2, 1}, 1.1, Vector3d(1, 2, 3).normalized());
    const RigidScene scene = atRest(cube(2), X * poseOf({0.13, 0.27, 2 + kGap}, 0.3), grid, X);
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    EXPECT_EQ(summary(contacts), "vertex-face 4");
}

// Gaps so small that only the features can tell the direction: that of a face is its normal.
TEST(RigidContacts, CornersThatTouchAFaceHaveTheNormalOfTheFace)
{
    for (const double gap : {0.0, 1e-12, 2e-9, 5e-9})
    {
        const RigidScene scene = atRest(cube(1), poseOf({0.3, 0.2, 1 + gap}), floorAt(0, 5));
        const auto contacts = contactsOf(scene);
        ASSERT_EQ(summary(contacts), "vertex-face 4") << gap;
        for (const FeatureContact& c : contacts)
        {
            EXPECT_LT((c.normal + Vector3d::UnitZ()).norm(), 1e-9) << gap;
        }
    }
}

TEST(RigidContacts, TouchingFeaturesHaveTheirOwnNormals)
{
    const RigidScene onFace = atRest(cube(1), onItsCorner({1, -2, kHalfDiagonal}), floorAt(0, 5));
    const RigidScene crossed =
        atRest(cube(1),
               poseOf({0, 0, 2 * std::sqrt(2.0)}, std::numbers::pi / 4, Vector3d::UnitX()),
               cube(1),
               poseOf({0, 0, 0}, std::numbers::pi / 4, Vector3d::UnitY()));
    const RigidScene tips =
        atRest(cube(1), onItsCorner({0, 0, 2 * kHalfDiagonal}), cube(1), onItsCorner({0, 0, 0}));
    const RigidScene stacked = atRest(cube(1), poseOf({0, 0, 2}), cube(1));
    for (const RigidScene& scene : {onFace, crossed, tips})
    {
        const auto contacts = contactsOf(scene);
        expectSound(contacts, scene);
        ASSERT_EQ(contacts.size(), 1U);
        EXPECT_LT(contacts[0].gap, 1e-14);
        EXPECT_LT((contacts[0].normal + Vector3d::UnitZ()).norm(), 1e-9);
    }
    const auto corners = contactsOf(stacked);
    expectSound(corners, stacked);
    EXPECT_EQ(summary(corners), "vertex-vertex 4");
}

TEST(RigidContacts, WhereSurfacesIntersectEdgesPierceFaces)
{
    // The lower half of a cube on its corner is below the plate: three edges pass through it, none
    // of them across the diagonal of the plate.
    const RigidScene scene =
        atRest(cube(1), onItsCorner({2, -2, kHalfDiagonal - 0.1}), floorAt(0, 5));
    const auto contacts = contactsOf(scene);
    expectSound(contacts, scene);
    ASSERT_EQ(summary(contacts), "edge-face 3");
    for (const FeatureContact& c : contacts)
    {
        EXPECT_EQ(c.gap, 0.0);
        EXPECT_NEAR(c.pointA.z(), 0.0, kRounding);
        EXPECT_LT((c.normal + Vector3d::UnitZ()).norm(), 1e-9);
    }
}

TEST(RigidContacts, ASoupIsMergedByPosition)
{
    const RigidScene indexed = atRest(cube(1), poseOf({0.3, 0.2, 1 + kGap}, 0.3), floorAt(0, 5));
    RigidScene soup = indexed;
    for (TriangleMesh* mesh : {&soup.meshA, &soup.meshB})
    {
        TriangleMesh apart;
        for (std::size_t i = 0; i < mesh->triangles.size(); ++i)
        {
            const Corners c = cornersOf(*mesh, i);
            apart.vertices.insert(apart.vertices.end(), c.begin(), c.end());
            const auto first = static_cast<std::int32_t>(3 * i);
            apart.triangles.push_back({first, first + 1, first + 2});
        }
        *mesh = apart;
    }
    const auto expected = contactsOf(indexed);
    const auto contacts = contactsOf(soup);
    ASSERT_EQ(summary(contacts), "vertex-face 4");
    for (const FeatureContact& c : contacts)
    {
        EXPECT_TRUE(std::any_of(expected.begin(),
                                expected.end(),
                                [&](const FeatureContact& e)
                                { return (e.pointA - c.pointA).norm() < kRounding; }));
    }
}

TEST(RigidContacts, DegenerateTrianglesCountAsTheSegmentsAndPointsThatTheyAre)
{
    const TriangleMesh plate = floorAt(0, 5);
    const TriangleMesh point{.vertices = {{1, -2, 0}}, .triangles = {{0, 0, 0}}};
    const TriangleMesh equalPoints = triangle({1, -2, 0}, {1, -2, 0}, {1, -2, 0});
    for (const TriangleMesh& mesh : {point, equalPoints})
    {
        EXPECT_EQ(summary(contactsOf(atRest(mesh, poseOf({0, 0, kGap}), plate))), "vertex-face 1");
        EXPECT_EQ(summary(contactsOf(atRest(mesh, poseOf({0, 0, kGap}), mesh))), "vertex-vertex 1");
    }
    const TriangleMesh rod = segment({-1, -2, 0}, {1, -2, 0});
    EXPECT_EQ(summary(contactsOf(atRest(rod, poseOf({0.1, 0, kGap}), plate))), "vertex-face 2");
    const TriangleMesh across = segment({0, -3, 0}, {0, 1, 0});
    EXPECT_EQ(summary(contactsOf(atRest(rod, poseOf({0.1, 0, kGap}), across))), "edge-edge 1");
    EXPECT_EQ(summary(contactsOf(atRest(rod, poseOf({0.1, 0, 0}), across))), "edge-edge 1");
    const TriangleMesh collinear = triangle({-1, -2, 0}, {1, -2, 0}, {0.3, -2, 0});
    EXPECT_FALSE(contactsOf(atRest(collinear, poseOf({0.1, 0, kGap}), plate)).empty());
    EXPECT_FALSE(contactsOf(atRest(collinear, poseOf({0.1, 0, 0}), collinear)).empty());
}

TEST(RigidContacts, BodiesApartHaveNone)
{
    EXPECT_TRUE(
        contactsOf(atRest(cube(1), poseOf({0, 0, 1 + 2 * kThreshold}), floorAt(0, 5))).empty());
}

TEST(RigidContacts, InputsThatAreNotFiniteAreRefused)
{
    const RigidScene scene = atRest(cube(1), poseOf({0, 0, 1 + kGap}), floorAt(0, 5));
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)contactsOf(scene, -1e-9), std::invalid_argument);
    EXPECT_THROW((void)contactsOf(scene, kNan), std::invalid_argument);
    EXPECT_THROW((void)contactsOf(scene, kThreshold, kNan), std::invalid_argument);
    RigidScene lost = scene;
    lost.motionA.X_W0.translation().x() = kNan;
    EXPECT_THROW((void)contactsOf(lost), std::invalid_argument);
}

/// Falls onto a plate at z = 0; arrives at t = 1.
class Drop : public UserMotion
{
public:
    [[nodiscard]] MotionState at(double t) const override
    {
        return {.X_W = poseOf({0.3, 0.2, 2 - t + kGap}), .v_W = {0, 0, -1}};
    }
    [[nodiscard]] AccelerationBound accelerationBound() const override { return {}; }
};

TEST(RigidContacts, AUserMotionTakesThePlaceOfTheOther)
{
    const SsvTree body = buildSsvTree(cube(1));
    const SsvTree plate = buildSsvTree(floorAt(0, 5));
    const Drop drop;
    const RigidBody falling{.tree = &body, .userMotion = &drop};
    EXPECT_TRUE(contactsAt(falling, {.tree = &plate}, 0.5, kThreshold).empty());
    EXPECT_EQ(summary(contactsAt(falling, {.tree = &plate}, 1.0, kThreshold)), "vertex-face 4");
}

/// Two random soups at rest that overlap in part; no two triangles of one share a vertex.
RigidScene randomSoups(Random& random)
{
    return atRest(soup(random, random.integer(1, 30), 0.6, 0.3),
                  random.pose(0.5),
                  soup(random, random.integer(1, 30), 0.6, 0.3),
                  random.pose(0.5));
}

TEST(RigidContacts, OfSoupsAllPairsOfTrianglesWithinTheThresholdAreNamed)
{
    Random random(71);
    int inContact = 0;
    int empty = 0;
    std::map<std::pair<FeatureKind, FeatureKind>, int> kinds;
    for (int k = 0; k < 300; ++k)
    {
        const RigidScene scene = randomSoups(random);
        const double threshold = random.logUniform(1e-3, 0.1);
        const auto contacts = contactsOf(scene, threshold);
        expectSound(contacts, scene, threshold);
        std::set<std::pair<std::int32_t, std::int32_t>> named;
        for (const FeatureContact& c : contacts)
        {
            named.insert({c.triangleA, c.triangleB});
            ++kinds[{c.featureA.kind, c.featureB.kind}];
        }
        std::set<std::pair<std::int32_t, std::int32_t>> expected;
        const Isometry3d X_BA = scene.motionB.X_W0.inverse() * scene.motionA.X_W0;
        for (std::size_t i = 0; i < scene.meshA.triangles.size(); ++i)
        {
            Corners a = cornersOf(scene.meshA, i);
            for (Vector3d& corner : a)
            {
                corner = X_BA * corner;
            }
            for (std::size_t j = 0; j < scene.meshB.triangles.size(); ++j)
            {
                const OracleDistance d = bruteForceTriangleDistance(a, cornersOf(scene.meshB, j));
                if (d.distance <= threshold)
                {
                    expected.insert({static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)});
                }
            }
        }
        EXPECT_EQ(named, expected) << "scene " << k;
        inContact += static_cast<int>(expected.size());
        empty += expected.empty() ? 1 : 0;
    }
    EXPECT_GT(inContact, 500);
    EXPECT_GT(empty, 10);
    EXPECT_GE(kinds.size(), 7U);  // V-V hardly ever
}

TEST(RigidContacts, NeitherAFrameNorTheOrderOfTheBodiesChangesTheFeatures)
{
    Random random(72);
    int pairs = 0;
    for (int k = 0; k < 200; ++k)
    {
        RigidScene scene = randomSoups(random);
        if (random.chance(0.5))
        {
            // A cube that lies on another.
            scene =
                atRest(cube(0.5), poseOf(0.6 * random.inBox(1.0), random.uniform(0, 6)), cube(0.5));
            scene.motionA.X_W0.translation().z() = 1 + kGap;
        }
        const double threshold = random.logUniform(2 * kGap, 0.02);
        const auto contacts = contactsOf(scene, threshold);
        expectSound(contacts, scene, threshold);
        pairs += static_cast<int>(contacts.size());

        const Isometry3d X = random.pose(3.0);
        const auto elsewhere = contactsOf(moved(scene, X), threshold);
        ASSERT_EQ(featuresOf(elsewhere), featuresOf(contacts)) << "scene " << k;
        auto turned = contactsOf(swapped(scene), threshold);
        for (FeatureContact& c : turned)
        {
            std::swap(c.featureA, c.featureB);
        }
        ASSERT_EQ(featuresOf(turned), featuresOf(contacts)) << "scene " << k;
        for (const FeatureContact& c : contacts)
        {
            const auto same = [&](const FeatureContact& d)
            { return d.featureA == c.featureA && d.featureB == c.featureB; };
            const auto there = std::find_if(elsewhere.begin(), elsewhere.end(), same);
            EXPECT_LT((there->pointA - X * c.pointA).norm(), 1e-9);
            const auto back = std::find_if(turned.begin(), turned.end(), same);
            EXPECT_LT((back->pointB - c.pointA).norm(), 1e-9);
            if (c.gap > 1e-6)
            {
                EXPECT_LT((there->normal - X.linear() * c.normal).norm(), 1e-6);
                EXPECT_LT((back->normal + c.normal).norm(), 1e-6);
            }
        }
    }
    EXPECT_GT(pairs, 400);
}

TEST(RigidContacts, NeitherTheUnitNorThePlaceChangesTheFeatures)
{
    Random random(74);
    int pairs = 0;
    for (int k = 0; k < 100; ++k)
    {
        RigidScene scene = randomSoups(random);
        if (random.chance(0.5))
        {
            const Vector3d place = 0.6 * random.inBox(1.0);
            scene = atRest(cube(0.5), poseOf({place.x(), place.y(), 1 + kGap}, 0.4), cube(0.5));
        }
        const double threshold = random.logUniform(2 * kGap, 0.02);
        const auto expected = featuresOf(contactsOf(scene, threshold));
        pairs += static_cast<int>(expected.size());
        for (const double unit : {1e-3, 1e3})
        {
            const auto contacts = contactsOf(scaled(scene, unit), unit * threshold);
            ASSERT_EQ(featuresOf(contacts), expected) << "scene " << k << " times " << unit;
        }
        // Millimetres at a distance of 100 m.
        const RigidScene far =
            moved(scaled(scene, 1e-2), poseOf({60, -80, 0}, 0.3, random.direction()));
        ASSERT_EQ(featuresOf(contactsOf(far, 1e-2 * threshold)), expected) << "scene " << k;
    }
    EXPECT_GT(pairs, 200);
}

TEST(RigidContacts, AtTheTimeOfAHitTheNamedTrianglesAreAmongTheContacts)
{
    Random random(73);
    int hits = 0;
    int named = 0;
    for (int k = 0; k < 300; ++k)
    {
        const RigidScene scene = randomRigidScene(random);
        const ToiOptions options{.tolerance = random.logUniform(1e-8, 1e-3),
                                 .minimumSeparation = random.chance(0.3) ? 0.05 : 0.0};
        const ToiResult result = queryToi(scene, options);
        if (result.status != ToiStatus::Hit)
        {
            continue;
        }
        ++hits;
        const double threshold = options.minimumSeparation + options.tolerance;
        const auto contacts = contactsOf(scene, threshold, result.time);
        expectSound(contacts, scene, threshold, result.time);
        ASSERT_FALSE(contacts.empty()) << "scene " << k;
        EXPECT_GE(contacts[0].gap, options.minimumSeparation);
        EXPECT_LE(contacts[0].gap, result.gap + kRounding);
        named += std::any_of(contacts.begin(),
                             contacts.end(),
                             [&](const FeatureContact& c) {
                                 return isOfTriangles(c, scene, result.triangleA, result.triangleB);
                             })
                     ? 1
                     : 0;
    }
    EXPECT_GT(hits, 90);
    EXPECT_EQ(named, hits);
}
}  // namespace
}  // namespace bullet_ccd::tests
