/// Faces on which objects stand, against closed forms.
#include "grasp/quality/stable_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kPi = std::numbers::pi;

/// The one that stands on the face, or null.
const StablePose* on(const std::vector<StablePose>& poses, const Eigen::Vector3d& down)
{
    const auto found = std::ranges::find_if(
        poses, [&](const StablePose& pose) { return pose.down.dot(down.normalized()) > 1 - 1e-9; });
    return found == poses.end() ? nullptr : &*found;
}

/// A prism of `sides` corners about z.
TriangleMesh prism(int sides, double radius, double halfHeight)
{
    TriangleMesh mesh;
    for (const double z : {-halfHeight, halfHeight})
    {
        for (int i = 0; i < sides; ++i)
        {
            const double angle = 2.0 * kPi * i / sides;
            mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
        }
    }
    for (int i = 0; i < sides; ++i)
    {
        const int next = (i + 1) % sides;
        mesh.triangles.push_back({i, next, sides + i});
        mesh.triangles.push_back({next, sides + next, sides + i});
        if (i > 0 && next > 0)
        {
            mesh.triangles.push_back({0, next, i});
            mesh.triangles.push_back({sides, sides + i, sides + next});
        }
    }
    return mesh;
}

TEST(StablePoses, ABoxStandsOnSixFaces)
{
    const Eigen::Vector3d half(0.02, 0.03, 0.05);
    const GraspObject box = makeGraspObject("box", makeBox(half));
    const std::vector<StablePose> poses = stablePoses(box);
    ASSERT_EQ(poses.size(), 6U);
    for (int axis = 0; axis < 3; ++axis)
    {
        const double least = std::min(half[(axis + 1) % 3], half[(axis + 2) % 3]);
        for (const double sign : {-1.0, 1.0})
        {
            const StablePose* const pose = on(poses, sign * Eigen::Vector3d::Unit(axis));
            ASSERT_NE(pose, nullptr) << axis;
            EXPECT_NEAR(pose->tilt, std::atan2(least, half[axis]), 1e-9) << axis;
        }
    }
    EXPECT_TRUE(std::ranges::is_sorted(poses, std::greater{}, &StablePose::tilt));
    // The flattest box on its narrow sides: atan(1/20) is 2.9 degrees.
    const GraspObject plate = makeGraspObject("plate", makeBox({0.1, 0.1, 0.005}));
    EXPECT_EQ(stablePoses(plate).size(), 2U);
    EXPECT_EQ(stablePoses(plate, 0.04).size(), 6U);
}

TEST(StablePoses, WhereTheCentreOfMassIsDecides)
{
    GraspObject box = makeGraspObject("box", makeBox({0.02, 0.03, 0.05}));
    box.centerOfMass = {0.0, 0.0, -0.04};
    const std::vector<StablePose> poses = stablePoses(box);
    ASSERT_NE(on(poses, -Eigen::Vector3d::UnitZ()), nullptr);
    EXPECT_NEAR(on(poses, -Eigen::Vector3d::UnitZ())->tilt, std::atan2(0.02, 0.01), 1e-9);
    EXPECT_NEAR(on(poses, Eigen::Vector3d::UnitX())->tilt, std::atan2(0.01, 0.02), 1e-9);
    box.centerOfMass = {0.021, 0.0, 0.0};  // beside the box
    EXPECT_EQ(on(stablePoses(box), Eigen::Vector3d::UnitZ()), nullptr);
}

TEST(StablePoses, ACylinderStandsOnItsEndsAndRollsOnItsSides)
{
    const GraspObject cylinder = makeGraspObject("cylinder", prism(64, 0.03, 0.05));
    const std::vector<StablePose> poses = stablePoses(cylinder);
    ASSERT_EQ(poses.size(), 2U);
    for (const double sign : {-1.0, 1.0})
    {
        const StablePose* const pose = on(poses, sign * Eigen::Vector3d::UnitZ());
        ASSERT_NE(pose, nullptr);
        EXPECT_NEAR(pose->tilt, std::atan2(0.03 * std::cos(kPi / 64.0), 0.05), 1e-9);
    }
    // A hexagon does not roll: it stands on each side up to 30 degrees.
    const std::vector<StablePose> nut = stablePoses(makeGraspObject("nut", prism(6, 0.03, 0.05)));
    EXPECT_EQ(nut.size(), 8U);
    const double middle = kPi / 6.0;
    const StablePose* const side = on(nut, {std::cos(middle), std::sin(middle), 0.0});
    ASSERT_NE(side, nullptr);
    EXPECT_NEAR(side->tilt, kPi / 6.0, 1e-9);
}

TEST(StablePoses, ATetrahedronStandsOnFourFaces)
{
    TriangleMesh mesh;
    mesh.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (Eigen::Vector3d& vertex : mesh.vertices)
    {
        vertex *= 0.03;
    }
    mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    const std::vector<StablePose> poses = stablePoses(makeGraspObject("tetrahedron", mesh));
    ASSERT_EQ(poses.size(), 4U);
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        const StablePose* const pose = on(poses, -vertex);
        ASSERT_NE(pose, nullptr);
        // The inner circle of a face, sqrt(2) to the height of the middle above it.
        EXPECT_NEAR(pose->tilt, std::atan(std::sqrt(2.0)), 1e-9);
    }
}

TEST(StablePoses, WhatIsFlatStandsNowhere)
{
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0.1, 0.1, 0}};
    mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
    EXPECT_TRUE(stablePoses(makeGraspObject("sheet", mesh)).empty());
}
}  // namespace
}  // namespace bullet_ccd::grasp
