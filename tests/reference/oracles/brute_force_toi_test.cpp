/// The reference itself, against closed forms.
#include "benchmarks/reference/oracles/brute_force_toi.h"

#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

TEST(BruteForceToi, FallingCube)
{
    const TriangleMesh body = cube(1.0);
    const TriangleMesh ground = floorAt(0.0, 10.0);
    RigidMotion motion{.X_W0 = poseOf({0.1, 0.2, 5.0}), .v_W = {0, 0, -8}};
    const OracleToi result = bruteForceToi(oracleBody(body, motion), oracleBody(ground, {}));
    ASSERT_TRUE(result.contact.has_value());
    EXPECT_NEAR(*result.contact, 0.5, 1e-14);
    EXPECT_LE(result.low, 0.5);
    EXPECT_GT(result.low, 0.5 - 1e-8);
}

TEST(BruteForceToi, SpinningRodHitsTheWall)
{
    const TriangleMesh rod = segment({0, 0, 0}, {2, 0, 0});
    const TriangleMesh wall = wallAtY(1.0, 10.0);
    for (const double turns : {0.25, 3.0})
    {
        const RigidMotion motion{.w_W = {0, 0, 2.0 * kPi * turns}};
        const OracleToi result = bruteForceToi(oracleBody(rod, motion), oracleBody(wall, {}));
        ASSERT_TRUE(result.contact.has_value());
        EXPECT_NEAR(*result.contact, std::asin(0.5) / (2.0 * kPi * turns), 1e-14);
        EXPECT_GT(result.low, *result.contact - 1e-7);
    }
}

TEST(BruteForceToi, NearMissIsNoContact)
{
    const TriangleMesh rod = segment({0, 0, 0}, {2, 0, 0});
    const TriangleMesh wall = wallAtY(2.01, 10.0);
    const RigidMotion motion{.w_W = {0, 0, kPi}};
    const OracleToi result = bruteForceToi(oracleBody(rod, motion), oracleBody(wall, {}));
    EXPECT_FALSE(result.contact.has_value());
    EXPECT_EQ(result.low, 1.0);
}

TEST(BruteForceToi, OverlappingAtTheStart)
{
    const TriangleMesh body = cube(1.0);
    const RigidMotion motion{.X_W0 = poseOf({1.5, 0.3, 0.2}), .v_W = {1, 0, 0}};
    const OracleToi result = bruteForceToi(oracleBody(body, motion), oracleBody(body, {}));
    ASSERT_TRUE(result.contact.has_value());
    EXPECT_EQ(*result.contact, 0.0);
}

TEST(BruteForceToi, TwoLinkArmReachesTheWall)
{
    KinematicTree tree;
    tree.links.resize(3);
    tree.links[1].parent = 0;
    tree.links[1].joint.type = JointType::Revolute;
    tree.links[1].joint.axis = Vector3d::UnitZ();
    tree.links[2] = tree.links[1];
    tree.links[2].parent = 1;
    tree.links[2].X_PL0.translation() = Vector3d(1, 0, 0);
    const JointMotion motion{.root = {}, .positions = {0, 1.2, -2.4}, .rates = {0, -1, 2}};
    const TriangleMesh rod = segment({0, 0, 0}, {1, 0, 0});
    const TriangleMesh wall = quad({1.5, -9, -9}, {1.5, 9, -9}, {1.5, 9, 9}, {1.5, -9, 9});
    const OracleToi result = bruteForceToi(oracleLink(rod, tree, motion, 2), oracleBody(wall, {}));
    ASSERT_TRUE(result.contact.has_value());
    EXPECT_NEAR(*result.contact, 1.2 - std::acos(0.75), 1e-14);
}

TEST(BruteForceToi, LinkSpeedBoundsFiniteDifferences)
{
    Random random(3);
    KinematicTree tree;
    tree.links.resize(3);
    for (std::size_t i = 1; i < 3; ++i)
    {
        tree.links[i].parent = static_cast<std::int32_t>(i) - 1;
        tree.links[i].X_PL0 = random.pose(1.0);
        tree.links[i].joint.axis = random.direction();
        tree.links[i].joint.type = i == 1 ? JointType::Prismatic : JointType::Revolute;
    }
    const JointMotion motion{.root = {.v_W = {1, 2, 0}, .w_W = {0, 3, 1}},
                             .positions = {0, 0.4, -1.0},
                             .rates = {0, 2.0, -5.0}};
    const TriangleMesh mesh = soup(random, 4, 1.0, 0.3);
    const OracleBody body = oracleLink(mesh, tree, motion, 2);
    double fastest = 0.0;
    constexpr double kStep = 1e-6;
    for (double t = 0.0; t < 1.0; t += 0.01)
    {
        for (const Vector3d& p : mesh.vertices)
        {
            fastest =
                std::max(fastest, (body.poseAt(t + kStep) * p - body.poseAt(t) * p).norm() / kStep);
        }
    }
    EXPECT_LE(fastest, body.speed);
    EXPECT_GT(fastest, 0.2 * body.speed);
}
}  // namespace
}  // namespace bullet_ccd::tests
