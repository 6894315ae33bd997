#include "benchmarks/reference/audit/world_audit.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/soak/bullet_soaks.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdReducedMesh.h"
#include "bullet_ccd/examples/example_support.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "robots/shapes/household_objects.h"
#include "tools/support/progress_line.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using examples::World;

constexpr double kWall = 0.02;      // thickness [m]
constexpr double kDensity = 800.0;  // [kg/m^3]
constexpr double kBetween = 0.005;  // bounding balls at the start [m]

// Inner half lengths of the bin for twenty objects [m]; its area grows with their number.
const Eigen::Vector2d kHalfInnerForTwenty(0.25, 0.2);

/// A shape, and what is to be known of it.
struct HouseholdObject
{
    std::string name;
    std::shared_ptr<const AuditMesh> audit;
    std::shared_ptr<const SsvTree> tree;
    std::optional<btCcdReducedMesh> reduced = std::nullopt;  ///< in place of the tree
    double mass = 0.0;                                       ///< [kg]
    double reach = 0.0;  ///< from the centre of mass, the origin [m]
};

/// Number 0 and on: all families in turn, first in their usual sizes, then in sizes by the seed.
HouseholdObject makeHouseholdObject(std::size_t number, std::uint64_t seed, double accuracy)
{
    const std::vector<std::string>& families = shapes::objectFamilies();
    HouseholdObject object;
    object.name = families[number % families.size()];
    TriangleMesh mesh = shapes::makeObject(
        object.name, number < families.size() ? std::nullopt : std::optional(seed), 2.0);
    static_cast<void>(examples::putIntoPrincipalAxes(mesh));
    object.mass = kDensity * massProperties(mesh).volume;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        object.reach = std::max(object.reach, vertex.norm());
    }
    if (accuracy > 0.0)
    {
        object.reduced.emplace(mesh, accuracy);
    }
    object.audit = std::make_shared<const AuditMesh>(mesh);
    object.tree = std::make_shared<const SsvTree>(buildSsvTree(std::move(mesh)));
    return object;
}

struct Ball
{
    Eigen::Vector3d center;
    double radius;
};

/// The lowest of some random places in the column above the floor where the ball is clear of all
/// others.
Eigen::Vector3d findPlace(const std::vector<Ball>& taken,
                          double radius,
                          const Eigen::Vector2d& halfInner,
                          Random& random)
{
    const double freeX = std::max(0.0, halfInner.x() - radius - kBetween);
    const double freeY = std::max(0.0, halfInner.y() - radius - kBetween);
    for (double z = radius + kBetween;; z += 0.01)
    {
        for (int attempt = 0; attempt < 20; ++attempt)
        {
            const double x = random.uniform(-freeX, freeX);
            const double y = random.uniform(-freeY, freeY);
            const Eigen::Vector3d place(x, y, z);
            if (std::ranges::all_of(
                    taken,
                    [&](const Ball& ball)
                    { return (ball.center - place).norm() > ball.radius + radius + kBetween; }))
            {
                return place;
            }
        }
    }
}

class HouseholdBin
{
public:
    /// Adds the objects, in a column clear of each other, and a bin whose walls are as high as the
    /// column: all families in turn, at most kSizes sizes of each, 500 to 5000 triangles an object.
    /// Making them takes half a second a kind.
    HouseholdBin(World& world, WorldAudit& audit, const BinSoak& soak, std::uint64_t seed)
        : m_halfInner(std::sqrt(std::max(1.0, soak.objects / 20.0)) * kHalfInnerForTwenty)
    {
        const std::size_t kinds = std::min(std::size_t(soak.objects),
                                           std::size_t(kSizes) * shapes::objectFamilies().size());
        for (std::size_t i = 0; i < kinds; ++i)
        {
            m_kinds.push_back(makeHouseholdObject(i, seed * 1000 + i, soak.accuracy));
        }
        Random random(seed);
        std::vector<Ball> taken;
        for (int i = 0; i < soak.objects; ++i)
        {
            const HouseholdObject& kind = m_kinds[std::size_t(i) % kinds];
            taken.push_back({findPlace(taken, kind.reach, m_halfInner, random), kind.reach});
            Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
            X.linear() = random.rotation();
            X.translation() = taken.back().center;
            btRigidBody* body =
                world.add(kind.reduced ? kind.reduced->makeShape()
                                       : std::make_unique<btCcdMeshShape>(kind.tree),
                          kind.mass,
                          btCcdToBullet(X));
            body->setRollingFriction(btScalar(0.002));
            body->setSpinningFriction(btScalar(0.002));
            audit.add(body, kind.audit);
            m_objects.push_back({body, &kind});
            m_names.push_back(kind.name + " " + std::to_string(i));
            m_top = std::max(m_top, taken.back().center.z() + kind.reach);
        }
        addWalls(world, audit);
    }

    static constexpr int kSizes = 2;

    /// Of the bodies, in the order of their numbers in the audit.
    [[nodiscard]] const std::vector<std::string>& names() const { return m_names; }
    /// Of the centres of mass [m/s].
    [[nodiscard]] double meanSpeed() const
    {
        double sum = 0.0;
        for (const Object& object : m_objects)
        {
            sum += double(object.body->getLinearVelocity().length());
        }
        return sum / double(m_objects.size());
    }
    /// What is wrong with where the objects are: a vertex that is below the floor or outside of the
    /// walls by more than the slack; or "".
    [[nodiscard]] std::string placesOf(double slack) const
    {
        for (std::size_t i = 0; i < m_objects.size(); ++i)
        {
            const Eigen::Isometry3d X = btCcdToEigen(m_objects[i].body->getWorldTransform());
            for (const Eigen::Vector3d& vertex : m_objects[i].kind->audit->mesh().vertices)
            {
                const Eigen::Vector3d p = X * vertex;
                if ((p.head<2>().cwiseAbs() - m_halfInner).maxCoeff() > slack || p.z() < -slack)
                {
                    return fmt::format("{} is not in the bin: ({:.3f}, {:.3f}, {:.3f})",
                                       m_names[i],
                                       p.x(),
                                       p.y(),
                                       p.z());
                }
            }
        }
        return "";
    }
    /// Adds which shapes there are, and their triangles.
    void count(std::map<std::string, std::int64_t>& counts) const
    {
        for (const auto& [body, kind] : m_objects)
        {
            const auto triangles = std::int64_t(kind->audit->mesh().triangles.size());
            counts["triangles, full"] += triangles;
            counts["triangles"] +=
                kind->reduced ? std::int64_t(kind->reduced->triangles()) : triangles;
            ++counts[std::string("shapes: ") +
                     (kind->reduced ? kind->reduced->name() : "full mesh")];
        }
    }

private:
    struct Object
    {
        btRigidBody* body = nullptr;
        const HouseholdObject* kind = nullptr;
    };

    Eigen::Vector2d m_halfInner;
    double m_top = 0.0;  // of the column of objects at the start
    std::vector<HouseholdObject> m_kinds;
    std::vector<Object> m_objects;
    std::vector<std::string> m_names;

    void addWalls(World& world, WorldAudit& audit)
    {
        const double x = m_halfInner.x() + kWall;
        const double y = m_halfInner.y() + kWall;
        const double z = 0.5 * m_top;
        const auto add =
            [&](const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& at)
        {
            btRigidBody* body = world.add(
                examples::meshShape(makeBox(size)), 0.0, examples::poseAt(at.x(), at.y(), at.z()));
            audit.add(body, std::make_shared<const AuditMesh>(makeBox(size)));
            m_names.push_back(name);
        };
        add("floor", {x + kWall, y + kWall, kWall}, {0.0, 0.0, -kWall});
        add("left wall", {kWall, y + kWall, z}, {-x, 0.0, z});
        add("right wall", {kWall, y + kWall, z}, {x, 0.0, z});
        add("front wall", {m_halfInner.x(), kWall, z}, {0.0, -y, z});
        add("back wall", {m_halfInner.x(), kWall, z}, {0.0, y, z});
    }
};

SoakAnswer runBin(const BinSoak& soak, std::uint64_t seed)
{
    examples::World world(examples::Engine::Ccd);
    world->setGravity(btVector3(0, 0, btScalar(-9.81)));
    WorldAudit audit(*world, {.longestMove = soak.longestMove, .mostSamples = soak.mostSamples});
    world.ccd().setCcdImpactListener(&audit);
    const HouseholdBin bin(world, audit, soak, seed);
    if (soak.accuracy > 0.0)
    {
        world.ccd().setCcdAccuracy(soak.accuracy);
    }
    const int steps = static_cast<int>(std::ceil(soak.seconds / soak.timeStep - 1e-9));
    AuditResult seen = audit.start();
    tools::ProgressLine progress(static_cast<std::size_t>(steps), "steps");
    for (int step = 1; step <= steps; ++step)
    {
        seen.add(audit.step(soak.timeStep));
        progress.show(static_cast<std::size_t>(step),
                      fmt::format(", {:.2f} s of motion, mean speed {:.3f} m/s, {} intersections",
                                  step * soak.timeStep,
                                  bin.meanSpeed(),
                                  seen.intersecting));
    }
    const double speed = bin.meanSpeed();
    const bool isClean = seen.clean() || seen.worst.depth < soak.accuracy;
    const std::string wrong = !isClean                               ? describe(seen, bin.names())
                              : !bin.placesOf(soak.accuracy).empty() ? bin.placesOf(soak.accuracy)
                              : speed < soak.restSpeed
                                  ? ""
                                  : fmt::format("not at rest: mean speed {:.4f} m/s", speed);
    SoakAnswer answer{.counts = namedCounts(world.ccd().getCcdCounters())};
    if (!wrong.empty())
    {
        answer.judgement = {.verdict = Verdict::Missed,
                            .time = seen.time,
                            .distance = -seen.worst.depth,
                            .pair = wrong};
    }
    bin.count(answer.counts);
    answer.counts["poses looked at"] = seen.poses;
    answer.counts["pairs of bodies near each other"] = seen.pairs;
    answer.counts["intersections"] = seen.intersecting;
    answer.counts["deepest [um]"] = std::llround(1e6 * seen.worst.depth);
    answer.counts["mean speed at the end [um/s]"] = std::llround(1e6 * speed);
    answer.counts["time per step [us of the processor]"] =
        std::llround(1e6 * audit.seconds() / steps);
    return answer;
}
}  // namespace

std::map<std::string, std::int64_t> namedCounts(const btCcdCounters& counters)
{
    return {{"queries", counters.m_queries},
            {"impacts", counters.m_impacts},
            {"lost time [us]", std::llround(1e6 * counters.m_lostTime)},
            {"pairs that intersected already", counters.m_overlaps},
            {"steps at the limit of impacts", counters.m_eventLimits},
            {"bodies squeezed", counters.m_squeezed},
            {"queries that gave up", counters.m_iterationLimits},
            {"colliders not covered", counters.m_unsupported}};
}

SoakSubject binSoak(const BinSoak& soak)
{
    return {.program = fmt::format(
                "benchmarks/run soak bullet bin --objects {} --seconds {} --dt {} --accuracy {}",
                soak.objects,
                soak.seconds,
                soak.timeStep,
                soak.accuracy),
            .families = {"bin"},
            .shares = {.leastHits = 0},
            .ask = [soak](std::uint64_t seed) { return runBin(soak, seed); }};
}
}  // namespace bullet_ccd::benchmarks
