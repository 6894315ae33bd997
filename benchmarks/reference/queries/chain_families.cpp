/// Chains whose links lie along x of their frames, among obstacles near where the links pass.
#include "benchmarks/reference/queries/chain_families.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;

/// Geometry of a link of that length: bars, needles, soups, a ball at its end, nothing.
TriangleMesh linkMesh(Random& random, double length)
{
    const Vector3d middle(0.5 * length, 0.0, 0.0);
    switch (random.integer(0, 9))
    {
        case 0:
            return {};
        case 1:
            return segment({0.1 * length, 0.0, 0.0}, {0.9 * length, 0.0, 0.0});
        case 2:
            return shifted(sphereWithPole(0.3 * length, random.direction(), 3), middle);
        case 3:
        case 4:
        case 5:
            return shifted(
                soup(random, random.integer(1, 6), 0.3 * length, random.logUniform(0.02, 0.3)),
                middle);
        default:
        {
            const double half = length * random.logUniform(0.01, 0.2);
            return box({0.15 * length, -half, -half}, {0.85 * length, half, half});
        }
    }
}

JointType jointType(ChainFamily family, Random& random)
{
    const double kind = random.uniform(0.0, 1.0);
    switch (family)
    {
        case ChainFamily::Prismatic:
            return kind < 0.7 ? JointType::Prismatic : JointType::Revolute;
        case ChainFamily::Spherical:
            return kind < 0.5 ? JointType::Spherical : JointType::Revolute;
        case ChainFamily::Mixed:
            return kind < 0.4    ? JointType::Revolute
                   : kind < 0.65 ? JointType::Prismatic
                   : kind < 0.85 ? JointType::Spherical
                                 : JointType::Fixed;
        case ChainFamily::Mimic:
        case ChainFamily::FloatingBase:
            return kind < 0.75 ? JointType::Revolute : JointType::Prismatic;
        default:
            return JointType::Revolute;
    }
}

/// Joints at the ends of the links before them; axes anywhere, or nearly parallel.
KinematicTree chainTree(ChainFamily family, const std::vector<double>& lengths, Random& random)
{
    const bool curls = family == ChainFamily::SelfCollision;
    KinematicTree tree;
    tree.links.resize(lengths.size());
    for (std::size_t i = 1; i < lengths.size(); ++i)
    {
        Link& link = tree.links[i];
        link.name = "link" + std::to_string(i);
        link.parent = static_cast<std::int32_t>(i) - 1;
        link.X_PL0.translation() = Vector3d(lengths[i - 1], 0.0, 0.0);
        link.joint.name = "joint" + std::to_string(i);
        link.joint.type = jointType(family, random);
        link.joint.axis =
            curls ? (Vector3d::UnitZ() + random.uniform(0.0, 0.3) * random.direction()).normalized()
                  : random.direction();
        if (!curls)
        {
            link.X_PL0.linear() = random.rotation();
        }
    }
    return tree;
}

/// Every third joint or so follows an earlier one of its kind.
void addMimics(KinematicTree& tree, JointMotion& motion, Random& random)
{
    for (std::size_t i = 2; i < tree.size(); ++i)
    {
        const auto leader = static_cast<std::size_t>(random.integer(1, static_cast<int>(i) - 1));
        Joint& joint = tree.links[i].joint;
        const Joint& other = tree.links[leader].joint;
        if (random.chance(0.3) || other.mimicOf != kNone || other.type != joint.type)
        {
            continue;
        }
        joint.mimicOf = static_cast<std::int32_t>(leader);
        joint.mimicMultiplier = random.uniform(-2.0, 2.0);
        joint.mimicOffset = random.uniform(-0.3, 0.3);
        motion.rates[i] = joint.mimicMultiplier * motion.rates[leader];
    }
    applyMimics(tree, motion.positions);
}

JointMotion chainMotion(ChainFamily family, KinematicTree& tree, double fastest, Random& random)
{
    JointMotion motion = randomJointMotion(random, tree, fastest);
    motion.root = {};
    const bool flies =
        family == ChainFamily::FloatingBase || (family == ChainFamily::Mixed && random.chance(0.5));
    if (flies)
    {
        motion.root = randomRigidMotion(random, std::min(fastest, 3.0));
        motion.root.reference_B = random.chance(0.5) ? Vector3d::Zero().eval() : random.inBox(0.5);
    }
    else if (random.chance(0.5))
    {
        motion.root.X_W0 = random.pose(3.0);
    }
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        if (tree.links[i].joint.type == JointType::Prismatic)
        {
            motion.positions[i] *= 0.2;
            motion.rates[i] *= 0.3;
        }
        if (family == ChainFamily::SelfCollision)
        {
            const double share = 1.0 / static_cast<double>(tree.size() - 1);
            motion.positions[i] = random.uniform(-0.5, 1.5) * share;
            motion.rates[i] = random.uniform(0.0, 15.0) * share;
        }
    }
    if (family == ChainFamily::Mimic)
    {
        addMimics(tree, motion, random);
    }
    return motion;
}

/// Pairs with a link between them, some or all.
void addSelfPairs(ArticulatedScene& scene, double share, Random& random)
{
    for (std::size_t b = 2; b < scene.linkMeshes.size(); ++b)
    {
        for (std::size_t a = 0; a + 1 < b; ++a)
        {
            const bool isSolid =
                !scene.linkMeshes[a].triangles.empty() && !scene.linkMeshes[b].triangles.empty();
            if (isSolid && random.chance(share))
            {
                scene.selfPairs.emplace_back(static_cast<std::int32_t>(a),
                                             static_cast<std::int32_t>(b));
            }
        }
    }
}

TriangleMesh obstacleMesh(Random& random)
{
    const double size = random.logUniform(0.05, 0.4);
    switch (random.integer(0, 3))
    {
        case 0:
            return quad({-size, 0, -size}, {-size, 0, size}, {size, 0, size}, {size, 0, -size});
        case 1:
            return sphereWithPole(size, random.direction(), 3);
        case 2:
            return box({-size, -0.5 * size, -0.2 * size}, {size, 0.5 * size, 0.2 * size});
        default:
            return soup(random, random.integer(1, 6), size, size);
    }
}

bool startsFree(const ArticulatedScene& scene,
                const TriangleMesh& obstacle,
                const RigidMotion& motion)
{
    const OracleBody body = oracleBody(obstacle, motion);
    for (std::size_t i = 0; i < scene.linkMeshes.size(); ++i)
    {
        const OracleBody link =
            oracleLink(scene.linkMeshes[i], scene.tree, scene.motion, static_cast<std::int32_t>(i));
        if (!link.mesh->triangles.empty() && oracleDistanceAt(link, body, 0.0) == 0.0)
        {
            return false;
        }
    }
    return true;
}

/// An obstacle near a link at some time of the motion; some move on their own. Most that overlap
/// the chain at the start are tried elsewhere.
void addObstacle(ArticulatedScene& scene, const std::vector<double>& lengths, Random& random)
{
    const TriangleMesh mesh = obstacleMesh(random);
    RigidMotion motion;
    do
    {
        const int link = random.integer(1, static_cast<int>(lengths.size()) - 1);
        const Eigen::Isometry3d X_WL =
            oracleLinkPose(scene.tree, scene.motion, link, random.uniform(0.3, 1.0));
        const double length = lengths[static_cast<std::size_t>(link)];
        motion = randomRigidMotion(random, random.chance(0.3) ? 1.0 : 0.0);
        motion.X_W0.translation() = X_WL * Vector3d(random.uniform(0.0, length), 0.0, 0.0) +
                                    random.uniform(0.0, 0.7) * random.direction();
    } while (random.chance(0.9) && !startsFree(scene, mesh, motion));
    scene.obstacles.push_back(mesh);
    scene.obstacleMotions.push_back(motion);
}

ArticulatedScene fingers(int joints, Random& random)
{
    ArticulatedScene scene;
    const double length = random.uniform(1.5, 2.5) / joints;
    const std::vector<double> lengths(static_cast<std::size_t>(joints), length);
    scene.tree = planarChain(lengths);
    scene.linkMeshes.resize(1);
    scene.motion = {.root = {}, .positions = {0.0}, .rates = {0.0}};
    const double turn = random.uniform(0.5, 4.0);
    for (int i = 0; i < joints; ++i)
    {
        const double half = length * random.uniform(0.02, 0.1);
        scene.linkMeshes.push_back(box({0.05 * length, -half, -half}, {0.9 * length, half, half}));
        scene.motion.positions.push_back(random.uniform(-0.3, 0.3) / joints);
        scene.motion.rates.push_back(random.uniform(-0.3, 2.0) * turn / joints);
    }
    scene.obstacles = {scaled(randomMesh(random), random.uniform(0.2, 0.7))};
    scene.obstacleMotions = {
        restAt(poseOf({random.uniform(0.0, 2.0), random.uniform(0.8, 1.6), 0.0}))};
    addSelfPairs(scene, 1.0, random);
    return scene;
}
}  // namespace

ArticulatedScene chainScene(ChainFamily family, int joints, Random& random)
{
    if (family == ChainFamily::Fingers)
    {
        return fingers(joints, random);
    }
    const bool curls = family == ChainFamily::SelfCollision;
    std::vector<double> lengths;
    ArticulatedScene scene;
    for (int i = 0; i <= joints; ++i)
    {
        lengths.push_back(random.uniform(0.2, 0.6));
        scene.linkMeshes.push_back(linkMesh(random, lengths.back()));
    }
    scene.tree = chainTree(family, lengths, random);
    scene.motion = chainMotion(family, scene.tree, random.logUniform(0.3, 5.0), random);
    addSelfPairs(scene, curls ? 1.0 : 0.1, random);
    for (int i = curls ? 0 : random.integer(1, 3); i > 0; --i)
    {
        addObstacle(scene, lengths, random);
    }
    return scene;
}
}  // namespace bullet_ccd::reference
