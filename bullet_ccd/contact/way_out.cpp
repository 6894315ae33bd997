#include "bullet_ccd/contact/way_out.h"

#include <algorithm>

namespace bullet_ccd
{
namespace
{
constexpr int kRefinements = 12;
/// Short ways that are tried in turn: the first one, of the shell, and how each follows another.
constexpr double kShortest = 1.0 / 64.0;
constexpr double kFineStep = 1.1;
/// Cosine of the angle between directions that are worth trying both.
constexpr double kOtherDirection = 0.9;
constexpr std::size_t kMostDirections = 12;
/// Out the way that the two came, if that is not farther than it was by so many shells.
constexpr double kSameWay = 8.0;
constexpr double kPreferred = 4.0;

constexpr double kBeside = 1e-6;
constexpr double kOnEdge = 1e-2;

const Eigen::Vector3d& cornerOf(const TriangleMesh& mesh, const Triangle& t, std::size_t k)
{
    return mesh.vertices[std::size_t(t[k % 3])];
}

/// Unit; zero for a triangle without an area.
Eigen::Vector3d normalOf(const TriangleMesh& mesh, std::int32_t triangle)
{
    const Triangle& t = mesh.triangles[std::size_t(triangle)];
    const Eigen::Vector3d normal = (cornerOf(mesh, t, 1) - cornerOf(mesh, t, 0))
                                       .cross(cornerOf(mesh, t, 2) - cornerOf(mesh, t, 0));
    return normal.stableNormalized();
}

/// Cosine of the angle between the normal of a triangle and a direction.
double slopeOf(const TriangleMesh& mesh, std::int32_t triangle, const Eigen::Vector3d& direction)
{
    return normalOf(mesh, triangle).dot(direction);
}

/// True if something that is nearest to a point of a triangle, in the direction, is inside.
bool isInsideOf(const PosedSolid& solid,
                const Eigen::Vector3d& direction_W,
                const Eigen::Vector3d& point_W,
                std::int32_t triangle)
{
    if (!solid.isSolid)
    {
        return false;
    }
    const TriangleMesh& mesh = solid.tree->mesh();
    const Eigen::Vector3d direction =
        solid.X_W.linear().transpose() * direction_W.stableNormalized();
    if (!(slopeOf(mesh, triangle, direction) < -kBeside))
    {
        return false;
    }
    // At a sharp edge or corner it is outside if it is above any of the triangles there.
    const Triangle& nearest = mesh.triangles[std::size_t(triangle)];
    const Eigen::Vector3d point = solid.X_W.inverse() * point_W;
    Triangle feature{kNone, kNone, kNone};
    for (std::size_t k = 0; k < 3; ++k)
    {
        // Not on the edge across from the corner, which rounding does not tell well.
        const Eigen::Vector3d& base = cornerOf(mesh, nearest, k + 1);
        const Eigen::Vector3d across = cornerOf(mesh, nearest, k + 2) - base;
        const Eigen::Vector3d to = cornerOf(mesh, nearest, k) - base;
        const Eigen::Vector3d up = to - across * (to.dot(across) / across.squaredNorm());
        const double part = up.dot(point - base) / up.squaredNorm();
        feature[k] = part > kOnEdge ? nearest[k] : kNone;
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const Triangle& other = mesh.triangles[i];
        const bool meetsThere = std::ranges::all_of(
            feature,
            [&](std::int32_t corner)
            { return corner == kNone || std::ranges::count(other, corner) > 0; });
        if (meetsThere && slopeOf(mesh, std::int32_t(i), direction) > kBeside)
        {
            return false;
        }
    }
    return true;
}
}  // namespace

bool hasInside(const TriangleMesh& mesh)
{
    double volume = 0.0;
    const Eigen::Vector3d& origin = mesh.vertices.front();
    for (const Triangle& t : mesh.triangles)
    {
        const auto corner = [&](std::size_t k) -> Eigen::Vector3d
        { return mesh.vertices[std::size_t(t[k])] - origin; };
        volume += corner(0).dot(corner(1).cross(corner(2)));
    }
    return volume > 0.0 && isWatertight(mesh);
}

WayOut::WayOut(const PosedSolid& a, const PosedSolid& b, double shell)
    : m_a(a),
      m_b(b),
      m_shell(shell),
      m_limit((isKnown() ? 2.0 : 1.0) * std::min(a.tree->radius(), b.tree->radius())),
      m_farthest(isKnown() ? m_limit : 0.0)
{
}

void WayOut::look(const Eigen::Vector3d& normal)
{
    double way = m_shell;
    double distance = distanceAt(normal, way);
    while (distance < kApart * m_shell && way < m_limit)
    {
        way = std::min(2.0 * way, m_limit);
        distance = distanceAt(normal, way);
    }
    if (distance < kApart * m_shell || way > m_limit || (way == m_limit && isFound()))
    {
        return;
    }
    for (int i = 0; i < kRefinements && distance > m_shell; ++i)
    {
        way -= distance - 0.5 * m_shell;
        distance = distanceAt(normal, way);
    }
    m_way = m_limit = way;
    m_normal = normal;
}

void WayOut::lookNear(std::span<const Contact> contacts)
{
    std::vector<Eigen::Vector3d> normals;
    std::vector<Eigen::Vector3d> ofA;
    std::vector<Eigen::Vector3d> ofB;
    const auto add = [](std::vector<Eigen::Vector3d>& several, const Eigen::Vector3d& normal)
    {
        const auto isLike = [&](const Eigen::Vector3d& other)
        { return normal.dot(other) > kOtherDirection; };
        if (!normal.isZero() && std::ranges::none_of(several, isLike))
        {
            several.push_back(normal);
        }
    };
    for (const Contact& contact : contacts)
    {
        add(normals, contact.normal);
        add(ofA, m_a.X_W.linear() * normalOf(m_a.tree->mesh(), contact.triangleA));
        add(ofB, -(m_b.X_W.linear() * normalOf(m_b.tree->mesh(), contact.triangleB)));
    }
    for (const std::vector<Eigen::Vector3d>* several : {&normals, &ofA, &ofB})
    {
        Eigen::Vector3d between = Eigen::Vector3d::Zero();
        for (const Eigen::Vector3d& normal : *several)
        {
            lookNear(normal);
            between += normal;
        }
        if (several->size() > 1 && between.norm() > kOnEdge)
        {
            lookNear(between.normalized());
        }
    }
}

/// The first gap on the way: as soon as it is wide enough, or where it is widest.
void WayOut::lookNear(const Eigen::Vector3d& normal)
{
    double widest = 0.0;
    double wayOfWidest = 0.0;
    const double limit = std::min(kShort * m_shell, m_limit);
    for (double way = kShortest * m_shell; way < limit && widest < kApart * m_shell;
         way *= kFineStep)
    {
        const double distance = distanceAt(normal, way);
        if (distance < widest)
        {
            break;
        }
        widest = distance;
        wayOfWidest = way;
    }
    if (widest > 0.0)
    {
        m_way = m_limit = wayOfWidest;
        m_normal = normal;
    }
}

void WayOut::lookAlong(std::span<const Contact> contacts,
                       const Eigen::Vector3d& former,
                       double formerWay)
{
    std::vector<Eigen::Vector3d> tried;
    const auto tryOut = [&](const Eigen::Vector3d& normal)
    {
        const auto isLike = [&](const Eigen::Vector3d& other)
        { return normal.dot(other) > kOtherDirection; };
        if (tried.size() < kMostDirections && std::ranges::none_of(tried, isLike))
        {
            tried.push_back(normal);
            look(normal);
        }
    };
    const auto tryFace = [&](const PosedSolid& solid, std::int32_t triangle, double side)
    {
        const Eigen::Vector3d normal = normalOf(solid.tree->mesh(), triangle);
        if (!normal.isZero())
        {
            tryOut(side * (solid.X_W.linear() * normal));
        }
    };
    if (!former.isZero())
    {
        tryOut(former);
        if (isFound() && m_way <= formerWay + kSameWay * m_shell)
        {
            return;
        }
        prefer(isFound() ? kPreferred : 1.0);
    }
    // What meets on several sides comes out of all of them between the normals.
    Eigen::Vector3d between = Eigen::Vector3d::Zero();
    for (const Contact& contact : contacts)
    {
        between += contact.normal;
    }
    if (between.norm() > kBeside)
    {
        tryOut(between.normalized());
    }
    for (const Contact& contact : contacts)
    {
        tryOut(contact.normal);
        if (isKnown())
        {
            tryOut(-contact.normal);  // more than halfway inside
        }
    }
    // Edges that pierce one face may end in another, which is the nearer way out.
    for (const Contact& contact : contacts)
    {
        tryFace(m_a, contact.triangleA, 1.0);
        tryFace(m_b, contact.triangleB, -1.0);
    }
}

void WayOut::comeBack(const Eigen::Vector3d& normal, double formerWay)
{
    double way = formerWay + kSameWay * m_shell;
    double distance = distanceAt(normal, way);
    if (distance < kApart * m_shell)
    {
        return;
    }
    for (int i = 0; i < kRefinements && distance > m_shell && way > 0.0; ++i)
    {
        way -= distance - 0.5 * m_shell;
        distance = way > 0.0 ? distanceAt(normal, way) : 0.0;
    }
    if (way > 0.0)
    {
        m_way = m_limit = way;
        m_normal = normal;
    }
}

void WayOut::takeBack(std::vector<Contact>& contacts, std::size_t first, double around) const
{
    const auto begin = contacts.begin() + std::ptrdiff_t(first);
    for (auto contact = begin; contact != contacts.end(); ++contact)
    {
        contact->pointA += m_way * m_normal;
        contact->gap -= m_way * contact->normal.dot(m_normal);
    }
    const auto isFar = [&](const Contact& contact) { return contact.gap > around; };
    contacts.erase(std::remove_if(begin, contacts.end(), isFar), contacts.end());
}

Eigen::Vector3d WayOut::nearestOut() const
{
    const TrianglePair nearest = nearestOf(m_a.X_W, m_limit);
    if (!isInside(nearest, m_a.X_W))
    {
        return Eigen::Vector3d::Zero();
    }
    return m_b.X_W.linear() * (nearest.pointA - nearest.pointB).normalized();
}

Eigen::Isometry3d WayOut::moved(const Eigen::Vector3d& normal, double way) const
{
    Eigen::Isometry3d pose = m_a.X_W;
    pose.translation() -= way * normal;
    return pose;
}

TrianglePair WayOut::nearestOf(const Eigen::Isometry3d& X_WA, double bound) const
{
    return treeDistance(*m_a.tree, *m_b.tree, m_b.X_W.inverse() * X_WA, bound);
}

bool WayOut::isInside(const TrianglePair& nearest, const Eigen::Isometry3d& X_WA) const
{
    if (nearest.triangleA == kNone)
    {
        return false;
    }
    const Eigen::Vector3d onA = m_b.X_W * nearest.pointA;
    const Eigen::Vector3d onB = m_b.X_W * nearest.pointB;
    return isInsideOf(m_b, onA - onB, onB, nearest.triangleB) ||
           isInsideOf({m_a.tree, X_WA, m_a.isSolid}, onB - onA, onA, nearest.triangleA);
}

/// Far away does not matter, where nothing is solid; 0 where one is inside the other.
double WayOut::distanceAt(const Eigen::Vector3d& normal, double way) const
{
    const Eigen::Isometry3d X_WA = moved(normal, way);
    const TrianglePair nearest = nearestOf(X_WA, std::max(way + 2.0 * m_shell, m_farthest));
    return isInside(nearest, X_WA) ? 0.0 : nearest.distance;
}
}  // namespace bullet_ccd
