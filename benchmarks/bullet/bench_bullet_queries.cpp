#include "benchmarks/bullet/bench_bullet_queries.h"

#include "benchmarks/reference/bullet/missiles.h"
#include "benchmarks/reference/oracles/toi_certificate.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Vector3d;
using reference::Random;

constexpr double kSize = 0.05;    // half, of the bodies
constexpr double kMargin = 1e-4;  // of hulls, boxes and meshes
constexpr double kLate = 2e-4;    // what rounded corners explain, on the way [m]
constexpr double kApart = 2e-3;

QueryBody boxBody(const Vector3d& half)
{
    return {.mesh = makeBox(half),
            .shape = [half]
            {
                auto shape = std::make_unique<btBoxShape>(btCcdToBullet(half));
                shape->setMargin(btScalar(kMargin));
                return shape;
            }};
}

QueryBody sphereBody()
{
    return {.mesh = reference::triangle(Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()),
            .radius = kSize,
            .shape = [] { return std::make_unique<btSphereShape>(btScalar(kSize)); }};
}

QueryBody capsuleBody()
{
    const double radius = 0.4 * kSize;
    return {.mesh = reference::segment({0, -kSize, 0}, {0, kSize, 0}),
            .radius = radius,
            .shape = [radius]
            { return std::make_unique<btCapsuleShape>(btScalar(radius), btScalar(2 * kSize)); }};
}

/// An ellipsoid of 42 corners: the hull of its corners is itself.
QueryBody hullBody(const Vector3d& halfAxes)
{
    TriangleMesh mesh = makeSphere(1.0, 1);
    for (Vector3d& v : mesh.vertices)
    {
        v = v.cwiseProduct(halfAxes);
    }
    return {.mesh = mesh,
            .radius = kMargin,
            .shape = [mesh]
            {
                auto shape = std::make_unique<btConvexHullShape>();
                for (const Vector3d& v : mesh.vertices)
                {
                    shape->addPoint(btCcdToBullet(v), false);
                }
                shape->recalcLocalAabb();
                shape->setMargin(btScalar(kMargin));
                return shape;
            }};
}

QueryBody torusBody()
{
    const TriangleMesh mesh = makeTorus(0.8 * kSize, 0.3 * kSize, 12, 8);
    return {.mesh = mesh,
            .shape =
                [mesh]
            {
                return std::make_unique<btCcdMeshShape>(
                    std::make_shared<const SsvTree>(buildSsvTree(mesh)), btScalar(kMargin));
            },
            .gimpact = [mesh] { return reference::makeGimpactShape(mesh, kMargin); }};
}

BulletQuery randomQuery(Random& random, bool turning)
{
    BulletQuery query;
    query.X_WB.linear() = random.rotation();
    const Vector3d from = 0.3 * random.direction();
    query.motionA.X_W0.linear() = random.rotation();
    query.motionA.X_W0.translation() = from;
    query.motionA.v_W = 2.0 * (random.inBox(1.6 * kSize) - from);
    if (turning)
    {
        query.motionA.w_W = random.uniform(0.2, 0.75) * random.direction();
    }
    return query;
}

/// The answer, from a query with a tolerance far below that of all methods; false if the oracle
/// does not prove it.
bool answer(const QueryFamily& family, const SsvTree& a, const SsvTree& b, BulletQuery& query)
{
    const ToiOptions options{.tolerance = 1e-9,
                             .minimumSeparation = family.a.radius + family.b.radius};
    ToiWorkspace work;
    const RigidMotion rest = restAt(query.X_WB);
    const ToiResult result = rigidToi(
        {.tree = &a, .motion = query.motionA}, {.tree = &b, .motion = rest}, options, work);
    const reference::RigidScene scene{
        .meshA = family.a.mesh, .meshB = family.b.mesh, .motionA = query.motionA, .motionB = rest};
    query.hit = result.status == ToiStatus::Hit;
    query.time = result.time;
    query.gap = result.gap - options.minimumSeparation;
    return (query.hit || result.status == ToiStatus::Separated) &&
           reference::judgeToi(scene, options, result).verdict == reference::Verdict::Right;
}

void addQueries(QueryFamily& family, int count, bool turning, Random& random)
{
    const SsvTree a = buildSsvTree(family.a.mesh);
    const SsvTree b = buildSsvTree(family.b.mesh);
    for (int i = 0; i < count; ++i)
    {
        BulletQuery query = randomQuery(random, turning);
        if (answer(family, a, b, query))
        {
            family.queries.push_back(query);
        }
        else
        {
            ++family.dropped;
        }
    }
}

/// What was wrong with the answers of a method; lengths are on the way [m].
struct Tally
{
    int hits = 0;
    int missed = 0;
    int late = 0;
    int falseHits = 0;
    double latest = 0.0;
    double error = 0.0;  ///< sum
};

void judge(const BulletQuery& query, const CastAnswer& answer, Tally& row)
{
    const double way = query.motionA.v_W.norm();
    if (!query.hit)
    {
        row.falseHits += answer.hit && query.gap > kApart ? 1 : 0;
        return;
    }
    if (!answer.hit)
    {
        ++row.missed;
        return;
    }
    ++row.hits;
    row.late += (answer.time - query.time) * way > kLate ? 1 : 0;
    row.latest = std::max(row.latest, (answer.time - query.time) * way);
    row.error += std::abs(answer.time - query.time) * way;
}
}  // namespace

std::vector<QueryFamily> queryFamilies(int count, std::uint64_t seed)
{
    const Vector3d box(kSize, 0.7 * kSize, 0.4 * kSize);
    const Vector3d plate(kSize, kSize, 2.5e-4);
    const Vector3d ellipsoid(kSize, 0.6 * kSize, 0.4 * kSize);
    std::vector<QueryFamily> families;
    Random random(seed);
    for (const bool turning : {false, true})
    {
        const auto add = [&](const char* name, QueryBody a, QueryBody b, bool convex)
        {
            QueryFamily family{.name = std::string(name) + (turning ? ", turning" : ""),
                               .a = std::move(a),
                               .b = std::move(b),
                               .convex = convex};
            addQueries(family, count, turning, random);
            families.push_back(std::move(family));
        };
        add("box x box", boxBody(box), boxBody(box), true);
        add("sphere x box", sphereBody(), boxBody(box), true);
        add("box x thin plate", boxBody(box), boxBody(plate), true);
        add("hull x hull", hullBody(ellipsoid), hullBody(ellipsoid), true);
        add("capsule x box", capsuleBody(), boxBody(box), true);
        add("mesh x mesh", torusBody(), torusBody(), false);
    }
    return families;
}

std::vector<nlohmann::json> runFamily(const QueryFamily& family, int repeats)
{
    const std::vector<CastMethod> methods = castMethods(family);
    std::vector<nlohmann::json> rows;
    std::vector<TimedMethod> timed;
    for (const CastMethod& method : methods)
    {
        Tally tally;
        for (const BulletQuery& query : family.queries)
        {
            method.prepare(query);
            judge(query, method.ask(), tally);
        }
        rows.push_back({{"pair", family.name},
                        {"method", method.name},
                        {"queries", family.queries.size()},
                        {"hits", tally.hits},
                        {"missed", tally.missed},
                        {"late", tally.late},
                        {"false", tally.falseHits},
                        {"latest", 1e3 * tally.latest},
                        {"error", 1e3 * tally.error / std::max(1, tally.hits)}});
        timed.push_back({.queries = family.queries.size(),
                         .passes = repeats,
                         .ask = [&](std::size_t) { keep(method.ask().time); },
                         .prepare = [&](std::size_t i) { method.prepare(family.queries[i]); }});
    }
    const std::vector<std::vector<double>> micros = timeInTurns(timed);
    for (std::size_t m = 0; m < rows.size(); ++m)
    {
        rows[m]["us"] = meanOf(micros[m]);
    }
    return rows;
}
}  // namespace bullet_ccd::benchmarks
