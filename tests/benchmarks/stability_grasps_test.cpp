// What the stability of grasps rests on: errors of poses, statistics, meshes, and the methods.
#include "benchmarks/stability/stability_closings.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/grasp/planner/test_hands.h"

#include <cmath>
#include <gmock/gmock.h>
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
        }
        EXPECT_EQ(octants.size(), 8u) << "directions are not all over the sphere";
    }
}

TEST(PoseError, HasTheSameDirectionsForEverySize)
{
    const Vector3d small = poseError(7, 1e-6, Vector3d::Zero()).translation();
    const Vector3d large = poseError(7, 1e-3, Vector3d::Zero()).translation();
    EXPECT_LT((large - 1e3 * small).norm(), 1e-15);
    const Vector3d other = poseError(8, 1e-3, Vector3d::Zero()).translation();
    EXPECT_GT((large - other).norm(), 1e-5);
}

TEST(PoseError, OfSizeZeroIsNone)
{
    EXPECT_TRUE(poseError(3, 0.0, Vector3d::Zero()).isApprox(Isometry3d::Identity(), 0.0));
}

TEST(Quantile, IsTheValueThatThatShareIsNotAbove)
{
    EXPECT_EQ(quantileOf({}, 0.5), 0.0);
    EXPECT_EQ(quantileOf({3.0}, 0.95), 3.0);
    EXPECT_EQ(quantileOf({3.0, 1.0, 2.0}, 0.5), 2.0);
    EXPECT_EQ(quantileOf({4.0, 3.0, 2.0, 1.0}, 0.0), 1.0);
    EXPECT_EQ(quantileOf({4.0, 3.0, 2.0, 1.0}, 1.0), 4.0);
}

TEST(MeshFamilies, AreOneShapeAtThreeSizes)
{
    for (const std::string& family : meshFamilies())
    {
        const double volume = massProperties(meshOfFamily(family, kMeshLevels - 1)).volume;
        for (int level = 0; level < kMeshLevels; ++level)
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
class ClosingMethods : public ::testing::Test
{
protected:
    grasp::HandModel m_hand = tests::makeGripper(false);
    grasp::GraspObject m_bar = grasp::makeGraspObject("bar", makeBox({0.03, 0.02, 0.03}));
    ClosingBench m_bench{m_hand, m_bar};
    GraspStart m_start{.X_WStart = Isometry3d(Eigen::Translation3d(0.0, 0.0, -0.2)),
                       .way = {0.0, 0.0, 0.16},
                       .open = m_hand.preshapes.front().positions};
};

TEST_F(ClosingMethods, AgreeOnAnEasyClosing)
{
    const std::vector<ClosingMethod> methods = closingMethods();
    const Grasp first = m_bench.close(methods.front(), m_start);
    ASSERT_EQ(first.reject, RejectReason::None);
    for (const ClosingMethod& method : methods)
    {
        const Grasp other = m_bench.close(method, m_start);
        EXPECT_EQ(other.reject, RejectReason::None) << method.name;
        const ClosingChange change = changeOf(m_hand, first, other);
        EXPECT_TRUE(change.sameLinks && change.success) << method.name;
        // Contact is within 0.1 mm for all; a sliding joint counts ten times its way.
        EXPECT_LT(change.posture, 10.0 * 1e-4) << method.name;
        EXPECT_LT(change.epsilon, 0.02) << method.name;
    }
}

TEST_F(ClosingMethods, GiveTheSameWithoutAnErrorAndFollowOne)
{
    for (const ClosingMethod& method : closingMethods())
    {
        const Grasp reference = m_bench.close(method, m_start);
        const Grasp again =
            m_bench.close(method, moved(m_start, poseError(5, 0.0, m_bar.centerOfMass)));
        EXPECT_EQ(reference.positions, again.positions) << method.name;
        const ClosingChange none = changeOf(m_hand, reference, again);
        EXPECT_EQ(none.posture, 0.0);
        EXPECT_EQ(none.epsilon, 0.0);
        EXPECT_EQ(none.contactShift, 0.0);

        const Grasp off =
            m_bench.close(method, moved(m_start, poseError(5, 1e-3, m_bar.centerOfMass)));
        const ClosingChange some = changeOf(m_hand, reference, off);
        ASSERT_TRUE(some.closed) << method.name;
        EXPECT_GT(some.posture, 1e-4) << method.name;
        // A jaw goes by the shift and by the turn over half of the bar at most, and by the gap in
        // which it may stop.
        EXPECT_LT(some.posture, 10.0 * (1e-3 * (1.0 + 0.05) + 1e-4)) << method.name;
    }
}

TEST_F(ClosingMethods, AreNotComparedWhereOneDidNotClose)
{
    const Grasp closed = m_bench.close(closingMethods().front(), m_start);
    EXPECT_FALSE(changeOf(m_hand, closed, Grasp{}).closed);
    EXPECT_FALSE(changeOf(m_hand, Grasp{}, closed).closed);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
