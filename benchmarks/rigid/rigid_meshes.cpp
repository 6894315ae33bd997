#include "benchmarks/rigid/rigid_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Vector3d;
using std::numbers::pi;

std::int32_t count(const TriangleMesh& mesh)
{
    return static_cast<std::int32_t>(mesh.vertices.size());
}

void addQuad(TriangleMesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d)
{
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
}

Vector3d knotCurve(double t)
{
    const double k = 50 + 22 * std::cos(3 * t);
    return {k * std::cos(2 * t), k * std::sin(2 * t), 30 * std::sin(3 * t)};
}

/// Divides by multiplying with the inverse: the last bit is part of the recipe.
Vector3d direction(const Vector3d& v)
{
    return v * (1 / std::sqrt(v.x() * v.x() + v.y() * v.y() + v.z() * v.z()));
}

TriangleMesh makeIcosahedron()
{
    const double g = (1 + std::sqrt(5.0)) / 2;
    TriangleMesh mesh;
    mesh.vertices = {{-1, g, 0},
                     {1, g, 0},
                     {-1, -g, 0},
                     {1, -g, 0},
                     {0, -1, g},
                     {0, 1, g},
                     {0, -1, -g},
                     {0, 1, -g},
                     {g, 0, -1},
                     {g, 0, 1},
                     {-g, 0, -1},
                     {-g, 0, 1}};
    for (Vector3d& v : mesh.vertices)
    {
        v = direction(v);
    }
    mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    return mesh;
}

/// Every triangle into four, the new vertices on the unit sphere.
void subdivide(TriangleMesh& mesh)
{
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b)
    {
        const auto [found, isNew] = middles.try_emplace(std::minmax(a, b), count(mesh));
        if (isNew)
        {
            const auto at = [&](std::int32_t i)
            { return mesh.vertices[static_cast<std::size_t>(i)]; };
            mesh.vertices.push_back(direction(at(a) + at(b)));
        }
        return found->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles)
    {
        const std::int32_t x = middle(a, b);
        const std::int32_t y = middle(b, c);
        const std::int32_t z = middle(c, a);
        finer.insert(finer.end(), {Triangle{a, x, z}, {b, y, x}, {c, z, y}, {x, y, z}});
    }
    mesh.triangles = std::move(finer);
}

/// Fan between the pole and a ring of `around` vertices that starts at vertex `ring`.
void addFan(TriangleMesh& mesh, std::int32_t pole, std::int32_t ring, int around, bool poleIsFirst)
{
    for (int j = 0; j < around; ++j)
    {
        const std::int32_t a = ring + j;
        const std::int32_t b = ring + (j + 1) % around;
        mesh.triangles.push_back(poleIsFirst ? Triangle{pole, b, a} : Triangle{a, b, pole});
    }
}
}  // namespace

TriangleMesh makeKnotTube(int along, int around)
{
    TriangleMesh mesh;
    constexpr double kRadius = 0.6 * 22.0;
    for (int i = 0; i < along; ++i)
    {
        const double t = 2 * pi * i / along;
        const Vector3d tangent = direction(knotCurve(t + 1e-4) - knotCurve(t - 1e-4));
        const Vector3d outward(std::cos(2 * t), std::sin(2 * t), 0);
        const Vector3d side = direction(tangent.cross(outward));
        const Vector3d up = side.cross(tangent);
        for (int j = 0; j < around; ++j)
        {
            const double s = 2 * pi * j / around;
            mesh.vertices.push_back(knotCurve(t) + up * (kRadius * std::cos(s)) +
                                    side * (kRadius * std::sin(s)));
        }
    }
    for (int i = 0; i < along; ++i)
    {
        const int next = (i + 1) % along;
        for (int j = 0; j < around; ++j)
        {
            const int k = (j + 1) % around;
            addQuad(mesh, i * around + j, next * around + j, next * around + k, i * around + k);
        }
    }
    return mesh;
}

TriangleMesh makeBumpySphere(int subdivisions, double radius, double amplitude)
{
    TriangleMesh mesh = makeIcosahedron();
    for (int level = 0; level < subdivisions; ++level)
    {
        subdivide(mesh);
    }
    for (Vector3d& v : mesh.vertices)
    {
        const double factor = 1 + amplitude * std::sin(5 * v.x() + 1) * std::sin(5 * v.y() + 2) *
                                      std::sin(5 * v.z() + 3);
        v *= radius * factor;
    }
    return mesh;
}

TriangleMesh makeFinger()
{
    constexpr int kSegments = 14;
    constexpr int kAround = 16;
    constexpr double kRadius = 9.0;
    constexpr double kLength = 70.0;
    std::vector<std::array<double, 2>> rings;  // radius, z
    for (int i = 1; i <= 8; ++i)
    {
        const double s = pi / 2 * i / 8;
        rings.push_back({kRadius * std::sin(s), -kRadius * std::cos(s)});
    }
    for (int i = 1; i < kSegments; ++i)
    {
        rings.push_back({kRadius, kLength * i / kSegments});
    }
    for (int i = 0; i < 8; ++i)
    {
        const double s = pi / 2 * i / 8;
        rings.push_back({kRadius * std::cos(s), kLength + kRadius * std::sin(s)});
    }
    TriangleMesh mesh;
    mesh.vertices.push_back({0, 0, -kRadius});
    for (const auto& [r, z] : rings)
    {
        for (int j = 0; j < kAround; ++j)
        {
            const double s = 2 * pi * j / kAround;
            mesh.vertices.push_back({r * std::cos(s), r * std::sin(s), z});
        }
    }
    const std::int32_t top = count(mesh);
    mesh.vertices.push_back({0, 0, kLength + kRadius});
    addFan(mesh, 0, 1, kAround, true);
    for (int i = 0; i + 1 < static_cast<int>(rings.size()); ++i)
    {
        const std::int32_t ring = 1 + i * kAround;
        for (int j = 0; j < kAround; ++j)
        {
            const int k = (j + 1) % kAround;
            addQuad(mesh, ring + j, ring + k, ring + kAround + k, ring + kAround + j);
        }
    }
    addFan(mesh, top, top - kAround, kAround, false);
    return mesh;
}

TriangleMesh makePlate(int cells, double side, double thickness)
{
    TriangleMesh mesh;
    const int row = cells + 1;
    const auto at = [&](int face, int i, int j) { return face * row * row + i * row + j; };
    for (int face = 0; face < 2; ++face)
    {
        for (int i = 0; i <= cells; ++i)
        {
            for (int j = 0; j <= cells; ++j)
            {
                mesh.vertices.push_back({side * (static_cast<double>(i) / cells - 0.5),
                                         side * (static_cast<double>(j) / cells - 0.5),
                                         (face - 0.5) * thickness});
            }
        }
    }
    for (int i = 0; i < cells; ++i)
    {
        for (int j = 0; j < cells; ++j)
        {
            addQuad(mesh, at(1, i, j), at(1, i + 1, j), at(1, i + 1, j + 1), at(1, i, j + 1));
            addQuad(mesh, at(0, i, j), at(0, i, j + 1), at(0, i + 1, j + 1), at(0, i + 1, j));
        }
    }
    const int n = cells;
    for (int i = 0; i < n; ++i)
    {
        addQuad(mesh, at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
        addQuad(mesh, at(0, i + 1, n), at(0, i, n), at(1, i, n), at(1, i + 1, n));
        addQuad(mesh, at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1));
        addQuad(mesh, at(0, n, i), at(0, n, i + 1), at(1, n, i + 1), at(1, n, i));
    }
    return mesh;
}
}  // namespace bullet_ccd::benchmarks
