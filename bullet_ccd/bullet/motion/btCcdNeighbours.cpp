#include "bullet_ccd/bullet/motion/btCcdNeighbours.h"

#include <algorithm>
#include <cmath>

namespace
{
/// Up to so many boxes are compared each with each: sorting would take longer.
constexpr std::size_t kFew = 32;
/// A box in more cells than this is compared with all others.
constexpr double kMostCells = 64.0;
/// Coordinates of cells beyond this are not counted any more.
constexpr double kFarthestCell = 1e15;

/// Cells far apart may have the same key: those who meet there are compared all the same.
std::uint64_t keyOf(std::int64_t x, std::int64_t y, std::int64_t z)
{
    constexpr int kBits = 21;
    constexpr std::uint64_t kMask = (1U << kBits) - 1U;
    return ((std::uint64_t(x) & kMask) << (2 * kBits)) | ((std::uint64_t(y) & kMask) << kBits) |
           (std::uint64_t(z) & kMask);
}

std::size_t bucketOf(std::uint64_t key, std::size_t buckets)
{
    const std::uint64_t hash = key * 0x9e3779b97f4a7c15U;
    return std::size_t(hash >> 32U) & (buckets - 1);
}

btScalar longestEdge(const btCcdBox& box)
{
    const btVector3 edges = box.m_high - box.m_low;
    return edges[edges.maxAxis()];
}
}  // namespace

void btCcdNeighbours::clear()
{
    m_boxes.clear();
    m_pairs.clear();
}

bool btCcdNeighbours::list(std::size_t split, std::size_t most)
{
    m_pairs.clear();
    m_split = split;
    m_most = most;
    if (split == 0 || split == m_boxes.size())
    {
        return true;
    }
    const bool isWhole = m_boxes.size() <= kFew ? listAll() : listByCells();
    if (!isWhole)
    {
        m_pairs.clear();
    }
    else if (m_boxes.size() > kFew)
    {
        sortPairs();  // the others are in order
    }
    return isWhole;
}

/// False if there are too many pairs.
inline bool btCcdNeighbours::compare(int a, int b)
{
    const bool isWanted = m_split == kNoSplit || isBeforeSplit(a) != isBeforeSplit(b);
    if (isWanted && m_boxes[std::size_t(a)].meets(m_boxes[std::size_t(b)]))
    {
        m_pairs.push_back(std::minmax(a, b));
    }
    return m_pairs.size() <= m_most;
}

bool btCcdNeighbours::listAll()
{
    for (int a = 0; std::size_t(a) < m_boxes.size(); ++a)
    {
        for (int b = a + 1; std::size_t(b) < m_boxes.size(); ++b)
        {
            if (!compare(a, b))
            {
                return false;
            }
        }
    }
    return true;
}

/// Cubes as wide as most boxes; what is much larger is in none of them.
void btCcdNeighbours::fillCells()
{
    std::vector<btScalar> edges;
    edges.reserve(m_boxes.size());
    for (const btCcdBox& box : m_boxes)
    {
        edges.push_back(longestEdge(box));
    }
    std::nth_element(edges.begin(), edges.begin() + std::ptrdiff_t(edges.size() / 2), edges.end());
    const double edge = double(edges[edges.size() / 2]);
    const double perMetre = edge > 0.0 && std::isfinite(edge) ? 1.0 / edge : 1.0;
    m_lowest.assign(m_boxes.size(), {});
    m_entries.clear();
    m_large.clear();
    for (std::size_t i = 0; i < m_boxes.size(); ++i)
    {
        const btCcdBox& box = m_boxes[i];
        if (box.m_low.x() > box.m_high.x())
        {
            continue;
        }
        std::array<std::int64_t, 3>& low = m_lowest[i];
        std::array<std::int64_t, 3> high{};
        double cells = 1.0;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const double from = std::floor(double(box.m_low[int(k)]) * perMetre);
            const double to = std::floor(double(box.m_high[int(k)]) * perMetre);
            cells *= std::abs(from) + std::abs(to) < kFarthestCell ? to - from + 1.0 : HUGE_VAL;
            low[k] = cells <= kMostCells ? std::int64_t(from) : 0;
            high[k] = cells <= kMostCells ? std::int64_t(to) : 0;
        }
        if (!(cells <= kMostCells))
        {
            m_large.push_back(int(i));
            continue;
        }
        for (std::int64_t x = low[0]; x <= high[0]; ++x)
        {
            for (std::int64_t y = low[1]; y <= high[1]; ++y)
            {
                for (std::int64_t z = low[2]; z <= high[2]; ++z)
                {
                    m_entries.push_back({keyOf(x, y, z), int(i)});
                }
            }
        }
    }
}

/// A pair that meets shares the cell of the largest of its lowest coordinates, and is compared
/// there only.
bool btCcdNeighbours::listByCells()
{
    fillCells();
    std::size_t buckets = 1;
    while (buckets < m_entries.size())
    {
        buckets *= 2;
    }
    m_begins.assign(buckets + 1, 0);
    for (const Entry& entry : m_entries)
    {
        ++m_begins[bucketOf(entry.m_key, buckets) + 1];
    }
    for (std::size_t i = 1; i <= buckets; ++i)
    {
        m_begins[i] += m_begins[i - 1];
    }
    m_sorted.resize(m_entries.size());
    for (const Entry& entry : m_entries)
    {
        m_sorted[m_begins[bucketOf(entry.m_key, buckets)]++] = entry;
    }
    // Every begin is its end by now, and the boxes of a bucket are in order.
    for (std::size_t bucket = 0, i = 0; bucket < buckets; ++bucket)
    {
        const std::size_t end = m_begins[bucket];
        std::size_t begin = i;
        while (m_split != kNoSplit && begin < end && isBeforeSplit(m_sorted[begin].m_box))
        {
            ++begin;
        }
        for (const std::size_t last = m_split != kNoSplit ? begin : end; i < last; ++i)
        {
            const Entry& a = m_sorted[i];
            const auto& lowA = m_lowest[std::size_t(a.m_box)];
            for (std::size_t j = std::max(i + 1, begin); j < end; ++j)
            {
                const Entry& b = m_sorted[j];
                const auto& lowB = m_lowest[std::size_t(b.m_box)];
                const bool isHere =
                    a.m_key == b.m_key && a.m_key == keyOf(std::max(lowA[0], lowB[0]),
                                                           std::max(lowA[1], lowB[1]),
                                                           std::max(lowA[2], lowB[2]));
                if (isHere && !compare(a.m_box, b.m_box))
                {
                    return false;
                }
            }
        }
        i = end;
    }
    return compareLarge();
}

bool btCcdNeighbours::compareLarge()
{
    std::vector<char> isDone(m_boxes.size(), 0);
    for (const int large : m_large)
    {
        isDone[std::size_t(large)] = 1;
        for (int other = 0; std::size_t(other) < m_boxes.size(); ++other)
        {
            if (isDone[std::size_t(other)] == 0 && !compare(large, other))
            {
                return false;
            }
        }
    }
    return true;
}

void btCcdNeighbours::sortPairs()
{
    m_begins.assign(m_boxes.size() + 1, 0);
    for (const auto& pair : m_pairs)
    {
        ++m_begins[std::size_t(pair.first) + 1];
    }
    for (std::size_t i = 1; i <= m_boxes.size(); ++i)
    {
        m_begins[i] += m_begins[i - 1];
    }
    m_sortedPairs.resize(m_pairs.size());
    for (const auto& pair : m_pairs)
    {
        m_sortedPairs[m_begins[std::size_t(pair.first)]++] = pair;
    }
    for (std::size_t i = 0, begin = 0; i < m_boxes.size(); begin = m_begins[i++])
    {
        std::sort(m_sortedPairs.begin() + std::ptrdiff_t(begin),
                  m_sortedPairs.begin() + std::ptrdiff_t(m_begins[i]));
    }
    m_pairs.swap(m_sortedPairs);
}
