#include "bullet_ccd/bullet/motion/btCcdNeighbours.h"

#include <algorithm>
#include <numeric>

namespace
{
/// Up to so many boxes are compared each with each: sorting would take longer.
constexpr std::size_t kFew = 32;
}  // namespace

void btCcdNeighbours::clear()
{
    m_boxes.clear();
    m_pairs.clear();
}

void btCcdNeighbours::list()
{
    m_pairs.clear();
    if (m_boxes.size() <= kFew)
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
    m_pairs.reserve(kFew * kFew / 2);
    for (std::size_t a = 0; a < m_boxes.size(); ++a)
    {
        const btCcdBox box = m_boxes[a];
        for (std::size_t b = a + 1; b < m_boxes.size(); ++b)
        {
            if (box.meets(m_boxes[b]))
            {
                m_pairs.emplace_back(int(a), int(b));
            }
        }
    }
}

void btCcdNeighbours::listByOrder()
{
    m_order.resize(m_boxes.size());
    std::iota(m_order.begin(), m_order.end(), 0);
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
