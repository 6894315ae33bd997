/// Cloth dropped onto thin boxes and meshes: nodes that go through in stock Bullet and with the
/// check, and what the check costs beside the rest of the same steps.
#include "benchmarks/reference/bullet/soft_scene.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>

#include <algorithm>
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
    bool quick = false;
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
        // A ring of posts.
        for (int i = 0; i < 12; ++i)
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
    double seconds = 0.0;       ///< of all steps
    double checkSeconds = 0.0;  ///< of them the check
    double worst = 0.0;         ///< check of a step
    int steps = 0;
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
        Isometry3d X = Isometry3d::Identity();
        X.translation().y() = 0.8 + 0.1 * k;
        scene.cloth(X, 1.4, arguments.cells, 5.0)
            ->setVelocity(btVector3(0, btScalar(-speed * (k == 0 ? 1.0 : 1.5)), 0));
    }
    Outcome outcome;
    outcome.steps = int(arguments.seconds * rate + 0.5);
    for (int i = 0; i < outcome.steps; ++i)
    {
        const double before = scene.checkSeconds();
        scene.step(1.0 / rate);
        outcome.worst = std::max(outcome.worst, scene.checkSeconds() - before);
    }
    outcome.verdict = scene.judge();
    outcome.seconds = scene.seconds();
    outcome.checkSeconds = scene.checkSeconds();
    return outcome;
}

bool run(const Arguments& arguments)
{
    fmt::print(
        "cloth of {} triangles, {} precision; ms of processor time a step; `ratio` is the check "
        "beside the rest of the same steps\n",
        2 * arguments.cells * arguments.cells,
        sizeof(btScalar) == 4 ? "single" : "double");
    const Table table(
        "floor:<6|cloths:>6|m/s=speed:>4|1/s=rate:>4|stock through=stock:>13|"
        "through:>7|crossing:>8|stock ms=other:>8.2f|rest ms=rest:>8.2f|"
        "check ms=check:>8.2f|worst ms=worst:>8.1f|ratio:>6.2f");
    const std::vector<double> speeds =
        arguments.quick ? std::vector<double>{20.0} : std::vector<double>{1.0, 5.0, 20.0, 50.0};
    const std::vector<double> rates =
        arguments.quick ? std::vector<double>{60.0} : std::vector<double>{30.0, 60.0, 120.0, 240.0};
    int wrong = 0;
    int runs = 0;
    for (const std::string& floor : arguments.floors)
    {
        double check = 0.0;
        double rest = 0.0;
        for (const int cloths : {1, 2})
        {
            for (const double speed : speeds)
            {
                for (const double rate : rates)
                {
                    const Outcome stock =
                        drop(SoftWorld::Stock, arguments, floor, speed, rate, cloths);
                    const Outcome ours =
                        drop(SoftWorld::Solver, arguments, floor, speed, rate, cloths);
                    const double others = ours.seconds - ours.checkSeconds;
                    const double scale = 1e3 / ours.steps;
                    table.print({{"floor", floor},
                                 {"cloths", cloths},
                                 {"speed", int(speed)},
                                 {"rate", int(rate)},
                                 {"stock", stock.verdict.through},
                                 {"through", ours.verdict.through},
                                 {"crossing", ours.verdict.crossing},
                                 {"other", scale * stock.seconds},
                                 {"rest", scale * others},
                                 {"check", scale * ours.checkSeconds},
                                 {"worst", 1e3 * ours.worst},
                                 {"ratio", ours.checkSeconds / others}});
                    check += ours.checkSeconds;
                    rest += others;
                    ++runs;
                    wrong += ours.verdict.isClean() ? 0 : 1;
                }
            }
        }
        fmt::print("{}: all checks / all the rest of the steps = {:.2f}\n", floor, check / rest);
    }
    fmt::print("{} of {} drops with something through, crossing or not finite\n", wrong, runs);
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
                     {"--floors", &arguments.floors, "box, plate, ball, torus, cup, figure"},
                     {"--quick", &arguments.quick, "one speed and one rate"}},
         .run = [&] { return run(arguments); }});
}
