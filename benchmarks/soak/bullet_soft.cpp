#include "benchmarks/reference/bullet/soft_scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/soak/bullet_soaks.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <fmt/format.h>
#include <string>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using Eigen::Isometry3d;
using Eigen::Vector3d;

/// In the order of the seeds.
enum class Floor : std::uint8_t
{
    Box,
    Ball,
    Mesh,
    Torus,
    Plane,
};
const std::vector<std::string> kFloors{"box", "ball", "mesh", "torus", "plane"};

TriangleMesh floorSquare(double half)
{
    return {.vertices = {{-half, 0, -half}, {half, 0, -half}, {-half, 0, half}, {half, 0, half}},
            .triangles = {{0, 2, 1}, {1, 2, 3}}};
}

void addFloor(SoftScene& scene, Floor floor, Random& random)
{
    Isometry3d X = Isometry3d::Identity();
    if (floor != Floor::Plane)
    {
        X.linear() =
            Eigen::AngleAxisd(random.uniform(-0.3, 0.3), random.direction()).toRotationMatrix();
    }
    const double size = random.uniform(0.2, 0.4);
    switch (floor)
    {
        case Floor::Box:
        {
            const double thin = random.logUniform(0.002, 0.05);
            scene.obstacle(
                std::make_unique<btBoxShape>(btVector3(1, btScalar(thin), 1)), floorSquare(1.0), X);
            break;
        }
        case Floor::Ball:
            scene.obstacle(std::make_unique<btSphereShape>(btScalar(size)), makeSphere(size, 2), X);
            break;
        case Floor::Mesh:
            scene.obstacle(btCcdMeshShape::fromMesh(floorSquare(1.0)), floorSquare(1.0), X);
            break;
        case Floor::Torus:
        {
            const TriangleMesh torus = makeTorus(size, 0.3 * size, 16, 8);
            scene.obstacle(btCcdMeshShape::fromMesh(torus), torus, X);
            break;
        }
        case Floor::Plane:
            scene.obstacle(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)),
                           floorSquare(50.0));
    }
}

/// The drop of a seed. Soft bodies start above each other, the upper ones as fast as they like.
double makeDrop(SoftScene& scene, std::uint64_t seed)
{
    Random random(seed * 7919);
    addFloor(scene, Floor(seed % kFloors.size()), random);
    double height = 0.5;
    const int bodies = random.integer(1, 3);
    for (int i = 0; i < bodies; ++i)
    {
        Isometry3d X = Isometry3d::Identity();
        X.linear() =
            Eigen::AngleAxisd(random.uniform(-0.2, 0.2), random.direction()).toRotationMatrix();
        X.translation() = Vector3d(random.uniform(-0.1, 0.1), height, random.uniform(-0.1, 0.1));
        height += 0.35;
        const int kind = i == 0 ? 0 : random.integer(0, 3);
        btSoftBody* body = nullptr;
        if (kind == 2)
        {
            body = scene.rope(X, 1.0, random.integer(5, 25), random.logUniform(0.1, 2.0));
        }
        else if (kind == 3)
        {
            body = scene.block(
                X, random.uniform(0.1, 0.25), random.integer(1, 4), random.logUniform(0.2, 4.0));
        }
        else
        {
            body = scene.cloth(
                X, random.uniform(0.5, 1.2), random.integer(3, 16), random.logUniform(0.2, 5.0));
        }
        body->m_cfg.kDF = btScalar(random.uniform(0.0, 0.8));
        body->setVelocity(btVector3(btScalar(random.uniform(-3.0, 3.0)),
                                    btScalar(-random.uniform(0.0, 50.0)),
                                    btScalar(random.uniform(-3.0, 3.0))));
    }
    if (random.chance(0.3))
    {
        Isometry3d X = Isometry3d::Identity();
        X.translation() = Vector3d(0.0, height, 0.0);
        scene
            .obstacle(std::make_unique<btSphereShape>(btScalar(0.1)),
                      makeSphere(0.1, 2),
                      X,
                      random.logUniform(0.1, 5.0))
            ->setLinearVelocity(btVector3(0, btScalar(-random.uniform(0.0, 20.0)), 0));
    }
    const double rates[] = {30.0, 60.0, 120.0, 240.0};
    return 1.0 / rates[random.integer(0, 3)];
}

SoakAnswer drop(const SoftSoak& soak, std::uint64_t seed)
{
    const auto run = [&](SoftScene& scene)
    {
        const double timeStep = makeDrop(scene, seed);
        const int steps = int(soak.seconds / timeStep + 0.5);
        for (int i = 0; i < steps; ++i)
        {
            scene.step(timeStep);
        }
        return steps;
    };
    SoftScene scene(seed % 2 == 0 ? SoftWorld::Solver : SoftWorld::World);
    const int steps = run(scene);
    const SoftVerdict verdict = scene.judge();
    const btCcdSoftCounters& counters = scene.solver()->getCcdSoftCounters();
    SoakAnswer answer{.family = std::size_t(seed % kFloors.size()),
                      .status = counters.m_contacts > 0 ? ToiStatus::Hit : ToiStatus::Separated};
    if (!verdict.isClean())
    {
        answer.judgement = {.verdict = Verdict::Missed,
                            .pair = fmt::format("{} nodes went through, {} edges cross faces, {} "
                                                "nodes are not finite",
                                                verdict.through,
                                                verdict.crossing,
                                                verdict.notFinite)};
    }
    answer.counts = {{"steps", steps},
                     {"contacts", counters.m_contacts},
                     {"rounds", counters.m_rounds},
                     {"paths shortened", counters.m_held},
                     {"rigid bodies held", counters.m_heldBodies},
                     {"touching at the start", counters.m_overlaps},
                     {"squeezed", counters.m_squeezed},
                     {"steps not checked", counters.m_unchecked}};
    if (soak.withStock)
    {
        SoftScene stock(SoftWorld::Stock);
        run(stock);
        answer.counts["processor time [us]"] = std::int64_t(1e6 * scene.seconds());
        answer.counts["processor time of stock Bullet [us]"] = std::int64_t(1e6 * stock.seconds());
        const SoftVerdict through = stock.judge();
        answer.counts["nodes through in stock Bullet"] = through.through;
        answer.counts["drops that stock Bullet spoils"] = through.isClean() ? 0 : 1;
    }
    return answer;
}
}  // namespace

SoakSubject softSoak(const SoftSoak& soak)
{
    return {.program = fmt::format("benchmarks/run soak bullet soft --seconds {}", soak.seconds),
            .families = kFloors,
            .round = kFloors.size(),
            .shares = {.leastHits = 50, .leastFree = 0, .enough = 5},
            .ask = [soak](std::uint64_t seed) { return drop(soak, seed); }};
}
}  // namespace bullet_ccd::benchmarks
