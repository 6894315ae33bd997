#include "bullet_ccd/contact/contact_outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kDirections = 12;

// Relative to the threshold: points that are one, how far a point may have moved since, and how far
// a point is below the hull to count.
constexpr double kSame = 0.01;
constexpr double kFormer = 0.1;
constexpr double kLow = 0.02;
/// Part of the largest area that is enough to keep the points.
constexpr double kEnough = 0.85;
/// Area below which a triangle of points says nothing about heights; the whole patch has 1.
constexpr double kNoArea = 1e-3;

double cross(const Vector2d& u, const Vector2d& v)
{
    return u.x() * v.y() - u.y() * v.x();
}

/// Area of the convex hull of four points: of the largest of all quadrilaterals and triangles.
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
}  // namespace

ContactOutline::ContactOutline(const std::vector<Contact>& contacts,
                               const std::vector<std::int32_t>& members,
                               const Vector3d& normal,
                               double threshold)
    : m_contacts(contacts), m_members(members), m_threshold(threshold)
{
    layAxes(normal);
    const auto addRing = [&](int count, double size, double depth)
    {
        for (int k = 0; k < count; ++k)
        {
            // Not along an edge of something rectangular, where many contacts are equally far.
            const double angle = 0.2 + 2.0 * std::numbers::pi * double(k) / double(count);
            addExtreme({size * std::cos(angle), size * std::sin(angle), depth});
        }
    };
    addRing(kDirections, 1.0, 0.0);
    m_rim = m_count;
    // What is lowest when the body leans by so many thresholds over the size of the patch.
    m_deepest = static_cast<int>(add(members.front()) - m_spots.data());
    const double least = contacts[static_cast<std::size_t>(members.front())].gap;
    if (contacts[static_cast<std::size_t>(members.back())].gap - least <= kLow * threshold)
    {
        return;
    }
    addRing(kDirections, 0.05, 1.0);
    addRing(kDirections / 2, 0.2, 1.0);
    addRing(kDirections / 2, 0.8, 1.0);
}

void ContactOutline::appendChoice(const std::vector<FormerContact>& former,
                                  std::int32_t most,
                                  std::vector<Contact>& chosen)
{
    addFormer(former);
    std::array<int, 4> best{0, 1, 2, 3};
    int count = m_count;
    if (m_count > 4)
    {
        best = base();
        count = 4;
    }
    for (int k = 0; k < count; ++k)
    {
        choose(best[static_cast<std::size_t>(k)]);
    }
    chooseLow(most);
    const auto end = m_chosen.begin() + m_chosenCount;
    std::swap(m_chosen.front(),
              *std::min_element(
                  m_chosen.begin(), end, [&](int x, int y) { return spot(x).gap < spot(y).gap; }));
    for (auto i = m_chosen.begin(); i != end; ++i)
    {
        chosen.push_back(m_contacts[static_cast<std::size_t>(spot(*i).contact)]);
    }
}

/// Coordinates across the normal, scaled once the axes are laid.
Vector2d ContactOutline::across(std::int32_t contact) const
{
    const Vector3d& point = m_contacts[static_cast<std::size_t>(contact)].pointB;
    return (m_axes.transpose() * point - m_origin).cwiseProduct(m_scale);
}

Vector2d ContactOutline::farthestFrom(const Vector2d& place) const
{
    Vector2d best = place;
    for (const std::int32_t member : m_members)
    {
        const Vector2d at = across(member);
        if ((at - place).squaredNorm() > (best - place).squaredNorm())
        {
            best = at;
        }
    }
    return best;
}

/// The first axis along the patch. Directions at equal angles miss the outline of a long patch
/// unless it is made as wide as long.
void ContactOutline::layAxes(const Vector3d& normal)
{
    m_axes.col(0) = normal.unitOrthogonal();
    m_axes.col(1) = normal.cross(m_axes.col(0));
    const Vector2d end = farthestFrom(across(m_members.front()));
    const Vector2d along = farthestFrom(end) - end;
    if (along.norm() > kSame * m_threshold)
    {
        m_axes.col(0) = (m_axes * along).normalized();
        m_axes.col(1) = normal.cross(m_axes.col(0));
    }
    Vector2d low = across(m_members.front());
    Vector2d high = low;
    for (const std::int32_t member : m_members)
    {
        low = low.cwiseMin(across(member));
        high = high.cwiseMax(across(member));
    }
    m_origin = low;
    m_scale = (high - low).cwiseMax(kSame * m_threshold).cwiseInverse();
}

/// The contact farthest in a direction: two coordinates across the patch and one down.
void ContactOutline::addExtreme(const Vector3d& direction)
{
    std::int32_t best = m_members.front();
    double farthest = -std::numeric_limits<double>::infinity();
    for (const std::int32_t member : m_members)
    {
        const double gap = m_contacts[static_cast<std::size_t>(member)].gap / m_threshold;
        const double value = direction.head<2>().dot(across(member)) - direction.z() * gap;
        if (value > farthest)
        {
            farthest = value;
            best = member;
        }
    }
    add(best);
}

void ContactOutline::addFormer(const std::vector<FormerContact>& former)
{
    for (const FormerContact& point : former)
    {
        double least = kFormer * kFormer * m_threshold * m_threshold;
        std::int32_t best = kNone;
        for (const std::int32_t member : m_members)
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
        Spot* found = best == kNone ? nullptr : add(best);
        if (found != nullptr)
        {
            found->isFormer = true;
        }
    }
}

/// The spot of the contact, or of one that is at the same place; null if there is no room.
ContactOutline::Spot* ContactOutline::add(std::int32_t contact)
{
    const Vector2d at = across(contact);
    const auto end = m_spots.begin() + m_count;
    const auto same =
        std::find_if(m_spots.begin(),
                     end,
                     [&](const Spot& s)
                     { return (s.at - at).cwiseQuotient(m_scale).norm() <= kSame * m_threshold; });
    if (same != end || m_count == static_cast<int>(kMaxSpots))
    {
        return same != end ? &*same : nullptr;
    }
    const double gap = m_contacts[static_cast<std::size_t>(contact)].gap / m_threshold;
    *same = {.at = at, .gap = gap, .contact = contact};
    ++m_count;
    return &*same;
}

double ContactOutline::area(const std::array<int, 4>& four) const
{
    return hullArea(spot(four[0]).at, spot(four[1]).at, spot(four[2]).at, spot(four[3]).at);
}

/// The four that span most, or the former ones if these do nearly as well.
std::array<int, 4> ContactOutline::base() const
{
    const std::array<int, 4> best =
        largest(m_rim < 4 ? m_count : m_rim, [](const Spot&) { return true; });
    const std::array<int, 4> former = largest(m_count, [](const Spot& s) { return s.isFormer; });
    return former[0] != kNone && area(former) >= kEnough * area(best) ? former : best;
}

/// Of those among the first `count` spots that the filter lets through; kNone if there are fewer
/// than four.
template <class Filter>
std::array<int, 4> ContactOutline::largest(int count, Filter filter) const
{
    std::array<int, 2 * kDirections> usable{};
    int n = 0;
    for (int i = 0; i < count && n < 2 * kDirections; ++i)
    {
        if (filter(spot(i)))
        {
            usable[static_cast<std::size_t>(n++)] = i;
        }
    }
    const auto at = [&](int k) { return usable[static_cast<std::size_t>(k)]; };
    std::array<int, 4> best{kNone, kNone, kNone, kNone};
    double most = -1.0;
    for (int a = 0; a < n; ++a)
    {
        for (int b = a + 1; b < n; ++b)
        {
            for (int c = b + 1; c < n; ++c)
            {
                for (int d = c + 1; d < n; ++d)
                {
                    const std::array<int, 4> four{at(a), at(b), at(c), at(d)};
                    const double size = area(four);
                    if (size > most)
                    {
                        most = size;
                        best = four;
                    }
                }
            }
        }
    }
    return best;
}

/// Height there of the lower hull of the chosen spots: the lowest of all triangles over the place;
/// outside of all of them, the plane of the one that is nearest.
double ContactOutline::heightOfHull(const Vector2d& at) const
{
    double lowest = std::numeric_limits<double>::infinity();
    double outside = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < m_chosenCount; ++i)
    {
        for (int j = i + 1; j < m_chosenCount; ++j)
        {
            for (int k = j + 1; k < m_chosenCount; ++k)
            {
                const Spot& a = spot(m_chosen[static_cast<std::size_t>(i)]);
                const Spot& b = spot(m_chosen[static_cast<std::size_t>(j)]);
                const Spot& c = spot(m_chosen[static_cast<std::size_t>(k)]);
                const double twice = cross(b.at - a.at, c.at - a.at);
                if (std::abs(twice) < 2.0 * kNoArea)
                {
                    continue;
                }
                const double ofB = cross(at - a.at, c.at - a.at) / twice;
                const double ofC = cross(b.at - a.at, at - a.at) / twice;
                const double inside = std::min({ofB, ofC, 1.0 - ofB - ofC, 0.0});
                const double height = a.gap + ofB * (b.gap - a.gap) + ofC * (c.gap - a.gap);
                if (inside > outside)
                {
                    outside = inside;
                    lowest = height;
                }
                else if (inside == outside)
                {
                    lowest = std::min(lowest, height);
                }
            }
        }
    }
    return lowest;
}

void ContactOutline::choose(int i)
{
    m_chosen[static_cast<std::size_t>(m_chosenCount++)] = i;
    m_spots[static_cast<std::size_t>(i)].isChosen = true;
}

/// Adds the deepest, and then what is below the hull of those chosen, first what touches when the
/// body leans least.
void ContactOutline::chooseLow(std::int32_t most)
{
    const auto isDeeper = [&](int x, int y) { return spot(x).gap < spot(y).gap; };
    const int chosen =
        *std::min_element(m_chosen.begin(), m_chosen.begin() + m_chosenCount, isDeeper);
    if (spot(m_deepest).gap < spot(chosen).gap - kLow)
    {
        choose(m_deepest);
    }
    for (int i = m_rim; i < m_count && m_chosenCount < most; ++i)
    {
        const double below = heightOfHull(spot(i).at) - spot(i).gap;
        if (!spot(i).isChosen && std::isfinite(below) && below > kLow)
        {
            choose(i);
        }
    }
}
}  // namespace bullet_ccd
