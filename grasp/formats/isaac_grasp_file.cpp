#include "grasp/formats/isaac_grasp_file.h"

#include "bullet_ccd/math/check.h"

#include <limits>
#include <ostream>
#include <yaml-cpp/yaml.h>

namespace bullet_ccd::grasp
{
namespace
{
/// Epsilon of confidence one half: a good grasp.
constexpr double kHalfConfidence = 0.1;

/// Quoted, so that no name is taken for a number or a truth value.
void emitName(YAML::Emitter& yaml, const std::string& name)
{
    yaml << YAML::DoubleQuoted << name;
}

void emitNamed(YAML::Emitter& yaml, const char* key, const std::string& name)
{
    yaml << YAML::Key << key << YAML::Value;
    emitName(yaml, name);
}

void emitVector(YAML::Emitter& yaml, const char* key, const Eigen::Vector3d& v)
{
    yaml << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq << v.x() << v.y()
         << v.z() << YAML::EndSeq;
}

void emitJoints(YAML::Emitter& yaml,
                const char* key,
                const KinematicTree& tree,
                const std::vector<double>& positions)
{
    yaml << YAML::Key << key << YAML::Value << YAML::BeginMap;
    for (std::size_t link = 1; link < tree.size(); ++link)
    {
        const Joint& joint = tree.links[link].joint;
        if (joint.isMovable() && joint.mimicOf == kNone)
        {
            yaml << YAML::Key;
            emitName(yaml, joint.name);
            yaml << YAML::Value << positions[link];
        }
    }
    yaml << YAML::EndMap;
}

void emitGrasp(YAML::Emitter& yaml, const HandModel& hand, const Grasp& grasp)
{
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    require(preshape != nullptr,
            "writeIsaacGrasps: the hand has no preshape \"" + grasp.preshape + "\"");
    require(grasp.positions.size() == hand.robot.tree.size(),
            "writeIsaacGrasps: a grasp needs one joint position a link");
    const Eigen::Quaterniond q = Eigen::Quaterniond(grasp.X_WH.linear()).normalized();
    yaml << YAML::BeginMap;
    yaml << YAML::Key << "confidence" << YAML::Value << isaacConfidence(grasp.quality.epsilon);
    emitVector(yaml, "position", grasp.X_WH.translation());
    yaml << YAML::Key << "orientation" << YAML::Value << YAML::Flow << YAML::BeginMap << YAML::Key
         << "w" << YAML::Value << q.w();
    emitVector(yaml, "xyz", q.vec());
    yaml << YAML::EndMap;
    emitJoints(yaml, "cspace_position", hand.robot.tree, grasp.positions);
    emitJoints(yaml, "pregrasp_cspace_position", hand.robot.tree, preshape->positions);
    yaml << YAML::EndMap;
}
}  // namespace

double isaacConfidence(double epsilon)
{
    return epsilon / (epsilon + kHalfConfidence);
}

void writeIsaacGrasps(std::ostream& out,
                      const GraspRun& run,
                      const HandModel& hand,
                      const GraspObject& object,
                      std::span<const Grasp> grasps)
{
    YAML::Emitter yaml(out);
    yaml.SetDoublePrecision(std::numeric_limits<double>::max_digits10);
    yaml << YAML::BeginMap << YAML::Key << "format" << YAML::Value << "isaac_grasp";
    // As text: as a number it would come out as 1.
    yaml << YAML::Key << "format_version" << YAML::Value << "1.0";
    emitNamed(yaml, "object_frame_link", object.name);
    emitNamed(yaml, "object_file", run.objectFile.string());
    yaml << YAML::Key << "object_scale" << YAML::Value << run.objectScale;
    emitNamed(yaml, "gripper_frame_link", hand.robot.tree.links.front().name);
    emitNamed(yaml, "gripper_file", run.handFile.string());
    yaml << YAML::Key << "grasps" << YAML::Value << YAML::BeginMap;
    std::size_t number = 0;
    for (const Grasp& grasp : grasps)
    {
        if (grasp.reject == RejectReason::None)
        {
            yaml << YAML::Key;
            emitName(yaml, "grasp_" + std::to_string(number++));
            yaml << YAML::Value;
            emitGrasp(yaml, hand, grasp);
        }
    }
    yaml << YAML::EndMap << YAML::EndMap;
    out << '\n';
}
}  // namespace bullet_ccd::grasp
