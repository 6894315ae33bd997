#include "benchmarks/reference/audit/exact_triangles.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace bullet_ccd::reference
{
namespace
{
__extension__ using Wide = __int128;
using GridPoint2 = std::array<std::int64_t, 2>;

int signOf(Wide value)
{
    return value > 0 ? 1 : (value < 0 ? -1 : 0);
}

GridPoint minus(const GridPoint& a, const GridPoint& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Component k of u x v.
Wide crossComponent(const GridPoint& u, const GridPoint& v, std::size_t k)
{
    const std::size_t i = (k + 1) % 3;
    const std::size_t j = (k + 2) % 3;
    return Wide(u[i]) * v[j] - Wide(u[j]) * v[i];
}

/// Sign of the area of a, b, c; positive if counter-clockwise.
int turnOf(const GridPoint2& a, const GridPoint2& b, const GridPoint2& c)
{
    return signOf(Wide(b[0] - a[0]) * (c[1] - a[1]) - Wide(b[1] - a[1]) * (c[0] - a[0]));
}

bool withinBox(const GridPoint2& a, const GridPoint2& b, const GridPoint2& p)
{
    return std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) &&
           std::min(a[1], b[1]) <= p[1] && p[1] <= std::max(a[1], b[1]);
}

bool segmentsMeet(const GridPoint2& a,
                  const GridPoint2& b,
                  const GridPoint2& c,
                  const GridPoint2& d)
{
    const int abc = turnOf(a, b, c);
    const int abd = turnOf(a, b, d);
    const int cda = turnOf(c, d, a);
    const int cdb = turnOf(c, d, b);
    if (abc * abd < 0 && cda * cdb < 0)
    {
        return true;
    }
    return (abc == 0 && withinBox(a, b, c)) || (abd == 0 && withinBox(a, b, d)) ||
           (cda == 0 && withinBox(c, d, a)) || (cdb == 0 && withinBox(c, d, b));
}

/// Segment p, q and triangle in one plane, which is seen along the axis where `normal` is not zero.
bool meetsInPlane(const GridPoint& p,
                  const GridPoint& q,
                  const GridTriangle& t,
                  const std::array<Wide, 3>& normal)
{
    const std::size_t k = normal[0] != 0 ? 0 : (normal[1] != 0 ? 1 : 2);
    const auto flat = [k](const GridPoint& x) {
        return GridPoint2{x[(k + 1) % 3], x[(k + 2) % 3]};
    };
    const GridPoint2 a = flat(t[0]);
    const GridPoint2 b = flat(t[1]);
    const GridPoint2 c = flat(t[2]);
    const GridPoint2 start = flat(p);
    const GridPoint2 end = flat(q);
    const int ab = turnOf(a, b, start);
    const int bc = turnOf(b, c, start);
    const int ca = turnOf(c, a, start);
    const bool inside = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
    return inside || segmentsMeet(start, end, a, b) || segmentsMeet(start, end, b, c) ||
           segmentsMeet(start, end, c, a);
}

/// Segment p, q against a closed triangle; `sideP`, `sideQ` are the sides of its plane.
bool segmentMeets(const GridPoint& p,
                  const GridPoint& q,
                  int sideP,
                  int sideQ,
                  const GridTriangle& t,
                  const std::array<Wide, 3>& normal)
{
    if (sideP * sideQ > 0)
    {
        return false;
    }
    if (sideP == 0 && sideQ == 0)
    {
        return meetsInPlane(p, q, t, normal);
    }
    const int ab = sideOf(p, q, t[0], t[1]);
    const int bc = sideOf(p, q, t[1], t[2]);
    const int ca = sideOf(p, q, t[2], t[0]);
    return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

/// Whether an edge of `a` meets triangle `b`.
bool edgesMeet(const GridTriangle& a, const GridTriangle& b)
{
    const GridPoint u = minus(b[1], b[0]);
    const GridPoint v = minus(b[2], b[0]);
    const std::array<Wide, 3> normal = {
        crossComponent(u, v, 0), crossComponent(u, v, 1), crossComponent(u, v, 2)};
    if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0)
    {
        return false;
    }
    std::array<int, 3> side{};
    for (std::size_t i = 0; i < 3; ++i)
    {
        side[i] = sideOf(b[0], b[1], b[2], a[i]);
    }
    if (std::abs(side[0] + side[1] + side[2]) == 3)
    {
        return false;
    }
    return segmentMeets(a[0], a[1], side[0], side[1], b, normal) ||
           segmentMeets(a[1], a[2], side[1], side[2], b, normal) ||
           segmentMeets(a[2], a[0], side[2], side[0], b, normal);
}
}  // namespace

GridPoint toGrid(const Eigen::Vector3d& point)
{
    GridPoint result{};
    for (int i = 0; i < 3; ++i)
    {
        if (!(std::abs(point[i]) <= kGridReach))
        {
            throw std::invalid_argument("exact check: coordinate " + std::to_string(point[i]) +
                                        " m is farther than 16 m from the mesh it is checked "
                                        "against: use smaller meshes");
        }
        const double grids = point[i] * kGridsPerMetre;
        result[static_cast<std::size_t>(i)] =
            static_cast<std::int64_t>(grids + (grids < 0.0 ? -0.5 : 0.5));
    }
    return result;
}

int sideOf(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d)
{
    // |coordinate| <= 2^40, differences <= 2^41, the sum of three products of three < 2^126.
    const GridPoint u = minus(b, a);
    const GridPoint v = minus(c, a);
    const GridPoint w = minus(d, a);
    Wide volume = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
        volume += crossComponent(u, v, k) * w[k];
    }
    return signOf(volume);
}

bool trianglesMeet(const GridTriangle& a, const GridTriangle& b)
{
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto [lowA, highA] = std::minmax({a[0][k], a[1][k], a[2][k]});
        const auto [lowB, highB] = std::minmax({b[0][k], b[1][k], b[2][k]});
        if (lowA > highB || lowB > highA)
        {
            return false;
        }
    }
    // Closed triangles meet exactly if an edge of one meets the other. (One inside the other, in
    // one plane, is among these: its edges are inside.)
    return edgesMeet(a, b) || edgesMeet(b, a);
}
}  // namespace bullet_ccd::reference
