/// Which objects are near enough to meet at all within the next few steps.
#ifndef BT_CCD_NEIGHBOURS_H
#define BT_CCD_NEIGHBOURS_H

#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btVector3.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

struct btCcdBox
{
    /// Nothing is in the box, and it meets none.
    btVector3 m_low = btVector3(BT_INFINITY, BT_INFINITY, BT_INFINITY);
    btVector3 m_high = btVector3(-BT_INFINITY, -BT_INFINITY, -BT_INFINITY);

    /// NaN is in no box.
    [[nodiscard]] bool contains(const btVector3& low, const btVector3& high) const
    {
        return m_low.x() <= low.x() && high.x() <= m_high.x() && m_low.y() <= low.y() &&
               high.y() <= m_high.y() && m_low.z() <= low.z() && high.z() <= m_high.z();
    }
    [[nodiscard]] bool meets(const btCcdBox& other) const
    {
        return TestAabbAgainstAabb2(m_low, m_high, other.m_low, other.m_high);
    }
};

/// A list of all pairs of boxes that meet. It stays good for as long as nothing leaves its box: the
/// boxes are to be made larger than what is in them now.
class btCcdNeighbours
{
public:
    /// Nothing is in a box of the list any more.
    void clear();
    /// Where the objects are, by index.
    [[nodiscard]] std::vector<btCcdBox>& boxes() { return m_boxes; }
    /// Makes the list anew, after a change of the boxes. False, and no list, if there are more
    /// pairs than `most`.
    [[nodiscard]] bool listAmongAll(std::size_t most) { return list(kNoSplit, most); }
    /// The same, only of pairs of one of the first `split` boxes and one of the others.
    [[nodiscard]] bool listBetween(std::size_t split, std::size_t most)
    {
        return list(split, most);
    }
    /// Smaller index first, in ascending order.
    [[nodiscard]] const std::vector<std::pair<int, int>>& pairs() const { return m_pairs; }

private:
    static constexpr std::size_t kNoSplit = std::numeric_limits<std::size_t>::max();

    /// A box in a cell of a regular grid.
    struct Entry
    {
        std::uint64_t m_key;
        int m_box;
    };

    std::vector<btCcdBox> m_boxes;
    std::vector<std::pair<int, int>> m_pairs;
    std::size_t m_split = kNoSplit;
    std::size_t m_most = 0;
    // Scratch memory.
    std::vector<std::array<std::int64_t, 3>> m_lowest;  // cells
    std::vector<Entry> m_entries;
    std::vector<Entry> m_sorted;  // by bucket
    std::vector<std::size_t> m_begins;
    std::vector<int> m_large;
    std::vector<std::pair<int, int>> m_sortedPairs;

    [[nodiscard]] bool list(std::size_t split, std::size_t most);
    [[nodiscard]] bool isBeforeSplit(int box) const { return std::size_t(box) < m_split; }
    [[nodiscard]] bool compare(int a, int b);
    [[nodiscard]] bool listAll();
    void fillCells();
    [[nodiscard]] bool listByCells();
    [[nodiscard]] bool compareLarge();
    void sortPairs();
};

#endif  // BT_CCD_NEIGHBOURS_H
