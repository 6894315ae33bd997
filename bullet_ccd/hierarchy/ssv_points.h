/// The points of one node, as its volume is fitted to them.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Points in single precision, four at a time, about the first of them; in a unit in which no
/// square over- or underflows.
///
/// Guarantee: every coordinate is right to 1e-7 of how far the points reach.
class SsvPoints
{
public:
    using Four = Eigen::Array4f;

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
    [[nodiscard]] std::size_t fours() const { return m_fours[0].size(); }
    /// Four coordinates along an axis, from about() in unit().
    [[nodiscard]] Four along(const Eigen::Vector3f& axis, std::size_t i) const
    {
        return axis.x() * m_fours[0][i] + axis.y() * m_fours[1][i] + axis.z() * m_fours[2][i];
    }
    /// Every how manieth four is enough to choose by, where a choice costs nothing but size.
    [[nodiscard]] std::size_t stride() const
    {
        constexpr std::size_t kSample = 36;
        return (fours() + kSample - 1) / kSample;
    }

private:
    Eigen::Vector3d m_about = Eigen::Vector3d::Zero();
    double m_unit = 0.0;
    std::size_t m_count = 0;
    std::array<std::vector<Four>, 3> m_fours;
};
}  // namespace bullet_ccd
