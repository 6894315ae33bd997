#include "bullet_ccd/bullet/motion/btCcdSweptBoxes.h"

#include <algorithm>

namespace
{
/// So few are gone through one after the other.
constexpr std::size_t kFewBoxes = 32;
/// Beside the length of a box: more than what rounding takes from where it begins.
constexpr btScalar kRoomOfBoxes = btScalar(1.125);

bool meet(const btCcdBox& a, const btCcdBox& b)
{
    for (int k = 0; k < 3; ++k)
    {
        if (a.m_low[k] > b.m_high[k] || b.m_low[k] > a.m_high[k])
        {
            return false;
        }
    }
    return true;
}
}  // namespace

void btCcdSweptBoxes::clear()
{
    m_boxes.clear();
    m_begins.clear();
    m_longest = 0;
    m_isSorted = false;
}

void btCcdSweptBoxes::add(const btCcdBox& box)
{
    m_boxes.push_back(box);
    m_isSorted = false;
}

void btCcdSweptBoxes::set(int index, const btCcdBox& box)
{
    m_boxes[std::size_t(index)] = box;
    m_isSorted = false;
}

const std::vector<int>& btCcdSweptBoxes::meeting(const btCcdBox& box)
{
    m_found.clear();
    if (m_boxes.size() <= kFewBoxes)
    {
        for (std::size_t i = 0; i < m_boxes.size(); ++i)
        {
            if (meet(box, m_boxes[i]))
            {
                m_found.push_back(int(i));
            }
        }
        return m_found;
    }
    sort();
    const auto isBefore = [](const Begin& begin, btScalar low) { return begin.m_low < low; };
    auto begin =
        std::lower_bound(m_begins.begin(), m_begins.end(), box.m_low[m_axis] - m_longest, isBefore);
    for (; begin != m_begins.end() && begin->m_low <= box.m_high[m_axis]; ++begin)
    {
        if (meet(box, m_boxes[std::size_t(begin->m_index)]))
        {
            m_found.push_back(begin->m_index);
        }
    }
    std::sort(m_found.begin(), m_found.end());
    return m_found;
}

/// Between two looks few boxes change or come, so insertion is quick.
void btCcdSweptBoxes::sort()
{
    if (m_isSorted)
    {
        return;
    }
    m_isSorted = true;
    const std::size_t known = m_begins.size();
    if (known == 0)
    {
        btCcdBox middles;
        for (const btCcdBox& box : m_boxes)
        {
            const btVector3 middle = btScalar(0.5) * (box.m_low + box.m_high);
            middles.m_low.setMin(middle);
            middles.m_high.setMax(middle);
        }
        m_axis = (middles.m_high - middles.m_low).maxAxis();
    }
    for (std::size_t i = known; i < m_boxes.size(); ++i)
    {
        m_begins.push_back({btScalar(0), int(i)});
    }
    for (Begin& begin : m_begins)
    {
        const btCcdBox& box = m_boxes[std::size_t(begin.m_index)];
        begin.m_low = box.m_low[m_axis];
        m_longest = std::max(m_longest, kRoomOfBoxes * (box.m_high[m_axis] - begin.m_low));
    }
    const auto isLess = [](const Begin& a, const Begin& b) { return a.m_low < b.m_low; };
    if (m_begins.size() - known > known / 8)
    {
        std::sort(m_begins.begin(), m_begins.end(), isLess);
        return;
    }
    for (auto begin = m_begins.begin(); begin != m_begins.end(); ++begin)
    {
        for (auto at = begin; at != m_begins.begin() && isLess(*at, *(at - 1)); --at)
        {
            std::swap(*at, *(at - 1));
        }
    }
}
