#include "bullet_ccd/contact/rigid_contacts.h"

#include "bullet_ccd/contact/near_surface.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Cosine of 0.1 rad: how far a point may be from the nearest on its own surface, see the header.
constexpr double kNearest = 0.995;
/// Gap, relative to the larger body, below which its direction says nothing.
constexpr double kTouchingGap = 1e-9;

using FeaturePair = std::pair<Feature, Feature>;

/// Weights of the corners of a triangle at a point of its edge from corner k to the next.
std::array<double, 3> edgeWeights(std::size_t k, double s)
{
    std::array<double, 3> weights{};
    weights[k] = 1.0 - s;
    weights[(k + 1) % 3] = s;
    return weights;
}

bool isInside(double s)
{
    return s > kOnBoundary && s < 1.0 - kOnBoundary;
}

bool contains(const Feature& larger, const Feature& smaller)
{
    return std::all_of(smaller.vertices.begin(),
                       smaller.vertices.end(),
                       [&](std::int32_t v)
                       {
                           return v == kNone ||
                                  std::find(larger.vertices.begin(), larger.vertices.end(), v) !=
                                      larger.vertices.end();
                       });
}

/// Two surfaces near each other in the frame F, the tree's of B.
class Contacts
{
public:
    struct Scene
    {
        const SsvTree& treeA;
        const SsvTree& treeB;
        Isometry3d X_FA;  ///< tree's frame of A
        double threshold;
        double rounding;  ///< of a distance
        double size;      ///< of the larger body
    };

    Contacts(const Scene& scene, const std::vector<TrianglePair>& pairs)
        : m_a(scene.treeA, scene.X_FA, trianglesOf(pairs, &TrianglePair::triangleA)),
          m_b(scene.treeB, Isometry3d::Identity(), trianglesOf(pairs, &TrianglePair::triangleB)),
          m_scene(scene)
    {
        for (const TrianglePair& pair : pairs)
        {
            const std::size_t i = m_a.indexOf(pair.triangleA);
            const std::size_t j = m_b.indexOf(pair.triangleB);
            offerCorners(i, j);
            offerEdges(i, j);
            if (pair.distance <= 0.0)
            {
                offerPierced(i, j);
            }
        }
    }

    /// Those that the header promises, without order.
    [[nodiscard]] std::vector<FeatureContact> all() const
    {
        std::vector<FeatureContact> contacts;
        for (const auto& [features, contact] : m_found)
        {
            if (boundsPatch(contact) && !isPassedOver(contact) && isNearest(contact))
            {
                contacts.push_back(contact);
                contacts.back().normal = normalOf(contact);
            }
        }
        return contacts;
    }

    /// The closest points of two triangles, whatever features they are on.
    [[nodiscard]] FeatureContact contactOf(const TrianglePair& pair) const
    {
        const std::size_t i = m_a.indexOf(pair.triangleA);
        const std::size_t j = m_b.indexOf(pair.triangleB);
        const Vector3d& origin = m_scene.treeB.origin();
        FeatureContact contact{.triangleA = pair.triangleA,
                               .triangleB = pair.triangleB,
                               .pointA = pair.pointA - origin,
                               .pointB = pair.pointB - origin,
                               .gap = pair.distance};
        contact.featureA =
            m_a.feature(i, closestOnTriangle(contact.pointA, m_a.corners(i)).weights);
        contact.featureB =
            m_b.feature(j, closestOnTriangle(contact.pointB, m_b.corners(j)).weights);
        contact.normal = normalOf(contact);
        return contact;
    }

private:
    static std::vector<std::int32_t> trianglesOf(const std::vector<TrianglePair>& pairs,
                                                 std::int32_t TrianglePair::*side)
    {
        std::vector<std::int32_t> triangles;
        for (const TrianglePair& pair : pairs)
        {
            triangles.push_back(pair.*side);
        }
        return triangles;
    }

    /// One of the triangles of either body and a point of it.
    struct Spot
    {
        std::size_t triangle = 0;
        std::array<double, 3> weights{};
        Vector3d point = Vector3d::Zero();
    };

    void offer(const Spot& a, const Spot& b)
    {
        const double gap = (b.point - a.point).norm();
        if (gap > m_scene.threshold + m_scene.rounding)
        {
            return;
        }
        const FeaturePair features(m_a.feature(a.triangle, a.weights),
                                   m_b.feature(b.triangle, b.weights));
        const auto [at, isNew] = m_found.try_emplace(features);
        FeatureContact& contact = at->second;
        if (isNew)
        {
            contact.featureA = features.first;
            contact.featureB = features.second;
            contact.triangleA = m_a.meshTriangle(a.triangle);
            contact.triangleB = m_b.meshTriangle(b.triangle);
        }
        if (isNew || gap < contact.gap)
        {
            contact.pointA = a.point;
            contact.pointB = b.point;
            contact.gap = gap;
        }
    }

    /// Corners of each triangle and the closest points of the other.
    void offerCorners(std::size_t i, std::size_t j)
    {
        const TriangleCorners& a = m_a.corners(i);
        const TriangleCorners& b = m_b.corners(j);
        for (std::size_t k = 0; k < 3; ++k)
        {
            const ClosestOnTriangle onB = closestOnTriangle(a[k], b);
            offer({i, edgeWeights(k, 0.0), a[k]}, {j, onB.weights, onB.point});
            const ClosestOnTriangle onA = closestOnTriangle(b[k], a);
            offer({i, onA.weights, onA.point}, {j, edgeWeights(k, 0.0), b[k]});
        }
    }

    /// Edges that pass each other. The ends of parallel ones are corners near an edge.
    void offerEdges(std::size_t i, std::size_t j)
    {
        const TriangleCorners& a = m_a.corners(i);
        const TriangleCorners& b = m_b.corners(j);
        for (std::size_t k = 0; k < 3; ++k)
        {
            const Vector3d u = a[(k + 1) % 3] - a[k];
            for (std::size_t l = 0; l < 3; ++l)
            {
                const Vector3d v = b[(l + 1) % 3] - b[l];
                const Vector3d n = u.cross(v);
                const double parallel = kOnBoundary * kOnBoundary * u.squaredNorm();
                if (n.squaredNorm() <= parallel * v.squaredNorm())
                {
                    continue;
                }
                // The projections afterwards make the error of almost parallel edges one along
                // them, which hardly changes the distance.
                double s = (b[l] - a[k]).cross(v).dot(n) / n.squaredNorm();
                const double t = v.dot(a[k] + s * u - b[l]) / v.squaredNorm();
                s = u.dot(b[l] + t * v - a[k]) / u.squaredNorm();
                if (isInside(s) && isInside(t))
                {
                    offer({i, edgeWeights(k, s), a[k] + s * u},
                          {j, edgeWeights(l, t), b[l] + t * v});
                }
            }
        }
    }

    /// Edges of each triangle that pass through the inside of the other.
    void offerPierced(std::size_t i, std::size_t j)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto [edgeA, onB] = pierced(i, m_a, k, m_b.corners(j));
            if (edgeA.triangle != kNowhere)
            {
                offer(edgeA, {j, onB.weights, edgeA.point});
            }
            const auto [edgeB, onA] = pierced(j, m_b, k, m_a.corners(i));
            if (edgeB.triangle != kNowhere)
            {
                offer({i, onA.weights, edgeB.point}, edgeB);
            }
        }
    }

    /// Where edge k of a triangle passes through a face; the spot's triangle is kNowhere if not.
    static std::pair<Spot, ClosestOnTriangle> pierced(std::size_t triangle,
                                                      const NearSurface& surface,
                                                      std::size_t k,
                                                      const TriangleCorners& face)
    {
        const Vector3d& p = surface.corners(triangle)[k];
        const Vector3d& q = surface.corners(triangle)[(k + 1) % 3];
        const Vector3d normal = unitNormal(face);
        const double heightP = normal.dot(p - face[0]);
        const double heightQ = normal.dot(q - face[0]);
        std::pair<Spot, ClosestOnTriangle> result;
        result.first.triangle = kNowhere;
        if (heightP * heightQ < 0.0)
        {
            const double s = heightP / (heightP - heightQ);
            const Vector3d through = p + s * (q - p);
            result.second = closestOnTriangle(through, face);
            const auto& weights = result.second.weights;
            if (isInside(s) && *std::min_element(weights.begin(), weights.end()) > kOnBoundary)
            {
                result.first = {triangle, edgeWeights(k, s), through};
            }
        }
        return result;
    }

    /// Nothing inside a flat part bounds a patch: a corner does, and edges that cross.
    [[nodiscard]] bool boundsPatch(const FeatureContact& c) const
    {
        const double offPlane = 0.01 * m_scene.threshold + m_scene.rounding;
        const FeatureKind kindA = c.featureA.kind;
        const FeatureKind kindB = c.featureB.kind;
        const bool sharpA = kindA <= kindB && !m_a.isFlat(c.featureA, offPlane);
        const bool sharpB = kindB <= kindA && !m_b.isFlat(c.featureB, offPlane);
        const bool edges = kindA == FeatureKind::Edge && kindB == FeatureKind::Edge;
        return edges ? sharpA && sharpB : sharpA || sharpB;
    }

    /// True for a vertex and the rim of a face or edge over the inside of which it stands.
    [[nodiscard]] bool isPassedOver(const FeatureContact& c) const
    {
        const Feature& a = c.featureA;
        const Feature& b = c.featureB;
        return (a.kind == FeatureKind::Vertex && anyAround(m_b,
                                                           b,
                                                           [&](const Feature& f) {
                                                               return m_found.contains({a, f});
                                                           })) ||
               (b.kind == FeatureKind::Vertex && anyAround(m_a,
                                                           a,
                                                           [&](const Feature& f) {
                                                               return m_found.contains({f, b});
                                                           }));
    }

    /// True if `test` holds for an edge or face with `feature` in its boundary.
    template <class Test>
    static bool anyAround(const NearSurface& surface, const Feature& feature, Test test)
    {
        constexpr std::array<std::array<double, 3>, 4> kInside{
            {{1.0, 1.0, 0.0}, {0.0, 1.0, 1.0}, {1.0, 0.0, 1.0}, {1.0, 1.0, 1.0}}};
        for (const std::size_t i : surface.around(feature))
        {
            for (const auto& weights : kInside)
            {
                const Feature larger = surface.feature(i, weights);
                if (larger.kind > feature.kind && contains(larger, feature) && test(larger))
                {
                    return true;
                }
            }
        }
        return false;
    }

    [[nodiscard]] bool isNearest(const FeatureContact& c) const
    {
        const double least = kNearest * c.gap - m_scene.rounding;
        const auto allBeyond =
            [&](const NearSurface& surface, const Feature& feature, const Vector3d& point)
        {
            const std::vector<std::size_t> around = surface.around(feature);
            return std::all_of(
                around.begin(),
                around.end(),
                [&](std::size_t i)
                { return closestOnTriangle(point, surface.corners(i)).distance >= least; });
        };
        return allBeyond(m_a, c.featureA, c.pointB) && allBeyond(m_b, c.featureB, c.pointA);
    }

    [[nodiscard]] Vector3d normalOf(const FeatureContact& c) const
    {
        if (c.gap > kTouchingGap * m_scene.size)
        {
            return (c.pointB - c.pointA).normalized();
        }
        if (c.featureB.kind == FeatureKind::Face)
        {
            return -m_b.normal(m_b.indexOf(c.triangleB));
        }
        if (c.featureA.kind == FeatureKind::Face)
        {
            return m_a.normal(m_a.indexOf(c.triangleA));
        }
        // Out of A and into B, at right angles to the edges.
        Vector3d normal = m_a.meanNormal(c.featureA) - m_b.meanNormal(c.featureB);
        const Vector3d edgeA = m_a.edgeDirection(c.featureA);
        const Vector3d edgeB = m_b.edgeDirection(c.featureB);
        const Vector3d across = edgeA.cross(edgeB);
        if (across.norm() > kOnBoundary)
        {
            return across.normalized() * (across.dot(normal) < 0.0 ? -1.0 : 1.0);
        }
        const Vector3d edge = edgeA.isZero(0.0) ? edgeB : edgeA;
        normal -= edge.dot(normal) * edge;
        if (normal.norm() > kOnBoundary)
        {
            return normal.normalized();
        }
        return edge.isZero(0.0) ? Vector3d(Vector3d::UnitZ()) : Vector3d(edge.unitOrthogonal());
    }

    static constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

    NearSurface m_a;
    NearSurface m_b;
    Scene m_scene;
    std::map<FeaturePair, FeatureContact> m_found;  ///< closest points of each, in F
};
}  // namespace

std::vector<FeatureContact> contactsAt(const RigidBody& bodyA,
                                       const RigidBody& bodyB,
                                       double time,
                                       double threshold)
{
    require(threshold >= 0.0 && std::isfinite(threshold),
            "contacts: the threshold must not be negative and must be finite");
    require(std::isfinite(time), "contacts: the time must be finite");
    const SsvTree& treeA = *bodyA.tree;
    const SsvTree& treeB = *bodyB.tree;
    const Isometry3d X_WA = geometryPoseAt(movingBody(bodyA), time);
    const Isometry3d X_WB = geometryPoseAt(movingBody(bodyB), time);
    require(X_WA.matrix().allFinite() && X_WB.matrix().allFinite(),
            "contacts: a pose is NaN or infinite");
    const Isometry3d X_BA = X_WB.inverse() * X_WA;
    Isometry3d X_FA = X_BA;
    X_FA.translation() = X_BA * treeA.origin() - treeB.origin();
    const double largest = std::max({treeA.radius() + treeA.origin().norm(),
                                     treeB.radius() + treeB.origin().norm(),
                                     X_WA.translation().norm(),
                                     X_WB.translation().norm()});
    const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * largest;
    std::vector<TrianglePair> pairs;
    trianglePairsWithin(treeA, treeB, X_BA, threshold + rounding, pairs);
    if (pairs.empty())
    {
        return {};
    }
    const Contacts found({.treeA = treeA,
                          .treeB = treeB,
                          .X_FA = X_FA,
                          .threshold = threshold,
                          .rounding = rounding,
                          .size = std::max(treeA.radius(), treeB.radius())},
                         pairs);
    std::vector<FeatureContact> contacts = found.all();
    if (contacts.empty())
    {
        // Rounding can put the nearest features just outside all rules; the bodies are in contact.
        contacts.push_back(found.contactOf(*std::min_element(
            pairs.begin(),
            pairs.end(),
            [](const TrianglePair& x, const TrianglePair& y) { return x.distance < y.distance; })));
    }
    std::sort(contacts.begin(),
              contacts.end(),
              [](const FeatureContact& x, const FeatureContact& y) {
                  return std::tie(x.gap, x.featureA, x.featureB) <
                         std::tie(y.gap, y.featureA, y.featureB);
              });
    for (FeatureContact& contact : contacts)
    {
        contact.pointA = X_WB * (contact.pointA + treeB.origin());
        contact.pointB = X_WB * (contact.pointB + treeB.origin());
        contact.normal = X_WB.linear() * contact.normal;
    }
    return contacts;
}
}  // namespace bullet_ccd
