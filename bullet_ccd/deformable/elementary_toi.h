/// First contact of two features that deform: a vertex and a face, or two edges, whose vertices
/// move on straight lines. What cloth and soft bodies are made of.
///
/// The two features are subtracted from each other. The pair touches if and only if the origin lies
/// in a moving convex polygon: a triangle for a vertex and a face, a parallelogram for two edges.
/// Time is certified interval by interval, by a direction along which all corners of the polygon
/// stay on one side of the origin; the direction turns linearly with time, so that an interval is
/// decided by quadratics in closed form. Directions come from the nearest point of the polygon, but
/// need not be trusted: a bad one certifies less, never something wrong. README.md has the proofs.
///
/// A vertex and an edge, or two vertices, are the same with corners that coincide.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/toi.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace bullet_ccd
{
/// Which two features meet.
enum class ElementaryKind : std::uint8_t
{
    VertexFace,  ///< vertex 0 against the triangle of vertices 1, 2, 3
    EdgeEdge,    ///< the edge of vertices 0 and 1 against that of 2 and 3
};

/// The places of the four vertices of a pair at one time [m].
using FourPoints = std::array<Eigen::Vector3d, 4>;

/// Two features and how they move: vertex k is at (1 - t) start[k] + t end[k], t in [0, 1].
struct ElementaryPair
{
    ElementaryKind kind = ElementaryKind::VertexFace;
    FourPoints start{};
    FourPoints end{};
};

/// What becomes of a pair whose gap has come down to the tolerance.
enum class ElementaryDepth : std::uint8_t
{
    Tolerance,  ///< it is a contact
    Decide,     ///< it is followed further, by a bounded effort: most then pass each other, or come
                ///< down to the rounding error of double precision; what is still open is a contact
    Exact,      ///< as Decide, and what is still open is decided without rounding: the answer is a
                ///< contact if and only if the features touch. Without minimum separation only.
};

/// What an elementary query is asked. The members of ToiOptions that it knows mean the same here.
struct ElementaryOptions
{
    /// Features that are already closer at t = 0 count as in contact at half of that distance.
    double tolerance = kDefaultTolerance;
    double minimumSeparation = 0.0;
    ElementaryDepth depth = ElementaryDepth::Tolerance;
    std::int64_t maxIterations = 10'000;  ///< of the search in time
};

/// First contact of two features. The normal points from the first feature to the second.
struct ElementaryResult
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;  ///< certified: no contact before it
    /// Distance of the features at `time` [m]; without a contact the minimum separation, which they
    /// exceed at all times.
    double gap = 0.0;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, at `time`; zero without a contact
    /// Of the vertices in the vector from the first feature's nearest point to the second's, at
    /// `time`: (-1, a, b, c) for a vertex and a face, (u - 1, -u, 1 - v, v) for two edges. Zero
    /// without a contact.
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    std::int64_t iterations = 0;  ///< evaluations of the nearest point
};

/// First time in [0, 1] at which two features come within `options.tolerance`.
///
/// Guarantee: no contact for t in [0, result.time); ToiStatus says what each outcome promises. No
/// contact is missed through rounding: with M the largest coordinate of the difference of any two
/// vertices of different features, all rounding stays below 64 * 2^-53 M, which is added to the
/// separation that is kept. So a contact may be reported whose gap is tolerance + 1.5e-14 M.
/// With ElementaryDepth::Exact a contact is reported if and only if the features touch.
/// Throws std::invalid_argument for coordinates that are not finite, a tolerance that is not
/// positive, a minimum separation that is negative, or one with ElementaryDepth::Exact.
[[nodiscard]] BULLET_CCD_API ElementaryResult elementaryToi(const ElementaryPair& pair,
                                                            const ElementaryOptions& options);
}  // namespace bullet_ccd
