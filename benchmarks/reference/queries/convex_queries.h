/// Random queries of convex shapes, one for every seed, judged on meshes by proof or
/// counterexample; shared by the tests, the benchmark and the soak program.
#pragma once

#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/scenes/rigid_scene.h"
#include "bullet_ccd/convex/convex_toi.h"

#include <array>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
enum class ConvexFamily : std::uint8_t
{
    Boxes,          ///< boxes that turn by up to 2.6 rad
    Spinning,       ///< by up to 20 rad
    Thin,           ///< plates and needles, aspect ratios up to 1e3
    Hulls,          ///< 4 to 42 corners
    Rounded,        ///< points, segments, boxes and hulls swept by balls
    Flat,           ///< boxes whose faces and edges are parallel at the start and often stay so
    CoMoving,       ///< common velocity and rotation with a small difference
    OffCentre,      ///< shapes and references off the origin of the body
    Clearance,      ///< queries with a minimum separation
    StartTouching,  ///< the motion begins within the tolerance
    Ground,         ///< above a half-space
    Round,          ///< cylinders and cones, judged by prisms and pyramids in and around them
};
inline constexpr std::size_t kConvexFamilies = 12;

/// In the order of ConvexFamily.
[[nodiscard]] std::vector<std::string> convexFamilyNames();

/// A shape and the meshes between which its core lies; the same mesh twice where it is a
/// polyhedron.
struct MeshedShape
{
    ConvexShape shape = {};
    TriangleMesh inner = {};
    TriangleMesh outer = {};
};

struct ConvexQueryCase
{
    ConvexFamily family = ConvexFamily::Boxes;
    std::array<MeshedShape, 2> shapes = {};
    std::array<RigidMotion, 2> motions = {};
    std::array<Eigen::Isometry3d, 2> X_BG = {Eigen::Isometry3d::Identity(),
                                             Eigen::Isometry3d::Identity()};
    ToiOptions options = {};

    /// Refers to this.
    [[nodiscard]] ConvexBody body(std::size_t side) const
    {
        return {.shape = &shapes[side].shape, .motion = motions[side], .X_BG = X_BG[side]};
    }
};

/// The query of a seed; the family rotates with it.
[[nodiscard]] ConvexQueryCase convexQuery(std::uint64_t seed);

/// Two boxes, one of which flies past or into the other and both of which turn by up to `turn`
/// [rad].
[[nodiscard]] ConvexQueryCase randomBoxes(std::uint64_t seed, double turn);

/// The cores as meshes, in the frames of the bodies.
[[nodiscard]] RigidScene coreScene(const ConvexQueryCase& query, bool outer = false);

/// What is wrong with the answer, if anything.
[[nodiscard]] Judgement judgeConvex(const ConvexQueryCase& query, const ToiResult& result);

void print(std::ostream& out, const ConvexQueryCase& query);
}  // namespace bullet_ccd::reference
