/// Every rigid case of the stability catalogue through this library, FCL and Bullet: tables of
/// verdicts, and JSON for benchmarks/run stability.
#include "benchmarks/peers/bullet_peer.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/catalogue/catalogue.h"
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/support/files.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/sandbox.h"
#include "benchmarks/support/table.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using nlohmann::json;

enum class PeerOutcome : std::uint8_t
{
    Free,
    Contact,
    GaveUp,  ///< says itself that it has no answer
};

struct PeerAnswer
{
    PeerOutcome outcome = PeerOutcome::Free;
    double time = 1.0;       ///< of the contact, a fraction of the motion
    std::int64_t pairs = 0;  ///< of nodes and triangles that were looked at; 0 if not counted
};

struct Method
{
    std::string name;
    std::string owner;  ///< ours, sampled, fcl, bullet
    std::string setting;
    std::function<PeerAnswer(const RigidCase&)> run;
    /// Why the method cannot be asked this, or "".
    std::function<std::string(const RigidCase&)> notApplicable = [](const RigidCase&)
    { return ""; };
};

/// True for closed convex surfaces and for single triangles, segments, points and rectangles: for
/// what is the same to a query as its convex hull, as long as the other body is outside.
bool isConvex(const TriangleMesh& mesh)
{
    TriangleMesh merged = mesh;
    repairMesh(merged);
    const std::vector<Eigen::Vector3d>& corners = merged.vertices;
    if (corners.size() <= 3 || (corners.size() == 4 && merged.triangles.size() == 2))
    {
        return true;
    }
    const double size = bounds(mesh).diagonal().norm();
    const auto isOutside = [&](const Triangle& t)
    {
        const auto at = [&](std::size_t k) { return corners[static_cast<std::size_t>(t[k])]; };
        const Eigen::Vector3d n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
        return std::ranges::all_of(
            corners, [&](const Eigen::Vector3d& v) { return n.dot(v - at(0)) <= 1e-9 * size; });
    };
    return isWatertight(merged) && std::ranges::all_of(merged.triangles, isOutside);
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

PeerAnswer contactAt(double time)
{
    return {.outcome = PeerOutcome::Contact, .time = time};
}

PeerAnswer answerOf(ToiStatus status, double time, const ToiCounters& counters)
{
    PeerAnswer answer{.time = time, .pairs = counters.nodePairs + counters.trianglePairs};
    if (isContact(status))
    {
        answer.outcome = PeerOutcome::Contact;
    }
    else if (status == ToiStatus::IterationLimit)
    {
        answer.outcome = PeerOutcome::GaveUp;
    }
    return answer;
}

PeerAnswer ours(const RigidCase& tested, ToiStrategy strategy)
{
    const ToiResult result =
        queryToi(tested.scene, {.tolerance = tested.answer.finest(), .strategy = strategy});
    return answerOf(result.status, result.time, result.counters);
}

/// The first of `steps` + 1 times at which something touches.
template <typename Touches>
PeerAnswer firstSample(int steps, const Touches& touches)
{
    for (int i = 0; i <= steps; ++i)
    {
        const double t = static_cast<double>(i) / steps;
        if (touches(t))
        {
            return contactAt(t);
        }
    }
    return {};
}

/// FCL on a case; it gets the same two motions, see fcl_peer.h.
template <typename Ask>
PeerAnswer askFcl(const RigidCase& tested, const Ask& ask)
{
    const FclModel a(tested.scene.meshA);
    const FclModel b(tested.scene.meshB);
    const FclAnswer answer =
        ask(FclBody{a, tested.scene.motionA}, FclBody{b, tested.scene.motionB});
    return answer.hit ? contactAt(answer.time) : PeerAnswer{};
}

PeerAnswer fclSampling(const RigidCase& tested, int steps)
{
    return askFcl(tested,
                  [&](const FclBody& a, const FclBody& b) { return fclNaive(a, b, steps + 1); });
}

PeerAnswer fclAdvancing(const RigidCase& tested)
{
    return askFcl(tested,
                  [](const FclBody& a, const FclBody& b)
                  { return fclAdvancement(a, b, 1e-6, 1001); });
}

PeerAnswer castByBullet(const RigidCase& tested, BulletCast cast)
{
    const BulletHull a(tested.scene.meshA, 0.0);
    const BulletHull b(tested.scene.meshB, 0.0);
    const BulletAnswer answer = bulletCast(cast, a, tested.scene.motionA, b, tested.scene.motionB);
    return answer.hit ? contactAt(answer.time) : PeerAnswer{};
}

/// Contact where the hulls are within the tolerance of the case.
PeerAnswer bulletSampling(const RigidCase& tested, int steps)
{
    const BulletHull a(tested.scene.meshA, 0.0);
    const BulletHull b(tested.scene.meshB, 0.0);
    const auto isNear = [&](double t)
    {
        return bulletDistance(
                   a, tested.scene.motionA.at(t).X_W, b, tested.scene.motionB.at(t).X_W) <=
               tested.answer.finest();
    };
    return firstSample(steps, isNear);
}

Method sampling(const std::string& name,
                const std::string& owner,
                int steps,
                PeerAnswer (*run)(const RigidCase&, int))
{
    return {.name = name + " x" + std::to_string(steps),
            .owner = owner,
            .setting = std::to_string(steps) + " steps",
            .run = [run, steps](const RigidCase& tested) { return run(tested, steps); }};
}

/// This library with every strategy at the finest tolerance of the case, FCL's sampling and its
/// conservative advancement, Bullet's casts and the closest points of its hulls at sampled poses.
/// Numbers of steps are primes: many of the catalogue's contact times are multiples of 1/1000,
/// which round numbers of steps would hit by luck.
std::vector<Method> catalogueMethods()
{
    std::vector<Method> all;
    for (const ToiStrategy strategy :
         {ToiStrategy::BestFirst, ToiStrategy::Interval, ToiStrategy::C2A})
    {
        all.push_back(
            {.name = nameOf(strategy),
             .owner = "ours",
             .setting = "the case's finest tolerance",
             .run = [strategy](const RigidCase& tested) { return ours(tested, strategy); }});
    }
    all.push_back({.name = "FCL advancement",
                   .owner = "fcl",
                   .setting = "CCDC_CONSERVATIVE_ADVANCEMENT, toc_err 1e-6",
                   .run = fclAdvancing});
    for (const int steps : {97, 997, 9973})
    {
        all.push_back(sampling("FCL sampling", "fcl", steps, fclSampling));
    }
    const auto cast = [&](const char* name, const char* setting, BulletCast kind, auto cannot)
    {
        all.push_back(
            {.name = name,
             .owner = "bullet",
             .setting = setting,
             .run = [kind](const RigidCase& tested) { return castByBullet(tested, kind); },
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
        all.push_back(sampling("Bullet discrete", "bullet", steps, bulletSampling));
        all.back().setting += ", as a world at that rate";
        all.back().notApplicable = notConvex;
    }
    return all;
}

struct CatalogueOptions
{
    double limit = 30.0;      ///< seconds for a case
    double peerLimit = 30.0;  ///< and for a peer, at most
    std::string only = {};    ///< cases, by their id or group
};

/// What a code that is asked for a time may be early, and rounding of its times.
constexpr double kAllowedTime = 1e-4;
constexpr double kLate = 1e-9;

RightTimes rightTimes(const CaseAnswer& exact, double rounding, bool isOurs)
{
    RightTimes right = rightTimes(exact, exact.finest(), rounding);
    if (!isOurs)
    {
        right.earliest = std::min(right.earliest, *exact.time - kAllowedTime);
        right.latest = std::max(right.latest, *exact.time + kLate + leadTime(exact, rounding));
    }
    return right;
}

std::string verdictOf(const Sandboxed<PeerAnswer>& asked,
                      const CaseAnswer& exact,
                      double rounding,
                      bool isOurs)
{
    const auto& [outcome, time, pairs] = asked.answer;
    if (asked.end != SandboxEnd::Answered)
    {
        return asked.end == SandboxEnd::Crashed ? "crashed" : "timed out";
    }
    if (outcome == PeerOutcome::GaveUp)
    {
        return "gave up";
    }
    if (!exact.time)
    {
        const bool isFalse =
            outcome == PeerOutcome::Contact && exact.clearance > 1.001 * exact.finest();
        return isFalse ? "false contact" : "pass";
    }
    if (outcome == PeerOutcome::Free)
    {
        return "missed";
    }
    const RightTimes right = rightTimes(exact, rounding, isOurs);
    if (!(time <= right.latest))  // not a number is late
    {
        return "late";
    }
    return time < right.earliest ? "inaccurate" : "pass";
}

/// A case that starts within the tolerance has no window; what is reported has to be that near, by
/// brute force.
bool isNear(const RigidCase& tested, double t)
{
    return oracleDistanceAt(oracleBody(tested.scene.meshA, tested.scene.motionA),
                            oracleBody(tested.scene.meshB, tested.scene.motionB),
                            t) <= 1.001 * tested.answer.finest() + roundingOf(tested);
}

json askMethod(const RigidCase& tested, const Method& method, double limit)
{
    json row{
        {"method", method.name}, {"verdict", "not applicable"}, {"seconds", 0.0}, {"pairs", 0}};
    if (const std::string note = method.notApplicable(tested); !note.empty())
    {
        row["note"] = note;
        return row;
    }
    const auto asked = sandboxedAnswer<PeerAnswer>(limit, [&] { return method.run(tested); });
    std::string verdict =
        verdictOf(asked, tested.answer, roundingOf(tested), method.owner == "ours");
    const bool isContact = asked.answer.outcome == PeerOutcome::Contact;
    if (verdict == "pass" && tested.answer.startsTouching && tested.answer.time &&
        !isNear(tested, asked.answer.time))
    {
        verdict = "inaccurate";
    }
    row["verdict"] = verdict;
    row["seconds"] = asked.seconds;
    row["pairs"] = asked.answer.pairs;
    if (isContact)
    {
        // Not a number has no JSON.
        const double time = asked.answer.time;
        row["time"] = std::isfinite(time) ? json(time) : json(nullptr);
        row["error"] =
            !std::isfinite(time) ? json(nullptr) : json(time - tested.answer.time.value_or(time));
    }
    return row;
}

/// The verdict, with the error of the time if that is what is wrong.
std::string cellOf(const json& answer)
{
    const auto verdict = answer["verdict"].get<std::string>();
    const bool hasError =
        (verdict == "late" || verdict == "inaccurate") && answer["error"].is_number();
    return answer.contains("note") ? "-"
           : hasError ? fmt::format("{} {:.1e}", verdict, std::abs(answer["error"].get<double>()))
                      : verdict;
}

/// Prints a row of verdicts per case as it comes, and sums. Gives what benchmarks/run stability
/// draws: `methods`; `cases`, each with an answer per method; `failures` of this
/// library. Throws std::invalid_argument if there is no such case.
///
/// The verdict of an answer is "pass", "inaccurate" (early beyond what is promised), "late",
/// "missed", "false contact", "gave up", "crashed", "timed out" or "not applicable". It is judged
/// by the tolerance of the case, and peers, which are asked for a time, by 1e-4 of the motion if
/// that is more. Late is what is beyond the rounding of the scene, and for peers beyond 1e-9.
json runCatalogue(const CatalogueOptions& options)
{
    json table{{"family", "catalogue"},
               {"title", "Contact times with exact answers, where known methods fail"},
               {"limit", options.limit},
               {"peers", {"FCL", "Bullet in double precision"}},
               {"methods", json::array()},
               {"cases", json::array()},
               {"failures", json::array()}};
    const std::vector<Method> methods = catalogueMethods();
    std::string columns = "case=id:<6|exact=time:>12.9g";
    for (const Method& method : methods)
    {
        columns += fmt::format("|{}:<18", method.name);
        table["methods"].push_back(
            {{"name", method.name}, {"owner", method.owner}, {"setting", method.setting}});
    }
    const Table printed(columns);
    std::vector<std::map<std::string, int>> sums(methods.size());
    for (const RigidCase& tested : rigidCases())
    {
        if (!tested.id.starts_with(options.only))
        {
            continue;
        }
        const CaseAnswer& exact = tested.answer;
        const json time = exact.time ? json(*exact.time) : json(nullptr);
        json line{{"id", tested.id}, {"time", time}};
        json answers = json::array();
        for (std::size_t i = 0; i < methods.size(); ++i)
        {
            const double limit = methods[i].owner == "ours"
                                     ? options.limit
                                     : std::min(options.limit, options.peerLimit);
            answers.push_back(askMethod(tested, methods[i], limit));
            const auto verdict = answers.back()["verdict"].get<std::string>();
            ++sums[i][verdict];
            line[methods[i].name] = cellOf(answers.back());
            if (verdict != "pass" && methods[i].owner == "ours")
            {
                table["failures"].push_back(
                    fmt::format("{} ({}: {})", tested.id, methods[i].name, verdict));
            }
        }
        printed.print(line);
        table["cases"].push_back({{"id", tested.id},
                                  {"title", tested.title},
                                  {"time", time},
                                  {"clearance", exact.clearance},
                                  {"closingSpeed", exact.closingSpeed},
                                  {"tolerance", exact.finest()},
                                  {"rounding", roundingOf(tested)},
                                  {"answers", std::move(answers)}});
    }
    for (std::size_t i = 0; i < methods.size(); ++i)
    {
        std::string counts;
        for (const auto& [verdict, count] : sums[i])
        {
            counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, verdict);
        }
        fmt::print("{}: {}\n", methods[i].name, counts);
    }
    bool isAny = !table["cases"].empty();
    for (const CatalogueRow& row : catalogueRows())
    {
        if (!options.only.empty() && row.id.starts_with(options.only) && row.where != kIsCase)
        {
            fmt::print("{}: {}: a property, held by the test {}\n", row.id, row.title, row.where);
            isAny = true;
        }
    }
    if (!isAny)
    {
        throw std::invalid_argument("--only " + options.only +
                                    ": no such case or group: see benchmarks/reference/catalogue");
    }
    for (const json& failure : table["failures"])
    {
        fmt::print("FAILED: {}\n", failure.get<std::string>());
    }
    return table;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    CatalogueOptions options;
    std::string output;
    bool quick = false;
    const auto run = [&]
    {
        options.peerLimit = quick ? 2.0 : options.peerLimit;
        const nlohmann::json measured = runCatalogue(options);
        if (!output.empty())
        {
            writeReport(output, measured);
        }
        return measured["failures"].empty();
    };
    return runProgram(
        argc,
        argv,
        {.name = "stability_catalogue",
         .about =
             "The rigid cases of the stability catalogue through this library, FCL and Bullet.\n"
             "pass: not late, and early by at most the case's tolerance, for peers by 1e-4 of "
             "the motion if that is more; -: not applicable. It fails if this library fails a "
             "case.",
         .options = {{"-o,--output", &output, "JSON file to write"},
                     {"--limit", &options.limit, "seconds of processor time that a case may take"},
                     {"--only", &options.only, "a case by its id, or a group by its letter"},
                     {"--quick", &quick, "two seconds for a case of a peer"}},
         .run = run});
}
