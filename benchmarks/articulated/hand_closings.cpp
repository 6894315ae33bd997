#include "benchmarks/articulated/hand_closings.h"

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/io/mesh_file.h"
#include "grasp/hand/hand_model.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using reference::Random;
using Objects = std::vector<std::unique_ptr<const LinkageObject>>;

/// Boxes, cans, fruit, bowls and tools of the YCB set.
constexpr std::array kObjects{"006_mustard_bottle",
                              "007_tuna_fish_can",
                              "009_gelatin_box",
                              "010_potted_meat_can",
                              "011_banana",
                              "013_apple",
                              "014_lemon",
                              "024_bowl",
                              "025_mug",
                              "035_power_drill",
                              "048_hammer",
                              "052_extra_large_clamp",
                              "056_tennis_ball",
                              "061_foam_brick",
                              "065-j_cups",
                              "072-a_toy_airplane"};

Objects loadObjects(const std::filesystem::path& data)
{
    Objects objects;
    for (const char* name : kObjects)
    {
        const std::string file = std::string(name) + ".obj";
        objects.push_back(std::make_unique<const LinkageObject>(
            loadMeshFile(data / "objects/ycb_4k" / file).mesh));
    }
    return objects;
}

/// The right hand if there are two, with detailed meshes.
std::filesystem::path fileOf(const std::filesystem::path& data, const std::string& name)
{
    for (const char* side : {"_right", ""})
    {
        const std::filesystem::path file = data / "hands" / name / (name + side + "_mesh.urdf");
        if (std::filesystem::exists(file))
        {
            return file;
        }
    }
    throw std::runtime_error("no hand \"" + name + "\" in " + (data / "hands").string() +
                             ": name a folder of it");
}

/// Closing joints start up to three tenths of their way closed and go to their limits.
JointMotion closingMotion(const grasp::HandModel& hand, Random& random)
{
    const KinematicTree& tree = hand.robot.tree;
    std::vector<double> from = hand.preshapes[0].positions;
    const std::vector<double> closed = grasp::closedPositions(hand, from);
    for (std::size_t i = 0; i < from.size(); ++i)
    {
        from[i] += random.uniform(0.0, 0.3) * (closed[i] - from[i]);
    }
    applyMimics(tree, from);
    JointMotion motion{.root = {}, .positions = from, .rates = grasp::closedPositions(hand, from)};
    for (std::size_t i = 0; i < from.size(); ++i)
    {
        motion.rates[i] -= from[i];
    }
    return motion;
}

/// An object turned at random near the point where the fingers meet, moved away from the palm until
/// it is clear of the open hand, and then by up to 6 cm; none if that takes too long.
std::optional<LinkageQuery> placeObject(const grasp::HandModel& hand,
                                        const Linkage& linkage,
                                        const Objects& objects,
                                        Random& random)
{
    LinkageQuery query{.motion = closingMotion(hand, random)};
    const int index = random.integer(0, static_cast<int>(objects.size()) - 1);
    query.object = objects[static_cast<std::size_t>(index)].get();
    const Eigen::Matrix3d turn = random.rotation();
    const Vector3d aside = random.inBox(0.02);
    const double more = random.uniform(0.0, 0.06);
    const auto isFreeAt = [&](double away)
    {
        const Vector3d at = hand.X_RG * (aside + Vector3d(0.0, 0.0, away));
        query.X_WO.linear() = turn;
        query.X_WO.translation() = at - turn * query.object->ball.center;
        return linkage.isFree(query, 0.0);
    };
    for (double away = 0.0; away < 0.2; away += 5e-3)
    {
        if (isFreeAt(away))
        {
            return isFreeAt(away + more) ? std::optional(query) : std::nullopt;
        }
    }
    return std::nullopt;
}

std::vector<LinkageQuery> makeClosings(const grasp::HandModel& hand,
                                       const Linkage& linkage,
                                       const Objects& objects,
                                       const LinkageOptions& options)
{
    Random random(options.seed);
    std::vector<LinkageQuery> queries;
    for (int tries = 0; static_cast<int>(queries.size()) < options.configurations; ++tries)
    {
        if (tries > 20 * options.configurations)
        {
            throw std::runtime_error(hand.robot.name + ": hardly any object fits the open hand");
        }
        if (std::optional<LinkageQuery> query = placeObject(hand, linkage, objects, random))
        {
            queries.push_back(std::move(*query));
        }
    }
    return queries;
}
}  // namespace

bool runHandClosings(const ClosingOptions& options)
{
    const Objects objects = loadObjects(options.linkage.data);
    fmt::print("hands closing around {} objects, {} times each:\n",
               objects.size(),
               options.linkage.configurations);
    const Table table = linkageTable();
    bool isAllRight = true;
    for (const std::string& name : options.hands)
    {
        const grasp::HandModel hand =
            grasp::loadHand(fileOf(options.linkage.data, name), std::nullopt, options.share);
        const Linkage linkage(hand.robot.tree, hand.linkTrees, hand.selfPairs);
        const LinkageTally tally = linkage.run(
            makeClosings(hand, linkage, objects, options.linkage), options.linkage.repeats);
        printLinkage(table, name, tally);
        isAllRight = isRight(tally) && isAllRight;
    }
    return isAllRight;
}
}  // namespace bullet_ccd::benchmarks
