#include "grasp/approach/approach_sampler.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/approach/object_shape.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
using tests::makeGripper;
using tests::makeThreeFingers;

GraspObject makeObject(TriangleMesh mesh, const Eigen::Vector3d& at = Eigen::Vector3d::Zero())
{
    transformMesh(mesh, Eigen::Affine3d(Eigen::Translation3d(at)));
    return makeGraspObject("object", std::move(mesh));
}

Eigen::Isometry3d graspFrame(const HandModel& hand, const ApproachCandidate& candidate)
{
    return candidate.X_WStart * hand.X_RG;
}

TEST(ApproachSampler, HandStartsOutsideTheBallOfTheObject)
{
    const HandModel hand = makeThreeFingers();
    const std::vector<GraspObject> objects = []
    {
        std::vector<GraspObject> made;
        made.push_back(makeObject(makeSphere(0.04, 2), {0.3, -0.2, 0.1}));
        made.push_back(makeObject(makeBox({0.02, 0.03, 0.15})));
        made.push_back(makeObject(makeCylinder(0.005, 0.2, 12), {-1.0, 0.0, 0.0}));
        return made;
    }();
    for (const GraspObject& object : objects)
    {
        for (std::int64_t number = 0; number < 60; ++number)
        {
            const ApproachCandidate candidate = sampleApproach(hand, object, 7, number, 60);
            const auto X_WL = linkPoses(
                hand.robot.tree, candidate.X_WStart, hand.preshapes[candidate.preshape].positions);
            for (std::size_t link = 0; link < X_WL.size(); ++link)
            {
                for (const Eigen::Vector3d& vertex : hand.linkTrees[link]->mesh().vertices)
                {
                    ASSERT_GT((X_WL[link] * vertex - object.centerOfMass).norm(), object.radius)
                        << "candidate " << number;
                }
            }
        }
    }
}

TEST(ApproachSampler, ApproachesAlongTheGraspFrameTowardsTheObject)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = makeObject(makeBox({0.01, 0.02, 0.1}), {0.5, 0.5, 0.5});
    for (std::int64_t number = 0; number < 50; ++number)
    {
        const ApproachCandidate candidate = sampleApproach(hand, object, 3, number, 50);
        const Eigen::Isometry3d X_WG = graspFrame(hand, candidate);
        EXPECT_NEAR(candidate.direction_W.norm(), 1.0, 1e-12);
        EXPECT_NEAR((X_WG.linear().col(2) - candidate.direction_W).norm(), 0.0, 1e-12);
        EXPECT_NEAR(X_WG.linear().determinant(), 1.0, 1e-12);
        const Eigen::Vector3d target =
            X_WG.translation() + candidate.centerDistance * candidate.direction_W;
        EXPECT_LT((target - object.centerOfMass).norm(), object.radius);
        EXPECT_GT(candidate.distance, candidate.centerDistance);
    }
}

TEST(ApproachSampler, IsAPureFunctionOfItsArguments)
{
    const HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeBox({0.01, 0.02, 0.03}));
    int different = 0;
    for (std::int64_t number = 0; number < 20; ++number)
    {
        const ApproachCandidate first = sampleApproach(hand, object, 5, number, 20);
        static_cast<void>(sampleApproach(hand, object, 5, 19 - number, 20));
        const ApproachCandidate again = sampleApproach(hand, object, 5, number, 20);
        EXPECT_EQ(first.X_WStart.matrix(), again.X_WStart.matrix());
        EXPECT_EQ(first.distance, again.distance);
        const ApproachCandidate otherSeed = sampleApproach(hand, object, 6, number, 20);
        different += first.X_WStart.matrix() != otherSeed.X_WStart.matrix() ? 1 : 0;
    }
    EXPECT_EQ(different, 20);
}

TEST(ApproachSampler, DirectionsCoverTheSphereAroundARoundObject)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = makeObject(makeSphere(0.03, 3));
    constexpr std::int64_t kCount = 100;
    std::vector<Eigen::Vector3d> directions;
    for (std::int64_t number = 0; number < kCount; ++number)
    {
        directions.push_back(sampleApproach(hand, object, 1, number, kCount).direction_W);
    }
    // A candidate owns a cap of radius 2 / sqrt(count); one may be turned by up to that much, so
    // the nearest one to any direction is at most a few caps away.
    const double cap = 2.0 / std::sqrt(static_cast<double>(kCount));
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    for (int trial = 0; trial < 500; ++trial)
    {
        const Eigen::Vector3d anywhere =
            Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
        double nearest = 10.0;
        for (const Eigen::Vector3d& direction : directions)
        {
            nearest = std::min(nearest, std::acos(std::clamp(anywhere.dot(direction), -1.0, 1.0)));
        }
        EXPECT_LT(nearest, 2.5 * cap);
    }
}

TEST(ApproachSampler, FingersOpposeAlongTheThinDirectionOfAPlate)
{
    const HandModel hand = makeGripper(true);
    // 20 mm thin; both other extents are wider than the gripper opens.
    const GraspObject object = makeObject(makeBox({0.01, 0.06, 0.08}));
    int aligned = 0;
    constexpr int kCount = 60;
    for (std::int64_t number = 0; number < kCount; ++number)
    {
        const ApproachCandidate candidate = sampleApproach(hand, object, 2, number, kCount);
        aligned += std::abs(graspFrame(hand, candidate).linear()(0, 0)) > 0.95 ? 1 : 0;
    }
    EXPECT_GT(aligned, kCount / 2);
}

TEST(ApproachSampler, FingersFaceTheSideOfACylinderSquarely)
{
    const HandModel hand = makeGripper(true);
    TriangleMesh mesh = makeCylinder(0.025, 0.14, 64);
    const Eigen::Affine3d turned(Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.0, 0.6, 0.8)));
    transformMesh(mesh, turned);
    const GraspObject object = makeObject(std::move(mesh));
    const Eigen::Vector3d axis = turned.linear().col(2);
    int square = 0;
    constexpr int kCount = 40;
    for (std::int64_t number = 0; number < kCount; ++number)
    {
        const ApproachCandidate candidate = sampleApproach(hand, object, 2, number, kCount);
        square += std::abs(graspFrame(hand, candidate).linear().col(0).dot(axis)) < 0.02 ? 1 : 0;
    }
    EXPECT_GT(square, kCount / 2);
}

TEST(ApproachSampler, PreshapesTakeTurns)
{
    HandModel hand = makeThreeFingers();
    hand.preshapes.push_back({"other", std::vector<double>(7, 0.1)});
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    for (std::int64_t number = 0; number < 6; ++number)
    {
        EXPECT_EQ(sampleApproach(hand, object, 1, number, 6).preshape,
                  static_cast<std::size_t>(number % 2));
    }
}

/// Jaws 90 mm apart, and 30 mm apart in a second preshape.
HandModel handWithNarrowPreshape()
{
    HandModel hand = makeGripper(true);
    hand.preshapes.push_back({"narrow", {0.0, 0.03, 0.03}});
    return hand;
}

TEST(ApproachSampler, SkipsPreshapesThatTheObjectDoesNotFitInto)
{
    const HandModel hand = handWithNarrowPreshape();
    int narrow = 0;
    const GraspObject wide = makeObject(makeBox({0.025, 0.03, 0.05}));
    const GraspObject thin = makeObject(makeBox({0.004, 0.03, 0.05}));
    for (std::int64_t number = 0; number < 6; ++number)
    {
        EXPECT_EQ(sampleApproach(hand, wide, 1, number, 6).preshape, 0U);
        narrow += sampleApproach(hand, thin, 1, number, 6).preshape == 1U ? 1 : 0;
    }
    EXPECT_EQ(narrow, 3);
}

TEST(ApproachSampler, AllPreshapesTakeTurnsIfTheObjectFitsIntoNone)
{
    const HandModel hand = handWithNarrowPreshape();
    const GraspObject huge = makeObject(makeSphere(0.5, 2));
    for (std::int64_t number = 0; number < 6; ++number)
    {
        EXPECT_EQ(sampleApproach(hand, huge, 1, number, 6).preshape,
                  static_cast<std::size_t>(number % 2));
    }
}

TEST(ApproachSampler, RefusesWhatMakesNoSense)
{
    HandModel hand = makeThreeFingers();
    const GraspObject object = makeObject(makeSphere(0.03, 2));
    EXPECT_THROW(static_cast<void>(sampleApproach(hand, object, 1, 0, 0)), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(sampleApproach(hand, object, 1, -1, 5)), std::invalid_argument);
    hand.preshapes.clear();
    EXPECT_THROW(static_cast<void>(sampleApproach(hand, object, 1, 0, 5)), std::invalid_argument);
}

TEST(ObjectShape, AxesOfABoxAreItsEdgesLongestFirst)
{
    const GraspObject object = makeObject(makeBox({0.02, 0.05, 0.01}), {0.1, 0.2, 0.3});
    const ObjectShape shape = objectShape(object);
    EXPECT_NEAR((shape.extents() - Eigen::Vector3d(0.1, 0.04, 0.02)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((shape.axes.col(0) - Eigen::Vector3d::UnitY()).norm(), 0.0, 1e-9);
    EXPECT_NEAR((shape.axes.col(1) - Eigen::Vector3d::UnitX()).norm(), 0.0, 1e-9);
    EXPECT_NEAR((shape.axes.col(2) - Eigen::Vector3d::UnitZ()).norm(), 0.0, 1e-9);
}

TEST(LocalWidth, MeasuresABoxAcrossItsFaces)
{
    const GraspObject object = makeObject(makeBox({0.02, 0.05, 0.03}));
    Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
    X_WG.translation() = Eigen::Vector3d(0.001, 0.0, 0.0);
    const LocalWidth local = localWidth(object, X_WG, 0.004);
    EXPECT_EQ(local.hits, LocalWidth::kRays);
    EXPECT_NEAR(local.width(), 0.04, 1e-12);
    EXPECT_NEAR(local.lower, -0.021, 1e-12);
    EXPECT_NEAR(local.squareness, 1.0, 1e-12);
}

TEST(LocalWidth, IsWiderAndLessSquareAcrossATurnedBox)
{
    const GraspObject object = makeObject(makeBox({0.02, 0.05, 0.03}));
    Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
    X_WG.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const LocalWidth local = localWidth(object, X_WG, 0.0);
    EXPECT_NEAR(local.width(), 0.04 / std::cos(0.3), 1e-12);
    EXPECT_NEAR(local.squareness, std::cos(0.3), 1e-12);
}

TEST(LocalWidth, KnowsHowTheFacesOfATurnedBoxOpposeEachOther)
{
    const GraspObject object = makeObject(makeBox({0.02, 0.05, 0.03}), {0.7, -0.2, 0.4});
    Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
    X_WG.translation() = Eigen::Vector3d(0.7, -0.2, 0.4);
    X_WG.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.0, 0.6, 0.8)).toRotationMatrix();
    const LocalWidth local = localWidth(object, X_WG, 0.001);
    EXPECT_EQ(local.hits, LocalWidth::kRays);
    EXPECT_NEAR((X_WG.linear() * local.opposition - Eigen::Vector3d::UnitX()).norm(), 0.0, 1e-12);
}

TEST(LocalWidth, IsEmptyBesideTheObject)
{
    const GraspObject object = makeObject(makeSphere(0.02, 2));
    Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
    X_WG.translation() = Eigen::Vector3d(0.0, 0.1, 0.0);
    EXPECT_EQ(localWidth(object, X_WG, 0.01).hits, 0);
}

/// Every triangle that a line crosses, by the signs of the volumes that its edges span with the
/// line, is among those that the hierarchy finds.
TEST(TrianglesNearLine, HasAllThatALineMeetsAndFewOthers)
{
    const GraspObject torus = makeObject(makeTorus(0.05, 0.015, 48, 24));
    const TriangleMesh& mesh = torus.tree.mesh();
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::size_t met = 0;
    std::size_t listed = 0;
    for (int line = 0; line < 200; ++line)
    {
        const auto draw = [&] { return Eigen::Vector3d(unit(random), unit(random), unit(random)); };
        const Eigen::Vector3d point = 0.06 * draw();
        const Eigen::Vector3d along = draw().normalized();
        const std::vector<std::int32_t> near = trianglesNearLine(torus.tree, point, along);
        EXPECT_TRUE(std::ranges::is_sorted(near));
        listed += near.size();
        for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
        {
            std::array<double, 3> volumes{};
            for (std::size_t i = 0; i < 3; ++i)
            {
                const auto corner = [&](std::size_t at) -> Eigen::Vector3d
                { return mesh.vertices[static_cast<std::size_t>(mesh.triangles[k][at])] - point; };
                volumes[i] = along.dot(corner(i).cross(corner((i + 1) % 3)));
            }
            const auto [low, high] = std::ranges::minmax(volumes);
            if (low > 0.0 || high < 0.0)
            {
                ++met;
                EXPECT_TRUE(std::ranges::binary_search(near, static_cast<std::int32_t>(k)))
                    << "line " << line << ", triangle " << k;
            }
        }
    }
    EXPECT_GT(met, 150U);
    EXPECT_LT(listed, 200U * mesh.triangles.size() / 10U);
}
}  // namespace
}  // namespace bullet_ccd::grasp
