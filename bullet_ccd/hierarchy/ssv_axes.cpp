#include "bullet_ccd/hierarchy/ssv_axes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
namespace
{
using Eigen::Array4f;
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
template <class T>
T boxMeasure(T x, T y, T z)
{
    const T width = x + y + z;
    return x * y + y * z + z * x + T(0.1) * width * width;
}

/// A box around a few points that is turned step by step; four points at a time.
class TurningBox
{
public:
    static constexpr int kMostFours = 8;

    void add(const Array4f& x, const Array4f& y, const Array4f& z)
    {
        m_points[0][m_fours] = x;
        m_points[1][m_fours] = y;
        m_points[2][m_fours] = z;
        ++m_fours;
    }

    /// Turns about each axis in turn by less and less as long as that makes the box smaller; a long
    /// side by a fraction of its slope against the short one.
    void turnUntilSmall()
    {
        for (int k = 0; k < 3; ++k)
        {
            m_size[k] = extent(k);
        }
        m_measure = boxMeasure(m_size[0], m_size[1], m_size[2]);
        for (const float step : {0.8F, 0.35F, 0.15F, 0.06F})
        {
            for (int k = 0; k < 3; ++k)
            {
                const float sizeU = m_size[(k + 1) % 3];
                const float sizeV = m_size[(k + 2) % 3];
                const float slope = std::min(sizeU, sizeV) / std::max(sizeU, sizeV);
                if (slope > 1e-4F)
                {
                    tryTurns(k, step * slope);
                }
            }
        }
    }

    /// Columns, in the axes of the points; longest side first.
    [[nodiscard]] Matrix3f axes() const
    {
        std::array<int, 3> order = {0, 1, 2};
        for (const std::size_t i : {0U, 1U, 0U})
        {
            if (m_size[order[i]] < m_size[order[i + 1]])
            {
                std::swap(order[i], order[i + 1]);
            }
        }
        return m_axes(Eigen::all, order);
    }

private:
    [[nodiscard]] float extent(int axis) const
    {
        Array4f low = m_points[axis][0];
        Array4f high = low;
        for (int i = 1; i < m_fours; ++i)
        {
            low = low.min(m_points[axis][i]);
            high = high.max(m_points[axis][i]);
        }
        return high.maxCoeff() - low.minCoeff();
    }

    /// Turns about axis k one way or the other, about by the given angle, if that makes the box
    /// smaller.
    void tryTurns(int k, float angle)
    {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        const float h = 0.5F * angle;  // the tangent of half the angle: no root is needed
        const float scale = 1.0F / (1.0F + h * h);
        const float c = (1.0F - h * h) * scale;
        const float s = 2.0F * h * scale;
        struct Range
        {
            Array4f low = Array4f::Constant(std::numeric_limits<float>::infinity());
            Array4f high = Array4f::Constant(-std::numeric_limits<float>::infinity());

            void add(const Array4f& x)
            {
                low = low.min(x);
                high = high.max(x);
            }
            [[nodiscard]] float size() const { return high.maxCoeff() - low.minCoeff(); }
        };
        Range rangesU[2];
        Range rangesV[2];
        for (int i = 0; i < m_fours; ++i)
        {
            const Array4f cu = c * m_points[u][i];
            const Array4f su = s * m_points[u][i];
            const Array4f cv = c * m_points[v][i];
            const Array4f sv = s * m_points[v][i];
            rangesU[0].add(cu + sv);
            rangesV[0].add(cv - su);
            rangesU[1].add(cu - sv);
            rangesV[1].add(cv + su);
        }
        const float sizesU[2] = {rangesU[0].size(), rangesU[1].size()};
        const float sizesV[2] = {rangesV[0].size(), rangesV[1].size()};
        const float measures[2] = {boxMeasure(m_size[k], sizesU[0], sizesV[0]),
                                   boxMeasure(m_size[k], sizesU[1], sizesV[1])};
        const int better = measures[0] <= measures[1] ? 0 : 1;
        if (measures[better] < 0.99999F * m_measure)
        {
            m_measure = measures[better];
            m_size[u] = sizesU[better];
            m_size[v] = sizesV[better];
            turn(u, v, c, better == 0 ? s : -s);
        }
    }

    void turn(int u, int v, float c, float s)
    {
        for (int i = 0; i < m_fours; ++i)
        {
            const Array4f x = m_points[u][i];
            m_points[u][i] = c * x + s * m_points[v][i];
            m_points[v][i] = c * m_points[v][i] - s * x;
        }
        const Vector3f axisU = m_axes.col(u);
        m_axes.col(u) = c * axisU + s * m_axes.col(v);
        m_axes.col(v) = c * m_axes.col(v) - s * axisU;
    }

    Array4f m_points[3][kMostFours];  ///< coordinates along the sides
    int m_fours = 0;
    Matrix3f m_axes = Matrix3f::Identity();  ///< columns, in the axes of the points
    Vector3f m_size = Vector3f::Zero();
    float m_measure = 0.0F;
};

struct Spread
{
    Matrix3d axes = Matrix3d::Identity();   ///< columns: largest spread first
    Vector3d deviation = Vector3d::Ones();  ///< along the axes, in any unit
};

Spread principalSpread(const SsvPoints& points)
{
    const std::size_t stride = points.stride();
    Array4f sum[3];
    Array4f square[6];
    std::fill(sum, sum + 3, Array4f::Zero());
    std::fill(square, square + 6, Array4f::Zero());
    float count = 0.0F;
    for (std::size_t i = 0; i < points.fours(); i += stride)
    {
        const Array4f x = points[0][i];
        const Array4f y = points[1][i];
        const Array4f z = points[2][i];
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
    const Vector3d mean = Vector3f(sum[0].sum(), sum[1].sum(), sum[2].sum()).cast<double>() / count;
    Matrix3d spread;
    for (int i = 0, n = 0; i < 3; ++i)
    {
        for (int k = i; k < 3; ++k, ++n)
        {
            spread(i, k) = spread(k, i) = square[n].sum() / count - mean[i] * mean[k];
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
    const Matrix3f columns = spread.axes.cast<float>();
    const std::size_t stride = points.stride();
    for (int k = 0; k < 3; ++k)
    {
        Array4f low = points.along(columns.col(k), 0);
        Array4f high = low;
        for (std::size_t i = stride; i < points.fours(); i += stride)
        {
            const Array4f x = points.along(columns.col(k), i);
            low = low.min(x);
            high = high.max(x);
        }
        spread.deviation[k] = static_cast<double>(high.maxCoeff() - low.minCoeff());
    }
    return spread;
}

/// The extremes along the axes, the diagonals of the widest face and the space diagonals, stretched
/// with the set.
void addExtremes(const SsvPoints& points, const Spread& spread, TurningBox& box)
{
    constexpr int kDirections = 9;
    constexpr float kSigns[kDirections][3] = {{1, 0, 0},
                                              {0, 1, 0},
                                              {0, 0, 1},
                                              {1, 1, 0},
                                              {1, -1, 0},
                                              {1, 1, 1},
                                              {1, 1, -1},
                                              {1, -1, 1},
                                              {1, -1, -1}};
    const Vector3f stretch =
        spread.deviation.cwiseMax(1e-6 * spread.deviation.maxCoeff()).cwiseInverse().cast<float>();
    const Matrix3f columns = spread.axes.cast<float>();
    // In every lane the extreme of its points.
    struct Extreme
    {
        Array4f height;
        Array4f at[3];

        void take(const Array4f& h, const Array4f (&p)[3])
        {
            const auto better = (h > height).eval();
            height = better.select(h, height);
            for (int k = 0; k < 3; ++k)
            {
                at[k] = better.select(p[k], at[k]);
            }
        }
        [[nodiscard]] Vector3f best() const
        {
            Eigen::Index lane = 0;
            height.maxCoeff(&lane);
            return {at[0][lane], at[1][lane], at[2][lane]};
        }
    };
    Extreme lowest[kDirections];
    Extreme highest[kDirections];
    const std::size_t stride = points.stride();
    for (std::size_t i = 0; i < points.fours(); i += stride)
    {
        const Array4f p[3] = {points.along(columns.col(0), i),
                              points.along(columns.col(1), i),
                              points.along(columns.col(2), i)};
        const Array4f q[3] = {p[0] * stretch[0], p[1] * stretch[1], p[2] * stretch[2]};
        for (int k = 0; k < kDirections; ++k)
        {
            const Array4f h = kSigns[k][0] * q[0] + kSigns[k][1] * q[1] + kSigns[k][2] * q[2];
            if (i == 0)
            {
                lowest[k] = {-h, {p[0], p[1], p[2]}};
                highest[k] = {h, {p[0], p[1], p[2]}};
                continue;
            }
            lowest[k].take(-h, p);
            highest[k].take(h, p);
        }
    }
    Array4f found[3][5];
    for (int k = 0; k < 2 * kDirections + 2; ++k)  // two fill the last four
    {
        const int direction = std::min(k / 2, kDirections - 1);
        const Vector3f p = k % 2 == 0 ? lowest[direction].best() : highest[direction].best();
        for (int axis = 0; axis < 3; ++axis)
        {
            found[axis][k / 4][k % 4] = p[axis];
        }
    }
    for (int i = 0; i < 5; ++i)
    {
        box.add(found[0][i], found[1][i], found[2][i]);
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
    double bestMeasure = std::numeric_limits<double>::infinity();
    std::size_t best = 0;
    double low = 0.0;
    double high = 0.0;
    double height = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const Vector3d edge = c[(i + 1) % 3] - c[i];
        const double length = edge.norm();
        if (!(length > 0.0))
        {
            continue;
        }
        const double along = edge.dot(c[(i + 2) % 3] - c[i]) / length;
        const double reach = std::max(length, along) - std::min(0.0, along);
        const double measure = boxMeasure(reach, area / length, 0.0);
        if (measure < bestMeasure)
        {
            bestMeasure = measure;
            best = i;
            low = std::min(0.0, along);
            high = std::max(length, along);
            height = area / length;
        }
    }
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
SsvAxes turned(const SsvPoints& points, const Spread& start)
{
    TurningBox box;
    if (points.fours() <= TurningBox::kMostFours)
    {
        const Matrix3f columns = start.axes.cast<float>();
        for (std::size_t i = 0; i < points.fours(); ++i)
        {
            box.add(points.along(columns.col(0), i),
                    points.along(columns.col(1), i),
                    points.along(columns.col(2), i));
        }
    }
    else
    {
        addExtremes(points, start, box);
    }
    box.turnUntilSmall();
    const Matrix3d axes = start.axes * box.axes().cast<double>();
    return straightened(axes.col(0), axes.col(1));
}
}  // namespace

SsvAxes smallBoxAxes(const SsvPoints& points)
{
    return turned(points, principalSpread(points));
}

SsvAxes smallBoxAxes(const SsvPoints& points, const SsvAxes& start)
{
    return turned(points, spreadAlong(points, start));
}
}  // namespace bullet_ccd
