/// Worlds of triangle meshes in which an exact check looks at every pose: gears and dominoes.
#include "benchmarks/reference/audit/world_audit.h"
#include "bullet_ccd/examples/example_support.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

namespace bullet_ccd::tests
{
namespace
{
using namespace bullet_ccd::examples;
using bullet_ccd::reference::AuditMesh;
using bullet_ccd::reference::AuditResult;
using bullet_ccd::reference::WorldAudit;

constexpr double kPi = std::numbers::pi;
constexpr double kModule = 0.005;           // pitch diameter for each tooth [m]
constexpr double kPressureAngle = kPi / 9;  // 20 degrees
constexpr double kThinner = 0.0006;         // each tooth, at the pitch circle: the play [m]
constexpr double kWidth = 0.01;             // [m]
constexpr double kMargin = 0.0001;          // of each mesh [m]
constexpr double kGearStep = 1.0 / 240.0;   // [s]
constexpr double kDriverSpeed = 20.0;       // of the driver [rad/s]
constexpr int kTeethDriver = 18;
constexpr int kTeethDriven = 27;

double involute(double angle)
{
    return std::tan(angle) - angle;
}

/// Outline of a gear, counter-clockwise, tooth 0 about the x axis.
std::vector<Eigen::Vector2d> outline(int teeth)
{
    const double pitch = 0.5 * kModule * teeth;
    const double base = pitch * std::cos(kPressureAngle);
    const double tip = pitch + kModule;
    const double root = pitch - 1.25 * kModule;
    const double atPitch = 0.5 * (kPi / teeth - kThinner / pitch);
    constexpr int kFlankPoints = 6;
    std::vector<Eigen::Vector2d> half;  // of a tooth: radius, half its angle there
    for (int i = 0; i < kFlankPoints; ++i)
    {
        const double radius = base + (tip - base) * i / (kFlankPoints - 1);
        half.emplace_back(radius,
                          atPitch + involute(kPressureAngle) - involute(std::acos(base / radius)));
    }
    half.insert(half.begin(), {root, half.front().y()});

    std::vector<Eigen::Vector2d> points;
    const auto add = [&points](double radius, double angle)
    { points.emplace_back(radius * std::cos(angle), radius * std::sin(angle)); };
    for (int tooth = 0; tooth < teeth; ++tooth)
    {
        const double center = 2.0 * kPi * tooth / teeth;
        for (auto at = half.begin(); at != half.end(); ++at)
        {
            add(at->x(), center - at->y());
        }
        for (auto at = half.rbegin(); at != half.rend(); ++at)
        {
            add(at->x(), center + at->y());
        }
    }
    return points;
}

TriangleMesh gearMesh(int teeth)
{
    const std::vector<Eigen::Vector2d> points = outline(teeth);
    return makeLofted(
        [&points](int station)
        {
            std::vector<Eigen::Vector3d> ring;
            for (const Eigen::Vector2d& p : points)
            {
                ring.emplace_back(p.x(), p.y(), (station - 0.5) * kWidth);
            }
            return ring;
        },
        2);
}

/// A gear that turns about z, and how far it has turned.
class Gear
{
public:
    Gear(World& world, WorldAudit& audit, int teeth, double x)
    {
        const TriangleMesh mesh = gearMesh(teeth);
        auto shape = meshShape(mesh);
        shape->setMargin(btScalar(kMargin));
        const double mass = 7800.0 * massProperties(mesh).volume;
        m_body = world.add(std::move(shape), mass, poseAt(x, 0.0, 0.0));
        m_body->setActivationState(DISABLE_DEACTIVATION);
        audit.add(m_body, std::make_shared<const AuditMesh>(mesh));
        m_hinge =
            std::make_unique<btHingeConstraint>(*m_body, btVector3(0, 0, 0), btVector3(0, 0, 1));
        world->addConstraint(m_hinge.get());
    }
    /// Angular momentum that the motor may give in a step [N m s].
    void drive(double speed, double impulse)
    {
        m_hinge->enableAngularMotor(true, btScalar(speed), btScalar(impulse));
    }
    void follow()
    {
        const btVector3 x = m_body->getWorldTransform().getBasis().getColumn(0);
        const double angle = std::atan2(double(x.y()), double(x.x()));
        m_turned += std::remainder(angle - m_angle, 2.0 * kPi);
        m_angle = angle;
    }
    [[nodiscard]] double turned() const { return m_turned; }
    [[nodiscard]] double tilt() const
    {
        return double(m_body->getWorldTransform().getBasis().getColumn(2).z());
    }
    btTypedConstraint* hinge() { return m_hinge.get(); }

private:
    btRigidBody* m_body = nullptr;
    std::unique_ptr<btHingeConstraint> m_hinge;
    double m_angle = 0.0;
    double m_turned = 0.0;
};

/// Two gears of 18 and 27 teeth on hinges; a motor drives the smaller one at 20 rad/s, the larger
/// one has a brake. Teeth are triangle meshes: nothing but their contact couples the gears. Half a
/// tooth goes by in every step.
TEST(AuditedWorld, GearsTurnEachOtherByTheirTeeth)
{
    World world(Engine::Ccd);
    world->setGravity(btVector3(0, 0, 0));
    WorldAudit audit(*world, {.longestMove = 2.5e-4, .mostSamples = 64});
    world.ccd().setCcdImpactListener(&audit);
    Gear driver(world, audit, kTeethDriver, 0.0);
    Gear driven(world, audit, kTeethDriven, 0.5 * kModule * (kTeethDriver + kTeethDriven));
    driver.drive(kDriverSpeed, 0.01);
    driven.drive(0.0, 5e-4);

    AuditResult seen = audit.start();
    double before[2] = {0.0, 0.0};
    const int settle = 240;
    const int turn = static_cast<int>(
        std::ceil(2.0 * kPi * kTeethDriven / kTeethDriver / kDriverSpeed / kGearStep));
    for (int step = 1; step <= settle + turn; ++step)
    {
        seen.add(audit.step(kGearStep));
        driver.follow();
        driven.follow();
        if (step == settle)
        {
            before[0] = driver.turned();
            before[1] = driven.turned();
        }
    }
    const double ratio = (driven.turned() - before[1]) / (driver.turned() - before[0]);
    const double expected = -double(kTeethDriver) / kTeethDriven;
    world->removeConstraint(driver.hinge());
    world->removeConstraint(driven.hinge());
    EXPECT_GT(driver.turned(), 0.9 * kDriverSpeed * (settle + turn) * kGearStep)
        << "the motor keeps its speed";
    EXPECT_NEAR(ratio / expected, 1.0, 0.02) << "the speeds have the ratio of the teeth";
    EXPECT_TRUE(seen.clean()) << "no tooth is ever inside another";
    EXPECT_GT(driver.tilt(), 0.999) << "the gears stay on their hinges";
    EXPECT_GT(driven.tilt(), 0.999);
}

constexpr int kTiles = 12;
constexpr double kTileStep = 1.0 / 60.0;  // [s]
constexpr double kBlockSpeed = 50.0;      // of the block [m/s]
const Eigen::Vector3d kHalfTile(0.001, 0.010, 0.020);
const Eigen::Vector3d kHalfBlock(0.006, 0.008, 0.006);
const Eigen::Vector3d kHalfGround(3.0, 3.0, 0.05);  // top at z = 0

/// Adds a box of triangles, resting in the world and watched by the audit.
btRigidBody* addBox(World& world,
                    WorldAudit& audit,
                    const Eigen::Vector3d& half,
                    double mass,
                    const btTransform& pose)
{
    btRigidBody* body = world.add(meshShape(makeBox(half)), mass, pose);
    audit.add(body, std::make_shared<const AuditMesh>(makeBox(half)));
    return body;
}

/// A row of tiles two millimetres thick, hit by a small block at 50 m/s. In one step of 1/60 s the
/// block would travel 0.8 m, farther than the row is long. Everything is a triangle mesh, which
/// stock Bullet lets pass through each other; here no two of them ever intersect.
TEST(AuditedWorld, DominoesFallAndNeverIntersect)
{
    World world(Engine::Ccd);
    world->setGravity(btVector3(0, 0, btScalar(-9.81)));
    // Half the thickness of a tile: what passes through one is seen in it.
    WorldAudit audit(*world, {.longestMove = 0.5 * kHalfTile.x(), .mostSamples = 4000});
    world.ccd().setCcdImpactListener(&audit);

    addBox(world, audit, kHalfGround, 0.0, poseAt(0.0, 0.0, -kHalfGround.z()));
    const double gap = 2.0 * btCcdMeshShape::kDefaultMargin;
    std::vector<btRigidBody*> tiles;
    for (int i = 0; i < kTiles; ++i)
    {
        tiles.push_back(
            addBox(world, audit, kHalfTile, 0.004, poseAt(0.015 * i, 0.0, kHalfTile.z() + gap)));
    }
    btRigidBody* block = addBox(world, audit, kHalfBlock, 0.006, poseAt(-0.1, 0.0, 0.03));
    block->setLinearVelocity(btVector3(btScalar(kBlockSpeed), 0, 0));

    AuditResult seen = audit.start();
    for (int step = 0; step < 120; ++step)
    {
        seen.add(audit.step(kTileStep));
    }

    int standing = 0;
    for (const btRigidBody* tile : tiles)
    {
        const bool upright = tile->getWorldTransform().getBasis()[2].z() > btScalar(0.9);
        const bool inPlace = tile->getWorldTransform().getOrigin().z() > 0.9 * kHalfTile.z();
        standing += upright && inPlace ? 1 : 0;
    }
    EXPECT_GE(world.ccd().getCcdCounters().m_impacts, 1) << "the block hits";
    EXPECT_TRUE(seen.clean()) << "bodies " << seen.bodyA << " and " << seen.bodyB << " at "
                              << seen.time << " s";
    EXPECT_EQ(standing, 0) << "no tile stands any more";
}
}  // namespace
}  // namespace bullet_ccd::tests
