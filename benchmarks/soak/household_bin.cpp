#include "benchmarks/soak/household_bin.h"

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "robots/shapes/household_objects.h"

#include <algorithm>
#include <optional>

namespace bullet_ccd::benchmarks
{
namespace
{
constexpr double kWall = 0.02;       // thickness [m]
constexpr double kDensity = 800.0;   // [kg/m^3]
constexpr double kCoarseness = 2.0;  // of the meshes
constexpr double kBetween = 0.005;   // bounding balls at the start [m]

using examples::meshShape;
using examples::poseAt;
using examples::World;
using reference::AuditMesh;
using reference::Random;

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
}  // namespace

HouseholdObject makeHouseholdObject(std::size_t number, std::uint64_t seed, double density)
{
    const std::vector<std::string>& families = shapes::objectFamilies();
    HouseholdObject object;
    object.name = families[number % families.size()];
    const std::optional<std::uint64_t> size =
        number < families.size() ? std::nullopt : std::optional(seed);
    TriangleMesh mesh = shapes::makeObject(object.name, size, kCoarseness);
    static_cast<void>(examples::putIntoPrincipalAxes(mesh));
    object.mass = density * massProperties(mesh).volume;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        object.reach = std::max(object.reach, vertex.norm());
    }
    object.audit = std::make_shared<const AuditMesh>(mesh);
    object.tree = std::make_shared<const SsvTree>(buildSsvTree(std::move(mesh)));
    return object;
}

HouseholdBin::HouseholdBin(World& world, reference::WorldAudit& audit, const BinOptions& options)
    : m_halfInner(options.halfInner)
{
    makeKinds(options);
    Random random(options.seed);
    std::vector<Ball> taken;
    for (int i = 0; i < options.objects; ++i)
    {
        const HouseholdObject& kind = m_kinds[std::size_t(i) % m_kinds.size()];
        taken.push_back({findPlace(taken, kind.reach, m_halfInner, random), kind.reach});
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.linear() = random.rotation();
        X.translation() = taken.back().center;
        btRigidBody* body =
            world.add(std::make_unique<btCcdMeshShape>(kind.tree), kind.mass, btCcdToBullet(X));
        body->setRollingFriction(btScalar(0.002));
        body->setSpinningFriction(btScalar(0.002));
        audit.add(body, kind.audit);
        m_objects.push_back({body, kind.audit.get()});
        m_names.push_back(kind.name + " " + std::to_string(i));
        m_top = std::max(m_top, taken.back().center.z() + kind.reach);
    }
    addWalls(world, audit);
}

void HouseholdBin::addWalls(World& world, reference::WorldAudit& audit)
{
    const Eigen::Vector2d& half = m_halfInner;
    const double x = half.x() + kWall;
    const double y = half.y() + kWall;
    const double z = 0.5 * m_top;
    const auto add =
        [&](const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& at)
    {
        btRigidBody* body =
            world.add(meshShape(makeBox(size)), 0.0, poseAt(at.x(), at.y(), at.z()));
        audit.add(body, std::make_shared<const AuditMesh>(makeBox(size)));
        m_names.push_back(name);
    };
    add("floor", {x + kWall, y + kWall, kWall}, {0.0, 0.0, -kWall});
    add("left wall", {kWall, y + kWall, z}, {-x, 0.0, z});
    add("right wall", {kWall, y + kWall, z}, {x, 0.0, z});
    add("front wall", {half.x(), kWall, z}, {0.0, -y, z});
    add("back wall", {half.x(), kWall, z}, {0.0, y, z});
}

void HouseholdBin::makeKinds(const BinOptions& options)
{
    const std::size_t count = std::min(std::size_t(options.objects),
                                       std::size_t(kSizes) * shapes::objectFamilies().size());
    for (std::size_t i = 0; i < count; ++i)
    {
        m_kinds.push_back(makeHouseholdObject(i, options.seed * 1000 + i, kDensity));
    }
}

bool HouseholdBin::isInside(std::size_t object) const
{
    const Eigen::Isometry3d X = btCcdToEigen(m_objects[object].body->getWorldTransform());
    return std::ranges::all_of(m_objects[object].mesh->mesh().vertices,
                               [&](const Eigen::Vector3d& vertex)
                               {
                                   const Eigen::Vector3d p = X * vertex;
                                   return std::abs(p.x()) < m_halfInner.x() &&
                                          std::abs(p.y()) < m_halfInner.y() && p.z() > 0.0;
                               });
}

int HouseholdBin::countInside() const
{
    int inside = 0;
    for (std::size_t i = 0; i < m_objects.size(); ++i)
    {
        inside += isInside(i) ? 1 : 0;
    }
    return inside;
}

double HouseholdBin::meanSpeed() const
{
    double sum = 0.0;
    for (const Object& object : m_objects)
    {
        sum += double(object.body->getLinearVelocity().length());
    }
    return sum / double(m_objects.size());
}
}  // namespace bullet_ccd::benchmarks
