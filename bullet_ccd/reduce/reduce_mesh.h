/// Smaller models of a body that keep a promised accuracy: fewer triangles, or a simple shape; and
/// how far one surface reaches from another, as a certified number.
///
/// What a simplifier says of its error is never believed. Every model is compared with the full
/// mesh by surfaceDeviation() in both directions, and a model that deviates by more than the
/// accuracy is not returned.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/math/stop_condition.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <optional>

namespace bullet_ccd
{
/// Bounds of the greatest distance of a point of a surface from another surface [m].
struct Deviation
{
    double lower = 0.0;                               ///< `point` is this far away
    double upper = 0.0;                               ///< no point is farther away
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< of the surface, in its frame
};

/// Greatest distance of a point of `surface` from the mesh of `other`, both in one frame: the
/// one-sided Hausdorff distance. All points of the triangles count, not only their vertices.
///
/// Guarantee: the truth is in [lower, upper] up to 1e-12 of the coordinates, and upper is at most
/// 1 % above lower or above `enough`, whichever is larger, unless a triangle of `surface` meets
/// more than 100,000 others. If the truth is found to exceed `limit`, the search ends: lower is
/// then above it and upper infinite. The result does not depend on the number of threads if it is
/// below the limit. How: the distance from one triangle is convex, so its maximum over a polygon is
/// at a corner. A triangle of `surface` is cut into polygons, each of which has one triangle of
/// `other` that is near at all of its corners. Throws std::invalid_argument for a mesh that
/// checkMesh() refuses, or for bounds that are NaN or negative, and QueryStopped.
[[nodiscard]] BULLET_CCD_API Deviation
surfaceDeviation(const TriangleMesh& surface,
                 const SsvTree& other,
                 double enough,
                 double limit = std::numeric_limits<double>::infinity(),
                 const StopCondition& stop = {});

/// What a reduced model is, the cheapest first.
enum class ModelKind
{
    Sphere,
    Capsule,
    Box,
    Hull,
    Mesh,
};

/// "sphere", "capsule", "box", "hull" or "mesh".
[[nodiscard]] BULLET_CCD_API const char* modelKindName(ModelKind kind);

/// A model in place of a mesh, in the frame of the mesh.
struct ReducedModel
{
    ModelKind kind = ModelKind::Mesh;
    /// The surface. The facets of spheres and capsules are around them; the deviations hold for
    /// both.
    TriangleMesh mesh{};
    /// Of a sphere, capsule or box: its frame. A capsule is along z.
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    double radius = 0.0;  ///< of a sphere or capsule [m]
    double height = 0.0;  ///< of a capsule: distance of the centres of its ends [m]
    Eigen::Vector3d halfExtents = Eigen::Vector3d::Zero();  ///< of a box [m]
    Deviation fullFromModel{};  ///< of the full surface from the model's
    Deviation modelFromFull{};  ///< of the model's surface from the full one

    /// No point of either surface is farther from the other one [m].
    [[nodiscard]] double deviation() const
    {
        return std::max(fullFromModel.upper, modelFromFull.upper);
    }
};

/// Which models reduceMesh() may take.
struct ReduceOptions
{
    /// Largest deviation of the surfaces from each other, in both directions [m].
    double accuracy = 0.0;
    /// The solid of the model contains that of the full mesh, which must be closed: what does not
    /// touch the model does not touch the body.
    bool contains = false;
    /// The only kind to try; otherwise all kinds are tried, the cheapest first.
    std::optional<ModelKind> kind{};
    /// Deadline and cancellation. What builds a hierarchy or simplifies a mesh goes on to its end
    /// first, which takes some microseconds per triangle.
    StopCondition stop{};
};

/// Smallest accuracy that reduceMesh() takes for a mesh [m]: 1e-9 of its largest coordinate or
/// extent.
[[nodiscard]] BULLET_CCD_API double smallestAccuracy(const TriangleMesh& mesh);

/// The cheapest model that keeps the accuracy: sphere, capsule, box, convex hull, else a mesh of
/// fewer triangles (moved outwards where the model must contain the body). The full mesh itself,
/// with deviation 0, if nothing smaller keeps the accuracy.
///
/// Guarantee: deviation() <= accuracy, by surfaceDeviation(). Two bodies whose models have a gap of
/// g have a gap in [g - s, g + s], where s is the sum of their deviations. The result is
/// deterministic.
/// With `kind` set, the result is nothing if a model of this kind does not keep the accuracy.
/// How: the simplifier is that of meshoptimizer, which begins, and collapses of edges that are
/// compared with the full mesh one by one; the hull is Qhull's.
/// Throws std::invalid_argument for a mesh that checkMesh() refuses, an accuracy below
/// smallestAccuracy(), and `contains` for a mesh that is not closed; QueryStopped.
[[nodiscard]] BULLET_CCD_API std::optional<ReducedModel> reduceMesh(const TriangleMesh& mesh,
                                                                    const ReduceOptions& options);
}  // namespace bullet_ccd
