#include "bullet_ccd/motion/kinematic_tree.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
/// Sums of six terms, each of a few products: a few dozen roundings.
constexpr double kPathRounding = 1e-14;

double binomial(std::size_t n, std::size_t k)
{
    double value = 1.0;
    for (std::size_t i = 1; i <= k; ++i)
    {
        value *= double(n - k + i) / double(i);
    }
    return value;
}

/// Encloses sum_k c[k] t^k, k < count, over [0, 1]: a polynomial is within the hull of its
/// Bernstein coefficients.
std::array<double, 2> rangeOf(const std::array<double, 6>& c, std::size_t count)
{
    double low = c[0];
    double high = c[0];
    double size = 0.0;
    for (std::size_t i = 0; i < count; ++i)
    {
        double coefficient = 0.0;
        for (std::size_t k = 0; k <= i; ++k)
        {
            coefficient += binomial(i, k) / binomial(count - 1, k) * c[k];
        }
        low = std::min(low, coefficient);
        high = std::max(high, coefficient);
        size += std::abs(c[i]);
    }
    return {low - kPathRounding * size, high + kPathRounding * size};
}

/// Adds what holds over a path, whose step is `span` of the one that is bounded.
void extend(JointPathBounds& bounds, const JointPath& path, double span)
{
    std::array<double, 6> rate{};
    std::array<double, 6> bend{};
    for (std::size_t k = 1; k < 6; ++k)
    {
        rate[k - 1] = double(k) * path.c[k] / span;
    }
    for (std::size_t k = 1; k < 5; ++k)
    {
        bend[k - 1] = double(k) * rate[k] / span;
    }
    const auto [lowestRate, highestRate] = rangeOf(rate, 5);
    const auto [lowestBend, highestBend] = rangeOf(bend, 4);
    const auto [lowest, highest] = rangeOf(path.c, 6);
    bounds.lowestRate = std::min(bounds.lowestRate, lowestRate);
    bounds.highestRate = std::max(bounds.highestRate, highestRate);
    bounds.bend = std::max({bounds.bend, -lowestBend, highestBend});
    bounds.reach = std::max({bounds.reach, -lowest, highest});
}
}  // namespace

JointPath JointPath::partOf(double begin, double end) const
{
    // Taylor's series about `begin`.
    JointPath part;
    double power = 1.0;
    for (std::size_t k = 0; k < 6; ++k)
    {
        double derivative = 0.0;  // of order k, divided by k!
        for (std::size_t j = 6; j-- > k;)
        {
            derivative = derivative * begin + binomial(j, k) * c[j];
        }
        part.c[k] = power * derivative;
        power *= end - begin;
    }
    return part;
}

JointPathBounds JointPath::bounds() const
{
    if (isLinear())
    {
        return {.lowestRate = c[1],
                .highestRate = c[1],
                .bend = 0.0,
                .reach = std::max(std::abs(c[0]), std::abs(c[0] + c[1]))};
    }
    JointPathBounds bounds{.lowestRate = c[1], .highestRate = c[1], .bend = 0.0, .reach = 0.0};
    double size = 0.0;  // of what the halves were computed from
    for (const double coefficient : c)
    {
        size += std::abs(coefficient);
    }
    extend(bounds, partOf(0.0, 0.5), 0.5);
    extend(bounds, partOf(0.5, 1.0), 0.5);
    const double slack = 64.0 * kPathRounding * size;
    bounds.lowestRate -= slack;
    bounds.highestRate += slack;
    bounds.bend += slack;
    bounds.reach += slack;
    return bounds;
}
}  // namespace bullet_ccd
