#include "grasp/check/penetration_check.h"

#include "grasp/check/box_grid.h"
#include "grasp/check/closed_surface.h"
#include "grasp/check/sign_test.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// Intersections and depths up to this are contact, not penetration: the rounding of poses is far
/// below, the gap that closing leaves far above [m].
constexpr double kTouching = PenetrationCheck::kResolution;
const Eigen::Vector3d kShift = kTouching * Eigen::Vector3d(0.6101, -0.4937, 0.6197);

struct PlacedMesh
{
    std::vector<Eigen::Vector3d> vertices;  ///< in W
    const std::vector<Triangle>* triangles = nullptr;
    Eigen::AlignedBox3d bounds;

    [[nodiscard]] Corners corners(std::size_t triangle) const
    {
        const Triangle& t = (*triangles)[triangle];
        return {vertices[static_cast<std::size_t>(t[0])],
                vertices[static_cast<std::size_t>(t[1])],
                vertices[static_cast<std::size_t>(t[2])]};
    }
};

PlacedMesh place(const TriangleMesh& mesh, const Eigen::Isometry3d& pose)
{
    PlacedMesh placed{.vertices = {}, .triangles = &mesh.triangles, .bounds = {}};
    placed.vertices.reserve(mesh.vertices.size());
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        placed.vertices.emplace_back(pose * vertex);
        placed.bounds.extend(placed.vertices.back());
    }
    return placed;
}

Eigen::AlignedBox3d boxOf(const Corners& corners)
{
    Eigen::AlignedBox3d box(corners[0]);
    box.extend(corners[1]);
    box.extend(corners[2]);
    return box;
}

BoxGrid makeGrid(const PlacedMesh& mesh)
{
    std::vector<Eigen::AlignedBox3d> boxes;
    boxes.reserve(mesh.triangles->size());
    for (std::size_t i = 0; i < mesh.triangles->size(); ++i)
    {
        boxes.push_back(boxOf(mesh.corners(i)));
    }
    return BoxGrid(std::move(boxes));
}

Corners shifted(Corners corners, const Eigen::Vector3d& shift)
{
    for (Eigen::Vector3d& corner : corners)
    {
        corner += shift;
    }
    return corners;
}

/// Pairs of triangles whose crossing is at least `kind`, with the link moved by `shift`.
std::int64_t countCrossings(const PlacedMesh& link,
                            const PlacedMesh& object,
                            BoxGrid& grid,
                            const Eigen::Vector3d& shift,
                            Crossing kind)
{
    std::int64_t count = 0;
    std::vector<std::int32_t> found;
    for (std::size_t i = 0; i < link.triangles->size(); ++i)
    {
        const Corners corners = shifted(link.corners(i), shift);
        grid.query(boxOf(corners), found);
        count += std::count_if(
            found.begin(),
            found.end(),
            [&](std::int32_t j)
            { return crossing(corners, object.corners(static_cast<std::size_t>(j))) >= kind; });
    }
    return count;
}

/// Pairs of triangles that intersect. If none even touch, that is all; else the link must intersect
/// when moved by kShift and also when moved back by it: what only touches comes free one way.
std::int64_t countIntersections(const PlacedMesh& link, const PlacedMesh& object, BoxGrid& grid)
{
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    if (countCrossings(link, object, grid, zero, Crossing::Touching) == 0)
    {
        return 0;
    }
    return std::min(countCrossings(link, object, grid, kShift, Crossing::Proper),
                    countCrossings(link, object, grid, -kShift, Crossing::Proper));
}

/// Adds the points (mapped by `toSurface`) that the surface winds around; true if there are any.
bool addInside(const std::vector<Eigen::Vector3d>& points,
               const Eigen::Isometry3d& toSurface,
               const Eigen::AlignedBox3d& region,
               ClosedSurface& surface,
               PenetrationReport& report)
{
    const std::int64_t before = report.verticesInside;
    for (const Eigen::Vector3d& point : points)
    {
        const Eigen::Vector3d place = toSurface * point;
        if (!region.contains(point) || !surface.contains(place))
        {
            continue;
        }
        const double depth = surface.distance(place);
        if (depth > kTouching)
        {
            ++report.verticesInside;
            report.deepest = std::max(report.deepest, depth);
        }
    }
    return report.verticesInside > before;
}
/// A vertex of each set of triangles that hang together by common vertices.
std::vector<Eigen::Vector3d> vertexOfEachPart(const TriangleMesh& mesh)
{
    std::vector<std::size_t> joined(mesh.vertices.size());
    std::iota(joined.begin(), joined.end(), std::size_t{0});
    const auto partOf = [&](std::int32_t vertex)
    {
        auto part = static_cast<std::size_t>(vertex);
        while (joined[part] != part)
        {
            part = joined[part] = joined[joined[part]];
        }
        return part;
    };
    for (const Triangle& triangle : mesh.triangles)
    {
        joined[partOf(triangle[1])] = partOf(triangle[0]);
        joined[partOf(triangle[2])] = partOf(triangle[0]);
    }
    std::vector<bool> isUsed(joined.size(), false);
    std::vector<Eigen::Vector3d> vertices;
    for (const Triangle& triangle : mesh.triangles)
    {
        const std::size_t part = partOf(triangle[0]);
        if (!isUsed[part])
        {
            vertices.push_back(mesh.vertices[part]);
            isUsed[part] = true;
        }
    }
    return vertices;
}

bool anyInside(const std::vector<Eigen::Vector3d>& points,
               const Eigen::Isometry3d& toSurface,
               const Eigen::AlignedBox3d& region,
               ClosedSurface& surface)
{
    return std::any_of(points.begin(),
                       points.end(),
                       [&](const Eigen::Vector3d& point)
                       {
                           const Eigen::Vector3d place = toSurface * point;
                           return region.contains(place) && surface.contains(place);
                       });
}
}  // namespace

struct PenetrationCheck::Parts
{
    Parts(const HandModel& theHand, const GraspObject& theObject)
        : hand(theHand),
          object(theObject),
          placedObject(place(object.tree.mesh(), Eigen::Isometry3d::Identity())),
          grid(makeGrid(placedObject)),
          objectSurface(object.tree.mesh()),
          objectParts(vertexOfEachPart(object.tree.mesh()))
    {
        for (const TriangleMesh& mesh : hand.robot.linkMeshes)
        {
            links.push_back({.bounds = bullet_ccd::bounds(mesh), .parts = vertexOfEachPart(mesh)});
        }
    }

    /// What is known of a link in its own frame.
    struct Link
    {
        Eigen::AlignedBox3d bounds;
        std::vector<Eigen::Vector3d> parts;  ///< a vertex of each
        bool surfaceIsKnown = false;
        std::optional<ClosedSurface> surface = {};  ///< none if it is open or was not needed yet
    };

    const HandModel& hand;
    const GraspObject& object;
    PlacedMesh placedObject;
    BoxGrid grid;
    ClosedSurface objectSurface;
    std::vector<Eigen::Vector3d> objectParts;  ///< a vertex of each
    std::vector<Link> links;

    ClosedSurface* surfaceOf(std::size_t index)
    {
        Link& link = links[index];
        const TriangleMesh& mesh = hand.robot.linkMeshes[index];
        if (!link.surfaceIsKnown && isWatertight(mesh))
        {
            link.surface.emplace(mesh);
        }
        link.surfaceIsKnown = true;
        return link.surface ? &*link.surface : nullptr;
    }

    /// True if a part of the link is within the object, or a part of the object within the link.
    bool holds(std::size_t index, const Eigen::Isometry3d& X_WL)
    {
        const Link& link = links[index];
        if (object.watertight && anyInside(link.parts, X_WL, placedObject.bounds, objectSurface))
        {
            return true;
        }
        const Eigen::Isometry3d X_LW = X_WL.inverse();
        const auto isNear = [&](const Eigen::Vector3d& p)
        { return link.bounds.contains(X_LW * p); };
        if (std::none_of(objectParts.begin(), objectParts.end(), isNear))
        {
            return false;
        }
        ClosedSurface* surface = surfaceOf(index);
        return surface != nullptr && anyInside(objectParts, X_LW, link.bounds, *surface);
    }

    /// Adds what is wrong with the link at its pose; true if anything is.
    bool look(std::size_t index, const Eigen::Isometry3d& X_WL, PenetrationReport& report)
    {
        const TriangleMesh& mesh = hand.robot.linkMeshes[index];
        const PlacedMesh link = place(mesh, X_WL);
        if (mesh.triangles.empty() || !link.bounds.intersects(placedObject.bounds))
        {
            return false;
        }
        const std::int64_t crossings = countIntersections(link, placedObject, grid);
        report.intersectingTriangles += crossings;
        bool concerned = crossings > 0;
        if (object.watertight)
        {
            concerned |= addInside(link.vertices,
                                   Eigen::Isometry3d::Identity(),
                                   placedObject.bounds,
                                   objectSurface,
                                   report);
        }
        if (ClosedSurface* surface = surfaceOf(index); surface != nullptr)
        {
            concerned |=
                addInside(placedObject.vertices, X_WL.inverse(), link.bounds, *surface, report);
        }
        return concerned;
    }
};

PenetrationCheck::PenetrationCheck(const HandModel& hand, const GraspObject& object)
    : m_parts(std::make_unique<Parts>(hand, object))
{
}
PenetrationCheck::~PenetrationCheck() = default;
PenetrationCheck::PenetrationCheck(PenetrationCheck&&) noexcept = default;

PenetrationReport PenetrationCheck::at(const Eigen::Isometry3d& X_WH,
                                       const std::vector<double>& positions)
{
    const std::vector<Eigen::Isometry3d> poses =
        linkPoses(m_parts->hand.robot.tree, X_WH, positions);
    PenetrationReport report;
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        if (m_parts->look(i, poses[i], report) && report.link == kNone)
        {
            report.link = static_cast<std::int32_t>(i);
        }
    }
    return report;
}

bool PenetrationCheck::holdsInside(const Eigen::Isometry3d& X_WH,
                                   const std::vector<double>& positions)
{
    const std::vector<Eigen::Isometry3d> poses =
        linkPoses(m_parts->hand.robot.tree, X_WH, positions);
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        if (m_parts->holds(i, poses[i]))
        {
            return true;
        }
    }
    return false;
}

PenetrationReport checkPenetration(const HandModel& hand,
                                   const GraspObject& object,
                                   const Eigen::Isometry3d& X_WH,
                                   const std::vector<double>& positions)
{
    return PenetrationCheck(hand, object).at(X_WH, positions);
}
}  // namespace bullet_ccd::grasp
