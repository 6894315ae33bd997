#include "bullet_ccd/hierarchy/ssv_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
void SsvPoints::begin(const Eigen::Vector3d& about, std::size_t count)
{
    m_about = about;
    m_count = 0;
    for (std::vector<Four>& fours : m_fours)
    {
        fours.resize((count + 3) / 4);
    }
    for (std::vector<Four>& fours : m_fours)
    {
        fours.back().setZero();  // where `about` is
    }
}

void SsvPoints::add(std::span<const Eigen::Vector3d> points)
{
    std::array<float*, 3> out{};
    for (std::size_t k = 0; k < 3; ++k)
    {
        out[k] = m_fours[k].data()->data() + m_count;
    }
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        const Eigen::Vector3d d = points[i] - m_about;
        for (std::size_t k = 0; k < 3; ++k)
        {
            out[k][i] = static_cast<float>(d[static_cast<Eigen::Index>(k)]);
        }
    }
    m_count += points.size();
}

void SsvPoints::end()
{
    Four reach = Four::Zero();
    for (const std::vector<Four>& fours : m_fours)
    {
        for (const Four& four : fours)
        {
            reach = reach.max(four.abs());
        }
    }
    // Single precision keeps the middle of a volume to this much, so offsets may be as large.
    const double largest = std::max(
        {static_cast<double>(reach.maxCoeff()), 1e-7 * m_about.cwiseAbs().maxCoeff(), kSmallest});
    m_unit = 1.0;
    constexpr double kPlain = 1e6;  // squares are far from the ends of single precision
    if (largest < kPlain && largest > 1.0 / kPlain)
    {
        return;
    }
    const int exponent = std::ilogb(largest);  // scales without rounding
    m_unit = std::ldexp(1.0, exponent);
    const float scale = std::ldexp(1.0F, -exponent);
    for (std::vector<Four>& fours : m_fours)
    {
        for (Four& four : fours)
        {
            four *= scale;
        }
    }
}
}  // namespace bullet_ccd
