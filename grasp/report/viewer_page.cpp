#include "grasp/report/viewer_page.h"

#include "grasp/closing/swept_boxes.h"
#include "grasp/quality/object_mass.h"
#include "grasp/report/closing_spans.h"
#include "grasp/report/grasp_scene.h"
#include "grasp/report/page_data.h"
#include "grasp/report/report_facts.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
PageJson roundedList(const Eigen::Ref<const Eigen::VectorXd>& values)
{
    PageJson list = PageJson::array();
    for (const double value : values)
    {
        list.push_back(rounded(value));
    }
    return list;
}

/// Links below movable joints; the page's lists of joints are in this order.
std::vector<std::int32_t> movableLinks(const HandModel& hand)
{
    std::vector<std::int32_t> links;
    for (std::size_t i = 0; i < hand.robot.tree.size(); ++i)
    {
        const JointType type = hand.robot.tree.links[i].joint.type;
        if (type == JointType::Revolute || type == JointType::Prismatic)
        {
            links.push_back(static_cast<std::int32_t>(i));
        }
    }
    return links;
}

PageJson linksJson(const HandModel& hand, MeshList& meshes)
{
    PageJson list = PageJson::array();
    for (std::size_t i = 0; i < hand.robot.tree.size(); ++i)
    {
        const Link& link = hand.robot.tree.links[i];
        const TriangleMesh& mesh = hand.robot.linkMeshes[i];
        const auto index = static_cast<std::int32_t>(i);
        const bool isFramed = index == hand.palm || fingerOf(hand, index) != kNone;
        list.push_back({{"name", link.name},
                        {"parent", link.parent},
                        {"pose", poseList(link.X_PL0)},
                        {"mesh", mesh.triangles.empty() ? PageJson() : PageJson(meshes.add(mesh))},
                        {"color", hexColor(colorOf(hand, index))},
                        {"framed", isFramed}});
    }
    return list;
}

PageJson jointsJson(const HandModel& hand)
{
    PageJson list = PageJson::array();
    for (const std::int32_t link : movableLinks(hand))
    {
        const Joint& joint = hand.robot.tree.links[static_cast<std::size_t>(link)].joint;
        list.push_back({{"name", joint.name},
                        {"link", link},
                        {"prismatic", joint.type == JointType::Prismatic},
                        {"axis", {joint.axis.x(), joint.axis.y(), joint.axis.z()}}});
    }
    return list;
}

/// Of the movable joints, all digits.
PageJson positionsJson(const HandModel& hand, const std::vector<double>& positions)
{
    PageJson list = PageJson::array();
    for (const std::int32_t link : movableLinks(hand))
    {
        list.push_back(positions[static_cast<std::size_t>(link)]);
    }
    return list;
}

PageJson boxesJson(const HandModel& hand, const Preshape& preshape)
{
    PageJson list = PageJson::array();
    const std::vector<Eigen::AlignedBox3d> boxes = sweptBoxes(hand, preshape.positions).closing;
    for (std::size_t link = 0; link < boxes.size(); ++link)
    {
        if (!boxes[link].isEmpty())
        {
            list.push_back({{"link", link},
                            {"min", roundedList(boxes[link].min())},
                            {"max", roundedList(boxes[link].max())}});
        }
    }
    return list;
}

/// By name, those that grasps began with.
PageJson preshapesJson(const HandModel& hand, std::span<const Grasp> grasps)
{
    PageJson list = PageJson::object();
    for (const Grasp& grasp : grasps)
    {
        const Preshape* preshape = findPreshape(hand, grasp.preshape);
        if (preshape != nullptr && !list.contains(preshape->name))
        {
            Grasp open;
            open.preshape = preshape->name;
            list[preshape->name] = {
                {"joints", positionsJson(hand, closingSpans(hand, open, {}).from)},
                {"boxes", boxesJson(hand, *preshape)}};
        }
    }
    return list;
}

PageJson paceJson(const ClosingSpans& spans)
{
    PageJson list = PageJson::array();
    for (const auto& [shown, time] : spans.pace)
    {
        list.push_back({rounded(shown), rounded(time)});
    }
    return list;
}

PageJson spansJson(const HandModel& hand, const ClosingSpans& spans)
{
    PageJson list = PageJson::array();
    for (const std::int32_t link : movableLinks(hand))
    {
        const ClosingSpan& span = spans.joints[static_cast<std::size_t>(link)];
        list.push_back({rounded(span.begin), rounded(span.end)});
    }
    return list;
}

PageJson contactsJson(const Grasp& grasp)
{
    PageJson list = PageJson::array();
    for (const GraspContact& contact : grasp.contacts)
    {
        list.push_back({{"link", contact.link},
                        {"point", roundedList(contact.point)},
                        {"normal", roundedList(contact.normal)}});
    }
    return list;
}

PageJson stopsJson(const Grasp& grasp)
{
    PageJson list = PageJson::array();
    for (const StopEvent& stop : grasp.stops)
    {
        list.push_back({{"link", stop.link},
                        {"time", rounded(stop.time)},
                        {"by", stop.byObject ? "object" : "hand"}});
    }
    return list;
}

/// Such as "lift held, six slipped (first in phase 2, after 0.4 s)"; null for a grasp that was not
/// tried.
PageJson trialsText(const GraspRun& run, const Grasp& grasp)
{
    const auto found = run.trials.find(grasp.candidate);
    if (found == run.trials.end())
    {
        return {};
    }
    std::string text;
    for (const TrialNote& note : found->second)
    {
        text += (text.empty() ? "" : ", ") + note.protocol + " " + note.outcome;
        text += note.reason.empty() ? "" : " (" + note.reason + ")";
    }
    return text;
}

PageJson graspJson(const HandModel& hand,
                   const Grasp& grasp,
                   const PlannerOptions& options,
                   double mass,
                   const std::vector<std::string>& files)
{
    const GraspQuality& quality = grasp.quality;
    PageJson json = {
        {"candidate", grasp.candidate},
        {"outcome", outcomeOf(grasp)},
        {"good", grasp.reject == RejectReason::None},
        {"epsilon", quality.epsilon},
        {"volume", quality.volume > 0.0 ? PageJson(quality.volume) : PageJson()},
        {"class", quality.forceClosure ? PageJson(epsilonClass(quality.epsilon)) : PageJson()},
        {"largestMass",
         quality.largestMass && std::isfinite(*quality.largestMass)
             ? PageJson(rounded(*quality.largestMass))
             : PageJson()},
        {"holds", quality.largestMass ? PageJson(*quality.largestMass >= mass) : PageJson()},
        {"source", grasp.source},
        {"preshape", grasp.preshape},
        {"start", poseList(grasp.X_WStart)},
        {"direction", {grasp.approach_W.x(), grasp.approach_W.y(), grasp.approach_W.z()}},
        {"travel", grasp.approachDistance},
        {"hand", nullptr},
        {"files", files}};
    if (!grasp.positions.empty())
    {
        const ClosingSpans spans = closingSpans(hand, grasp, options.closing);
        json["hand"] = poseList(grasp.X_WH);
        json["joints"] = positionsJson(hand, grasp.positions);
        json["spans"] = spansJson(hand, spans);
        json["pace"] = paceJson(spans);
        json["end"] = json["pace"].back()[0];
        json["stops"] = stopsJson(grasp);
        json["contacts"] = contactsJson(grasp);
    }
    return json;
}

PageJson obstaclesJson(std::span<const RigidBody> obstacles, MeshList& meshes)
{
    PageJson list = PageJson::array();
    for (const RigidBody& body : obstacles)
    {
        list.push_back(
            {{"mesh", meshes.add(body.tree->mesh())}, {"pose", poseList(body.motion.X_W0)}});
    }
    return list;
}

PageJson pageJson(const GraspRun& run,
                  const HandModel& hand,
                  const GraspObject& object,
                  std::span<const Grasp> grasps,
                  const PageExtras& extras)
{
    MeshList meshes;
    const double mass = massOf(object, run.options.mass).mass;
    PageJson json = {{"hand", hand.robot.name},
                     {"tried", run.options.candidates},
                     {"friction", run.options.friction},
                     {"mass", rounded(mass)},
                     {"command", extras.command},
                     {"files", extras.files},
                     {"links", linksJson(hand, meshes)},
                     {"joints", jointsJson(hand)},
                     {"preshapes", preshapesJson(hand, grasps)},
                     {"object",
                      {{"name", object.name},
                       {"mesh", meshes.add(object.tree.mesh())},
                       {"color", hexColor(kObjectColor)},
                       {"radius", object.radius}}},
                     {"obstacles", obstaclesJson(extras.obstacles, meshes)}};
    json["meshes"] = meshes.json();
    json["facts"] = PageJson::array();
    for (const auto& [name, value] : reportFacts(run, hand, object, grasps))
    {
        json["facts"].push_back({name, value});
    }
    json["grasps"] = PageJson::array();
    for (std::size_t k = 0; k < grasps.size(); ++k)
    {
        const bool hasFiles = k < extras.graspFiles.size();
        PageJson grasp = graspJson(hand,
                                   grasps[k],
                                   run.options,
                                   mass,
                                   hasFiles ? extras.graspFiles[k] : std::vector<std::string>());
        grasp["trials"] = trialsText(run, grasps[k]);
        json["grasps"].push_back(std::move(grasp));
    }
    return json;
}

}  // namespace

void writeViewerPage(const GraspRun& run,
                     const HandModel& hand,
                     const GraspObject& object,
                     std::span<const Grasp> grasps,
                     const PageExtras& extras,
                     const std::filesystem::path& viewer,
                     const std::filesystem::path& file)
{
    writePage(
        filledTemplate(viewer,
                       {{"@TITLE@", escaped("Grasps of " + object.name + " by " + hand.robot.name)},
                        {"@DATA@", scriptText(pageJson(run, hand, object, grasps, extras))}}),
        file);
}
}  // namespace bullet_ccd::grasp
