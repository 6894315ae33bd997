/// A warm query allocates nothing, and a batch over threads answers as one query after the other.
#include "bullet_ccd/toi/rigid_toi.h"
#include "tests/support/random_scenes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace
{
std::atomic<std::int64_t> allocations{0};

void* counted(std::size_t size, std::size_t alignment)
{
    ++allocations;
    // aligned_alloc wants a multiple of the alignment.
    void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (memory == nullptr)
    {
        throw std::bad_alloc();
    }
    return memory;
}
}  // namespace

// Counting replacements of the global operators.
void* operator new(std::size_t size)
{
    return counted(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment)
{
    return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept
{
    std::free(memory);
}

namespace bullet_ccd::tests
{
namespace
{
struct Query
{
    SsvTree treeA;
    SsvTree treeB;
    RigidMotion motionA;
    RigidMotion motionB;

    [[nodiscard]] RigidBodyPair pair() const
    {
        return {.bodyA = {.tree = &treeA, .motion = motionA},
                .bodyB = {.tree = &treeB, .motion = motionB}};
    }
};

std::vector<Query> randomQueries(int count)
{
    Random random(41);
    std::vector<Query> queries;
    for (int i = 0; i < count; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        queries.push_back({.treeA = buildSsvTree(scene.meshA),
                           .treeB = buildSsvTree(scene.meshB),
                           .motionA = scene.motionA,
                           .motionB = scene.motionB});
    }
    return queries;
}

TEST(RigidToiWorkspace, WarmQueriesAllocateNothing)
{
    const std::vector<Query> queries = randomQueries(30);
    for (const ToiStrategy strategy :
         {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
    {
        ToiWorkspace work;
        const ToiOptions options{.strategy = strategy};
        int hits = 0;
        for (const Query& query : queries)
        {
            const RigidBodyPair pair = query.pair();
            const ToiResult first = rigidToi(pair.bodyA, pair.bodyB, options, work);
            const std::int64_t before = allocations;
            const ToiResult second = rigidToi(pair.bodyA, pair.bodyB, options, work);
            EXPECT_EQ(allocations, before);
            EXPECT_EQ(first.time, second.time);
            hits += isContact(second.status) ? 1 : 0;
        }
        EXPECT_GT(hits, 5);
    }
}

TEST(RigidToiWorkspace, BatchesAnswerAsQueriesOneByOne)
{
    const std::vector<Query> queries = randomQueries(60);
    std::vector<RigidBodyPair> pairs;
    for (const Query& query : queries)
    {
        pairs.push_back(query.pair());
    }
    const std::vector<ToiResult> batch = rigidTois(pairs, {});
    ASSERT_EQ(batch.size(), pairs.size());
    ToiWorkspace work;
    for (std::size_t i = 0; i < pairs.size(); ++i)
    {
        const ToiResult alone = rigidToi(pairs[i].bodyA, pairs[i].bodyB, {}, work);
        EXPECT_EQ(batch[i].status, alone.status);
        EXPECT_EQ(batch[i].time, alone.time);
        EXPECT_EQ(batch[i].triangleA, alone.triangleA);
        EXPECT_EQ(batch[i].counters.nodePairs, alone.counters.nodePairs);
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
