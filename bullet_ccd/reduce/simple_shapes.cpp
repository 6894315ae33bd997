#include "bullet_ccd/reduce/simple_shapes.h"

#include "bullet_ccd/distance/triangle_distance.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kSegments = 96;

MeshFrame frameAlong(const TriangleMesh& mesh, const Matrix3d& axes)
{
    Eigen::AlignedBox3d box;
    for (const Vector3d& vertex : mesh.vertices)
    {
        box.extend(Vector3d(axes.transpose() * vertex));
    }
    MeshFrame frame;
    frame.pose.linear() = axes;
    frame.pose.translation() = axes * box.center();
    frame.half = 0.5 * box.sizes();
    return frame;
}

/// Axes of the second moments of the surface about its centroid.
Matrix3d principalAxes(const TriangleMesh& mesh)
{
    double area = 0.0;
    Vector3d first = Vector3d::Zero();
    Matrix3d second = Matrix3d::Zero();
    const Vector3d origin = bounds(mesh).center();
    for (const Triangle& t : mesh.triangles)
    {
        std::array<Vector3d, 3> corners;
        for (std::size_t k = 0; k < 3; ++k)
        {
            corners[k] = mesh.vertices[static_cast<std::size_t>(t[k])] - origin;
        }
        const double weight = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
        const Vector3d sum = corners[0] + corners[1] + corners[2];
        area += weight;
        first += weight / 3.0 * sum;
        second += weight / 12.0 * (sum * sum.transpose());
        for (const Vector3d& corner : corners)
        {
            second += weight / 12.0 * (corner * corner.transpose());
        }
    }
    if (!(area > 0.0))
    {
        return Matrix3d::Identity();
    }
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(second - first * first.transpose() / area);
    Matrix3d axes = solver.eigenvectors();
    axes.col(2) = axes.col(0).cross(axes.col(1)).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return axes;
}

/// The ends of a capsule's axis as a triangle without area.
TriangleCorners axisOf(const ReducedModel& model)
{
    const Vector3d reach = 0.5 * model.height * model.pose.linear().col(2);
    const Vector3d middle = model.pose.translation();
    return {middle - reach, middle + reach, middle + reach};
}

TriangleCorners cornersOf(const TriangleMesh& mesh, const Triangle& t)
{
    return {mesh.vertices[static_cast<std::size_t>(t[0])],
            mesh.vertices[static_cast<std::size_t>(t[1])],
            mesh.vertices[static_cast<std::size_t>(t[2])]};
}

/// Enlarges the radius until all vertices are inside, and makes the surface.
void enclose(const TriangleMesh& mesh, ReducedModel& model)
{
    const TriangleCorners axis = axisOf(model);
    model.radius = 0.0;
    for (const Vector3d& vertex : mesh.vertices)
    {
        model.radius = std::max(model.radius, pointToTriangle(vertex, axis).distance);
    }
    if (!(model.radius > 0.0))
    {
        return;  // a line: no solid
    }
    // The facets of a capsule cut inside of it: one that is larger by that share contains it.
    const auto capsule = [&](double radius)
    {
        TriangleMesh facets = makeCapsule(radius, model.height, kSegments);
        transformMesh(facets, Eigen::Affine3d(model.pose));
        return facets;
    };
    model.mesh = capsule(model.radius);
    double least = model.radius;
    for (const Triangle& t : model.mesh.triangles)
    {
        least = std::min(least, triangleDistance(cornersOf(model.mesh, t), axis).distance);
    }
    constexpr double kRounding = 1e-9;
    model.mesh = capsule((1.0 + kRounding) * model.radius * model.radius / least);
}
}  // namespace

std::array<MeshFrame, 2> meshFrames(const TriangleMesh& mesh)
{
    return {frameAlong(mesh, Matrix3d::Identity()), frameAlong(mesh, principalAxes(mesh))};
}

ReducedModel sphereAround(const TriangleMesh& mesh)
{
    // The centre moves towards the farthest vertex by steps that shrink: after n of them the radius
    // is within 1/n of the smallest (Badoiu and Clarkson 2003).
    Vector3d center = bounds(mesh).center();
    for (int step = 1; step <= 200; ++step)
    {
        const auto farthest =
            std::max_element(mesh.vertices.begin(),
                             mesh.vertices.end(),
                             [&](const Vector3d& x, const Vector3d& y)
                             { return (x - center).squaredNorm() < (y - center).squaredNorm(); });
        center += (*farthest - center) / (step + 1.0);
    }
    // Where the vertices are on a sphere, the middle of the bounds is often the better centre.
    ReducedModel best{.kind = ModelKind::Sphere};
    for (const Vector3d& candidate : {center, Vector3d(bounds(mesh).center())})
    {
        ReducedModel model{.kind = ModelKind::Sphere};
        model.pose.translation() = candidate;
        enclose(mesh, model);
        if (best.mesh.triangles.empty() || model.radius < best.radius)
        {
            best = std::move(model);
        }
    }
    return best;
}

ReducedModel capsuleAround(const TriangleMesh& mesh, const MeshFrame& frame, int axis)
{
    ReducedModel model{.kind = ModelKind::Capsule};
    Matrix3d axes;
    axes << frame.pose.linear().col((axis + 1) % 3), frame.pose.linear().col((axis + 2) % 3),
        frame.pose.linear().col(axis);
    model.pose.linear() = axes;
    model.pose.translation() = frame.pose.translation();
    double thickness = 0.0;
    for (const Vector3d& vertex : mesh.vertices)
    {
        const Vector3d local = axes.transpose() * (vertex - model.pose.translation());
        thickness = std::max(thickness, local.head<2>().norm());
    }
    model.height = 2.0 * std::max(0.0, frame.half[axis] - thickness);
    enclose(mesh, model);
    return model;
}

ReducedModel boxAround(const MeshFrame& frame)
{
    ReducedModel model{.kind = ModelKind::Box, .mesh = makeBox(frame.half), .pose = frame.pose};
    model.halfExtents = frame.half;
    transformMesh(model.mesh, Eigen::Affine3d(frame.pose));
    return model;
}

void compareRound(const TriangleMesh& mesh,
                  const SsvTree& full,
                  double limit,
                  const StopCondition& stop,
                  ReducedModel& model)
{
    // All vertices are inside, and the distance from the axis is convex: how far a point of the
    // mesh is from the round surface is the radius less its distance from the axis. The facets are
    // between the radius and that of their corners.
    const TriangleCorners axis = axisOf(model);
    double outer = model.radius;
    for (const Vector3d& vertex : model.mesh.vertices)
    {
        outer = std::max(outer, pointToTriangle(vertex, axis).distance);
    }
    for (const Triangle& t : mesh.triangles)
    {
        const TriangleDistance nearest = triangleDistance(cornersOf(mesh, t), axis);
        const double depth = outer - nearest.distance;
        if (depth > model.fullFromModel.upper)
        {
            model.fullFromModel = {.lower = std::max(0.0, model.radius - nearest.distance),
                                   .upper = depth,
                                   .point = nearest.pointA};
        }
        if (depth > limit)
        {
            model.fullFromModel.upper = std::numeric_limits<double>::infinity();
            return;
        }
    }
    const double chord = outer - model.radius;
    model.modelFromFull =
        surfaceDeviation(model.mesh, full, 0.5 * limit, std::max(0.0, limit - chord), stop);
    model.modelFromFull.lower = std::max(0.0, model.modelFromFull.lower - chord);
    model.modelFromFull.upper += chord;
}
}  // namespace bullet_ccd
