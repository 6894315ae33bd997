/// Boxes of which some change now and then, and which of them meet another one.
#ifndef BT_CCD_SWEPT_BOXES_H
#define BT_CCD_SWEPT_BOXES_H

#include "bullet_ccd/bullet/motion/btCcdNeighbours.h"

#include <vector>

/// Of many boxes few are looked at: they are kept in the order in which they begin along one axis,
/// that along which they are farthest spread. Keeps scratch memory.
class btCcdSweptBoxes
{
public:
    void clear();
    [[nodiscard]] int size() const { return int(m_boxes.size()); }
    /// @pre finite
    void add(const btCcdBox& box);
    void set(int index, const btCcdBox& box);
    /// The indices of all that meet the box, in ascending order, until the next call.
    [[nodiscard]] const std::vector<int>& meeting(const btCcdBox& box);

private:
    struct Begin
    {
        btScalar m_low;
        int m_index;
    };

    std::vector<btCcdBox> m_boxes;
    std::vector<Begin> m_begins;
    std::vector<int> m_found;
    int m_axis = 0;
    btScalar m_longest = 0;  // of the boxes, along the axis, at least
    bool m_isSorted = false;

    void sort();
};

#endif  // BT_CCD_SWEPT_BOXES_H
