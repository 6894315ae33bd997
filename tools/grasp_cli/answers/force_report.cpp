#include "tools/grasp_cli/answers/force_report.h"

#include "tools/support/text_table.h"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace bullet_ccd::tools
{
namespace
{
using Json = nlohmann::ordered_json;
using grasp::ForceObjective;
using grasp::ForceStatus;

const char* objectiveName(ForceObjective objective)
{
    switch (objective)
    {
        case ForceObjective::Total:
            return "total normal force";
        case ForceObjective::Max:
            return "largest normal force";
        case ForceObjective::Firm:
            return "margin to slip";
    }
    return "";
}

/// With that many digits; what rounds to 0 has no sign.
std::string decimals(double value, int digits)
{
    const bool isZero = std::abs(value) < 0.5 * std::pow(10.0, -digits);
    return fmt::format("{:.{}f}", isZero ? 0.0 : value, digits);
}

std::string outcome(const ForceRecord& record)
{
    const std::string grasp = fmt::format("rank {}, candidate {}: ", record.rank, record.candidate);
    const std::string& reason = record.disturbance ? record.robust.reason : record.forces.reason;
    const char* name = objectiveName(record.options.objective);
    if (record.status() != ForceStatus::Balanced)
    {
        return fmt::format("{}{}: {}\n", grasp, toString(record.status()), reason);
    }
    if (!record.disturbance)
    {
        return fmt::format("{}balanced, {} {:.4g} N (bound {:.4g} N)\n",
                           grasp,
                           name,
                           record.forces.value,
                           record.forces.bound);
    }
    return fmt::format(
        "{}balanced for any wrench of size {:g} N, {} {:.4g} N (needed by one of them: {:.4g} N); "
        "forces of the worst:\n",
        grasp,
        record.disturbance->size,
        name,
        record.robust.guaranteed,
        record.robust.necessary);
}

std::string contactText(const ForceRecord& record, const grasp::HandModel& hand)
{
    TextTable table{
        .header =
            {"contact", "link", "normal [N]", "tangential [N]", "torsion [N m]", "margin [N]"},
        .rows = {}};
    for (std::size_t i = 0; i < record.forces.contacts.size(); ++i)
    {
        const grasp::ContactForce& force = record.forces.contacts[i];
        table.rows.push_back({fmt::format("{}", i),
                              linkName(hand, record.problem.contacts[i].link),
                              decimals(force.normal, 4),
                              decimals(force.tangential, 4),
                              decimals(force.torsion, 5),
                              decimals(force.margin, 4)});
    }
    return alignedText(table);
}

/// Joints that the contacts load, or that have a limit.
std::string jointText(const ForceRecord& record)
{
    TextTable table{.header = {"joint", "torque [N m or N]", "limit", "used [%]"}, .rows = {}};
    for (std::size_t j = 0; j < record.forces.jointTorques.size(); ++j)
    {
        const double torque = record.forces.jointTorques[j];
        const double limit = record.problem.torqueLimits[j];
        table.rows.push_back(
            {record.problem.jointNames[j],
             decimals(torque, 4),
             std::isfinite(limit) ? fmt::format("{:g}", limit) : "-",
             std::isfinite(limit) ? decimals(100.0 * std::abs(torque) / limit, 1) : "-"});
    }
    return alignedText(table);
}

template <typename Vector>
Json listOf(const Vector& v)
{
    return Json(std::vector<double>(v.begin(), v.end()));
}

/// Infinity is no number of JSON.
Json finiteOrNull(double value)
{
    return std::isfinite(value) ? Json(value) : Json();
}

Json contactsJson(const ForceRecord& record, const grasp::HandModel& hand)
{
    Json json = Json::array();
    for (std::size_t i = 0; i < record.forces.contacts.size(); ++i)
    {
        const grasp::ContactForce& force = record.forces.contacts[i];
        const grasp::GraspContact& contact = record.problem.contacts[i];
        json.push_back({{"link", linkName(hand, contact.link)},
                        {"point_m", listOf(contact.point)},
                        {"force_on_object_n", listOf(force.force)},
                        {"normal_n", force.normal},
                        {"tangential_n", force.tangential},
                        {"torsion_nm", force.torsion},
                        {"margin_n", force.margin}});
        if (record.disturbance && i < record.robust.largestNormals.size())
        {
            json.back()["largest_normal_n"] = record.robust.largestNormals[i];
        }
    }
    return json;
}

Json jointsJson(const ForceRecord& record)
{
    Json json = Json::array();
    for (std::size_t j = 0; j < record.forces.jointTorques.size(); ++j)
    {
        json.push_back({{"joint", record.problem.jointNames[j]},
                        {"torque", record.forces.jointTorques[j]},
                        {"limit", finiteOrNull(record.problem.torqueLimits[j])}});
        if (record.disturbance && j < record.robust.largestTorques.size())
        {
            json.back()["largest_torque"] = record.robust.largestTorques[j];
        }
    }
    return json;
}

Json certificateJson(const grasp::ForceCertificate& certificate)
{
    return {{"direction", listOf(certificate.direction)},
            {"length_m", certificate.length},
            {"friction_alone", certificate.coneOnly()},
            {"proven_up_to_n", finiteOrNull(certificate.provenUpTo)}};
}
}  // namespace

std::string forceText(const ForceRecord& record, const grasp::HandModel& hand)
{
    std::string text = outcome(record);
    if (record.status() == ForceStatus::Balanced)
    {
        text += contactText(record, hand);
        if (!record.forces.jointTorques.empty())
        {
            text += jointText(record);
        }
    }
    return text;
}

std::string forceJson(const ForceRecord& record, const grasp::HandModel& hand)
{
    const grasp::GraspForces& forces = record.forces;
    const bool balanced = record.status() == ForceStatus::Balanced;
    const std::string& reason = record.disturbance ? record.robust.reason : forces.reason;
    Json json{{"rank", record.rank},
              {"candidate", record.candidate},
              {"status", toString(record.status())},
              {"reason", balanced ? Json() : Json(reason)},
              {"objective", objectiveName(record.options.objective)},
              {"load", listOf(record.problem.load)},
              {"reference_m", listOf(record.problem.reference)}};
    if (record.disturbance)
    {
        json["any_wrench"] = {{"size_n", record.disturbance->size},
                              {"torque_scale_m", record.disturbance->torqueScale},
                              {"guaranteed_n", balanced ? Json(record.robust.guaranteed) : Json()},
                              {"necessary_n", balanced ? Json(record.robust.necessary) : Json()},
                              {"worst", listOf(record.robust.worstDisturbance)}};
    }
    json["value_n"] = balanced ? Json(forces.value) : Json();
    json["bound_n"] = balanced ? Json(forces.bound) : Json();
    json["contacts"] = contactsJson(record, hand);
    json["joints"] = jointsJson(record);
    json["residuals"] = {{"force_n", forces.residuals.force},
                         {"moment_nm", forces.residuals.moment},
                         {"cone_n", forces.residuals.cone},
                         {"torque", forces.residuals.torque},
                         {"normal_n", forces.residuals.normal}};
    json["certificate"] = forces.certificate ? certificateJson(*forces.certificate) : Json();
    return json.dump() + "\n";
}
}  // namespace bullet_ccd::tools
