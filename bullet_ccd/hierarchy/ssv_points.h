/// The points of one node, as its volume is fitted to them.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Four numbers that are computed with at once, with the same bits as one by one. Eigen's arrays
/// are as fast in sums and products, but slow where lanes change their places.
using FourNumbers = float __attribute__((vector_size(16)));

[[nodiscard]] inline FourNumbers smaller(FourNumbers a, FourNumbers b)
{
    return a < b ? a : b;
}

[[nodiscard]] inline FourNumbers larger(FourNumbers a, FourNumbers b)
{
    return a > b ? a : b;
}

/// Folds each of four by a commutative operation: the k-th to lane k.
template <class Operation>
[[nodiscard]] FourNumbers folded(
    FourNumbers a, FourNumbers b, FourNumbers c, FourNumbers d, Operation&& of)
{
    const FourNumbers ab =
        of(__builtin_shufflevector(a, b, 0, 4, 1, 5), __builtin_shufflevector(a, b, 2, 6, 3, 7));
    const FourNumbers cd =
        of(__builtin_shufflevector(c, d, 0, 4, 1, 5), __builtin_shufflevector(c, d, 2, 6, 3, 7));
    return of(__builtin_shufflevector(ab, cd, 0, 1, 4, 5),
              __builtin_shufflevector(ab, cd, 2, 3, 6, 7));
}

/// The numbers of several fours, lane by lane.
struct FourRanges
{
    FourNumbers low = FourNumbers{} + std::numeric_limits<float>::infinity();
    FourNumbers high = FourNumbers{} - std::numeric_limits<float>::infinity();

    void add(FourNumbers x)
    {
        low = smaller(x, low);
        high = larger(x, high);
    }
};

/// The size of each range over all of its lanes.
[[nodiscard]] inline FourNumbers sizesOf(const FourRanges& a,
                                         const FourRanges& b,
                                         const FourRanges& c,
                                         const FourRanges& d)
{
    return folded(a.high, b.high, c.high, d.high, larger) -
           folded(a.low, b.low, c.low, d.low, smaller);
}

/// Points in single precision, four at a time, about the first of them; in a unit in which no
/// square over- or underflows.
///
/// Guarantee: every coordinate is right to 1e-7 of how far the points reach.
class SsvPoints
{
public:
    using Four = Eigen::Array4f;

    /// So many fours are enough to choose by.
    static constexpr std::size_t kSample = 36;
    /// What single precision may drop altogether, far below the smallest mesh [m].
    static constexpr double kSmallest = 1e-30;

    /// Forgets the points; `count` new ones follow. The first is `about`, to be added as well.
    void begin(const Eigen::Vector3d& about, std::size_t count);
    void add(std::span<const Eigen::Vector3d> points);
    /// To be called when all have been added.
    void end();

    [[nodiscard]] const Eigen::Vector3d& about() const { return m_about; }
    [[nodiscard]] double unit() const { return m_unit; }  ///< [m], a power of two
    /// Coordinate x, y or z. Where four do not divide their number, the first fills the last four.
    [[nodiscard]] std::span<const Four> operator[](std::size_t k) const { return m_fours[k]; }
    [[nodiscard]] std::size_t count() const { return m_count; }
    [[nodiscard]] std::size_t fours() const { return m_fours[0].size(); }
    [[nodiscard]] FourNumbers numbers(std::size_t k, std::size_t i) const
    {
        FourNumbers x;
        std::memcpy(&x, m_fours[k][i].data(), sizeof(x));
        return x;
    }
    /// Four coordinates along an axis, from about() in unit().
    [[nodiscard]] FourNumbers along(const Eigen::Vector3f& axis, std::size_t i) const
    {
        return axis.x() * numbers(0, i) + axis.y() * numbers(1, i) + axis.z() * numbers(2, i);
    }
    /// Every how manieth four is enough to choose by, where a choice costs nothing but size.
    [[nodiscard]] std::size_t stride() const { return (fours() + kSample - 1) / kSample; }

private:
    Eigen::Vector3d m_about = Eigen::Vector3d::Zero();
    double m_unit = 0.0;
    std::size_t m_count = 0;
    std::array<std::vector<Four>, 3> m_fours;
};
}  // namespace bullet_ccd
