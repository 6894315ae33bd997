/// Closings repeated with errors of the pose and on meshes of other sizes: how contacts, epsilon
/// and success change, ours and the discrete baseline. benchmarks/run stability draws them.
#include "benchmarks/stability/stability_closings.h"
#include "benchmarks/support/data_folder.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/report.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/closing/closing.h"
#include "grasp/hand/hand_model.h"
#include "grasp/planner/grasp_planner.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
namespace
{
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
    int closures =
        2;          ///< grasps a pair of hand and object that are force closures; one that is not
    int draws = 5;  ///< a size of the error
    std::uint64_t seed = 1;
    bool quick = false;
};

struct Report
{
    json pairs = json::array();
    json noise = json::array();
    json meshes = json::array();
};

/// The same object at one or several numbers of triangles, coarsest first.
using Levels = std::vector<GraspObject>;

/// The first candidates that are force closures, and the first that closed on something else.
std::vector<Grasp> chosenGrasps(const HandModel& hand,
                                const GraspObject& object,
                                const Arguments& arguments,
                                int closures)
{
    std::vector<Grasp> planned = grasp::planGrasps(
        hand,
        object,
        {.candidates = arguments.candidates, .seed = arguments.seed, .jobs = 1, .volumes = 0},
        [] { return grasp::kinematicClosing(); });
    std::ranges::sort(planned, {}, &Grasp::candidate);
    int others = 1;
    std::erase_if(planned,
                  [&](const Grasp& grasp)
                  {
                      const bool isOther = grasp.reject == RejectReason::NoForceClosure ||
                                           grasp.reject == RejectReason::TooFewContacts;
                      return grasp.reject == RejectReason::None ? closures-- <= 0
                                                                : !isOther || others-- <= 0;
                  });
    return planned;
}

json headOf(const HandModel& hand,
            const GraspObject& object,
            const Grasp& grasp,
            const auto& method)
{
    return {{"hand", hand.robot.name},
            {"object", object.name},
            {"grasp", grasp.candidate},
            {"planned", grasp.reject == RejectReason::None ? "force closure" : "other"},
            {"method", method.name}};
}

/// One method, grasp and size of the error: counts of all draws, values of those that closed.
json noiseRow(double noise, const std::vector<json>& changes)
{
    json row{{"noise", noise}, {"draws", changes.size()}, {"quietPosture", json::array()}};
    for (const char* name : {"closed", "sameLinks", "success"})
    {
        row[name] = std::ranges::count_if(
            changes, [&](const json& change) { return change[name].get<bool>(); });
    }
    for (const char* name : {"posture", "shift", "epsilon", "contacts"})
    {
        row[name] = json::array();
        for (const json& change : changes)
        {
            if (change["closed"])
            {
                row[name].push_back(change[name]);
            }
        }
    }
    for (const json& change : changes)
    {
        if (change["sameLinks"])
        {
            row["quietPosture"].push_back(change["posture"]);
        }
    }
    return row;
}

void runNoise(const HandModel& hand,
              const GraspObject& object,
              const Arguments& arguments,
              Report& report)
{
    const std::vector<Grasp> grasps = chosenGrasps(hand, object, arguments, arguments.closures);
    const std::vector<GraspMethod> methods = graspMethods(hand, object);
    for (const Grasp& grasp : grasps)
    {
        const ClosingStart start = startOf(hand, grasp);
        for (const GraspMethod& method : methods)
        {
            const Grasp reference = method.run(start);
            json head = headOf(hand, object, grasp, method);
            head["before"] = {{"contacts", reference.contacts.size()},
                              {"epsilon", reference.quality.epsilon},
                              {"success", reference.reject == RejectReason::None},
                              {"outcome", grasp::toString(reference.reject)}};
            for (const double noise : kNoises)
            {
                const std::uint64_t first =
                    (arguments.seed * 1'000'003 + static_cast<std::uint64_t>(grasp.candidate)) *
                    1'000;
                std::vector<json> changes;
                for (std::uint64_t draw = 0; draw < std::uint64_t(arguments.draws); ++draw)
                {
                    const Grasp repeated = method.run(
                        moved(start, poseError(first + draw, noise, object.centerOfMass)));
                    changes.push_back(changeOf(hand, reference, repeated));
                }
                report.noise.push_back(noiseRow(noise, changes));
                report.noise.back().update(head);
            }
        }
    }
    const auto closures = std::ranges::count(grasps, RejectReason::None, &Grasp::reject);
    report.pairs.push_back({{"hand", hand.robot.name},
                            {"object", object.name},
                            {"grasps", grasps.size()},
                            {"closures", closures}});
    fmt::print("{:<28}{:<22}{} grasps, {} of them force closures\n",
               hand.robot.name,
               object.name,
               grasps.size(),
               closures);
    std::fflush(stdout);
}

/// Every start that is planned on the finest mesh, on all of them.
void runMeshes(const HandModel& hand,
               const Levels& levels,
               const Arguments& arguments,
               Report& report)
{
    std::vector<std::vector<GraspMethod>> methods;
    for (const GraspObject& object : levels)
    {
        methods.push_back(graspMethods(hand, object));
    }
    for (const Grasp& grasp : chosenGrasps(hand, levels.back(), arguments, 2 * arguments.closures))
    {
        const ClosingStart start = startOf(hand, grasp);
        for (std::size_t m = 0; m < methods.back().size(); ++m)
        {
            const Grasp finest = methods.back()[m].run(start);
            for (std::size_t level = 0; level < levels.size(); ++level)
            {
                const Grasp repeated = methods[level][m].run(start);
                json row = headOf(hand, levels[level], grasp, methods[level][m]);
                row.update(changeOf(hand, finest, repeated));
                row["value"] = repeated.quality.epsilon;
                row["triangles"] = levels[level].tree.mesh().triangles.size();
                row["finest"] = level + 1 == levels.size();
                report.meshes.push_back(std::move(row));
            }
        }
    }
    fmt::print("{:<28}{:<22}at {} sizes\n", hand.robot.name, levels.back().name, levels.size());
    std::fflush(stdout);
}

GraspObject loadObject(const std::string& name, const fs::path& folder)
{
    return grasp::makeGraspObject(name, loadMeshFile(folder / (name + ".obj")).mesh);
}

void runOwn(const Arguments& arguments, Report& report)
{
    const fs::path share = BULLET_CCD_BUILT_SHARE;
    std::vector<GraspObject> objects;
    for (const char* name : kOwnObjects)
    {
        objects.push_back(loadObject(name, share / "objects"));
    }
    std::vector<Levels> families;
    for (const char* name : {"egg", "block", "bottle", "ring"})
    {
        families.emplace_back();
        for (const int level : {0, 1, 2})
        {
            families.back().push_back(grasp::makeGraspObject(name, meshOfFamily(name, level)));
        }
    }
    if (arguments.quick)
    {
        objects.erase(objects.begin() + 2, objects.end());
        families.erase(families.begin() + 2, families.end());
    }
    for (const std::string name : kOwnHands)
    {
        const HandModel hand = grasp::loadHand(share / "robots" / name / (name + ".urdf"));
        for (const GraspObject& object : objects)
        {
            runNoise(hand, object, arguments, report);
        }
        for (const Levels& levels : families)
        {
            runMeshes(hand, levels, arguments, report);
        }
    }
}

void runData(const Arguments& arguments, Report& report)
{
    std::vector<Levels> objects;
    for (const char* name : kDataObjects)
    {
        objects.emplace_back();
        for (const char* folder : {"ycb_4k", "ycb_16k"})
        {
            objects.back().push_back(loadObject(name, arguments.data / "objects" / folder));
        }
    }
    for (const char* name : kDetailedHands)
    {
        const fs::path urdf = arguments.data / "hands" / (std::string(name) + ".urdf");
        const HandModel hand = grasp::loadHand(urdf, std::nullopt, BULLET_CCD_SHARE);
        for (const Levels& levels : objects)
        {
            runNoise(hand, levels.back(), arguments, report);
            runMeshes(hand, levels, arguments, report);
        }
        if (arguments.quick)
        {
            break;
        }
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
    json methods = json::array();
    for (const json& row : report.noise)
    {
        if (std::ranges::find(methods, row["method"]) == methods.end())
        {
            methods.push_back(row["method"]);
        }
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
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
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
