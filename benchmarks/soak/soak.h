/// What soak programs share: a range of seeds, one query for each, answers that are judged and
/// counted, progress, and a checkpoint.
#pragma once

#include "benchmarks/reference/queries/soak_tally.h"

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace CLI
{
class App;
}

namespace bullet_ccd::benchmarks
{
struct SoakAnswer
{
    std::size_t family = 0;  ///< index into SoakSubject::families
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;
    double gap = 0.0;
    reference::Judgement judgement = {};
    std::map<std::string, std::int64_t> counts = {};  ///< of anything else; summed over all answers
};

struct SoakSubject
{
    std::string program = {};  ///< and the settings that change answers: how a user asks again
    std::vector<std::string> families = {};
    std::uint64_t round = 1;  ///< seeds after which families and options repeat: one checkpoint
    reference::SoakShares shares = {};
    std::function<SoakAnswer(std::uint64_t seed)> ask = {};  ///< from several threads
    std::function<void(std::ostream& out, std::uint64_t seed)> print = {};  ///< the query; or none
};

struct SoakOptions
{
    std::uint64_t firstSeed = 1;
    std::uint64_t count = 1;
    std::uint64_t quickCount = 1;
    int jobs = 1;
    bool resume = false;
    bool quick = false;
    bool verbose = false;
    std::string checkpoint = {};
};

/// Adds the options to a command line; their present values are the defaults.
void addSoakOptions(CLI::App& app, SoakOptions& options);

/// Asks the queries, prints progress, wrong answers and a table by family, which do not depend on
/// the number of threads. Returns the exit code: 0 if every answer is right, 1 on a wrong one, 2 if
/// the run proves little, 3 if it could not be run, as with a checkpoint that does not fit. A run
/// that is killed has kept all but the round in hand.
[[nodiscard]] int runSoak(const SoakSubject& subject, const SoakOptions& options);
}  // namespace bullet_ccd::benchmarks
