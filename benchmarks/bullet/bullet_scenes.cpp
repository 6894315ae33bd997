/// What goes wrong on days of programs that use Bullet, and what it costs.
#include "benchmarks/reference/bullet/days.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>

namespace
{
using namespace bullet_ccd::reference;
using namespace bullet_ccd::benchmarks;

nlohmann::json rowOf(const Day& day, Kind kind)
{
    std::vector<double> times;
    double lost = 0.0;
    double memory = 0.0;
    const auto step = [&](Scene& scene, double seconds)
    {
        times.push_back(microsecondsOf([&] { scene.step(seconds); }));
        memory = std::max(memory, heldMegabytes());
        lost = scene.counters().m_lostTime;
    };
    return {{"wrong", play(day, kind, step)},  // first: the others are of its steps
            {"name", day.name},
            {"world", nameOf(kind)},
            {"what", day.wrong},
            {"median", medianOf(times) / 1e3},
            {"worst", *std::ranges::max_element(times) / 1e3},
            {"lost", lost},
            {"memory", memory}};
}

bool run(const std::string& part)
{
    const Table table(
        "scene=name:<24|world:<13|what is counted=what:<16|count=wrong:>6|median ms=median:>9.2f|"
        "worst ms=worst:>9.2f|lost s=lost:>8.3f|MB=memory:>7.1f");
    bool good = true;
    std::map<std::string, std::pair<int, int>> bad;  // days and bodies
    for (const Day& day : only(days(), part))
    {
        int stock = 0;
        for (const Kind kind : {Kind::Stock, Kind::Action, Kind::World})
        {
            const nlohmann::json row = rowOf(day, kind);
            table.print(row);
            const int wrong = row["wrong"].get<int>();
            stock = isOurs(kind) ? stock : wrong;
            good = good && (!isOurs(kind) || day.isGood(wrong, stock));
            bad[nameOf(kind)].first += wrong > 0 ? 1 : 0;
            bad[nameOf(kind)].second += wrong;
        }
    }
    for (const auto& [world, sums] : bad)
    {
        fmt::print("{}: bad days {}, bodies {}\n", world, sums.first, sums.second);
    }
    return good;
}
}  // namespace

int main(int argc, char** argv)
{
    std::string part;
    return runProgram(
        argc,
        argv,
        {.name = "bullet_scenes",
         .about = "Days of programs that use Bullet: what fares badly in a stock world, with the "
                  "action, and in ours. benchmarks/bullet/README.md says when the exit code is 0.",
         .options = {{"--only", &part, "scenes whose name contains this", 0}},
         .run = [&] { return run(part); }});
}
