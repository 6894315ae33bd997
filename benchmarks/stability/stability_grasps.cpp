/// Closings repeated with errors of the pose and on meshes of other sizes: how contacts, epsilon
/// and success change, ours and the discrete baseline.
#include "benchmarks/stability/stability_closings.h"
#include "benchmarks/support/report.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/closing/kinematic_closing.h"
#include "grasp/hand/hand_file.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
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
constexpr std::array kDataHands{"schunk_sah/schunk_sah_right_mesh",
                                "allegro/allegro_right_mesh",
                                "barrett/barrett_mesh",
                                "shadow/shadow_right_mesh",
                                "schunk_svh/schunk_svh_right_mesh",
                                "leap/leap_right_mesh",
                                "panda_gripper/panda_gripper_mesh",
                                "schunk_sdh/schunk_sdh_mesh"};
constexpr std::array kDataObjects{"025_mug", "006_mustard_bottle"};

struct Arguments
{
    std::string output;
    fs::path data = BULLET_CCD_BENCHMARK_DATA;
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
    const auto begin = std::chrono::steady_clock::now();
    const std::vector<Grasp> grasps = chosenGrasps(hand, object, arguments);
    runNoise(hand, object, grasps, arguments, report);
    const auto closures = std::ranges::count(grasps, RejectReason::None, &Grasp::reject);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    report.pairs.push_back({{"hand", hand.robot.name},
                            {"object", object.name},
                            {"grasps", grasps.size()},
                            {"closures", closures}});
    fmt::print("{:<28}{:<22}{} grasps, {} of them force closures {:8.1f} s\n",
               hand.robot.name,
               object.name,
               grasps.size(),
               closures,
               seconds.count());
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

std::vector<HandModel> ownHands()
{
    std::vector<HandModel> hands;
    const fs::path robots = fs::path(BULLET_CCD_BUILT_SHARE) / "robots";
    for (const char* name : kOwnHands)
    {
        hands.push_back(grasp::loadHand(robots / name / (std::string(name) + ".urdf")));
    }
    return hands;
}

TriangleMesh ycbMesh(const fs::path& data, const std::string& folder, const std::string& name)
{
    return loadMeshFile(data / "objects" / folder / (name + ".obj")).mesh;
}

void runOwn(const Arguments& arguments, Report& report)
{
    const std::vector<HandModel> hands = ownHands();
    std::vector<GraspObject> objects;
    for (const char* name : kOwnObjects)
    {
        const fs::path file =
            fs::path(BULLET_CCD_BUILT_SHARE) / "objects" / (std::string(name) + ".obj");
        objects.push_back(grasp::makeGraspObject(name, loadMeshFile(file).mesh));
        if (arguments.quick && objects.size() == 2)
        {
            break;
        }
    }
    const std::vector<MeshFamily> families = ownFamilies(arguments.quick);
    for (const HandModel& hand : hands)
    {
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
    for (const char* name : kDataHands)
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

/// A line a method and size of the error, over all grasps that are force closures without it.
void printSums(const Report& report)
{
    struct Sum
    {
        std::vector<double> posture;
        std::vector<double> epsilon;
        int draws = 0;
        int same = 0;
        int success = 0;
    };
    std::map<std::pair<std::string, double>, Sum> sums;
    for (const json& row : report.noise)
    {
        if (!row["before"]["success"].get<bool>())
        {
            continue;
        }
        Sum& sum = sums[{row["method"].get<std::string>(), row["noise"].get<double>()}];
        for (const double value : row["posture"])
        {
            sum.posture.push_back(value);
        }
        for (const double value : row["epsilon"])
        {
            sum.epsilon.push_back(value);
        }
        sum.draws += row["draws"].get<int>();
        sum.same += row["sameLinks"].get<int>();
        sum.success += row["success"].get<int>();
    }
    fmt::print(
        "\nof closings that are force closures without an error: change of the posture "
        "[rad], of epsilon\n");
    for (const auto& [key, sum] : sums)
    {
        const auto percent = [&](int count) { return 100.0 * count / std::max(sum.draws, 1); };
        fmt::print(
            "{:<26} {:.0e} m, rad: posture median {:.1e}, 95 % {:.1e}; epsilon median "
            "{:.1e}, 95 % {:.1e}; same links {:5.1f} %, success {:5.1f} % of {}\n",
            key.first,
            key.second,
            quantileOf(sum.posture, 0.5),
            quantileOf(sum.posture, 0.95),
            quantileOf(sum.epsilon, 0.5),
            quantileOf(sum.epsilon, 0.95),
            percent(sum.same),
            percent(sum.success),
            sum.draws);
    }
}

void write(const Arguments& arguments, Report report, bool hasData, double seconds)
{
    json methods = json::array();
    for (const ClosingMethod& method : closingMethods())
    {
        methods.push_back(method.name);
    }
    writeReport(arguments.output,
                {{"family", "grasps"},
                 {"title", "Stability of grasps"},
                 {"peers", json::array()},
                 {"quick", arguments.quick},
                 {"seed", arguments.seed},
                 {"candidates", arguments.candidates},
                 {"draws", arguments.draws},
                 {"noises", kNoises},
                 {"methods", methods},
                 {"data", hasData},
                 {"seconds", seconds},
                 {"pairs", std::move(report.pairs)},
                 {"noise", std::move(report.noise)},
                 {"meshes", std::move(report.meshes)}});
}

void run(const Arguments& arguments)
{
    const auto begin = std::chrono::steady_clock::now();
    Report report;
    runOwn(arguments, report);
    const bool hasData = fs::exists(arguments.data / "hands");
    if (hasData)
    {
        runData(arguments, report);
    }
    else
    {
        fmt::print("{}: no hands/ there: the project's own hands alone\n", arguments.data.string());
    }
    printSums(report);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    write(arguments, std::move(report), hasData, seconds.count());
}
}  // namespace

int main(int argc, char** argv)
{
    Arguments arguments;
    CLI::App app("Closings with errors of the pose and on other meshes, ours and stepping");
    app.add_option("-o,--output", arguments.output, "JSON file")->required();
    app.add_option("--data", arguments.data, "folder with hands/ and objects/");
    app.add_option("-n,--candidates", arguments.candidates, "planned, of a hand and an object")
        ->check(CLI::PositiveNumber);
    app.add_option("--draws", arguments.draws, "errors of each size")->check(CLI::PositiveNumber);
    app.add_option("--seed", arguments.seed, "of candidates and errors");
    app.add_flag("--quick", arguments.quick, "two objects, one hand of the data folder");
    CLI11_PARSE(app, argc, argv);
    if (arguments.quick)
    {
        arguments.candidates = 8;
        arguments.closures = 1;
        arguments.draws = 2;
    }
    try
    {
        run(arguments);
    }
    catch (const std::exception& error)
    {
        std::cerr << "stability_grasps: " << error.what() << '\n';
        return 2;
    }
    return 0;
}
