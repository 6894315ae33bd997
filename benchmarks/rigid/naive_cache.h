/// FCL's sampled answers kept in a file, so that a re-run while tuning takes seconds.
///
/// Cached times are a rough yardstick only: they were measured in another run.
#pragma once

#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/rigid/rigid_sets.h"

#include <map>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
struct NaiveRun
{
    std::vector<FclAnswer> answers;
    double meanMicros = 0.0;
};

class NaiveCache
{
public:
    /// Reads the file if it exists; an empty name keeps nothing.
    explicit NaiveCache(std::string file);

    /// Null if the very same queries were not stored.
    [[nodiscard]] const NaiveRun* find(const RigidSet& set) const;
    void store(const RigidSet& set, NaiveRun run);
    /// Throws std::runtime_error if the file cannot be written.
    void save() const;

private:
    std::string m_file;
    std::map<std::string, NaiveRun> m_runs;
};
}  // namespace bullet_ccd::benchmarks
