#include "benchmarks/stability/catalogue_methods.h"

#include "benchmarks/reference/queries/soak_queries.h"

#include <algorithm>
#include <array>
#include <set>

namespace bullet_ccd::tests
{
namespace
{
/// Corners that triangles use, once each.
std::vector<Eigen::Vector3d> cornersInUse(const TriangleMesh& mesh)
{
    std::set<std::array<double, 3>> seen;
    std::vector<Eigen::Vector3d> corners;
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t index : t)
        {
            const Eigen::Vector3d& v = mesh.vertices[static_cast<std::size_t>(index)];
            if (seen.insert({v.x(), v.y(), v.z()}).second)
            {
                corners.push_back(v);
            }
        }
    }
    return corners;
}

std::string notConvex(const RigidCase& tested)
{
    if (tested.nested)
    {
        return "hulls overlap from the start";
    }
    return isConvex(tested.scene.meshA) && isConvex(tested.scene.meshB) ? "" : "not convex";
}

std::string notConvexOrTurns(const RigidCase& tested)
{
    const bool turns =
        !tested.scene.motionA.w_W.isZero(0.0) || !tested.scene.motionB.w_W.isZero(0.0);
    return turns ? "translations only" : notConvex(tested);
}

template <typename Case>
void addOurs(std::vector<Method<Case>>& all)
{
    for (const ToiStrategy strategy :
         {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
    {
        all.push_back({.name = nameOf(strategy),
                       .owner = "ours",
                       .setting = "the case's finest tolerance",
                       .run = [strategy](const Case& tested) { return ours(tested, strategy); }});
    }
}

template <typename Case>
Method<Case> sampling(const std::string& name,
                      const std::string& owner,
                      int steps,
                      PeerAnswer (*run)(const Case&, int))
{
    return {.name = name + " x" + std::to_string(steps),
            .owner = owner,
            .setting = std::to_string(steps) + " steps",
            .run = [run, steps](const Case& tested) { return run(tested, steps); }};
}
}  // namespace

std::vector<Method<RigidCase>> rigidMethods()
{
    std::vector<Method<RigidCase>> all;
    addOurs(all);
    if (hasFcl())
    {
        all.push_back({.name = "FCL advancement",
                       .owner = "fcl",
                       .setting = "CCDC_CONSERVATIVE_ADVANCEMENT, toc_err 1e-6",
                       .run = fclAdvancement});
        for (const int steps : {97, 997, 9973})
        {
            all.push_back(sampling<RigidCase>("FCL sampling", "fcl", steps, fclSampling));
        }
    }
    if (hasBullet())
    {
        const auto cast = [&](const char* name, const char* setting, BulletCast kind, auto cannot)
        {
            all.push_back(
                {.name = name,
                 .owner = "bullet",
                 .setting = setting,
                 .run = [kind](const RigidCase& tested) { return bulletCast(tested, kind); },
                 .notApplicable = cannot});
        };
        cast("Bullet continuous",
             "btContinuousConvexCollision, margin 0",
             BulletCast::Continuous,
             notConvex);
        cast("Bullet subsimplex",
             "btSubsimplexConvexCast, margin 0",
             BulletCast::Subsimplex,
             notConvexOrTurns);
        cast("Bullet GJK cast", "btGjkConvexCast, margin 0", BulletCast::Gjk, notConvexOrTurns);
        for (const int steps : {59, 241})
        {
            all.push_back(sampling<RigidCase>("Bullet discrete", "bullet", steps, bulletSampling));
            all.back().setting += ", as a world at that rate";
            all.back().notApplicable = notConvex;
        }
    }
    return all;
}

std::vector<Method<ArticulatedCase>> articulatedMethods()
{
    std::vector<Method<ArticulatedCase>> all;
    addOurs(all);
    for (const int steps : {59, 241, 997, 9973})
    {
        all.push_back(
            sampling<ArticulatedCase>("exact distance", "sampled", steps, distanceSampling));
    }
    for (const int steps : {241, 997})
    {
        if (hasFcl())
        {
            all.push_back(sampling<ArticulatedCase>("FCL overlap", "fcl", steps, fclSampling));
        }
    }
    return all;
}

bool isConvex(const TriangleMesh& mesh)
{
    const std::vector<Eigen::Vector3d> corners = cornersInUse(mesh);
    if (corners.size() <= 3 || (corners.size() == 4 && mesh.triangles.size() == 2))
    {
        return true;
    }
    TriangleMesh merged = mesh;
    repairMesh(merged);
    const double size = bounds(mesh).diagonal().norm();
    const auto isOutside = [&](const Triangle& t)
    {
        const auto at = [&](std::size_t k)
        { return merged.vertices[static_cast<std::size_t>(t[k])]; };
        const Eigen::Vector3d n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
        return std::all_of(corners.begin(),
                           corners.end(),
                           [&](const Eigen::Vector3d& v)
                           { return n.dot(v - at(0)) <= 1e-9 * size; });
    };
    return isWatertight(merged) &&
           std::all_of(merged.triangles.begin(), merged.triangles.end(), isOutside);
}
}  // namespace bullet_ccd::tests
