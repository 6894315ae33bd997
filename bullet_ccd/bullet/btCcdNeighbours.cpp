#include "bullet_ccd/bullet/btCcdNeighbours.h"

#include <algorithm>

namespace
{
/// Up to so many boxes are compared each with each: sorting would take longer.
constexpr std::size_t kFew = 32;

bool isUsed(const btCcdBox& box)
{
    return box.m_low.x() <= box.m_high.x();
}
}  // namespace

void btCcdNeighbours::clear()
{
    m_boxes.clear();
    m_pairs.clear();
}

void btCcdNeighbours::list(const std::vector<btCcdBox>& boxes)
{
    m_boxes = boxes;
    m_pairs.clear();
    if (boxes.size() <= kFew)
    {
        listAll();
    }
    else
    {
        listByOrder();
    }
}

void btCcdNeighbours::listAll()
{
    for (std::size_t a = 0; a < m_boxes.size(); ++a)
    {
        for (std::size_t b = a + 1; b < m_boxes.size(); ++b)
        {
            if (isUsed(m_boxes[a]) && isUsed(m_boxes[b]) && m_boxes[a].meets(m_boxes[b]))
            {
                m_pairs.emplace_back(int(a), int(b));
            }
        }
    }
}

void btCcdNeighbours::listByOrder()
{
    m_order.clear();
    for (std::size_t i = 0; i < m_boxes.size(); ++i)
    {
        if (isUsed(m_boxes[i]))
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
