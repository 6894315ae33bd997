#include "benchmarks/soak/checkpoint.h"

#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace bullet_ccd::tests
{
namespace
{
constexpr const char* kEnd = "end";  // a file that was cut off does not have it

std::string headerOf(const SoakSubject& subject)
{
    return subject.program + "_checkpoint_2";
}

/// What else holds for the counts of a run: a file that was changed by hand or by a disk does not
/// go unnoticed.
bool isConsistent(const Checkpoint& checkpoint)
{
    std::int64_t queries = 0;
    std::int64_t wrong = 0;
    for (const SoakTally& tally : checkpoint.tallies)
    {
        if (!tally.isConsistent())
        {
            return false;
        }
        queries += tally.queries;
        wrong += tally.wrong();
    }
    return checkpoint.nextSeed >= checkpoint.firstSeed &&
           checkpoint.nextSeed - checkpoint.firstSeed == static_cast<std::uint64_t>(queries) &&
           checkpoint.failures.size() == static_cast<std::size_t>(wrong);
}

void write(std::ostream& file, const Checkpoint& checkpoint, const SoakSubject& subject)
{
    file << headerOf(subject) << '\n'
         << checkpoint.firstSeed << ' ' << checkpoint.nextSeed << ' ' << checkpoint.tallies.size()
         << '\n';
    for (const SoakTally& tally : checkpoint.tallies)
    {
        file << tally.queries << ' ' << tally.hits << ' ' << tally.overlapping << ' ' << tally.free;
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
    file << kEnd << '\n';
}

/// Fails the stream where the file is not one of ours.
Checkpoint read(std::istream& file, const SoakSubject& subject)
{
    Checkpoint checkpoint;
    std::string header;
    std::size_t families = 0;
    file >> header >> checkpoint.firstSeed >> checkpoint.nextSeed >> families;
    if (header != headerOf(subject) || families != subject.families.size())
    {
        file.setstate(std::ios::failbit);
        return checkpoint;
    }
    checkpoint.tallies.resize(families);
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
    std::string end;
    file >> end;
    if (end != kEnd || !isConsistent(checkpoint))
    {
        file.setstate(std::ios::failbit);
    }
    return checkpoint;
}
}  // namespace

void save(const Checkpoint& checkpoint, const SoakSubject& subject, const std::string& path)
{
    const std::string fresh = path + ".new";
    {
        std::ofstream file(fresh);
        write(file, checkpoint, subject);
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

std::optional<Checkpoint> load(const SoakSubject& subject, const std::string& path)
{
    std::ifstream file(path);
    if (!file)
    {
        return std::nullopt;
    }
    Checkpoint checkpoint = read(file, subject);
    if (!file)
    {
        throw std::runtime_error(path + ": not a checkpoint of " + subject.program +
                                 ", or damaged: remove it, or choose another --checkpoint");
    }
    return checkpoint;
}
}  // namespace bullet_ccd::tests
