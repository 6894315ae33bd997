#include "tools/ccd_cli/files/robot_links.h"

#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/hand/srdf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace bullet_ccd::tools
{
namespace
{
using LinkPair = std::pair<std::int32_t, std::int32_t>;

/// Positions tried of each joint, by the number of joints between two links.
constexpr std::array<int, 4> kSamples{0, 41, 13, 7};

const Link& at(const KinematicTree& tree, std::int32_t link)
{
    return tree.links[static_cast<std::size_t>(link)];
}

/// For every link, the nearest one at or above it that a joint moves: links of one such carrier are
/// one rigid body.
std::vector<std::int32_t> carriersOf(const KinematicTree& tree)
{
    std::vector<std::int32_t> carriers;
    for (const Link& link : tree.links)
    {
        const bool isFixed = link.parent != kNone && !link.joint.isMovable();
        carriers.push_back(isFixed ? carriers[static_cast<std::size_t>(link.parent)]
                                   : static_cast<std::int32_t>(carriers.size()));
    }
    return carriers;
}

/// What lies between two links.
class Neighbours
{
public:
    explicit Neighbours(const RobotLinks& links)
        : m_tree(links.robot.tree), m_carriers(carriersOf(m_tree)), m_solid(m_tree.size(), false)
    {
        for (std::size_t k = 0; k < m_carriers.size(); ++k)
        {
            const auto carrier = static_cast<std::size_t>(m_carriers[k]);
            m_solid[carrier] = m_solid[carrier] || links.linkTrees[k] != nullptr;
        }
    }

    /// The joints between two neighbours, by the links below them; nothing if other geometry lies
    /// between, or more joints than neighbours have.
    [[nodiscard]] std::vector<std::int32_t> jointsBetween(const LinkPair& pair) const
    {
        std::vector<std::int32_t> joints;
        const std::int32_t a = carrier(pair.first);
        const std::int32_t b = carrier(pair.second);
        const std::int32_t top = carrier(commonAncestor(m_tree, a, b));
        for (const std::int32_t end : {a, b})
        {
            for (std::int32_t link = end; link != top; link = carrier(at(m_tree, link).parent))
            {
                if (link != end && m_solid[static_cast<std::size_t>(link)])
                {
                    return {};
                }
                joints.push_back(link);
            }
        }
        const bool isTopBetween = top != a && top != b && m_solid[static_cast<std::size_t>(top)];
        return isTopBetween || joints.size() >= kSamples.size() ? std::vector<std::int32_t>()
                                                                : joints;
    }

private:
    [[nodiscard]] std::int32_t carrier(std::int32_t link) const
    {
        return m_carriers[static_cast<std::size_t>(link)];
    }

    const KinematicTree& m_tree;
    std::vector<std::int32_t> m_carriers;
    std::vector<bool> m_solid;
};

/// Position number k of `count` over the range of the joint; a full turn without limits.
double positionOf(const Joint& joint, int k, int count)
{
    const bool isLimited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
    const double widest = joint.type == JointType::Revolute ? std::numbers::pi : 0.0;
    const double lower = isLimited ? joint.lower : -widest;
    const double upper = isLimited ? joint.upper : widest;
    return lower + (upper - lower) * k / (count - 1);
}

/// Poses of the first link in the second over the ranges of the joints between them.
std::vector<Eigen::Isometry3d> posesOver(const KinematicTree& tree,
                                         const LinkPair& pair,
                                         const std::vector<std::int32_t>& joints)
{
    const int samples = kSamples[joints.size()];
    int count = 1;
    for (std::size_t k = 0; k < joints.size(); ++k)
    {
        count *= samples;
    }
    std::vector<double> positions(tree.size(), 0.0);
    std::vector<Eigen::Isometry3d> poses;
    for (int n = 0; n < count; ++n)
    {
        int digits = n;
        for (const std::int32_t joint : joints)
        {
            positions[static_cast<std::size_t>(joint)] =
                positionOf(at(tree, joint).joint, digits % samples, samples);
            digits /= samples;
        }
        const std::vector<Eigen::Isometry3d> X_R =
            linkPoses(tree, Eigen::Isometry3d::Identity(), positions);
        poses.push_back(X_R[static_cast<std::size_t>(pair.second)].inverse() *
                        X_R[static_cast<std::size_t>(pair.first)]);
    }
    return poses;
}

std::vector<LinkPair> disabledPairs(RobotLinks& links, const std::filesystem::path& path)
{
    std::vector<LinkPair> pairs;
    if (path.empty())
    {
        return pairs;
    }
    std::string unknown;
    for (const auto& [first, second] : grasp::readSrdf(path).disabledPairs)
    {
        const LinkPair pair{links.robot.tree.findLink(first), links.robot.tree.findLink(second)};
        if (pair.first != kNone && pair.second != kNone)
        {
            pairs.push_back(pair);
            continue;
        }
        const std::string& name = pair.first == kNone ? first : second;
        unknown += unknown.empty() ? "" : ", ";
        unknown += name;
    }
    if (!unknown.empty())
    {
        links.notes.push_back(path.string() +
                              ": disabled pairs of links that the robot does not "
                              "have are ignored: " +
                              unknown);
    }
    return pairs;
}
}  // namespace

ArticulatedBody RobotLinks::body(const JointMotion& motion) const
{
    return {.tree = &robot.tree,
            .linkTrees = linkTrees,
            .motion = &motion,
            .selfPairs = selfPairs,
            .masks = linkMasks};
}

RobotLinks loadRobotLinks(const std::filesystem::path& urdf)
{
    RobotLinks links;
    links.robot = loadRobot(urdf);
    links.notes = links.robot.notes;
    for (TriangleMesh& mesh : links.robot.linkMeshes)
    {
        links.trees.push_back(mesh.triangles.empty() ? nullptr
                                                     : std::make_unique<const SsvTree>(
                                                           buildSsvTreeAsNeeded(std::move(mesh))));
        links.linkTrees.push_back(links.trees.back().get());
    }
    return links;
}

void addSelfPairs(RobotLinks& links, const std::filesystem::path& srdf, double reach)
{
    const std::vector<LinkPair> disabled = disabledPairs(links, srdf);
    links.selfPairs = selfPairsOf(links.robot.tree, links.linkTrees, disabled);
    const Neighbours neighbours(links);
    for (const LinkPair& pair : links.selfPairs)
    {
        const std::vector<std::int32_t> joints = neighbours.jointsBetween(pair);
        if (joints.empty())
        {
            continue;
        }
        auto mask = std::make_unique<const PairMask>(
            maskNear(*links.linkTrees[static_cast<std::size_t>(pair.first)],
                     *links.linkTrees[static_cast<std::size_t>(pair.second)],
                     posesOver(links.robot.tree, pair, joints),
                     reach));
        if (!mask->isEmpty())
        {
            links.linkMasks.push_back({.link = pair.first,
                                       .otherLink = pair.second,
                                       .obstacle = kNone,
                                       .mask = mask.get()});
            links.masks.push_back(std::move(mask));
        }
    }
}

void attachObject(RobotLinks& links,
                  const std::string& name,
                  TriangleMesh mesh,
                  std::int32_t link,
                  const Eigen::Isometry3d& X_LO,
                  bool testsSelf)
{
    KinematicTree& tree = links.robot.tree;
    const auto object = static_cast<std::int32_t>(tree.size());
    tree.links.push_back({.name = name, .parent = link, .X_PL0 = X_LO});
    links.trees.push_back(std::make_unique<const SsvTree>(buildSsvTree(std::move(mesh))));
    links.linkTrees.push_back(links.trees.back().get());
    const std::vector<std::int32_t> carriers = carriersOf(tree);
    for (std::int32_t other = 0; testsSelf && other < object; ++other)
    {
        if (links.linkTrees[static_cast<std::size_t>(other)] != nullptr &&
            carriers[static_cast<std::size_t>(other)] != carriers.back())
        {
            links.selfPairs.emplace_back(object, other);
        }
    }
}
}  // namespace bullet_ccd::tools
