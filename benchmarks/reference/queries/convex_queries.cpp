#include "benchmarks/reference/queries/convex_queries.h"

#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;

TriangleMesh boxMeshOf(const Vector3d& half)
{
    return box(-half, half);
}

MeshedShape meshedBox(const Vector3d& half)
{
    return {.shape = boxShape(half), .inner = boxMeshOf(half), .outer = boxMeshOf(half)};
}

MeshedShape meshedPoint()
{
    const TriangleMesh mesh = triangle(Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero());
    return {.shape = sphereShape(0.0), .inner = mesh, .outer = mesh};
}

MeshedShape meshedSegment(double half)
{
    const TriangleMesh mesh = segment({0.0, 0.0, -half}, {0.0, 0.0, half});
    return {.shape = capsuleShape(0.0, half), .inner = mesh, .outer = mesh};
}

/// An affine image of a polyhedron is convex, and its faces are known.
MeshedShape meshedHull(Random& random)
{
    const int kind = random.integer(0, 3);
    TriangleMesh mesh;
    if (kind == 0)
    {
        mesh.vertices = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
        mesh.triangles = {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}};
    }
    else
    {
        mesh = kind == 1 ? octahedron() : makeSphere(1.0, kind - 2);
    }
    const Eigen::Matrix3d stretch =
        Vector3d(random.uniform(0.2, 1.0), random.uniform(0.2, 1.0), random.uniform(0.2, 1.0))
            .asDiagonal();
    const Eigen::Matrix3d affine = random.rotation() * stretch * random.rotation();
    const Vector3d shift = random.inBox(0.3);
    for (Vector3d& v : mesh.vertices)
    {
        v = affine * v + shift;
    }
    return {.shape = hullShape(mesh.vertices), .inner = mesh, .outer = mesh};
}

/// Prisms and pyramids whose sides are inside or outside the surface.
MeshedShape meshedRound(Random& random)
{
    constexpr int kSides = 16;
    const double radius = random.uniform(0.2, 1.0);
    const double half = random.uniform(0.2, 1.0);
    const double wider = radius / std::cos(std::numbers::pi / kSides) * (1.0 + 1e-12);
    if (random.chance(0.5))
    {
        return {.shape = cylinderShape(radius, half),
                .inner = makeCylinder(radius, 2.0 * half, kSides),
                .outer = makeCylinder(wider, 2.0 * half, kSides)};
    }
    const auto cone = [&](double r) {
        return makeRevolved({{0.0, -half}, {r, -half}, {0.0, half}}, kSides);
    };
    return {.shape = coneShape(radius, half), .inner = cone(radius), .outer = cone(wider)};
}

Vector3d boxSize(Random& random)
{
    return {random.uniform(0.2, 1.0), random.uniform(0.2, 1.0), random.uniform(0.2, 1.0)};
}

MeshedShape roundedShape(Random& random)
{
    MeshedShape shape;
    switch (random.integer(0, 3))
    {
        case 0:
            shape = meshedPoint();
            break;
        case 1:
            shape = meshedSegment(random.uniform(0.1, 1.0));
            break;
        case 2:
            shape = meshedBox(boxSize(random));
            break;
        default:
            shape = meshedHull(random);
            break;
    }
    shape.shape = shape.shape.rounded(random.uniform(0.01, 0.5));
    return shape;
}

MeshedShape anyPolyhedron(Random& random)
{
    return random.chance(0.5) ? meshedBox(boxSize(random)) : meshedHull(random);
}

/// A comes from a few sizes away and passes within `spread` of B; both turn.
void fly(Random& random, double turn, double spread, ConvexQueryCase& query)
{
    RigidMotion& a = query.motions[0];
    RigidMotion& b = query.motions[1];
    a.X_W0.linear() = random.rotation();
    b.X_W0.linear() = random.rotation();
    a.X_W0.translation() = 5.0 * random.direction();
    b.X_W0.translation() = random.inBox(0.1);
    a.v_W = 1.6 * (random.inBox(spread) - a.X_W0.translation());
    b.v_W = random.inBox(0.5);
    a.w_W = random.uniform(0.0, turn) * random.direction();
    b.w_W = random.uniform(0.0, turn) * random.direction();
}

/// Parallel edges, quarter turns, and velocities along the axes.
void flyFlat(Random& random, ConvexQueryCase& query)
{
    const int across = random.integer(0, 2);
    RigidMotion& a = query.motions[0];
    Vector3d start = random.inBox(random.chance(0.5) ? 0.0 : 1.0);
    start[across] = random.uniform(1.0, 4.0);
    a.X_W0.translation() = start;
    a.v_W = -random.uniform(1.0, 6.0) * Vector3d::Unit(across);
    if (random.chance(0.5))
    {
        a.v_W += random.inBox(1.0);
    }
    if (random.chance(0.5))
    {
        const double turn = 0.5 * std::numbers::pi * random.integer(1, 4);
        a.w_W = turn * Vector3d::Unit(random.integer(0, 2));
    }
    const Eigen::Isometry3d X = random.pose(2.0);
    a = moved(a, X);
    query.motions[1] = moved(query.motions[1], X);
}

void coMove(Random& random, ConvexQueryCase& query)
{
    const Vector3d axis = random.uniform(0.0, 6.0) * random.direction();
    const Vector3d reference = random.inBox(1.0);  // about which both turn
    const Vector3d v = random.inBox(5.0);
    for (std::size_t side = 0; side < 2; ++side)
    {
        RigidMotion& m = query.motions[side];
        m.X_W0 = random.pose(side == 0 ? 1.0 : 0.1);
        if (side == 0)
        {
            m.X_W0.translation() += 2.0 * random.direction();
        }
        m.v_W = v + (side == 0 ? random.inBox(1.5) : Vector3d(Vector3d::Zero()));
        m.w_W = axis + random.inBox(random.chance(0.3) ? 0.0 : 0.3);
        m.reference_B = m.X_W0.inverse() * reference;
    }
}

/// Moves A along the line between the closest points until the shapes are that far apart.
void approach(ConvexQueryCase& query, double distance)
{
    constexpr int kSteps = 6;
    const double radii = query.shapes[0].shape.radius + query.shapes[1].shape.radius;
    for (int i = 0; i < kSteps; ++i)
    {
        const InstantDistance d = instantDistance(coreScene(query), 0.0);
        if (d.distance == 0.0)
        {
            return;
        }
        query.motions[0].X_W0.translation() +=
            (1.0 - (distance + radii) / d.distance) * (d.pointB - d.pointA);
    }
}

void overGround(Random& random, ConvexQueryCase& query)
{
    const Eigen::Isometry3d X = random.pose(1.0);
    constexpr double kWide = 50.0;
    query.shapes[1].inner = floorAt(0.0, kWide);
    query.shapes[1].outer = query.shapes[1].inner;
    query.shapes[1].shape = halfSpaceShape(Vector3d::UnitZ(), 0.0);
    RigidMotion& a = query.motions[0];
    RigidMotion& b = query.motions[1];
    b.X_W0.setIdentity();
    a.X_W0 = random.pose(1.0);
    a.X_W0.translation().z() = random.uniform(2.5, 4.0);
    a.v_W =
        Vector3d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-4.0, 0.0));
    a.w_W = random.uniform(0.0, 5.0) * random.direction();
    b.v_W = random.uniform(-0.5, 0.5) * Vector3d::UnitZ();
    b.w_W = random.uniform(0.0, 0.6) * random.direction();
    for (RigidMotion& m : query.motions)
    {
        m = moved(m, X);
    }
}

bool isInside(const Vector3d& point, const TriangleMesh& mesh)
{
    return std::ranges::all_of(mesh.triangles,
                               [&](const Triangle& t)
                               {
                                   const auto corner = [&](std::size_t k) -> const Vector3d&
                                   { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
                                   const Vector3d normal =
                                       (corner(1) - corner(0)).cross(corner(2) - corner(0));
                                   return normal.dot(point - corner(0)) <= 0.0;
                               });
}

/// At t = 0, one core inside the other: solids overlap where surfaces do not.
bool isContained(const RigidScene& scene)
{
    const Eigen::Isometry3d X_BA = scene.motionB.X_W0.inverse() * scene.motionA.X_W0;
    return isInside(X_BA * scene.meshA.vertices.front(), scene.meshB) ||
           isInside(X_BA.inverse() * scene.meshB.vertices.front(), scene.meshA);
}

/// A round shape is at least as large as the mesh in it and at most as large as the one around it.
Judgement judgeRound(const ConvexQueryCase& query,
                     const ToiOptions& options,
                     const ToiResult& result)
{
    ToiOptions asGivenUp = options;
    asGivenUp.maxIterations = 1;
    ToiResult inner = result;
    inner.status = ToiStatus::IterationLimit;
    const bool isFree =
        result.status == ToiStatus::Separated || result.status == ToiStatus::TouchingLeaving;
    Judgement judgement = judgeToi(coreScene(query), asGivenUp, inner);
    if (judgement.verdict == Verdict::Late && isFree)
    {
        judgement.verdict = Verdict::Missed;
    }
    if (judgement.verdict == Verdict::Right && gaveUp(result.status))
    {
        judgement.verdict = Verdict::GaveUp;
    }
    if (judgement.verdict == Verdict::Right && isContact(result.status))
    {
        const double nearest = instantDistance(coreScene(query, true), result.time).distance;
        const double reach = result.status == ToiStatus::Overlapping ? 0.0 : options.tolerance;
        judgement.verdict = nearest > options.minimumSeparation + reach ? Verdict::False
                            : nearest > result.gap + 1e-12              ? Verdict::WrongGap
                                                                        : Verdict::Right;
        judgement.time = result.time;
        judgement.distance = nearest;
    }
    return judgement;
}
}  // namespace

std::vector<std::string> convexFamilyNames()
{
    return {"boxes",
            "spinning",
            "thin",
            "hulls",
            "rounded",
            "flat",
            "co-moving",
            "off-centre",
            "clearance",
            "start touching",
            "ground",
            "round"};
}

ConvexQueryCase randomBoxes(std::uint64_t seed, double turn)
{
    Random random(seed);
    ConvexQueryCase query;
    query.shapes = {meshedBox(boxSize(random)), meshedBox(boxSize(random))};
    constexpr double kSpread = 2.5;  // about half of them hit
    fly(random, turn, kSpread, query);
    query.options.tolerance = 1e-4;
    return query;
}

ConvexQueryCase convexQuery(std::uint64_t seed)
{
    Random random(seed);
    ConvexQueryCase query;
    query.family = static_cast<ConvexFamily>(seed % kConvexFamilies);
    query.options.tolerance = random.logUniform(1e-7, 1e-3);
    query.shapes = {meshedBox(boxSize(random)), meshedBox(boxSize(random))};
    constexpr double kTurn = 2.6;
    constexpr double kSpread = 2.0;
    fly(random, kTurn, kSpread, query);
    switch (query.family)
    {
        case ConvexFamily::Boxes:
            break;
        case ConvexFamily::Spinning:
            fly(random, 20.0, kSpread, query);
            break;
        case ConvexFamily::Thin:
            for (MeshedShape& shape : query.shapes)
            {
                const auto size = [&] { return random.logUniform(1e-3, 1.0); };
                shape = meshedBox({random.uniform(0.5, 1.0), size(), size()});
            }
            fly(random, kTurn, 0.5, query);
            break;
        case ConvexFamily::Hulls:
            query.shapes = {anyPolyhedron(random), meshedHull(random)};
            break;
        case ConvexFamily::Rounded:
            query.shapes = {roundedShape(random), roundedShape(random)};
            break;
        case ConvexFamily::Flat:
            query.motions = {};
            flyFlat(random, query);
            break;
        case ConvexFamily::CoMoving:
            coMove(random, query);
            break;
        case ConvexFamily::OffCentre:
            for (std::size_t side = 0; side < 2; ++side)
            {
                query.X_BG[side] = random.pose(0.5);
                query.motions[side].reference_B = random.inBox(0.5);
            }
            break;
        case ConvexFamily::Clearance:
            query.shapes = {anyPolyhedron(random), anyPolyhedron(random)};
            query.options.minimumSeparation = random.logUniform(1e-6, 0.3);
            break;
        case ConvexFamily::StartTouching:
            query.shapes = {anyPolyhedron(random), roundedShape(random)};
            query.motions[0].v_W = random.inBox(1.0);
            approach(query, random.uniform(0.01, 0.99) * query.options.tolerance);
            break;
        case ConvexFamily::Ground:
            query.shapes[0] = roundedShape(random);
            overGround(random, query);
            break;
        case ConvexFamily::Round:
            query.shapes[0] = meshedRound(random);
            if (random.chance(0.5))
            {
                query.shapes[1] = meshedRound(random);
            }
            break;
    }
    return query;
}

RigidScene coreScene(const ConvexQueryCase& query, bool outer)
{
    const auto mesh = [&](std::size_t side)
    {
        const MeshedShape& shape = query.shapes[side];
        return placed(outer ? shape.outer : shape.inner, query.X_BG[side]);
    };
    return {.meshA = mesh(0),
            .meshB = mesh(1),
            .motionA = query.motions[0],
            .motionB = query.motions[1]};
}

Judgement judgeConvex(const ConvexQueryCase& query, const ToiResult& result)
{
    // Shapes swept by balls come within s where their cores come within s and the radii.
    const double radii = query.shapes[0].shape.radius + query.shapes[1].shape.radius;
    ToiOptions options = query.options;
    options.minimumSeparation += radii;
    ToiResult ofCores = result;
    ofCores.gap += radii;
    if (query.family == ConvexFamily::Round)
    {
        return judgeRound(query, options, ofCores);
    }
    const RigidScene scene = coreScene(query);
    if (result.status == ToiStatus::Overlapping && query.family != ConvexFamily::Ground &&
        isContained(scene))
    {
        return {};
    }
    return judgeToi(scene, options, ofCores);
}

void print(std::ostream& out, const ConvexQueryCase& query)
{
    out.precision(17);
    for (std::size_t side = 0; side < 2; ++side)
    {
        const ConvexShape& shape = query.shapes[side].shape;
        const RigidMotion& m = query.motions[side];
        out << "core " << static_cast<int>(shape.core) << " half " << shape.half.transpose()
            << " radius " << shape.radius << "\nX_BG\n"
            << query.X_BG[side].matrix() << "\nX_W0\n"
            << m.X_W0.matrix() << "\nv " << m.v_W.transpose() << " w " << m.w_W.transpose()
            << " reference " << m.reference_B.transpose() << '\n';
    }
    out << "tolerance " << query.options.tolerance << " minimum separation "
        << query.options.minimumSeparation << '\n';
}
}  // namespace bullet_ccd::reference
