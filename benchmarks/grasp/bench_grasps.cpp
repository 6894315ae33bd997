// Closings and plans of many hands and objects: judged, counted, timed.
#include "benchmarks/grasp/grasp_table.h"
#include "benchmarks/grasp/judged_rows.h"
#include "benchmarks/support/checkpoint.h"
#include "benchmarks/support/program.h"
#include "grasp/hand/hand_model.h"
#include "tools/grasp_cli/options/config_option.h"
#include "tools/grasp_cli/options/input_options.h"
#include "tools/grasp_cli/options/planner_options.h"
#include "tools/support/progress_line.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

namespace bullet_ccd::benchmarks
{
namespace
{
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kBenchCriteria =
    "Of closings, exit code 1 if one of ours ends inside something or leaves a gap above 0.1 mm\n"
    "(beside full models: above --accuracy, which is all that is judged), goes on through a\n"
    "contact, differs without a reason, or if fewer than 95 % of a hand's closings, of 100 or\n"
    "more, are alike; of plans, if no object is held; of hands without their SRDF, if one has\n"
    "less than 0.9 of its force closures with it, all less than 0.95 in the mean, or less than\n"
    "0.97 the other way round; of unknown hands, if less than 60 % are force closures in the\n"
    "mean of the hands, or less than 90 % of their objects held.";

struct BenchArguments : TableOptions
{
    bool resume = false;
    bool shipped = true;    ///< every hand with its SRDF
    bool inferred = false;  ///< every hand without it
    ClosingReference against = ClosingReference::Sweep;
    TrialQuestions questions;
    std::string masses;  ///< a file
};

/// Files of one stem may lie in several folders.
std::string keyOf(const fs::path& file)
{
    return (file.parent_path().filename() / file.stem()).generic_string();
}

using JudgePair =
    std::function<json(const tools::LoadedHand& hand, const tools::LoadedObject& object)>;

/// Of a run that is resumed.
std::vector<json> knownRows(const BenchArguments& arguments, const json& settings)
{
    const std::string file = arguments.output.string();
    if (fs::exists(file) && !arguments.resume)
    {
        throw std::runtime_error(file +
                                 ": exists already: --resume goes on with it, another "
                                 "--output leaves it alone");
    }
    const std::optional<json> kept = loadCheckpoint(file, settings);
    return kept ? kept->get<std::vector<json>>() : std::vector<json>{};
}

std::map<std::string, tools::LoadedHand> handsOf(const BenchArguments& arguments)
{
    std::map<std::string, tools::LoadedHand> hands;
    for (const std::string& name : arguments.hands)
    {
        tools::LoadedHand hand = tools::loadNamedHand(name);
        const fs::path file = hand.file;
        if (arguments.shipped)
        {
            hands.try_emplace(file.stem().string(), std::move(hand));
        }
        if (arguments.inferred)
        {
            hands.try_emplace(file.stem().string() + kWithoutSrdf,
                              tools::LoadedHand{.hand = grasp::inferHand(file), .file = file});
        }
    }
    return hands;
}

/// Takes objects one by one, with all hands, and keeps the rows in a checkpoint.
class PairRunner
{
public:
    PairRunner(const BenchArguments& arguments, const JudgePair& judge, json settings)
        : m_arguments(arguments),
          m_judge(judge),
          m_settings(std::move(settings)),
          m_hands(handsOf(arguments)),
          m_rows(knownRows(arguments, m_settings)),
          m_progress(m_hands.size() * arguments.objects.size(), "pairs", m_rows.size())
    {
        // A misspelt name must not cost an hour.
        for (const std::string& object : arguments.objects)
        {
            static_cast<void>(tools::resolveObject(object));
        }
    }

    /// All rows, in the order in which they were judged.
    const std::vector<json>& run()
    {
        const int jobs = m_arguments.planner.jobs;
        tbb::task_arena(jobs > 0 ? jobs : tbb::task_arena::automatic)
            .execute(
                [this] {
                    tbb::parallel_for_each(m_arguments.objects,
                                           [this](const std::string& name) { take(name); });
                });
        return m_rows;
    }

private:
    const BenchArguments& m_arguments;
    const JudgePair& m_judge;
    json m_settings;
    std::map<std::string, tools::LoadedHand> m_hands;  // by what rows call them
    std::vector<json> m_rows;
    std::mutex m_mutex;  // of the rows
    tools::ProgressLine m_progress;

    [[nodiscard]] bool isKnown(const std::string& hand, const std::string& object)
    {
        const std::scoped_lock lock(m_mutex);
        return std::ranges::any_of(m_rows,
                                   [&](const json& row)
                                   { return row["hand"] == hand && row["object"] == object; });
    }

    void add(json row)
    {
        const std::scoped_lock lock(m_mutex);
        m_rows.push_back(std::move(row));
        saveCheckpoint(m_arguments.output.string(), m_settings, m_rows);
        m_progress.show(m_rows.size());
    }

    void take(const std::string& name)
    {
        std::optional<tools::LoadedObject> object;
        for (const auto& [handKey, hand] : m_hands)
        {
            const std::string objectKey = keyOf(tools::resolveObject(name));
            if (isKnown(handKey, objectKey))
            {
                continue;
            }
            if (!object)
            {
                object = tools::loadNamedObject(name, m_arguments.objectScale);
            }
            json row = m_judge(hand, *object);
            row["hand"] = handKey;
            row["object"] = objectKey;
            add(std::move(row));
        }
    }
};

/// What the rows depend on, beside hands and objects.
json settingsOf(const char* what, const BenchArguments& arguments)
{
    const grasp::PlannerOptions& options = arguments.planner;
    return {{"bench", what},
            {"candidates", options.candidates},
            {"seed", options.seed},
            {"object_scale", arguments.objectScale},
            {"engine", grasp::toString(options.engine)},
            {"friction", options.friction},
            {"cone_edges", options.coneEdges},
            {"min_epsilon", options.forceClosureThreshold},
            {"accuracy", options.closing.tolerance},
            {"against", toString(arguments.against)}};
}

bool run(const char* what,
         const BenchArguments& arguments,
         const JudgePair& judge,
         bool (*summarize)(const std::vector<json>& rows))
{
    const bool isGood = summarize(PairRunner(arguments, judge, settingsOf(what, arguments)).run());
    fmt::print("rows: {}\n", arguments.output.string());
    return isGood;
}

/// Threads take objects; each plans alone.
grasp::PlannerOptions alone(grasp::PlannerOptions options)
{
    options.jobs = 1;
    options.volumes = 0;
    return options;
}

bool runClosings(const BenchArguments& arguments)
{
    const auto judge = [&](const tools::LoadedHand& hand, const tools::LoadedObject& object)
    { return judgeClosings(hand, object, arguments.against, alone(arguments.planner)); };
    return run("closing", arguments, judge, &summarizeClosings);
}

/// Hands with their SRDF, without it, or both.
bool runPlans(const char* what,
              BenchArguments arguments,
              bool shipped,
              bool inferred,
              bool (*summarize)(const std::vector<json>& rows))
{
    arguments.shipped = shipped;
    arguments.inferred = inferred;
    const auto judge = [&](const tools::LoadedHand& hand, const tools::LoadedObject& object)
    { return judgePlans(hand, object, alone(arguments.planner)); };
    return run(what, arguments, judge, summarize);
}

#ifdef BULLET_CCD_HAS_MUJOCO
bool runTrials(const BenchArguments& arguments)
{
    json settings = settingsOf("trials", arguments);
    settings["mass"] = arguments.planner.mass.value_or(0.0);
    settings["masses"] = arguments.masses;
    settings["best"] = arguments.questions.best;
    settings["suites"] = arguments.questions.suites;
    settings["torsion"] = arguments.questions.torsion;
    settings["models"] = {arguments.questions.pieces.accuracy,
                          arguments.questions.pieces.most,
                          arguments.questions.skinStiffness,
                          arguments.questions.alone};
    std::map<std::string, double> masses;
    std::ifstream file(arguments.masses);
    for (std::string name, mass; std::getline(file, name, ',') && std::getline(file, mass);)
    {
        masses[name] = std::strtod(mass.c_str(), nullptr);
    }
    if (!arguments.masses.empty() && masses.empty())
    {
        throw std::runtime_error(arguments.masses + ": no lines OBJECT,KG: give another file");
    }
    tools::PieceStore pieces(arguments.questions.pieces);
    const auto judge = [&](const tools::LoadedHand& hand, const tools::LoadedObject& object)
    {
        grasp::PlannerOptions options = alone(arguments.planner);
        if (const auto listed = masses.find(object.file.stem().string()); listed != masses.end())
        {
            options.mass = listed->second;
        }
        try
        {
            return judgeTrials(hand, object, options, arguments.questions, pieces);
        }
        catch (const std::exception& error)  // must not cost the others
        {
            return json{{"error", error.what()}, {"trials", json::array()}};
        }
    };
    static_cast<void>(PairRunner(arguments, judge, settings).run());
    return true;
}
#endif

using Verb = bool (*)(const BenchArguments& arguments);

Program verbOf(const std::string& name, const std::string& about, Verb verb)
{
    const auto arguments = std::make_shared<BenchArguments>();
    const auto extend = [=](CLI::App& app)
    {
        BenchArguments& a = *arguments;
        const bool isTable = name == "table";
        a.output = isTable ? "" : "bench.json";
        tools::addInputOptions(app, a.hands, a.objects, a.objectScale);
        tools::addPlannerOptions(app, a.planner);
        app.add_option("-o,--output",
                       a.output,
                       isTable ? "folder for the table and all grasps"
                               : "JSON file: the settings, and a row per pair")
            ->group("Output");
        app.footer(isTable ? kTableCriteria : kBenchCriteria);
        if (isTable)
        {
            tools::addFingersOption(app, a.planner.closing);
            app.add_flag("-q,--quiet", a.quiet, "no progress and no notes on stderr")
                ->group("Output");
        }
        else
        {
            app.add_flag("--resume", a.resume, "keep the rows that are there and add the rest")
                ->group("Output");
        }
        if (name == "trials")
        {
            app.add_option(
                "--best", a.questions.best, "so many force closures of each pair, best first");
            app.add_option(
                "--torsion", a.questions.torsion, "of MuJoCo's contacts, six and lift [m]");
            app.add_option("--bulge", a.questions.pieces.accuracy, "of MuJoCo's pieces [m]");
            app.add_flag("--alone", a.questions.alone, "without MuJoCo");
            app.add_option("--pieces", a.questions.pieces.most, "of an object, at the most");
            app.add_option("--skin-stiffness", a.questions.skinStiffness, "of ours [N/m]");
            app.add_option("--suites", a.questions.suites, "what is asked of them")
                ->delimiter(',')
                ->check(CLI::IsMember({"six", "dexgraspbench", "lift"}));
            app.add_option("--masses", a.masses, "a table OBJECT,KG, before --mass and volumes");
        }
        if (name == "closing")
        {
            tools::addFingersOption(app, a.planner.closing);
            app.add_option("--against", a.against, "sweep (0.001 rad), simulated or full models")
                ->transform(
                    tools::wordFor<ClosingReference>({{"sweep", ClosingReference::Sweep},
                                                      {"simulated", ClosingReference::Simulated},
                                                      {"full", ClosingReference::Full}}))
                ->default_str("sweep");
        }
        tools::addConfigOptions(app);
    };
    return {.name = name,
            .about = about,
            .options = {},
            .run = [=] { return verb(*arguments); },
            .extend = extend};
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    return runProgram(
        argc,
        argv,
        {.name = "bench_grasps",
         .about = "Judges closings and plans of many hands and objects.",
         .options = {},
         .verbs = {
             verbOf("closing", "closings against a fine sweep or the simulation", &runClosings),
             verbOf("planning",
                    "force closures of many hands and objects",
                    [](const BenchArguments& a)
                    { return runPlans("planning", a, true, false, &summarizePlans); }),
             verbOf("inference",
                    "force closures of hands with their SRDF and without it",
                    [](const BenchArguments& a)
                    { return runPlans("inference", a, true, true, &summarizeInference); }),
#ifdef BULLET_CCD_HAS_MUJOCO
             verbOf("trials", "grasps tried in our simulation and in MuJoCo", &runTrials),
#endif
             verbOf("thumbed",
                    "force closures of hands of which nothing but the URDF is known",
                    [](const BenchArguments& a)
                    { return runPlans("thumbed", a, false, true, &summarizeThumbed); }),
             verbOf("table",
                    "plan every hand with every object and compare",
                    [](const BenchArguments& arguments) { return tableGrasps(arguments); })}});
}
