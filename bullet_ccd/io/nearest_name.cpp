#include "bullet_ccd/io/nearest_name.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace bullet_ccd
{
namespace
{
/// Number of insertions, deletions and replacements that turn one word into the other.
std::size_t editDistance(const std::string& a, const std::string& b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i)
    {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t k = 1; k <= b.size(); ++k)
        {
            const std::size_t replaced = diagonal + (a[i - 1] == b[k - 1] ? 0 : 1);
            diagonal = row[k];
            row[k] = std::min({replaced, row[k] + 1, row[k - 1] + 1});
        }
    }
    return row[b.size()];
}
}  // namespace

std::string nearestName(const std::string& name, std::span<const std::string> names)
{
    const auto nearest = std::min_element(names.begin(),
                                          names.end(),
                                          [&](const std::string& a, const std::string& b) {
                                              return editDistance(name, a) < editDistance(name, b);
                                          });
    return nearest == names.end() ? std::string() : *nearest;
}
}  // namespace bullet_ccd
