#include "benchmarks/rigid/rigid_meshes.h"

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Vector3d;
using std::numbers::pi;

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
}  // namespace

TriangleMesh makeKnotTube(int along, int around)
{
    TriangleMesh mesh;
    constexpr double kRadius = 0.6 * 22.0;
    for (int i = 0; i < along; ++i)
    {
        const double t = 2 * pi * i / along;
        const Vector3d tangent = (knotCurve(t + 1e-4) - knotCurve(t - 1e-4)).normalized();
        const Vector3d outward(std::cos(2 * t), std::sin(2 * t), 0);
        const Vector3d side = tangent.cross(outward).normalized();
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
    TriangleMesh mesh = makeSphere(1.0, subdivisions);
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
    constexpr double kRadius = 9.0;
    constexpr double kLength = 70.0;
    std::vector<Eigen::Vector2d> profile{{0, -kRadius}};  // radius, z
    for (int i = 1; i <= 8; ++i)
    {
        const double s = pi / 2 * i / 8;
        profile.emplace_back(kRadius * std::sin(s), -kRadius * std::cos(s));
    }
    for (int i = 1; i < kSegments; ++i)
    {
        profile.emplace_back(kRadius, kLength * i / kSegments);
    }
    for (int i = 0; i < 8; ++i)
    {
        const double s = pi / 2 * i / 8;
        profile.emplace_back(kRadius * std::cos(s), kLength + kRadius * std::sin(s));
    }
    profile.emplace_back(0, kLength + kRadius);
    return makeRevolved(profile, 16);
}

TriangleMesh makeGridBox(const std::array<int, 3>& cells, const Vector3d& halfExtents)
{
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis)
    {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        const auto along = [&](int side, int i)
        { return (2.0 * i / cells[static_cast<std::size_t>(side)] - 1.0) * halfExtents[side]; };
        for (const double side : {-1.0, 1.0})
        {
            for (int i = 0; i < cells[static_cast<std::size_t>(u)]; ++i)
            {
                for (int j = 0; j < cells[static_cast<std::size_t>(v)]; ++j)
                {
                    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
                    for (const auto& [di, dj] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}})
                    {
                        Vector3d corner;
                        corner[axis] = side * halfExtents[axis];
                        corner[u] = along(u, i + di);
                        corner[v] = along(v, j + dj);
                        mesh.vertices.push_back(corner);
                    }
                    const int turn = side > 0.0 ? 1 : 3;
                    addQuad(mesh, first, first + turn, first + 2, first + 4 - turn);
                }
            }
        }
    }
    repairMesh(mesh);
    return mesh;
}

TriangleMesh makeRingedCylinder(
    double radius, double height, int segments, int ringsOnCap, int ringsAlong)
{
    std::vector<Eigen::Vector2d> profile{{0.0, -0.5 * height}};  // radius, z
    for (int i = 1; i <= ringsOnCap; ++i)
    {
        profile.emplace_back(radius * i / ringsOnCap, -0.5 * height);
    }
    for (int i = 1; i <= ringsAlong; ++i)
    {
        profile.emplace_back(radius, height * (static_cast<double>(i) / ringsAlong - 0.5));
    }
    for (int i = ringsOnCap - 1; i >= 0; --i)
    {
        profile.emplace_back(radius * i / ringsOnCap, 0.5 * height);
    }
    return makeRevolved(profile, segments);
}

TriangleMesh makeGear(int teeth, double backlash, double width, int stations)
{
    constexpr int kFlank = 9;  // points
    const double pitch = 0.5 * teeth;
    const double angle = pi / 9.0;
    const double base = pitch * std::cos(angle);
    const auto involute = [](double x) { return std::tan(x) - x; };
    // Half of a tooth, seen from the center.
    const auto halfAt = [&](double radius)
    {
        const double pressure = std::acos(std::min(1.0, base / radius));
        return (0.5 * pi - 0.5 * backlash) / teeth + involute(angle) - involute(pressure);
    };
    std::vector<Vector3d> ring;
    for (int tooth = 0; tooth < teeth; ++tooth)
    {
        for (int i = 0; i < 2 * kFlank; ++i)
        {
            const bool rises = i < kFlank;
            const int step = rises ? i : 2 * kFlank - 1 - i;
            const double radius = pitch - 1.25 + 2.25 * step / (kFlank - 1);
            const double at =
                2.0 * pi * tooth / teeth + (rises ? -1.0 : 1.0) * halfAt(std::max(radius, base));
            ring.emplace_back(radius * std::cos(at), radius * std::sin(at), 0.0);
        }
    }
    return makeLofted(
        [&](int station)
        {
            std::vector<Vector3d> section = ring;
            for (Vector3d& point : section)
            {
                point.z() = width * (static_cast<double>(station) / (stations - 1) - 0.5);
            }
            return section;
        },
        stations);
}

TriangleMesh makeThread(double radius, double depth, double pitch, bool isNut)
{
    constexpr int kAround = 64;
    constexpr int kStations = 97;
    constexpr int kPerTurn = 16;
    TriangleMesh mesh = makeLofted(
        [&](int station)
        {
            std::vector<Vector3d> ring;
            for (int i = 0; i < kAround; ++i)
            {
                const double at = 2.0 * pi * i / kAround;
                const double r = radius + depth * std::sin(2.0 * pi * station / kPerTurn - at);
                const double z = pitch * (station - kStations / 2) / kPerTurn;
                ring.emplace_back(r * std::cos(at), r * std::sin(at), z);
            }
            return ring;
        },
        kStations);
    if (isNut)
    {
        mesh.triangles.resize(2UL * kAround * (kStations - 1));
    }
    return mesh;
}

TriangleMesh makeComb(int blades, double pitch, const Vector3d& halfExtents)
{
    TriangleMesh mesh;
    for (int i = 0; i < blades; ++i)
    {
        TriangleMesh blade = makeGridBox({9, 9, 9}, halfExtents);
        for (Vector3d& vertex : blade.vertices)
        {
            vertex.z() += pitch * i;
        }
        appendMesh(mesh, blade);
    }
    return mesh;
}
}  // namespace bullet_ccd::benchmarks
