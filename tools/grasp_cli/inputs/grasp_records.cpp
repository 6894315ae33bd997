#include "tools/grasp_cli/inputs/grasp_records.h"

#include "grasp/formats/content_hash.h"
#include "tools/support/command_line.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

void requireSameContent(const fs::path& file, const std::string& now, const std::string& then)
{
    if (now != then)
    {
        throw std::runtime_error(fmt::format(
            "{}: content hash {} differs from {} that the grasps were planned with: restore the "
            "file or plan again",
            file.string(),
            now,
            then));
    }
}

/// The file that a record names, or where it is now.
std::string inputOf(const std::string& given,
                    const fs::path& recorded,
                    const RecordArguments& arguments,
                    const std::string& option)
{
    if (given.empty() && !fs::exists(recorded))
    {
        throw std::runtime_error(
            fmt::format("{}: {} is not there any more: say where it is with {}",
                        arguments.file,
                        recorded.string(),
                        option));
    }
    return given.empty() ? recorded.string() : given;
}

/// Such as "1 to 10", or "2, 3, 5" where some are missing.
std::string ranksText(std::vector<int> ranks)
{
    std::ranges::sort(ranks);
    if (!ranks.empty() && ranks.front() == 1 && ranks.back() == static_cast<int>(ranks.size()))
    {
        return fmt::format("1 to {}", ranks.size());
    }
    return ranks.empty() ? "none" : fmt::format("{}", fmt::join(ranks, ", "));
}
}  // namespace

GraspRecords loadGraspRecords(const RecordArguments& arguments)
{
    grasp::GraspFileSource source = grasp::readGraspSource(arguments.file, true);
    const grasp::GraspRun& run = source.run;
    // An SRDF that is gone may have moved with its hand; the content hash tells another one.
    LoadedHand hand = loadNamedHand(inputOf(arguments.hand, run.handFile, arguments, "--hand"),
                                    fs::exists(run.srdfFile) ? run.srdfFile : fs::path());
    LoadedObject object = loadNamedObject(
        inputOf(arguments.object, run.objectFile, arguments, "--object"), run.objectScale);
    requireSameContent(hand.file, grasp::contentHash(hand.hand), source.handHash);
    requireSameContent(object.file, grasp::contentHash(object.object), source.objectHash);
    std::vector<std::string> damaged;
    std::vector<int> ranks;
    std::vector<grasp::Grasp> grasps =
        grasp::readGrasps(arguments.file, hand.hand, &damaged, &ranks);
    for (const std::string& line : damaged)
    {
        fmt::print(stderr, "left out: {}\n", line);
    }
    return {.source = std::move(source),
            .hand = std::move(hand),
            .object = std::move(object),
            .grasps = std::move(grasps),
            .ranks = std::move(ranks),
            .isDamaged = !damaged.empty()};
}

int GraspRecords::exitCode(int code) const
{
    return isDamaged ? kBadInput : code;
}

std::vector<std::size_t> chosenGrasps(const GraspRecords& records,
                                      const RecordArguments& arguments,
                                      const RecordChoice& choice)
{
    const std::vector<grasp::Grasp>& grasps = records.grasps;
    std::set<std::size_t> chosen;
    for (const int rank : choice.ranks)
    {
        const auto found = std::ranges::find(records.ranks, rank);
        if (found == records.ranks.end())
        {
            throw std::runtime_error(fmt::format("{}: no grasp of rank {}: it has {}",
                                                 arguments.file,
                                                 rank,
                                                 ranksText(records.ranks)));
        }
        chosen.insert(static_cast<std::size_t>(found - records.ranks.begin()));
    }
    for (const std::int64_t candidate : choice.candidates)
    {
        const auto found =
            std::find_if(grasps.begin(),
                         grasps.end(),
                         [&](const grasp::Grasp& grasp) { return grasp.candidate == candidate; });
        if (found == grasps.end())
        {
            throw std::runtime_error(
                fmt::format("{}: no grasp of candidate {}: see its key "
                            "\"candidate\"",
                            arguments.file,
                            candidate));
        }
        chosen.insert(static_cast<std::size_t>(found - grasps.begin()));
    }
    const bool all = choice.ranks.empty() && choice.candidates.empty();
    for (std::size_t k = 0; all && k < grasps.size(); ++k)
    {
        if (grasps[k].reject == grasp::RejectReason::None)
        {
            chosen.insert(k);
        }
    }
    return {chosen.begin(), chosen.end()};
}
}  // namespace bullet_ccd::tools
