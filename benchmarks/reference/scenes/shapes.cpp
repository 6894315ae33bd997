#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace bullet_ccd::reference
{
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

TriangleMesh triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    return {.vertices = {a, b, c}, .triangles = {{0, 1, 2}}};
}

TriangleMesh segment(const Vector3d& a, const Vector3d& b)
{
    return {.vertices = {a, b}, .triangles = {{0, 1, 1}}};
}

TriangleMesh quad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d)
{
    return {.vertices = {a, b, c, d}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
}

TriangleMesh floorAt(double z, double half)
{
    return quad({-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z});
}

TriangleMesh wallAtX(double x, double half)
{
    return quad({x, -half, -half}, {x, half, -half}, {x, half, half}, {x, -half, half});
}

TriangleMesh wallAtY(double y, double half)
{
    return quad({-half, y, -half}, {-half, y, half}, {half, y, half}, {half, y, -half});
}

TriangleMesh box(const Vector3d& low, const Vector3d& high)
{
    return prism(
        {{low.x(), low.y()}, {high.x(), low.y()}, {high.x(), high.y()}, {low.x(), high.y()}},
        low.z(),
        high.z());
}

TriangleMesh cube(double half)
{
    return box(Vector3d::Constant(-half), Vector3d::Constant(half));
}

TriangleMesh sphereWithPole(double radius, const Vector3d& direction, int rings)
{
    const Vector3d pole = direction.normalized();
    const Vector3d side = pole.unitOrthogonal();
    const Vector3d third = pole.cross(side);
    const int around = 2 * rings;
    TriangleMesh mesh;
    for (int i = 1; i < rings; ++i)
    {
        const double polar = std::numbers::pi * i / rings;
        for (int j = 0; j < around; ++j)
        {
            const double angle = 2.0 * std::numbers::pi * j / around;
            const Vector3d flat = std::cos(angle) * side + std::sin(angle) * third;
            // The factor keeps rounding from pushing a vertex outside the sphere.
            mesh.vertices.push_back((1.0 - 1e-15) * radius *
                                    (std::cos(polar) * pole + std::sin(polar) * flat));
        }
    }
    const auto top = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.push_back(radius * pole);
    mesh.vertices.push_back(-radius * pole);
    for (int j = 0; j < around; ++j)
    {
        const int next = (j + 1) % around;
        mesh.triangles.push_back({top, j, next});
        for (int i = 0; i + 2 < rings; ++i)
        {
            const int row = i * around;
            mesh.triangles.push_back({row + j, row + around + j, row + around + next});
            mesh.triangles.push_back({row + j, row + around + next, row + next});
        }
        const int last = (rings - 2) * around;
        mesh.triangles.push_back({last + next, last + j, top + 1});
    }
    return mesh;
}

std::vector<Vector2d> circlePoints(double radius, const std::vector<double>& angles)
{
    std::vector<Vector2d> points;
    for (const double angle : angles)
    {
        points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    return points;
}

std::vector<double> circleAngles(int count, double first, std::initializer_list<double> extra)
{
    constexpr double kTurn = 2.0 * std::numbers::pi;
    std::vector<double> angles;
    for (int i = 0; i < count; ++i)
    {
        angles.push_back(first + kTurn * i / count);
    }
    for (const double angle : extra)
    {
        angles.push_back(angle - kTurn * std::floor((angle - first) / kTurn));
    }
    std::sort(angles.begin(), angles.end());
    return angles;
}

TriangleMesh prism(const std::vector<Vector2d>& ring, double zLow, double zHigh)
{
    const auto n = static_cast<std::int32_t>(ring.size());
    TriangleMesh mesh;
    for (const double z : {zLow, zHigh})
    {
        for (const Vector2d& p : ring)
        {
            mesh.vertices.emplace_back(p.x(), p.y(), z);
        }
    }
    for (std::int32_t i = 0; i < n; ++i)
    {
        const std::int32_t next = (i + 1) % n;
        mesh.triangles.push_back({i, next, n + next});
        mesh.triangles.push_back({i, n + next, n + i});
    }
    for (std::int32_t i = 1; i + 1 < n; ++i)
    {
        mesh.triangles.push_back({0, i + 1, i});
        mesh.triangles.push_back({n, n + i, n + i + 1});
    }
    return mesh;
}

TriangleMesh octahedron()
{
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis)
    {
        mesh.vertices.push_back(Vector3d::Unit(axis));
        mesh.vertices.push_back(-Vector3d::Unit(axis));
    }
    for (const std::int32_t x : {0, 1})
    {
        for (const std::int32_t y : {2, 3})
        {
            for (const std::int32_t z : {4, 5})
            {
                const bool even = (x + (y - 2) + (z - 4)) % 2 == 0;
                mesh.triangles.push_back(even ? Triangle{x, y, z} : Triangle{x, z, y});
            }
        }
    }
    return mesh;
}

TriangleMesh soup(Random& random, int count, double half, double size)
{
    TriangleMesh mesh;
    for (std::int32_t i = 0; i < count; ++i)
    {
        const Vector3d center = random.inBox(half);
        for (int corner = 0; corner < 3; ++corner)
        {
            mesh.vertices.push_back(center + random.inBox(size));
        }
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

TriangleMesh merged(std::initializer_list<TriangleMesh> meshes)
{
    TriangleMesh all;
    for (const TriangleMesh& mesh : meshes)
    {
        const auto offset = static_cast<std::int32_t>(all.vertices.size());
        all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
        for (const Triangle& t : mesh.triangles)
        {
            all.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
        }
    }
    return all;
}

TriangleMesh placed(TriangleMesh mesh, const Isometry3d& X)
{
    for (Vector3d& v : mesh.vertices)
    {
        v = X * v;
    }
    return mesh;
}

TriangleMesh shifted(TriangleMesh mesh, const Vector3d& offset)
{
    for (Vector3d& v : mesh.vertices)
    {
        v += offset;
    }
    return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, double factor)
{
    for (Vector3d& v : mesh.vertices)
    {
        v *= factor;
    }
    return mesh;
}

TriangleMesh permuted(TriangleMesh mesh, Random& random)
{
    for (std::size_t i = mesh.triangles.size(); i > 1; --i)
    {
        const auto j = static_cast<std::size_t>(random.integer(0, static_cast<int>(i) - 1));
        std::swap(mesh.triangles[i - 1], mesh.triangles[j]);
    }
    for (Triangle& t : mesh.triangles)
    {
        std::rotate(t.begin(), t.begin() + random.integer(0, 2), t.end());
    }
    return mesh;
}

double radiusOf(const TriangleMesh& mesh)
{
    double radius = 0.0;
    for (const Vector3d& v : mesh.vertices)
    {
        radius = std::max(radius, v.norm());
    }
    return radius;
}

Isometry3d poseOf(const Vector3d& translation, double angle, const Vector3d& axis)
{
    Isometry3d X = Isometry3d::Identity();
    X.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    X.translation() = translation;
    return X;
}
}  // namespace bullet_ccd::reference
