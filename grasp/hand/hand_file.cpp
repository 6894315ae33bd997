#include "bullet_ccd/io/robot_file.h"
#include "grasp/hand/hand_model.h"
#include "grasp/hand/srdf_file.h"
#include "grasp/hand/srdf_to_hand.h"

#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
std::string withoutMeshSuffix(const std::string& name)
{
    const std::string suffix = "_mesh";
    const bool has = name.size() > suffix.size() &&
                     name.compare(name.size() - suffix.size(), suffix.size(), suffix) == 0;
    return has ? name.substr(0, name.size() - suffix.size()) : name;
}

/// The project's own SRDF for this robot, if there is one.
std::optional<std::filesystem::path> findShared(const RobotModel& robot,
                                                const std::filesystem::path& shareFolder)
{
    const std::string stem = robot.file.stem().string();
    for (const std::string& name :
         {stem, withoutMeshSuffix(stem), robot.name, withoutMeshSuffix(robot.name)})
    {
        // A robot's name comes from a file: it must not lead out of the folder.
        const std::filesystem::path file = std::filesystem::path(name + ".srdf").filename();
        std::error_code error;
        if (std::filesystem::is_regular_file(shareFolder / "robots" / "srdf" / file, error))
        {
            return shareFolder / "robots" / "srdf" / file;
        }
    }
    return std::nullopt;
}

HandModel emptyHand(RobotModel robot)
{
    HandModel hand;
    hand.robot = std::move(robot);
    std::vector<std::size_t> links;
    for (std::size_t i = 0; i < hand.robot.linkMeshes.size(); ++i)
    {
        if (!hand.robot.linkMeshes[i].triangles.empty())
        {
            hand.trees.push_back(buildSsvTree(hand.robot.linkMeshes[i]));
            links.push_back(i);
        }
    }
    hand.linkTrees.assign(hand.robot.tree.size(), nullptr);
    for (std::size_t k = 0; k < links.size(); ++k)
    {
        hand.linkTrees[links[k]] = &hand.trees[k];
    }
    return hand;
}

HandModel inferred(HandModel hand, const std::filesystem::path& cacheFolder)
{
    Srdf empty;
    empty.file = hand.robot.file;
    applySrdf(empty, hand, cacheFolder);
    return hand;
}

/// Without what names a link or a joint of the robot that the hand does not have.
Srdf ofHand(Srdf srdf, const KinematicTree& hand, const KinematicTree& whole)
{
    const auto isOther = [&](const std::string& link)
    { return hand.findLink(link) == kNone && whole.findLink(link) != kNone; };
    const auto isOtherJoint = [&](const std::string& joint)
    { return hand.findJoint(joint) == kNone && whole.findJoint(joint) != kNone; };
    std::erase_if(srdf.groups,
                  [&](const SrdfGroup& group) {
                      return group.hasChain && (isOther(group.baseLink) || isOther(group.tipLink));
                  });
    for (SrdfState& state : srdf.states)
    {
        std::erase_if(state.joints, [&](const auto& joint) { return isOtherJoint(joint.first); });
    }
    std::erase_if(srdf.states, [](const SrdfState& state) { return state.joints.empty(); });
    std::erase_if(srdf.disabledPairs,
                  [&](const auto& pair) { return isOther(pair.first) || isOther(pair.second); });
    std::erase_if(srdf.passiveJoints, isOtherJoint);
    std::erase_if(srdf.closings,
                  [&](const SrdfClosing& closing) { return isOtherJoint(closing.joint); });
    std::erase_if(srdf.graspFrames,
                  [&](const SrdfGraspFrame& frame) { return isOther(frame.link); });
    return srdf;
}
}  // namespace

HandModel handOf(RobotModel part,
                 const KinematicTree& whole,
                 const std::optional<std::filesystem::path>& srdf,
                 const std::filesystem::path& cacheFolder)
{
    HandModel hand = emptyHand(std::move(part));
    if (!srdf)
    {
        return inferred(std::move(hand), cacheFolder);
    }
    hand.srdfFile = *srdf;
    applySrdf(ofHand(readSrdf(*srdf), hand.robot.tree, whole), hand, cacheFolder);
    return hand;
}

HandModel loadHand(const std::filesystem::path& urdf,
                   const std::optional<std::filesystem::path>& srdf,
                   const std::filesystem::path& shareFolder,
                   const std::filesystem::path& cacheFolder)
{
    HandModel hand = emptyHand(loadRobot(urdf));
    std::error_code error;
    std::filesystem::path beside = urdf;
    beside.replace_extension(".srdf");
    if (srdf || std::filesystem::is_regular_file(beside, error))
    {
        hand.srdfFile = srdf ? *srdf : beside;
        applySrdf(readSrdf(hand.srdfFile), hand, cacheFolder);
        return hand;
    }
    const std::optional<std::filesystem::path> shared =
        shareFolder.empty() ? std::nullopt : findShared(hand.robot, shareFolder);
    if (shared)
    {
        try
        {
            applySrdf(readSrdf(*shared), hand, cacheFolder);
            hand.srdfFile = *shared;
            return hand;
        }
        catch (const std::runtime_error& reason)
        {
            hand = emptyHand(std::move(hand.robot));
            hand.notes.push_back("SRDF of the project put aside, it does not fit this robot: " +
                                 std::string(reason.what()));
        }
    }
    hand.notes.push_back("no SRDF found, everything about the hand is inferred");
    return inferred(std::move(hand), cacheFolder);
}

HandModel inferHand(const std::filesystem::path& urdf, const std::filesystem::path& cacheFolder)
{
    return inferred(emptyHand(loadRobot(urdf)), cacheFolder);
}
}  // namespace bullet_ccd::grasp
