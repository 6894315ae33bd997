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
constexpr double kWall = 3e-3;   // of what is closed [m]
constexpr double kThick = 1e-2;  // of what is open [m]
constexpr double kVent = 2e-3;   // radius of the hole in a lid, which makes a shell one surface [m]
constexpr int kRound = 48;       // sides of what is round

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
        outline.emplace_back(std::max(point->x() - kThick, 0.0), isBottom ? kThick : point->y());
    }
    return outline;
}

/// The outline of a shell with a lid, in whose middle there is a vent; `outside` goes up.
Profile shell(const Profile& outside)
{
    const double bottom = outside.front().y();
    const double top = outside.back().y();
    Profile outline{{0.0, bottom}};
    outline.insert(outline.end(), outside.begin(), outside.end());
    outline.insert(outline.end(), {{kVent, top}, {kVent, top - kWall}});
    for (auto point = outside.rbegin(); point != outside.rend(); ++point)
    {
        outline.emplace_back(point->x() - kWall,
                             std::clamp(point->y(), bottom + kWall, top - kWall));
    }
    outline.emplace_back(0.0, bottom + kWall);
    return outline;
}

/// The outline of a shell, round from below to its top.
Profile egg(double radius, double halfHeight)
{
    constexpr int kSteps = 24;
    Profile outline;
    for (const double wall : {0.0, kWall})
    {
        Profile arc;
        for (int i = 0; i <= kSteps; ++i)
        {
            const double angle = std::numbers::pi * i / kSteps;  // from below
            arc.emplace_back(i == 0        ? 0.0
                             : i == kSteps ? kVent
                                           : (radius - wall) * std::sin(angle),
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

/// The outside of a dome on a flat foot.
Profile dome(double radius, double foot, double height)
{
    constexpr int kSteps = 12;
    Profile outside{{radius, 0.0}};
    for (int i = 0; i < kSteps; ++i)
    {
        const double angle = 0.5 * std::numbers::pi * i / kSteps;
        outside.emplace_back(radius * std::cos(angle), foot + (height - foot) * std::sin(angle));
    }
    return outside;
}
}  // namespace

const std::vector<std::string>& largeObjectNames()
{
    static const std::vector<std::string> names{"ball",
                                                "barrel",
                                                "bolster",
                                                "bucket",
                                                "carton",
                                                "cone",
                                                "crate",
                                                "dome",
                                                "drum",
                                                "egg",
                                                "hamper",
                                                "pot",
                                                "pumpkin",
                                                "tray"};
    return names;
}

TriangleMesh makeLargeObject(const std::string& name)
{
    if (name == "ball")
    {
        return turned(egg(0.17, 0.17), kRound);
    }
    if (name == "barrel")
    {
        return turned(shell({{0.13, 0.0}, {0.16, 0.1}, {0.16, 0.25}, {0.13, 0.35}}), kRound);
    }
    if (name == "bolster")
    {
        return turned(shell({{0.15, 0.0}, {0.15, 0.42}}), kRound);
    }
    if (name == "bucket")
    {
        return turned(shell({{0.13, 0.0}, {0.16, 0.3}}), kRound);
    }
    if (name == "carton")
    {
        return turned(shell({{0.16, 0.0}, {0.16, 0.3}}), 4);
    }
    if (name == "cone")
    {
        return turned(shell({{0.18, 0.0}, {0.13, 0.32}}), kRound);
    }
    if (name == "crate")
    {
        return turned(shell({{0.2, 0.0}, {0.2, 0.3}}), 4, 0.75);
    }
    if (name == "dome")
    {
        return turned(shell(dome(0.17, 0.08, 0.28)), kRound);
    }
    if (name == "drum")
    {
        return turned(shell({{0.16, 0.0}, {0.16, 0.3}}), kRound);
    }
    if (name == "egg")
    {
        return turned(egg(0.16, 0.2), kRound, 0.8);
    }
    if (name == "hamper")
    {
        return turned(shell({{0.15, 0.0}, {0.15, 0.32}}), 6);
    }
    if (name == "pot")
    {
        return turned(vessel({{0.0, 0.0}, {0.16, 0.0}, {0.16, 0.2}}), kRound);
    }
    if (name == "pumpkin")
    {
        return turned(egg(0.17, 0.14), kRound);
    }
    if (name == "tray")
    {
        return turned(vessel({{0.0, 0.0}, {0.24, 0.0}, {0.25, 0.06}}), 4, 0.7);
    }
    throw std::invalid_argument("large object \"" + name + "\": there is none of that name");
}
}  // namespace bullet_ccd::shapes
