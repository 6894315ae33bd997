#include "benchmarks/support/chart.h"

#include "benchmarks/support/files.h"
#include "benchmarks/support/sandbox.h"
#include "benchmarks/support/table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
ChartOutcome judge(const ChartTruth& truth, const ChartAnswer& answer, double reach)
{
    ChartOutcome outcome{.micros = answer.micros, .hit = truth.hit};
    if (answer.timedOut)
    {
        outcome.flaw = ChartFlaw::TimedOut;
        return outcome;
    }
    if (!truth.hit)
    {
        const bool isFalse = answer.hit && truth.clearance > reach;
        outcome.flaw = isFalse ? ChartFlaw::False : ChartFlaw::None;
        return outcome;
    }
    if (!answer.hit)
    {
        outcome.flaw = ChartFlaw::Missed;
        return outcome;
    }
    // A fraction far outside of the motion, which one peer returns, counts as the end.
    const double time = std::isfinite(answer.time) ? std::clamp(answer.time, 0.0, 1.0) : 1.0;
    outcome.flaw = time > truth.time + truth.slack ? ChartFlaw::Late : ChartFlaw::None;
    outcome.error = std::abs(truth.time - time);
    return outcome;
}

nlohmann::json pointOf(const std::vector<ChartOutcome>& outcomes)
{
    std::vector<double> micros;
    std::vector<double> errors;
    double sum = 0.0;
    for (const ChartOutcome& outcome : outcomes)
    {
        sum += outcome.micros;
        micros.push_back(outcome.micros);
        if (outcome.error)
        {
            errors.push_back(*outcome.error);
        }
    }
    const auto number = [&](ChartFlaw flaw)
    { return std::ranges::count(outcomes, flaw, &ChartOutcome::flaw); };
    return {
        {"queries", outcomes.size()},
        {"hits", std::ranges::count(outcomes, true, &ChartOutcome::hit)},
        {"found", errors.size()},
        {"missed", number(ChartFlaw::Missed)},
        {"late", number(ChartFlaw::Late)},
        {"false", number(ChartFlaw::False)},
        {"timedOut", number(ChartFlaw::TimedOut)},
        {"meanMicroseconds", sum / static_cast<double>(std::max<std::size_t>(micros.size(), 1))},
        {"medianMicroseconds", medianOf(micros)},
        {"medianError", medianOf(errors)},
        {"maxError", errors.empty() ? 0.0 : std::ranges::max(errors)}};
}

void addPoints(const ChartScene& scene, const Table& table, nlohmann::json& points)
{
    for (const ChartMethod& method : scene.methods)
    {
        for (const ChartSetting& setting : method.settings)
        {
            nlohmann::json point = pointOf(setting.run());
            point["scene"] = scene.name;
            point["title"] = scene.title;
            point["method"] = method.name;
            point["setting"] = setting.label;
            table.print(point);
            points.push_back(std::move(point));
        }
    }
}

nlohmann::json measured(const ChartFamily& family, nlohmann::json points)
{
    std::vector<std::string> peers = family.peers;
    std::erase(peers, std::string());
    return {{"family", family.name},
            {"title", family.title},
            {"time", family.time},
            {"error", family.error},
            {"flaws",
             {{"missed", family.missed},
              {"late", family.late},
              {"false", family.falseHit},
              {"timedOut", family.timedOut}}},
            {"peers", peers},
            {"points", std::move(points)}};
}
}  // namespace

ChartFamily toiFamily(const std::string& name, const std::string& title)
{
    return {.name = name,
            .title = title,
            .time = "time of a query",
            .error = "error of the time, part of the motion",
            .missed = "missed",
            .late = "late",
            .falseHit = "false",
            .timedOut = "too slow",
            .peers = {}};
}

ChartSetting toiSetting(std::string label,
                        double reach,
                        SharedTruths truths,
                        std::function<std::vector<ChartAnswer>()> ask)
{
    return {.label = std::move(label),
            .run = [reach, truths = std::move(truths), ask = std::move(ask)]
            {
                const std::vector<ChartAnswer> answers = ask();
                std::vector<ChartOutcome> outcomes;
                for (std::size_t i = 0; i < answers.size(); ++i)
                {
                    outcomes.push_back(judge((*truths)[i], answers[i], reach));
                }
                return outcomes;
            }};
}

std::vector<ChartAnswer> runWithLimit(std::size_t count,
                                      double seconds,
                                      const std::function<ChartAnswer(std::size_t)>& ask)
{
    std::vector<ChartAnswer> answers;
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto one = sandboxedAnswer<ChartAnswer>(seconds, [&] { return ask(i); });
        answers.push_back(one.end == SandboxEnd::Answered
                              ? one.answer
                              : ChartAnswer{.micros = 1e6 * seconds, .timedOut = true});
    }
    return answers;
}

std::vector<ToiSetting> tolerances(int first, int last, double unit)
{
    std::vector<ToiSetting> settings;
    for (int exponent = first; exponent <= last; ++exponent)
    {
        const double tolerance = unit * std::pow(10.0, -exponent);
        settings.push_back(
            {.label = fmt::format("1e-{}", exponent), .value = tolerance, .reach = tolerance});
    }
    return settings;
}

std::vector<ToiSetting> sampleCounts(const std::vector<int>& counts)
{
    std::vector<ToiSetting> settings;
    for (const int count : counts)
    {
        settings.push_back({.label = fmt::format("x{}", count), .value = double(count)});
    }
    return settings;
}

ChartMethod toiMethod(const std::string& name,
                      const SharedTruths& truths,
                      const std::vector<ToiSetting>& settings,
                      const std::function<ChartAnswer(std::size_t, double)>& answer,
                      int passes)
{
    ChartMethod method{.name = name, .settings = {}};
    for (const ToiSetting& setting : settings)
    {
        const auto ask = [answer, value = setting.value](std::size_t i)
        {
            ChartAnswer result;
            const double micros = microsecondsOf([&] { result = answer(i, value); });
            result.micros = micros;
            return result;
        };
        method.settings.push_back(toiSetting(setting.label,
                                             setting.reach,
                                             truths,
                                             [=] { return askAll(truths->size(), passes, ask); }));
    }
    return method;
}

int runChart(int argc, char** argv, const ChartProgram& program)
{
    std::string output;
    ChartOptions options{.data = defaultDataFolder()};
    std::vector<std::string> scenes = program.scenes;
    std::vector<ProgramOption> all{
        {.names = "-o,--output", .value = &output, .help = "JSON file", .isRequired = true},
        {"--data", &options.data, "data folder"},
        {"--scene,--set,--motion", &scenes, "names of scenes"},
        {"--repeats", &options.repeats, "of fast methods"},
        {"--quick", &options.quick, "few queries a scene"}};
    all.insert(all.end(), program.options.begin(), program.options.end());
    const auto run = [&]
    {
        if (options.quick)
        {
            scenes.resize(std::min(scenes.size(), program.quickScenes));
        }
        const Table table(
            "scene:<22|method:<30|setting:<14|us=meanMicroseconds:>12.1f|error=medianError:>9.1e|"
            "missed:>6|late:>6|false:>6|timed out=timedOut:>9|queries:>7");
        nlohmann::json points = nlohmann::json::array();
        for (const std::string& scene : scenes)
        {
            addPoints(program.makeScene(scene, options), table, points);
        }
        writeReport(output, measured(program.family, std::move(points)));
        return true;
    };
    return runProgram(argc,
                      argv,
                      {.name = "chart_" + program.family.name,
                       .about = "Time against error: " + program.family.title,
                       .options = all,
                       .run = run});
}
}  // namespace bullet_ccd::benchmarks
