// Times of impact of pairs by Bullet's own methods and by ours, and the time per step of worlds.
//
// Every answer is checked against a proved one before anything is timed. Repeats of all methods
// take turns; the number of a query is the median over the repeats, the number of a family the mean
// over its queries. Processor time of one thread.
#include "benchmarks/bullet/bench_bullet_queries.h"
#include "benchmarks/bullet/bench_bullet_worlds.h"
#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"

#include <fmt/format.h>

namespace bullet_ccd::benchmarks
{
namespace
{
void printQueries(int count, int repeats)
{
    const Table table(
        "pair:<26|method:<30|hits:>4|of=queries:>4|missed:>6|late:>6|false:>6|"
        "latest mm=latest:>10.4f|error mm=error:>10.4f|us:>9.2f");
    for (const QueryFamily& family : queryFamilies(count, 1))
    {
        if (family.dropped > 0)
        {
            fmt::print("{}: {} queries left out, no proof\n", family.name, family.dropped);
        }
        for (const nlohmann::json& row : runFamily(family, repeats))
        {
            table.print(row);
        }
    }
}

void printWorlds(const std::vector<int>& bodies, int steps)
{
    fmt::print("\n");
    const Table table(
        "bodies:>6|world:<14|median us=median:>12.1f|mean us=mean:>12.1f|got out=outside:>10|"
        "queries/step=queries:>12.2f|impacts/step=impacts:>12.2f");
    for (const int count : bodies)
    {
        for (const nlohmann::json& row : runWorlds(count, steps))
        {
            table.print(row);
        }
    }
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    int count = 100;
    int repeats = 11;
    int steps = 240;
    std::vector<int> bodies{10, 100, 1000};
    bool queries = true;
    const auto run = [&]
    {
        fmt::print("btScalar {}\n", bullet_ccd::reference::kDouble ? "double" : "float");
        if (queries)
        {
            printQueries(count, repeats);
        }
        std::erase(bodies, 0);
        if (!bodies.empty())
        {
            printWorlds(bodies, steps);
        }
        return true;
    };
    return runProgram(
        argc,
        argv,
        {.name = "bench_bullet",
         .about = "Bullet's own continuous collision detection beside ours: pairs and worlds.",
         .options = {{"-n,--count", &count, "queries of each pair of shapes"},
                     {"--repeats", &repeats, "of every query"},
                     {"--steps", &steps, "of every world"},
                     {"--bodies", &bodies, "sizes of worlds; 0: none", 0},
                     {"!--no-queries", &queries, "worlds only"}},
         .run = run});
}
