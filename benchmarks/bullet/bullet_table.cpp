/// The tunnelling table: how many of its runs each kind of world lets through.
#include "benchmarks/reference/bullet/pile.h"
#include "benchmarks/reference/bullet/tunnelling.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace
{
using namespace bullet_ccd::reference;
using bullet_ccd::benchmarks::Table;

/// Lost time that a world may have, of the simulated time.
constexpr double kMaxLost = 0.01;
/// What the drift may lag behind beyond that: Bullet's contacts of convex shapes with inner edges
/// of a mesh push sideways, so that a hit brakes the drift.
constexpr double kMaxTilt = 0.12;

struct Cell
{
    int runs = 0;
    int through = 0;
    int ghosts = 0;
    double lost = 0.0;  ///< worst run and body: lost time / simulated time
    double lag = 0.0;   ///< worst run: the same of the centre of mass, seen from outside
};

Cell cellOf(const RunOutcome& outcome)
{
    return {.runs = 1,
            .through = outcome.through ? 1 : 0,
            .ghosts = isGhostStop(outcome) ? 1 : 0,
            .lost = outcome.lost / outcome.simulated,
            .lag = outcome.lag / outcome.simulated};
}

void add(Cell& sum, const Cell& cell)
{
    sum.runs += cell.runs;
    sum.through += cell.through;
    sum.ghosts += cell.ghosts;
    sum.lost = std::max(sum.lost, cell.lost);
    sum.lag = std::max(sum.lag, cell.lag);
}

struct Options
{
    int phases = 0;  ///< 0: as the row says
    std::string only;
    bool settings = false;
    bool list = false;
};

void runCell(
    const TunnellingRow& row, const Setting& setting, Kind kind, const Options& options, Cell& cell)
{
    const int phases = options.phases > 0 ? options.phases : row.phases;
    for (int phase = 0; phase < phases; ++phase)
    {
        const RunOutcome outcome = row.run(kind, setting, double(phase) / phases);
        add(cell, cellOf(outcome));
        const bool frozen = kind == Kind::World && outcome.lost > kMaxLost * outcome.simulated;
        if (options.list && isOurs(kind) && (outcome.through || isGhostStop(outcome) || frozen))
        {
            fmt::print("  {}: {}, dt 1/{:.0f}, speed {}, phase {}/{}: closest {:.2e} m\n",
                       outcome.through        ? "through"
                       : isGhostStop(outcome) ? "stopped in the air"
                                              : "frozen",
                       nameOf(kind),
                       1.0 / setting.timeStep,
                       setting.speed,
                       phase,
                       phases,
                       outcome.closest);
        }
    }
}

/// A column of runs per kind of world, and of ours what else there is to say.
std::string columns()
{
    std::string all = "runs that went through=name:<44";
    for (const Kind kind : kAllKinds)
    {
        all += fmt::format("|{}:>12", nameOf(kind));
        if (isOurs(kind))
        {
            const std::string code = codeOf(kind);
            all += fmt::format("|air=air{0}:>5|lost %=lost{0}:>7.2f|lag %=lag{0}:>7.2f", code);
        }
    }
    return all;
}

nlohmann::json rowOf(const std::string& name, const std::vector<Cell>& cells)
{
    nlohmann::json row{{"name", name}};
    for (std::size_t i = 0; i < cells.size(); ++i)
    {
        const Cell& cell = cells[i];
        const std::string code = codeOf(kAllKinds[i]);
        row[nameOf(kAllKinds[i])] = fmt::format("{}/{}", cell.through, cell.runs);
        row["air" + code] = cell.ghosts;
        row["lost" + code] = 100.0 * cell.lost;
        row["lag" + code] = 100.0 * cell.lag;
    }
    return row;
}

/// What the table must not have; prints it.
bool isGood(Kind kind, const Cell& cell)
{
    bool good = true;
    const auto require = [&](bool condition, const std::string& what)
    {
        if (!condition)
        {
            fmt::print("FAILED: {}: {}\n", nameOf(kind), what);
            good = false;
        }
    };
    if (isOurs(kind))
    {
        require(cell.through == 0, fmt::format("{} of {} runs through", cell.through, cell.runs));
        require(cell.ghosts == 0, fmt::format("{} stopped in the air", cell.ghosts));
    }
    if (kind == Kind::World)
    {
        require(cell.lost <= kMaxLost, fmt::format("{:.2f} % of the time lost", 100 * cell.lost));
        // In single precision Bullet's normals on large triangles may be anything.
        require(!kDouble || cell.lag <= cell.lost + kMaxTilt,
                fmt::format("{:.2f} % lag, more than was counted as lost", 100 * cell.lag));
    }
    if (kind == Kind::Stock)
    {
        // The control: a table in which stock Bullet loses nothing proves nothing.
        require(cell.through > cell.runs / 4, "hardly anything went through");
    }
    return good;
}

/// A body in free flight beside a busy pile must not feel it.
bool fallsFreely(Kind kind)
{
    const PileFall fall = fallBesidePile(kind);
    const double ratio = fall.way / fall.expected;
    fmt::print("free fall beside a busy pile, {}: {:.4f} of g t^2 / 2 ({} impacts in the pile)\n",
               nameOf(kind),
               ratio,
               fall.impacts);
    return std::abs(ratio - 1.0) <= 0.01;
}

bool run(const Options& options)
{
    const std::vector<TunnellingRow> rows =
        bullet_ccd::benchmarks::only(tunnellingRows(), options.only);
    fmt::print("btScalar {}\n", kDouble ? "double" : "float");
    const Table table(columns());
    std::vector<Cell> all(kAllKinds.size());
    for (const TunnellingRow& row : rows)
    {
        std::vector<Cell> cells(kAllKinds.size());
        for (const Setting& setting : row.settings)
        {
            std::vector<Cell> parts(kAllKinds.size());
            for (std::size_t i = 0; i < kAllKinds.size(); ++i)
            {
                runCell(row, setting, kAllKinds[i], options, parts[i]);
                add(cells[i], parts[i]);
            }
            if (options.settings)
            {
                table.print(rowOf(
                    fmt::format("    dt 1/{:.0f}, speed {}", 1 / setting.timeStep, setting.speed),
                    parts));
            }
        }
        table.print(rowOf(row.name, cells));
        for (std::size_t i = 0; i < cells.size(); ++i)
        {
            add(all[i], cells[i]);
        }
    }
    table.print(rowOf("all", all));
    bool good = true;
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        good = isGood(kAllKinds[i], all[i]) && good;
        good = fallsFreely(kAllKinds[i]) && good;
    }
    return good;
}
}  // namespace

int main(int argc, char** argv)
{
    Options options;
    return bullet_ccd::benchmarks::runProgram(
        argc,
        argv,
        {.name = "bullet_table",
         .about =
             "Tunnelling table: runs that went through, stock Bullet beside bullet_ccd; of ours "
             "also those that were stopped in the air, the worst lost time by the counters, and "
             "the lag of the motion seen from outside, both % of the simulated time. The exit "
             "code is not 0 if ours let anything through, stopped anything in the air, "
             "or (the world) lost more than 1 % of the time.",
         .options =
             {{"-n,--phases", &options.phases, "runs of each setting; 0: as the row says", 0},
              {"--only", &options.only, "rows whose name contains this"},
              {"--settings", &options.settings, "a line for every time step and speed"},
              {"--list", &options.list, "name every run of ours that failed"}},
         .run = [&] { return run(options); }});
}
