#include "grasp/sim/settle.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Boxes and balls above a table of 0.4 m.
struct Heap
{
    SsvTree table = buildSsvTree(makeBox({0.4, 0.4, 0.02}));
    RigidBody top{.tree = &table,
                  .motion = restAt(Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, -0.02)))};
    GraspObject box = makeGraspObject("box", makeBox({0.02, 0.03, 0.04}));
    GraspObject slab = makeGraspObject("slab", makeBox({0.04, 0.04, 0.01}));

    [[nodiscard]] SettledObjects settled(int count, const ClutterOptions& options) const
    {
        std::vector<const GraspObject*> objects;
        for (int i = 0; i < count; ++i)
        {
            objects.push_back(i % 2 == 0 ? &box : &slab);
        }
        return settle(objects, std::span(&top, 1), options);
    }
};

TEST(Settle, ObjectsWithRoomStandWhereTheyWereLetGo)
{
    const Heap heap;
    const SettledObjects settled = heap.settled(6, {});
    EXPECT_TRUE(settled.atRest);
    ASSERT_EQ(settled.X_WO.size(), 6U);
    for (std::size_t i = 0; i < 6; ++i)
    {
        // On the skins, upright.
        const double half = i % 2 == 0 ? 0.04 : 0.01;
        EXPECT_NEAR(settled.X_WO[i].translation().z(), half, 2e-3) << i;
        EXPECT_GT(settled.X_WO[i].linear()(2, 2), 0.999) << i;
    }
    const SettledObjects again = heap.settled(6, {});
    const SettledObjects other = heap.settled(6, {.seed = 2});
    for (std::size_t i = 0; i < 6; ++i)
    {
        EXPECT_EQ(settled.X_WO[i].matrix(), again.X_WO[i].matrix());
        EXPECT_NE(settled.X_WO[i].matrix(), other.X_WO[i].matrix());
    }
}

TEST(Settle, AHeapComesToRestWithoutPenetration)
{
    const Heap heap;
    const SettledObjects settled = heap.settled(8, {.from = {-0.05, -0.05}, .to = {0.05, 0.05}});
    double highest = 0.0;
    for (std::size_t i = 0; i < settled.X_WO.size(); ++i)
    {
        const SsvTree& a = i % 2 == 0 ? heap.box.tree : heap.slab.tree;
        highest = std::max(highest, settled.X_WO[i].translation().z());
        EXPECT_GT(treeDistance(a, heap.table, heap.top.motion.X_W0.inverse() * settled.X_WO[i], 1.0)
                      .distance,
                  0.0)
            << i;
        for (std::size_t k = 0; k < i; ++k)
        {
            const SsvTree& b = k % 2 == 0 ? heap.box.tree : heap.slab.tree;
            EXPECT_GT(treeDistance(a, b, settled.X_WO[k].inverse() * settled.X_WO[i], 1.0).distance,
                      0.0)
                << i << " and " << k;
        }
    }
    EXPECT_GT(highest, 0.05) << "they do not all lie side by side";
    EXPECT_TRUE(settled.atRest);
}

TEST(Settle, RefusesWhatMakesNoSense)
{
    const Heap heap;
    EXPECT_THROW(static_cast<void>(heap.settled(0, {})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(heap.settled(1, {.from = {0.1, 0.0}, .to = {0.0, 0.1}})),
                 std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::grasp
