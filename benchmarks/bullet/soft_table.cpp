/// Cloth dropped onto thin boxes and meshes: nodes that go through in stock Bullet and with the
/// check, and what the check costs beside the rest of the same steps.
#include "benchmarks/reference/bullet/soft_scene.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "benchmarks/support/checkpoint.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/sandbox.h"
#include "benchmarks/support/table.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::reference;
using benchmarks::Table;
using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Arguments
{
    int cells = 35;  ///< of a side of the cloth
    double seconds = 0.4;
    double stockSeconds = 5.0;
    bool quick = false;
    std::string checkpoint = {};
    std::vector<std::string> floors{"box", "plate", "ball", "torus", "cup", "figure"};
};

TriangleMesh moved(TriangleMesh mesh, const Vector3d& way)
{
    for (Vector3d& x : mesh.vertices)
    {
        x += way;
    }
    return mesh;
}

TriangleMesh floorMesh(const std::string& name)
{
    if (name == "box")
    {
        return makeBox({1.0, 0.0025, 1.0});
    }
    if (name == "plate")
    {
        return {.vertices = {{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {1, 0, 1}},
                .triangles = {{0, 2, 1}, {1, 2, 3}}};
    }
    if (name == "ball")
    {
        return makeSphere(0.3, 3);
    }
    if (name == "torus")
    {
        return makeTorus(0.3, 0.1, 32, 16);
    }
    TriangleMesh mesh = makeBox({1.0, 0.01, 1.0});
    if (name == "cup")
    {
        for (int i = 0; i < 12; ++i)  // a ring of posts
        {
            const double turn = i * 0.5235987755982988;
            appendMesh(mesh,
                       moved(makeBox({0.01, 0.1, 0.01}),
                             {0.3 * std::cos(turn), 0.12, 0.3 * std::sin(turn)}));
        }
        return mesh;
    }
    appendMesh(mesh, moved(makeSphere(0.2, 3), {0.0, 0.22, 0.0}));
    appendMesh(mesh, moved(makeSphere(0.12, 3), {0.15, 0.45, 0.0}));
    return mesh;
}

struct Outcome
{
    SoftVerdict verdict;
    double milliseconds = 0.0;  ///< of a step without the check
    double check = 0.0;         ///< of a step, in the mean [ms]
    double worst = 0.0;         ///< of a step [ms]
};

Outcome drop(SoftWorld kind,
             const Arguments& arguments,
             const std::string& floor,
             double speed,
             double rate,
             int cloths)
{
    SoftScene scene(kind);
    const TriangleMesh mesh = floorMesh(floor);
    if (floor == "box")
    {
        scene.obstacle(std::make_unique<btBoxShape>(btVector3(1, btScalar(0.0025), 1)), mesh);
    }
    else
    {
        scene.obstacle(btCcdMeshShape::fromMesh(mesh), mesh);
    }
    for (int k = 0; k < cloths; ++k)
    {
        const Isometry3d X(Eigen::Translation3d(0.0, 0.8 + 0.1 * k, 0.0));
        scene.cloth(X, 1.4, arguments.cells, 5.0)
            ->setVelocity(btVector3(0, btScalar(-speed * (k == 0 ? 1.0 : 1.5)), 0));
    }
    Outcome outcome;
    const double most = kind == SoftWorld::Stock ? arguments.stockSeconds : 1e9;
    int steps = 0;
    for (; steps < int(arguments.seconds * rate + 0.5) && scene.seconds() < most; ++steps)
    {
        const double before = scene.checkSeconds();
        scene.step(1.0 / rate);
        outcome.worst = std::max(outcome.worst, 1e3 * (scene.checkSeconds() - before));
    }
    outcome.verdict = scene.judge();
    outcome.check = 1e3 * scene.checkSeconds() / steps;
    outcome.milliseconds = 1e3 * scene.seconds() / steps - outcome.check;
    return outcome;
}

/// Both worlds on the same drop; without the columns of stock Bullet where that crashes.
nlohmann::json measured(
    const Arguments& arguments, const std::string& floor, int cloths, double speed, double rate)
{
    const auto stock = benchmarks::sandboxedAnswer<Outcome>(
        1e4, [&] { return drop(SoftWorld::Stock, arguments, floor, speed, rate, cloths); });
    const Outcome ours = drop(SoftWorld::Solver, arguments, floor, speed, rate, cloths);
    nlohmann::json row{{"floor", floor},
                       {"cloths", cloths},
                       {"speed", int(speed)},
                       {"rate", int(rate)},
                       {"through", ours.verdict.through},
                       {"crossing", ours.verdict.crossing},
                       {"isClean", ours.verdict.isClean()},
                       {"rest", ours.milliseconds},
                       {"check", ours.check},
                       {"worst", ours.worst},
                       {"toRest", ours.check / ours.milliseconds}};
    if (stock.end == benchmarks::SandboxEnd::Answered)
    {
        row["lost"] = stock.answer.verdict.through;
        row["stock"] = stock.answer.milliseconds;
        row["toStock"] = ours.check / stock.answer.milliseconds;
    }
    return row;
}

/// Times of drops in which stock Bullet did not crash [ms of a step].
struct Sum
{
    double check = 0.0;
    double stock = 0.0;
    double rest = 0.0;

    void add(const nlohmann::json& row)
    {
        check += row["check"].get<double>();
        stock += row["stock"].get<double>();
        rest += row["rest"].get<double>();
    }
};

bool run(const Arguments& arguments)
{
    const char* const precision = sizeof(btScalar) == 4 ? "single" : "double";
    fmt::print("cloth of {} triangles, {} precision; ms of processor time a step\n",
               2 * arguments.cells * arguments.cells,
               precision);
    const Table table(
        "floor:<6|cloths:>6|m/s=speed:>4|1/s=rate:>4|stock through=lost:>13|"
        "through:>7|crossing:>8|stock ms=stock:>8.2f|rest ms=rest:>8.2f|"
        "check ms=check:>8.2f|worst ms=worst:>8.1f|/ stock=toStock:>7.2f|/ rest=toRest:>6.2f");
    using Doubles = std::vector<double>;
    const Doubles speeds = arguments.quick ? Doubles{20.0} : Doubles{1.0, 5.0, 20.0, 50.0};
    const Doubles rates = arguments.quick ? Doubles{60.0} : Doubles{30.0, 60.0, 120.0, 240.0};
    const std::string file = arguments.checkpoint + "." + precision;
    const nlohmann::json settings{{"precision", precision},
                                  {"cells", arguments.cells},
                                  {"seconds", arguments.seconds},
                                  {"stockSeconds", arguments.stockSeconds}};
    const bool isKept = !arguments.checkpoint.empty();
    nlohmann::json rows = nlohmann::json::object();
    if (isKept)
    {
        rows = benchmarks::loadCheckpoint(file, settings).value_or(rows);
    }
    int wrong = 0;
    double mean = 0.0;  // of the floors, one cloth and two: checks over stock steps
    for (const std::string& floor : arguments.floors)
    {
        std::array<Sum, 3> sums;  // all, of one cloth, of two
        for (int i = 0; i < 2 * int(speeds.size() * rates.size()); ++i)
        {
            const double rate = rates[std::size_t(i) % rates.size()];
            const double speed = speeds[std::size_t(i) / rates.size() % speeds.size()];
            const int cloths = 1 + i / int(speeds.size() * rates.size());
            nlohmann::json& row = rows[fmt::format("{} {} {} {}", floor, cloths, speed, rate)];
            if (row.is_null())
            {
                row = measured(arguments, floor, cloths, speed, rate);
                if (isKept)
                {
                    benchmarks::saveCheckpoint(file, settings, rows);
                }
            }
            table.print(row);
            wrong += row["isClean"].get<bool>() ? 0 : 1;
            if (row.contains("stock"))
            {
                sums[0].add(row);
                sums[std::size_t(cloths)].add(row);
            }
        }
        const auto toStock = [&](std::size_t i) { return sums[i].check / sums[i].stock; };
        mean += (toStock(1) + toStock(2)) / (2.0 * double(arguments.floors.size()));
        fmt::print("{}, {}: checks / stock steps = {:.2f} with one cloth, {:.2f} with two, ",
                   floor,
                   precision,
                   toStock(1),
                   toStock(2));
        fmt::print("{:.2f} of all; / the rest of the steps = {:.2f} of all\n",
                   toStock(0),
                   sums[0].check / sums[0].rest);
    }
    fmt::print(
        "mean of {} floors with one cloth and two, {} precision: checks / stock steps = {:.2f}\n",
        arguments.floors.size(),
        precision,
        mean);
    fmt::print("{} drops with something through, crossing or not finite\n", wrong);
    return wrong == 0;
}
}  // namespace

int main(int argc, char** argv)
{
    Arguments arguments;
    return benchmarks::runProgram(
        argc,
        argv,
        {.name = sizeof(btScalar) == 4 ? "soft_table_single" : "soft_table_double",
         .about = "Cloth dropped onto thin things: what goes through, and what the check costs.",
         .options = {{"--cells", &arguments.cells, "of a side of the cloth"},
                     {"--seconds", &arguments.seconds, "simulated time of a drop [s]"},
                     {"--stock-seconds",
                      &arguments.stockSeconds,
                      "after which a drop in stock Bullet ends [s]"},
                     {"--floors", &arguments.floors, "box, plate, ball, torus, cup, figure"},
                     {"--quick", &arguments.quick, "one speed and one rate"},
                     {"--checkpoint",
                      &arguments.checkpoint,
                      "keeps finished drops in this file: the next run does not repeat them"}},
         .run = [&] { return run(arguments); }});
}
