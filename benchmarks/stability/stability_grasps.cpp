/// Closings repeated with errors of the pose and on meshes of other sizes: how contacts, epsilon
/// and success change, ours and the discrete baseline.
#include "benchmarks/stability/stability_closings.h"
#include "benchmarks/support/data_folder.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/report.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/closing/closing.h"
#include "grasp/hand/hand_model.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::benchmarks;
using grasp::Grasp;
using grasp::GraspObject;
using grasp::HandModel;
using grasp::RejectReason;
using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::array kNoises{1e-6, 1e-5, 1e-4, 1e-3};  // [m and rad]
constexpr std::array kOwnHands{"anthropomorphic_hand", "three_finger_gripper", "parallel_gripper"};
constexpr std::array kOwnObjects{"bottle", "mug", "apple", "box", "hammer"};
constexpr std::array kDataObjects{"025_mug", "006_mustard_bottle"};

struct Arguments
{
    std::string output;
    fs::path data = defaultDataFolder();
    int candidates = 24;
    int closures = 2;  ///< grasps a pair of hand and object that are force closures
    int others = 1;    ///< that are not
    int draws = 5;     ///< a size of the error
    std::uint64_t seed = 1;
    bool quick = false;
};

/// What all parts of the measurement write to.
struct Report
{
    json pairs = json::array();
    json noise = json::array();
    json meshes = json::array();
};

/// The first candidates of either kind, in the order of their numbers.
std::vector<Grasp> chosenGrasps(const HandModel& hand,
                                const GraspObject& object,
                                const Arguments& arguments)
{
    std::vector<Grasp> planned = grasp::planGrasps(
        hand,
        object,
        {.candidates = arguments.candidates, .seed = arguments.seed, .jobs = 1, .volumes = 0},
        [] { return grasp::kinematicClosing(); });
    std::ranges::sort(planned, {}, &Grasp::candidate);
    std::vector<Grasp> chosen;
    int closures = 0;
    int others = 0;
    for (Grasp& grasp : planned)
    {
        const bool isClosure = grasp.reject == RejectReason::None;
        const bool isOther = grasp.reject == RejectReason::NoForceClosure ||
                             grasp.reject == RejectReason::TooFewContacts;
        if ((isClosure && closures++ < arguments.closures) ||
            (isOther && others++ < arguments.others))
        {
            chosen.push_back(std::move(grasp));
        }
    }
    return chosen;
}

/// One method, grasp and size of the error.
json noiseRow(const std::string& method, double noise, const std::vector<ClosingChange>& changes)
{
    json row{{"method", method},
             {"noise", noise},
             {"draws", changes.size()},
             {"closed", 0},
             {"sameLinks", 0},
             {"success", 0},
             {"posture", json::array()},
             {"quietPosture", json::array()},
             {"shift", json::array()},
             {"epsilon", json::array()},
             {"contacts", json::array()}};
    const auto count = [&](const char* name, bool is)
    { row[name] = row[name].get<int>() + (is ? 1 : 0); };
    for (const ClosingChange& change : changes)
    {
        count("success", change.success);
        count("closed", change.closed);
        if (change.closed)
        {
            count("sameLinks", change.sameLinks);
            row["posture"].push_back(change.posture);
            row["shift"].push_back(change.contactShift);
            row["epsilon"].push_back(change.epsilon);
            row["contacts"].push_back(change.contacts);
            if (change.sameLinks)
            {
                row["quietPosture"].push_back(change.posture);
            }
        }
    }
    return row;
}

void runNoise(const HandModel& hand,
              const GraspObject& object,
              const std::vector<Grasp>& grasps,
              const Arguments& arguments,
              Report& report)
{
    ClosingBench bench(hand, object);
    for (const Grasp& grasp : grasps)
    {
        const GraspStart start = startOf(hand, grasp);
        for (const ClosingMethod& method : closingMethods())
        {
            const Grasp reference = bench.close(method, start);
            for (const double noise : kNoises)
            {
                std::vector<ClosingChange> changes;
                for (int draw = 0; draw < arguments.draws; ++draw)
                {
                    const std::uint64_t seed =
                        (arguments.seed * 1'000'003 + static_cast<std::uint64_t>(grasp.candidate)) *
                            1'000 +
                        static_cast<std::uint64_t>(draw);
                    const Grasp repeated = bench.close(
                        method, moved(start, poseError(seed, noise, object.centerOfMass)));
                    changes.push_back(changeOf(hand, reference, repeated));
                }
                json row = noiseRow(method.name, noise, changes);
                row["hand"] = hand.robot.name;
                row["object"] = object.name;
                row["grasp"] = grasp.candidate;
                row["planned"] = grasp.reject == RejectReason::None ? "force closure" : "other";
                row["before"] = {{"contacts", reference.contacts.size()},
                                 {"epsilon", reference.quality.epsilon},
                                 {"success", reference.reject == RejectReason::None},
                                 {"outcome", grasp::toString(reference.reject)}};
                report.noise.push_back(std::move(row));
            }
        }
    }
}

void runPair(const HandModel& hand,
             const GraspObject& object,
             const Arguments& arguments,
             Report& report)
{
    std::vector<Grasp> grasps;
    const double micros = wallMicrosecondsOf(
        [&]
        {
            grasps = chosenGrasps(hand, object, arguments);
            runNoise(hand, object, grasps, arguments, report);
        });
    const auto closures = std::ranges::count(grasps, RejectReason::None, &Grasp::reject);
    report.pairs.push_back({{"hand", hand.robot.name},
                            {"object", object.name},
                            {"grasps", grasps.size()},
                            {"closures", closures}});
    fmt::print("{:<28}{:<22}{} grasps, {} of them force closures {:8.1f} s\n",
               hand.robot.name,
               object.name,
               grasps.size(),
               closures,
               1e-6 * micros);
    std::fflush(stdout);
}

/// An object at several numbers of triangles, coarsest first.
struct MeshFamily
{
    std::string name;
    std::vector<TriangleMesh> meshes;
};

/// Every start that is planned on the finest mesh, on all of them.
void runMeshes(const HandModel& hand,
               const MeshFamily& family,
               const Arguments& arguments,
               Report& report)
{
    std::vector<GraspObject> objects;
    for (const TriangleMesh& mesh : family.meshes)
    {
        objects.push_back(grasp::makeGraspObject(family.name, mesh));
    }
    Arguments asked = arguments;
    asked.closures = 2 * arguments.closures;
    const std::vector<Grasp> grasps = chosenGrasps(hand, objects.back(), asked);
    std::vector<std::unique_ptr<ClosingBench>> benches;
    for (const GraspObject& object : objects)
    {
        benches.push_back(std::make_unique<ClosingBench>(hand, object));
    }
    for (const Grasp& grasp : grasps)
    {
        const GraspStart start = startOf(hand, grasp);
        for (const ClosingMethod& method : closingMethods())
        {
            const Grasp finest = benches.back()->close(method, start);
            for (std::size_t level = 0; level < objects.size(); ++level)
            {
                const Grasp repeated = benches[level]->close(method, start);
                const ClosingChange change = changeOf(hand, finest, repeated);
                report.meshes.push_back(
                    {{"hand", hand.robot.name},
                     {"object", family.name},
                     {"triangles", family.meshes[level].triangles.size()},
                     {"finest", level + 1 == objects.size()},
                     {"grasp", grasp.candidate},
                     {"planned", grasp.reject == RejectReason::None ? "force closure" : "other"},
                     {"method", method.name},
                     {"closed", change.closed},
                     {"contacts", change.contacts},
                     {"value", repeated.quality.epsilon},
                     {"epsilon", change.epsilon},
                     {"posture", change.posture},
                     {"shift", change.contactShift},
                     {"sameLinks", change.sameLinks},
                     {"success", change.success}});
            }
        }
    }
    fmt::print("{:<28}{:<22}{} grasps at {} sizes\n",
               hand.robot.name,
               family.name,
               grasps.size(),
               objects.size());
    std::fflush(stdout);
}

std::vector<MeshFamily> ownFamilies(bool quick)
{
    std::vector<MeshFamily> families;
    for (const std::string& name : meshFamilies())
    {
        MeshFamily family{.name = name, .meshes = {}};
        for (int level = 0; level < kMeshLevels; ++level)
        {
            family.meshes.push_back(meshOfFamily(name, level));
        }
        families.push_back(std::move(family));
    }
    families.resize(quick ? 2 : families.size());
    return families;
}

TriangleMesh ycbMesh(const fs::path& data, const std::string& folder, const std::string& name)
{
    return loadMeshFile(data / "objects" / folder / (name + ".obj")).mesh;
}

void runOwn(const Arguments& arguments, Report& report)
{
    const fs::path share = BULLET_CCD_BUILT_SHARE;
    std::vector<GraspObject> objects;
    for (const std::string name :
         std::span(kOwnObjects).first(arguments.quick ? 2 : kOwnObjects.size()))
    {
        objects.push_back(
            grasp::makeGraspObject(name, loadMeshFile(share / "objects" / (name + ".obj")).mesh));
    }
    const std::vector<MeshFamily> families = ownFamilies(arguments.quick);
    for (const std::string name : kOwnHands)
    {
        const HandModel hand = grasp::loadHand(share / "robots" / name / (name + ".urdf"));
        for (const GraspObject& object : objects)
        {
            runPair(hand, object, arguments, report);
        }
        for (const MeshFamily& family : families)
        {
            runMeshes(hand, family, arguments, report);
        }
    }
}

void runData(const Arguments& arguments, Report& report)
{
    std::vector<GraspObject> objects;
    std::vector<MeshFamily> families;
    for (const char* name : kDataObjects)
    {
        const TriangleMesh fine = ycbMesh(arguments.data, "ycb_16k", name);
        objects.push_back(grasp::makeGraspObject(name, fine));
        families.push_back(
            {.name = name, .meshes = {ycbMesh(arguments.data, "ycb_4k", name), fine}});
    }
    for (const char* name : kDetailedHands)
    {
        const HandModel hand =
            grasp::loadHand(arguments.data / "hands" / (std::string(name) + ".urdf"),
                            std::nullopt,
                            BULLET_CCD_SHARE);
        for (std::size_t i = 0; i < objects.size(); ++i)
        {
            runPair(hand, objects[i], arguments, report);
            runMeshes(hand, families[i], arguments, report);
        }
        if (arguments.quick)
        {
            break;
        }
    }
}

/// A line per method and size of the error, over all grasps that are force closures without it.
void printSums(const json& noise)
{
    fmt::print("\nof closings that are force closures without an error:\n");
    const Table table(
        "method:<26|error [m, rad]=noise:>14.0e|posture [rad]=posture:>13.1e|95 %=posture95:>7.1e|"
        "epsilon:>8.1e|95 %=epsilon95:>7.1e|same links [%]=sameLinks:>14.1f|"
        "success [%]=success:>11.1f|draws:>5");
    std::map<std::pair<std::string, double>, std::vector<json>> groups;
    for (const json& row : noise)
    {
        if (row["before"]["success"].get<bool>())
        {
            groups[{row["method"], row["noise"]}].push_back(row);
        }
    }
    for (const auto& [key, rows] : groups)
    {
        std::map<std::string, std::vector<double>> values;
        std::map<std::string, int> counts;
        for (const json& row : rows)
        {
            for (const char* name : {"posture", "epsilon"})
            {
                values[name].insert(values[name].end(), row[name].begin(), row[name].end());
            }
            for (const char* name : {"sameLinks", "success", "draws"})
            {
                counts[name] += row[name].get<int>();
            }
        }
        const double percent = 100.0 / std::max(counts["draws"], 1);
        table.print({{"method", key.first},
                     {"noise", key.second},
                     {"posture", quantileOf(values["posture"], 0.5)},
                     {"posture95", quantileOf(values["posture"], 0.95)},
                     {"epsilon", quantileOf(values["epsilon"], 0.5)},
                     {"epsilon95", quantileOf(values["epsilon"], 0.95)},
                     {"sameLinks", percent * counts["sameLinks"]},
                     {"success", percent * counts["success"]},
                     {"draws", counts["draws"]}});
    }
}

bool run(Arguments arguments)
{
    if (arguments.quick)
    {
        arguments.candidates = 8;
        arguments.closures = 1;
        arguments.draws = 2;
    }
    Report report;
    runOwn(arguments, report);
    if (fs::exists(arguments.data / "hands"))
    {
        runData(arguments, report);
    }
    else
    {
        fmt::print("{}: no hands/ there: the project's own hands alone\n", arguments.data.string());
    }
    printSums(report.noise);
    json methods = json::array();
    for (const ClosingMethod& method : closingMethods())
    {
        methods.push_back(method.name);
    }
    writeReport(arguments.output,
                {{"family", "grasps"},
                 {"title", "Stability of grasps"},
                 {"peers", json::array()},
                 {"seed", arguments.seed},
                 {"draws", arguments.draws},
                 {"noises", kNoises},
                 {"methods", methods},
                 {"pairs", std::move(report.pairs)},
                 {"noise", std::move(report.noise)},
                 {"meshes", std::move(report.meshes)}});
    return true;
}
}  // namespace

int main(int argc, char** argv)
{
    Arguments arguments;
    return runProgram(
        argc,
        argv,
        {.name = "stability_grasps",
         .about = "Closings with errors of the pose and on other meshes, ours and stepping",
         .options = {{.names = "-o,--output",
                      .value = &arguments.output,
                      .help = "JSON file",
                      .isRequired = true},
                     {"--data", &arguments.data, "folder with hands/ and objects/"},
                     {"-n,--candidates", &arguments.candidates, "planned, of a hand and an object"},
                     {"--draws", &arguments.draws, "errors of each size"},
                     {"--seed", &arguments.seed, "of candidates and errors"},
                     {"--quick", &arguments.quick, "two objects, one hand of the data folder"}},
         .run = [&] { return run(arguments); }});
}
