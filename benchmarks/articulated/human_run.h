/// Answers, checks and times of the human among chessmen.
#pragma once

#include "benchmarks/articulated/human_peers.h"
#include "benchmarks/articulated/human_scene.h"

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// The query, whole or with a stage of it switched off.
struct Stage
{
    const char* name;
    ArticulatedToiOptions options;
};

/// The whole query first.
[[nodiscard]] std::vector<Stage> humanStages();

/// Sums over the queries of a method.
struct Mix
{
    std::string method{};
    int queries = 0;
    int contacts = 0;
    int exemptContacts = 0;  ///< of those, by a pair that intersects at the start, elsewhere on it
    int busy = 0;            ///< free with three pairs or more after spatial culling
    int exempt = 0;          ///< with pairs that intersect at the start
    int wrong = 0;
    double late = 0.0;   ///< largest, against rigidToi() on each pair
    double early = 0.0;  ///< the same
    ArticulatedCounters counters{};
    double micros = 0.0;
    double microsOfContacts = 0.0;  ///< of those queries alone
};

void add(Mix& sum, const Mix& more);

/// One motion in its scene.
class HumanRun
{
public:
    HumanRun(const std::filesystem::path& data, const std::string& name, bool withFcl);

    void describe(bool listExempt) const;

    /// Asks all and compares the answers, then takes the times of all but FCL in turns.
    /// @return the stages, then rigidToi() on each pair, then FCL if it is asked
    [[nodiscard]] std::vector<Mix> run(std::span<const Stage> stages, int repeats);

private:
    void askPeers();
    [[nodiscard]] Mix check(const Stage& stage, std::vector<bool>& hits);
    [[nodiscard]] bool isWrong(std::size_t query, const ArticulatedToiResult& result) const;
    [[nodiscard]] bool isApartAt(const HumanQuery& query, const LinkContact& contact) const;
    [[nodiscard]] double distanceOf(const HumanQuery& query, const LinkContact& contact) const;

    std::string m_name;
    HumanScene m_scene;
    Environment m_environment;
    std::unique_ptr<FclHuman> m_fcl;
    std::vector<double> m_rigidTimes;   ///< of contact
    std::vector<double> m_sampleTimes;  ///< FCL's first sample that overlaps
    double m_fclMicros = 0.0;
    ToiWorkspace m_work;
};
}  // namespace bullet_ccd::benchmarks
