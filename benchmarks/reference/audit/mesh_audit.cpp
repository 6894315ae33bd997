#include "benchmarks/reference/audit/mesh_audit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <numeric>

namespace bullet_ccd::reference
{
namespace
{
constexpr std::int32_t kLeafTriangles = 4;
constexpr int kEdgePoints = 9;
// Crossing triangles whose edges are looked at: what is deep has vertices inside.
constexpr std::size_t kEdgeCrossings = 64;

using Corners = std::array<Eigen::Vector3d, 3>;

Corners cornersIn(const TriangleMesh& mesh, std::int32_t triangle)
{
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k)
    {
        corners[k] = mesh.vertices[static_cast<std::size_t>(
            mesh.triangles[static_cast<std::size_t>(triangle)][k])];
    }
    return corners;
}

double squaredDistanceToSegment(const Eigen::Vector3d& p,
                                const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b)
{
    const Eigen::Vector3d edge = b - a;
    const double length = edge.squaredNorm();
    const double s = length > 0.0 ? std::clamp(edge.dot(p - a) / length, 0.0, 1.0) : 0.0;
    return (a + s * edge - p).squaredNorm();
}

double squaredDistanceToTriangle(const Eigen::Vector3d& p, const Corners& t)
{
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    bool above = normal.squaredNorm() > 0.0;
    for (std::size_t i = 0; i < 3 && above; ++i)
    {
        above = normal.cross(t[(i + 1) % 3] - t[i]).dot(p - t[i]) >= 0.0;
    }
    if (above)
    {
        const double height = normal.dot(p - t[0]);
        return height * height / normal.squaredNorm();
    }
    return std::min({squaredDistanceToSegment(p, t[0], t[1]),
                     squaredDistanceToSegment(p, t[1], t[2]),
                     squaredDistanceToSegment(p, t[2], t[0])});
}

/// Solid angle of a triangle seen from p, signed.
double solidAngle(const Eigen::Vector3d& p, const Corners& t)
{
    const Eigen::Vector3d a = t[0] - p;
    const Eigen::Vector3d b = t[1] - p;
    const Eigen::Vector3d c = t[2] - p;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    return 2.0 * std::atan2(a.dot(b.cross(c)),
                            la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

/// Axis-aligned box around a turned and moved box.
Eigen::AlignedBox3d boxAround(const Eigen::AlignedBox3d& box, const Eigen::Isometry3d& X)
{
    const Eigen::Vector3d center = X * box.center();
    const Eigen::Vector3d reach = X.linear().cwiseAbs() * (0.5 * box.sizes());
    // A grid point may lie half a grid outside, and the poses are rounded.
    const Eigen::Vector3d slack = Eigen::Vector3d::Constant(1e-10);
    return {center - reach - slack, center + reach + slack};
}

/// The pair in the frame of A.
struct Query
{
    const AuditMesh& a;
    const AuditMesh& b;
    Eigen::Isometry3d X_AB;
};

void crossLeaves(const Query& query,
                 const AuditMesh::Node& leafA,
                 const AuditMesh::Node& leafB,
                 std::vector<std::pair<std::int32_t, std::int32_t>>& crossings)
{
    for (std::int32_t i = leafB.first; i < leafB.first + leafB.count; ++i)
    {
        const std::int32_t triangleB = query.b.order()[static_cast<std::size_t>(i)];
        const GridTriangle cornersB = query.b.corners(triangleB, query.X_AB);
        for (std::int32_t k = leafA.first; k < leafA.first + leafA.count; ++k)
        {
            const std::int32_t triangleA = query.a.order()[static_cast<std::size_t>(k)];
            if (trianglesMeet(query.a.corners(triangleA), cornersB))
            {
                crossings.emplace_back(triangleA, triangleB);
            }
        }
    }
}

std::vector<std::pair<std::int32_t, std::int32_t>> findCrossings(const Query& query)
{
    std::vector<std::pair<std::int32_t, std::int32_t>> crossings;
    std::vector<std::pair<std::int32_t, std::int32_t>> open{{0, 0}};
    while (!open.empty())
    {
        const auto [indexA, indexB] = open.back();
        open.pop_back();
        const AuditMesh::Node& nodeA = query.a.nodes()[static_cast<std::size_t>(indexA)];
        const AuditMesh::Node& nodeB = query.b.nodes()[static_cast<std::size_t>(indexB)];
        if (!nodeA.box.intersects(boxAround(nodeB.box, query.X_AB)))
        {
            continue;
        }
        if (nodeA.count > 0 && nodeB.count > 0)
        {
            crossLeaves(query, nodeA, nodeB, crossings);
        }
        else if (nodeB.count > 0 ||
                 (nodeA.count == 0 && nodeA.box.sizes().norm() > nodeB.box.sizes().norm()))
        {
            open.emplace_back(nodeA.first, indexB);
            open.emplace_back(nodeA.first + 1, indexB);
        }
        else
        {
            open.emplace_back(indexA, nodeB.first);
            open.emplace_back(indexA, nodeB.first + 1);
        }
    }
    return crossings;
}

/// Takes the depth of a point of one solid, given in the frame of `other`, into account.
void addDepth(const AuditMesh& other,
              const Eigen::Vector3d& point,
              const Eigen::Isometry3d& X_WO,
              PairAudit& audit)
{
    if (!other.box().contains(point) || !other.contains(point))
    {
        return;
    }
    const double depth = other.distance(point);
    if (depth > audit.depth)
    {
        audit.depth = depth;
        audit.point_W = X_WO * point;
    }
}

/// Depth of the vertices of `a` in `b`.
void addVertices(const AuditMesh& a,
                 const AuditMesh& b,
                 const Eigen::Isometry3d& X_BA,
                 const Eigen::Isometry3d& X_WB,
                 PairAudit& audit)
{
    for (const Eigen::Vector3d& vertex : a.mesh().vertices)
    {
        addDepth(b, X_BA * vertex, X_WB, audit);
    }
}

void addEdges(const Corners& corners,
              const AuditMesh& other,
              const Eigen::Isometry3d& X_OT,
              const Eigen::Isometry3d& X_WO,
              PairAudit& audit)
{
    for (std::size_t i = 0; i < 3; ++i)
    {
        for (int k = 1; k <= kEdgePoints; ++k)
        {
            const double s = static_cast<double>(k) / (kEdgePoints + 1);
            addDepth(other,
                     X_OT * Eigen::Vector3d((1.0 - s) * corners[i] + s * corners[(i + 1) % 3]),
                     X_WO,
                     audit);
        }
    }
}
}  // namespace

AuditMesh::AuditMesh(TriangleMesh mesh)
    : m_mesh(std::move(mesh)), m_watertight(isWatertight(m_mesh))
{
    for (const Eigen::Vector3d& vertex : m_mesh.vertices)
    {
        m_grid.push_back(toGrid(vertex));
    }
    m_order.resize(m_mesh.triangles.size());
    std::iota(m_order.begin(), m_order.end(), 0);
    m_nodes.emplace_back();
    split(0, 0, static_cast<std::int32_t>(m_order.size()));
}

void AuditMesh::split(std::int32_t node, std::int32_t begin, std::int32_t end)
{
    Eigen::AlignedBox3d box;
    Eigen::AlignedBox3d centers;
    const auto center = [this](std::int32_t triangle) -> Eigen::Vector3d
    {
        const Corners c = cornersIn(m_mesh, triangle);
        return (c[0] + c[1] + c[2]) / 3.0;
    };
    for (std::int32_t i = begin; i < end; ++i)
    {
        const std::int32_t triangle = m_order[static_cast<std::size_t>(i)];
        for (const Eigen::Vector3d& corner : cornersIn(m_mesh, triangle))
        {
            box.extend(corner);
        }
        centers.extend(center(triangle));
    }
    m_nodes[static_cast<std::size_t>(node)].box = box;
    if (end - begin <= kLeafTriangles)
    {
        m_nodes[static_cast<std::size_t>(node)].first = begin;
        m_nodes[static_cast<std::size_t>(node)].count = end - begin;
        return;
    }
    Eigen::Index axis = 0;
    centers.sizes().maxCoeff(&axis);
    const std::int32_t middle = (begin + end) / 2;
    std::nth_element(m_order.begin() + begin,
                     m_order.begin() + middle,
                     m_order.begin() + end,
                     [&](std::int32_t a, std::int32_t b)
                     { return center(a)[axis] < center(b)[axis]; });
    const auto child = static_cast<std::int32_t>(m_nodes.size());
    m_nodes[static_cast<std::size_t>(node)].first = child;
    m_nodes.resize(m_nodes.size() + 2);
    split(child, begin, middle);
    split(child + 1, middle, end);
}

GridTriangle AuditMesh::corners(std::int32_t triangle) const
{
    const Triangle& t = m_mesh.triangles[static_cast<std::size_t>(triangle)];
    const auto at = [&](std::size_t k) { return m_grid[static_cast<std::size_t>(t[k])]; };
    return {at(0), at(1), at(2)};
}

GridTriangle AuditMesh::corners(std::int32_t triangle, const Eigen::Isometry3d& X) const
{
    const Corners c = cornersIn(m_mesh, triangle);
    return {toGrid(X * c[0]), toGrid(X * c[1]), toGrid(X * c[2])};
}

bool AuditMesh::contains(const Eigen::Vector3d& point) const
{
    if (!m_watertight)
    {
        return false;
    }
    double angle = 0.0;
    for (std::size_t i = 0; i < m_mesh.triangles.size(); ++i)
    {
        angle += solidAngle(point, cornersIn(m_mesh, static_cast<std::int32_t>(i)));
    }
    return std::abs(angle) > 2.0 * std::numbers::pi;
}

double AuditMesh::distance(const Eigen::Vector3d& point) const
{
    double squared = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < m_mesh.triangles.size(); ++i)
    {
        squared = std::min(
            squared,
            squaredDistanceToTriangle(point, cornersIn(m_mesh, static_cast<std::int32_t>(i))));
    }
    return std::sqrt(squared);
}

PairAudit auditPair(const AuditMesh& a,
                    const Eigen::Isometry3d& X_WA,
                    const AuditMesh& b,
                    const Eigen::Isometry3d& X_WB)
{
    if (b.box().sizes().squaredNorm() > a.box().sizes().squaredNorm())
    {
        // In the frame of the larger mesh: a box around a large turned triangle is mostly empty.
        return auditPair(b, X_WB, a, X_WA);
    }
    const Eigen::Isometry3d X_AB = X_WA.inverse() * X_WB;
    const Eigen::Isometry3d X_BA = X_AB.inverse();
    const auto crossings = findCrossings({a, b, X_AB});
    PairAudit audit;
    audit.crossings = static_cast<std::int64_t>(crossings.size());
    if (crossings.empty())
    {
        // Surfaces that do not meet: all of one is inside the other, or nothing is.
        const Eigen::Vector3d inB = X_BA * a.mesh().vertices.front();
        const Eigen::Vector3d inA = X_AB * b.mesh().vertices.front();
        audit.contained = (b.box().contains(inB) && b.contains(inB)) ||
                          (a.box().contains(inA) && a.contains(inA));
        if (!audit.contained)
        {
            return audit;
        }
    }
    else
    {
        audit.point_W = X_WA * cornersIn(a.mesh(), crossings.front().first).front();
    }
    addVertices(a, b, X_BA, X_WB, audit);
    addVertices(b, a, X_AB, X_WA, audit);
    for (std::size_t i = 0; i < std::min(crossings.size(), kEdgeCrossings); ++i)
    {
        addEdges(cornersIn(a.mesh(), crossings[i].first), b, X_BA, X_WB, audit);
        addEdges(cornersIn(b.mesh(), crossings[i].second), a, X_AB, X_WA, audit);
    }
    return audit;
}

void AuditResult::add(const AuditResult& other)
{
    poses += other.poses;
    pairs += other.pairs;
    if (!other.clean() && (clean() || other.worst.depth > worst.depth))
    {
        worst = other.worst;
        bodyA = other.bodyA;
        bodyB = other.bodyB;
        time = other.time;
    }
    intersecting += other.intersecting;
}

AuditResult auditPoses(const AuditScene& scene,
                       const BodyPoses& X_WB,
                       double time,
                       const std::vector<std::int32_t>& only)
{
    const auto isWanted = [&](std::int32_t a, std::int32_t b)
    {
        const auto fixed = [&](std::int32_t body)
        { return scene.fixed[static_cast<std::size_t>(body)]; };
        const auto asked = [&](std::int32_t body)
        { return only.empty() || std::ranges::find(only, body) != only.end(); };
        return a != b && (!fixed(a) || !fixed(b)) && (asked(a) || asked(b)) &&
               !scene.ignored.contains({a, b});
    };
    std::vector<Eigen::Isometry3d> X_WM;
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const AuditPart& part : scene.parts)
    {
        X_WM.push_back(X_WB[static_cast<std::size_t>(part.body)] * part.X_BM);
        boxes.push_back(boxAround(part.mesh->box(), X_WM.back()));
    }
    std::vector<std::size_t> order(boxes.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(),
              order.end(),
              [&](std::size_t a, std::size_t b)
              { return boxes[a].min().x() < boxes[b].min().x(); });

    AuditResult result;
    result.poses = 1;
    for (std::size_t i = 0; i < order.size(); ++i)
    {
        for (std::size_t k = i + 1;
             k < order.size() && boxes[order[k]].min().x() <= boxes[order[i]].max().x();
             ++k)
        {
            const std::size_t a = std::min(order[i], order[k]);
            const std::size_t b = std::max(order[i], order[k]);
            const auto [bodyA, bodyB] = std::minmax(scene.parts[a].body, scene.parts[b].body);
            if (!boxes[a].intersects(boxes[b]) || !isWanted(bodyA, bodyB))
            {
                continue;
            }
            AuditResult pair;
            pair.pairs = 1;
            pair.worst = auditPair(*scene.parts[a].mesh, X_WM[a], *scene.parts[b].mesh, X_WM[b]);
            pair.intersecting = pair.worst.clean() ? 0 : 1;
            pair.bodyA = bodyA;
            pair.bodyB = bodyB;
            pair.time = time;
            result.add(pair);
        }
    }
    return result;
}

Eigen::Isometry3d betweenPoses(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double s)
{
    const Eigen::AngleAxisd turn(Eigen::Quaterniond(to.linear() * from.linear().transpose()));
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = Eigen::AngleAxisd(s * turn.angle(), turn.axis()) * from.linear();
    X.translation() = (1.0 - s) * from.translation() + s * to.translation();
    return X;
}

std::string describe(const AuditResult& result, std::span<const std::string> names)
{
    std::array<char, 256> text{};
    std::snprintf(text.data(),
                  text.size(),
                  "%s and %s are %.2e m inside each other at %.4f s near (%.4f, %.4f, %.4f)",
                  names[static_cast<std::size_t>(result.bodyA)].c_str(),
                  names[static_cast<std::size_t>(result.bodyB)].c_str(),
                  result.worst.depth,
                  result.time,
                  result.worst.point_W.x(),
                  result.worst.point_W.y(),
                  result.worst.point_W.z());
    return text.data();
}
}  // namespace bullet_ccd::reference
