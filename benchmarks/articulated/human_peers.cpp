#include "benchmarks/articulated/human_peers.h"

#include <algorithm>
#include <array>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;

/// A link as a motion that rigidToi() takes: what a caller without articulatedToi() would do.
class LinkAsUserMotion : public UserMotion
{
public:
    LinkAsUserMotion(const KinematicTree& tree, const JointMotion& motion, std::int32_t link)
        : m_tree(tree),
          m_motion(motion),
          m_link(link),
          m_bound(linkAccelerationBound(tree, motion, kNone, link))
    {
    }
    [[nodiscard]] MotionState at(double t) const override
    {
        return linkStateAt(m_tree, m_motion, kNone, m_link, t);
    }
    [[nodiscard]] AccelerationBound accelerationBound() const override { return m_bound; }

private:
    const KinematicTree& m_tree;
    const JointMotion& m_motion;
    std::int32_t m_link;
    AccelerationBound m_bound;
};

/// firstContact() as rigidToi() asks it, with the exempt triangles of the pair.
ToiResult maskedToi(const RigidBody& link,
                    const RigidBody& obstacle,
                    const PairMask* mask,
                    const ToiOptions& options,
                    ToiWorkspace& work)
{
    if (mask == nullptr)
    {
        return rigidToi(link, obstacle, options, work);
    }
    const std::array bodies{movingBody(link), movingBody(obstacle)};
    const std::array pairs{BodyPair{.bodyA = 0, .bodyB = 1, .mask = mask}};
    return firstContact(bodies, pairs, options, work);
}
}  // namespace

std::vector<Stage> humanStages()
{
    const ArticulatedToiOptions whole{.toi = {.tolerance = kHumanTolerance}};
    std::vector<Stage> all{{"articulatedToi", whole},
                           {"without halving", whole},
                           {"without space", whole},
                           {"without time", whole}};
    all[1].options.subdivide = false;
    all[2].options.cullBySpace = false;
    all[3].options.cullByTime = false;
    return all;
}

double rigidTime(const HumanScene& scene,
                 const HumanQuery& query,
                 double tolerance,
                 ToiWorkspace& work)
{
    double earliest = kNever;
    for (std::size_t i = 0; i < scene.tree.size(); ++i)
    {
        const auto index = static_cast<std::int32_t>(i);
        const LinkAsUserMotion motion(scene.tree, query.motion, index);
        const RigidBody link{.tree = scene.linkTrees[i], .motion = {}, .userMotion = &motion};
        for (std::size_t k = 0; k < scene.obstacles.size(); ++k)
        {
            const ToiResult result = maskedToi(link,
                                               scene.obstacles[k],
                                               query.maskOf(index, static_cast<std::int32_t>(k)),
                                               {.tolerance = tolerance},
                                               work);
            if (isContact(result.status))
            {
                earliest = std::min(earliest, result.time);
            }
        }
    }
    return earliest;
}

FclHuman::FclHuman(const HumanScene& scene) : m_scene(scene)
{
    for (const SsvTree& tree : scene.links)
    {
        m_links.emplace_back(tree.mesh());
    }
    for (const SsvTree& tree : scene.pieces)
    {
        m_pieces.emplace_back(tree.mesh());
    }
    for (const RigidBody& obstacle : scene.obstacles)
    {
        m_obstacles.push_back(
            &m_pieces[static_cast<std::size_t>(obstacle.tree - scene.pieces.data())]);
    }
}

/// Pairs of a link and an obstacle that do not intersect at the start.
FclHuman::Pairs FclHuman::pairsOf(const HumanQuery& query) const
{
    Pairs pairs;
    for (std::size_t i = 0; i < m_links.size(); ++i)
    {
        for (std::size_t k = 0; k < m_obstacles.size(); ++k)
        {
            if (query.maskOf(static_cast<std::int32_t>(i), static_cast<std::int32_t>(k)) == nullptr)
            {
                pairs.emplace_back(i, k);
            }
        }
    }
    return pairs;
}

bool FclHuman::overlap(const HumanQuery& query, const Pairs& pairs, double t) const
{
    std::vector<Isometry3d> X_WL(m_links.size());
    for (std::size_t i = 0; i < m_links.size(); ++i)
    {
        X_WL[i] =
            linkStateAt(m_scene.tree, query.motion, kNone, static_cast<std::int32_t>(i), t).X_W;
    }
    return std::any_of(
        pairs.begin(),
        pairs.end(),
        [&](const auto& pair)
        {
            const auto& [i, k] = pair;
            return fclOverlap(
                m_links[i], X_WL[i], *m_obstacles[k], m_scene.obstacles[k].motion.X_W0);
        });
}

bool FclHuman::overlaps(const HumanQuery& query, double t) const
{
    return overlap(query, pairsOf(query), t);
}

double FclHuman::firstSample(const HumanQuery& query, int samples) const
{
    const Pairs pairs = pairsOf(query);
    for (int sample = 0; sample < samples; ++sample)
    {
        const double t = static_cast<double>(sample) / (samples - 1);
        if (overlap(query, pairs, t))
        {
            return t;
        }
    }
    return kNever;
}

double FclHuman::distanceOf(const HumanQuery& query,
                            std::int32_t link,
                            std::int32_t obstacle,
                            double t) const
{
    const RigidMotion motion = restAt(linkStateAt(m_scene.tree, query.motion, kNone, link, t).X_W);
    const auto k = static_cast<std::size_t>(obstacle);
    return fclDistance({.model = m_links[static_cast<std::size_t>(link)], .motion = motion},
                       {.model = *m_obstacles[k], .motion = m_scene.obstacles[k].motion},
                       0.0);
}
}  // namespace bullet_ccd::benchmarks
