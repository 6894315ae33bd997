// First contact of two boxes, exact shapes without triangles, beside Bullet's three convex casts.
//
// Every answer of ours is judged by a proof or a counterexample before anything is timed; the exit
// code is 1 if one is wrong. Queries are asked in batches, since one takes less than the clock
// does; all methods take turns. Processor time of one thread; Bullet gets its transforms ready
// made.
#include "benchmarks/reference/queries/convex_queries.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/bullet/btCcdConversions.h"

#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>

#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
namespace
{
using reference::ConvexQueryCase;

/// A query as Bullet is asked it.
struct BulletBoxes
{
    std::array<btBoxShape, 2> shapes;
    std::array<btTransform, 4> at;  ///< A at the start and the end, B likewise

    explicit BulletBoxes(const ConvexQueryCase& query)
        : shapes{btBoxShape(btCcdToBullet(query.shapes[0].shape.half)),
                 btBoxShape(btCcdToBullet(query.shapes[1].shape.half))}
    {
        for (std::size_t i = 0; i < at.size(); ++i)
        {
            at[i] = btCcdToBullet(query.motions[i / 2].at(static_cast<double>(i % 2)).X_W);
        }
        for (btBoxShape& shape : shapes)
        {
            shape.setMargin(1e-3);  // of which its casts need some
        }
    }
};

template <typename Cast, typename... Solver>
double castByBullet(const BulletBoxes& query, Solver*... solver)
{
    btVoronoiSimplexSolver simplex;
    Cast cast(&query.shapes[0], &query.shapes[1], &simplex, solver...);
    btConvexCast::CastResult result;
    const auto& X = query.at;
    return cast.calcTimeOfImpact(X[0], X[1], X[2], X[3], result) ? result.m_fraction : 2.0;
}

struct ConvexMethod
{
    std::string name;
    std::function<double(std::size_t)> ask;  ///< time of contact; beyond 1 if there is none
};

/// One line for every method; false if an answer of ours is wrong.
bool runBoxes(const Table& table, const std::string& name, double turn, int count, int repeats)
{
    std::vector<ConvexQueryCase> queries;
    std::vector<std::array<ConvexBody, 2>> bodies;
    std::vector<BulletBoxes> bullets;
    queries.reserve(static_cast<std::size_t>(count));
    bullets.reserve(static_cast<std::size_t>(count));
    int wrong = 0;
    for (int i = 0; i < count; ++i)
    {
        queries.push_back(reference::randomBoxes(static_cast<std::uint64_t>(i), turn));
        bullets.emplace_back(queries.back());
        const ConvexQueryCase& q = queries.back();
        bodies.push_back({q.body(0), q.body(1)});
        const ToiResult result = convexToi(bodies.back()[0], bodies.back()[1], q.options);
        wrong += judgeConvex(q, result).verdict == reference::Verdict::Right ? 0 : 1;
    }
    btGjkEpaPenetrationDepthSolver epa;
    const std::vector<ConvexMethod> methods{
        {"ours",
         [&](std::size_t i)
         {
             const ToiResult result = convexToi(bodies[i][0], bodies[i][1], queries[i].options);
             return isContact(result.status) ? result.time : 2.0;
         }},
        {"Bullet continuous convex",
         [&](std::size_t i)
         { return castByBullet<btContinuousConvexCollision>(bullets[i], &epa); }},
        {"Bullet GJK convex cast",
         [&](std::size_t i) { return castByBullet<btGjkConvexCast>(bullets[i]); }},
        {"Bullet subsimplex cast",
         [&](std::size_t i) { return castByBullet<btSubsimplexConvexCast>(bullets[i]); }}};
    constexpr std::size_t kBatch = 250;
    std::vector<TimedMethod> timed;
    for (const ConvexMethod& method : methods)
    {
        timed.push_back({.queries = queries.size() / kBatch,
                         .passes = repeats,
                         .ask = [&](std::size_t batch)
                         {
                             double sum = 0.0;
                             for (std::size_t i = batch * kBatch; i < (batch + 1) * kBatch; ++i)
                             {
                                 sum += method.ask(i);
                             }
                             keep(sum);
                         }});
    }
    const std::vector<std::vector<double>> micros = timeInTurns(timed);
    for (std::size_t m = 0; m < methods.size(); ++m)
    {
        int hits = 0;
        int differ = 0;
        for (std::size_t i = 0; i < queries.size(); ++i)
        {
            const bool isHit = methods[m].ask(i) <= 1.0;
            hits += isHit ? 1 : 0;
            differ += isHit != (methods[0].ask(i) <= 1.0) ? 1 : 0;
        }
        const double nanos = 1e3 * meanOf(micros[m]) / static_cast<double>(kBatch);
        table.print({{"set", name},
                     {"method", methods[m].name},
                     {"queries", queries.size()},
                     {"hits", hits},
                     {"differ", differ},
                     {"wrong", m == 0 ? nlohmann::json(wrong) : nlohmann::json()},
                     {"ns", nanos},
                     {"ratio", meanOf(micros[0]) / meanOf(micros[m])}});
    }
    return wrong == 0;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    int count = 10000;
    int repeats = 7;
    return runProgram(
        argc,
        argv,
        {.name = "bench_convex",
         .about = "First contact of boxes, judged and timed beside Bullet's casts",
         .options = {{"-n,--count", &count, "queries of a set, in batches of 250", 250},
                     {"--repeats", &repeats, "passes; medians count"}},
         .run = [&]
         {
             const Table table(
                 "set:<14|method:<25|queries:>7|hits:>6|differ:>6|"
                 "wrong:>5|ns:>7.0f|ours/this=ratio:>9.2f");
             bool isRight = true;
             for (const auto& [name, turn] :
                  {std::pair{"boxes_turning", 2.6}, {"boxes_sliding", 0.0}})
             {
                 isRight = runBoxes(table, name, turn, count, repeats) && isRight;
             }
             return isRight;
         }});
}
