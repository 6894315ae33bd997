#include "bullet_ccd/hierarchy/ssv_axes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Matrix3f;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// Axes along `first` and, as far as it is orthogonal to it, `second`; any that fit where these
/// are zero, parallel or not finite.
SsvAxes makeAxes(const Vector3d& first, const Vector3d& second)
{
    const double length = first.norm();
    const bool usable = length > 0.0 && length < std::numeric_limits<double>::infinity();
    const Vector3d e0 = usable ? Vector3d(first / length) : Vector3d(Vector3d::UnitX());
    Vector3d e1 = second - e0.dot(second) * e0;
    const double height = e1.norm();
    e1 = height > 1e-9 * second.norm() ? Vector3d(e1 / height) : e0.unitOrthogonal();
    // Once more: what was left along the first axis grew with the division.
    e1 = (e1 - e0.dot(e1) * e0).normalized();
    return {.axis0 = toFloats(e0), .axis1 = toFloats(e1)};
}

/// Axes that are unit and orthogonal already but for 1e-5: one step of Newton's method leaves
/// 1e-10.
SsvAxes straightened(const Vector3d& first, const Vector3d& second)
{
    const Vector3d e0 = (1.5 - 0.5 * first.squaredNorm()) * first;
    const Vector3d across = second - e0.dot(second) * e0;
    return {.axis0 = toFloats(e0), .axis1 = toFloats((1.5 - 0.5 * across.squaredNorm()) * across)};
}

/// Measure of a box to be made small: its surface, and a little of its width so that flat boxes are
/// told apart.
template <class Number, class T>
T boxMeasure(T x, T y, T z)
{
    const T width = x + y + z;
    return x * y + y * z + z * x + Number(0.1) * width * width;
}

/// Boxes around a few points each that are turned step by step: a box in every lane, so that no
/// step waits for the one before and none has to be guessed.
class TurningBoxes
{
public:
    static constexpr std::size_t kMostPoints = 32;

    TurningBoxes()
    {
        for (FourNumbers(&points)[kMostPoints] : m_points)
        {
            points[0] = FourNumbers{};
        }
    }
    void add(std::size_t lane, float x, float y, float z)
    {
        const std::size_t i = m_counts[lane]++;
        m_points[0][i][lane] = x;
        m_points[1][i][lane] = y;
        m_points[2][i][lane] = z;
    }

    /// Turns about each axis in turn by less and less as long as that makes the box smaller; a long
    /// side by a fraction of its slope against the short one.
    void turnUntilSmall()
    {
        repeatPoints();
        for (std::size_t k = 0; k < 3; ++k)
        {
            FourRanges range;
            for (std::size_t i = 0; i < m_count; ++i)
            {
                range.add(m_points[k][i]);
            }
            m_sizes[k] = range.high - range.low;
        }
        m_measures = boxMeasure<float>(m_sizes[0], m_sizes[1], m_sizes[2]);
        for (const float step : {0.8F, 0.35F, 0.15F, 0.06F})
        {
            tryTurns<0>(step);
            tryTurns<1>(step);
            tryTurns<2>(step);
        }
    }

    /// Columns, in the axes of the points; longest side first.
    [[nodiscard]] Matrix3f axes(std::size_t lane) const
    {
        std::array<std::size_t, 3> order = {0, 1, 2};
        for (const std::size_t i : {0U, 1U, 0U})
        {
            if (m_sizes[order[i]][lane] < m_sizes[order[i + 1]][lane])
            {
                std::swap(order[i], order[i + 1]);
            }
        }
        Matrix3f axes;
        for (int k = 0; k < 3; ++k)
        {
            const FourNumbers(&axis)[3] = m_axes[order[static_cast<std::size_t>(k)]];
            axes.col(k) << axis[0][lane], axis[1][lane], axis[2][lane];
        }
        return axes;
    }

private:
    /// Lanes with fewer points than others repeat their first, empty ones have the origin.
    void repeatPoints()
    {
        m_count = *std::max_element(m_counts.begin(), m_counts.end());
        for (std::size_t lane = 0; lane < m_counts.size(); ++lane)
        {
            for (std::size_t i = m_counts[lane]; i < m_count; ++i)
            {
                for (FourNumbers(&points)[kMostPoints] : m_points)
                {
                    points[i][lane] = points[0][lane];
                }
            }
        }
    }

    /// Turns about axis k one way or the other where that makes a box smaller.
    template <std::size_t k>
    void tryTurns(float step)
    {
        constexpr std::size_t u = (k + 1) % 3;
        constexpr std::size_t v = (k + 2) % 3;
        const FourNumbers slope = smaller(m_sizes[u], m_sizes[v]) / larger(m_sizes[u], m_sizes[v]);
        const FourNumbers h = 0.5F * (step * slope);  // tangent of half the angle: without a root
        const FourNumbers scale = 1.0F / (1.0F + h * h);
        const FourNumbers c = (1.0F - h * h) * scale;
        const FourNumbers s = 2.0F * h * scale;
        FourRanges rangesU[2];
        FourRanges rangesV[2];
        for (std::size_t i = 0; i < m_count; ++i)
        {
            const FourNumbers cu = c * m_points[u][i];
            const FourNumbers su = s * m_points[u][i];
            const FourNumbers cv = c * m_points[v][i];
            const FourNumbers sv = s * m_points[v][i];
            rangesU[0].add(cu + sv);
            rangesV[0].add(cv - su);
            rangesU[1].add(cu - sv);
            rangesV[1].add(cv + su);
        }
        FourNumbers sizesU[2];
        FourNumbers sizesV[2];
        FourNumbers measures[2];
        for (std::size_t way = 0; way < 2; ++way)
        {
            sizesU[way] = rangesU[way].high - rangesU[way].low;
            sizesV[way] = rangesV[way].high - rangesV[way].low;
            measures[way] = boxMeasure<float>(m_sizes[k], sizesU[way], sizesV[way]);
        }
        const auto isFirst = measures[0] <= measures[1];
        const FourNumbers measure = isFirst ? measures[0] : measures[1];
        const auto isSmaller = (slope > 1e-4F) & (measure < 0.99999F * m_measures);
        if ((isSmaller[0] | isSmaller[1] | isSmaller[2] | isSmaller[3]) == 0)
        {
            return;
        }
        m_measures = isSmaller ? measure : m_measures;
        m_sizes[u] = isSmaller ? (isFirst ? sizesU[0] : sizesU[1]) : m_sizes[u];
        m_sizes[v] = isSmaller ? (isFirst ? sizesV[0] : sizesV[1]) : m_sizes[v];
        const FourNumbers none{};
        turn(u, v, isSmaller ? c : none + 1.0F, isSmaller ? (isFirst ? s : -s) : none);
    }

    void turn(std::size_t u, std::size_t v, FourNumbers c, FourNumbers s)
    {
        const auto turnOne = [c, s](FourNumbers& x, FourNumbers& y)
        {
            const FourNumbers before = x;
            x = c * x + s * y;
            y = c * y - s * before;
        };
        for (std::size_t i = 0; i < m_count; ++i)
        {
            turnOne(m_points[u][i], m_points[v][i]);
        }
        for (std::size_t i = 0; i < 3; ++i)
        {
            turnOne(m_axes[u][i], m_axes[v][i]);
        }
    }

    FourNumbers m_points[3][kMostPoints];  ///< coordinates along the sides
    std::array<std::size_t, 4> m_counts{};
    std::size_t m_count = 0;  ///< the largest
    FourNumbers m_axes[3][3] = {{FourNumbers{} + 1.0F, FourNumbers{}, FourNumbers{}},
                                {FourNumbers{}, FourNumbers{} + 1.0F, FourNumbers{}},
                                {FourNumbers{}, FourNumbers{}, FourNumbers{} + 1.0F}};
    FourNumbers m_sizes[3] = {};
    FourNumbers m_measures{};
};

struct Spread
{
    Matrix3d axes = Matrix3d::Identity();   ///< columns: largest spread first
    Vector3d deviation = Vector3d::Ones();  ///< along the axes, in any unit
};

Spread principalSpread(const SsvPoints& points)
{
    const std::size_t stride = points.stride();
    FourNumbers sum[3] = {};
    FourNumbers square[6] = {};
    float count = 0.0F;
    for (std::size_t i = 0; i < points.fours(); i += stride)
    {
        const FourNumbers x = points.numbers(0, i);
        const FourNumbers y = points.numbers(1, i);
        const FourNumbers z = points.numbers(2, i);
        sum[0] += x;
        sum[1] += y;
        sum[2] += z;
        square[0] += x * x;
        square[1] += x * y;
        square[2] += x * z;
        square[3] += y * y;
        square[4] += y * z;
        square[5] += z * z;
        count += 4.0F;
    }
    const auto total = [](FourNumbers x) { return (x[0] + x[2]) + (x[1] + x[3]); };
    const Vector3d mean =
        Vector3f(total(sum[0]), total(sum[1]), total(sum[2])).cast<double>() / count;
    Matrix3d spread;
    for (int i = 0, n = 0; i < 3; ++i)
    {
        for (int k = i; k < 3; ++k, ++n)
        {
            spread(i, k) = spread(k, i) = total(square[n]) / count - mean[i] * mean[k];
        }
    }
    const double largest = spread.cwiseAbs().maxCoeff();
    Spread result;
    if (!(largest > 0.0))
    {
        return result;
    }
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(spread / largest);
    if (solver.eigenvectors().allFinite())
    {
        result.axes = solver.eigenvectors().rowwise().reverse();
        result.deviation = solver.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
    }
    return result;
}

Spread spreadAlong(const SsvPoints& points, const SsvAxes& axes)
{
    Spread spread{.axes = axes.matrix()};
    if (points.count() <= TurningBoxes::kMostPoints)
    {
        return spread;  // all points are taken, however they are stretched
    }
    const Matrix3f columns = spread.axes.cast<float>();
    const std::size_t stride = points.stride();
    FourRanges ranges[3];
    for (std::size_t i = 0; i < points.fours(); i += stride)
    {
        for (int k = 0; k < 3; ++k)
        {
            ranges[k].add(points.along(columns.col(k), i));
        }
    }
    const FourNumbers sizes = sizesOf(ranges[0], ranges[1], ranges[2], ranges[2]);
    for (int k = 0; k < 3; ++k)
    {
        spread.deviation[k] = static_cast<double>(sizes[k]);
    }
    return spread;
}

/// The extremes along the axes, the diagonals of the widest face and the space diagonals, stretched
/// with the set.
void addExtremes(const SsvPoints& points,
                 const Spread& spread,
                 std::size_t lane,
                 TurningBoxes& boxes)
{
    constexpr int kDirections = 9;
    using Places = std::int32_t __attribute__((vector_size(16)));
    /// In every lane how far its points reach, and where the first of those that reach so far is.
    struct Extreme
    {
        FourNumbers height = FourNumbers{} - std::numeric_limits<float>::infinity();
        Places at{};

        void take(FourNumbers h, Places place)
        {
            at = h > height ? place : at;
            height = larger(h, height);
        }
    };
    const Vector3f stretch =
        spread.deviation.cwiseMax(1e-6 * spread.deviation.maxCoeff()).cwiseInverse().cast<float>();
    const Matrix3f columns = spread.axes.cast<float>();
    Extreme extremes[2 * kDirections];  // the lowest and the highest along every direction
    FourNumbers sample[3][SsvPoints::kSample];
    const std::size_t stride = points.stride();
    Places place{};
    for (std::size_t i = 0, count = 0; i < points.fours(); i += stride, ++count)
    {
        FourNumbers q[3];
        for (int k = 0; k < 3; ++k)
        {
            sample[k][count] = points.along(columns.col(k), i);
            q[k] = sample[k][count] * stretch[k];
        }
        const FourNumbers sum = q[0] + q[1];
        const FourNumbers difference = q[0] - q[1];
        const FourNumbers heights[kDirections] = {q[0],
                                                  q[1],
                                                  q[2],
                                                  sum,
                                                  difference,
                                                  sum + q[2],
                                                  sum - q[2],
                                                  difference + q[2],
                                                  difference - q[2]};
        for (int k = 0; k < kDirections; ++k)
        {
            extremes[2 * k].take(-heights[k], place);
            extremes[2 * k + 1].take(heights[k], place);
        }
        place += 1;
    }
    for (const Extreme& extreme : extremes)
    {
        int best = 0;
        for (int other = 1; other < 4; ++other)
        {
            best = extreme.height[other] > extreme.height[best] ? other : best;
        }
        const auto at = extreme.at[best];
        boxes.add(lane, sample[0][at][best], sample[1][at][best], sample[2][at][best]);
    }
}
}  // namespace

Matrix3d SsvAxes::matrix() const
{
    Matrix3d m;
    m.col(0) = axis0.cast<double>();
    m.col(1) = axis1.cast<double>();
    m.col(2) = m.col(0).cross(m.col(1));
    return m;
}

[[gnu::noinline]] Vector3f toFloats(const Vector3d& x)
{
    return x.cast<float>();
}

SsvTriangleBox triangleBox(const SsvCorners& c)
{
    const double area = (c[1] - c[0]).cross(c[2] - c[0]).norm();  // twice
    struct Side
    {
        double low = 0.0;
        double high = 0.0;
        double height = 0.0;
        double measure = std::numeric_limits<double>::infinity();
    };
    // Which is best is as good as random, so branches would be guessed wrongly.
    const auto sideAlong = [&](std::size_t i) -> Side
    {
        const Vector3d edge = c[(i + 1) % 3] - c[i];
        const double length = edge.norm();
        if (!(length > 0.0))
        {
            return {};
        }
        const double along = edge.dot(c[(i + 2) % 3] - c[i]) / length;
        const double low = std::min(0.0, along);
        const double high = std::max(length, along);
        const double height = area / length;
        return {.low = low,
                .high = high,
                .height = height,
                .measure = boxMeasure<double>(high - low, height, 0.0)};
    };
    const Side sides[3] = {sideAlong(0), sideAlong(1), sideAlong(2)};
    const auto betterOf = [&sides](std::size_t i, std::size_t k)
    { return sides[k].measure < sides[i].measure ? k : i; };
    const std::size_t best = betterOf(betterOf(0, 1), 2);
    const auto [low, high, height, measure] = sides[best];
    const Vector3d edge = c[(best + 1) % 3] - c[best];
    const Vector3d other = c[(best + 2) % 3] - c[best];
    constexpr double kNeedle = 1e-6;
    SsvAxes axes;
    if (height > kNeedle * (high - low))
    {
        const double length = edge.norm();
        const Vector3d e0 = edge / length;
        axes = straightened(e0, (other - e0.dot(other) * e0) / height);
    }
    else
    {
        axes = makeAxes(edge, other);
    }
    const double reach = high - low;
    SsvTriangleBox box{.axes = axes,
                       .corner = best,
                       .center = 0.5 * (low + high) * axes.axis0.cast<double>() +
                                 0.5 * height * axes.axis1.cast<double>(),
                       .half = {0.5 * reach, 0.5 * height, 0.0}};
    if (height > reach)
    {
        box.axes = {.axis0 = axes.axis1, .axis1 = -axes.axis0};
        std::swap(box.half[0], box.half[1]);
    }
    return box;
}

namespace
{
void addTo(TurningBoxes& boxes, std::size_t lane, const SsvPoints& points, const Spread& start)
{
    if (points.count() > TurningBoxes::kMostPoints)
    {
        addExtremes(points, start, lane, boxes);
        return;
    }
    const Matrix3f columns = start.axes.cast<float>();
    for (std::size_t i = 0; i < points.fours(); ++i)
    {
        const FourNumbers x = points.along(columns.col(0), i);
        const FourNumbers y = points.along(columns.col(1), i);
        const FourNumbers z = points.along(columns.col(2), i);
        for (std::size_t k = 0; k < std::min<std::size_t>(4, points.count() - 4 * i); ++k)
        {
            boxes.add(lane, x[k], y[k], z[k]);
        }
    }
}

SsvAxes axesIn(const TurningBoxes& boxes, std::size_t lane, const Spread& start)
{
    const Matrix3d axes = start.axes * boxes.axes(lane).cast<double>();
    return straightened(axes.col(0), axes.col(1));
}
}  // namespace

SsvAxes smallBoxAxes(const SsvPoints& points)
{
    const Spread start = principalSpread(points);
    TurningBoxes boxes;
    addTo(boxes, 0, points, start);
    boxes.turnUntilSmall();
    return axesIn(boxes, 0, start);
}

void turnToSmallBoxes(std::span<const SsvPoints> points, std::span<SsvAxes> axes)
{
    std::array<Spread, kSsvTurnedAtOnce> starts;
    TurningBoxes boxes;
    for (std::size_t lane = 0; lane < points.size(); ++lane)
    {
        starts[lane] = spreadAlong(points[lane], axes[lane]);
        addTo(boxes, lane, points[lane], starts[lane]);
    }
    boxes.turnUntilSmall();
    for (std::size_t lane = 0; lane < points.size(); ++lane)
    {
        axes[lane] = axesIn(boxes, lane, starts[lane]);
    }
}
}  // namespace bullet_ccd
