#include "bullet_ccd/contact/contact_search.h"

#include "bullet_ccd/contact/contact_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// Gap, relative to the rounding of a distance, below which its direction says nothing.
constexpr double kTouching = 1e3;

/// Looks at pairs of triangles; contacts in F.
class Search
{
public:
    Search(ContactView view,
           const ContactPoses& poses,
           double threshold,
           std::vector<Contact>& found,
           std::vector<Contact>& pierced)
        : m_view(view),
          m_lenient(view == ContactView::Points ? kWide : kLenient),
          m_threshold(threshold),
          m_rounding(poses.rounding),
          m_touching(kTouching * poses.rounding),
          m_centerA(poses.p_FA),
          m_found(found),
          m_first(found.size()),
          m_pierced(pierced)
    {
        m_pierced.clear();
    }

    void look(const Face& a, const Face& b)
    {
        const std::array<double, 3> heightsA = heights(a, b);
        const std::array<double, 3> heightsB = heights(b, a);
        if (isBeyond(heightsA, b) || isBeyond(heightsB, a))
        {
            return;
        }
        offerVertices(a, b, heightsA);
        offerVertices(b, a, heightsB);
        offerEdges(a, b);
        if (isCut(heightsA) && !b.normal.isZero(0.0))
        {
            offerPierced(a, b, heightsA);
        }
        if (isCut(heightsB) && !a.normal.isZero(0.0))
        {
            offerPierced(b, a, heightsB);
        }
    }

    /// To be called at the end.
    void finish()
    {
        const auto begin = m_found.begin() + static_cast<std::ptrdiff_t>(m_first);
        double least = std::numeric_limits<double>::infinity();
        for (auto at = begin; at != m_found.end(); ++at)
        {
            least = std::min(least, at->gap);
        }
        if (m_isPierced)
        {
            if (least >= 0.0)
            {
                keepFirstPierced();
            }
        }
        else if (m_nearest.gap < least - m_rounding)
        {
            // Rounding can put the nearest features just outside their cones.
            m_found.push_back(m_nearest);
        }
    }

private:
    static std::array<double, 3> heights(const Face& x, const Face& y)
    {
        return {y.normal.dot(x.corners[0] - y.corners[0]),
                y.normal.dot(x.corners[1] - y.corners[0]),
                y.normal.dot(x.corners[2] - y.corners[0])};
    }
    /// All to one side of the plane of y, farther than the threshold.
    [[nodiscard]] bool isBeyond(const std::array<double, 3>& h, const Face& y) const
    {
        const double far = m_threshold + m_rounding;
        return !y.normal.isZero(0.0) && ((h[0] > far && h[1] > far && h[2] > far) ||
                                         (h[0] < -far && h[1] < -far && h[2] < -far));
    }
    static bool isCut(const std::array<double, 3>& h)
    {
        const auto [low, high] = std::minmax({h[0], h[1], h[2]});
        return low < 0.0 && high > 0.0;
    }

    /// Limits of the cones: of vertices and edges that meet, and of smooth edges that cross.
    [[nodiscard]] double exact(double gap) const
    {
        return m_view == ContactView::Points ? kWide : kExact + 4.0 * m_rounding / gap;
    }
    [[nodiscard]] double smooth(double gap) const
    {
        return m_view == ContactView::Patches ? exact(gap) : m_lenient;
    }

    Contact contactOf(const Face& x,
                      const Face& y,
                      const Vector3d& onX,
                      const Vector3d& onY,
                      const Vector3d& normal,
                      double gap) const
    {
        return x.isB ? Contact{onY, onX, -normal, gap, y.index, x.index}
                     : Contact{onX, onY, normal, gap, x.index, y.index};
    }
    void record(const Contact& contact, bool isContact)
    {
        if (isContact)
        {
            m_found.push_back(contact);
        }
        else if (contact.gap < m_nearest.gap)
        {
            m_nearest = contact;
        }
    }

    void offerVertices(const Face& x, const Face& y, const std::array<double, 3>& heightsX)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            if (!x.owns(k))
            {
                continue;
            }
            if (std::abs(heightsX[k]) <= m_threshold + m_rounding)
            {
                offerVertexFace(x, k, y, heightsX[k]);
            }
            for (std::size_t l = 0; l < 3; ++l)
            {
                if (y.ownsEdge(l))
                {
                    offerVertexEdge(x, k, y, l);
                }
                // From one side only.
                if (!x.isB && y.owns(l))
                {
                    offerVertexVertex(x, k, y, l);
                }
            }
        }
    }

    void offerVertexFace(const Face& x, std::size_t k, const Face& y, double height)
    {
        if (!y.covers(x.corners[k]))
        {
            return;
        }
        Vector3d normal = height > 0.0 ? Vector3d(-y.normal) : y.normal;
        bool isContact = x.vertexCone(k, normal, m_lenient);
        if (!isContact && std::abs(height) <= m_touching)
        {
            normal = -normal;
            isContact = x.vertexCone(k, normal, m_lenient);
        }
        const Vector3d foot = x.corners[k] - height * y.normal;
        record(contactOf(x, y, x.corners[k], foot, normal, std::abs(height)), isContact);
    }

    void offerVertexEdge(const Face& x, std::size_t k, const Face& y, std::size_t l)
    {
        const Vector3d edge = y.edge(l);
        const Vector3d& point = x.corners[k];
        const double s = edge.dot(point - y.corners[l]) / edge.squaredNorm();
        const Vector3d foot = y.corners[l] + s * edge;
        const double gap = (foot - point).norm();
        if (s < 0.0 || s > 1.0 || gap > m_threshold + m_rounding)
        {
            return;
        }
        if (gap <= m_touching)
        {
            recordTouching(x,
                           x.surface->aroundVertex(x.slot->vertices[k]),
                           point,
                           y,
                           y.surface->aroundEdge(y.slot->edges[l]),
                           foot,
                           gap);
            return;
        }
        const Vector3d normal = (foot - point) / gap;
        record(contactOf(x, y, point, foot, normal, gap),
               y.edgeCone(l, -normal, exact(gap)) &&
                   x.vertexCone(k, normal, exact(gap), edge.normalized()));
    }

    void offerVertexVertex(const Face& a, std::size_t k, const Face& b, std::size_t l)
    {
        const double gap = (b.corners[l] - a.corners[k]).norm();
        if (gap > m_threshold + m_rounding)
        {
            return;
        }
        if (gap <= m_touching)
        {
            recordTouching(a,
                           a.surface->aroundVertex(a.slot->vertices[k]),
                           a.corners[k],
                           b,
                           b.surface->aroundVertex(b.slot->vertices[l]),
                           b.corners[l],
                           gap);
            return;
        }
        const Vector3d normal = (b.corners[l] - a.corners[k]) / gap;
        record(contactOf(a, b, a.corners[k], b.corners[l], normal, gap),
               b.vertexCone(l, -normal, exact(gap)) && a.vertexCone(k, normal, exact(gap)));
    }

    void offerEdges(const Face& a, const Face& b)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            for (std::size_t l = 0; l < 3; ++l)
            {
                if (a.ownsEdge(k) && b.ownsEdge(l))
                {
                    offerCrossing(a, k, b, l);
                }
            }
        }
    }

    void offerCrossing(const Face& a, std::size_t k, const Face& b, std::size_t l)
    {
        const Vector3d u = a.edge(k);
        const Vector3d v = b.edge(l);
        const Crossing at(a.corners[k], u, b.corners[l], v);
        if (!at.isInside())
        {
            return;
        }
        const Vector3d onA = a.corners[k] + at.s * u;
        const Vector3d onB = b.corners[l] + at.t * v;
        const double gap = (onB - onA).norm();
        if (gap > m_threshold + m_rounding)
        {
            return;
        }
        Vector3d normal;
        bool isContact = false;
        if (gap > m_touching)
        {
            normal = (onB - onA) / gap;
            isContact = crosses(a, k, b, l, normal, smooth(gap));
        }
        else
        {
            normal = u.cross(v).stableNormalized();
            isContact = crosses(a, k, b, l, normal, kLenient);
            if (!isContact)
            {
                normal = -normal;
                isContact = crosses(a, k, b, l, normal, kLenient);
            }
        }
        record(contactOf(a, b, onA, onB, normal, gap), isContact);
    }
    [[nodiscard]] bool crosses(const Face& x,
                               std::size_t k,
                               const Face& y,
                               std::size_t l,
                               const Vector3d& normal,
                               double smooth) const
    {
        return x.crossingCone(k, normal, m_lenient, smooth) &&
               y.crossingCone(l, -normal, m_lenient, smooth);
    }

    /// Tip to tip: the normal is out of both, as far as the directions around tell.
    void recordTouching(const Face& x,
                        std::span<const Vector3f> aroundX,
                        const Vector3d& onX,
                        const Face& y,
                        std::span<const Vector3f> aroundY,
                        const Vector3d& onY,
                        double gap)
    {
        Vector3f outX = Vector3f::Zero();
        Vector3f outY = Vector3f::Zero();
        for (const Vector3f& t : aroundX)
        {
            outX -= t;
        }
        for (const Vector3f& t : aroundY)
        {
            outY -= t;
        }
        const Vector3d out =
            *x.R_FG * outX.normalized().cast<double>() - *y.R_FG * outY.normalized().cast<double>();
        const bool hasNormal = out.norm() > kOnBoundary;
        record(contactOf(x,
                         y,
                         onX,
                         onY,
                         hasNormal ? Vector3d(out.normalized()) : Vector3d(Vector3d::UnitZ()),
                         gap),
               false);
    }

    /// Edges of x that x owns and that pass through y.
    void offerPierced(const Face& x, const Face& y, const std::array<double, 3>& h)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::size_t next = (k + 1) % 3;
            const bool isFlat = (x.slot->flatEdges >> k & 1U) != 0;
            if (h[k] * h[next] >= 0.0 || (!isFlat && !x.ownsEdge(k)))
            {
                continue;
            }
            const double s = h[k] / (h[k] - h[next]);
            const Vector3d through = x.corners[k] + s * x.edge(k);
            // What only touches the rim is a contact of the rim; a solver needs all that holds.
            if (!y.covers(through, m_view == ContactView::Patches ? -kOnBoundary : kOnBoundary))
            {
                continue;
            }
            m_isPierced = true;
            if (isFlat || m_view != ContactView::Patches || !offerBehind(x, k, y, h))
            {
                addPierced(x, y, through, std::min(std::abs(h[k]), std::abs(h[next])), isFlat);
            }
        }
    }

    /// The end of an edge that is behind the face, or the edge behind one of the face.
    bool offerBehind(const Face& x, std::size_t k, const Face& y, const std::array<double, 3>& h)
    {
        const std::size_t next = (k + 1) % 3;
        const std::size_t end = std::abs(h[k]) <= std::abs(h[next]) ? k : next;
        Contact best;
        best.gap = -std::numeric_limits<double>::infinity();
        const Vector3d out = h[end] > 0.0 ? y.normal : Vector3d(-y.normal);
        if (std::abs(h[end]) <= m_threshold && x.vertexCone(end, out, kLenient))
        {
            const Vector3d foot = x.corners[end] - h[end] * y.normal;
            best = contactOf(x, y, x.corners[end], foot, out, -std::abs(h[end]));
        }
        for (std::size_t l = 0; l < 3; ++l)
        {
            if ((y.slot->sharpEdges >> l & 1U) == 0)
            {
                continue;
            }
            const Crossing at(x.corners[k], x.edge(k), y.corners[l], y.edge(l));
            const Vector3d onX = x.corners[k] + at.s * x.edge(k);
            const Vector3d onY = y.corners[l] + at.t * y.edge(l);
            const double depth = (onX - onY).norm();
            if (!at.isInside() || depth > std::min(m_threshold, -best.gap) || depth <= m_touching)
            {
                continue;
            }
            const Vector3d normal = (onX - onY) / depth;
            if (x.edgeCone(k, normal, kLenient) && y.edgeCone(l, -normal, kLenient))
            {
                best = contactOf(x, y, onX, onY, normal, -depth);
            }
        }
        const bool found = std::isfinite(best.gap);
        if (found)
        {
            m_found.push_back(best);
        }
        return found;
    }

    /// Across the face, so that the middle of x stays on the side where it is.
    void addPierced(
        const Face& x, const Face& y, const Vector3d& through, double depth, bool isFlat)
    {
        const Vector3d center = x.isB ? Vector3d(Vector3d::Zero()) : m_centerA;
        const bool isAbove = y.normal.dot(center - y.corners[0]) > 0.0;
        const Vector3d normal = isAbove ? Vector3d(-y.normal) : y.normal;
        // The gap holds a rank for a while; edges inside a flat part come last.
        double rank = isFlat ? m_threshold + 1e6 * depth : depth;
        if (m_view != ContactView::Patches)
        {
            rank = isFlat ? std::numeric_limits<double>::infinity() : 0.0;
        }
        m_pierced.push_back(contactOf(x, y, through, through, normal, rank));
    }

    void keepFirstPierced()
    {
        double least = std::numeric_limits<double>::infinity();
        for (const Contact& contact : m_pierced)
        {
            least = std::min(least, contact.gap);
        }
        for (Contact& contact : m_pierced)
        {
            if (contact.gap <= 2.0 * least + m_threshold)
            {
                m_found.push_back(contact);
                m_found.back().gap = 0.0;
            }
        }
    }

    ContactView m_view;
    double m_lenient;  ///< limit of the cones of vertices over faces and sharp edges that cross
    double m_threshold;
    double m_rounding;  ///< of a distance
    double m_touching;  ///< gap that has no direction
    Vector3d m_centerA;
    std::vector<Contact>& m_found;
    std::size_t m_first;
    std::vector<Contact>& m_pierced;
    bool m_isPierced = false;
    Contact m_nearest{.gap = std::numeric_limits<double>::infinity()};
};

/// The closest points of all pairs of triangles: where no feature has a contact of its own.
Contact closestOfAll(const ContactSurface& surfaceA,
                     const ContactSurface& surfaceB,
                     const ContactPoses& poses,
                     const IndexPairs& slots)
{
    Contact best{.gap = std::numeric_limits<double>::infinity()};
    for (const auto& [a, b] : slots)
    {
        TriangleCorners corners = surfaceA.corners(a);
        for (Vector3d& corner : corners)
        {
            corner = poses.R_FA * corner + poses.p_FA;
        }
        const TriangleDistance d = triangleDistance(corners, surfaceB.corners(b));
        if (d.distance < best.gap)
        {
            best = {d.pointA, d.pointB, -surfaceB.slot(b).normal, d.distance, a, b};
        }
    }
    if (best.gap > 0.0)
    {
        best.normal = (best.pointB - best.pointA).stableNormalized();
    }
    return best;
}

/// Appends contacts in F, their triangles by their slots.
void search(ContactView view,
            const ContactSurface& surfaceA,
            const ContactSurface& surfaceB,
            const ContactPoses& poses,
            double threshold,
            const IndexPairs& slots,
            std::vector<Contact>& pierced,
            std::vector<Contact>& contacts,
            const StopCondition& stop = {})
{
    StopCheck check(stop);
    const std::size_t first = contacts.size();
    Search search(view, poses, threshold, contacts, pierced);
    const Matrix3d I = Matrix3d::Identity();
    // The pairs of one triangle follow each other often.
    Face faceA;
    Face faceB;
    for (const auto& [a, b] : slots)
    {
        check.look();
        if (a != faceA.index)
        {
            faceA = faceOf(surfaceA, poses.R_FA, poses.p_FA, a);
        }
        if (b != faceB.index)
        {
            faceB = faceOf(surfaceB, I, b);
        }
        search.look(faceA, faceB);
    }
    search.finish();
    if (contacts.size() == first)
    {
        const Contact closest = closestOfAll(surfaceA, surfaceB, poses, slots);
        if (closest.gap <= threshold + poses.rounding)
        {
            contacts.push_back(closest);
        }
    }
}

/// The surface of one side of the pairs, which from then on go by its slots.
ContactSurface partOf(const SsvTree& tree,
                      std::int32_t IndexPairs::value_type::*side,
                      IndexPairs& pairs)
{
    // In the order of the mesh, so that features are owned by the first of their triangles.
    const auto isBefore = [&](std::int32_t x, std::int32_t y)
    { return tree.triangle(x) < tree.triangle(y); };
    std::vector<std::int32_t> slots;
    for (const auto& pair : pairs)
    {
        slots.push_back(pair.*side);
    }
    std::sort(slots.begin(), slots.end(), isBefore);
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    for (auto& pair : pairs)
    {
        const auto at = std::lower_bound(slots.begin(), slots.end(), pair.*side, isBefore);
        pair.*side = static_cast<std::int32_t>(at - slots.begin());
    }
    return ContactSurface(tree, slots);
}
ContactPoses contactPoses(const SsvTree& treeA,
                          const Isometry3d& X_WA,
                          const SsvTree& treeB,
                          const Isometry3d& X_WB)
{
    const double largest = std::max({treeA.radius() + treeA.origin().norm(),
                                     treeB.radius() + treeB.origin().norm(),
                                     X_WA.translation().norm(),
                                     X_WB.translation().norm()});
    const Matrix3d R_BW = X_WB.linear().transpose();
    return {.X_WB = X_WB,
            .originB = treeB.origin(),
            .R_FA = R_BW * X_WA.linear(),
            .p_FA = R_BW * (X_WA * treeA.origin() - X_WB * treeB.origin()),
            .rounding = 64.0 * std::numeric_limits<double>::epsilon() * largest};
}
}  // namespace

void appendContacts(const ContactSurface& surfaceA,
                    const Isometry3d& X_WA,
                    const ContactSurface& surfaceB,
                    const Isometry3d& X_WB,
                    double threshold,
                    ContactSearchWorkspace& work,
                    std::vector<Contact>& contacts,
                    KeptSlots* kept)
{
    const SsvTree& treeA = surfaceA.tree();
    const SsvTree& treeB = surfaceB.tree();
    const ContactPoses poses = contactPoses(treeA, X_WA, treeB, X_WB);
    const double within = threshold + poses.rounding;
    if (kept != nullptr)
    {
        kept->collect(treeA, treeB, poses.R_FA, poses.p_FA, within, work.open, work.slots);
    }
    else
    {
        collectNearSlots(treeA, treeB, poses.R_FA, poses.p_FA, within, work.open, work.slots);
    }
    work.pairs += static_cast<std::int64_t>(work.slots.size());
    if (!work.slots.empty())
    {
        const std::size_t first = contacts.size();
        search(ContactView::Patches,
               surfaceA,
               surfaceB,
               poses,
               threshold,
               work.slots,
               work.pierced,
               contacts);
        toWorld(poses, surfaceA, surfaceB, std::span(contacts).subspan(first));
    }
}

std::optional<NearFeatures> nearFeatures(const SsvTree& treeA,
                                         const Isometry3d& X_WA,
                                         const SsvTree& treeB,
                                         const Isometry3d& X_WB,
                                         double threshold,
                                         ContactView view,
                                         const StopCondition& stop)
{
    const ContactPoses poses = contactPoses(treeA, X_WA, treeB, X_WB);
    ContactSearchWorkspace work;
    collectNearSlots(treeA,
                     treeB,
                     poses.R_FA,
                     poses.p_FA,
                     threshold + poses.rounding,
                     work.open,
                     work.slots,
                     stop);
    if (work.slots.empty())
    {
        return std::nullopt;
    }
    NearFeatures near{.poses = poses,
                      .a = partOf(treeA, &IndexPairs::value_type::first, work.slots),
                      .b = partOf(treeB, &IndexPairs::value_type::second, work.slots),
                      .contacts = {}};
    search(view, near.a, near.b, poses, threshold, work.slots, work.pierced, near.contacts, stop);
    return near;
}

void toWorld(const ContactPoses& poses,
             const ContactSurface& a,
             const ContactSurface& b,
             std::span<Contact> contacts)
{
    for (Contact& contact : contacts)
    {
        contact.pointA = poses.X_WB * (contact.pointA + poses.originB);
        contact.pointB = poses.X_WB * (contact.pointB + poses.originB);
        contact.normal = poses.X_WB.linear() * contact.normal;
        contact.triangleA = a.triangle(contact.triangleA);
        contact.triangleB = b.triangle(contact.triangleB);
    }
}
}  // namespace bullet_ccd
