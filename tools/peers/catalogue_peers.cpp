/// Every rigid case of the stability catalogue through this library, FCL and Bullet; prints a
/// Markdown table of verdicts.
#include "tests/stability/cases.h"
#include "tests/support/random_scenes.h"
#include "tests/support/soak_queries.h"
#include "tools/peers/isolated.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::tests;

/// What a code that steps in time is allowed to be early: the resolution that it is asked for.
constexpr double kAllowedTime = 1e-4;
/// Rounding of times; beyond it an answer after the contact is late.
constexpr double kLate = 1e-9;

struct Method
{
    std::string name;
    std::function<PeerAnswer(const RigidCase&)> run;
    bool needsConvex = false;
};

PeerAnswer ours(const RigidCase& tested, ToiStrategy strategy)
{
    const double tolerance = tested.answer.tolerances.back() * tested.answer.length;
    const ToiResult result = queryToi(tested.scene, {.tolerance = tolerance, .strategy = strategy});
    return {.contact = isContact(result.status), .time = result.time};
}

std::vector<Method> methods()
{
    std::vector<Method> all;
    for (const ToiStrategy strategy :
         {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
    {
        all.push_back({.name = std::string("bullet_ccd ") + nameOf(strategy),
                       .run = [strategy](const RigidCase& c) { return ours(c, strategy); }});
    }
    if (hasFcl())
    {
        all.push_back({.name = "FCL, 1,001 samples",
                       .run = [](const RigidCase& c) { return fclSampling(c.scene); }});
        all.push_back({.name = "FCL, conservative advancement",
                       .run = [](const RigidCase& c) { return fclAdvancement(c.scene); }});
    }
    if (hasBullet())
    {
        all.push_back({.name = "Bullet, convex cast",
                       .run = [](const RigidCase& c) { return bulletConvexCast(c.scene); },
                       .needsConvex = true});
    }
    return all;
}

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

/// True for closed convex surfaces and for single triangles, segments, points and rectangles: for
/// what is the same to a query as its convex hull, as long as the other body is outside.
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
    return isWatertight(merged) &&
           std::all_of(merged.triangles.begin(),
                       merged.triangles.end(),
                       [&](const Triangle& t)
                       {
                           const auto at = [&](std::size_t k)
                           { return merged.vertices[static_cast<std::size_t>(t[k])]; };
                           const Eigen::Vector3d n =
                               (at(1) - at(0)).cross(at(2) - at(0)).normalized();
                           return std::all_of(corners.begin(),
                                              corners.end(),
                                              [&](const Eigen::Vector3d& v)
                                              { return n.dot(v - at(0)) <= 1e-9 * size; });
                       });
}

/// Cases in which a body starts inside the other, so that hulls overlap where surfaces do not.
bool isNested(const RigidCase& tested)
{
    return tested.id == "B14";
}

std::string verdictOf(const IsolatedAnswer& isolated, const CaseAnswer& exact)
{
    if (isolated.ending != Ending::Answered)
    {
        return isolated.ending == Ending::Crashed ? "crashed" : "timed out";
    }
    const PeerAnswer& answer = isolated.answer;
    const double tolerance = exact.tolerances.back() * exact.length;
    if (!exact.time)
    {
        return answer.contact && exact.clearance > 1.001 * tolerance ? "false contact" : "pass";
    }
    if (!answer.contact)
    {
        return "missed";
    }
    std::array<char, 64> text{};
    const double error = answer.time - *exact.time;
    const double allowed = std::max(kAllowedTime, 1.1 * leadTime(exact, tolerance));
    if (std::isnan(error) || error > kLate)
    {
        std::snprintf(text.data(), text.size(), "late %.1e", error);
        return text.data();
    }
    if (error < -allowed)
    {
        std::snprintf(text.data(), text.size(), "early %.1e", -error);
        return text.data();
    }
    return "pass";
}

/// The same motion at that part of its speed: the contact comes later by the inverse. Many of the
/// catalogue's times are multiples of 1/1000 and so fall on a sample by luck.
RigidCase slowed(RigidCase tested, double factor)
{
    for (RigidMotion* motion : {&tested.scene.motionA, &tested.scene.motionB})
    {
        motion->v_W *= factor;
        motion->w_W *= factor;
    }
    if (tested.answer.time)
    {
        tested.answer.time = *tested.answer.time / factor;
        tested.answer.closingSpeed *= factor;
        tested.answer.closingAcceleration *= factor * factor;
    }
    return tested;
}

struct Table
{
    double limit = 10.0;
    double slow = 1.0;
    std::string only = {};
};

void printTable(const std::vector<Method>& all, const Table& table)
{
    std::printf("| case | exact |");
    std::string line = "|---|--:|";
    for (const Method& method : all)
    {
        std::printf(" %s |", method.name.c_str());
        line += "---|";
    }
    std::printf("\n%s\n", line.c_str());
    std::vector<std::map<std::string, int>> counts(all.size());
    for (const RigidCase& listed : rigidCases())
    {
        if (!table.only.empty() && listed.id != table.only)
        {
            continue;
        }
        const RigidCase tested = slowed(listed, table.slow);
        const bool convex =
            isConvex(tested.scene.meshA) && isConvex(tested.scene.meshB) && !isNested(tested);
        std::printf("| %s | ", tested.id.c_str());
        if (tested.answer.time)
        {
            std::printf("%.9g |", *tested.answer.time);
        }
        else
        {
            std::printf("none |");
        }
        for (std::size_t i = 0; i < all.size(); ++i)
        {
            std::string verdict = "-";
            if (convex || !all[i].needsConvex)
            {
                verdict = verdictOf(runIsolated([&] { return all[i].run(tested); }, table.limit),
                                    tested.answer);
            }
            ++counts[i][verdict.substr(0, verdict.find(' '))];
            std::printf(" %s |", verdict.c_str());
            std::fflush(stdout);
        }
        std::printf("\n");
    }
    std::printf("| **sum** | |");
    for (std::map<std::string, int>& of : counts)
    {
        std::string text;
        for (const auto& [verdict, count] : of)
        {
            if (verdict != "-")
            {
                text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + verdict;
            }
        }
        std::printf(" %s |", text.c_str());
    }
    std::printf("\n");
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app{
        "The rigid cases of the stability catalogue through this library, FCL 0.7 and "
        "Bullet; a Markdown table.\n"
        "pass: not late, and early by at most 1e-4 of the motion or the case's "
        "tolerance; late, early: by that part of the motion; -: not convex."};
    Table table;
    app.add_option("--limit", table.limit, "seconds a case may take")->capture_default_str();
    app.add_option("--only", table.only, "one case, by its name");
    app.add_option("--slow",
                   table.slow,
                   "part of the speed of all motions; below 1, contact times are no longer round "
                   "numbers that sampling hits by luck")
        ->check(CLI::Range(0.9, 1.0))
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try
    {
        for (const auto& [name, present] :
             {std::pair{"FCL", hasFcl()}, std::pair{"Bullet (double precision)", hasBullet()}})
        {
            if (!present)
            {
                std::fprintf(stderr, "catalogue_peers: built without %s\n", name);
            }
        }
        printTable(methods(), table);
        return 0;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "catalogue_peers: %s\n", error.what());
        return 3;
    }
}
