#include "grasp/hand/sampled_pairs.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <tinyxml2.h>

namespace bullet_ccd::grasp
{
namespace
{
using Poses = std::vector<Eigen::Isometry3d>;

/// Where random positions of a joint lie; both ends equal for a joint that rests.
std::pair<double, double> rangeOf(const Joint& joint)
{
    if (std::isfinite(joint.lower) && std::isfinite(joint.upper))
    {
        return {joint.lower, joint.upper};
    }
    const double half = joint.type == JointType::Revolute ? std::numbers::pi : 0.0;
    const double middle = std::clamp(0.0, joint.lower, joint.upper);
    return {std::max(joint.lower, middle - half), std::min(joint.upper, middle + half)};
}

Poses posesAtRest(const KinematicTree& tree)
{
    std::vector<double> positions;
    for (const Link& link : tree.links)
    {
        positions.push_back(std::clamp(0.0, link.joint.lower, link.joint.upper));
    }
    applyMimics(tree, positions);
    return linkPoses(tree, Eigen::Isometry3d::Identity(), positions);
}

class RandomPoses
{
public:
    RandomPoses(const KinematicTree& tree, std::uint64_t seed) : m_tree(tree), m_engine(seed) {}

    Poses next()
    {
        std::vector<double> positions(m_tree.size(), 0.0);
        for (std::size_t i = 1; i < m_tree.size(); ++i)
        {
            const auto [lower, upper] = rangeOf(m_tree.links[i].joint);
            positions[i] = lower + (upper - lower) * share();
        }
        applyMimics(m_tree, positions);
        return linkPoses(m_tree, Eigen::Isometry3d::Identity(), positions);
    }

private:
    /// Uniform in [0, 1), the same with every standard library.
    double share() { return static_cast<double>(m_engine() >> 11U) * 0x1p-53; }

    const KinematicTree& m_tree;
    std::mt19937_64 m_engine;
};

/// True if a joint, and no other link with geometry, lies between the links.
bool areJoined(const KinematicTree& tree,
               std::span<const SsvTree* const> linkTrees,
               std::int32_t first,
               std::int32_t second)
{
    const std::int32_t top = commonAncestor(tree, first, second);
    const auto isSolid = [&](std::int32_t link) {
        return link != first && link != second &&
               linkTrees[static_cast<std::size_t>(link)] != nullptr;
    };
    for (const std::int32_t end : {first, second})
    {
        for (std::int32_t link = end; link != top;
             link = tree.links[static_cast<std::size_t>(link)].parent)
        {
            if (isSolid(link))
            {
                return false;
            }
        }
    }
    return !isSolid(top);
}

bool overlap(const SampledPair& pair,
             std::span<const SsvTree* const> linkTrees,
             const Poses& X_R,
             double reach)
{
    const auto a = static_cast<std::size_t>(pair.first);
    const auto b = static_cast<std::size_t>(pair.second);
    return treeDistance(*linkTrees[a], *linkTrees[b], X_R[b].inverse() * X_R[a], reach).distance <
           reach;
}

std::vector<SampledPair> allPairs(std::span<const SsvTree* const> linkTrees)
{
    std::vector<SampledPair> pairs;
    const auto count = static_cast<std::int32_t>(linkTrees.size());
    for (std::int32_t a = 0; a < count; ++a)
    {
        for (std::int32_t b = a + 1; b < count; ++b)
        {
            if (linkTrees[static_cast<std::size_t>(a)] != nullptr &&
                linkTrees[static_cast<std::size_t>(b)] != nullptr)
            {
                pairs.push_back({.first = a, .second = b});
            }
        }
    }
    return pairs;
}

/// Neither always nor never, whatever the rest of the samples would be.
bool isSettled(const SampledPair& pair, const PairSampling& sampling)
{
    const double free = pair.samples - pair.overlaps;
    return pair.overlaps > 0 && free > (1.0 - sampling.always) * sampling.samples;
}

void sample(const KinematicTree& tree,
            std::span<const SsvTree* const> linkTrees,
            const PairSampling& sampling,
            std::vector<SampledPair>& pairs)
{
    RandomPoses random(tree, sampling.seed);
    for (int i = 0; i < sampling.samples; ++i)
    {
        const Poses X_R = random.next();
        for (SampledPair& pair : pairs)
        {
            if (!isSettled(pair, sampling))
            {
                ++pair.samples;
                pair.overlaps += overlap(pair, linkTrees, X_R, sampling.reach) ? 1 : 0;
            }
        }
    }
}

PairFinding findingOf(const SampledPair& pair, const PairSampling& sampling)
{
    if (pair.overlaps == 0)
    {
        return PairFinding::Never;
    }
    return pair.overlaps >= sampling.always * pair.samples ? PairFinding::Always
                                                           : PairFinding::Sometimes;
}
}  // namespace

const char* nameOf(PairFinding finding)
{
    constexpr std::array<const char*, 5> kNames{
        "Adjacent", "Default", "Always", "Never", "Sometimes"};
    return kNames[static_cast<std::size_t>(finding)];
}

std::vector<SampledPair> samplePairs(const KinematicTree& tree,
                                     std::span<const SsvTree* const> linkTrees,
                                     const PairSampling& sampling)
{
    require(linkTrees.size() == tree.size(), "samplePairs: one hierarchy or null a link");
    require(sampling.samples > 0, "samplePairs: the number of samples must be positive");
    require(sampling.always > 0.0 && sampling.always <= 1.0,
            "samplePairs: the share that counts as always must be in (0, 1]");
    require(sampling.reach > 0.0 && std::isfinite(sampling.reach),
            "samplePairs: the reach must be positive and finite");
    std::vector<SampledPair> pairs = allPairs(linkTrees);
    sample(tree, linkTrees, sampling, pairs);
    const Poses rest = posesAtRest(tree);
    for (SampledPair& pair : pairs)
    {
        pair.finding = areJoined(tree, linkTrees, pair.first, pair.second) ? PairFinding::Adjacent
                       : overlap(pair, linkTrees, rest, sampling.reach)    ? PairFinding::Default
                                                                        : findingOf(pair, sampling);
    }
    return pairs;
}

std::string disabledPairsSrdf(const std::string& robot,
                              const KinematicTree& tree,
                              std::span<const SampledPair> pairs)
{
    const auto name = [&](std::int32_t link)
    { return tree.links[static_cast<std::size_t>(link)].name.c_str(); };
    tinyxml2::XMLPrinter printer;
    printer.PushHeader(false, true);
    printer.OpenElement("robot");
    printer.PushAttribute("name", robot.c_str());
    for (const SampledPair& pair : pairs)
    {
        printer.OpenElement("disable_collisions");
        printer.PushAttribute("link1", name(pair.first));
        printer.PushAttribute("link2", name(pair.second));
        printer.PushAttribute("reason", nameOf(pair.finding));
        printer.CloseElement();
    }
    printer.CloseElement();
    return printer.CStr();
}
}  // namespace bullet_ccd::grasp
