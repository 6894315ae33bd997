#include "tools/soak/checkpoint.h"

#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace bullet_ccd::tests
{
namespace
{
constexpr const char* kHeader = "soak_rigid_checkpoint_1";
}

void save(const Checkpoint& checkpoint, const std::string& path)
{
    const std::string fresh = path + ".new";
    {
        std::ofstream file(fresh);
        file << kHeader << '\n' << checkpoint.firstSeed << ' ' << checkpoint.nextSeed << '\n';
        for (const SoakTally& tally : checkpoint.tallies)
        {
            file << tally.queries << ' ' << tally.hits << ' ' << tally.overlapping << ' '
                 << tally.free;
            for (const std::int64_t count : tally.verdicts)
            {
                file << ' ' << count;
            }
            file << '\n';
        }
        file << checkpoint.failures.size() << '\n';
        for (const std::uint64_t seed : checkpoint.failures)
        {
            file << seed << '\n';
        }
        if (!file.flush())
        {
            throw std::runtime_error(fresh + ": cannot be written: choose another --checkpoint");
        }
    }
    if (std::rename(fresh.c_str(), path.c_str()) != 0)
    {
        throw std::runtime_error(path + ": cannot be replaced: choose another --checkpoint");
    }
}

std::optional<Checkpoint> load(const std::string& path)
{
    std::ifstream file(path);
    if (!file)
    {
        return std::nullopt;
    }
    Checkpoint checkpoint;
    std::string header;
    file >> header >> checkpoint.firstSeed >> checkpoint.nextSeed;
    for (SoakTally& tally : checkpoint.tallies)
    {
        file >> tally.queries >> tally.hits >> tally.overlapping >> tally.free;
        for (std::int64_t& count : tally.verdicts)
        {
            file >> count;
        }
    }
    std::size_t failures = 0;
    file >> failures;
    for (std::size_t i = 0; file && i < failures; ++i)
    {
        std::uint64_t seed = 0;
        file >> seed;
        checkpoint.failures.push_back(seed);
    }
    if (!file || header != kHeader)
    {
        throw std::runtime_error(path + ": not a checkpoint of this program: remove it");
    }
    return checkpoint;
}
}  // namespace bullet_ccd::tests
