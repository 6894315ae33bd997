#include "benchmarks/support/checkpoint.h"

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
/// A file that was cut off or changed does not go unnoticed: FNV-1a.
std::uint64_t hashOf(const nlohmann::json& run, const nlohmann::json& state)
{
    std::uint64_t hash = 0xcbf29ce484222325ULL;
    for (const char byte : run.dump() + state.dump())
    {
        hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3ULL;
    }
    return hash;
}
}  // namespace

void saveCheckpoint(const std::string& path, const nlohmann::json& run, const nlohmann::json& state)
{
    const std::string fresh = path + ".new";
    std::ofstream file(fresh);
    file << nlohmann::json{{"run", run}, {"state", state}, {"hash", hashOf(run, state)}}.dump(1)
         << '\n';
    file.close();
    if (!file || std::rename(fresh.c_str(), path.c_str()) != 0)
    {
        throw std::runtime_error(path + ": cannot be written: name another file");
    }
}

std::optional<nlohmann::json> loadCheckpoint(const std::string& path, const nlohmann::json& run)
{
    std::ifstream file(path);
    if (!file)
    {
        return std::nullopt;
    }
    const nlohmann::json kept = nlohmann::json::parse(file, nullptr, false);
    if (!kept.is_object() || !kept.contains("run") || !kept.contains("state") ||
        kept.value("hash", std::uint64_t{0}) != hashOf(kept["run"], kept["state"]))
    {
        throw std::runtime_error(path +
                                 ": not a checkpoint, or damaged: remove it, or name another file");
    }
    if (kept["run"] != run)
    {
        throw std::runtime_error(path + ": belongs to another run, " + kept["run"].dump() +
                                 ", not to " + run.dump() +
                                 ": run without --resume, or name another file");
    }
    return kept["state"];
}
}  // namespace bullet_ccd::benchmarks
