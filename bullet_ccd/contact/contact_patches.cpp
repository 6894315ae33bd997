#include "bullet_ccd/contact/contact_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kDirections = 12;
constexpr std::size_t kMaxCandidates = kDirections + 1;

// Relative to the threshold: points that are one, points that are as deep as the deepest, how far a
// point may have moved since, and how deep the deepest may be if the points stay.
constexpr double kSame = 0.01;
constexpr double kDeep = 0.02;
constexpr double kFormer = 0.1;
constexpr double kFormerDeep = 0.1;
/// Part of the largest area that is enough to keep the points.
constexpr double kEnough = 0.85;

/// A contact in the plane across the normal of its patch.
struct Spot
{
    Vector2d at = Vector2d::Zero();
    double gap = 0.0;
    std::int32_t contact = kNone;
};

double cross(const Vector2d& u, const Vector2d& v)
{
    return u.x() * v.y() - u.y() * v.x();
}

/// Area of the convex hull of four points: of the larger of all quadrilaterals and triangles.
double hullArea(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d)
{
    return 0.5 * std::max({std::abs(cross(c - a, d - b)),
                           std::abs(cross(b - a, d - c)),
                           std::abs(cross(d - a, c - b)),
                           std::abs(cross(b - a, c - a)),
                           std::abs(cross(b - a, d - a)),
                           std::abs(cross(c - a, d - a)),
                           std::abs(cross(c - b, d - b))});
}

/// A few contacts of a patch that hold its outline, and a deepest one.
class Outline
{
public:
    Outline(const std::vector<Contact>& contacts,
            const std::vector<std::int32_t>& members,
            const Vector3d& normal,
            double threshold)
        : m_contacts(contacts), m_threshold(threshold)
    {
        const Vector2d size = layAxes(members, normal);
        for (std::size_t k = 0; k < kDirections; ++k)
        {
            // Not along an edge of something rectangular, where many contacts are equally far.
            const double angle = 0.2 + 2.0 * std::numbers::pi * double(k) / double(kDirections);
            add(extreme(members, Vector2d(std::cos(angle) * size.y(), std::sin(angle) * size.x())));
        }
        const double least = contacts[static_cast<std::size_t>(members.front())].gap;
        m_deep = least + kDeep * threshold;
        if (std::none_of(m_spots.begin(),
                         m_spots.begin() + m_count,
                         [&](const Spot& s) { return s.gap <= m_deep; }))
        {
            add(spotOf(members.front()));
        }
    }

    /// At most four of them, a deepest first.
    void appendBest(const std::vector<std::int32_t>& members,
                    const std::vector<FormerContact>& former,
                    std::vector<Contact>& chosen)
    {
        std::array<int, 4> best{0, 1, 2, 3};
        int count = m_count;
        if (m_count > kPointsPerPatch)
        {
            best = largest();
            count = kPointsPerPatch;
            holdFormer(members, former, best);
        }
        const auto deepest =
            std::min_element(best.begin(),
                             best.begin() + count,
                             [&](int x, int y) { return spot(x).gap < spot(y).gap; });
        std::swap(best.front(), *deepest);
        for (int k = 0; k < count; ++k)
        {
            chosen.push_back(m_contacts[static_cast<std::size_t>(
                spot(best[static_cast<std::size_t>(k)]).contact)]);
        }
    }

private:
    [[nodiscard]] const Spot& spot(int i) const { return m_spots[static_cast<std::size_t>(i)]; }
    [[nodiscard]] Spot spotOf(std::int32_t contact) const
    {
        const Contact& c = m_contacts[static_cast<std::size_t>(contact)];
        return {m_axes.transpose() * c.pointB, c.gap, contact};
    }
    /// The first axis along the patch; its size along both. Directions at equal angles miss the
    /// outline of a long patch unless it is made as wide as long.
    Vector2d layAxes(const std::vector<std::int32_t>& members, const Vector3d& normal)
    {
        m_axes.col(0) = normal.unitOrthogonal();
        m_axes.col(1) = normal.cross(m_axes.col(0));
        const Vector2d start = spotOf(members.front()).at;
        const Vector2d end = farthestFrom(start, members);
        const Vector2d along = farthestFrom(end, members) - end;
        if (along.norm() > kSame * m_threshold)
        {
            m_axes.col(0) = (m_axes * along).normalized();
            m_axes.col(1) = normal.cross(m_axes.col(0));
        }
        Vector2d low = spotOf(members.front()).at;
        Vector2d high = low;
        for (const std::int32_t member : members)
        {
            low = low.cwiseMin(spotOf(member).at);
            high = high.cwiseMax(spotOf(member).at);
        }
        return (high - low).cwiseMax(kSame * m_threshold);
    }
    [[nodiscard]] Vector2d farthestFrom(const Vector2d& place,
                                        const std::vector<std::int32_t>& members) const
    {
        Vector2d best = place;
        for (const std::int32_t member : members)
        {
            const Vector2d at = spotOf(member).at;
            if ((at - place).squaredNorm() > (best - place).squaredNorm())
            {
                best = at;
            }
        }
        return best;
    }
    [[nodiscard]] Spot extreme(const std::vector<std::int32_t>& members,
                               const Vector2d& direction) const
    {
        const Vector3d along = m_axes * direction;
        std::int32_t best = members.front();
        double farthest = -std::numeric_limits<double>::infinity();
        for (const std::int32_t member : members)
        {
            const double value = along.dot(m_contacts[static_cast<std::size_t>(member)].pointB);
            if (value > farthest)
            {
                farthest = value;
                best = member;
            }
        }
        return spotOf(best);
    }
    /// Points nearer to each other than a hundredth of the threshold are one.
    void add(const Spot& candidate)
    {
        const auto end = m_spots.begin() + m_count;
        if (std::none_of(m_spots.begin(),
                         end,
                         [&](const Spot& s)
                         { return (s.at - candidate.at).norm() <= kSame * m_threshold; }))
        {
            m_spots[static_cast<std::size_t>(m_count++)] = candidate;
        }
    }

    [[nodiscard]] double area(const std::array<int, 4>& four) const
    {
        return hullArea(spot(four[0]).at, spot(four[1]).at, spot(four[2]).at, spot(four[3]).at);
    }

    /// Replaces the best four by the former ones if these do nearly as well.
    void holdFormer(const std::vector<std::int32_t>& members,
                    const std::vector<FormerContact>& former,
                    std::array<int, 4>& best)
    {
        std::array<Spot, 4> held;
        std::size_t count = 0;
        double least = std::numeric_limits<double>::infinity();
        for (const FormerContact& point : former)
        {
            const std::int32_t member = nearest(members, point);
            if (member == kNone)
            {
                continue;
            }
            if (count == held.size())
            {
                return;
            }
            held[count++] = spotOf(member);
            least = std::min(least, held[count - 1].gap);
        }
        if (count < held.size() || least > m_deep + (kFormerDeep - kDeep) * m_threshold ||
            hullArea(held[0].at, held[1].at, held[2].at, held[3].at) < kEnough * area(best))
        {
            return;
        }
        std::copy(held.begin(), held.end(), m_spots.begin());
        best = {0, 1, 2, 3};
    }
    [[nodiscard]] std::int32_t nearest(const std::vector<std::int32_t>& members,
                                       const FormerContact& point) const
    {
        double least = kFormer * kFormer * m_threshold * m_threshold;
        std::int32_t best = kNone;
        for (const std::int32_t member : members)
        {
            const Contact& c = m_contacts[static_cast<std::size_t>(member)];
            const double squared = std::min((c.pointA - point.onA).squaredNorm(),
                                            (c.pointB - point.onB).squaredNorm());
            if (squared < least)
            {
                least = squared;
                best = member;
            }
        }
        return best;
    }

    [[nodiscard]] std::array<int, 4> largest() const
    {
        std::array<int, 4> best{0, 1, 2, 3};
        double largest = -1.0;
        for (int a = 0; a < m_count; ++a)
        {
            for (int b = a + 1; b < m_count; ++b)
            {
                for (int c = b + 1; c < m_count; ++c)
                {
                    for (int d = c + 1; d < m_count; ++d)
                    {
                        const double gap =
                            std::min({spot(a).gap, spot(b).gap, spot(c).gap, spot(d).gap});
                        const double size = area({a, b, c, d});
                        if (gap <= m_deep && size > largest)
                        {
                            largest = size;
                            best = {a, b, c, d};
                        }
                    }
                }
            }
        }
        return best;
    }

    const std::vector<Contact>& m_contacts;
    double m_threshold;
    double m_deep = 0.0;
    Eigen::Matrix<double, 3, 2> m_axes;
    std::array<Spot, kMaxCandidates> m_spots{};
    int m_count = 0;
};

bool isDeeper(const Contact& x, const Contact& y)
{
    return std::tie(x.gap, x.triangleA, x.triangleB) < std::tie(y.gap, y.triangleA, y.triangleB);
}
}  // namespace

void reducePatches(const PatchOptions& options, PatchWorkspace& work)
{
    work.patches.clear();
    work.contacts.clear();
    std::sort(work.raw.begin(), work.raw.end(), isDeeper);
    const double cosine = std::cos(options.mergeAngle);
    work.patchOf.clear();
    for (const Contact& contact : work.raw)
    {
        const auto patch = std::find_if(work.patches.begin(),
                                        work.patches.end(),
                                        [&](const ContactPatch& p)
                                        { return p.normal.dot(contact.normal) >= cosine; });
        const auto index = static_cast<std::int32_t>(patch - work.patches.begin());
        if (patch == work.patches.end() && index < options.maxPatches)
        {
            work.patches.push_back({.normal = contact.normal});
        }
        work.patchOf.push_back(index);
    }
    for (std::size_t k = 0; k < work.patches.size(); ++k)
    {
        work.members.clear();
        for (std::size_t i = 0; i < work.raw.size(); ++i)
        {
            if (work.patchOf[i] == static_cast<std::int32_t>(k))
            {
                work.members.push_back(static_cast<std::int32_t>(i));
            }
        }
        ContactPatch& patch = work.patches[k];
        patch.first = static_cast<std::int32_t>(work.contacts.size());
        Outline(work.raw, work.members, patch.normal, options.threshold)
            .appendBest(work.members, work.former, work.contacts);
        patch.count = static_cast<std::int32_t>(work.contacts.size()) - patch.first;
    }
}

void findPatches(const ContactSurface& surfaceA,
                 const Eigen::Isometry3d& X_WA,
                 const ContactSurface& surfaceB,
                 const Eigen::Isometry3d& X_WB,
                 const PatchOptions& options,
                 PatchWorkspace& work)
{
    work.raw.clear();
    appendContacts(surfaceA, X_WA, surfaceB, X_WB, options.threshold, work.search, work.raw);
    reducePatches(options, work);
}
}  // namespace bullet_ccd
