// The volumes that the rigid benchmark compares: they contain their triangles, are what their names
// say, and change no answer.
#include "benchmarks/rigid/volume_kinds.h"

#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/tree_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Vector3d;
using namespace bullet_ccd::tests;

constexpr VolumeKind kKinds[] = {VolumeKind::Box,
                                 VolumeKind::RoundedBox,
                                 VolumeKind::SweptRectangle,
                                 VolumeKind::SweptLine,
                                 VolumeKind::SweptPoint,
                                 VolumeKind::Cheapest};

SsvNode rootOf(VolumeKind kind, const TriangleMesh& mesh)
{
    return buildTreeOf(kind, mesh).nodes()[0];
}

/// Half-extents of the core that are not zero.
std::ptrdiff_t dimensions(const SsvNode& node)
{
    return 3 - std::ranges::count(node.half, 0.0F);
}

TEST(VolumeKinds, ContainTheirTriangles)
{
    Random random(1);
    for (int i = 0; i < 15; ++i)
    {
        const double scale = random.logUniform(1e-6, 1e6);
        const double offset = random.chance(0.5) ? 0.0 : random.logUniform(1.0, 1e4);
        TriangleMesh mesh = soup(random, random.integer(1, 100), 1.0, random.logUniform(1e-4, 1.0));
        mesh = scaled(shifted(mesh, offset * random.direction()), scale);
        for (const VolumeKind kind : kKinds)
        {
            const SsvTree tree = buildTreeOf(kind, mesh);
            expectSoundTree(tree, "kind " + std::to_string(static_cast<int>(kind)));
            if (mesh.triangles.size() > 1)
            {
                EXPECT_GT(checkTree(tree, 0.99).worstEscape, 1e-4);
            }
        }
    }
}

TEST(VolumeKinds, AreWhatTheirNamesSay)
{
    const TriangleMesh mesh = placed(box({-3, -2, -1}, {3, 2, 1}), poseOf({7, 8, 9}, 1.0));
    const double corner = Vector3d(3, 2, 1).norm();
    // A box in a box: its own half-extents, whatever way it lies.
    const SsvNode exact = rootOf(VolumeKind::Box, mesh);
    EXPECT_EQ(exact.radius, 0.0F);
    EXPECT_NEAR(exact.half[0], 3.0, 0.1);
    EXPECT_NEAR(exact.half[1], 2.0, 0.1);
    EXPECT_NEAR(exact.half[2], 1.0, 0.1);
    // The ball of a box is about its corners; all others are between the two.
    const SsvNode ball = rootOf(VolumeKind::SweptPoint, mesh);
    EXPECT_EQ(dimensions(ball), 0);
    EXPECT_NEAR(static_cast<double>(ball.radius), corner, 0.1);
    const SsvNode line = rootOf(VolumeKind::SweptLine, mesh);
    EXPECT_LE(dimensions(line), 1);
    EXPECT_NEAR(static_cast<double>(line.radius), std::sqrt(5.0), 0.2);
    const SsvNode rectangle = rootOf(VolumeKind::SweptRectangle, mesh);
    EXPECT_LE(dimensions(rectangle), 2);
    EXPECT_NEAR(static_cast<double>(rectangle.radius), 1.0, 0.1);
    for (const VolumeKind kind : kKinds)
    {
        EXPECT_LT(static_cast<double>(rootOf(kind, mesh).size()), 1.7 * corner);
    }
    const SsvTree ours = buildSsvTree(mesh);
    const SsvTree rounded = buildTreeOf(VolumeKind::RoundedBox, mesh);
    ASSERT_EQ(ours.nodes().size(), rounded.nodes().size());
    EXPECT_EQ(std::memcmp(ours.nodes().data(), rounded.nodes().data(), ours.nodes().size_bytes()),
              0);
}

TEST(VolumeKinds, CheapestTakesTheSimplestCoreThatIsTight)
{
    const auto coreDimensions = [](const TriangleMesh& mesh)
    {
        const SsvNode node = rootOf(VolumeKind::Cheapest, mesh);
        return 3 - std::ranges::count_if(node.half,
                                         [&](float half) { return half <= 0.02F * node.size(); });
    };
    EXPECT_EQ(coreDimensions(makeSphere(1.0, 3)), 0);
    EXPECT_EQ(coreDimensions(makeCapsule(0.5, 4.0, 32)), 1);
    EXPECT_EQ(coreDimensions(box({-5, -4, -0.1}, {5, 4, 0.1})), 2);
    EXPECT_EQ(coreDimensions(box({-5, -4, -3}, {5, 4, 3})), 3);
}

TEST(VolumeKinds, GiveTheSameAnswers)
{
    Random random(2);
    const TriangleMesh mesh = makeTorus(1.0, 0.3, 32, 16);
    const SsvTree boxes = buildTreeOf(VolumeKind::Box, mesh);
    for (const VolumeKind kind : kKinds)
    {
        expectSameAnswers(boxes, buildTreeOf(kind, mesh), random, 20);
    }
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
