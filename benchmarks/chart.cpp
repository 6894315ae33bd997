#include "benchmarks/chart.h"

#include "benchmarks/timing.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
struct Point
{
    std::size_t queries = 0;
    int hits = 0;
    int found = 0;
    int missed = 0;
    int late = 0;
    int falseHits = 0;
    int timedOut = 0;
    double meanMicros = 0.0;
    double medianMicros = 0.0;
    std::vector<double> errors;  ///< absolute, of hits found
};

void count(const ChartTruth& truth, const ChartAnswer& answer, double reach, Point& point)
{
    point.hits += truth.hit ? 1 : 0;
    if (answer.timedOut)
    {
        ++point.timedOut;
        return;
    }
    if (!truth.hit)
    {
        point.falseHits += answer.hit && truth.clearance > reach ? 1 : 0;
        return;
    }
    if (!answer.hit)
    {
        ++point.missed;
        return;
    }
    ++point.found;
    // A fraction far outside of the motion, which one peer returns, counts as the end.
    const double time = std::isfinite(answer.time) ? std::clamp(answer.time, 0.0, 1.0) : 1.0;
    point.late += time > truth.time + truth.slack ? 1 : 0;
    point.errors.push_back(std::abs(truth.time - time));
}

nlohmann::json toJson(const ChartScene& scene,
                      const ChartMethod& method,
                      const ChartSetting& setting,
                      const Point& point)
{
    return {{"scene", scene.name},
            {"title", scene.title},
            {"method", method.name},
            {"setting", setting.label},
            {"queries", point.queries},
            {"hits", point.hits},
            {"found", point.found},
            {"missed", point.missed},
            {"late", point.late},
            {"false", point.falseHits},
            {"timedOut", point.timedOut},
            {"meanMicroseconds", point.meanMicros},
            {"medianMicroseconds", point.medianMicros},
            {"medianToiError", medianOf(point.errors)},
            {"maxToiError", point.errors.empty() ? 0.0 : std::ranges::max(point.errors)}};
}
}  // namespace

nlohmann::json chartPoints(const ChartScene& scene,
                           const std::function<void(const std::string&)>& progress)
{
    nlohmann::json points = nlohmann::json::array();
    for (const ChartMethod& method : scene.methods)
    {
        for (const ChartSetting& setting : method.settings)
        {
            const std::vector<ChartAnswer> answers = setting.run();
            Point point{.queries = answers.size(), .errors = {}};
            std::vector<double> micros;
            for (std::size_t i = 0; i < answers.size(); ++i)
            {
                count(scene.truths[i], answers[i], setting.reach, point);
                micros.push_back(answers[i].micros);
                point.meanMicros += answers[i].micros / static_cast<double>(answers.size());
            }
            point.medianMicros = medianOf(micros);
            progress(fmt::format(
                "{:<22}{:<26}{:<9}{:>12.1f} us  error {:.1e}  missed {} late {} false {} "
                "timed out {} of {}",
                scene.name,
                method.name,
                setting.label,
                point.meanMicros,
                medianOf(point.errors),
                point.missed,
                point.late,
                point.falseHits,
                point.timedOut,
                point.queries));
            points.push_back(toJson(scene, method, setting, point));
        }
    }
    return points;
}

void writeChart(const std::string& output,
                const std::string& family,
                const std::vector<std::string>& peers,
                const nlohmann::json& points)
{
    std::ofstream out(output);
    out << nlohmann::json{{"family", family},
                          {"compiler", BULLET_CCD_COMPILER},
                          {"flags", BULLET_CCD_FLAGS},
                          {"peers", peers},
                          {"points", points}}
               .dump(1)
        << '\n';
    if (!out)
    {
        throw std::runtime_error(output + ": cannot be written: name another file");
    }
}
}  // namespace bullet_ccd::benchmarks
