#include "benchmarks/bullet/bench_bullet_worlds.h"

#include "benchmarks/reference/bullet/pile.h"
#include "benchmarks/support/timing.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace bullet_ccd::benchmarks
{
namespace
{
using reference::Kind;
using reference::Scene;
using reference::WorldClass;

constexpr double kTimeStep = 1.0 / 240.0;

struct Run
{
    std::unique_ptr<Scene> scene;
    std::vector<double> times;
};

/// Four layers, whatever the number.
double binHalf(int bodies)
{
    return 0.01 + 0.5 * reference::kPileSpacing * std::max(2.0, std::ceil(std::sqrt(bodies / 4.0)));
}

void shoot(Scene& scene, int bodies)
{
    btCollisionShape* bullet = scene.box(reference::vec(0.005, 0.005, 0.005));
    const int count = std::max(1, bodies / 50);
    for (int i = 0; i < count; ++i)
    {
        const double place = count > 1 ? 1.6 * (double(i) / (count - 1) - 0.5) : 0.0;
        btRigidBody* body = scene.body(
            bullet, 0.01, reference::poseAt(reference::vec(place * binHalf(bodies), 0.0, 1.0)));
        body->setLinearVelocity(reference::vec(0, 0, -20));
    }
}

int outside(Scene& scene, double half)
{
    int count = 0;
    const btCollisionObjectArray& objects = scene.world().getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        const btVector3& p = objects[i]->getWorldTransform().getOrigin();
        const bool inside = p.z() > btScalar(0) && std::abs(p.x()) < half && std::abs(p.y()) < half;
        count += !objects[i]->isStaticObject() && !inside ? 1 : 0;
    }
    return count;
}
}  // namespace

std::vector<nlohmann::json> runWorlds(int bodies, int steps)
{
    std::vector<Run> runs;
    for (const Kind kind : reference::kAllKinds)
    {
        auto scene = std::make_unique<Scene>(kind, WorldClass::Rigid);
        reference::addPile(
            *scene, bodies, binHalf(bodies), 11, {.meshes = false, .wallHeight = 1.0});
        shoot(*scene, bodies);
        runs.push_back({std::move(scene), {}});
    }
    for (int step = 0; step < steps; ++step)
    {
        for (Run& run : runs)
        {
            run.times.push_back(microsecondsOf([&] { run.scene->step(kTimeStep); }));
        }
    }
    std::vector<nlohmann::json> rows;
    for (std::size_t i = 0; i < runs.size(); ++i)
    {
        const Run& run = runs[i];
        const btCcdCounters counters = run.scene->counters();
        rows.push_back({{"bodies", bodies},
                        {"world", reference::nameOf(reference::kAllKinds[i])},
                        {"median", medianOf(run.times)},
                        {"mean", meanOf(run.times)},
                        {"outside", outside(*run.scene, binHalf(bodies))},
                        {"queries", double(counters.m_queries) / steps},
                        {"impacts", double(counters.m_impacts) / steps}});
    }
    return rows;
}
}  // namespace bullet_ccd::benchmarks
