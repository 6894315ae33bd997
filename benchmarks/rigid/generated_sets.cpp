#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "benchmarks/reference/scenes/split_mix.h"
#include "benchmarks/rigid/rigid_meshes.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using std::numbers::pi;

class Random : public reference::RandomFrom<reference::SplitMix64>
{
public:
    using RandomFrom::RandomFrom;

    Vector3d inBall(double radius)
    {
        const double r = radius * std::cbrt(uniform(0.0, 1.0));
        return r * direction();
    }

    Eigen::Matrix3d rotation()
    {
        // Shoemake: uniform over all orientations.
        const double u = uniform(0.0, 1.0);
        const double a = uniform(0.0, 2.0 * pi);
        const double b = uniform(0.0, 2.0 * pi);
        const double s = std::sqrt(1.0 - u);
        const double r = std::sqrt(u);
        return Eigen::Quaterniond(
                   r * std::cos(b), s * std::sin(a), s * std::cos(a), r * std::sin(b))
            .toRotationMatrix();
    }
};

/// The two bodies of a set while its queries are drawn.
struct Bodies
{
    SsvTree a;
    SsvTree b;
    double radiusA = 0.0;  ///< farthest vertex from the model origin
    double radiusB = 0.0;
    double sizeB = 0.0;  ///< longest side of the bounds

    [[nodiscard]] bool overlap(const Isometry3d& X_WA, const Isometry3d& X_WB) const
    {
        // With a bound, only what is about to touch is opened.
        constexpr double kBound = 1e-9;
        return treeDistance(a, b, X_WB.inverse() * X_WA, kBound).distance <= 0.0;
    }
};

using Draw = std::function<std::optional<RigidQuery>(Random&, const Bodies&)>;

Isometry3d pose(const Eigen::Matrix3d& rotation, const Vector3d& position)
{
    Isometry3d X = Isometry3d::Identity();
    X.linear() = rotation;
    X.translation() = position;
    return X;
}

/// Moves A from far away towards the origin along -`direction` until it touches B, then back until
/// the surfaces at the contact are `gap` apart. None if A passes by.
std::optional<Isometry3d> placeAtGap(const Bodies& bodies,
                                     const Eigen::Matrix3d& rotationA,
                                     const Isometry3d& X_WB,
                                     const Vector3d& direction,
                                     double gap)
{
    const double far = bodies.radiusA + bodies.radiusB + 2.0 * gap;
    RigidMotion motion = restAt(pose(rotationA, far * direction));
    motion.v_W = -2.0 * far * direction;
    ToiWorkspace work;
    const ToiResult contact = rigidToi({.tree = &bodies.a, .motion = motion},
                                       {.tree = &bodies.b, .motion = restAt(X_WB)},
                                       {.tolerance = 1e-4 * gap},
                                       work);
    if (contact.status != ToiStatus::Hit)
    {
        return std::nullopt;
    }
    // In coarse steps, so that the set does not change with the last digits of the query.
    const double quantum = 1e-2 * gap;
    const double touching = far * (1.0 - 2.0 * contact.time);
    const double slope = std::max(0.2, -contact.normal.dot(direction));
    const double back = quantum * std::ceil((touching + gap / slope) / quantum);
    return pose(rotationA, back * direction);
}

/// A flies towards a point near B and ends before, at or behind it.
std::pair<Vector3d, Vector3d> flight(Random& random, const Bodies& bodies)
{
    const Vector3d from = random.uniform(0.9, 2.3) * bodies.radiusA * random.direction();
    const Vector3d aim = random.inBall(1.6 * bodies.radiusB);
    return {from, random.uniform(0.6, 1.3) * (aim - from)};
}

std::optional<RigidQuery> drawFlight(Random& random, const Bodies& bodies, double maxTurn)
{
    const auto [from, shift] = flight(random, bodies);
    RigidQuery query{.motionA = restAt(pose(random.rotation(), from)),
                     .motionB = restAt(pose(random.rotation(), Vector3d::Zero()))};
    query.motionA.v_W = shift;
    query.motionA.w_W = random.uniform(0.0, maxTurn) * random.direction();
    return query;
}

/// Begins at a gap of 0.3 to 7.5 % of the size and moves by a few such gaps.
std::optional<RigidQuery> drawNear(Random& random, const Bodies& bodies)
{
    const double gap = random.uniform(0.003, 0.075) * bodies.sizeB;
    const Vector3d direction = random.direction();
    const Isometry3d X_WB = pose(random.rotation(), Vector3d::Zero());
    const auto X_WA = placeAtGap(bodies, random.rotation(), X_WB, direction, gap);
    if (!X_WA)
    {
        return std::nullopt;
    }
    RigidQuery query{.motionA = restAt(*X_WA), .motionB = restAt(X_WB)};
    query.motionA.v_W = gap * (random.uniform(0.0, 2.5) * random.direction() - direction);
    query.motionA.w_W = gap / bodies.radiusA * random.uniform(0.0, 2.5) * random.direction();
    return query;
}

/// Rotation about the model origin by up to 120 degrees, begun close by.
std::optional<RigidQuery> drawRotation(Random& random, const Bodies& bodies)
{
    const double gap = random.uniform(0.003, 0.06) * bodies.sizeB;
    const Isometry3d X_WB = pose(random.rotation(), Vector3d::Zero());
    const auto X_WA = placeAtGap(bodies, random.rotation(), X_WB, random.direction(), gap);
    if (!X_WA)
    {
        return std::nullopt;
    }
    RigidQuery query{.motionA = restAt(*X_WA), .motionB = restAt(X_WB)};
    query.motionA.w_W = random.uniform(pi / 6.0, 2.0 * pi / 3.0) * random.direction();
    return query;
}

/// A finger closes about its joint, its own origin, more or less towards the middle of B.
std::optional<RigidQuery> drawFinger(Random& random, const Bodies& bodies)
{
    const Vector3d joint = random.uniform(0.4, 0.85) * bodies.radiusB * random.direction();
    const Vector3d finger = random.direction();  // +z of the mesh
    const Eigen::Matrix3d rotation =
        rotationBetween(Vector3d::UnitZ(), finger).toRotationMatrix() *
        AngleAxisd(random.uniform(0.0, 2.0 * pi), Vector3d::UnitZ()).toRotationMatrix();
    const Vector3d aim = random.inBall(0.5 * bodies.radiusB) - joint;
    const Vector3d axis = finger.cross(aim).normalized();
    RigidQuery query{.motionA = restAt(pose(rotation, joint)),
                     .motionB = restAt(pose(random.rotation(), Vector3d::Zero()))};
    query.motionA.w_W = random.uniform(0.2, 1.7) * axis;
    return query;
}

/// Tilt at which the crossing of two plates spans a part of the way.
/// Tilted: the tilt spans it where they face each other, their thickness comes on top.
/// Flat: tilt and thickness together; some plates are exactly parallel and meet everywhere at once.
double tunnelTilt(double span, double side, bool isFlat)
{
    constexpr double kBothThick = 0.4;
    constexpr double kFacing = 0.4;  // of the side: they overlap in part only
    return isFlat ? std::max(0.0, span - kBothThick) / side : span / (kFacing * side);
}

/// Two thin plates, nearly parallel, cross in 1/100 to 1/1000 of the motion.
std::optional<RigidQuery> drawTunnel(Random& random, const Bodies& bodies, bool isFlat)
{
    constexpr double kSide = 120.0;
    const double length = random.uniform(0.9, 3.3) * kSide;
    const double span = random.uniform(0.001, 0.01) * length;
    const double tilt = tunnelTilt(span, kSide, isFlat);
    const double inPlane = random.uniform(0.0, 2.0 * pi);
    const Vector3d tiltAxis(std::cos(inPlane), std::sin(inPlane), 0.0);
    const double when = random.uniform(0.1, 0.9);
    const Vector3d offset(
        random.uniform(-1.15, 1.15) * kSide, random.uniform(-1.15, 1.15) * kSide, 0.0);
    const Vector3d drift(
        random.uniform(-0.2, 0.2) * length, random.uniform(-0.2, 0.2) * length, 0.0);
    const Vector3d turn = random.uniform(0.0, 0.2) * random.direction();

    // In the frame of B; then both are turned together.
    const Isometry3d X_WB = pose(random.rotation(), random.inBall(0.5 * bodies.radiusB));
    const Eigen::Matrix3d crossing =
        (AngleAxisd(tilt, tiltAxis) * AngleAxisd(random.uniform(0.0, 2.0 * pi), Vector3d::UnitZ()))
            .toRotationMatrix();
    const double angle = -when * turn.norm();
    const Eigen::Matrix3d start =
        AngleAxisd(angle, turn.normalized()).toRotationMatrix() * crossing;
    const Vector3d velocity = length * Vector3d::UnitZ() + drift;
    RigidQuery query{.motionA = restAt(X_WB * pose(start, offset - when * velocity)),
                     .motionB = restAt(X_WB)};
    query.motionA.v_W = X_WB.linear() * velocity;
    query.motionA.w_W = X_WB.linear() * turn;
    return query;
}

/// How far the mesh reaches along a direction from its origin.
double reachOf(const SsvTree& tree, const Vector3d& direction)
{
    double reach = -std::numeric_limits<double>::infinity();
    for (const Vector3d& vertex : tree.mesh().vertices)
    {
        reach = std::max(reach, direction.dot(vertex));
    }
    return reach;
}

/// A lies on B and is pressed or lifted by a part of the gap, slides along it and turns, or falls
/// on it flat or almost. `segments` are those of a cylinder, which stands, lies on a face or on an
/// edge; 0 for bodies with a face below.
std::optional<RigidQuery> drawFlat(Random& random, const Bodies& bodies, int segments)
{
    Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
    if (segments > 0 && random.chance(0.6))
    {
        const double roll = random.chance(0.5) ? 0.0 : pi / segments;
        turned = (AngleAxisd(0.5 * pi, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitZ()))
                     .toRotationMatrix();
    }
    if (random.chance(0.7))
    {
        turned = AngleAxisd(random.uniform(0.0, 2.0 * pi), Vector3d::UnitZ()) * turned;
    }
    const Vector3d up = Vector3d::UnitZ();
    const double touching = reachOf(bodies.b, up) + reachOf(bodies.a, -(turned.transpose() * up));
    const double side = bodies.sizeB;
    const Vector3d aside(
        random.uniform(-0.4, 0.4) * side, random.uniform(-0.4, 0.4) * side, touching);

    double gap = random.logUniform(1e-7, 1e-2) * side;
    Vector3d velocity = random.uniform(-2.0, 1.0) * gap * up;
    Vector3d turn = Vector3d::Zero();
    switch (random.integer(0, 2))
    {
        case 0:
            break;
        case 1:
            velocity = side * Vector3d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.0);
            turn = random.uniform(0.0, 1.0) * up;
            break;
        default:
            gap = random.uniform(0.02, 1.0) * side;
            velocity = -random.uniform(0.7, 2.0) * gap * up;
            if (random.chance(0.5))
            {
                const double tilt = random.logUniform(1e-7, 1e-2);
                turned = AngleAxisd(tilt, Vector3d::UnitX()) * turned;
                gap += tilt * (bodies.radiusA + aside.norm());
            }
            break;
    }
    const Isometry3d X_WB = pose(random.rotation(), random.inBall(0.5 * bodies.radiusB));
    RigidQuery query{.motionA = restAt(X_WB * pose(turned, aside + gap * up)),
                     .motionB = restAt(X_WB)};
    query.motionA.v_W = X_WB.linear() * velocity;
    query.motionA.w_W = X_WB.linear() * turn;
    return query;
}

/// Both bodies fly and turn.
std::optional<RigidQuery> drawBoth(Random& random, const Bodies& bodies)
{
    std::optional<RigidQuery> query = drawFlight(random, bodies, 0.45 * pi);
    const Vector3d shift = random.inBall(0.5 * bodies.radiusB);
    query->motionB.v_W = shift;
    query->motionB.w_W = random.uniform(0.0, 0.45 * pi) * random.direction();
    query->motionA.v_W += shift;
    return query;
}

/// The relative motion of drawBoth() at its start and end, with B at rest.
std::optional<RigidQuery> drawBothAtRest(Random& random, const Bodies& bodies)
{
    RigidQuery query = *drawBoth(random, bodies);
    const Isometry3d X_BA = query.motionB.at(1.0).X_W.inverse() * query.motionA.at(1.0).X_W;
    const Isometry3d& X_WB = query.motionB.X_W0;
    query.motionA = motionBetween(query.motionA.X_W0, X_WB * X_BA);
    query.motionB = restAt(X_WB);
    return query;
}

/// Both seen from somewhere, turned together.
RigidQuery placed(Random& random, const Isometry3d& X_BA, const Vector3d& v, const Vector3d& w)
{
    const Isometry3d X_WB = pose(random.rotation(), random.inBall(50.0));
    RigidQuery query{.motionA = restAt(X_WB * X_BA), .motionB = restAt(X_WB)};
    query.motionA.v_W = X_WB.linear() * v;
    query.motionA.w_W = X_WB.linear() * w;
    return query;
}

/// Two gears in mesh turn against each other; one of three uses up the backlash.
std::optional<RigidQuery> drawGears(Random& random, const Bodies& /*bodies*/)
{
    const Vector3d axis = Vector3d::UnitZ();
    const AngleAxisd phase(pi + pi / 30.0, axis);
    const double turn = random.uniform(0.3, 1.5);
    RigidQuery query =
        placed(random,
               pose(phase.inverse().toRotationMatrix(),
                    phase.inverse() * Vector3d(-25.0, 0.0, random.uniform(-1.0, 1.0))),
               Vector3d::Zero(),
               (turn + random.uniform(-0.75, 0.75) * kGearBacklash / 10.0) * axis);
    query.motionB.w_W = query.motionB.X_W0.linear() * (-turn * 20.0 / 30.0 * axis);
    return query;
}

/// A ball turns in a shell and moves by a part of the clearance or a little more.
std::optional<RigidQuery> drawShells(Random& random, const Bodies& bodies)
{
    const double clearance = bodies.radiusB - bodies.radiusA;
    const Vector3d from = random.inBall(0.7 * clearance);
    const Vector3d to = random.inBall(1.2 * clearance);
    return placed(random,
                  pose(random.rotation(), from),
                  to - from,
                  random.uniform(0.3, 2.0) * random.direction());
}

/// A bolt turns in its nut; one of three moves too far along it.
std::optional<RigidQuery> drawScrews(Random& random, const Bodies& /*bodies*/)
{
    const double turn = random.uniform(-2.0, 2.0) * pi;
    const double slip = random.uniform(-1.0, 1.0) * kNutClearance;
    return placed(random,
                  pose(Eigen::Matrix3d::Identity(), random.inBall(0.1 * kNutClearance)),
                  (kPitch * turn / (2.0 * pi) + slip) * Vector3d::UnitZ(),
                  turn * Vector3d::UnitZ());
}

/// The blades of one comb slide between those of another.
std::optional<RigidQuery> drawCombs(Random& random, const Bodies& /*bodies*/)
{
    const double clearance = 0.5 * kCombPitch - 2.0 * kBlade;
    const Vector3d from(random.uniform(30.0, 65.0), random.uniform(-20.0, 20.0), 0.5 * kCombPitch);
    const Vector3d way(random.uniform(-60.0, 0.0),
                       random.uniform(-20.0, 20.0),
                       random.uniform(-1.2, 1.2) * clearance);
    return placed(random,
                  pose(Eigen::Matrix3d::Identity(), from),
                  way,
                  random.uniform(-1.0, 1.0) * clearance / 60.0 * random.direction());
}

/// Two links of a chain swing in each other.
std::optional<RigidQuery> drawLinks(Random& random, const Bodies& /*bodies*/)
{
    const Isometry3d X_BA = pose(random.rotation(), Vector3d(40.0, 0.0, 0.0) + random.inBall(20.0));
    return placed(random, X_BA, random.inBall(30.0), random.uniform(0.3, 2.0) * random.direction());
}

struct Recipe
{
    const char* name;
    const char* meshA;
    const char* meshB;
    int queries;
    std::uint64_t seed;
    Draw draw;
};

const std::vector<Recipe>& recipes()
{
    const auto flightOf = [](double maxTurn)
    {
        return [maxTurn](Random& random, const Bodies& bodies)
        { return drawFlight(random, bodies, maxTurn); };
    };
    const auto tunnelOf = [](bool isFlat)
    {
        return [isFlat](Random& random, const Bodies& bodies)
        { return drawTunnel(random, bodies, isFlat); };
    };
    const auto flatOf = [](int segments)
    {
        return [segments](Random& random, const Bodies& bodies)
        { return drawFlat(random, bodies, segments); };
    };
    static const std::vector<Recipe> kRecipes{
        {"bunny_random", "bunny", "bunny", 300, 1, flightOf(2.0 * pi / 3.0)},
        {"bunny_near", "bunny", "bunny", 200, 2, drawNear},
        {"bunny_rot", "bunny", "bunny", 100, 3, drawRotation},
        {"bunny_trans", "bunny", "bunny", 100, 4, flightOf(0.0)},
        {"finger", "finger", "bunny", 200, 5, drawFinger},
        {"tunnel", "plate", "plate", 200, 6, tunnelOf(false)},
        {"tunnel_flat", "plate", "plate", 200, 6, tunnelOf(true)},
        {"bunny_both", "bunny", "bunny", 200, 7, drawBoth},
        {"bunny_both_rest", "bunny", "bunny", 200, 7, drawBothAtRest},
        {"pass_knot_1k", "knot_1k", "knot_1k", 200, 8, flightOf(2.0)},
        {"pass_knot_4k", "knot_4k", "knot_4k", 200, 8, flightOf(2.0)},
        {"pass_knot_16k", "knot_16k", "knot_16k", 200, 8, flightOf(2.0)},
        {"pass_knot_64k", "knot_64k", "knot_64k", 200, 8, flightOf(2.0)},
        {"near_knot_16k", "knot_16k", "knot_16k", 200, 9, drawNear},
        {"pass_sphere_20k", "sphere_20k", "sphere_20k", 200, 10, flightOf(2.0)},
        {"pass_torus", "torus", "torus", 200, 11, flightOf(2.0)},
        {"pass_cylinder", "cylinder", "cylinder", 200, 12, flightOf(2.0)},
        {"flat_plate_1k", "flat_plate_1k", "flat_plate_1k", 60, 13, flatOf(0)},
        {"flat_plate_10k", "flat_plate_10k", "flat_plate_10k", 60, 13, flatOf(0)},
        {"flat_plate_100k", "flat_plate_100k", "flat_plate_100k", 60, 13, flatOf(0)},
        {"flat_box_1k", "flat_box_1k", "flat_box_1k", 60, 14, flatOf(0)},
        {"flat_box_10k", "flat_box_10k", "flat_box_10k", 60, 14, flatOf(0)},
        {"flat_box_100k", "flat_box_100k", "flat_box_100k", 60, 14, flatOf(0)},
        {"flat_cylinder_1k", "flat_cylinder_1k", "flat_plate_1k", 60, 15, flatOf(24)},
        {"flat_cylinder_10k", "flat_cylinder_10k", "flat_plate_10k", 60, 15, flatOf(72)},
        {"flat_cylinder_100k", "flat_cylinder_100k", "flat_plate_100k", 60, 15, flatOf(228)},
        {"worst_gears", "gear_20", "gear_30", 20, 16, drawGears},
        {"worst_shells_02", "ball", "shell_02", 12, 17, drawShells},
        {"worst_shells_2", "ball", "shell_2", 20, 17, drawShells},
        {"worst_screws", "bolt", "nut", 20, 18, drawScrews},
        {"worst_combs", "comb", "comb", 20, 19, drawCombs},
        {"worst_links", "link", "link", 20, 20, drawLinks},
    };
    return kRecipes;
}
}  // namespace

const std::vector<std::string>& generatedSetNames()
{
    static const std::vector<std::string> kNames = []
    {
        std::vector<std::string> names;
        for (const Recipe& recipe : recipes())
        {
            names.emplace_back(recipe.name);
        }
        return names;
    }();
    return kNames;
}

RigidSet generateSet(const std::string& name, MeshLibrary& meshes, std::uint64_t seedShift)
{
    const auto found = std::ranges::find(recipes(), name, &Recipe::name);
    if (found == recipes().end())
    {
        throw std::invalid_argument("generated set '" + name + "' is unknown");
    }
    RigidSet set{
        .name = name, .meshA = meshes.mesh(found->meshA), .meshB = meshes.mesh(found->meshB)};
    const Eigen::Vector3d sizes = bounds(*set.meshB).sizes();
    const Bodies bodies{.a = buildSsvTree(*set.meshA),
                        .b = buildSsvTree(*set.meshB),
                        .radiusA = reference::radiusOf(*set.meshA),
                        .radiusB = reference::radiusOf(*set.meshB),
                        .sizeB = sizes.maxCoeff()};
    Random random((found->seed + seedShift) * 1'000'003);
    while (static_cast<int>(set.queries.size()) < found->queries)
    {
        std::optional<RigidQuery> query = found->draw(random, bodies);
        if (!query || bodies.overlap(query->motionA.X_W0, query->motionB.X_W0))
        {
            continue;
        }
        query->id = static_cast<std::int32_t>(set.queries.size());
        set.queries.push_back(*query);
    }
    return set;
}
}  // namespace bullet_ccd::benchmarks
