#include "bullet_ccd/contact/contact_search.h"
#include "bullet_ccd/contact/contacts.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Gap, relative to the larger body, below which its direction says nothing.
constexpr double kTouchingGap = 1e-9;

/// Weights of the corners at a point of a triangle in slot i, of its longest edge if it has no
/// area.
std::array<double, 3> weightsAt(const ContactSurface& surface, std::int32_t i, const Vector3d& x)
{
    const auto c = surface.corners(i);
    const Vector3d& normal = surface.slot(i).normal;
    std::array<double, 3> weights{};
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const std::size_t l = (k + 1) % 3;
        const Vector3d edge = c[l] - c[k];
        if (!normal.isZero(0.0))
        {
            const double twiceArea = (c[1] - c[0]).cross(c[2] - c[0]).dot(normal);
            weights[(l + 1) % 3] = edge.cross(x - c[k]).dot(normal) / twiceArea;
        }
        else if (k == 0 || edge.squaredNorm() > longest)
        {
            longest = edge.squaredNorm();
            const double s = longest > 0.0 ? edge.dot(x - c[k]) / longest : 0.0;
            weights = {};
            weights[k] = 1.0 - s;
            weights[l] = s;
        }
    }
    return weights;
}

/// The feature of a triangle inside of which a point of it lies, in the tree's frame.
Feature featureAt(const ContactSurface& surface, std::int32_t i, const Vector3d& point)
{
    const std::array<double, 3> weights = weightsAt(surface, i, point);
    std::array<std::int32_t, 3> vertices{};
    auto end = vertices.begin();
    for (std::size_t k = 0; k < 3; ++k)
    {
        if (weights[k] > kOnBoundary)
        {
            *end++ = surface.meshVertex(surface.slot(i).vertices[k]);
        }
    }
    std::sort(vertices.begin(), end);
    end = std::unique(vertices.begin(), end);
    std::fill(end, vertices.end(), kNone);
    return {.kind = FeatureKind(end - vertices.begin() - 1), .vertices = vertices};
}

/// Mean normal of the surface around a vertex or an edge, unit, in the tree's frame; zero if the
/// normals cancel.
Vector3d meanNormal(const ContactSurface& surface, const Feature& feature)
{
    Vector3d sum = Vector3d::Zero();
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(surface.slots().size()); ++i)
    {
        int count = 0;
        std::size_t at = 0;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto& all = feature.vertices;
            const std::int32_t vertex = surface.meshVertex(surface.slot(i).vertices[k]);
            if (std::find(all.begin(), all.end(), vertex) != all.end())
            {
                ++count;
                at = k;
            }
        }
        if (count > static_cast<int>(feature.kind))
        {
            // By the angle of the triangle at a vertex: the same however its faces are cut.
            const auto c = surface.corners(i);
            const Vector3d u = c[(at + 1) % 3] - c[at];
            const Vector3d v = c[(at + 2) % 3] - c[at];
            const bool isVertex = feature.kind == FeatureKind::Vertex;
            const double weight = isVertex ? std::atan2(u.cross(v).norm(), u.dot(v)) : 1.0;
            sum += weight * surface.slot(i).normal;
        }
    }
    return sum.norm() > kOnBoundary ? Vector3d(sum.normalized()) : Vector3d::Zero();
}

/// Where a vertex touches a vertex or an edge: out of A and into B, at right angles to the edge. In
/// F; `found` for others, which have a normal of their own.
Vector3d touchingNormal(const FeatureContact& c, const NearFeatures& near, const Vector3d& found)
{
    const bool hasVertex =
        c.featureA.kind == FeatureKind::Vertex || c.featureB.kind == FeatureKind::Vertex;
    const bool hasFace =
        c.featureA.kind == FeatureKind::Face || c.featureB.kind == FeatureKind::Face;
    if (!hasVertex || hasFace)
    {
        return found;
    }
    const Matrix3d& R_FA = near.poses.R_FA;
    Vector3d normal = R_FA * meanNormal(near.a, c.featureA) - meanNormal(near.b, c.featureB);
    const auto straighten = [&](const Feature& feature, const TriangleMesh& mesh, const Matrix3d& R)
    {
        if (feature.kind == FeatureKind::Edge)
        {
            const auto end = [&](std::size_t k)
            { return mesh.vertices[static_cast<std::size_t>(feature.vertices[k])]; };
            const Vector3d edge = R * (end(1) - end(0)).stableNormalized();
            normal -= edge.dot(normal) * edge;
        }
    };
    straighten(c.featureA, near.a.tree().mesh(), R_FA);
    straighten(c.featureB, near.b.tree().mesh(), Matrix3d::Identity());
    return normal.norm() > kOnBoundary ? Vector3d(normal.normalized()) : found;
}
}  // namespace

std::vector<FeatureContact> contactsAt(const RigidBody& bodyA,
                                       const RigidBody& bodyB,
                                       double time,
                                       double threshold,
                                       const StopCondition& stop)
{
    require(threshold >= 0.0 && std::isfinite(threshold),
            "contacts: the threshold must not be negative and must be finite");
    require(std::isfinite(time), "contacts: the time must be finite");
    const Isometry3d X_WA = geometryPoseAt(movingBody(bodyA), time);
    const Isometry3d X_WB = geometryPoseAt(movingBody(bodyB), time);
    require(X_WA.matrix().allFinite() && X_WB.matrix().allFinite(),
            "contacts: a pose is NaN or infinite");
    std::optional<NearFeatures> near =
        nearFeatures(*bodyA.tree, X_WA, *bodyB.tree, X_WB, threshold, ContactView::Features, stop);
    if (!near)
    {
        return {};
    }
    const double touching = kTouchingGap * std::max(bodyA.tree->radius(), bodyB.tree->radius());
    std::map<std::pair<Feature, Feature>, FeatureContact> merged;
    for (Contact& found : near->contacts)
    {
        const Vector3d inA = near->poses.R_FA.transpose() * (found.pointA - near->poses.p_FA);
        FeatureContact contact{.featureA = featureAt(near->a, found.triangleA, inA),
                               .featureB = featureAt(near->b, found.triangleB, found.pointB),
                               .gap = found.gap};
        if (found.gap <= touching)
        {
            found.normal = touchingNormal(contact, *near, found.normal);
        }
        toWorld(near->poses, near->a, near->b, {&found, 1});
        contact.triangleA = found.triangleA;
        contact.triangleB = found.triangleB;
        contact.pointA = found.pointA;
        contact.pointB = found.pointB;
        contact.normal = found.normal;
        // The nearest points of all that are the same, and the first triangles that have both.
        const std::pair features(contact.featureA, contact.featureB);
        FeatureContact& kept = merged.try_emplace(features, contact).first->second;
        const std::int32_t firstA = std::min(kept.triangleA, contact.triangleA);
        const std::int32_t firstB = std::min(kept.triangleB, contact.triangleB);
        if (contact.gap < kept.gap)
        {
            kept = contact;
        }
        kept.triangleA = firstA;
        kept.triangleB = firstB;
    }
    std::vector<FeatureContact> contacts;
    for (const auto& [features, contact] : merged)
    {
        contacts.push_back(contact);
    }
    std::stable_sort(contacts.begin(),
                     contacts.end(),
                     [](const FeatureContact& x, const FeatureContact& y)
                     { return x.gap < y.gap; });
    return contacts;
}
}  // namespace bullet_ccd
