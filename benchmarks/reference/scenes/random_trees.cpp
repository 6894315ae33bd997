#include "benchmarks/reference/scenes/random_trees.h"

#include <algorithm>
#include <string>

namespace bullet_ccd::reference
{
KinematicTree randomTree(Random& random, int links, double branching)
{
    KinematicTree tree;
    tree.links.resize(static_cast<std::size_t>(links));
    for (int i = 1; i < links; ++i)
    {
        Link& link = tree.links[static_cast<std::size_t>(i)];
        link.name = "link" + std::to_string(i);
        link.parent = random.chance(branching) ? random.integer(0, i - 1) : i - 1;
        link.X_PL0 = random.pose(0.8);
        link.joint.name = "joint" + std::to_string(i);
        link.joint.axis = random.direction();
        const double kind = random.uniform(0.0, 1.0);
        link.joint.type = kind < 0.6   ? JointType::Revolute
                          : kind < 0.9 ? JointType::Prismatic
                                       : JointType::Fixed;
    }
    return tree;
}

KinematicTree randomBallTree(Random& random, int links, double branching)
{
    KinematicTree tree = randomTree(random, links, branching);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        if (random.chance(0.25))
        {
            tree.links[i].joint.type = JointType::Spherical;
        }
    }
    return tree;
}

JointMotion randomJointMotion(Random& random, const KinematicTree& tree, double fastest)
{
    JointMotion motion;
    if (random.chance(0.5))
    {
        motion.root = randomRigidMotion(random, fastest);
    }
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        motion.positions.push_back(random.uniform(-2.0, 2.0));
        motion.rates.push_back(random.chance(0.33) ? 0.0 : random.uniform(-fastest, fastest));
    }
    const bool hasBalls =
        std::any_of(tree.links.begin(),
                    tree.links.end(),
                    [](const Link& link) { return link.joint.type == JointType::Spherical; });
    for (std::size_t i = 0; hasBalls && i < tree.size(); ++i)
    {
        const double speed = random.chance(0.33) ? 0.0 : random.uniform(0.0, fastest);
        motion.balls.push_back({.start = random.rotation(), .rate = speed * random.direction()});
    }
    return motion;
}

void addRandomCurves(Random& random, double most, JointMotion& motion)
{
    for (std::size_t i = 0; i < motion.positions.size(); ++i)
    {
        JointCurve curve{};
        for (double& coefficient : curve)
        {
            coefficient = random.chance(0.3) ? 0.0 : 0.25 * random.uniform(-most, most);
        }
        motion.curves.push_back(random.chance(0.3) ? JointCurve{} : curve);
    }
}

RigidMotion randomRigidMotion(Random& random, double fastest)
{
    RigidMotion motion;
    motion.X_W0 = random.pose(2.0);
    motion.v_W = random.uniform(0.0, fastest) * random.direction();
    motion.w_W = random.uniform(0.0, fastest) * random.direction();
    return motion;
}

KinematicTree planarChain(const std::vector<double>& lengths, const Eigen::Vector3d& at)
{
    KinematicTree tree;
    tree.links.resize(lengths.size() + 1);
    for (std::size_t i = 0; i < lengths.size(); ++i)
    {
        Link& link = tree.links[i + 1];
        link.parent = static_cast<std::int32_t>(i);
        link.X_PL0.translation() = i == 0 ? at : Eigen::Vector3d(lengths[i - 1], 0.0, 0.0);
        link.joint.type = JointType::Revolute;
        link.joint.axis = Eigen::Vector3d::UnitZ();
    }
    return tree;
}
}  // namespace bullet_ccd::reference
