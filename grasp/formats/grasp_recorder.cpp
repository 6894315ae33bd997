#include "grasp/formats/grasp_recorder.h"

#include "grasp/force/grasp_forces.h"
#include "grasp/formats/content_hash.h"
#include "grasp/quality/hold_score.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace bullet_ccd::grasp
{
namespace
{
using Json = nlohmann::ordered_json;

Json toJson(const Eigen::Vector3d& v)
{
    return Json::array({v.x(), v.y(), v.z()});
}

/// A rotation matrix is rebuilt from its quaternion when read, so what is written is what counts.
Json poseToJson(const Eigen::Isometry3d& X)
{
    const Eigen::Quaterniond q = Eigen::Quaterniond(X.linear()).normalized();
    return {{"position_m", toJson(X.translation())},
            {"quaternion_wxyz", Json::array({q.w(), q.x(), q.y(), q.z()})}};
}

Json rotationToJson(const Eigen::Isometry3d& X)
{
    const Eigen::Matrix3d& R = X.linear();
    return Json::array(
        {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)});
}

Json handToJson(const GraspRun& run, const HandModel& hand, const std::string& hash)
{
    return {{"name", hand.robot.name},
            {"urdf", run.handFile.string()},
            {"srdf", run.srdfFile.empty() ? Json() : Json(run.srdfFile.string())},
            {"root_link", hand.robot.tree.links.front().name},
            {"content_hash", hash}};
}

Json objectToJson(const GraspRun& run, const GraspObject& object, const std::string& hash)
{
    return {{"name", object.name},
            {"file", run.objectFile.string()},
            {"scale", run.objectScale},
            {"center_of_mass_m", toJson(object.centerOfMass)},
            {"radius_m", object.radius},
            {"watertight", object.watertight},
            {"content_hash", hash}};
}

Json samplingToJson(const ApproachOptions& options)
{
    return {
        {"from", toString(options.source)},
        {"table_top", options.tableTop},
        {"up", toJson(options.up)},
        {"max_tilt_rad", options.maxTilt},
        {"standoff_m", options.standoff},
        {"reach_m", options.reach},
        {"roll_rad", options.roll ? Json::array({options.roll->from, options.roll->to}) : Json()}};
}

Json planToJson(const GraspRun& run, const ObjectMass& mass)
{
    const PlannerOptions& options = run.options;
    return {{"seed", options.seed},
            {"candidates", options.candidates},
            {"approach", samplingToJson(options.approach)},
            {"closing_engine", toString(options.engine)},
            {"closing_order", toString(options.closing.order)},
            {"first_fingers", options.closing.firstFingers},
            {"closing_speeds", options.closing.speeds},
            {"obstacles_hash", run.obstaclesHash.empty() ? Json() : Json(run.obstaclesHash)},
            {"robot", run.robot.empty() ? Json() : Json(run.robot)},
            {"tolerance_m", options.closing.tolerance},
            {"contact_threshold_m", options.closing.contactThreshold},
            {"min_contact_spacing_m", options.minContactSpacing},
            {"force_closure_threshold", options.forceClosureThreshold},
            {"mass_kg", mass.mass},
            {"mass_from", toString(mass.source)}};
}

Json approachToJson(const Grasp& grasp)
{
    Json json{{"start_pose_in_object", poseToJson(grasp.X_WStart)},
              {"from", grasp.source.empty() ? Json() : Json(grasp.source)},
              {"direction", toJson(grasp.approach_W)},
              {"travel_to_contact_m", grasp.approachDistance},
              {"obstacles_in_reach", grasp.obstaclesInReach}};
    if (!grasp.positions.empty())
    {
        const Eigen::Vector3d moved = grasp.X_WH.translation() - grasp.X_WStart.translation();
        const double along = moved.dot(grasp.approach_W);
        json["retreat_m"] = grasp.approachDistance - along;
        json["sideways_shift_m"] = (moved - along * grasp.approach_W).norm();
    }
    return json;
}

Json jointsToJson(const KinematicTree& tree, const std::vector<double>& positions)
{
    Json json = Json::object();
    for (std::size_t link = 0; link < positions.size(); ++link)
    {
        if (tree.links[link].joint.isMovable() && link > 0)
        {
            json[tree.links[link].joint.name] = positions[link];
        }
    }
    return json;
}

/// Null for a preshape that the hand does not have.
Json preshapeToJson(const HandModel& hand, const std::string& name)
{
    const Preshape* found = findPreshape(hand, name);
    return found == nullptr ? Json() : jointsToJson(hand.robot.tree, found->positions);
}

Json contactsToJson(const HandModel& hand, const std::vector<GraspContact>& contacts)
{
    Json json = Json::array();
    for (const GraspContact& contact : contacts)
    {
        json.push_back({{"link", linkName(hand, contact.link)},
                        {"point_m", toJson(contact.point)},
                        {"normal_into_object", toJson(contact.normal)},
                        {"gap_m", contact.gap}});
    }
    return json;
}

Json stopsToJson(const HandModel& hand, const std::vector<StopEvent>& stops)
{
    Json json = Json::array();
    for (const StopEvent& stop : stops)
    {
        json.push_back({{"link", linkName(hand, stop.link)},
                        {"time_s", stop.time},
                        {"by", stop.byObject ? "object" : "hand"}});
    }
    return json;
}

/// Null for what is no force closure.
Json weightToJson(const GraspQuality& quality,
                  const PlannerOptions& options,
                  double mass,
                  const HandModel& hand)
{
    if (!quality.largestMass)
    {
        return {};
    }
    const double margin = *quality.largestMass / mass;
    const bool isAssumed =
        options.efforts.empty() &&
        std::ranges::any_of(jointEfforts(hand), [](const JointEffort& e) { return e.isAssumed; });
    return {{"mass_kg", mass},
            {"held_in_any_direction", margin >= 1.0},
            {"margin", std::isfinite(margin) ? Json(margin) : Json()},
            {"largest_mass_kg", std::isfinite(margin) ? Json(*quality.largestMass) : Json()},
            {"effort_assumed", isAssumed}};
}

Json qualityToJson(const Grasp& grasp,
                   const PlannerOptions& options,
                   double mass,
                   const HandModel& hand,
                   const GraspObject& object)
{
    const GraspQuality& quality = grasp.quality;
    return {{"epsilon", quality.epsilon},
            {"volume", quality.volume > 0.0 ? Json(quality.volume) : Json()},
            {"force_closure", quality.forceClosure},
            {"class", quality.forceClosure ? Json(epsilonClass(quality.epsilon)) : Json()},
            {"weight", weightToJson(quality, options, mass, hand)},
            {"hold_score", quality.largestMass ? Json(holdScore(grasp, mass)) : Json()},
            {"friction", options.friction},
            {"cone_edges", options.coneEdges},
            {"torque_scale_m", object.radius}};
}

/// Null where none was asked for.
Json squeezeToJson(const Grasp& grasp,
                   const GraspRun& run,
                   double mass,
                   const HandModel& hand,
                   const GraspObject& object)
{
    if (!run.squeeze)
    {
        return {};
    }
    if (grasp.reject != RejectReason::None)
    {
        return {{"reason", toString(grasp.reject)}};
    }
    SqueezeOptions options = *run.squeeze;
    options.mass = options.mass.value_or(mass);
    options.centerOfMass = object.centerOfMass;
    const Squeeze squeeze = squeezeOf(hand, grasp, options);
    Json json{{"mass_kg", *options.mass},
              {"friction", run.squeeze->friction},
              {"reason", squeeze.reason.empty() ? Json() : Json(squeeze.reason)},
              {"normal_forces_n", squeeze.normalForce},
              {"weights_held", squeeze.weights},
              {"joints", Json::object()}};
    const KinematicTree& tree = hand.robot.tree;
    const std::vector<std::int32_t> joints = independentJoints(tree);
    for (std::size_t j = 0; j < joints.size(); ++j)
    {
        Json entry{{"effort", squeeze.efforts[j].limit},
                   {"effort_assumed", squeeze.efforts[j].isAssumed}};
        if (squeeze.exists())
        {
            entry["torque"] = squeeze.torques[j];
            entry["target"] = squeeze.targets[j];
            entry["stiffness"] = squeeze.stiffness[j];
        }
        json["joints"][tree.links[static_cast<std::size_t>(joints[j])].joint.name] =
            std::move(entry);
    }
    return json;
}

/// Null for a grasp that was not tried.
Json trialsToJson(const Grasp& grasp, const GraspRun& run)
{
    const auto found = run.trials.find(grasp.candidate);
    if (found == run.trials.end())
    {
        return {};
    }
    Json json = Json::array();
    for (const TrialNote& note : found->second)
    {
        json.push_back({{"protocol", note.protocol},
                        {"outcome", note.outcome},
                        {"reason", note.reason.empty() ? Json() : Json(note.reason)},
                        {"held", note.held},
                        {"slip_m", note.slip},
                        {"turn_rad", note.turn}});
    }
    return json;
}

/// What takes long to make.
struct Facts
{
    const std::string& handHash;
    const std::string& objectHash;
    const ObjectMass& mass;
};

Json recordOf(const Grasp& grasp,
              const GraspRun& run,
              const HandModel& hand,
              const GraspObject& object,
              const Facts& facts)
{
    const bool closed = !grasp.positions.empty();
    return Json{
        {"schema", kGraspSchema},
        {"rank", Json()},
        {"candidate", grasp.candidate},
        {"reject", grasp.reject == RejectReason::None ? Json() : Json(toString(grasp.reject))},
        {"quality", qualityToJson(grasp, run.options, facts.mass.mass, hand, object)},
        {"hand_pose_in_object", closed ? poseToJson(grasp.X_WH) : Json()},
        {"joints", jointsToJson(hand.robot.tree, grasp.positions)},
        {"contacts", contactsToJson(hand, grasp.contacts)},
        {"preshape", grasp.preshape},
        {"preshape_joints", preshapeToJson(hand, grasp.preshape)},
        {"approach", approachToJson(grasp)},
        {"stops", stopsToJson(hand, grasp.stops)},
        {"hand", handToJson(run, hand, facts.handHash)},
        {"object", objectToJson(run, object, facts.objectHash)},
        {"plan", planToJson(run, facts.mass)},
        {"versions", {{"bullet_ccd", recorderVersion()}}}};
}
}  // namespace

const char* recorderVersion()
{
    return BULLET_CCD_VERSION;
}

GraspRecorder::GraspRecorder(const GraspRun& run, const HandModel& hand, const GraspObject& object)
    : m_run(run),
      m_hand(hand),
      m_object(object),
      m_handHash(contentHash(hand)),
      m_objectHash(contentHash(object)),
      m_mass(massOf(object, run.options.mass))
{
}

std::string GraspRecorder::ranked(const Grasp& grasp, int rank) const
{
    Json json = recordOf(grasp, m_run, m_hand, m_object, {m_handHash, m_objectHash, m_mass});
    json["rank"] = rank;
    json["squeeze"] = squeezeToJson(grasp, m_run, m_mass.mass, m_hand, m_object);
    json["trials"] = trialsToJson(grasp, m_run);
    return json.dump();
}

std::string GraspRecorder::exact(const Grasp& grasp) const
{
    Json json = recordOf(grasp, m_run, m_hand, m_object, {m_handHash, m_objectHash, m_mass});
    json["approach"]["start_pose_in_object"][kRotationKey] = rotationToJson(grasp.X_WStart);
    if (!grasp.positions.empty())
    {
        json["hand_pose_in_object"][kRotationKey] = rotationToJson(grasp.X_WH);
    }
    return json.dump();
}
}  // namespace bullet_ccd::grasp
