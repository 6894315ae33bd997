#include "tools/grasp_cli/plan/plan_run.h"

#include "bullet_ccd/io/nearest_name.h"
#include "grasp/closing/closing.h"
#include "grasp/sim/hand_simulation.h"
#include "tools/support/progress_line.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <atomic>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
using grasp::RejectReason;

void printNotes(const std::filesystem::path& file, const std::vector<std::string>& notes)
{
    for (const std::string& note : notes)
    {
        fmt::print(stderr, "{}: {}\n", file.filename().string(), note);
    }
}
}  // namespace

void printNotes(const LoadedHand& hand, const LoadedObject& object)
{
    printNotes(hand.file, hand.hand.robot.notes);
    printNotes(hand.file, hand.hand.notes);
    printNotes(object.file, object.notes);
}

void requireFingers(const LoadedHand& hand, const grasp::ClosingOptions& closing)
{
    std::vector<std::string> known;
    for (const grasp::Finger& finger : hand.hand.fingers)
    {
        known.push_back(finger.name);
    }
    for (const std::string& name : closing.firstFingers)
    {
        if (std::find(known.begin(), known.end(), name) == known.end())
        {
            throw std::runtime_error(
                fmt::format("{}: --fingers: no finger \"{}\": did you mean {}? The hand has {}",
                            hand.file.string(),
                            name,
                            nearestName(name, known),
                            joined(known, ", ")));
        }
    }
    known.clear();
    for (std::size_t link = 1; link < hand.hand.robot.tree.size(); ++link)
    {
        const Joint& joint = hand.hand.robot.tree.links[link].joint;
        if (hand.hand.closingDirections[link] != 0 && joint.mimicOf == kNone)
        {
            known.push_back(joint.name);
        }
    }
    for (const auto& [name, ratio] : closing.speeds)
    {
        if (std::find(known.begin(), known.end(), name) == known.end())
        {
            throw std::runtime_error(fmt::format(
                "{}: --closing-speeds: no joint \"{}\" closes by itself: did you mean {}? These "
                "do: {}",
                hand.file.string(),
                name,
                nearestName(name, known),
                joined(known, ", ")));
        }
    }
}

void requireKinematic(const std::vector<Obstacle>& obstacles, const grasp::PlannerOptions& options)
{
    if (!obstacles.empty() && options.engine == grasp::ClosingEngine::Simulated)
    {
        throw std::runtime_error(
            "--scene, --table-top: the simulated engine closes on the object alone: use --engine "
            "kinematic");
    }
}

grasp::MakeCloseHand closingEngine(grasp::ClosingEngine engine,
                                   std::span<const RigidBody> obstacles,
                                   ClosingUses* uses)
{
    if (engine == grasp::ClosingEngine::Simulated)
    {
        return grasp::simulatedClosing();
    }
    return [obstacles, uses, lock = std::make_shared<std::mutex>()]
    {
        const std::scoped_lock one(*lock);
        return grasp::kinematicClosing(obstacles,
                                       uses == nullptr ? nullptr : &uses->emplace_back());
    };
}

bool hasAccuracy(const grasp::PlannerOptions& options)
{
    return options.closing.tolerance != kDefaultTolerance &&
           options.engine == grasp::ClosingEngine::Kinematic;
}

ModelShare closingShare(const ClosingUses& uses,
                        const grasp::HandModel& hand,
                        const grasp::GraspObject& object,
                        const ObstacleList& obstacles)
{
    std::vector<const SsvTree*> trees{&object.tree};
    trees.insert(trees.end(), hand.linkTrees.begin(), hand.linkTrees.end());
    for (const Obstacle& obstacle : obstacles.inReach)
    {
        trees.push_back(obstacle.tree.get());
    }
    const std::vector<ModelUse> all(uses.begin(), uses.end());
    ModelShare share(all, trees);
    share.ofBodies += obstacles.outOfReach;
    share.ofTriangles += obstacles.trianglesOutOfReach;
    return share;
}

std::string closingReport(const ClosingUses& uses,
                          double accuracy,
                          const grasp::HandModel& hand,
                          const grasp::GraspObject& object,
                          const ObstacleList& obstacles)
{
    const std::vector<ModelUse> all(uses.begin(), uses.end());
    std::string parts;
    const auto add = [&](const char* kind, const std::string& name, const SsvTree* tree)
    {
        if (tree != nullptr)
        {
            const ModelShare share(all, std::span(&tree, 1));
            parts += fmt::format(R"({}    {{"{}": {}, "triangles": {}, "of_triangles": {}}})",
                                 parts.empty() ? "" : ",\n",
                                 kind,
                                 nlohmann::json(name).dump(),
                                 share.triangles,
                                 share.ofTriangles);
        }
    };
    add("object", object.name, &object.tree);
    for (std::size_t link = 0; link < hand.linkTrees.size(); ++link)
    {
        add("link", hand.robot.tree.links[link].name, hand.linkTrees[link]);
    }
    for (const Obstacle& obstacle : obstacles.inReach)
    {
        add("obstacle", obstacle.name, obstacle.tree.get());
    }
    return fmt::format("{{\n  \"accuracy\": {},\n  {},\n  \"parts\": [\n{}\n  ]\n}}\n",
                       accuracy,
                       jsonText(closingShare(uses, hand, object, obstacles)),
                       parts);
}

void runPlan(PlanRun& run,
             const grasp::PlannerOptions& options,
             bool quiet,
             const grasp::PlanExtras& extras)
{
    if (!quiet)
    {
        printNotes(run.hand, run.object);
    }
    const grasp::HandModel& model = run.hand.hand;
    const grasp::GraspObject& target = run.object.object;
    std::atomic<std::size_t> done = extras.known.size();
    std::atomic<std::size_t> found = forceClosures(extras.known);
    std::optional<ProgressLine> progress;
    if (!quiet)
    {
        progress.emplace(static_cast<std::size_t>(options.candidates),
                         fmt::format("candidates of {} x {}", model.robot.name, target.name),
                         done);
    }
    grasp::PlanExtras all = extras;
    all.progress = [&](const grasp::Grasp& grasp)
    {
        if (extras.progress)
        {
            extras.progress(grasp);
        }
        ++done;
        found += grasp.reject == RejectReason::None ? 1 : 0;
        if (progress)
        {
            progress->show(done, fmt::format(", {} force closures", found.load()));
        }
    };
    const Stopwatch watch;
    run.grasps = grasp::planGrasps(
        model,
        target,
        options,
        closingEngine(options.engine, extras.obstacles, hasAccuracy(options) ? &run.uses : nullptr),
        all);
    run.seconds = watch.seconds();
}

std::string candidatesLeft(const std::vector<grasp::Grasp>& grasps, std::int64_t candidates)
{
    std::vector<char> tried(static_cast<std::size_t>(candidates), 0);
    for (const grasp::Grasp& grasp : grasps)
    {
        tried[static_cast<std::size_t>(grasp.candidate)] = 1;
    }
    std::vector<std::string> ranges;
    for (auto first = std::find(tried.begin(), tried.end(), 0); first != tried.end();)
    {
        const auto end = std::find(first, tried.end(), 1);
        const auto from = first - tried.begin();
        const auto to = end - tried.begin() - 1;
        ranges.push_back(from == to ? std::to_string(from) : fmt::format("{} to {}", from, to));
        first = std::find(end, tried.end(), 0);
    }
    return joined(ranges, ", ");
}

std::size_t forceClosures(std::span<const grasp::Grasp> grasps)
{
    return static_cast<std::size_t>(std::count_if(grasps.begin(),
                                                  grasps.end(),
                                                  [](const grasp::Grasp& g)
                                                  { return g.reject == RejectReason::None; }));
}

std::size_t linksInContact(const grasp::Grasp& grasp)
{
    std::set<std::int32_t> links;
    for (const grasp::GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    return links.size();
}

std::string rejectionCounts(const std::vector<grasp::Grasp>& grasps)
{
    std::map<RejectReason, int> counts;
    for (const grasp::Grasp& g : grasps)
    {
        if (g.reject != RejectReason::None)
        {
            ++counts[g.reject];
        }
    }
    std::vector<std::string> texts;
    for (const auto& [reason, count] : counts)
    {
        texts.push_back(fmt::format("{} {}", count, grasp::toString(reason)));
    }
    return joined(texts, ", ");
}
}  // namespace bullet_ccd::tools
