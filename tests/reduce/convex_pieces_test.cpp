#include "bullet_ccd/reduce/convex_pieces.h"

#include "bullet_ccd/reduce/reduce_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

/// How far the point is outside of the convex piece; negative inside.
double outside(const TriangleMesh& piece, const Vector3d& point)
{
    double most = -std::numeric_limits<double>::infinity();
    for (const Triangle& t : piece.triangles)
    {
        const Vector3d& a = piece.vertices[static_cast<std::size_t>(t[0])];
        const Vector3d across = (piece.vertices[static_cast<std::size_t>(t[1])] - a)
                                    .cross(piece.vertices[static_cast<std::size_t>(t[2])] - a);
        if (across.norm() > 1e-12)
        {
            most = std::max(most, across.normalized().dot(point - a));
        }
    }
    return most;
}

double outsideOfAll(const ConvexPieces& pieces, const Vector3d& point)
{
    double least = std::numeric_limits<double>::infinity();
    for (const TriangleMesh& piece : pieces.pieces)
    {
        least = std::min(least, outside(piece, point));
    }
    return least;
}

void expectConvexAndAround(const ConvexPieces& pieces, const TriangleMesh& mesh)
{
    for (const TriangleMesh& piece : pieces.pieces)
    {
        EXPECT_TRUE(isWatertight(piece));
        EXPECT_GT(massProperties(piece).volume, 0.0);
        for (const Vector3d& vertex : piece.vertices)
        {
            EXPECT_LT(outside(piece, vertex), 1e-9);
        }
    }
    for (const Triangle& t : mesh.triangles)
    {
        Vector3d middle = Vector3d::Zero();
        for (const std::int32_t index : t)
        {
            middle += mesh.vertices[static_cast<std::size_t>(index)] / 3.0;
        }
        EXPECT_LT(outsideOfAll(pieces, middle), 1e-9);
    }
}

TEST(ConvexPieces, WhatIsConvexStaysWhole)
{
    const TriangleMesh ball = makeSphere(0.03, 3);
    const ConvexPieces pieces = convexPieces(ball, {.accuracy = 1e-3});
    ASSERT_EQ(pieces.pieces.size(), 1U);
    EXPECT_LT(pieces.bulge, 1e-9);
    EXPECT_NEAR(massProperties(pieces.pieces[0]).volume, massProperties(ball).volume, 1e-12);
}

TEST(ConvexPieces, ATorusKeepsItsHole)
{
    const TriangleMesh torus = makeTorus(0.04, 0.01, 48, 16);
    const ConvexPieces pieces = convexPieces(torus, {.accuracy = 1e-3});
    EXPECT_LE(pieces.bulge, 1e-3);
    expectConvexAndAround(pieces, torus);
    // Nothing is in the hole, up to the bulge.
    for (int k = 0; k < 36; ++k)
    {
        const double angle = k * std::numbers::pi / 18.0;
        EXPECT_GT(outsideOfAll(pieces, 0.0285 * Vector3d(std::cos(angle), std::sin(angle), 0.0)),
                  0.0);
    }
    // The pieces have no inside in common, so their volumes add up to no more than that of the
    // solid and what bulges.
    double volume = 0.0;
    for (const TriangleMesh& piece : pieces.pieces)
    {
        volume += massProperties(piece).volume;
    }
    const double area = 4.0 * std::numbers::pi * std::numbers::pi * 0.04 * 0.01;
    EXPECT_LT(volume, massProperties(torus).volume + 0.5 * area * pieces.bulge);
    EXPECT_GT(volume, 0.5 * massProperties(torus).volume);
}

TEST(ConvexPieces, FewPiecesBulgeAndSayIt)
{
    const TriangleMesh torus = makeTorus(0.04, 0.01, 48, 16);
    const ConvexPieces one = convexPieces(torus, {.accuracy = 1e-3, .most = 1});
    ASSERT_EQ(one.pieces.size(), 1U);
    // The facets at the inner equator look up or down by 11.25 degrees, and the hull ends 10 mm
    // above and below.
    EXPECT_NEAR(one.bulge, 0.01 / std::sin(std::numbers::pi / 16.0), 1e-3);
    expectConvexAndAround(one, torus);
    const ConvexPieces eight = convexPieces(torus, {.accuracy = 1e-3, .most = 8});
    EXPECT_EQ(eight.pieces.size(), 8U);
    EXPECT_LT(eight.bulge, 0.5 * one.bulge);
    expectConvexAndAround(eight, torus);
}

TEST(ConvexPieces, WhatIsFlatOrOpenGetsAThickness)
{
    const TriangleMesh sheet =
        makeTriangle(Vector3d::Zero(), Vector3d(0.1, 0.0, 0.0), Vector3d(0.0, 0.1, 0.0));
    const ConvexPieces pieces = convexPieces(sheet, {.accuracy = 1e-3});
    ASSERT_EQ(pieces.pieces.size(), 1U);
    EXPECT_NEAR(massProperties(pieces.pieces[0]).volume, 0.005 * 1e-4, 1e-9);
    expectConvexAndAround(pieces, sheet);
    // A tube without ends.
    TriangleMesh tube = makeCylinder(0.03, 0.1, 48);
    std::erase_if(tube.triangles,
                  [&](const Triangle& t)
                  {
                      const auto z = [&](int k)
                      { return tube.vertices[static_cast<std::size_t>(t[k])].z(); };
                      return z(0) == z(1) && z(1) == z(2);
                  });
    expectConvexAndAround(convexPieces(tube, {.accuracy = 1e-3}), tube);
}

TEST(ConvexPieces, SayWhatIsWrong)
{
    const TriangleMesh ball = makeSphere(0.03, 1);
    EXPECT_THROW((void)convexPieces({}, {}), std::invalid_argument);
    EXPECT_THROW((void)convexPieces(ball, {.accuracy = 0.0}), std::invalid_argument);
    EXPECT_THROW((void)convexPieces(ball, {.most = 0}), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd
