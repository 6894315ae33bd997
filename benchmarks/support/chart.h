/// Time against error for any family of queries: scenes, methods, points.
///
/// A family (rigid bodies, chains, closings, steps of a world) supplies its scenes; everything here
/// is the same for all.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// What was wrong with an answer. A family says in its words what that means.
enum class ChartFlaw : std::uint8_t
{
    None,
    Missed,
    Late,
    False,
    TimedOut,
};

/// How a query went.
struct ChartOutcome
{
    double micros = 0.0;
    bool hit = false;  ///< there is something to find
    ChartFlaw flaw = ChartFlaw::None;
    std::optional<double> error{};  ///< of what was found, >= 0; none if nothing was
};

/// One setting of a method: a tolerance, a number of samples.
struct ChartSetting
{
    std::string label;
    /// Asks the scene's queries, or its first ones where all would take hours.
    std::function<std::vector<ChartOutcome>()> run;
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
    std::vector<ChartMethod> methods;
};

/// What the chart says of all scenes of a family.
struct ChartFamily
{
    std::string name;
    std::string title;
    std::string time;   ///< what the times are of
    std::string error;  ///< what the errors are of, with its unit
    // Words for the flaws; empty: cannot happen.
    std::string missed;
    std::string late;
    std::string falseHit;
    std::string timedOut;
    std::vector<std::string> peers;  ///< names and versions; empty ones are left out
};

/// What is known of a query for a time of contact, independent of the methods.
struct ChartTruth
{
    bool hit = false;
    double time = 1.0;       ///< of first contact
    double slack = 1e-11;    ///< of `time`
    double clearance = 0.0;  ///< smallest distance met, if no hit
};
using SharedTruths = std::shared_ptr<const std::vector<ChartTruth>>;

/// What a method said when asked for a time of contact.
struct ChartAnswer
{
    bool hit = false;
    double time = 1.0;
    double micros = 0.0;
    bool timedOut = false;  ///< `micros` is the limit, the rest means nothing
};

/// A family of queries for times of contact, with its flaws and errors.
[[nodiscard]] ChartFamily toiFamily(const std::string& name, const std::string& title);

/// A setting that is asked for times of contact.
/// @param reach distance up to which it may call a near miss a hit
[[nodiscard]] ChartSetting toiSetting(std::string label,
                                      double reach,
                                      SharedTruths truths,
                                      std::function<std::vector<ChartAnswer>()> ask);

/// Asks queries 0 .. count - 1 in a sandbox; one that takes longer than `seconds` is timedOut.
[[nodiscard]] std::vector<ChartAnswer> runWithLimit(
    std::size_t count, double seconds, const std::function<ChartAnswer(std::size_t)>& ask);

/// Runs every setting of every method of a scene; prints a line for each.
/// @return the points, as the drawing script reads them; a point that missed, was late or timed out
///         says so and is never left out
[[nodiscard]] nlohmann::json chartPoints(const ChartScene& scene);

/// Writes the file that benchmarks/run chart draws: points of all scenes of a family, and what
/// built them. Throws std::runtime_error if it cannot be written.
void writeChart(const std::string& output, const ChartFamily& family, const nlohmann::json& points);
}  // namespace bullet_ccd::benchmarks
