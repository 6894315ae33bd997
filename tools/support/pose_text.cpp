#include "tools/support/pose_text.h"

#include "tools/support/csv_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
constexpr double kLargestNumber = 1e15;
}  // namespace

double numberFrom(std::string_view text)
{
    const std::string_view cell = trimmed(text);
    if (cell.empty())
    {
        throw std::invalid_argument("no value: write a number");
    }
    // from_chars takes no plus sign.
    const std::string_view digits =
        cell.size() > 1 && cell[0] == '+' && cell[1] != '-' ? cell.substr(1) : cell;
    double value = 0.0;
    const char* const end = digits.data() + digits.size();
    const std::from_chars_result read = std::from_chars(digits.data(), end, value);
    if (read.ec == std::errc::result_out_of_range)
    {
        throw std::invalid_argument(
            fmt::format("'{}' does not fit a double: check the number and its unit", cell));
    }
    if (read.ec != std::errc() || read.ptr != end)
    {
        throw std::invalid_argument(
            fmt::format("'{}' is not a number: write it like -1.5 or 2e-3", cell));
    }
    if (!(std::abs(value) <= kLargestNumber))
    {
        throw std::invalid_argument(fmt::format(
            "'{}' is not a finite number up to 1e15: check the program that wrote it", cell));
    }
    return value;
}

std::vector<double> numbersFrom(std::string_view text, std::size_t count)
{
    std::vector<double> values;
    for (std::size_t first = 0; first <= text.size();)
    {
        const std::size_t comma = std::min(text.find(',', first), text.size());
        values.push_back(numberFrom(text.substr(first, comma - first)));
        first = comma + 1;
    }
    if (values.size() != count)
    {
        throw std::invalid_argument(
            fmt::format("'{}' has {} numbers: write {}, separated by commas without spaces",
                        text,
                        values.size(),
                        count));
    }
    return values;
}

Eigen::Isometry3d poseFrom(std::span<const double, 7> values)
{
    const Eigen::Quaterniond q(values[0], values[1], values[2], values[3]);
    const double length = q.norm();
    if (!(std::abs(length - 1.0) <= kQuaternionSlack))
    {
        throw std::invalid_argument(
            fmt::format("quaternion {},{},{},{} has length {:.6g}: normalise it to 1 (qw first)",
                        values[0],
                        values[1],
                        values[2],
                        values[3],
                        length));
    }
    Eigen::Isometry3d X_W = Eigen::Isometry3d::Identity();
    X_W.linear() = q.normalized().toRotationMatrix();
    X_W.translation() = Eigen::Vector3d(values[4], values[5], values[6]);
    return X_W;
}
}  // namespace bullet_ccd::tools
