// Times of impact of pairs by Bullet's own methods and by ours, and the time per step of worlds.
//
// Every answer is checked against a proved one before anything is timed. Repeats of all methods
// take turns; the number of a query is the median over the repeats, the number of a family the mean
// over its queries. Processor time of one thread.
#include "benchmarks/bullet/bench_bullet_queries.h"
#include "benchmarks/bullet/bench_bullet_worlds.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fmt/format.h>

namespace
{
using namespace bullet_ccd::benchmarks;

void printQueries(int count, int repeats)
{
    fmt::print("{:<26}{:<30}{:>8} {:>7} {:>6} {:>6} {:>10} {:>10} {:>9}\n",
               "pair",
               "method",
               "hits",
               "missed",
               "late",
               "false",
               "latest mm",
               "error mm",
               "us");
    for (const QueryFamily& family : queryFamilies(count, 1))
    {
        if (family.dropped > 0)
        {
            fmt::print("{}: {} queries left out, no proof\n", family.name, family.dropped);
        }
        for (const CastRow& row : runFamily(family, repeats))
        {
            fmt::print("{:<26}{:<30}{:>8} {:>7} {:>6} {:>6} {:>10.4f} {:>10.4f} {:>9.2f}\n",
                       row.family,
                       row.method,
                       fmt::format("{}/{}", row.hits, row.queries),
                       row.missed,
                       row.late,
                       row.falseHits,
                       1e3 * row.latest,
                       1e3 * row.error,
                       row.microseconds);
        }
        std::fflush(stdout);
    }
}

void printWorlds(const std::vector<int>& bodies, int steps)
{
    fmt::print("\n{:>6} {:<14}{:>12} {:>12} {:>10} {:>12} {:>12}\n",
               "bodies",
               "world",
               "median us",
               "mean us",
               "got out",
               "queries/step",
               "impacts/step");
    for (const int count : bodies)
    {
        for (const WorldRow& row : runWorlds(count, steps))
        {
            fmt::print("{:>6} {:<14}{:>12.1f} {:>12.1f} {:>10} {:>12.2f} {:>12.2f}\n",
                       row.bodies,
                       bullet_ccd::tests::nameOf(row.kind),
                       row.median,
                       row.mean,
                       row.outside,
                       row.queries,
                       row.impacts);
        }
        std::fflush(stdout);
    }
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app("Bullet's own continuous collision detection beside ours: pairs and worlds.");
    int count = 100;
    int repeats = 11;
    int steps = 240;
    std::vector<int> bodies{10, 100, 1000};
    bool noQueries = false;
    app.add_option("-n,--count", count, "Queries a pair of shapes")->check(CLI::PositiveNumber);
    app.add_option("--repeats", repeats, "Repeats of every query")->check(CLI::PositiveNumber);
    app.add_option("--steps", steps, "Steps of every world")->check(CLI::PositiveNumber);
    app.add_option("--bodies", bodies, "Sizes of worlds; 0: none");
    app.add_flag("--no-queries", noQueries, "Worlds only");
    CLI11_PARSE(app, argc, argv);
    fmt::print("btScalar {}\n", bullet_ccd::tests::kDouble ? "double" : "float");
    if (!noQueries)
    {
        printQueries(count, repeats);
    }
    std::erase(bodies, 0);
    if (!bodies.empty())
    {
        printWorlds(bodies, steps);
    }
    return 0;
}
