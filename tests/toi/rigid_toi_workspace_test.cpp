/// A warm query allocates nothing, and queries on several threads answer as one after the other.
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "bullet_ccd/toi/articulated_toi.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>
#include <thread>

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

// Counting replacements of the global operators. Not to be inlined: where only one of a pair is,
// the compiler takes it for a mismatch.
void* operator new(std::size_t size)
{
    return counted(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment)
{
    return counted(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept
{
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept
{
    std::free(memory);
}

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
struct Query
{
    SsvTree treeA;
    SsvTree treeB;
    RigidMotion motionA;
    RigidMotion motionB;

    [[nodiscard]] ToiResult ask(const ToiOptions& options, ToiWorkspace& work) const
    {
        return rigidToi({.tree = &treeA, .motion = motionA},
                        {.tree = &treeB, .motion = motionB},
                        options,
                        work);
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
            const ToiResult first = query.ask(options, work);
            const std::int64_t before = allocations;
            const ToiResult second = query.ask(options, work);
            EXPECT_EQ(allocations, before);
            EXPECT_EQ(first.time, second.time);
            hits += isContact(second.status) ? 1 : 0;
        }
        EXPECT_GT(hits, 5);
    }
}

TEST(ArticulatedToiWorkspace, WarmQueriesWithoutContactAllocateNothing)
{
    // Only the contacts of a result are allocated.
    Random random(42);
    ToiWorkspace work;
    int quiet = 0;
    for (int i = 0; i < 60; ++i)
    {
        const KinematicTree tree = randomTree(random, 6, 0.3);
        const JointMotion motion = randomJointMotion(random, tree, 3.0);
        const SsvTree mesh = buildSsvTree(randomMesh(random));
        const std::vector<const SsvTree*> links(6, &mesh);
        std::vector<RigidBody> obstacles;
        for (int k = 0; k < 20; ++k)
        {
            RigidMotion at = randomRigidMotion(random, k % 4 == 0 ? 1.0 : 0.0);
            at.X_W0.translation() = random.uniform(2.0, 12.0) * random.direction();
            obstacles.push_back({.tree = &mesh, .motion = at});
        }
        const Environment environment(obstacles);
        const ArticulatedBody body{
            .tree = &tree, .linkTrees = links, .motion = &motion, .selfPairs = {}};
        const ArticulatedToiResult first = articulatedToi(body, environment, {}, work);
        const std::int64_t before = allocations;
        const ArticulatedToiResult second = articulatedToi(body, environment, {}, work);
        const std::int64_t after = allocations;
        EXPECT_EQ(first.time, second.time);
        if (second.status == ToiStatus::Separated)
        {
            EXPECT_EQ(after, before);
            quiet += second.counters.nodePairs > 0 ? 1 : 0;
        }
    }
    EXPECT_GT(quiet, 5);
}

TEST(RigidToiWorkspace, ThreadsAnswerAsQueriesOneByOne)
{
    // Every thread has a workspace of its own and begins elsewhere.
    const std::vector<Query> queries = randomQueries(60);
    std::array<std::vector<ToiResult>, 4> answers;
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < answers.size(); ++k)
    {
        threads.emplace_back(
            [&, k]
            {
                ToiWorkspace work;
                answers[k].resize(queries.size());
                for (std::size_t i = 0; i < queries.size(); ++i)
                {
                    const std::size_t query = (i + 15 * k) % queries.size();
                    answers[k][query] = queries[query].ask({}, work);
                }
            });
    }
    threads.clear();
    ToiWorkspace work;
    int hits = 0;
    for (std::size_t i = 0; i < queries.size(); ++i)
    {
        const ToiResult alone = queries[i].ask({}, work);
        hits += isContact(alone.status) ? 1 : 0;
        for (const std::vector<ToiResult>& answer : answers)
        {
            EXPECT_EQ(answer[i].status, alone.status);
            EXPECT_EQ(answer[i].time, alone.time);
            EXPECT_EQ(answer[i].triangleA, alone.triangleA);
            EXPECT_EQ(answer[i].counters.nodePairs, alone.counters.nodePairs);
        }
    }
    EXPECT_GT(hits, 10);
}
}  // namespace
}  // namespace bullet_ccd::tests
