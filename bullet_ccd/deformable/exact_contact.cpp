#include "bullet_ccd/deformable/exact_contact.h"

#include "bullet_ccd/deformable/big_integer.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// A point whose coordinates are polynomials of time.
using MovingPoint = std::array<Polynomial, 3>;

MovingPoint operator-(const MovingPoint& a, const MovingPoint& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

MovingPoint operator+(const MovingPoint& a, const MovingPoint& b)
{
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

Polynomial dot(const MovingPoint& a, const MovingPoint& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

MovingPoint cross(const MovingPoint& a, const MovingPoint& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// x = mantissa 2^exponent, mantissa odd or 0.
struct Number
{
    std::int64_t mantissa = 0;
    std::int32_t exponent = 0;
};

Number numberOf(double x)
{
    if (x == 0.0)
    {
        return {};
    }
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto field = static_cast<std::int32_t>(bits >> 52U & 0x7FFU);  // 0: subnormal
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52U) - 1U);
    const std::uint64_t size = field == 0 ? fraction : fraction | std::uint64_t{1} << 52U;
    const int zeros = std::countr_zero(size);
    const auto mantissa = static_cast<std::int64_t>(size >> static_cast<unsigned>(zeros));
    return {x < 0.0 ? -mantissa : mantissa, std::max(field, 1) - 1075 + zeros};
}

/// The four vertices as polynomials, and a distance, over a common power of two.
struct ExactPair
{
    std::array<MovingPoint, 4> vertices;
    BigInteger distance;
};

ExactPair exactPair(const ElementaryPair& pair, double distance)
{
    std::int32_t least = std::numeric_limits<std::int32_t>::max();
    const auto look = [&least](double x)
    { least = x == 0.0 ? least : std::min(least, numberOf(x).exponent); };
    look(distance);
    for (const FourPoints* points : {&pair.start, &pair.end})
    {
        for (const Eigen::Vector3d& x : *points)
        {
            std::ranges::for_each(x, look);
        }
    }
    const auto whole = [least](double x)
    {
        const Number number = numberOf(x);
        return number.mantissa == 0 ? BigInteger()
                                    : BigInteger(number.mantissa).shifted(number.exponent - least);
    };
    ExactPair exact{.vertices = {}, .distance = whole(distance)};
    for (std::size_t k = 0; k < 4; ++k)
    {
        for (int c = 0; c < 3; ++c)
        {
            const BigInteger start = whole(pair.start[k][c]);
            const BigInteger end = whole(pair.end[k][c]);
            const BigInteger way = end - start;
            exact.vertices[k][static_cast<std::size_t>(c)] = way.sign() != 0
                                                                 ? Polynomial{start, way}
                                                             : start.sign() != 0 ? Polynomial{start}
                                                                                 : Polynomial{};
        }
    }
    return exact;
}

/// A time at which signs of polynomials are known: a dyadic number, or the one root of `equation`
/// between `low` and `high`.
struct Moment
{
    const Polynomial* equation = nullptr;  ///< null: the time is `low`
    Dyadic low{};
    Dyadic high{};

    [[nodiscard]] int sign(const Polynomial& p) const
    {
        if (equation == nullptr || p.size() <= 1)
        {
            return scaledValue(p, low).sign();
        }
        const BigInteger atLow = scaledValue(p, low);
        return exceedsItsChange(p, atLow) ? atLow.sign() : tarskiQuery(*equation, p, low, high);
    }

private:
    /// |p(low)| > (high - low) max |p'|: p keeps its sign up to `high`. Bounds have one shift.
    [[nodiscard]] bool exceedsItsChange(const Polynomial& p, const BigInteger& atLow) const
    {
        BigInteger slope;
        for (const BigInteger& c : derivative(p))
        {
            slope = c.sign() < 0 ? slope - c : slope + c;
        }
        const BigInteger change =
            (slope * (high.numerator - low.numerator))
                .shifted(low.shift * (static_cast<std::int32_t>(p.size()) - 2));
        return compareSizes(atLow, change) > 0;
    }
};

/// low + (high - low) part / 16, of bounds with one shift.
Dyadic between(const Dyadic& low, const Dyadic& high, std::int64_t part)
{
    return {low.numerator.shifted(4) + (high.numerator - low.numerator) * BigInteger(part),
            low.shift + 4};
}

Moment momentAt(std::int64_t time)
{
    return {.low = {BigInteger(time), 0}};
}

bool isBefore(const Dyadic& a, const Dyadic& b)
{
    return (a.numerator.shifted(b.shift) - b.numerator.shifted(a.shift)).sign() < 0;
}

/// Bits of the largest coefficient.
std::int64_t bitsOf(const Polynomial& p)
{
    std::int64_t bits = 0;
    for (const BigInteger& c : p)
    {
        bits = std::max(bits, c.bits());
    }
    return bits;
}

/// Shrinks the interval around a root at which the polynomial changes its sign: to 2^-39 by a guess
/// in double precision and from there to 2^-73 by a step of Newton's, if that can be confirmed.
/// Otherwise it stays.
void narrow(Moment& moment)
{
    constexpr std::int32_t kShift = 50;
    constexpr std::int64_t kHalfWidth = std::int64_t{1} << 10;
    constexpr std::int32_t kMore = 30;
    constexpr std::int64_t kHalfWidthThen = std::int64_t{1} << 6;
    const Polynomial& p = *moment.equation;
    const std::int64_t bits = bitsOf(p);
    std::vector<double> coefficients;
    for (const BigInteger& c : p)
    {
        coefficients.push_back(c.toDouble(bits));
    }
    const auto value = [&](double t)
    {
        double sum = 0.0;
        for (std::size_t i = coefficients.size(); i-- > 0;)
        {
            sum = sum * t + coefficients[i];
        }
        return sum;
    };
    double low = moment.low.numerator.toDouble(moment.low.shift);
    double high = moment.high.numerator.toDouble(moment.high.shift);
    const bool rises = value(low) < 0.0;
    for (int i = 0; i < 54; ++i)
    {
        const double middle = 0.5 * (low + high);
        ((value(middle) < 0.0) == rises ? low : high) = middle;
    }
    const auto confirm = [&](const BigInteger& middle, std::int64_t halfWidth, std::int32_t shift)
    {
        const auto within = [&](std::int64_t way)
        {
            const Dyadic bound{middle + BigInteger(way), shift};
            const Dyadic& end = way < 0 ? moment.low : moment.high;
            const bool isBeyond = way < 0 ? isBefore(bound, end) : isBefore(end, bound);
            return isBeyond ? Dyadic{end.numerator.shifted(shift - end.shift), shift} : bound;
        };
        if (shift < moment.low.shift)
        {
            return false;
        }
        const Dyadic below = within(-halfWidth);
        const Dyadic above = within(halfWidth);
        const bool isConfirmed = isBefore(below, above) &&
                                 scaledValue(p, below).sign() * scaledValue(p, above).sign() < 0;
        if (isConfirmed)
        {
            moment.low = below;
            moment.high = above;
        }
        return isConfirmed;
    };
    const auto guess = static_cast<std::int64_t>(std::ldexp(low, kShift));
    if (!confirm(BigInteger(guess), kHalfWidth, kShift))
    {
        return;
    }
    double slope = 0.0;
    for (std::size_t i = coefficients.size(); i-- > 1;)
    {
        slope = slope * low + static_cast<double>(i) * coefficients[i];
    }
    const auto degree = static_cast<std::int64_t>(p.size()) - 1;
    const double step = std::ldexp(
        -scaledValue(p, moment.low).toDouble(bits + kShift * degree) / slope, kShift + kMore);
    if (std::abs(step) < 0x1p62)
    {
        confirm(moment.low.numerator.shifted(kMore) + BigInteger(static_cast<std::int64_t>(step)),
                kHalfWidthThen,
                kShift + kMore);
    }
}

/// How often the coefficients of p in Bernstein's basis on [0, 1] change their sign: p has at most
/// so many roots in (0, 1), and exactly one if it is one.
int bernsteinChanges(const Polynomial& p)
{
    const auto binomial = [](std::size_t n, std::size_t k)
    {
        std::int64_t value = 1;
        for (std::size_t i = 0; i < k; ++i)
        {
            value = value * static_cast<std::int64_t>(n - i) / static_cast<std::int64_t>(i + 1);
        }
        return value;
    };
    const std::size_t degree = p.size() - 1;
    int changes = 0;
    int last = 0;
    for (std::size_t k = 0; k <= degree; ++k)
    {
        BigInteger coefficient;  // times the binomial of degree and k
        for (std::size_t i = 0; i <= k; ++i)
        {
            coefficient = coefficient + p[i] * BigInteger(binomial(degree - i, k - i));
        }
        const int sign = coefficient.sign();
        changes += sign != 0 && last != 0 && sign != last ? 1 : 0;
        last = sign != 0 ? sign : last;
    }
    return changes;
}

/// Appends a moment for every root of `p`, which is not zero, in the open interval (low, high).
/// @pre neither bound is a root
void appendRoots(const Polynomial& p,
                 const Dyadic& low,
                 const Dyadic& high,
                 std::vector<Moment>& moments)
{
    const int count = tarskiQuery(p, {BigInteger(1)}, low, high);
    if (count == 0)
    {
        return;
    }
    if (count == 1)
    {
        moments.push_back({.equation = &p, .low = low, .high = high});
        narrow(moments.back());
        return;
    }
    // Of nine places one is no root, because the degree is at most six.
    std::int64_t part = 4;
    while (scaledValue(p, between(low, high, part)).sign() == 0)
    {
        ++part;
    }
    const Dyadic middle = between(low, high, part);
    appendRoots(p, {low.numerator.shifted(4), low.shift + 4}, middle, moments);
    appendRoots(p, middle, {high.numerator.shifted(4), high.shift + 4}, moments);
}

/// `p` without the roots 0 and 1.
Polynomial withoutEnds(Polynomial p)
{
    while (p.front().sign() == 0)
    {
        p.erase(p.begin());
    }
    const Dyadic one{BigInteger(1), 0};
    while (scaledValue(p, one).sign() == 0)
    {
        // p = (t - 1) r: from the highest coefficient down, r[i - 1] = p[i] + r[i].
        Polynomial r(p.begin() + 1, p.end());
        for (std::size_t i = r.size() - 1; i-- > 0;)
        {
            r[i] = r[i] + r[i + 1];
        }
        p = std::move(r);
    }
    return p;
}

class ExactTriangle
{
public:
    explicit ExactTriangle(const std::array<MovingPoint, 3>& corners) : m_corners(corners) {}

    [[nodiscard]] bool meetsOrigin()
    {
        const Polynomial determinant = dot(m_corners[2], crossed(0));
        if (!determinant.empty())
        {
            return holdsAtEnd(determinant, 0) || holdsAtEnd(determinant, 1) ||
                   holdsAtRoots(determinant);
        }
        // The origin is in the plane of the triangle all the time. The first contact is at the
        // start, or an edge comes to the origin (the cross product of its corners becomes zero), or
        // it is on the line of an edge all the time, and a corner comes to it.
        if (contains(momentAt(0)) || contains(momentAt(1)))
        {
            return true;
        }
        for (std::size_t k = 0; k < 3; ++k)
        {
            for (const MovingPoint& point : {crossed(k), m_corners[k]})
            {
                // It is zero at roots of any of its components only.
                const auto component = std::ranges::find_if_not(point, &Polynomial::empty);
                if (component != point.end() && holdsAtRoots(*component))
                {
                    return true;
                }
            }
        }
        return false;
    }

    /// Whether the origin comes as near as the distance, which is positive. When it first does,
    /// time begins, or a corner, the nearest point within an edge, or that within the face is
    /// exactly so far away.
    [[nodiscard]] bool comesWithin(const BigInteger& distance)
    {
        const Polynomial limit{distance * distance};
        for (std::size_t k = 0; k < 3; ++k)
        {
            const MovingPoint& corner = m_corners[k];
            const MovingPoint& next = m_corners[(k + 1) % 3];
            const MovingPoint edge = next - corner;
            const Polynomial length = dot(edge, edge);
            const Polynomial from = dot(corner, edge);
            const Polynomial to = dot(next, edge);
            const auto isWithinEdge = [&](const Moment& moment)
            { return moment.sign(from) <= 0 && moment.sign(to) >= 0 && moment.sign(length) > 0; };
            if (isReached(dot(corner, corner) - limit, [](const Moment&) { return true; }) ||
                isReached(dot(crossed(k), crossed(k)) - limit * length, isWithinEdge))
            {
                return true;
            }
        }
        const Polynomial determinant = dot(m_corners[2], crossed(0));
        const Polynomial area = dot(normal(), normal());
        const auto isWithinFace = [&](const Moment& moment)
        {
            return moment.sign(side(0)) >= 0 && moment.sign(side(1)) >= 0 &&
                   moment.sign(side(2)) >= 0 && moment.sign(area) > 0;
        };
        return isReached(determinant * determinant - limit * area, isWithinFace);
    }

private:
    [[nodiscard]] bool holdsAtEnd(const Polynomial& determinant, std::int64_t time)
    {
        const Moment moment = momentAt(time);
        return moment.sign(determinant) == 0 && contains(moment);
    }
    [[nodiscard]] bool holdsAtRoots(const Polynomial& p)
    {
        return holdsAtRoots(p, [this](const Moment& moment) { return contains(moment); });
    }
    /// Whether the condition holds at the start or the end with p <= 0, or at a root of p.
    template <class Condition>
    [[nodiscard]] static bool isReached(const Polynomial& p, const Condition& condition)
    {
        for (const std::int64_t time : {0, 1})
        {
            const Moment moment = momentAt(time);
            if (moment.sign(p) <= 0 && condition(moment))
            {
                return true;
            }
        }
        return !p.empty() && holdsAtRoots(p, condition);
    }
    template <class Condition>
    [[nodiscard]] static bool holdsAtRoots(const Polynomial& p, const Condition& condition)
    {
        const Polynomial inner = withoutEnds(p);
        std::vector<Moment> moments;
        const int most = bernsteinChanges(inner);
        if (most == 1)
        {
            moments.push_back(
                {.equation = &inner, .low = momentAt(0).low, .high = momentAt(1).low});
            narrow(moments.back());
        }
        else if (most > 1)
        {
            appendRoots(inner, momentAt(0).low, momentAt(1).low, moments);
        }
        return std::ranges::any_of(moments, condition);
    }

    /// Whether the triangle contains the origin at a moment when it lies in one plane with it.
    [[nodiscard]] bool contains(const Moment& moment)
    {
        if (const std::optional<bool> known = containsAlongAxis(moment))
        {
            return *known;
        }
        // The three sides add up to the square of the normal, so one of them is positive, unless
        // the normal is zero.
        bool hasNormal = false;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const int sign = moment.sign(side(k));
            if (sign < 0)
            {
                return false;
            }
            hasNormal = hasNormal || sign > 0;
        }
        if (hasNormal)
        {
            return true;
        }
        // All corners on a line: on one of the edges?
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto isZero = [&](const Polynomial& p) { return moment.sign(p) == 0; };
            if (std::ranges::all_of(crossed(k), isZero) &&
                moment.sign(dot(m_corners[k], m_corners[(k + 1) % 3])) <= 0)
            {
                return true;
            }
        }
        return false;
    }

    /// What contains() says, where double precision can tell a component of the normal from 0. In
    /// one plane with the origin, the cross products of corners are parallel to the normal, so that
    /// the signs of sides are those of one component.
    [[nodiscard]] std::optional<bool> containsAlongAxis(const Moment& moment) const
    {
        // Coordinates are at most 1 in size at both ends, hence at all times, and change by at most
        // 2. With u = 2^-53, a time that is off by half a width and conversions leave them off by
        // e = width + 20 u, cross products by less than 4.3 e, and the sum of three by 14 e.
        const double from = moment.low.numerator.toDouble(moment.low.shift);
        const double to =
            moment.equation == nullptr ? from : moment.high.numerator.toDouble(moment.high.shift);
        const double error = 16.0 * (to - from + 0x1p-48);
        std::int64_t bits = 0;
        for (const MovingPoint& corner : m_corners)
        {
            for (const Polynomial& x : corner)
            {
                bits = std::max(bits, bitsOf(x));
            }
        }
        std::array<Eigen::Vector3d, 3> corners;
        for (std::size_t k = 0; k < 3; ++k)
        {
            for (std::size_t i = 0; i < 3; ++i)
            {
                const Polynomial& x = m_corners[k][i];
                const double start = x.empty() ? 0.0 : x[0].toDouble(bits + 1);
                const double way = x.size() < 2 ? 0.0 : x[1].toDouble(bits + 1);
                corners[k][static_cast<Eigen::Index>(i)] = start + 0.5 * (from + to) * way;
            }
        }
        const std::array<Eigen::Vector3d, 3> crosses{corners[0].cross(corners[1]),
                                                     corners[1].cross(corners[2]),
                                                     corners[2].cross(corners[0])};
        const Eigen::Vector3d normal = crosses[0] + crosses[1] + crosses[2];
        Eigen::Index axis = 0;
        if (!(normal.cwiseAbs().maxCoeff(&axis) > error) || !(error < 0.01))
        {
            return std::nullopt;
        }
        const auto signAlong = [&](std::size_t k)
        {
            const double nearly = crosses[k][axis];
            if (std::abs(nearly) > error)
            {
                return nearly > 0.0 ? 1 : -1;
            }
            const auto i = static_cast<std::size_t>(axis + 1) % 3;
            const std::size_t j = (i + 1) % 3;
            const MovingPoint& a = m_corners[k];
            const MovingPoint& b = m_corners[(k + 1) % 3];
            return moment.sign(a[i] * b[j] - a[j] * b[i]);
        };
        const int sign = normal[axis] > 0.0 ? 1 : -1;
        return signAlong(0) != -sign && signAlong(1) != -sign && signAlong(2) != -sign;
    }

    /// The cross product of corners k and k + 1.
    [[nodiscard]] const MovingPoint& crossed(std::size_t k)
    {
        if (!m_crosses[k])
        {
            m_crosses[k] = cross(m_corners[k], m_corners[(k + 1) % 3]);
        }
        return *m_crosses[k];
    }
    [[nodiscard]] const MovingPoint& normal()
    {
        if (!m_normal)
        {
            m_normal = crossed(0) + crossed(1) + crossed(2);
        }
        return *m_normal;
    }
    /// Positive where the origin is on the inner side of the edge from corner k on.
    [[nodiscard]] const Polynomial& side(std::size_t k)
    {
        if (!m_sides[k])
        {
            m_sides[k] = dot(crossed(k), normal());
        }
        return *m_sides[k];
    }

    std::array<MovingPoint, 3> m_corners;
    std::array<std::optional<MovingPoint>, 3> m_crosses;
    std::optional<MovingPoint> m_normal;
    std::array<std::optional<Polynomial>, 3> m_sides;
};
}  // namespace

bool featuresTouch(const ElementaryPair& pair, double distance)
{
    const ExactPair exact = exactPair(pair, distance);
    const std::array<MovingPoint, 4>& x = exact.vertices;
    const auto meets = [&](const std::array<MovingPoint, 3>& corners)
    {
        ExactTriangle triangle(corners);
        return distance > 0.0 ? triangle.comesWithin(exact.distance) : triangle.meetsOrigin();
    };
    if (pair.kind == ElementaryKind::VertexFace)
    {
        return meets({x[1] - x[0], x[2] - x[0], x[3] - x[0]});
    }
    const MovingPoint diagonal = x[2] - x[0];
    const MovingPoint opposite = x[3] - x[1];
    return meets({diagonal, x[3] - x[0], opposite}) || meets({diagonal, opposite, x[2] - x[1]});
}
}  // namespace bullet_ccd
