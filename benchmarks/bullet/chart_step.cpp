// Points of the chart of whole Bullet steps as JSON; benchmarks/run chart runs this program and
// draws them.
#include "benchmarks/reference/bullet/missiles.h"
#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "benchmarks/support/chart.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>

namespace bullet_ccd::benchmarks
{
namespace
{
using reference::Kind;
using reference::Missile;
using reference::Scene;
using reference::vec;

constexpr double kFrame = 1.0 / 60.0;  // [s]
constexpr int kRow = 5;                // bodies along a side of a volley
constexpr double kSpacing = 0.15;      // [m]: they must not meet
constexpr double kTargetHalf = 1.0;
constexpr double kPlateHalf = 0.00025;  // of the thickness
constexpr double kMeshMargin = btCcdMeshShape::kDefaultMargin;
constexpr double kTwoMargins = 2.0 * kMeshMargin;
constexpr double kContactReach = 1.1e-3;  // farther is no contact
constexpr double kNothing = 1e-6;         // closer is as good as there
constexpr double kStart = 0.1;            // of the lowest centre above the target

struct Volley
{
    std::string name;
    std::string title;
    std::string missile;  ///< name
    std::function<btCollisionShape*(Scene&, Kind)> target;
    double surface = 0.0;  ///< height of the target's surface
    double margins = 0.0;  ///< of the meshes: where they rest
    double speed = 5.0;    ///< [m/s]
    double spin = 1.0;     ///< of the missile's own
};

const Eigen::Vector3d kPlate(kTargetHalf, kTargetHalf, kPlateHalf);

btCollisionShape* plate(Scene& scene, Kind /*kind*/)
{
    return scene.box(btCcdToBullet(kPlate));
}

/// Stock Bullet has its own static mesh, which its moving meshes can meet.
btCollisionShape* meshPlate(Scene& scene, Kind kind)
{
    return reference::isOurs(kind)
               ? static_cast<btCollisionShape*>(scene.boxMesh(btCcdToBullet(kPlate)))
               : scene.staticMesh(makeBox(kPlate));
}

btCollisionShape* sheet(Scene& scene, Kind /*kind*/)
{
    return scene.staticMesh(reference::floorAt(0.0, kTargetHalf));
}

const std::vector<Volley>& allVolleys()
{
    // Bullet turns no body by more than 0.785 rad a step: rods spin at less than 47 rad/s.
    static const std::vector<Volley> kVolleys{
        {"balls_plate", "balls at a plate", "sphere", plate, kPlateHalf},
        {"boxes_sheet", "boxes at a sheet of triangles", "box", sheet},
        {"rods_plate",
         "spinning rods at a plate",
         "spinning rod",
         plate,
         kPlateHalf,
         0.0,
         2.0,
         0.25},
        {"meshes_plate", "mesh boxes at a plate", "mesh box", plate, kPlateHalf, kMeshMargin},
        {"meshes_mesh",
         "mesh boxes at a mesh plate",
         "mesh box",
         meshPlate,
         kPlateHalf,
         kTwoMargins},
        {"mesh_rods_mesh",
         "spinning mesh rods at a mesh plate",
         "spinning mesh rod",
         meshPlate,
         kPlateHalf,
         kTwoMargins,
         2.0,
         0.25}};
    return kVolleys;
}

Missile missileNamed(const std::string& name)
{
    for (const reference::Shot& shot : reference::shotsAtTargets())
    {
        if (shot.missile.name == name)
        {
            return shot.missile;
        }
    }
    throw std::invalid_argument(name + ": no missile of the tunnelling table has this name");
}

/// How a world is stepped.
struct Stepping
{
    Kind kind = Kind::Stock;
    int substeps = 1;
    double tolerance = 0.0;  ///< 0: its default
};

/// A body, with what was seen of it at the ends of frames.
struct Shot
{
    btRigidBody* body = nullptr;
    double lowest = INFINITY;  ///< of its points above the surface [m]
    bool sunk = false;         ///< the inner half of the ball about its centre met the surface
    bool through = false;      ///< the centre is on the other side
};

btCollisionShape* shapeOf(Scene& scene, const Missile& missile, Kind kind)
{
    const bool isMesh = std::string(missile.name).find("mesh") != std::string::npos;
    return isMesh && !reference::isOurs(kind) ? reference::gimpactShape(scene, missile.surface)
                                              : missile.make(scene);
}

/// Orientations and heights are those of the number, so that all methods are asked the same.
std::vector<Shot> shoot(
    Scene& scene, btCollisionShape* shape, const Volley& volley, const Missile& missile, int number)
{
    std::vector<Shot> shots;
    for (int i = 0; i < kRow * kRow; ++i)
    {
        const double phase = std::fmod(0.61803398875 * (1 + i + kRow * kRow * number), 1.0);
        const btVector3 place = vec(kSpacing * (i % kRow - kRow / 2),
                                    kSpacing * (i / kRow - kRow / 2),
                                    kStart + volley.speed * kFrame * phase);
        const btQuaternion turn(vec(1, 2, 3).normalized(), btScalar(0.2 + 5.0 * phase));
        btRigidBody* body = scene.body(shape, 0.01, btTransform(turn, place));
        body->setFriction(0);
        body->setLinearVelocity(vec(0.2, 0, -volley.speed));
        body->setAngularVelocity(btCcdToBullet(volley.spin * missile.spin));
        shots.push_back({.body = body});
    }
    return shots;
}

void look(const Volley& volley, const Missile& missile, Shot& shot)
{
    const Eigen::Isometry3d X_WB = btCcdToEigen(shot.body->getWorldTransform());
    const double centre = X_WB.translation().z() - volley.surface;
    shot.sunk = shot.sunk || centre < 0.5 * missile.inner;
    shot.through = shot.through || centre < 0.0;
    for (const Eigen::Vector3d& p_B : missile.surface.vertices)
    {
        const double height = (X_WB * p_B).z() - missile.radius - volley.surface;
        shot.lowest = std::min(shot.lowest, height);
    }
}

/// Bodies may touch and part again within a step.
class Watcher : public btCcdImpactListener
{
public:
    Watcher(const Volley& volley, const Missile& missile, std::span<Shot> shots)
        : m_volley(volley), m_missile(missile), m_shots(shots)
    {
    }

    void lookAtAll()
    {
        for (Shot& shot : m_shots)
        {
            look(m_volley, m_missile, shot);
        }
    }

    btCcdAfterImpact onImpact(const btCcdImpact& /*impact*/) override
    {
        lookAtAll();
        return btCcdAfterImpact::Solve;
    }

private:
    const Volley& m_volley;
    const Missile& m_missile;
    std::span<Shot> m_shots;
};

ChartOutcome judge(const Volley& volley, const Shot& shot, double micros)
{
    ChartOutcome outcome{.micros = micros, .hit = true};
    if (shot.through)
    {
        outcome.flaw = ChartFlaw::Missed;
        return outcome;
    }
    outcome.error = std::max({-shot.lowest, shot.lowest - volley.margins, kNothing});
    if (shot.sunk)
    {
        outcome.flaw = ChartFlaw::Late;
    }
    else if (shot.lowest > volley.margins + kContactReach)
    {
        outcome.flaw = ChartFlaw::False;
    }
    return outcome;
}

/// One world until all bodies have long met the target.
class World
{
public:
    World(const Volley& volley, const Stepping& stepping, int number)
        : m_volley(volley),
          m_stepping(stepping),
          m_missile(missileNamed(volley.missile)),
          m_scene(stepping.kind, reference::WorldClass::Rigid)
    {
        const Kind kind = stepping.kind;
        m_scene.body(volley.target(m_scene, kind), 0.0, btTransform::getIdentity());
        m_shots = shoot(m_scene, shapeOf(m_scene, m_missile, kind), volley, m_missile, number);
        if (stepping.tolerance > 0.0)
        {
            m_scene.ccd().setCcdTolerance(stepping.tolerance);
        }
    }

    /// Mean of the frames.
    [[nodiscard]] double micros()
    {
        const double all = microsecondsOf([&] { run([] {}); });
        return all / frames();
    }

    [[nodiscard]] std::vector<ChartOutcome> watch(double micros)
    {
        Watcher watcher(m_volley, m_missile, m_shots);
        // The action leaves bodies where they met until the step ends.
        if (m_stepping.kind == Kind::World)
        {
            m_scene.ccd().setCcdImpactListener(&watcher);
        }
        run([&] { watcher.lookAtAll(); });
        if (m_stepping.kind == Kind::World)
        {
            m_scene.ccd().setCcdImpactListener(nullptr);
        }
        std::vector<ChartOutcome> outcomes;
        for (const Shot& shot : m_shots)
        {
            outcomes.push_back(judge(m_volley, shot, micros));
        }
        return outcomes;
    }

private:
    const Volley& m_volley;
    Stepping m_stepping;
    Missile m_missile;
    Scene m_scene;
    std::vector<Shot> m_shots;

    [[nodiscard]] int frames() const { return int(kStart / (m_volley.speed * kFrame)) + 6; }

    template <typename AfterStep>
    void run(const AfterStep& afterStep)
    {
        for (int i = 0; i < frames() * m_stepping.substeps; ++i)
        {
            m_scene.step(kFrame / m_stepping.substeps);
            afterStep();
        }
    }
};

ChartSetting settingOf(const Volley& volley,
                       const std::string& label,
                       const Stepping& stepping,
                       int volleys)
{
    return {
        .label = label,
        .run = [&volley, stepping, volleys]
        {
            std::vector<ChartOutcome> outcomes;
            for (int number = 0; number < volleys; ++number)
            {
                // The same motion twice: looking takes time.
                const double micros = World(volley, stepping, number).micros();
                for (const ChartOutcome& outcome : World(volley, stepping, number).watch(micros))
                {
                    outcomes.push_back(outcome);
                }
            }
            return outcomes;
        }};
}
/// Frames of 1/60 s by stock Bullet in several numbers of substeps, by its own continuous collision
/// detection, by our action and by our world. A query is a body, its time that of a frame of its
/// world.
///
/// The lowest point of a body must come down to the surface and no farther: the error is how deep
/// it was seen below it at the ends of steps and at impacts, or else how far it stayed from the
/// margins, within which meshes may rest [m]. Missed are bodies that went through, late those that
/// sank in by half: a ball of half the inner radius about the centre met the surface; false those
/// that were stopped more than 1.1 mm before.
/// @param volleys worlds of 25 bodies, each with other orientations and phases
ChartScene makeScene(const std::string& name, int volleys)
{
    const auto found = std::ranges::find(allVolleys(), name, &Volley::name);
    if (found == allVolleys().end())
    {
        throw std::invalid_argument(fmt::format("scene '{}' is unknown: see --help", name));
    }
    const Volley& volley = *found;
    ChartScene scene{.name = volley.name, .title = volley.title, .methods = {}};
    for (const Kind kind : reference::kAllKinds)
    {
        const bool isStock = kind == Kind::Stock;
        ChartMethod method{.name = isStock                  ? "Bullet, stock"
                                   : kind == Kind::StockCcd ? "Bullet, stock CCD"
                                                            : reference::nameOf(kind),
                           .settings = {}};
        for (const int substeps : {1, 4, 16, 64, 256})
        {
            method.settings.push_back(
                settingOf(volley, fmt::format("x{}", substeps), {kind, substeps}, volleys));
        }
        scene.methods.push_back(std::move(method));
        if (reference::isOurs(kind))
        {
            ChartMethod tolerances{
                .name = fmt::format("{}, x1, tolerance", reference::nameOf(kind)), .settings = {}};
            for (const double tolerance : {1e-3, 1e-5})
            {
                tolerances.settings.push_back(
                    settingOf(volley,
                              fmt::format("1e{:.0f} m", std::log10(tolerance)),
                              {kind, 1, tolerance},
                              volleys));
            }
            scene.methods.push_back(std::move(tolerances));
        }
    }
    return scene;
}

int run(int argc, char** argv)
{
    std::vector<std::string> scenes;
    for (const Volley& volley : allVolleys())
    {
        scenes.push_back(volley.name);
    }
    int volleys = 4;
    return runChart(argc,
                    argv,
                    {.family = {.name = "step",
                                .title = "A frame of 1/60 s of a Bullet world",
                                .time = "time of a frame with 25 bodies",
                                .error = "depth or distance [m]",
                                .missed = "went through",
                                .late = "half in",
                                .falseHit = "kept away",
                                .timedOut = "",
                                .peers = {fmt::format("Bullet {}", btGetVersion())}},
                     .scenes = scenes,
                     .options = {{"-n,--volleys", &volleys, "worlds of 25 bodies of a scene"}},
                     .makeScene = [&](const std::string& scene, const ChartOptions& options)
                     { return makeScene(scene, options.quick ? 1 : volleys); }});
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    return bullet_ccd::benchmarks::run(argc, argv);
}
