#include "bullet_ccd/bullet/btCcdNeighbours.h"

#include <algorithm>

void btCcdNeighbours::clear()
{
    m_boxes.clear();
    m_pairs.clear();
}

void btCcdNeighbours::list(const std::vector<btCcdBox>& boxes)
{
    m_boxes = boxes;
    m_pairs.clear();
    m_order.clear();
    for (std::size_t i = 0; i < boxes.size(); ++i)
    {
        if (boxes[i].m_low.x() <= boxes[i].m_high.x())
        {
            m_order.push_back(int(i));
        }
    }
    const auto box = [&](int index) -> const btCcdBox& { return m_boxes[std::size_t(index)]; };
    std::sort(m_order.begin(),
              m_order.end(),
              [&](int a, int b) { return box(a).m_low.x() < box(b).m_low.x(); });
    for (auto a = m_order.begin(); a != m_order.end(); ++a)
    {
        for (auto b = a + 1; b != m_order.end() && box(*b).m_low.x() <= box(*a).m_high.x(); ++b)
        {
            if (box(*a).meets(box(*b)))
            {
                m_pairs.push_back(std::minmax(*a, *b));
            }
        }
    }
    std::sort(m_pairs.begin(), m_pairs.end());
}
