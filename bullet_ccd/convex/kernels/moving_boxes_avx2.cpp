// Compiled for AVX2 and FMA; called only where the processor has them. README.md of the folder
// above says how it works; convex_toi.cpp does the same step by step, for every processor.
//
// Vectors have three numbers and a zero. Axes are stored as the rows of their matrix, so that the
// components of a direction along all three are three products of a number and a row.
#include "bullet_ccd/convex/certified_root.h"
#include "bullet_ccd/convex/kernels/moving_boxes.h"
#include "bullet_ccd/convex/sine_series.h"

#include <immintrin.h>
#include <limits>

namespace bullet_ccd::avx2
{
namespace
{
using Vector = double __attribute__((vector_size(32)));

Vector load3(const double* x)
{
    return _mm256_maskload_pd(x, _mm256_setr_epi64x(-1, -1, -1, 0));
}
Vector load3(const double* x, const double* y, const double* z)
{
    return _mm256_insertf128_pd(
        _mm256_castpd128_pd256(_mm_loadh_pd(_mm_load_sd(x), y)), _mm_load_sd(z), 1);
}
void store3(Vector v, double (&x)[3])
{
    for (int k = 0; k < 3; ++k)
    {
        x[k] = v[k];
    }
}
Vector next(Vector v)
{
    return __builtin_shufflevector(v, v, 1, 2, 0, 3);
}
Vector last(Vector v)
{
    return __builtin_shufflevector(v, v, 2, 0, 1, 3);
}
Vector cross(Vector a, Vector b)
{
    return next(a * next(b) - next(a) * b);
}
double sum(Vector v)
{
    return v[0] + v[1] + v[2];
}
double dot(Vector a, Vector b)
{
    return sum(a * b);
}
Vector sizeOf(Vector v)
{
    return v > -v ? v : -v;
}
Vector withSigns(Vector size, Vector of)
{
    return of < 0.0 ? -size : size;
}
Vector greater(Vector a, Vector b)
{
    return a > b ? a : b;
}
/// The sums of four vectors of four numbers.
Vector sums(Vector a, Vector b, Vector c, Vector d)
{
    const Vector ab =
        __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Vector cd =
        __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) +
           __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}
/// The number before a positive one.
double before(double x)
{
    long long bits = 0;
    __builtin_memcpy(&bits, &x, sizeof(bits));
    --bits;
    __builtin_memcpy(&x, &bits, sizeof(x));
    return x;
}
Vector roots(Vector a)
{
    return _mm256_sqrt_pd(a);
}
/// Which of the first three numbers are the same as x, as bits.
int equal(Vector v, double x)
{
    return _mm256_movemask_pd(v == Vector{x, x, x, x}) & 7;
}
/// The largest of the first three.
double largest(Vector v)
{
    const double most = v[0] > v[1] ? v[0] : v[1];
    return most > v[2] ? most : v[2];
}

/// Three axes as rows.
struct Axes
{
    Vector rows[3];

    /// The components of v along the axes.
    [[nodiscard]] Vector along(Vector v) const
    {
        return v[0] * rows[0] + v[1] * rows[1] + v[2] * rows[2];
    }
    /// The vector with these components.
    [[nodiscard]] Vector times(Vector v) const
    {
        return sums(v * rows[0], v * rows[1], v * rows[2], Vector{});
    }
    [[nodiscard]] Vector axis(int i) const
    {
        const auto numbers = reinterpret_cast<const double(*)[4]>(rows);
        return load3(&numbers[0][i], &numbers[1][i], &numbers[2][i]);
    }
};

/// Turning at constant speed: along + cos across + sin ahead.
struct TurningAxes
{
    Vector w;
    double rate;
    Axes along;
    Axes across;
    Axes ahead;

    explicit TurningAxes(const MovingBox& box) : w(load3(box.w)), rate(__builtin_sqrt(dot(w, w)))
    {
        const Vector u = rate > 0.0 ? w / rate : Vector{0.0, 0.0, 1.0, 0.0};
        const Axes start = {{load3(&box.axes[0][0], &box.axes[1][0], &box.axes[2][0]),
                             load3(&box.axes[0][1], &box.axes[1][1], &box.axes[2][1]),
                             load3(&box.axes[0][2], &box.axes[1][2], &box.axes[2][2])}};
        const Vector kept = start.along(u);
        for (int k = 0; k < 3; ++k)
        {
            const int k1 = (k + 1) % 3;
            const int k2 = (k + 2) % 3;
            along.rows[k] = u[k] * kept;
            across.rows[k] = start.rows[k] - along.rows[k];
            ahead.rows[k] = u[k1] * start.rows[k2] - u[k2] * start.rows[k1];
        }
    }
    [[nodiscard]] Axes at(double cosine, double sine) const
    {
        Axes axes;
        for (int k = 0; k < 3; ++k)
        {
            axes.rows[k] = along.rows[k] + cosine * across.rows[k] + sine * ahead.rows[k];
        }
        return axes;
    }
};

/// A direction that separates the boxes, and the features that it belongs to; see BoxAxis.
struct Separation
{
    Vector n{};
    Vector nA{};  ///< in A's axes
    Vector nB{};
    double gap = -std::numeric_limits<double>::infinity();
    int edgeA = -1;
    int edgeB = -1;
};

class BoxesSearch
{
public:
    explicit BoxesSearch(const MovingBoxes& boxes)
        : m_boxes(boxes),
          m_turnA(boxes.a),
          m_turnB(boxes.b),
          m_halfA(load3(boxes.a.half)),
          m_halfB(load3(boxes.b.half)),
          m_armA(load3(boxes.a.arm)),
          m_armB(load3(boxes.b.arm)),
          m_D0(load3(boxes.D0)),
          m_V(load3(boxes.V)),
          m_speed(__builtin_sqrt(dot(m_V, m_V))),
          m_rounding(std::numeric_limits<double>::epsilon() *
                     (32.0 * boxes.sizes +
                      4.0 * (m_turnA.rate * boxes.a.reach + m_turnB.rate * boxes.b.reach)))
    {
        setThreshold(boxes.threshold);
    }

    BoxesMeeting run()
    {
        using Outcome = BoxesMeeting::Outcome;
        double t = m_boxes.begin;
        while (m_found.looks < m_boxes.mostLooks)
        {
            ++m_found.looks;
            lookAt(t);
            // Where the features of the last axis still face each other, they are the closest.
            bool isFacing = m_found.looks > 1 && refresh() && isFaced();
            if (!isFacing)
            {
                findBest();
                isFacing = !isBeyond(m_threshold) && m_axis.gap > 0.0 && isFaced();
            }
            if (t == 0.0 && !isBeyond(m_threshold))
            {
                if (!isFacing || !touchesAtStart())
                {
                    break;
                }
            }
            else if (isFacing && m_axis.gap <= m_near)
            {
                store3(m_pointA - m_D, m_found.pointA);
                store3(m_pointB - m_D, m_found.pointB);
                store3(m_axis.n, m_found.normal);
                m_found.gap = m_axis.gap;
                return finish(Outcome::Hit, t);
            }
            else if (!isFacing && !isBeyond(m_near))
            {
                break;
            }
            const double later = advance(t);
            if (later >= m_boxes.end)
            {
                m_found.gap = m_margin;
                return finish(Outcome::Apart, 1.0);
            }
            if (later <= t)
            {
                break;
            }
            t = later;
        }
        // Who goes on from a later time does not know that they touched.
        return finish(Outcome::Open, m_found.touches ? 0.0 : t);
    }

private:
    [[nodiscard]] BoxesMeeting finish(BoxesMeeting::Outcome outcome, double t)
    {
        m_found.outcome = outcome;
        m_found.time = t;
        return m_found;
    }
    /// See PairLimits.
    void setThreshold(double threshold)
    {
        const double room = threshold - m_boxes.floor;
        m_threshold = threshold;
        m_margin = m_boxes.floor + m_boxes.aim * room;
        m_near = m_boxes.floor + (m_boxes.aim < 0.5 ? 2.0 * m_boxes.aim : 1.0) * room;
    }
    /// As ConvexQuery::touchesAtStart(), of boxes that face each other.
    bool touchesAtStart()
    {
        constexpr double kRestingSpeed = 1e-12;
        if (m_axis.gap <= m_boxes.floor + 4.0 * m_rounding)
        {
            return false;
        }
        const Vector closing = cross(m_turnA.w, m_pointA) - cross(m_turnB.w, m_pointB - m_D) - m_V;
        const double scale =
            m_speed + m_turnA.rate * m_boxes.a.reach + m_turnB.rate * m_boxes.b.reach;
        m_found.touches = true;
        m_found.presses = dot(m_axis.n, closing) > kRestingSpeed * scale;
        const double nearer = m_boxes.floor + 0.75 * (m_axis.gap - m_boxes.floor);
        setThreshold(nearer < m_threshold ? nearer : m_threshold);
        return true;
    }
    /// Whether the boxes are farther apart, whatever the rounding.
    [[nodiscard]] bool isBeyond(double distance) const
    {
        return m_axis.gap > distance + m_rounding;
    }

    void lookAt(double t)
    {
        const auto [sines, cosines] =
            sinesAndCosinesOf(Vector{m_turnA.rate * t, m_turnB.rate * t, 0.0, 0.0});
        m_A = m_turnA.at(cosines[0], sines[0]);
        m_B = m_turnB.at(cosines[1], sines[1]);
        m_D = m_D0 + t * m_V;
    }

    /// Takes a direction, whichever way it points, and the gap along it.
    void take(Vector n)
    {
        m_axis.nA = m_A.along(n);
        m_axis.nB = m_B.along(n);
        const double across = sum(n * m_D - m_axis.nA * m_armA + m_axis.nB * m_armB);
        const double reach = sum(sizeOf(m_axis.nA) * m_halfA + sizeOf(m_axis.nB) * m_halfB);
        const double sign = across < 0.0 ? -1.0 : 1.0;
        m_axis.n = sign * n;
        m_axis.nA = sign * m_axis.nA;
        m_axis.nB = sign * m_axis.nB;
        m_axis.gap = sign * across - reach;
    }

    bool refresh()
    {
        if (m_axis.edgeA < 0 || m_axis.edgeB < 0)
        {
            take(m_axis.edgeA < 0 ? m_B.axis(m_axis.edgeB) : m_A.axis(m_axis.edgeA));
            return m_axis.gap > 0.0;
        }
        const Vector n = cross(m_A.axis(m_axis.edgeA), m_B.axis(m_axis.edgeB));
        const double square = dot(n, n);
        if (!(square > kParallel))
        {
            return false;
        }
        take(n / __builtin_sqrt(square));
        return m_axis.gap > 0.0;
    }

    /// The best of fifteen. Which it is is as good as random, so branches would be guessed wrongly:
    /// all gaps come first.
    void findBest()
    {
        // A's axes and the way from B's middle to A's in the frame of B, and the other way round.
        const Vector columns[3] = {
            m_B.along(m_A.axis(0)), m_B.along(m_A.axis(1)), m_B.along(m_A.axis(2))};
        const Vector p = columns[0] * m_armA[0] + columns[1] * m_armA[1] + columns[2] * m_armA[2] -
                         m_B.along(m_D) - m_armB;
        const Vector rows[3] = {
            m_A.along(m_B.axis(0)), m_A.along(m_B.axis(1)), m_A.along(m_B.axis(2))};
        const Vector size[3] = {sizeOf(columns[0]), sizeOf(columns[1]), sizeOf(columns[2])};
        const Vector facesB = sizeOf(p) - m_halfB - m_halfA[0] * size[0] - m_halfA[1] * size[1] -
                              m_halfA[2] * size[2];
        const Vector facesA = sizeOf(p[0] * rows[0] + p[1] * rows[1] + p[2] * rows[2]) - m_halfA -
                              m_halfB[0] * sizeOf(rows[0]) - m_halfB[1] * sizeOf(rows[1]) -
                              m_halfB[2] * sizeOf(rows[2]);
        // Edges: see bestBoxAxis().
        const Vector p1 = next(p);
        const Vector p2 = last(p);
        const Vector halfB1 = next(m_halfB);
        const Vector halfB2 = last(m_halfB);
        Vector squares[3];
        for (int i = 0; i < 3; ++i)
        {
            const int i1 = (i + 1) % 3;
            const int i2 = (i + 2) % 3;
            const Vector right = next(columns[i]);
            const Vector left = last(columns[i]);
            const Vector reach = m_halfA[i1] * size[i2] + m_halfA[i2] * size[i1] +
                                 halfB1 * last(size[i]) + halfB2 * next(size[i]);
            const Vector length = right * right + left * left;
            const Vector gap = greater(sizeOf(p1 * left - p2 * right) - reach, Vector{});
            squares[i] = length > kParallel ? gap * gap / length : Vector{};
        }
        const double face = largest(greater(facesA, facesB));
        const double edge = largest(greater(greater(squares[0], squares[1]), squares[2]));
        // Where numbers overflow, nothing is equal: the first face is as good as any.
        const int faces = equal(facesA, face) | equal(facesB, face) << 3 | 1 << 6;
        const int edges = equal(squares[0], edge) | equal(squares[1], edge) << 3 |
                          equal(squares[2], edge) << 6 | 1 << 9;
        const bool isEdge = face <= 0.0 ? edge > 0.0 : edge > face * face;
        const int first = __builtin_ctz(static_cast<unsigned>(isEdge ? edges << 7 : faces));
        static constexpr std::int8_t kEdgesA[] = {
            0, 1, 2, -1, -1, -1, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2};
        static constexpr std::int8_t kEdgesB[] = {
            -1, -1, -1, 0, 1, 2, -1, 0, 1, 2, 0, 1, 2, 0, 1, 2};
        m_axis.edgeA = kEdgesA[first];
        m_axis.edgeB = kEdgesB[first];
        if (!refresh() && m_axis.gap > 0.0)
        {
            m_axis.gap = 0.0;  // edges that rounding calls parallel now
        }
    }

    /// Whether the features of the axis face each other: then their closest points are those of the
    /// boxes.
    bool isFaced()
    {
        Vector inA = withSigns(m_halfA, m_axis.nA) + m_armA;
        Vector inB = withSigns(m_halfB, -m_axis.nB) + m_armB;
        // Of a face or an edge that is parallel to the other's face, what is nearest to its middle.
        if (m_axis.edgeA < 0 && isFlat(m_axis.nA))
        {
            const Vector middle = m_A.along(m_D + m_B.times(m_armB)) - m_armA;
            inA = onFlat(inA - m_armA, m_axis.nA, middle, m_halfA) + m_armA;
        }
        else if (m_axis.edgeB < 0 && isFlat(m_axis.nB))
        {
            const Vector middle = m_B.along(m_A.times(m_armA) - m_D) - m_armB;
            inB = onFlat(inB - m_armB, m_axis.nB, middle, m_halfB) + m_armB;
        }
        const auto isWithin = [](Vector x, Vector half, int across)
        {
            const int k = (across + 1) % 3;
            const int m = (across + 2) % 3;
            return (static_cast<int>(x[k] <= half[k]) & static_cast<int>(x[m] <= half[m])) != 0;
        };
        if (m_axis.edgeA < 0)
        {
            m_pointA = m_A.times(inA);
            m_pointB = m_pointA + m_axis.gap * m_axis.n;
            return isWithin(sizeOf(m_B.along(m_pointA - m_D) - m_armB), m_halfB, m_axis.edgeB);
        }
        if (m_axis.edgeB < 0)
        {
            m_pointB = m_D + m_B.times(inB);
            m_pointA = m_pointB - m_axis.gap * m_axis.n;
            return isWithin(sizeOf(m_A.along(m_pointB) - m_armA), m_halfA, m_axis.edgeA);
        }
        inA[m_axis.edgeA] = m_armA[m_axis.edgeA];
        inB[m_axis.edgeB] = m_armB[m_axis.edgeB];
        const Vector a = m_A.axis(m_axis.edgeA);
        const Vector b = m_B.axis(m_axis.edgeB);
        const Vector middleA = m_A.times(inA);
        const Vector middleB = m_D + m_B.times(inB);
        const Vector between = middleB - middleA;
        const Vector products = sums(between * a, between * b, a * b, Vector{});
        const double square = 1.0 - products[2] * products[2];
        const double s = (products[0] - products[2] * products[1]) / square;
        const double u = (products[2] * products[0] - products[1]) / square;
        m_pointA = middleA + s * a;
        m_pointB = middleB + u * b;
        return __builtin_fabs(s) <= m_halfA[m_axis.edgeA] &&
               __builtin_fabs(u) <= m_halfB[m_axis.edgeB];
    }

    /// Whether a box has more than a corner in a direction, and its point there that is nearest to
    /// a place.
    static bool isFlat(Vector n) { return (_mm256_movemask_pd(sizeOf(n) <= kFlat) & 7) != 0; }
    static Vector onFlat(Vector corner, Vector n, Vector place, Vector half)
    {
        const Vector within = place > half ? half : place < -half ? -half : place;
        return sizeOf(n) <= kFlat ? within : corner;
    }

    /// How the direction turns, so that it stays normal to its features; see rateOfFeatures().
    [[nodiscard]] Vector turningOfAxis() const
    {
        if (m_axis.edgeA < 0)
        {
            return m_turnB.w;
        }
        if (m_axis.edgeB < 0)
        {
            return m_turnA.w;
        }
        const Vector n = m_axis.n;
        const Vector a = m_A.axis(m_axis.edgeA);
        const Vector b = m_B.axis(m_axis.edgeB);
        const Vector products = sums(
            a * cross(n, m_turnA.w), b * cross(n, m_turnB.w), a * b, n * (m_turnA.w + m_turnB.w));
        const double cosine = products[2];
        const double square = 1.0 - cosine * cosine;
        constexpr double kAlmostParallel = 1e-6;
        if (square < kAlmostParallel)
        {
            return -products[0] * cross(n, a);
        }
        const Vector change = ((products[0] - cosine * products[1]) / square) * a +
                              ((products[1] - cosine * products[0]) / square) * b;
        return 0.5 * products[3] * n - cross(n, change);
    }

    /// How far the direction certifies; see GapAlong and ConvexQuery::advance().
    double advance(double begin)
    {
        const double margin = m_margin + m_rounding;
        double room = m_axis.gap - margin;
        if (!(room > 0.0))
        {
            return begin;
        }
        const Vector n = m_axis.n;
        Vector w = turningOfAxis();
        if (!(dot(w, w) < kMostTurning * kMostTurning))
        {
            w = m_turnB.w;  // edges that are almost parallel; any other turning will do
        }
        const Vector turning = cross(w, n);
        const Vector ofA = m_turnA.w - w;
        const Vector ofB = m_turnB.w - w;
        const Vector bendA = cross(w, ofA);
        const Vector bendB = cross(w, ofB);
        const Vector sizes = roots(sums(turning * turning, bendA * bendA, bendB * bendB, w * w));
        const double rateOfAxis = sizes[3];
        const double bend = (sizes[0] * (rateOfAxis * m_boxes.farthest + 2.0 * m_speed) +
                             (dot(ofA, ofA) + sizes[1]) * m_boxes.a.reach +
                             (dot(ofB, ofB) + sizes[2]) * m_boxes.b.reach) *
                            (1.0 + 1e-12);
        const Vector inA = withSigns(m_halfA, m_axis.nA) + m_armA;
        const Vector inB = withSigns(m_halfB, -m_axis.nB) + m_armB;
        double rate = sum(n * m_V + turning * m_D - inA * m_A.along(cross(n, ofA)) +
                          inB * m_B.along(cross(n, ofB)));
        const Vector u = rateOfAxis > 0.0 ? w / rateOfAxis : Vector{};
        const Vector ahead = cross(u, n);
        const Vector inward = cross(u, ahead);

        double t = begin;
        const double little = 0.25 * room;
        constexpr int kProbes = 4;
        for (int probe = 0; probe < kProbes && room > little; ++probe)
        {
            ++m_found.probes;
            double length = m_boxes.end - t;
            if (-rate * length > room)
            {
                length = room / -rate;
            }
            // Where the bend is what counts, a shorter look sees farther.
            if (bend * length * length > 4.0 * room)
            {
                const double shorter = __builtin_sqrt(4.0 * room / bend);
                length = shorter < length ? shorter : length;
            }
            const bool isToEnd = length >= m_boxes.end - t;
            const double there = isToEnd ? m_boxes.end : t + length;
            const double later = there - begin;
            const auto [sines, cosines] = sinesAndCosinesOf(
                Vector{m_turnA.rate * there, m_turnB.rate * there, rateOfAxis * later, 0.0});
            const Vector nThere = n + sines[2] * ahead + (1.0 - cosines[2]) * inward;
            const Vector nA = m_turnA.at(cosines[0], sines[0]).along(nThere);
            const Vector nB = m_turnB.at(cosines[1], sines[1]).along(nThere);
            const double gap = sum(nThere * (m_D0 + there * m_V) - nA * m_armA + nB * m_armB -
                                   sizeOf(nA) * m_halfA - sizeOf(nB) * m_halfB);
            const double roomThere = gap - margin;
            const double root = certifiedRoot(room, roomThere, there - t, bend);
            if (root < there - t)
            {
                const double reached = before(t + root);
                return reached > begin ? reached : begin;
            }
            if (isToEnd)
            {
                return m_boxes.end;
            }
            rate = (roomThere - room) / (there - t);
            room = roomThere;
            t = there;
        }
        return t;
    }

    /// Edges whose sine has no larger square give no direction.
    static constexpr double kParallel = 1e-10;
    /// See facingPoints().
    static constexpr double kFlat = 1e-15;

    const MovingBoxes& m_boxes;
    TurningAxes m_turnA;
    TurningAxes m_turnB;
    Vector m_halfA;
    Vector m_halfB;
    Vector m_armA;
    Vector m_armB;
    Vector m_D0;
    Vector m_V;
    double m_speed;
    double m_rounding;
    double m_threshold = 0.0;
    double m_margin = 0.0;  ///< no step goes below this distance
    double m_near = 0.0;    ///< near enough to stop

    Axes m_A;  ///< where they are
    Axes m_B;
    Vector m_D;
    Separation m_axis;
    Vector m_pointA{};  ///< from A's reference
    Vector m_pointB{};
    BoxesMeeting m_found;
};
}  // namespace

BoxesMeeting meetingOfBoxes(const MovingBoxes& boxes)
{
    return BoxesSearch(boxes).run();
}
}  // namespace bullet_ccd::avx2
