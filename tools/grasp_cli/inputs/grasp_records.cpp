#include "tools/grasp_cli/inputs/grasp_records.h"

#include "grasp/formats/content_hash.h"
#include "tools/support/command_line.h"

#include <algorithm>
#include <fmt/format.h>
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
}  // namespace

GraspRecords loadGraspRecords(const RecordArguments& arguments)
{
    grasp::GraspFileSource source = grasp::readGraspSource(arguments.file, true);
    const grasp::GraspRun& run = source.run;
    // An SRDF that is gone may have moved with its hand; the content hash tells another one.
    LoadedHand hand = loadNamedHand(arguments.hand.empty() ? run.handFile.string() : arguments.hand,
                                    fs::exists(run.srdfFile) ? run.srdfFile : fs::path());
    LoadedObject object = loadNamedObject(
        arguments.object.empty() ? run.objectFile.string() : arguments.object, run.objectScale);
    requireSameContent(hand.file, grasp::contentHash(hand.hand), source.handHash);
    requireSameContent(object.file, grasp::contentHash(object.object), source.objectHash);
    std::vector<std::string> damaged;
    std::vector<grasp::Grasp> grasps = grasp::readGrasps(arguments.file, hand.hand, &damaged);
    for (const std::string& line : damaged)
    {
        fmt::print(stderr, "left out: {}\n", line);
    }
    return {.source = std::move(source),
            .hand = std::move(hand),
            .object = std::move(object),
            .grasps = std::move(grasps),
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
        if (rank < 1 || static_cast<std::size_t>(rank) > grasps.size())
        {
            throw std::runtime_error(fmt::format(
                "{}: no grasp of rank {}: give 1 to {}", arguments.file, rank, grasps.size()));
        }
        chosen.insert(static_cast<std::size_t>(rank) - 1);
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
