#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/contact/contacts.h"
#include "bullet_ccd/math/pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
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

std::vector<Contact> contactsOf(const TriangleMesh& a,
                                const Isometry3d& X_WA,
                                const TriangleMesh& b,
                                const Isometry3d& X_WB)
{
    return findContacts(buildSsvTree(a), X_WA, buildSsvTree(b), X_WB, kThreshold);
}

/// What every contact promises.
void expectSound(const std::vector<Contact>& contacts,
                 const TriangleMesh& a,
                 const Isometry3d& X_WA,
                 const TriangleMesh& b,
                 const Isometry3d& X_WB)
{
    constexpr double kRounding = 1e-12;
    for (const Contact& contact : contacts)
    {
        EXPECT_LE(contact.gap, kThreshold + kRounding);
        EXPECT_NEAR((contact.pointB - contact.pointA).norm(), contact.gap, kRounding);
        EXPECT_NEAR(contact.normal.norm(), 1.0, 1e-9);
        if (contact.gap > 1e-9)
        {
            EXPECT_NEAR(contact.normal.dot(contact.pointB - contact.pointA),
                        contact.gap,
                        1e-3 * contact.gap);
        }
        EXPECT_LE(distanceToMesh(X_WA.inverse() * contact.pointA, a), kRounding);
        EXPECT_LE(distanceToMesh(X_WB.inverse() * contact.pointB, b), kRounding);
    }
}

/// Area of the convex hull of the contact points, in the plane z = const.
double spannedArea(const std::vector<Contact>& contacts)
{
    std::vector<Eigen::Vector2d> points;
    for (const Contact& contact : contacts)
    {
        points.push_back(contact.pointA.head<2>());
    }
    const auto cross =
        [](const Eigen::Vector2d& o, const Eigen::Vector2d& p, const Eigen::Vector2d& q)
    { return (p - o).x() * (q - o).y() - (p - o).y() * (q - o).x(); };
    std::sort(points.begin(),
              points.end(),
              [](const Eigen::Vector2d& p, const Eigen::Vector2d& q)
              { return std::pair(p.x(), p.y()) < std::pair(q.x(), q.y()); });
    double area = 0.0;
    for (const int direction : {1, -1})
    {
        std::vector<Eigen::Vector2d> chain;
        for (const Eigen::Vector2d& p : points)
        {
            while (chain.size() > 1 &&
                   direction * cross(chain[chain.size() - 2], chain.back(), p) <= 0.0)
            {
                chain.pop_back();
            }
            chain.push_back(p);
        }
        for (std::size_t i = 1; i + 1 < chain.size(); ++i)
        {
            area += 0.5 * std::abs(cross(chain[0], chain[i], chain[i + 1]));
        }
    }
    return area;
}

TEST(FindContacts, ABoxOnAPlaneTouchesAtItsFourCorners)
{
    const TriangleMesh body = box({-0.3, -0.2, 0}, {0.3, 0.2, 1});
    const TriangleMesh ground = floorAt(0.0, 5.0);
    const Isometry3d X = poseOf({0.1, 0.05, kGap}, 0.3);
    const auto contacts = contactsOf(body, X, ground, poseOf({0, 0, 0}));
    expectSound(contacts, body, X, ground, poseOf({0, 0, 0}));
    ASSERT_EQ(contacts.size(), 4U);
    for (const double x : {-0.3, 0.3})
    {
        for (const double y : {-0.2, 0.2})
        {
            const Vector3d corner = X * Vector3d(x, y, 0);
            EXPECT_TRUE(std::any_of(contacts.begin(),
                                    contacts.end(),
                                    [&](const Contact& c)
                                    { return (c.pointA - corner).norm() < 1e-9; }));
        }
    }
    for (const Contact& contact : contacts)
    {
        EXPECT_NEAR(contact.gap, kGap, 1e-12);
        EXPECT_LT((contact.normal + Vector3d::UnitZ()).norm(), 1e-9);
    }
}

TEST(FindContacts, AFlatPalmOnACubeFaceSpansTheOverlap)
{
    // I12: the overlap is [0.1, 0.5] x [-0.5, 0.3].
    const TriangleMesh palm = box({0.1, -0.7, 0}, {0.9, 0.3, 0.1});
    const TriangleMesh body = cube(0.5);
    const Isometry3d X = poseOf({0, 0, 0.5 + kGap});
    const auto contacts = contactsOf(palm, X, body, poseOf({0, 0, 0}));
    expectSound(contacts, palm, X, body, poseOf({0, 0, 0}));
    ASSERT_GE(contacts.size(), 3U);
    ASSERT_LE(contacts.size(), 4U);
    EXPECT_GT(spannedArea(contacts), 0.95 * 0.4 * 0.8);
    EXPECT_LT(spannedArea(contacts), 1.001 * 0.4 * 0.8);
    for (const Contact& contact : contacts)
    {
        EXPECT_LT((contact.normal + Vector3d::UnitZ()).norm(), 1e-9);
    }
}

TEST(FindContacts, FinelyMeshedFacesGiveNoMorePoints)
{
    TriangleMesh plate;
    for (int i = 0; i < 10; ++i)
    {
        for (int j = 0; j < 10; ++j)
        {
            const double x = 0.1 * i;
            const double y = 0.1 * j;
            plate = merged(
                {plate, quad({x, y, 0}, {x + 0.1, y, 0}, {x + 0.1, y + 0.1, 0}, {x, y + 0.1, 0})});
        }
    }
    const auto contacts =
        contactsOf(plate, poseOf({0, 0, kGap}), floorAt(0.0, 5.0), poseOf({0, 0, 0}));
    ASSERT_LE(contacts.size(), 4U);
    EXPECT_GT(spannedArea(contacts), 0.95);
}

TEST(FindContacts, AnEdgeTouchesAtItsEndsAndAVertexOnce)
{
    const TriangleMesh ground = floorAt(0.0, 5.0);
    const TriangleMesh body = cube(0.5);
    const Isometry3d onEdge =
        poseOf({0, 0, std::sqrt(0.5) + kGap}, 0.25 * std::numbers::pi, Vector3d::UnitX());
    const auto edge = contactsOf(body, onEdge, ground, poseOf({0, 0, 0}));
    expectSound(edge, body, onEdge, ground, poseOf({0, 0, 0}));
    ASSERT_GE(edge.size(), 2U);
    ASSERT_LE(edge.size(), 4U);
    for (const double x : {-0.5, 0.5})
    {
        EXPECT_TRUE(std::any_of(edge.begin(),
                                edge.end(),
                                [&](const Contact& c)
                                { return std::abs(c.pointA.x() - x) < 1e-9; }));
    }

    Isometry3d onVertex = poseOf({0, 0, 0.5 * std::sqrt(3.0) + kGap});
    onVertex.linear() = rotationBetween(Vector3d(1, 1, 1), Vector3d::UnitZ()).toRotationMatrix();
    const auto vertex = contactsOf(body, onVertex, ground, poseOf({0, 0, 0}));
    expectSound(vertex, body, onVertex, ground, poseOf({0, 0, 0}));
    ASSERT_EQ(vertex.size(), 1U);
    EXPECT_LT((vertex[0].pointA - Vector3d(0, 0, kGap)).norm(), 1e-9);
    EXPECT_LT((vertex[0].normal + Vector3d::UnitZ()).norm(), 1e-6);
}

TEST(FindContacts, NothingBeyondTheThreshold)
{
    const TriangleMesh body = cube(0.5);
    const TriangleMesh ground = floorAt(0.0, 5.0);
    EXPECT_TRUE(contactsOf(body, poseOf({0, 0, 0.5 + 2.1e-4}), ground, poseOf({0, 0, 0})).empty());
    EXPECT_FALSE(contactsOf(body, poseOf({0, 0, 0.5 + 1.9e-4}), ground, poseOf({0, 0, 0})).empty());
    // Tilted: of the face's corners only two are within the threshold.
    const Isometry3d tilted =
        poseOf({0, 0, 0.5 + 0.5 * std::sin(1e-3) + kGap}, 1e-3, Vector3d::UnitY());
    const auto contacts = contactsOf(body, tilted, ground, poseOf({0, 0, 0}));
    expectSound(contacts, body, tilted, ground, poseOf({0, 0, 0}));
    ASSERT_GE(contacts.size(), 2U);
    for (const Contact& contact : contacts)
    {
        EXPECT_GT(contact.pointA.x(), 0.3);
    }
}

TEST(FindContacts, TwoFacesOfACornerArePatchesOfTheirOwn)
{
    // A cube in the corner of a floor and a wall: normals down and sideways.
    const TriangleMesh corner = merged({floorAt(0.0, 2.0), wallAtY(0.0, 2.0)});
    const Isometry3d X = poseOf({0, 0.5 + kGap, 0.5 + kGap});
    const auto contacts = contactsOf(cube(0.5), X, corner, poseOf({0, 0, 0}));
    expectSound(contacts, cube(0.5), X, corner, poseOf({0, 0, 0}));
    const auto along = [&](const Vector3d& normal)
    {
        return std::count_if(contacts.begin(),
                             contacts.end(),
                             [&](const Contact& contact)
                             { return contact.normal.dot(normal) > 0.99; });
    };
    // The two corners in the groove count for one of the two faces only.
    EXPECT_GE(along(-Vector3d::UnitZ()), 3);
    EXPECT_GE(along(-Vector3d::UnitY()), 3);
    EXPECT_LE(contacts.size(), 8U);
}

TEST(FindContacts, IntersectingTrianglesAreReportedWithGapZero)
{
    const auto contacts =
        contactsOf(cube(0.5), poseOf({0, 0, 0.4}), floorAt(0.0, 5.0), poseOf({0, 0, 0}));
    ASSERT_FALSE(contacts.empty());
    for (const Contact& contact : contacts)
    {
        EXPECT_EQ(contact.gap, 0.0);
        EXPECT_NEAR(std::abs(contact.normal.z()), 1.0, 1e-9);
    }
}

TEST(FindContacts, AStoppedQuerySaysSo)
{
    const SsvTree tree = buildSsvTree(cube(0.5));
    const Isometry3d X = Isometry3d::Identity();
    EXPECT_FALSE(findContacts(tree, X, tree, X, kThreshold, stopAfter(60.0)).empty());
    EXPECT_THROW((void)findContacts(tree, X, tree, X, kThreshold, stopAfter(-1.0)), QueryStopped);
    const std::atomic<bool> isCancelled = true;
    const RigidBody body{.tree = &tree, .motion = restAt(X)};
    EXPECT_THROW((void)contactsAt(body, body, 0.0, kThreshold, {.isCancelled = &isCancelled}),
                 QueryStopped);
}

TEST(FindContacts, RandomMeshesGiveSoundContactsEveryTimeTheSame)
{
    Random random(95);
    int withContacts = 0;
    for (int i = 0; i < 200; ++i)
    {
        const TriangleMesh a = randomMesh(random);
        const TriangleMesh b = randomMesh(random);
        Isometry3d X = random.pose(0.0);
        X.translation() = 3.0 * random.direction();
        const Isometry3d X_WB = random.pose(1.0);
        // Along the line between their closest points down to a gap of 1e-4.
        const OracleDistance apart = bruteForceMeshDistance(a, b, X);
        X.translation() += (apart.pointB - apart.pointA) * (1.0 - kGap / apart.distance);
        const Isometry3d X_WA = X_WB * X;
        const bool near = bruteForceMeshDistance(a, b, X).distance <= kThreshold;
        const auto contacts = contactsOf(a, X_WA, b, X_WB);
        EXPECT_EQ(near, !contacts.empty()) << i;
        expectSound(contacts, a, X_WA, b, X_WB);
        const auto again = contactsOf(a, X_WA, b, X_WB);
        ASSERT_EQ(again.size(), contacts.size());
        for (std::size_t k = 0; k < contacts.size(); ++k)
        {
            EXPECT_EQ(again[k].pointA, contacts[k].pointA);
            EXPECT_EQ(again[k].triangleB, contacts[k].triangleB);
        }
        withContacts += contacts.empty() ? 0 : 1;
    }
    EXPECT_GT(withContacts, 100);
}
}  // namespace
}  // namespace bullet_ccd::tests
