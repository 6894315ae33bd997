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
        : m_contacts(contacts), m_same(1e-2 * threshold)
    {
        const Vector2d size = layAxes(members, normal);
        for (std::size_t k = 0; k < kDirections; ++k)
        {
            // Not along an edge of something rectangular, where many contacts are equally far.
            const double angle = 0.2 + 2.0 * std::numbers::pi * double(k) / double(kDirections);
            add(extreme(members, Vector2d(std::cos(angle) * size.y(), std::sin(angle) * size.x())));
        }
        const double least = contacts[static_cast<std::size_t>(members.front())].gap;
        m_deep = least + 2e-2 * threshold;
        if (std::none_of(m_spots.begin(),
                         m_spots.begin() + m_count,
                         [&](const Spot& s) { return s.gap <= m_deep; }))
        {
            add(spotOf(members.front()));
        }
    }

    /// At most four of them, a deepest first.
    void appendBest(std::vector<Contact>& chosen) const
    {
        std::array<int, 4> best{0, 1, 2, 3};
        int count = m_count;
        if (m_count > kPointsPerPatch)
        {
            best = largest();
            count = kPointsPerPatch;
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
        if (along.norm() > m_same)
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
        return (high - low).cwiseMax(m_same);
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
                         [&](const Spot& s) { return (s.at - candidate.at).norm() <= m_same; }))
        {
            m_spots[static_cast<std::size_t>(m_count++)] = candidate;
        }
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
                        const double area =
                            hullArea(spot(a).at, spot(b).at, spot(c).at, spot(d).at);
                        if (gap <= m_deep && area > largest)
                        {
                            largest = area;
                            best = {a, b, c, d};
                        }
                    }
                }
            }
        }
        return best;
    }

    const std::vector<Contact>& m_contacts;
    double m_same;
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
        Outline(work.raw, work.members, patch.normal, options.threshold).appendBest(work.contacts);
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
