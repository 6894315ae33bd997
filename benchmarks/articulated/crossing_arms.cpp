#include "benchmarks/articulated/crossing_arms.h"

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/io/robot_file.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Vector3d;
using reference::Random;

/// The robot, and which of its links are of which arm.
struct Arms
{
    explicit Arms(const std::filesystem::path& urdf) : robot(loadUrdf(urdf))
    {
        trees.reserve(robot.linkMeshes.size());  // linkTrees points into it
        for (const TriangleMesh& mesh : robot.linkMeshes)
        {
            const bool isEmpty = mesh.triangles.empty();
            linkTrees.push_back(isEmpty ? nullptr : &trees.emplace_back(buildSsvTree(mesh)));
        }
        left = robot.tree.findLink("left_link_7");
        right = robot.tree.findLink("right_link_7");
        if (left == kNone || right == kNone)
        {
            throw std::runtime_error(urdf.string() +
                                     ": has no left_link_7 and right_link_7: give two arms");
        }
        addPairs();
    }
    Arms(const Arms&) = delete;
    Arms& operator=(const Arms&) = delete;

    /// All of one arm against all of the other.
    void addPairs()
    {
        const auto isOf = [&](std::size_t link, const char* side)
        { return linkTrees[link] != nullptr && robot.tree.links[link].name.starts_with(side); };
        for (std::size_t a = 0; a < linkTrees.size(); ++a)
        {
            for (std::size_t b = 0; b < linkTrees.size(); ++b)
            {
                if (isOf(a, "left_") && isOf(b, "right_"))
                {
                    pairs.emplace_back(static_cast<std::int32_t>(a), static_cast<std::int32_t>(b));
                }
            }
        }
    }

    RobotModel robot;
    std::vector<SsvTree> trees;
    std::vector<const SsvTree*> linkTrees;
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    std::int32_t left = kNone;
    std::int32_t right = kNone;
};

std::vector<double> randomPositions(const KinematicTree& tree, Random& random)
{
    std::vector<double> positions(tree.size(), 0.0);
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        if (joint.isMovable() && joint.mimicOf == kNone)
        {
            positions[i] = random.uniform(joint.lower, joint.upper);
        }
    }
    applyMimics(tree, positions);
    return positions;
}

/// From the left wrist to the right one.
Vector3d across(const Arms& arms, const std::vector<double>& positions)
{
    const std::vector<Eigen::Isometry3d> X =
        linkPoses(arms.robot.tree, Eigen::Isometry3d::Identity(), positions);
    return X[static_cast<std::size_t>(arms.right)].translation() -
           X[static_cast<std::size_t>(arms.left)].translation();
}

/// Random positions from which the wrists change sides, starting clear of each other.
std::vector<LinkageQuery> makeCrossings(const Arms& arms,
                                        const Linkage& linkage,
                                        const LinkageOptions& options)
{
    const KinematicTree& tree = arms.robot.tree;
    const Vector3d sides = across(arms, std::vector<double>(tree.size(), 0.0)).normalized();
    Random random(options.seed);
    std::vector<LinkageQuery> queries;
    while (static_cast<int>(queries.size()) < options.configurations)
    {
        const std::vector<double> from = randomPositions(tree, random);
        const std::vector<double> to = randomPositions(tree, random);
        if (across(arms, from).dot(sides) < 0.2 || across(arms, to).dot(sides) > -0.2)
        {
            continue;
        }
        LinkageQuery query{.motion = {.root = {}, .positions = from, .rates = to}};
        for (std::size_t i = 0; i < from.size(); ++i)
        {
            query.motion.rates[i] -= from[i];
        }
        if (linkage.isFree(query, 0.0))
        {
            queries.push_back(std::move(query));
        }
    }
    return queries;
}
}  // namespace

bool runCrossingArms(const LinkageOptions& options)
{
    const Arms arms(options.data / "arms/combined/dual_iiwa7_sah.urdf");
    fmt::print("two arms with hands that change sides, {} times:\n", options.configurations);
    const Table table = linkageTable();
    const Linkage linkage(arms.robot.tree, arms.linkTrees, arms.pairs);
    const LinkageTally tally = linkage.run(makeCrossings(arms, linkage, options), options.repeats);
    printLinkage(table, "dual_iiwa7_sah", tally);
    return isRight(tally);
}
}  // namespace bullet_ccd::benchmarks
