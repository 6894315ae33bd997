// Two gears of 18 and 27 teeth on hinges; a motor drives the smaller one at 20 rad/s, the larger
// one has a brake. Teeth are triangle meshes: nothing but their contact couples the gears. Half a
// tooth goes by in every step.
#include "benchmarks/reference/audit/world_audit.h"
#include "bullet_ccd/examples/example_support.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace
{
using namespace bullet_ccd;
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
constexpr double kTimeStep = 1.0 / 240.0;   // [s]
constexpr double kSpeed = 20.0;             // of the driver [rad/s]
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
}  // namespace

int main()
{
    World world(Engine::Ccd);
    world->setGravity(btVector3(0, 0, 0));
    WorldAudit audit(*world, {.longestMove = 2.5e-4, .mostSamples = 64});
    world.ccd().setCcdImpactListener(&audit);
    Gear driver(world, audit, kTeethDriver, 0.0);
    Gear driven(world, audit, kTeethDriven, 0.5 * kModule * (kTeethDriver + kTeethDriven));
    driver.drive(kSpeed, 0.01);
    driven.drive(0.0, 5e-4);

    AuditResult seen = audit.start();
    double before[2] = {0.0, 0.0};
    const int settle = 240;
    const int turn =
        static_cast<int>(std::ceil(2.0 * kPi * kTeethDriven / kTeethDriver / kSpeed / kTimeStep));
    for (int step = 1; step <= settle + turn; ++step)
    {
        seen.add(audit.step(kTimeStep));
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
    std::printf("driver turned %.2f rad, driven %.2f rad; ratio of speeds %.4f, of teeth %.4f\n",
                driver.turned(),
                driven.turned(),
                ratio,
                expected);
    const btCcdCounters& counters = world.ccd().getCcdCounters();
    std::printf("%lld impacts, %lld clamps, %lld poses looked at\n",
                static_cast<long long>(counters.m_impacts),
                static_cast<long long>(counters.m_clamps),
                static_cast<long long>(seen.poses));
    world->removeConstraint(driver.hinge());
    world->removeConstraint(driven.hinge());
    check(driver.turned() > 0.9 * kSpeed * (settle + turn) * kTimeStep,
          "the motor keeps its speed");
    check(std::abs(ratio / expected - 1.0) < 0.02, "the speeds have the ratio of the teeth");
    check(seen.clean(), "no tooth is ever inside another");
    check(driver.tilt() > 0.999 && driven.tilt() > 0.999, "the gears stay on their hinges");
    return exitCode();
}
