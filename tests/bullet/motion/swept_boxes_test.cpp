#include "bullet_ccd/bullet/motion/btCcdSweptBoxes.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace bullet_ccd::tests
{
namespace
{
/// Long and short ones; some that touch others exactly, far from the origin.
btCcdBox randomBox(std::mt19937& random)
{
    std::uniform_int_distribution<int> place(-40, 40);
    std::uniform_int_distribution<int> size(0, 3);
    std::uniform_int_distribution<int> tenth(0, 9);
    const btScalar longer = tenth(random) == 0 ? btScalar(8) : btScalar(1);
    const btVector3 low(btScalar(1000 + place(random)),
                        btScalar(place(random)),
                        btScalar(place(random)) * btScalar(0.25));
    const btVector3 extent(btScalar(size(random)), btScalar(size(random)), btScalar(size(random)));
    return {low, low + longer * extent};
}

bool meet(const btCcdBox& a, const btCcdBox& b)
{
    bool all = true;
    for (int k = 0; k < 3; ++k)
    {
        all = all && a.m_low[k] <= b.m_high[k] && b.m_low[k] <= a.m_high[k];
    }
    return all;
}
}  // namespace

/// Few and many boxes, that come, change, and come again.
TEST(SweptBoxes, FindsAllThatMeetInOrder)
{
    std::mt19937 random(3);
    btCcdSweptBoxes boxes;
    int found = 0;
    for (int round = 0; round < 30; ++round)
    {
        boxes.clear();
        std::vector<btCcdBox> all;
        const int count = round % 3 == 0 ? 20 : 300;
        for (int step = 0; step < 60; ++step)
        {
            for (int i = 0; i < (step == 0 ? count : step % 4); ++i)
            {
                all.push_back(randomBox(random));
                boxes.add(all.back());
            }
            for (int i = 0; i < step % 5; ++i)
            {
                const int index = std::uniform_int_distribution(0, boxes.size() - 1)(random);
                all[std::size_t(index)] = randomBox(random);
                boxes.set(index, all[std::size_t(index)]);
            }
            const btCcdBox asked = randomBox(random);
            std::vector<int> expected;
            for (std::size_t i = 0; i < all.size(); ++i)
            {
                if (meet(asked, all[i]))
                {
                    expected.push_back(int(i));
                }
            }
            found += int(expected.size());
            ASSERT_EQ(boxes.meeting(asked), expected) << round << ", step " << step;
        }
    }
    EXPECT_GT(found, 1000);
}
}  // namespace bullet_ccd::tests
