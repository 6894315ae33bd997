/// The scenes of the soak queries, in units of about the size of the bodies.
#include "benchmarks/reference/queries/soak_families.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;

TriangleMesh smallSoup(Random& random)
{
    return soup(random, random.integer(1, 30), 0.5, random.logUniform(0.05, 0.6));
}

TriangleMesh smallBox(Random& random)
{
    const Vector3d half = Vector3d::Constant(0.1) + 0.5 * random.inBox(1.0).cwiseAbs();
    return box(-half, half);
}

TriangleMesh anyMesh(Random& random)
{
    switch (random.integer(0, 3))
    {
        case 0:
            return smallBox(random);
        case 1:
            return sphereWithPole(random.uniform(0.3, 0.8), random.direction(), 3);
        default:
            return smallSoup(random);
    }
}

/// Triangles of length about 1 and any width.
TriangleMesh slivers(Random& random)
{
    TriangleMesh mesh;
    const int count = random.integer(1, 12);
    for (int i = 0; i < count; ++i)
    {
        const Vector3d a = random.inBox(0.4);
        const Vector3d along = random.uniform(0.3, 1.2) * random.direction();
        const Vector3d width = random.logUniform(1e-9, 1e-2) * random.direction();
        mesh = merged({mesh, triangle(a, a + along, a + random.uniform(0.0, 1.0) * along + width)});
    }
    return mesh;
}

/// Points, segments with two or three different corners, and a few honest triangles.
TriangleMesh degenerate(Random& random)
{
    TriangleMesh mesh;
    const int count = random.integer(1, 12);
    for (int i = 0; i < count; ++i)
    {
        const Vector3d a = random.inBox(0.5);
        const Vector3d b = a + random.inBox(0.7);
        const double s = random.integer(-2, 3) * 0.5;
        const std::array<Vector3d, 4> third{a, b, a + s * (b - a), Vector3d(a + random.inBox(0.5))};
        const bool isPoint = random.chance(0.2);
        const auto kind = static_cast<std::size_t>(random.integer(0, 3));
        mesh = merged({mesh, isPoint ? triangle(a, a, a) : triangle(a, b, third[kind])});
    }
    return mesh;
}

double quarter(Random& random, int low, int high)
{
    return 0.25 * random.integer(low, high);
}

TriangleMesh gridBox(Random& random)
{
    const Vector3d half(quarter(random, 1, 3), quarter(random, 1, 3), quarter(random, 1, 3));
    return random.chance(0.2) ? quad({-half.x(), -half.y(), 0},
                                     {half.x(), -half.y(), 0},
                                     {half.x(), half.y(), 0},
                                     {-half.x(), half.y(), 0})
                              : box(-half, half);
}

TriangleMesh bar(Random& random, double half)
{
    const double length = random.uniform(0.3, 1.0);
    return random.chance(0.3) ? segment({-length, 0, 0}, {length, 0, 0})
                              : box({-length, -half, -half}, {length, half, half});
}

TriangleMesh plate(Random& random)
{
    const double half = random.uniform(0.3, 0.7);
    const double thick = random.chance(0.3) ? 0.0 : random.logUniform(1e-5, 1e-2);
    return thick > 0.0 ? box({-half, -half, -thick}, {half, half, thick}) : floorAt(0.0, half);
}

/// A cone with its tip at the origin, opening along z.
TriangleMesh spike(Random& random)
{
    const double radius = random.logUniform(1e-6, 0.2);
    const int sides = random.integer(3, 8);
    TriangleMesh mesh{.vertices = {{0, 0, 0}}, .triangles = {}};
    for (const Eigen::Vector2d& p : circlePoints(radius, circleAngles(sides, 0.3)))
    {
        mesh.vertices.emplace_back(p.x(), p.y(), 0.8);
    }
    for (std::int32_t i = 0; i < sides; ++i)
    {
        mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % sides});
    }
    return mesh;
}

/// Turns both bodies and lets them fly at each other from outside of their balls.
void approach(Random& random, RigidScene& scene, double spin, double miss)
{
    const double reach = radiusOf(scene.meshA) + radiusOf(scene.meshB);
    const Vector3d away = random.uniform(1.02, 2.0) * reach * random.direction();
    const Vector3d drift = random.chance(0.5) ? random.inBox(2.0) : Vector3d::Zero();
    scene.motionB.X_W0 = random.pose(1.0);
    scene.motionA.X_W0 = random.pose(1.0);
    scene.motionA.X_W0.translation() = scene.motionB.X_W0.translation() + away;
    scene.motionA.v_W = drift - random.uniform(0.6, 2.0) * away + miss * reach * random.direction();
    scene.motionB.v_W = drift;
    scene.motionA.w_W = random.uniform(0.0, spin) * random.direction();
    scene.motionB.w_W = random.uniform(0.0, spin) * random.direction();
}

SoakScene flight(Random& random, TriangleMesh a, TriangleMesh b, double spin, double miss)
{
    SoakScene made{.scene = {.meshA = std::move(a), .meshB = std::move(b)}};
    approach(random, made.scene, spin, miss);
    return made;
}

SoakScene soups(Random& random)
{
    SoakScene made = flight(random, anyMesh(random), anyMesh(random), 4.0, 0.4);
    if (random.chance(0.15))
    {
        made.scene.motionA.X_W0.translation() =
            made.scene.motionB.X_W0.translation() + random.inBox(0.8);
    }
    return made;
}

SoakScene sliverScene(Random& random)
{
    TriangleMesh other = random.chance(0.5) ? slivers(random) : anyMesh(random);
    return flight(random, slivers(random), std::move(other), 3.0, 0.15);
}

SoakScene degenerateScene(Random& random)
{
    TriangleMesh other = random.chance(0.4) ? degenerate(random) : anyMesh(random);
    return flight(random, degenerate(random), std::move(other), 3.0, 0.15);
}

SoakScene coplanarScene(Random& random)
{
    SoakScene made{.scene = {.meshA = gridBox(random), .meshB = gridBox(random)}};
    Vector3d at(quarter(random, -5, 5), quarter(random, -5, 5), quarter(random, -5, 5));
    at[random.integer(0, 2)] = random.chance(0.5) ? 2.0 : -2.0;
    Vector3d v = -at * quarter(random, 2, 6);
    v[random.integer(0, 2)] = 0.0;
    made.scene.motionA.X_W0.translation() = at;
    made.scene.motionA.v_W = random.chance(0.3) ? Vector3d(-quarter(random, 2, 6) * at) : v;
    if (random.chance(0.2))
    {
        made.scene.motionA.w_W[random.integer(0, 2)] = 0.5 * std::numbers::pi;
    }
    return made;
}

SoakScene parallelScene(Random& random)
{
    SoakScene made{.scene = {.meshA = bar(random, 0.05), .meshB = bar(random, 0.1)}};
    const double twist = random.chance(0.3) ? 0.0 : random.logUniform(1e-14, 1e-2);
    const double roll = random.chance(0.5) ? 0.25 * std::numbers::pi : 0.0;
    const double cross = random.chance(0.3) ? 0.5 * std::numbers::pi : 0.0;
    made.scene.motionA.X_W0 = poseOf({random.uniform(-0.3, 0.3), random.uniform(-0.1, 0.1), 1.0});
    made.scene.motionA.X_W0.rotate(Eigen::AngleAxisd(cross + twist, Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(roll, Vector3d::UnitX()));
    made.scene.motionB.X_W0 = poseOf(Vector3d::Zero(), roll, Vector3d::UnitX());
    made.scene.motionA.v_W = {0, random.chance(0.3) ? 0.3 : 0.0, -random.uniform(0.7, 2.0)};
    if (random.chance(0.3))
    {
        // About the bars themselves: edges stay parallel.
        made.scene.motionA.w_W = {random.uniform(-3.0, 3.0), 0, 0};
        made.scene.motionB.w_W = {random.uniform(-3.0, 3.0), 0, 0};
    }
    return made;
}

SoakScene plateScene(Random& random)
{
    SoakScene made = flight(random, plate(random), plate(random), 2.0, 0.05);
    made.scene.motionA.v_W *= random.uniform(5.0, 50.0);
    made.scene.motionB.v_W *= random.chance(0.5) ? 1.0 : 0.0;
    if (random.chance(0.5))
    {
        // Straight through, starting anywhere on the way.
        made.scene.motionA.v_W =
            -random.uniform(20.0, 300.0) *
            (made.scene.motionA.X_W0.translation() - made.scene.motionB.X_W0.translation());
        made.scene.motionB.v_W.setZero();
    }
    return made;
}

SoakScene spikeScene(Random& random)
{
    TriangleMesh other = random.chance(0.6) ? spike(random) : anyMesh(random);
    SoakScene made{.scene = {.meshA = spike(random), .meshB = std::move(other)}};
    // Tip to tip, off by up to a few times the width of a needle.
    const Vector3d off = random.logUniform(1e-9, 1e-1) * random.direction();
    made.scene.motionA.X_W0 = poseOf(Vector3d(0, 0, 1.1) + off);
    made.scene.motionB.X_W0 = poseOf({0, 0, -0.2}, std::numbers::pi, Vector3d::UnitX());
    made.scene.motionA.v_W = {0, 0, -random.uniform(1.0, 2.5)};
    if (random.chance(0.5))
    {
        made.scene.motionA.w_W = random.uniform(0.0, 3.0) * random.direction();
        made.scene.motionB.w_W = random.uniform(0.0, 3.0) * random.direction();
    }
    return made;
}

struct Extreme
{
    double height = -1e300;
    Vector3d place = Vector3d::Zero();
};

void raise(Extreme& extreme, const TriangleMesh& mesh, const RigidMotion& motion, double t)
{
    const Isometry3d X = oraclePose(motion, t);
    for (const Vector3d& v : mesh.vertices)
    {
        const Vector3d at = X * v;
        if (at.z() > extreme.height)
        {
            extreme = {.height = at.z(), .place = at};
        }
    }
}

/// The highest point that the body reaches: sampled, then refined about the best sample.
Extreme highestPoint(const TriangleMesh& mesh, const RigidMotion& motion)
{
    double middle = 0.0;
    double half = 0.5;
    Extreme best;
    for (int round = 0; round < 7; ++round)
    {
        const double from = std::max(0.0, middle - half);
        const double to = std::min(1.0, middle + half);
        const int samples = round == 0 ? 100 : 20;
        for (int k = 0; k <= samples; ++k)
        {
            const double t = from + (to - from) * k / samples;
            const double before = best.height;
            raise(best, mesh, motion, t);
            middle = best.height > before ? t : middle;
        }
        half = (to - from) / samples;
    }
    return best;
}

SoakScene grazingScene(Random& random)
{
    SoakScene made{.scene = {.meshA = soup(random, random.integer(1, 6), 0.6, 0.4),
                             .motionA = randomRigidMotion(random, 5.0)}};
    const Extreme top = highestPoint(made.scene.meshA, made.scene.motionA);
    const double gap = (random.chance(0.5) ? 1.0 : -1.0) * random.logUniform(1e-9, 1e-2);
    const Vector3d at = top.place + gap * Vector3d::UnitZ();
    switch (random.integer(0, 2))
    {
        case 0:
            made.scene.meshB = floorAt(top.height + gap, 20.0);
            break;
        case 1:
        {
            const Vector3d along = random.direction().cross(Vector3d::UnitZ());
            made.scene.meshB = segment(at - along, at + along);
            break;
        }
        default:
            made.scene.meshB = shifted(spike(random), at);
    }
    made.clearance = std::abs(gap);
    return made;
}

/// The vertex farthest along n.
Vector3d supportOf(const TriangleMesh& mesh, const Vector3d& n)
{
    return *std::max_element(mesh.vertices.begin(),
                             mesh.vertices.end(),
                             [&](const Vector3d& a, const Vector3d& b)
                             { return n.dot(a) < n.dot(b); });
}

SoakScene nearMissScene(Random& random)
{
    SoakScene made{
        .scene = {
            .meshA = placed(anyMesh(random), poseOf(Vector3d::Zero(), 1.0, random.direction())),
            .meshB = placed(anyMesh(random), poseOf(Vector3d::Zero(), 2.0, random.direction()))}};
    const Vector3d n = random.direction();
    const Vector3d along = n.unitOrthogonal();
    const double gap = (random.chance(0.45) ? 1.0 : -1.0) * random.logUniform(1e-9, 1e-2);
    const Vector3d meet =
        supportOf(made.scene.meshB, n) - supportOf(made.scene.meshA, -n) + gap * n;
    const double travel = random.uniform(1.5, 3.0);
    const double fraction = random.uniform(0.3, 0.9);
    made.scene.motionA.X_W0.translation() = meet + fraction * travel * along;
    made.scene.motionA.v_W = -travel * along;
    made.clearance = std::abs(gap);
    if (random.chance(0.3))
    {
        made.scene.motionA.w_W = random.logUniform(1e-9, 1e-3) * random.direction();
    }
    return made;
}

SoakScene multiTurnScene(Random& random)
{
    SoakScene made =
        flight(random, soup(random, random.integer(1, 10), 0.5, 0.4), anyMesh(random), 1.0, 0.5);
    made.scene.motionA.w_W = random.uniform(6.0, 60.0) * random.direction();
    if (random.chance(0.5))
    {
        made.scene.motionB.w_W = random.uniform(6.0, 60.0) * random.direction();
    }
    return made;
}

SoakScene bothTurningScene(Random& random)
{
    SoakScene made = flight(random, anyMesh(random), anyMesh(random), 6.0, 0.3);
    for (RigidMotion* motion : {&made.scene.motionA, &made.scene.motionB})
    {
        if (random.chance(0.6))
        {
            motion->reference_B = random.inBox(1.5);
        }
    }
    return made;
}

SoakScene coMovingScene(Random& random)
{
    const double small = random.chance(0.2) ? 0.0 : random.logUniform(1e-2, 2.0);
    SoakScene made = flight(random, anyMesh(random), anyMesh(random), 0.0, 0.1);
    RigidScene& scene = made.scene;
    const Vector3d apart = scene.motionA.X_W0.translation() - scene.motionB.X_W0.translation();
    // Nearer than the balls, so that something may happen.
    scene.motionA.X_W0.translation() -= random.uniform(0.1, 0.5) * apart;
    const Vector3d axis = random.uniform(0.0, 4.0) * random.direction();
    const Vector3d v = random.inBox(3.0);
    const Vector3d hub = random.inBox(2.0);
    for (RigidMotion* motion : {&scene.motionA, &scene.motionB})
    {
        motion->reference_B = motion->X_W0.inverse() * hub;
        motion->v_W = v;
        motion->w_W = axis;
    }
    scene.motionA.v_W -= small * apart;
    scene.motionA.w_W += small * random.inBox(0.5);
    return made;
}

SoakScene farSmallScene(Random& random)
{
    SoakScene made = soups(random);
    if (random.chance(0.5))
    {
        // The mesh itself is far from its body's origin and turns about its own place.
        const Vector3d far = random.inBox(1e6);
        RigidScene& scene = made.scene;
        scene.meshA = shifted(scene.meshA, far);
        scene.motionA.reference_B = far;
        scene.motionA.X_W0.translation() -= scene.motionA.X_W0.linear() * far;
    }
    const Isometry3d X = random.pose(1e6);
    made.scene = moved(made.scene, X);
    made.scale = 1e-3;
    return made;
}

SoakScene scaledScene(Random& random)
{
    SoakScene made = random.chance(0.5) ? soups(random) : bothTurningScene(random);
    made.scale = random.logUniform(1e-9, 1e9);
    return made;
}

SoakScene touchingScene(Random& random)
{
    SoakScene made{
        .scene = {.meshA = random.chance(0.5) ? smallBox(random) : soup(random, 4, 0.4, 0.4),
                  .meshB = random.chance(0.5) ? smallBox(random) : soup(random, 4, 0.4, 0.4)}};
    RigidScene& scene = made.scene;
    approach(random, scene, 0.0, 0.0);
    scene.motionA.v_W = scene.motionB.v_W = Vector3d::Zero();
    made.tolerance = random.logUniform(1e-7, 1e-2);
    const double wanted = made.tolerance * (random.chance(0.5) ? random.uniform(0.0, 1.2)
                                                               : random.logUniform(1e-4, 1));
    Vector3d across = Vector3d::UnitX();
    for (int round = 0; round < 3; ++round)
    {
        const InstantDistance now = featureDistance(scene, 0.0);
        if (now.distance == 0.0)
        {
            break;
        }
        across = (now.pointB - now.pointA).normalized();
        scene.motionA.X_W0.translation() += (now.distance - wanted) * across;
    }
    const double speed = random.logUniform(1e-3, 3.0);
    switch (random.integer(0, 3))
    {
        case 0:  // leaving or pressing
            scene.motionA.v_W = (random.chance(0.5) ? speed : -speed) * across;
            break;
        case 1:  // sliding
            scene.motionA.v_W = speed * across.unitOrthogonal();
            break;
        default:
            scene.motionA.v_W = speed * random.direction();
            scene.motionA.w_W = random.uniform(0.0, 3.0) * random.direction();
            scene.motionB.w_W = random.uniform(0.0, 1.0) * random.direction();
    }
    return made;
}

SoakScene clearanceScene(Random& random)
{
    SoakScene made = random.chance(0.5)
                         ? soups(random)
                         : flight(random, smallBox(random), smallBox(random), 1.0, 0.2);
    made.separation = random.logUniform(1e-5, 0.3);
    return made;
}
}  // namespace

SoakScene soakScene(SoakFamily family, Random& random)
{
    constexpr std::array<SoakScene (*)(Random&), kSoakFamilies> kMakers{soups,
                                                                        sliverScene,
                                                                        degenerateScene,
                                                                        coplanarScene,
                                                                        parallelScene,
                                                                        plateScene,
                                                                        spikeScene,
                                                                        grazingScene,
                                                                        nearMissScene,
                                                                        multiTurnScene,
                                                                        bothTurningScene,
                                                                        coMovingScene,
                                                                        farSmallScene,
                                                                        scaledScene,
                                                                        touchingScene,
                                                                        clearanceScene};
    return kMakers[static_cast<std::size_t>(family)](random);
}
}  // namespace bullet_ccd::reference
