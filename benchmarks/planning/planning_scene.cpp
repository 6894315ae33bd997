#include "benchmarks/planning/planning_scene.h"

namespace bullet_ccd::benchmarks
{
namespace
{
constexpr double kLength = 0.2;
constexpr double kThickness = 0.03;

/// A capsule from one joint to the next, along z.
TriangleMesh linkMesh()
{
    TriangleMesh mesh = makeCapsule(kThickness, kLength - 2.0 * kThickness, 16);
    for (Eigen::Vector3d& vertex : mesh.vertices)
    {
        vertex.z() += 0.5 * kLength;
    }
    return mesh;
}

KinematicTree armTree()
{
    KinematicTree tree;
    tree.links.resize(kArmJoints + 1);
    for (std::size_t i = 1; i <= kArmJoints; ++i)
    {
        Link& link = tree.links[i];
        link.parent = static_cast<std::int32_t>(i) - 1;
        link.X_PL0.translation().z() = i == 1 ? 0.0 : kLength;
        link.joint.type = JointType::Revolute;
        link.joint.axis = i % 2 == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
        link.joint.lower = -2.5;
        link.joint.upper = 2.5;
    }
    return tree;
}
}  // namespace

ClutteredArm::ClutteredArm(std::uint64_t seed, int obstacles)
    : m_tree(armTree()),
      m_link(buildSsvTree(linkMesh())),
      m_links(m_tree.size(), &m_link),
      m_fclLink(linkMesh())
{
    m_links[0] = nullptr;
    reference::Random random(seed);
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i < obstacles; ++i)
    {
        const double half = random.uniform(0.005, 0.02);
        const Eigen::Vector3d halves(
            half, random.chance(0.5) ? half : random.uniform(0.05, 0.15), random.uniform(0.1, 0.3));
        m_obstacles.push_back(buildSsvTree(makeBox(halves)));
        m_fclObstacles.emplace_back(makeBox(halves));
        Eigen::Isometry3d X_WO = random.pose(0.0);
        X_WO.translation() = random.uniform(0.45, 1.1) * random.direction();
        poses.push_back(X_WO);
    }
    std::vector<RigidBody> bodies;
    for (std::size_t i = 0; i < poses.size(); ++i)
    {
        bodies.push_back({.tree = &m_obstacles[i], .motion = restAt(poses[i])});
        m_centers.push_back(poses[i] * m_obstacles[i].origin());
    }
    m_environment.reset(bodies);
    PlanningScene scene{.body = {.tree = &m_tree, .linkTrees = m_links, .selfPairs = {}},
                        .environment = &m_environment,
                        .joints = {}};
    for (std::int32_t i = 1; i <= static_cast<std::int32_t>(kArmJoints); ++i)
    {
        scene.joints.push_back(i);
    }
    m_robot = std::make_shared<const CertifiedRobot>(std::move(scene));
}

bool ClutteredArm::isFreeByFcl(std::span<const double> q) const
{
    std::array<double, kArmJoints + 1> positions{};
    std::copy(q.begin(), q.end(), positions.begin() + 1);
    const std::vector<Eigen::Isometry3d> X_W =
        linkPoses(m_tree, Eigen::Isometry3d::Identity(), positions);
    for (std::size_t link = 1; link < X_W.size(); ++link)
    {
        const Eigen::Vector3d center = X_W[link] * m_link.origin();
        for (std::size_t k = 0; k < m_obstacles.size(); ++k)
        {
            const double reach = m_link.radius() + m_obstacles[k].radius();
            if ((center - m_centers[k]).squaredNorm() <= reach * reach &&
                fclOverlap(
                    m_fclLink, X_W[link], m_fclObstacles[k], m_environment.bodies()[k].motion.X_W0))
            {
                return false;
            }
        }
    }
    return true;
}

Configuration ClutteredArm::freeConfiguration(reference::Random& random) const
{
    Configuration q{};
    do
    {
        for (double& value : q)
        {
            value = random.uniform(-2.5, 2.5);
        }
    } while (!m_robot->isFree(q));
    return q;
}
}  // namespace bullet_ccd::benchmarks
