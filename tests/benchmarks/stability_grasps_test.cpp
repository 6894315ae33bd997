// What the stability of grasps rests on: errors of poses, meshes, and the methods.
#include "benchmarks/stability/stability_closings.h"
#include "tests/grasp/planner/test_hands.h"

#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using grasp::Grasp;
using grasp::RejectReason;
using nlohmann::json;

TEST(PoseError, IsAShiftAndATurnOfExactlyThatSize)
{
    const Vector3d center(0.1, -0.2, 0.3);
    for (const double magnitude : {1e-6, 1e-4, 1e-2})
    {
        std::set<int> octants;
        for (std::uint64_t seed = 0; seed < 200; ++seed)
        {
            const Isometry3d error = poseError(seed, magnitude, center);
            const Vector3d shift = error * center - center;
            EXPECT_NEAR(shift.norm(), magnitude, 1e-15);
            // Of a small turn the sine is known better than the cosine.
            const Eigen::Matrix3d skew = 0.5 * (error.linear() - error.linear().transpose());
            const double sine = Vector3d(skew(2, 1), skew(0, 2), skew(1, 0)).norm();
            EXPECT_NEAR(sine, std::sin(magnitude), 1e-15);
            octants.insert((shift.x() > 0 ? 1 : 0) + (shift.y() > 0 ? 2 : 0) +
                           (shift.z() > 0 ? 4 : 0));
            const Vector3d smaller = poseError(seed, 1e-3 * magnitude, center) * center - center;
            EXPECT_LT((shift - 1e3 * smaller).norm(), 1e-12) << "another direction";
        }
        EXPECT_EQ(octants.size(), 8u) << "directions are not all over the sphere";
    }
}

TEST(MeshFamilies, AreOneShapeAtThreeSizes)
{
    for (const char* family : {"egg", "block", "bottle", "ring"})
    {
        const double volume = massProperties(meshOfFamily(family, 2)).volume;
        for (int level = 0; level < 3; ++level)
        {
            const TriangleMesh mesh = meshOfFamily(family, level);
            EXPECT_EQ(mesh.triangles.size(), 1024u << (2 * level)) << family;
            EXPECT_TRUE(isWatertight(mesh)) << family;
            // Inscribed in a smooth surface: less, by what the chords cut off.
            const double ratio = massProperties(mesh).volume / volume;
            EXPECT_GT(ratio, 0.96) << family << ' ' << level;
            EXPECT_LE(ratio, 1.0 + 1e-3) << family << ' ' << level;
        }
    }
    EXPECT_THROW(static_cast<void>(meshOfFamily("cloud", 0)), std::invalid_argument);
}

/// Two jaws with an opening of 80 mm around a bar of 60 mm.
class GraspMethods : public ::testing::Test
{
protected:
    grasp::HandModel m_hand = tests::makeGripper(false);
    grasp::GraspObject m_bar = grasp::makeGraspObject("bar", makeBox({0.03, 0.02, 0.03}));
    std::vector<GraspMethod> m_methods = graspMethods(m_hand, m_bar);
    ClosingStart m_start{.X_WStart = Isometry3d(Eigen::Translation3d(0.0, 0.0, -0.2)),
                         .shift = {0.0, 0.0, 0.16},
                         .open = m_hand.preshapes.front().positions,
                         .X_WH = Isometry3d::Identity()};
};

TEST_F(GraspMethods, AgreeOnAnEasyClosing)
{
    const Grasp first = m_methods.front().run(m_start);
    ASSERT_EQ(first.reject, RejectReason::None);
    for (const GraspMethod& method : m_methods)
    {
        const json change = changeOf(m_hand, first, method.run(m_start));
        EXPECT_TRUE(change["sameLinks"] && change["success"]) << method.name;
        // Contact is within 0.1 mm for all; a sliding joint counts ten times its way.
        EXPECT_LT(change["posture"], 10.0 * 1e-4) << method.name;
        EXPECT_LT(change["epsilon"], 0.02) << method.name;
    }
}

TEST_F(GraspMethods, GiveTheSameWithoutAnErrorAndFollowOne)
{
    for (const GraspMethod& method : m_methods)
    {
        const Grasp reference = method.run(m_start);
        const auto changeBy = [&](double error)
        {
            return changeOf(m_hand,
                            reference,
                            method.run(moved(m_start, poseError(5, error, m_bar.centerOfMass))));
        };
        const json none = changeBy(0.0);
        EXPECT_TRUE(none["closed"] && none["sameLinks"]) << method.name;
        for (const char* what : {"posture", "epsilon", "shift"})
        {
            EXPECT_EQ(none[what], 0.0) << method.name << ' ' << what;
        }
        const json some = changeBy(1e-3);
        ASSERT_TRUE(some["closed"]) << method.name;
        EXPECT_GT(some["posture"], 1e-4) << method.name;
        // A jaw goes by the shift and by the turn over half of the bar at most, and by the gap in
        // which it may stop.
        EXPECT_LT(some["posture"], 10.0 * (1e-3 * (1.0 + 0.05) + 1e-4)) << method.name;
    }
}

TEST_F(GraspMethods, AreNotComparedWhereOneDidNotClose)
{
    const Grasp closed = m_methods.front().run(m_start);
    EXPECT_FALSE(changeOf(m_hand, closed, Grasp{})["closed"]);
    EXPECT_FALSE(changeOf(m_hand, Grasp{}, closed)["closed"]);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
