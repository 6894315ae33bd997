/// What a soak program asks: one query for every seed, answered by the library and judged.
#pragma once

#include "benchmarks/reference/queries/soak_tally.h"

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
struct SoakAnswer
{
    std::size_t family = 0;  ///< index into SoakSubject::families
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;
    double gap = 0.0;
    Judgement judgement = {};
};

struct SoakSubject
{
    std::string program = {};      ///< under which tools/ runs it
    std::string description = {};  ///< a sentence
    std::vector<std::string> families = {};
    std::uint64_t round = 1;  ///< seeds after which families and options repeat: handed out at once
    SoakShares shares = {};
    std::uint64_t count = 1;                                 ///< of queries, unless asked otherwise
    std::function<SoakAnswer(std::uint64_t seed)> ask = {};  ///< from several threads
    std::function<void(std::ostream& out, std::uint64_t seed)> print = {};  ///< the query
};
}  // namespace bullet_ccd::tests
