/// Which objects are near enough to meet at all within the next few steps.
#ifndef BT_CCD_NEIGHBOURS_H
#define BT_CCD_NEIGHBOURS_H

#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btVector3.h>

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
    /// Makes the list anew, after a change of the boxes.
    void list();
    /// Smaller index first, in ascending order.
    [[nodiscard]] const std::vector<std::pair<int, int>>& pairs() const { return m_pairs; }

private:
    std::vector<btCcdBox> m_boxes;
    std::vector<int> m_order;  // by the lower end
    std::vector<std::pair<int, int>> m_pairs;

    void listAll();
    void listByOrder();
};

#endif  // BT_CCD_NEIGHBOURS_H
