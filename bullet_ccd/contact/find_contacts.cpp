#include "bullet_ccd/contact/find_contacts.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/distance/triangle_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <iterator>
#include <tuple>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

/// Normal of a triangle, or zero if it has no area.
Vector3d triangleNormal(const SsvTree& tree, std::int32_t triangle)
{
    const auto c = tree.cornersOfTriangle(triangle);
    return (c[1] - c[0]).cross(c[2] - c[0]).stableNormalized();
}

/// A contact of two points, given in the frame of B.
Contact makeContact(const Eigen::Isometry3d& X_WB,
                    const TrianglePair& pair,
                    const TriangleDistance& closest)
{
    return {.pointA = X_WB * closest.pointA,
            .pointB = X_WB * closest.pointB,
            .normal = X_WB.linear() * (closest.pointB - closest.pointA).normalized(),
            .gap = closest.distance,
            .triangleA = pair.triangleA,
            .triangleB = pair.triangleB};
}

TriangleDistance swapped(const TriangleDistance& closest)
{
    return {closest.distance, closest.pointB, closest.pointA};
}

/// Closest points of all corners with the other triangle and of all edges with each other, where
/// they are as near as `threshold`: two parallel triangles have one closest pair of points among
/// many, but the corners of their overlap are among these. Oblique ones are left out; they belong
/// to other faces.
void appendFeatureContacts(const TriangleCorners& a,
                           const TriangleCorners& b,
                           const Contact& nearest,
                           const ContactOptions& options,
                           const TrianglePair& pair,
                           const Eigen::Isometry3d& X_WB,
                           std::vector<Contact>& contacts)
{
    const double cosine = std::cos(options.mergeAngle);
    const auto offer = [&](const TriangleDistance& closest)
    {
        if (closest.distance > 0.0 && closest.distance <= options.threshold)
        {
            const Contact contact = makeContact(X_WB, pair, closest);
            if (contact.normal.dot(nearest.normal) >= cosine)
            {
                contacts.push_back(contact);
            }
        }
    };
    for (std::size_t i = 0; i < 3; ++i)
    {
        offer(pointToTriangle(a[i], b));
        offer(swapped(pointToTriangle(b[i], a)));
        for (std::size_t j = 0; j < 3; ++j)
        {
            offer(segmentToSegment(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
        }
    }
}

/// Contacts of all pairs of triangles, in W.
std::vector<Contact> rawContacts(const SsvTree& treeA,
                                 const Eigen::Isometry3d& X_WA,
                                 const SsvTree& treeB,
                                 const Eigen::Isometry3d& X_WB,
                                 const ContactOptions& options)
{
    const Eigen::Isometry3d X_BA = X_WB.inverse() * X_WA;
    std::vector<TrianglePair> pairs;
    trianglePairsWithin(treeA, treeB, X_BA, options.threshold, pairs);
    std::vector<Contact> contacts;
    contacts.reserve(pairs.size());
    for (const TrianglePair& pair : pairs)
    {
        Contact contact =
            makeContact(X_WB, pair, TriangleDistance{pair.distance, pair.pointA, pair.pointB});
        if (pair.distance > 0.0)
        {
            TriangleCorners a = treeA.cornersOfTriangle(pair.triangleA);
            TriangleCorners b = treeB.cornersOfTriangle(pair.triangleB);
            for (std::size_t k = 0; k < 3; ++k)
            {
                a[k] = X_BA * (a[k] + treeA.origin());
                b[k] += treeB.origin();
            }
            appendFeatureContacts(a, b, contact, options, pair, X_WB, contacts);
        }
        else
        {
            contact.normal = -X_WB.linear() * triangleNormal(treeB, pair.triangleB);
        }
        contacts.push_back(contact);
    }
    return contacts;
}

/// A point on a grid, so that equal witnesses of neighbouring triangles compare equal.
using Cell = std::array<std::int64_t, 3>;

Cell cellOf(const Vector3d& point, double size)
{
    return {std::llround(point.x() / size),
            std::llround(point.y() / size),
            std::llround(point.z() / size)};
}

/// Keeps, of all contacts that share a witness on one side, the closest. A corner that hovers over
/// a face is also near the faces beside it, at an oblique angle: those are no contacts, because the
/// corner has a nearer point. What remains is nearest seen from both sides.
template <class PointOf>
void keepNearest(std::vector<Contact>& contacts, double cell, PointOf pointOf)
{
    struct Place
    {
        Cell cell;
        double gap;
        std::int32_t triangleA;
        std::int32_t triangleB;
        std::size_t index;
        auto operator<=>(const Place&) const = default;
    };
    std::vector<Place> places;
    places.reserve(contacts.size());
    for (const Contact& c : contacts)
    {
        places.push_back(
            {cellOf(pointOf(c), cell), c.gap, c.triangleA, c.triangleB, places.size()});
    }
    std::sort(places.begin(), places.end());
    const auto last = std::unique(places.begin(),
                                  places.end(),
                                  [](const Place& x, const Place& y) { return x.cell == y.cell; });
    std::vector<Contact> kept;
    kept.reserve(static_cast<std::size_t>(last - places.begin()));
    std::transform(places.begin(),
                   last,
                   std::back_inserter(kept),
                   [&](const Place& place) { return contacts[place.index]; });
    contacts = std::move(kept);
}

/// Groups of contacts with like normals; the seed of each is its closest contact.
std::vector<std::vector<Contact>> patchesOf(const std::vector<Contact>& contacts, double mergeAngle)
{
    const double cosine = std::cos(mergeAngle);
    std::vector<std::vector<Contact>> patches;
    for (const Contact& contact : contacts)
    {
        const auto patch = std::find_if(patches.begin(),
                                        patches.end(),
                                        [&](const std::vector<Contact>& p)
                                        { return p.front().normal.dot(contact.normal) >= cosine; });
        if (patch != patches.end())
        {
            patch->push_back(contact);
        }
        else
        {
            patches.push_back({contact});
        }
    }
    return patches;
}

/// The contact farthest by `measure`, if it is farther than `least`.
template <class Measure>
const Contact* farthest(const std::vector<Contact>& patch, double least, Measure measure)
{
    const Contact* best = nullptr;
    for (const Contact& contact : patch)
    {
        const double value = measure(contact.pointB);
        if (value > least)
        {
            least = value;
            best = &contact;
        }
    }
    return best;
}

/// At most `count` contacts that span the patch: the closest, the one farthest from it, the one
/// farthest from their line, and the one farthest on the other side of it; then whatever lies
/// farthest from all chosen.
std::vector<Contact> spanningContacts(const std::vector<Contact>& patch, int count)
{
    std::vector<Contact> chosen{patch.front()};
    const auto wanted = static_cast<std::size_t>(std::max(count, 1));
    const Vector3d a = patch.front().pointB;
    const Contact* second =
        farthest(patch, 0.0, [&](const Vector3d& p) { return (p - a).squaredNorm(); });
    if (second == nullptr || wanted < 2)
    {
        return chosen;
    }
    chosen.push_back(*second);
    const Vector3d line = (second->pointB - a).normalized();
    const Vector3d side = patch.front().normal.cross(line);
    const double extent = 1e-3 * (second->pointB - a).norm();
    for (const double sign : {1.0, -1.0})
    {
        const Contact* other =
            farthest(patch, extent, [&](const Vector3d& p) { return sign * side.dot(p - a); });
        if (other != nullptr && chosen.size() < wanted)
        {
            chosen.push_back(*other);
        }
    }
    while (chosen.size() < wanted)
    {
        const auto toChosen = [&](const Vector3d& p)
        {
            double nearest = (p - chosen.front().pointB).norm();
            for (const Contact& c : chosen)
            {
                nearest = std::min(nearest, (p - c.pointB).norm());
            }
            return nearest;
        };
        const Contact* other = farthest(patch, extent, toChosen);
        if (other == nullptr)
        {
            break;
        }
        chosen.push_back(*other);
    }
    return chosen;
}
}  // namespace

std::vector<Contact> findContacts(const SsvTree& treeA,
                                  const Eigen::Isometry3d& X_WA,
                                  const SsvTree& treeB,
                                  const Eigen::Isometry3d& X_WB,
                                  const ContactOptions& options)
{
    std::vector<Contact> contacts = rawContacts(treeA, X_WA, treeB, X_WB, options);
    const double cell = 1e-3 * options.threshold;
    keepNearest(contacts, cell, [](const Contact& c) { return c.pointA; });
    keepNearest(contacts, cell, [](const Contact& c) { return c.pointB; });
    std::sort(contacts.begin(),
              contacts.end(),
              [](const Contact& x, const Contact& y) {
                  return std::tie(x.gap, x.triangleA, x.triangleB) <
                         std::tie(y.gap, y.triangleA, y.triangleB);
              });
    std::vector<Contact> reduced;
    for (const std::vector<Contact>& patch : patchesOf(contacts, options.mergeAngle))
    {
        const std::vector<Contact> spanning = spanningContacts(patch, options.maxPerPatch);
        reduced.insert(reduced.end(), spanning.begin(), spanning.end());
    }
    return reduced;
}
}  // namespace bullet_ccd
