#include "tools/ccd_cli/text/batch_summary.h"

#include "tools/ccd_cli/text/result_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
std::string timesText(const std::string& name, const std::vector<double>& times)
{
    if (times.empty())
    {
        return fmt::format("{}: none\n", name);
    }
    const double sum = std::accumulate(times.begin(), times.end(), 0.0);
    return fmt::format("{}: mean {:.2f}, median {:.2f}, p95 {:.2f}\n",
                       name,
                       sum / static_cast<double>(times.size()),
                       quantile(times, 0.5),
                       quantile(times, 0.95));
}

std::vector<double> timesOf(std::span<const TimedAnswer> answers, double TimedAnswer::*member)
{
    std::vector<double> times;
    times.reserve(answers.size());
    for (const TimedAnswer& answer : answers)
    {
        times.push_back(answer.*member);
    }
    return times;
}
}  // namespace

std::string summaryText(const BatchSummary& summary)
{
    std::string text = fmt::format("rows: {}\n", summary.answers.size() + summary.badRows);
    for (const ToiStatus status : {ToiStatus::Hit,
                                   ToiStatus::Separated,
                                   ToiStatus::Overlapping,
                                   ToiStatus::TouchingLeaving,
                                   ToiStatus::TouchingPressing,
                                   ToiStatus::IterationLimit,
                                   ToiStatus::Stopped})
    {
        const auto count = std::count_if(summary.answers.begin(),
                                         summary.answers.end(),
                                         [&](const TimedAnswer& answer)
                                         { return answer.result.status == status; });
        text += fmt::format("{}: {}\n", statusWord(status), count);
    }
    text += fmt::format("{}: {}\n", kBadRowWord, summary.badRows);
    text += timesText("microseconds", timesOf(summary.answers, &TimedAnswer::microseconds));
    if (summary.warm)
    {
        text += timesText("warm_microseconds",
                          timesOf(summary.answers, &TimedAnswer::warmMicroseconds));
    }
    text +=
        fmt::format("seconds: loading meshes {:.4f}, building hierarchies {:.4f}, queries {:.4f}\n",
                    summary.loadSeconds,
                    summary.buildSeconds,
                    summary.wallSeconds);
    return summary.needed ? text + "needed: " + plainText(*summary.needed) + "\n" : text;
}
}  // namespace bullet_ccd::tools
