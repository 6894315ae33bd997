/// What soak programs share: a range of seeds, one query for each, answers that are judged and
/// counted, progress, and a checkpoint.
#pragma once

#include "benchmarks/reference/queries/soak_tally.h"
#include "benchmarks/support/program.h"

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

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
    int count = 1;
    int quickCount = 1;
    int jobs = 1;
    std::string checkpoint = {};
    std::uint64_t firstSeed = 1;
    bool resume = false;
    bool quick = false;
    bool verbose = false;
};

/// A program, or one of its verbs, that asks the queries and prints progress, wrong answers and a
/// table by family, which do not depend on the number of threads. It fails on a wrong answer, and
/// if the run proves little. A run that is killed has kept all but the round in hand.
/// @param defaults  of the options that all soaks have
/// @param subject   made when the command line is known
/// @param more      options of this one
[[nodiscard]] Program soakProgram(const std::string& name,
                                  const std::string& about,
                                  const SoakOptions& defaults,
                                  const std::function<SoakSubject(bool quick)>& subject,
                                  const std::vector<ProgramOption>& more = {});
}  // namespace bullet_ccd::benchmarks
