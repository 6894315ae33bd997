#include "robots/shapes/large_objects.h"

#include "robots/shapes/solid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace bullet_ccd::shapes
{
namespace
{
constexpr double kWall = 3e-3;  // [m]
constexpr int kRound = 48;      // sides of what is round

/// The region that the outline bounds, turned about z; for few sides, radii are those of the flat
/// faces' middles. The outline runs with the outside at its right (up where it is outermost), is
/// closed, and its points on the axis follow each other.
TriangleMesh turned(const Profile& outline, int sides, double widthX = 1.0)
{
    TriangleMesh mesh;
    std::vector<std::int32_t> first;
    const double corner = 1.0 / std::cos(std::numbers::pi / sides);
    for (const Eigen::Vector2d& point : outline)
    {
        first.push_back(static_cast<std::int32_t>(mesh.vertices.size()));
        for (int k = 0; k < (point.x() > 0.0 ? sides : 1); ++k)
        {
            const double angle = 2.0 * std::numbers::pi * (k + 0.5) / sides;
            const double radius = point.x() * corner;
            mesh.vertices.emplace_back(
                widthX * radius * std::cos(angle), radius * std::sin(angle), point.y());
        }
    }
    const auto vertex = [&](std::size_t i, int k)
    { return first[i] + (outline[i].x() > 0.0 ? k % sides : 0); };
    for (std::size_t i = 0; i < outline.size(); ++i)
    {
        const std::size_t next = (i + 1) % outline.size();
        for (int k = 0; k < sides; ++k)
        {
            if (outline[i].x() > 0.0)
            {
                mesh.triangles.push_back({vertex(i, k), vertex(i, k + 1), vertex(next, k + 1)});
            }
            if (outline[next].x() > 0.0)
            {
                mesh.triangles.push_back({vertex(i, k), vertex(next, k + 1), vertex(next, k)});
            }
        }
    }
    return mesh;
}

/// The outline of a vessel, of which `outside` goes from the middle of the bottom to the rim.
Profile vessel(const Profile& outside)
{
    Profile outline = outside;
    for (auto point = outside.rbegin(); point != outside.rend(); ++point)
    {
        const bool isBottom = point->y() == 0.0;
        outline.emplace_back(std::max(point->x() - kWall, 0.0), isBottom ? kWall : point->y());
    }
    return outline;
}

/// The outline of a shell with a hole at its top.
Profile egg(double radius, double halfHeight)
{
    constexpr int kSteps = 24;
    constexpr double kHole = 0.12;  // half its angle
    Profile outline;
    for (const double wall : {0.0, kWall})
    {
        Profile arc;
        for (int i = 0; i <= kSteps; ++i)
        {
            const double angle = (std::numbers::pi - kHole) * i / kSteps;  // from below
            arc.emplace_back(i == 0 ? 0.0 : (radius - wall) * std::sin(angle),
                             halfHeight - (halfHeight - wall) * std::cos(angle));
        }
        if (wall > 0.0)
        {
            std::ranges::reverse(arc);
        }
        outline.insert(outline.end(), arc.begin(), arc.end());
    }
    return outline;
}
}  // namespace

const std::vector<std::string>& largeObjectNames()
{
    static const std::vector<std::string> names{"ball",
                                                "barrel",
                                                "basin",
                                                "bin",
                                                "bucket",
                                                "carton",
                                                "crate",
                                                "egg",
                                                "hoop",
                                                "pot",
                                                "tray",
                                                "vase"};
    return names;
}

TriangleMesh makeLargeObject(const std::string& name)
{
    if (name == "ball")
    {
        return turned(egg(0.16, 0.16), kRound);
    }
    if (name == "barrel")
    {
        return turned(vessel({{0.0, 0.0}, {0.13, 0.0}, {0.16, 0.1}, {0.16, 0.25}, {0.13, 0.35}}),
                      kRound);
    }
    if (name == "basin")
    {
        return turned(vessel({{0.0, 0.0}, {0.12, 0.0}, {0.18, 0.06}, {0.2, 0.13}}), kRound);
    }
    if (name == "bin")
    {
        return turned(vessel({{0.0, 0.0}, {0.15, 0.0}, {0.15, 0.32}}), 6);
    }
    if (name == "bucket")
    {
        return turned(vessel({{0.0, 0.0}, {0.13, 0.0}, {0.16, 0.3}}), kRound);
    }
    if (name == "carton")
    {
        return turned(vessel({{0.0, 0.0}, {0.16, 0.0}, {0.16, 0.3}}), 4);
    }
    if (name == "crate")
    {
        return turned(vessel({{0.0, 0.0}, {0.2, 0.0}, {0.2, 0.2}}), 4, 0.75);
    }
    if (name == "egg")
    {
        return turned(egg(0.16, 0.2), kRound, 0.8);
    }
    if (name == "hoop")
    {
        return turned({{0.17, 0.0}, {0.17, 0.12}, {0.17 - kWall, 0.12}, {0.17 - kWall, 0.0}},
                      kRound);
    }
    if (name == "pot")
    {
        return turned(vessel({{0.0, 0.0}, {0.16, 0.0}, {0.16, 0.2}}), kRound);
    }
    if (name == "tray")
    {
        return turned(vessel({{0.0, 0.0}, {0.21, 0.0}, {0.22, 0.06}}), 4, 0.7);
    }
    if (name == "vase")
    {
        return turned(vessel({{0.0, 0.0}, {0.09, 0.0}, {0.16, 0.15}, {0.09, 0.3}, {0.11, 0.35}}),
                      kRound);
    }
    throw std::invalid_argument("large object \"" + name + "\": there is none of that name");
}
}  // namespace bullet_ccd::shapes
