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

/// Measure of a box to be made small: its surface, and a little of its width so that flat boxes are
/// told apart.
template <class T>
T boxMeasure(T x, T y, T z)
{
    const T width = x + y + z;
    return x * y + y * z + z * x + T(0.1) * width * width;
}

/// The edge whose box is smallest: across it is the height over it.
SsvAxes triangleAxes(const SsvCorners& c)
{
    SsvAxes best = makeAxes(Vector3d::Zero(), Vector3d::Zero());
    double bestMeasure = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i)
    {
        const Vector3d edge = c[(i + 1) % 3] - c[i];
        const Vector3d other = c[(i + 2) % 3] - c[i];
        const double length = edge.norm();
        if (!(length > 0.0))
        {
            continue;
        }
        const double along = edge.dot(other) / length;
        const double height = edge.cross(other).norm() / length;
        const double reach = std::max(length, along) - std::min(0.0, along);
        const double measure = boxMeasure(reach, height, 0.0);
        if (measure < bestMeasure)
        {
            bestMeasure = measure;
            best = height > reach ? makeAxes(other - (along / length) * edge, edge)
                                  : makeAxes(edge, other);
        }
    }
    return best;
}

/// A box around a few points that is turned step by step; four points at a time.
class TurningBox
{
public:
    static constexpr int kMaxPoints = 32;

    void add(const Vector3f& p)
    {
        for (int k = 0; k < 3; ++k)
        {
            m_points[k][m_count / 4][m_count % 4] = p[k];
        }
        ++m_count;
    }

    /// Turns about each axis in turn by less and less as long as that makes the box smaller; a long
    /// side by a fraction of its slope against the short one.
    void turnUntilSmall()
    {
        while (m_count % 4 != 0)
        {
            add({m_points[0][0][0], m_points[1][0][0], m_points[2][0][0]});
        }
        for (int k = 0; k < 3; ++k)
        {
            m_size[k] = extent(k, k, 1.0F, 0.0F);
        }
        for (const float step : {1.0F, 0.5F, 0.25F, 0.125F, 0.0625F})
        {
            for (int k = 0; k < 3; ++k)
            {
                const float sizeU = m_size[(k + 1) % 3];
                const float sizeV = m_size[(k + 2) % 3];
                const float slope = std::min(sizeU, sizeV) / std::max(sizeU, sizeV);
                if (slope > 1e-4F && !tryTurn(k, step * slope))
                {
                    tryTurn(k, -step * slope);
                }
            }
        }
    }

    /// Columns, in the axes of the points; longest side first.
    [[nodiscard]] Matrix3f axes() const
    {
        std::array<int, 3> order = {0, 1, 2};
        std::stable_sort(
            order.begin(), order.end(), [&](int a, int b) { return m_size[a] > m_size[b]; });
        return m_axes(Eigen::all, order);
    }

private:
    /// Extent of c x_u + s x_v.
    [[nodiscard]] float extent(int u, int v, float c, float s) const
    {
        Array4f low = c * m_points[u][0] + s * m_points[v][0];
        Array4f high = low;
        for (int i = 1; 4 * i < m_count; ++i)
        {
            const Array4f x = c * m_points[u][i] + s * m_points[v][i];
            low = low.min(x);
            high = high.max(x);
        }
        return high.maxCoeff() - low.minCoeff();
    }

    /// Turns about axis k if that makes the box smaller.
    bool tryTurn(int k, float tangent)
    {
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        const float c = 1.0F / std::sqrt(1.0F + tangent * tangent);
        const float s = c * tangent;
        const float sizeU = extent(u, v, c, s);
        const float sizeV = extent(v, u, c, -s);
        if (!(boxMeasure(m_size[k], sizeU, sizeV) <
              0.99999F * boxMeasure(m_size[0], m_size[1], m_size[2])))
        {
            return false;
        }
        m_size[u] = sizeU;
        m_size[v] = sizeV;
        for (int i = 0; 4 * i < m_count; ++i)
        {
            const Array4f x = m_points[u][i];
            m_points[u][i] = c * x + s * m_points[v][i];
            m_points[v][i] = c * m_points[v][i] - s * x;
        }
        const Vector3f axisU = m_axes.col(u);
        m_axes.col(u) = c * axisU + s * m_axes.col(v);
        m_axes.col(v) = c * m_axes.col(v) - s * axisU;
        return true;
    }

    Array4f m_points[3][kMaxPoints / 4];  ///< coordinates along the sides
    int m_count = 0;
    Matrix3f m_axes = Matrix3f::Identity();
    Vector3f m_size = Vector3f::Zero();
};

/// Corners of every stride-th triangle.
class Sample
{
public:
    static constexpr std::size_t kTriangles = 48;

    explicit Sample(std::span<const SsvCorners> triangles)
        : m_triangles(triangles), m_stride((triangles.size() + kTriangles - 1) / kTriangles)
    {
    }
    template <class Visit>
    void forEach(Visit&& visit) const
    {
        for (std::size_t i = 0; i < m_triangles.size(); i += m_stride)
        {
            for (const Vector3d& corner : m_triangles[i])
            {
                visit(corner);
            }
        }
    }
    [[nodiscard]] bool isSmall() const { return 3 * m_triangles.size() <= TurningBox::kMaxPoints; }

private:
    std::span<const SsvCorners> m_triangles;
    std::size_t m_stride;
};

struct Spread
{
    Vector3d about = Vector3d::Zero();      ///< a point among the corners
    double scale = 0.0;                     ///< one over their size
    Matrix3d axes = Matrix3d::Identity();   ///< columns: largest spread first
    Vector3d deviation = Vector3d::Zero();  ///< along the axes, scaled
};

Spread spreadOf(const Sample& sample, const Vector3d& about)
{
    Spread spread{.about = about};
    Vector3d sum = Vector3d::Zero();
    Matrix3d square = Matrix3d::Zero();
    double count = 0.0;
    sample.forEach(
        [&](const Vector3d& corner)
        {
            const Vector3d d = corner - about;
            sum += d;
            square.noalias() += d * d.transpose();
            count += 1.0;
        });
    square = square / count - (sum / count) * (sum / count).transpose();
    const double largest = square.cwiseAbs().maxCoeff();
    if (!(largest > 0.0) || !(largest < std::numeric_limits<double>::infinity()))
    {
        return spread;
    }
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(square / largest);
    if (!solver.eigenvectors().allFinite())
    {
        return spread;
    }
    spread.scale = 1.0 / std::sqrt(largest);
    spread.axes = solver.eigenvectors().rowwise().reverse();
    spread.deviation = solver.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
    return spread;
}

/// The extremes along the axes, the diagonals of the widest face and the space diagonals, stretched
/// with the set.
void addExtremes(const Sample& sample, const Spread& spread, TurningBox& box)
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
    const Vector3f stretch = spread.deviation.cwiseMax(1e-6).cwiseInverse().cast<float>();
    const Matrix3d toAxes = spread.scale * spread.axes.transpose();
    float low[kDirections];
    float high[kDirections];
    std::fill(low, low + kDirections, std::numeric_limits<float>::infinity());
    std::fill(high, high + kDirections, -std::numeric_limits<float>::infinity());
    Vector3f lowest[kDirections];
    Vector3f highest[kDirections];
    sample.forEach(
        [&](const Vector3d& corner)
        {
            const Vector3f p = (toAxes * (corner - spread.about)).cast<float>();
            const Vector3f q = p.cwiseProduct(stretch);
            for (int i = 0; i < kDirections; ++i)
            {
                const float x = kSigns[i][0] * q.x() + kSigns[i][1] * q.y() + kSigns[i][2] * q.z();
                if (x < low[i])
                {
                    low[i] = x;
                    lowest[i] = p;
                }
                if (x > high[i])
                {
                    high[i] = x;
                    highest[i] = p;
                }
            }
        });
    for (int i = 0; i < kDirections; ++i)
    {
        box.add(lowest[i]);
        box.add(highest[i]);
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

SsvAxes smallBoxAxes(std::span<const SsvCorners> triangles)
{
    if (triangles.size() == 1)
    {
        return triangleAxes(triangles[0]);
    }
    const Sample sample(triangles);
    const Spread spread = spreadOf(sample, triangles[0][0]);
    if (spread.scale == 0.0)
    {
        return makeAxes(Vector3d::Zero(), Vector3d::Zero());
    }
    TurningBox box;
    if (sample.isSmall())
    {
        const Matrix3d toAxes = spread.scale * spread.axes.transpose();
        sample.forEach([&](const Vector3d& corner)
                       { box.add((toAxes * (corner - spread.about)).cast<float>()); });
    }
    else
    {
        addExtremes(sample, spread, box);
    }
    box.turnUntilSmall();
    const Matrix3d axes = spread.axes * box.axes().cast<double>();
    return makeAxes(axes.col(0), axes.col(1));
}
}  // namespace bullet_ccd
