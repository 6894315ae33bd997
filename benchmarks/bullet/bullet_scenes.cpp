/// Days of programs that use Bullet: what goes wrong in a stock world, with the action, and in our
/// world, and what it costs.
#include "benchmarks/reference/bullet/days.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"

#include <algorithm>
#include <malloc.h>
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
        const struct mallinfo2 held = mallinfo2();
        memory = std::max(memory, 1e-6 * double(held.uordblks + held.hblkhd));
        lost = scene.counters().m_lostTime;
    };
    const int wrong = play(day, kind, step);
    return {{"name", day.name},
            {"world", nameOf(kind)},
            {"what", day.wrong},
            {"wrong", wrong},
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
        }
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
         .about = "Ordinary and less ordinary days of programs that use Bullet, in a stock world "
                  "(where meshes that move are boxes), with the action, and in our world: how many "
                  "bodies fared badly, milliseconds of processor time of the median and the worst "
                  "step, time that bodies lost, and megabytes that the program holds. The exit "
                  "code is not 0 if anything of ours went through, or more fared badly than in "
                  "stock Bullet.",
         .options = {{"--only", &part, "scenes whose name contains this", 0}},
         .run = [&] { return run(part); }});
}
