#include "tools/ccd_cli/run/certify_run.h"

#include "bullet_ccd/io/nearest_name.h"
#include "tools/support/stopwatch.h"

#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
/// What a name stands for.
struct Named
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;
};

Named find(const RobotLinks& links, std::span<const Obstacle> obstacles, const std::string& name)
{
    if (const std::int32_t link = links.robot.tree.findLink(name); link != kNone)
    {
        return {.link = link};
    }
    std::vector<std::string> known;
    for (const Link& link : links.robot.tree.links)
    {
        known.push_back(link.name);
    }
    for (std::size_t k = 0; k < obstacles.size(); ++k)
    {
        if (obstacles[k].name == name)
        {
            return {.obstacle = static_cast<std::int32_t>(k)};
        }
        known.push_back(obstacles[k].name);
    }
    throw std::runtime_error(
        fmt::format("--allow: {}: no link, attached object or obstacle has this name: did you mean "
                    "{}?",
                    name,
                    nearestName(name, known)));
}

/// A mask that exempts everything.
std::unique_ptr<const PairMask> wholeMask(const SsvTree& a, const SsvTree& b)
{
    const std::vector<std::uint8_t> marksA(a.mesh().triangles.size(), 1);
    const std::vector<std::uint8_t> marksB(b.mesh().triangles.size(), 1);
    return std::make_unique<const PairMask>(a, b, marksA, marksB);
}
}  // namespace

Verdict verdictOf(const Certificate& certificate)
{
    if (!certificate.error.empty())
    {
        return Verdict::BadInput;
    }
    if (gaveUp(certificate.toi.status))
    {
        return Verdict::Unknown;
    }
    return isContact(certificate.toi.status) ? Verdict::Contact : Verdict::Free;
}

Certificate certify(const RobotLinks& links,
                    std::span<const RigidBody> obstacles,
                    const Trajectory& trajectory,
                    const CertifyOptions& options)
{
    const Environment environment(obstacles);
    const ArticulatedBody body{.tree = &links.robot.tree,
                               .linkTrees = links.linkTrees,
                               .selfPairs = links.selfPairs,
                               .masks = links.linkMasks};
    const Stopwatch watch;
    Certificate certificate;
    certificate.segments = trajectory.segments.size();
    certificate.start = trajectory.times.front();
    ToiOptions toi = options.toi;
    toi.strategy = ToiStrategy::Interval;
    certificate.toi = trajectoryToi(body, environment, trajectory, {.toi = toi}, options.work);
    if (options.wantsDistance && verdictOf(certificate) == Verdict::Free)
    {
        const TrajectoryLeastDistance least =
            leastDistance(body,
                          obstacles,
                          trajectory,
                          {.tolerance = options.toi.tolerance,
                           .maxIterations = options.toi.maxIterations,
                           .stop = options.toi.stop},
                          options.work);
        if (std::isfinite(least.found) || gaveUp(least.status))
        {
            certificate.least = least;
        }
    }
    certificate.microseconds = 1e6 * watch.seconds();
    return certificate;
}

void allowPair(RobotLinks& links, std::span<const Obstacle> obstacles, const AllowedPair& pair)
{
    Named a = find(links, obstacles, pair.a);
    Named b = find(links, obstacles, pair.b);
    if (a.link == kNone)
    {
        std::swap(a, b);
    }
    if (a.link == kNone)
    {
        throw std::runtime_error(fmt::format(
            "--allow: {},{}: two obstacles are never tested: name a link or an attached object",
            pair.a,
            pair.b));
    }
    if (b.link != kNone)
    {
        std::erase_if(
            links.selfPairs,
            [&](const auto& tested) {
                return tested == std::pair{a.link, b.link} || tested == std::pair{b.link, a.link};
            });
        return;
    }
    const SsvTree* tree = links.linkTrees[static_cast<std::size_t>(a.link)];
    if (tree != nullptr)
    {
        links.masks.push_back(
            wholeMask(*tree, *obstacles[static_cast<std::size_t>(b.obstacle)].tree));
        links.linkMasks.push_back(
            {.link = a.link, .obstacle = b.obstacle, .mask = links.masks.back().get()});
    }
}
}  // namespace bullet_ccd::tools
