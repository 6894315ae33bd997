/// Time against error for any family of queries: scenes, methods, points.
///
/// A family (rigid bodies, chains, closings, steps of a world) supplies its scenes; everything here
/// is the same for all.
#pragma once

#include "benchmarks/support/program.h"
#include "benchmarks/support/timing.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
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

/// All queries in sequence, `passes` times; of what the call returns, the median time counts.
template <typename Call>
auto askAll(std::size_t queries, int passes, const Call& call)
{
    std::vector<decltype(call(queries))> answers(queries);
    std::vector<std::vector<double>> times(queries);
    for (int pass = 0; pass < passes; ++pass)
    {
        for (std::size_t i = 0; i < queries; ++i)
        {
            answers[i] = call(i);
            times[i].push_back(answers[i].micros);
        }
    }
    for (std::size_t i = 0; i < queries; ++i)
    {
        answers[i].micros = medianOf(times[i]);
    }
    return answers;
}

/// A setting that is asked for times of contact.
/// @param reach distance up to which it may call a near miss a hit
[[nodiscard]] ChartSetting toiSetting(std::string label,
                                      double reach,
                                      SharedTruths truths,
                                      std::function<std::vector<ChartAnswer>()> ask);

/// Asks queries 0 .. count - 1 in a sandbox; one that takes longer than `seconds` is timedOut.
[[nodiscard]] std::vector<ChartAnswer> runWithLimit(
    std::size_t count, double seconds, const std::function<ChartAnswer(std::size_t)>& ask);

/// One value of what a method for times of contact can be set to.
struct ToiSetting
{
    std::string label;
    double value = 0.0;
    double reach = 0.0;  ///< see toiSetting()
};
/// Tolerances of `unit` times 1e-first to 1e-last.
[[nodiscard]] std::vector<ToiSetting> tolerances(int first, int last, double unit = 1.0);
[[nodiscard]] std::vector<ToiSetting> sampleCounts(const std::vector<int>& counts);

/// A method that answers query i with a setting; the median time of the passes counts.
[[nodiscard]] ChartMethod toiMethod(const std::string& name,
                                    const SharedTruths& truths,
                                    const std::vector<ToiSetting>& settings,
                                    const std::function<ChartAnswer(std::size_t, double)>& answer,
                                    int passes = 1);

/// What every family can be asked.
struct ChartOptions
{
    std::filesystem::path data;
    bool quick = false;
    int repeats = 3;  ///< of fast methods; the median counts
};

/// The program of a family.
struct ChartProgram
{
    ChartFamily family;
    std::vector<std::string> scenes;            ///< names of all
    std::size_t quickScenes = std::size_t(-1);  ///< with --quick only so many
    std::vector<ProgramOption> options{};       ///< beyond those of ChartOptions
    std::function<ChartScene(const std::string& scene, const ChartOptions& options)> makeScene;
};

/// Runs every setting of every method of the scenes that are asked for, prints a line for each, and
/// writes the file that benchmarks/run chart draws: all points, and what built them. A point that
/// missed, was late or timed out says so and is never left out.
/// @return exit code
[[nodiscard]] int runChart(int argc, char** argv, const ChartProgram& program);
}  // namespace bullet_ccd::benchmarks
