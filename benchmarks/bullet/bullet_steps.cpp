/// What single steps of worlds with many bodies cost and hold: stock Bullet, the action, our world.
#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace
{
using namespace bullet_ccd::reference;
using namespace bullet_ccd::benchmarks;

constexpr double kTimeStep = 1.0 / 60.0;
/// What a step may cost: without impacts relative to stock, with impacts relative to stock or to
/// the median of the same world, whichever is larger.
constexpr double kMostQuiet = 1.15;
constexpr double kMostBusy = 5.0;
constexpr double kMostMedians = 3.0;
constexpr double kMostMemory = 2.0;  ///< held, relative to stock
/// Milliseconds of the first step, in which shapes are converted, or relative to making the world.
constexpr double kMostFirst = 500.0;
constexpr double kMostMade = 3.0;
constexpr double kTooShort = 0.1;  ///< to be compared, as the median of a world [ms]
constexpr std::array kKinds{Kind::Stock, Kind::Action, Kind::World};

struct StepScene
{
    std::string name;
    int steps;
    std::function<void(Scene&)> fill;
};

struct Cost
{
    std::vector<double> times;  ///< of the steps, the least of all runs [us]
    std::vector<double> stock;  ///< of stock Bullet's, each from where ours began
    std::vector<std::int64_t> impacts;
    double memory = 0.0;  ///< most that was held after a step [MB]
    double made = std::numeric_limits<double>::infinity();  ///< what making the world took [us]
};

btRigidBody* addCube(Scene& scene, btCollisionShape* cube, double x, double y, double z)
{
    return scene.body(cube, 1.0, poseAt(vec(x, y, z)));
}

void addGround(Scene& scene)
{
    scene.body(scene.box(vec(200, 1, 200)), 0.0, poseAt(vec(0, -1, 0)));
}

/// Cubes on a cubic grid.
template <typename Velocity>
void addGrid(Scene& scene, int count, double spacing, double height, const Velocity& velocityOf)
{
    btCollisionShape* cube = scene.box(vec(0.5, 0.5, 0.5));
    const int side = int(std::ceil(std::cbrt(count)));
    for (int i = 0; i < count; ++i)
    {
        const double up = height + spacing * (i / side % side);
        addCube(scene, cube, spacing * (i % side), up, spacing * (i / side / side))
            ->setLinearVelocity(velocityOf(i));
    }
}

void addFall(Scene& scene, int count)
{
    scene.world().setGravity(vec(0, -10, 0));
    addGrid(scene, count, 1.5, 0.0, [](int) { return vec(0, 0, 0); });
}

/// In all directions, at up to 50 m/s, without gravity.
void addFlock(Scene& scene, int count)
{
    const auto velocityOf = [](int i)
    { return vec(3 * (i * 37 % 19 - 9), 2 * (i * 53 % 17), 3 * (i * 71 % 23 - 11)); };
    addGround(scene);
    addGrid(scene, count, 4.0, 2.0, velocityOf);
}

void addPileOf(Scene& scene, int count)
{
    scene.world().setGravity(vec(0, -10, 0));
    addGround(scene);
    addGrid(scene, count, 1.15, 1.0, [](int) { return vec(0, -5, 0); });
}

/// The same of cylinders and cones, tilted.
void addRoundPile(Scene& scene, int count)
{
    addPileOf(scene, count);
    btCollisionShape* drum = scene.keep(std::make_unique<btCylinderShape>(vec(0.5, 0.25, 0.5)));
    btCollisionShape* cone = scene.keep(std::make_unique<btConeShape>(btScalar(0.5), btScalar(1)));
    for (int i = 0; i < count; ++i)
    {
        btCollisionObject* body = scene.world().getCollisionObjectArray()[i + 1];
        body->setCollisionShape(i % 2 == 0 ? drum : cone);
        body->getWorldTransform().setRotation({vec(1, i % 3, i % 5).normalized(), btScalar(i)});
    }
}

/// Cubes that stand on the ground side by side, awake.
void addStanding(Scene& scene, int count)
{
    scene.world().setGravity(vec(0, -10, 0));
    addGround(scene);
    btCollisionShape* cube = scene.box(vec(0.5, 0.5, 0.5));
    for (int i = 0; i < count; ++i)
    {
        addCube(scene, cube, 1.5 * (i % 100) - 75.0, 0.5, 1.5 * (i / 100) - 75.0)
            ->setActivationState(DISABLE_DEACTIVATION);
    }
}

/// A heavy ball at 300 m/s into a wall of cubes.
void addWall(Scene& scene, int count)
{
    scene.world().setGravity(vec(0, -10, 0));
    addGround(scene);
    btCollisionShape* cube = scene.box(vec(0.5, 0.5, 0.5));
    const int width = int(std::sqrt(count));
    for (int i = 0; i < count; ++i)
    {
        addCube(scene, cube, 1.01 * (i % width) - 0.5 * width, 0.5 + i / width, 0.0);
    }
    btRigidBody* ball = scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(1))),
                                   50.0,
                                   poseAt(vec(0, width / 3.0, 60)));
    ball->setLinearVelocity(vec(0, 0, -300));
}

double hillAt(int x, int y)
{
    return 5.0 * std::sin(0.05 * x) * std::cos(0.03 * y);
}

/// A fast cube above a height field, and above a static mesh of stock Bullet.
void addHills(Scene& scene, btCollisionShape* hills)
{
    scene.world().setGravity(vec(0, 0, -10));
    scene.body(hills, 0.0, poseAt(vec(0, 0, 0)));
    addCube(scene, scene.box(vec(0.1, 0.1, 0.1)), 0.3, 0.2, 30)->setLinearVelocity(vec(0, 0, -100));
}

void addField(Scene& scene, int side)
{
    addHills(scene, scene.heightField(side, hillAt));
}

void addTerrain(Scene& scene, int side)
{
    addHills(scene, scene.staticMesh(gridMesh(side, 1.0, hillAt)));
}

std::vector<StepScene> stepScenes()
{
    const auto scene = [](const char* name, int count, int steps, void (*fill)(Scene&, int)) {
        return StepScene{
            fmt::format("{} {}", name, count), steps, [=](Scene& s) { fill(s, count); }};
    };
    return {scene("free fall", 3000, 90, addFall),
            scene("free fall", 10000, 60, addFall),
            scene("flying", 1000, 60, addFlock),
            scene("flying", 3000, 30, addFlock),
            scene("pile", 1000, 120, addPileOf),
            scene("round pile", 800, 90, addRoundPile),
            scene("standing", 3000, 30, addStanding),
            scene("wall hit", 400, 60, addWall),
            scene("wall hit", 1000, 60, addWall),
            scene("height field", 1024, 30, addField),
            scene("terrain", 708, 30, addTerrain)};
}

/// Puts everything where it is in the other world: the next step is the same one.
void copyState(Scene& from, Scene& to)
{
    for (int i = 0; i < from.world().getNumCollisionObjects(); ++i)
    {
        const auto& a = *btRigidBody::upcast(from.world().getCollisionObjectArray()[i]);
        auto& b = *btRigidBody::upcast(to.world().getCollisionObjectArray()[i]);
        if (!a.isStaticObject())
        {
            b.setCenterOfMassTransform(a.getCenterOfMassTransform());
            b.setLinearVelocity(a.getLinearVelocity());
            b.setAngularVelocity(a.getAngularVelocity());
            b.forceActivationState(a.getActivationState());
            b.setDeactivationTime(a.getDeactivationTime());
        }
    }
}

void runOnce(const StepScene& scene, Kind kind, Cost& cost)
{
    Scene twin(Kind::Stock, WorldClass::Rigid);
    scene.fill(twin);
    double held = -heldMegabytes();
    Scene world(kind, WorldClass::Rigid);
    cost.made = std::min(cost.made, microsecondsOf([&] { scene.fill(world); }));
    world.addHooks();
    held += heldMegabytes();
    std::int64_t impacts = 0;
    cost.times.resize(std::size_t(scene.steps), std::numeric_limits<double>::infinity());
    cost.stock.resize(cost.times.size(), std::numeric_limits<double>::infinity());
    cost.impacts.resize(cost.times.size());
    for (std::size_t i = 0; i < cost.times.size(); ++i)
    {
        copyState(world, twin);
        cost.stock[i] = std::min(cost.stock[i], microsecondsOf([&] { twin.step(kTimeStep); }));
        held -= heldMegabytes();
        cost.times[i] = std::min(cost.times[i], microsecondsOf([&] { world.step(kTimeStep); }));
        held += heldMegabytes();
        cost.impacts[i] = world.counters().m_impacts - impacts;
        impacts = world.counters().m_impacts;
        cost.memory = std::max(cost.memory, held);
    }
}

/// Without the first step, in which shapes are converted.
nlohmann::json rowOf(const std::string& name, Kind kind, const Cost& ours, const Cost& stock)
{
    double quiet = 0.0;
    double busy = 0.0;
    double allowed = 0.0;
    const double median = medianOf(ours.times);
    for (std::size_t i = 1; i < ours.times.size(); ++i)
    {
        if (ours.impacts[i] == 0)
        {
            quiet = std::max(quiet, ours.times[i] / ours.stock[i]);
            continue;
        }
        busy = std::max(busy, ours.times[i] / ours.stock[i]);
        allowed = std::max(
            allowed, ours.times[i] / std::max(kMostBusy * ours.stock[i], kMostMedians * median));
    }
    const auto total = [](const std::vector<double>& times) {
        return sumOf({times.data() + 1, times.size() - 1});
    };
    return {{"name", name},
            {"world", nameOf(kind)},
            {"median", median / 1e3},
            {"worst", *std::ranges::max_element(ours.times) / 1e3},
            {"first", ours.times.front() / 1e3},
            {"made", ours.made / 1e3},
            {"held", ours.memory / stock.memory},
            {"memory", ours.memory},
            {"all", total(ours.times) / total(ours.stock)},
            {"quiet", quiet},
            {"busy", busy},
            {"allowed", allowed}};
}

bool isWithin(const nlohmann::json& row)
{
    const auto value = [&](const char* key) { return row[key].get<double>(); };
    const bool isShort = value("median") < kTooShort;
    return (isShort || (value("quiet") <= kMostQuiet && value("allowed") <= 1.0)) &&
           value("held") <= kMostMemory &&
           value("first") <= std::max(kMostFirst, kMostMade * value("made"));
}

bool run(int runs, const std::string& part)
{
    const Table table(
        "scene=name:<16|world:<24|median ms=median:>9.2f|worst ms=worst:>9.2f|"
        "first ms=first:>9.2f|made ms=made:>8.1f|MB=memory:>7.1f|all=all:>6.2f|"
        "without impacts=quiet:>15.2f|with=busy:>7.2f|of allowed=allowed:>10.2f");
    bool good = true;
    for (const StepScene& scene : only(stepScenes(), part))
    {
        std::array<Cost, kKinds.size()> costs;
        for (int i = 0; i < runs; ++i)
        {
            for (std::size_t k = 0; k < kKinds.size(); ++k)
            {
                runOnce(scene, kKinds[k], costs[k]);
            }
        }
        for (std::size_t k = 0; k < kKinds.size(); ++k)
        {
            const nlohmann::json row = rowOf(scene.name, kKinds[k], costs[k], costs[0]);
            table.print(row);
            good = good && (k == 0 || isWithin(row));
        }
    }
    return good;
}
}  // namespace

int main(int argc, char** argv)
{
    int runs = 5;
    std::string part;
    return runProgram(
        argc,
        argv,
        {.name = "bullet_steps",
         .about = "What single steps cost in worlds with many bodies, and what these hold, beside "
                  "stock Bullet. benchmarks/bullet/README.md says what the columns are and when "
                  "the exit code is not 0.",
         .options = {{"--runs", &runs, "runs of every scene and world"},
                     {"--only", &part, "scenes whose name contains this", 0}},
         .run = [&] { return run(runs, part); }});
}
