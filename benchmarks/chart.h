/// Time against error of the time of contact, for any family of queries: scenes, methods, points.
///
/// A family (rigid bodies, chains, ..) supplies its scenes; everything here is the same for all.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// What is known of a query, independent of the methods.
struct ChartTruth
{
    bool hit = false;
    double time = 1.0;       ///< of first contact
    double slack = 1e-11;    ///< of `time`
    double clearance = 0.0;  ///< smallest distance met, if no hit
};

/// What a method said.
struct ChartAnswer
{
    bool hit = false;
    double time = 1.0;
    double micros = 0.0;
    bool timedOut = false;  ///< `micros` is the limit, the rest means nothing
};

/// One setting of a method: a tolerance, a number of samples.
struct ChartSetting
{
    std::string label;
    /// Distance up to which this setting may call a near miss a hit.
    double reach = 0.0;
    /// Answers and times of the scene's queries, or of its first ones where all would take hours.
    std::function<std::vector<ChartAnswer>()> run;
};

struct ChartMethod
{
    std::string name;
    std::vector<ChartSetting> settings;
};

struct ChartScene
{
    std::string name;
    std::string title;
    std::vector<ChartTruth> truths;
    std::vector<ChartMethod> methods;
};

/// Runs every setting of every method of a scene.
/// @param progress gets a line a method
/// @return the points, as the drawing script reads them; a point that missed, was late or timed out
///         says so and is never left out
[[nodiscard]] nlohmann::json chartPoints(const ChartScene& scene,
                                         const std::function<void(const std::string&)>& progress);

/// Writes the file that tools/chart draws: points of all scenes of a family, and what built them.
/// Throws std::runtime_error if it cannot be written.
void writeChart(const std::string& output,
                const std::string& family,
                const std::vector<std::string>& peers,
                const nlohmann::json& points);
}  // namespace bullet_ccd::benchmarks
