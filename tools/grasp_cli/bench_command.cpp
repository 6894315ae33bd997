#include "tools/ccd_cli/progress_line.h"
#include "tools/grasp_cli/bench_log.h"
#include "tools/grasp_cli/bench_pairs.h"
#include "tools/grasp_cli/bench_summary.h"
#include "tools/grasp_cli/commands.h"
#include "tools/grasp_cli/input_options.h"

#include <atomic>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using nlohmann::json;

struct BenchArguments
{
    std::vector<std::string> hands;
    std::vector<std::string> objects;
    double objectScale = 1.0;
    fs::path output = "bench.jsonl";
    bool resume = false;
    ClosingReference against = ClosingReference::Sweep;
    grasp::PlannerOptions options;
};

/// Files of one stem may lie in several folders.
std::string keyOf(const fs::path& file)
{
    return (file.parent_path().filename() / file.stem()).generic_string();
}

using BenchPair = std::function<json(const LoadedHand& hand, const LoadedObject& object)>;

/// Takes objects one by one, with all hands.
class PairRunner
{
public:
    PairRunner(const BenchArguments& arguments, const BenchPair& bench, BenchLog& log)
        : m_arguments(arguments),
          m_bench(bench),
          m_log(log),
          m_progress(arguments.hands.size() * arguments.objects.size()),
          m_done(log.rows().size())
    {
        for (const std::string& hand : arguments.hands)
        {
            m_hands.push_back(loadNamedHand(hand, std::nullopt));
        }
        // A misspelt name must not cost an hour.
        for (const std::string& object : arguments.objects)
        {
            static_cast<void>(resolveObject(object));
        }
    }

    void run()
    {
        const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
        const int jobs = m_arguments.options.jobs > 0 ? m_arguments.options.jobs : cores;
        {
            std::vector<std::jthread> threads;
            for (int i = 0; i < jobs; ++i)
            {
                threads.emplace_back([this] { work(); });
            }
        }
        if (m_error)
        {
            std::rethrow_exception(m_error);
        }
    }

private:
    const BenchArguments& m_arguments;
    const BenchPair& m_bench;
    BenchLog& m_log;
    std::vector<LoadedHand> m_hands;
    ProgressLine m_progress;
    std::atomic<std::size_t> m_next = 0;
    std::atomic<std::size_t> m_done;
    std::atomic<bool> m_failed = false;
    std::exception_ptr m_error;

    void work()
    {
        try
        {
            for (std::size_t i = m_next++; i < m_arguments.objects.size() && !m_failed;
                 i = m_next++)
            {
                take(m_arguments.objects[i]);
            }
        }
        catch (...)
        {
            if (!m_failed.exchange(true))
            {
                m_error = std::current_exception();
            }
        }
    }

    void take(const std::string& name)
    {
        std::optional<LoadedObject> object;
        for (const LoadedHand& hand : m_hands)
        {
            const std::string handKey = hand.file.stem().string();
            const std::string objectKey = keyOf(resolveObject(name));
            if (m_failed || m_log.has(handKey, objectKey))
            {
                continue;
            }
            if (!object)
            {
                object = loadNamedObject(name, m_arguments.objectScale);
            }
            json row = m_bench(hand, *object);
            row["hand"] = handKey;
            row["object"] = objectKey;
            m_log.add(row);
            m_progress.show(++m_done);
        }
    }
};

/// What the rows depend on, beside hands and objects.
json settingsOf(const char* what, const BenchArguments& arguments)
{
    const grasp::PlannerOptions& options = arguments.options;
    return {{"bench", what},
            {"candidates", options.candidates},
            {"seed", options.seed},
            {"object_scale", arguments.objectScale},
            {"engine", grasp::toString(options.engine)},
            {"friction", options.friction},
            {"cone_edges", options.coneEdges},
            {"min_epsilon", options.forceClosureThreshold},
            {"against", toString(arguments.against)}};
}

int run(const char* what,
        const BenchArguments& arguments,
        const BenchPair& bench,
        BenchSummary (*summarize)(const std::vector<json>& rows))
{
    BenchLog log(arguments.output, settingsOf(what, arguments), arguments.resume);
    PairRunner(arguments, bench, log).run();
    const BenchSummary summary = summarize(log.rows());
    fmt::print("{}\nrows: {}\n", summary.text, arguments.output.string());
    return summary.good ? kFound : kNothingFound;
}

/// Threads take objects; each plans alone.
grasp::PlannerOptions alone(grasp::PlannerOptions options)
{
    options.jobs = 1;
    options.volumes = 0;
    return options;
}

CLI::App* addBench(CLI::App& bench, const char* name, const char* text, BenchArguments& arguments)
{
    CLI::App* command = bench.add_subcommand(name, text);
    addInputOptions(*command, arguments.hands, arguments.objects, arguments.objectScale);
    addPlannerOptions(*command, arguments.options);
    command
        ->add_option("-o,--output", arguments.output, "JSON Lines: the settings, then a row a pair")
        ->type_name("FILE")
        ->capture_default_str()
        ->group("Output");
    command->add_flag("--resume", arguments.resume, "keep the rows that are there and add the rest")
        ->group("Output");
    return command;
}
}  // namespace

void addBenchCommand(CLI::App& app, int& exitCode)
{
    CLI::App* bench =
        app.add_subcommand("bench", "judge closings or plans of many hands and objects");
    bench->require_subcommand(1);

    const auto closing = std::make_shared<BenchArguments>();
    CLI::App* command =
        addBench(*bench, "closing", "closings against a fine sweep or the simulation", *closing);
    command->add_option("--against", closing->against, "sweep (0.001 rad) or simulated")
        ->type_name("REFERENCE")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, ClosingReference>{{"sweep", ClosingReference::Sweep},
                                                    {"simulated", ClosingReference::Simulated}},
            CLI::ignore_case))
        ->default_str("sweep");
    command->footer(
        "Exit code 1 if one of our closings ends inside something or leaves a gap above 0.1 mm,\n"
        "goes on through a contact, differs without a reason, or (simulated) if fewer than 95 %\n"
        "of a hand's closings are alike.");
    command->callback(
        [closing, &exitCode]
        {
            const auto pair = [&](const LoadedHand& hand, const LoadedObject& object)
            { return benchClosing(hand, object, closing->against, alone(closing->options)); };
            exitCode = run("closing", *closing, pair, &summarizeClosings);
        });

    const auto planning = std::make_shared<BenchArguments>();
    addBench(*bench, "planning", "force closures of many hands and objects", *planning)
        ->callback(
            [planning, &exitCode]
            {
                const auto pair = [&](const LoadedHand& hand, const LoadedObject& object)
                { return benchPlanning(hand, object, alone(planning->options)); };
                exitCode = run("planning", *planning, pair, &summarizePlans);
            });
}
}  // namespace bullet_ccd::tools
