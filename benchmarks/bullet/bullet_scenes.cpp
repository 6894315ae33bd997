/// Ordinary and less ordinary days of programs that use Bullet: what goes wrong in a stock world,
/// with the action, and in our world, and what it costs.
#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>

#include <algorithm>
#include <functional>
#include <malloc.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace
{
using namespace bullet_ccd::reference;
using bullet_ccd::benchmarks::medianOf;
using bullet_ccd::benchmarks::microsecondsOf;
using bullet_ccd::benchmarks::Table;

constexpr double kStep = 1.0 / 60.0;
using Bodies = std::vector<btRigidBody*>;

/// A scene under way.
struct Day
{
    std::function<void(int)> before = [](int) {};  ///< a step
    std::function<int()> wrong;                    ///< at the end; 0 is right
};
struct DayScene
{
    std::string name;
    std::string wrong;  ///< what is counted
    int steps;
    std::function<Day(Scene&, bool ours)> begin;
};

btVector3 at(const btRigidBody& body)
{
    return body.getWorldTransform().getOrigin();
}
double heightOf(const btRigidBody& body)
{
    return double(at(body).z());
}
double speedOf(const btRigidBody& body)
{
    return double(body.getLinearVelocity().length());
}
btVector3 cubic(double half)
{
    return vec(half, half, half);
}
/// Stock Bullet has no meshes that move.
btCollisionShape* solid(Scene& scene, const btVector3& half, bool mesh)
{
    return mesh ? static_cast<btCollisionShape*>(scene.boxMesh(half)) : scene.box(half);
}
btCollisionShape* ball(Scene& scene, double radius)
{
    return scene.keep(std::make_unique<btSphereShape>(btScalar(radius)));
}
btRigidBody* put(Scene& scene,
                 btCollisionShape* shape,
                 double mass,
                 const btVector3& place,
                 const btVector3& velocity = {0, 0, 0})
{
    btRigidBody* body = scene.body(shape, mass, poseAt(place));
    body->setLinearVelocity(velocity);
    return body;
}
btRigidBody* mover(Scene& scene, btCollisionShape* shape, const btVector3& place)
{
    btRigidBody* body = put(scene, shape, 0.0, place);
    body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
}
void fall(Scene& scene)
{
    scene.world().setGravity(vec(0, 0, -10));
}
btRigidBody* floorOf(Scene& scene, double thickness, bool mesh = false)
{
    fall(scene);
    return put(scene, solid(scene, vec(20, 20, thickness / 2), mesh), 0, vec(0, 0, -thickness / 2));
}
std::function<int()> count(const Bodies& bodies, const std::function<bool(btRigidBody&)>& wrong)
{
    return [bodies, wrong]
    { return int(std::ranges::count_if(bodies, [&](btRigidBody* body) { return wrong(*body); })); };
}
bool isBelow(btRigidBody& body)
{
    return !(heightOf(body) > -0.05) || !(at(body).length() < btScalar(1e4));
}
Day pile(Scene& scene, bool ours, bool meshes, bool meshFloor)
{
    floorOf(scene, 0.01, ours && meshFloor);
    Bodies bodies;
    for (int i = 0; i < 40; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.1), ours && meshes && i % 2 == 0);
        const btVector3 place = vec(0.22 * (i % 3), 0.22 * (i / 3 % 3), 0.2 + 0.25 * (i / 9));
        bodies.push_back(put(scene, cube, 1, place, vec(0, 0, -10)));
    }
    return {.wrong = count(bodies, isBelow)};
}

/// Cubes above each other; the upper ones are faster.
Day column(Scene& scene, bool ours, int cubes, double speed)
{
    floorOf(scene, 0.1);
    btCollisionShape* cube = solid(scene, cubic(0.1), ours);
    Bodies bodies;
    for (int i = 0; i < cubes; ++i)
    {
        const btVector3 place = vec(0.5 * (i % std::max(cubes / 5, 1)), 0, 3 + 0.3 * i);
        bodies.push_back(put(scene, cube, 1, place, vec(0, 0, -speed * i)));
    }
    return {.wrong = count(bodies, [](btRigidBody& b) { return isBelow(b) || speedOf(b) > 1; })};
}

Day lift(Scene& scene, bool ours, bool mesh, double speed, double ceiling)
{
    fall(scene);
    btRigidBody* deck = mover(scene, scene.box(vec(2, 2, 0.1)), vec(0, 0, -0.1));
    put(scene, scene.box(vec(2, 2, 0.1)), 0, vec(0, 0, ceiling + 0.1));
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.2), ours && mesh);
        bodies.push_back(put(scene, cube, 1, vec(-1 + 0.5 * i, 0, 0.201)));
    }
    const auto before = [=](int step)
    {
        const double height = std::min(ceiling - 0.05, speed * kStep * step);
        deck->setWorldTransform(poseAt(vec(0, 0, height - 0.1)));
    };
    const auto isOut = [=](btRigidBody& body)
    { return heightOf(body) < heightOf(*deck) || heightOf(body) > ceiling + 0.2; };
    return {before, count(bodies, isOut)};
}

Day bat(Scene& scene, bool ours, double rate, bool setsInterpolation)
{
    btRigidBody* blade = mover(scene, solid(scene, vec(1, 0.01, 0.2), ours), vec(0, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
    {
        const btVector3 place = poseAt(vec(0, 0, 0), 0.5 + 0.3 * i) * vec(0.8, 0, 0);
        bodies.push_back(put(scene, ball(scene, 0.05), 1, place));
    }
    const auto before = [=](int step)
    {
        blade->setWorldTransform(poseAt(vec(0, 0, 0), rate * kStep * step));
        if (setsInterpolation)
        {
            blade->setInterpolationWorldTransform(blade->getWorldTransform());
        }
    };
    return {before, count(bodies, [](btRigidBody& b) { return speedOf(b) < 0.1; })};
}

Day press(Scene& scene, bool ours)
{
    put(scene, scene.box(vec(2, 2, 0.1)), 0, vec(0, 0, -0.1));
    btRigidBody* plate = mover(scene, solid(scene, vec(2, 2, 0.1), ours), vec(0, 0, 1));
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        bodies.push_back(put(scene, solid(scene, cubic(0.1), ours), 1, vec(0.4 * i - 1, 0, 0.11)));
    }
    const auto before = [=](int step)
    { plate->setWorldTransform(poseAt(vec(0, 0, std::max(0.32, 1 - 0.05 * step)))); };
    return {before, count(bodies, [](btRigidBody& b) { return isBelow(b) || heightOf(b) > 0.4; })};
}

Day rattle(Scene& scene, bool /*ours*/)
{
    btRigidBody* block = put(scene, scene.box(cubic(0.2)), 1, vec(1, 0, 0), vec(2, 0, 0));
    block->setActivationState(DISABLE_DEACTIVATION);
    put(scene, scene.box(vec(0.1, 1, 1)), 0, vec(6, 0, 0))->setRestitution(1);
    put(scene, ball(scene, 0.02), 1e-4, vec(3, 0, 0), vec(60, 0, 0))->setRestitution(1);
    return {.wrong = count({block}, [](btRigidBody& b) { return speedOf(b) < 1.5; })};
}

/// A rod that is shot at a wall of 1 mm far from the origin, turning.
Day shotFarAway(Scene& scene, bool /*ours*/)
{
    constexpr double kFar = 1e3;
    put(scene, scene.box(vec(0.0005, 2, 2)), 0, vec(kFar + 1, 0, 0));
    btCollisionShape* rod = scene.box(vec(0.3, 0.005, 0.005));
    btRigidBody* body = put(scene, rod, 1, vec(kFar, 0, 0), vec(80, 3, 1));
    body->setAngularVelocity(vec(5, 9, 40));
    return {.wrong = count({body}, [](btRigidBody& b) { return at(b).x() > btScalar(kFar + 1); })};
}

Day ragdoll(Scene& scene, bool /*ours*/, bool collide)
{
    put(scene, scene.box(vec(0.005, 3, 3)), 0, vec(2, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 6; ++i)
    {
        auto limb = std::make_unique<btCapsuleShape>(btScalar(0.05), btScalar(0.3));
        const btVector3 place = vec(0, 0.2 * i, 0.45 * i);
        bodies.push_back(put(scene, scene.keep(std::move(limb)), 1, place, vec(90, 0, 0)));
        if (i > 0)
        {
            btRigidBody& former = *bodies[std::size_t(i) - 1];
            scene.addConstraint(std::make_unique<btPoint2PointConstraint>(
                                    former, *bodies.back(), vec(0, 0.1, 0.22), vec(0, -0.1, -0.22)),
                                collide);
        }
    }
    return {.wrong = count(bodies, [](btRigidBody& b) { return at(b).x() > btScalar(2); })};
}

template <typename Make, typename... Settings>
std::function<Day(Scene&, bool)> with(Make make, Settings... settings)
{
    return [=](Scene& scene, bool ours) { return make(scene, ours, settings...); };
}

std::vector<DayScene> dayScenes()
{
    return {
        {"boxes on a thin box", "through", 180, with(pile, false, false)},
        {"boxes on a thin mesh", "through", 180, with(pile, false, true)},
        {"boxes and meshes on it", "through", 180, with(pile, true, true)},
        {"column of four", "lost", 300, with(column, 4, 5)},
        {"forty, to 195 m/s", "lost", 300, with(column, 40, 5)},
        {"forty, to 780 m/s", "lost", 300, with(column, 40, 20)},
        {"lift with boxes", "lost", 200, with(lift, false, 1, 9)},
        {"lift with meshes", "lost", 200, with(lift, true, 1, 9)},
        {"lift into a ceiling", "outside", 240, with(lift, false, 3, 2.9)},
        {"bat at 5 rad/s", "missed", 60, with(bat, 5, false)},
        {"bat at 50 rad/s", "missed", 12, with(bat, 50, false)},
        {"bat that sets all", "missed", 12, with(bat, 50, true)},
        {"press", "lost", 90, with(press)},
        {"rattle", "stopped", 60, with(rattle)},
        {"1 km from the origin", "through", 10, with(shotFarAway)},
        {"joined capsules", "through", 60, with(ragdoll, false)},
        {"the same, colliding", "through", 60, with(ragdoll, true)},
    };
}

nlohmann::json rowOf(const DayScene& scene, Kind kind)
{
    Scene world(kind, WorldClass::Rigid);
    const Day day = scene.begin(world, isOurs(kind));
    world.addHooks();
    std::vector<double> times;
    for (int i = 0; i < scene.steps; ++i)
    {
        day.before(i);
        times.push_back(microsecondsOf([&] { world.step(kStep); }));
    }
    const struct mallinfo2 memory = mallinfo2();
    return {{"name", scene.name},
            {"world", codeOf(kind)},
            {"what", scene.wrong},
            {"wrong", day.wrong()},
            {"median", medianOf(times) / 1e3},
            {"worst", *std::ranges::max_element(times) / 1e3},
            {"lost", world.counters().m_lostTime},
            {"memory", 1e-6 * double(memory.uordblks + memory.hblkhd)}};
}

bool run(const std::string& part)
{
    const Table table(
        "scene=name:<24|world:<8|what is counted=what:<16|count=wrong:>6|median ms=median:>9.2f|"
        "worst ms=worst:>9.2f|lost s=lost:>8.3f|MB=memory:>7.1f");
    bool good = true;
    for (const DayScene& scene : bullet_ccd::benchmarks::only(dayScenes(), part))
    {
        int stock = 0;
        for (const Kind kind : {Kind::Stock, Kind::Action, Kind::World})
        {
            const nlohmann::json row = rowOf(scene, kind);
            table.print(row);
            const int wrong = row["wrong"].get<int>();
            stock = isOurs(kind) ? stock : wrong;
            good = good &&
                   (!isOurs(kind) || wrong == 0 || (scene.wrong != "through" && wrong <= stock));
        }
    }
    return good;
}
}  // namespace

int main(int argc, char** argv)
{
    std::string part;
    return bullet_ccd::benchmarks::runProgram(
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
