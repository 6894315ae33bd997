#include "benchmarks/support/chart.h"

#include "benchmarks/support/report.h"
#include "benchmarks/support/sandbox.h"
#include "benchmarks/support/timing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
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
    for (const auto& [end, answer, time] :
         sandboxedAnswers<ChartAnswer>(count, {.seconds = seconds}, ask))
    {
        answers.push_back(end == SandboxEnd::Answered
                              ? answer
                              : ChartAnswer{.micros = 1e6 * seconds, .timedOut = true});
    }
    return answers;
}

nlohmann::json chartPoints(const ChartScene& scene)
{
    nlohmann::json points = nlohmann::json::array();
    for (const ChartMethod& method : scene.methods)
    {
        for (const ChartSetting& setting : method.settings)
        {
            nlohmann::json point = pointOf(setting.run());
            fmt::print(
                "{:<22}{:<30}{:<14}{:>12.1f} us  error {:.1e}  missed {} late {} false {} "
                "timed out {} of {}\n",
                scene.name,
                method.name,
                setting.label,
                point["meanMicroseconds"].get<double>(),
                point["medianError"].get<double>(),
                point["missed"].get<int>(),
                point["late"].get<int>(),
                point["false"].get<int>(),
                point["timedOut"].get<int>(),
                point["queries"].get<int>());
            std::fflush(stdout);
            point["scene"] = scene.name;
            point["title"] = scene.title;
            point["method"] = method.name;
            point["setting"] = setting.label;
            points.push_back(std::move(point));
        }
    }
    return points;
}

void writeChart(const std::string& output, const ChartFamily& family, const nlohmann::json& points)
{
    std::vector<std::string> peers = family.peers;
    std::erase(peers, std::string());
    writeReport(output,
                {{"family", family.name},
                 {"title", family.title},
                 {"time", family.time},
                 {"error", family.error},
                 {"flaws",
                  {{"missed", family.missed},
                   {"late", family.late},
                   {"false", family.falseHit},
                   {"timedOut", family.timedOut}}},
                 {"peers", peers},
                 {"points", points}});
}
}  // namespace bullet_ccd::benchmarks
