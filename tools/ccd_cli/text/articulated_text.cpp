#include "tools/ccd_cli/text/articulated_text.h"

#include "tools/ccd_cli/text/result_text.h"
#include "tools/support/csv_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
std::string quoted(const std::string& text)
{
    return nlohmann::json(text).dump();
}

const std::string& otherName(const LinkContact& contact, const ArticulatedNames& names)
{
    return contact.obstacle != kNone
               ? names.obstacles[static_cast<std::size_t>(contact.obstacle)].name
               : names.links.linkName(contact.otherLink);
}

const char* otherKind(const LinkContact& contact)
{
    return contact.obstacle != kNone ? "obstacle" : "link";
}

/// The joint that must stop; "base" for a root that moves, "" if nothing of the robot can.
std::string stopName(const LinkContact& contact, const ArticulatedNames& names)
{
    if (contact.stopJoint == kNone)
    {
        return {};
    }
    return contact.stopJoint == 0
               ? "base"
               : names.links.robot.tree.links[static_cast<std::size_t>(contact.stopJoint)]
                     .joint.name;
}

bool hasNormal(const LinkContact& contact)
{
    return !contact.normal.isZero(0.0);
}

std::string jsonContact(const LinkContact& contact, const ArticulatedNames& names)
{
    const std::string stop = stopName(contact, names);
    return fmt::format(
        R"(
    {{"time": {}, "link": {}, "{}": {}, "gap": {}, "point_link": {}, "point_other": {}, )"
        R"("normal": {}, "triangle_link": {}, "triangle_other": {}, "stop_joint": {}}})",
        contact.time,
        quoted(names.links.linkName(contact.link)),
        contact.obstacle != kNone ? "obstacle" : "other_link",
        quoted(otherName(contact, names)),
        contact.gap,
        jsonArray(contact.pointLink),
        jsonArray(contact.pointOther),
        jsonArray(contact.normal, hasNormal(contact)),
        contact.triangleLink,
        contact.triangleOther,
        stop.empty() ? "null" : quoted(stop));
}

/// The joints that stopped before the end, "base" for the root, and when.
std::vector<std::pair<std::string, double>> stopsOf(const ArticulatedReport& report,
                                                    const ArticulatedNames& names)
{
    std::vector<std::pair<std::string, double>> stops;
    for (std::size_t k = 0; k < report.stopTimes.size(); ++k)
    {
        const Joint& joint = names.links.robot.tree.links[k].joint;
        if (report.stopTimes[k] < 1.0 && (k == 0 || joint.isMovable()))
        {
            stops.emplace_back(k == 0 ? "base" : joint.name, report.stopTimes[k]);
        }
    }
    return stops;
}

std::string words(const Eigen::Vector3d& v)
{
    return fmt::format("{:.9g} {:.9g} {:.9g}", v.x(), v.y(), v.z());
}

std::string readableContact(const LinkContact& contact, const ArticulatedNames& names)
{
    const std::string stop = stopName(contact, names);
    return fmt::format(
        "  at {:.12g}: link {} and {} {}, gap {:.4g}\n"
        "    points     {} - {}\n"
        "    normal     {}\n"
        "    triangles  {} of {}, {} of {}\n"
        "    must stop  {}\n",
        contact.time,
        names.links.linkName(contact.link),
        otherKind(contact),
        otherName(contact, names),
        contact.gap,
        words(contact.pointLink),
        words(contact.pointOther),
        hasNormal(contact) ? words(contact.normal) : "none",
        contact.triangleLink,
        names.links.linkName(contact.link),
        contact.triangleOther,
        otherName(contact, names),
        stop.empty() ? "nothing: only the other moves" : stop);
}

/// What the answer promises, in one sentence.
std::string sentence(const ArticulatedReport& report, const ToiOptions& options)
{
    const std::string clear = excludedWords(options);
    switch (report.status)
    {
        case ToiStatus::Separated:
            return clear + " is never reached";
        case ToiStatus::Hit:
            return fmt::format("{} is not reached before t = {}",
                               clear,
                               report.contacts.empty() ? report.time : report.contacts[0].time);
        case ToiStatus::Overlapping:
            return options.minimumSeparation > 0.0
                       ? "closer than the minimum separation at the start"
                       : "surfaces intersect at the start: change the start, or disable the pair "
                         "of "
                         "links in an SRDF if it may overlap";
        case ToiStatus::TouchingLeaving:
            return fmt::format("surfaces touch at the start, but {} is never reached", clear);
        case ToiStatus::TouchingPressing:
            return fmt::format(
                "surfaces touch at the start and approach; the robot may move until t = {}",
                report.time);
        case ToiStatus::IterationLimit:
            return fmt::format(
                "gave up; {} is not reached before t = {}, what follows is unknown: raise "
                "--max-iterations",
                clear,
                report.time);
        case ToiStatus::Stopped:
            return fmt::format(
                "stopped; {} is not reached before t = {}, what follows is unknown: raise "
                "--time-limit",
                clear,
                report.time);
    }
    return {};
}

std::span<const LinkContact> shownOf(const ArticulatedReport& report)
{
    return report.contacts.first(std::min(report.shown, report.contacts.size()));
}
}  // namespace

std::string readableText(const ArticulatedReport& report,
                         const ArticulatedNames& names,
                         const ToiOptions& options)
{
    std::string text =
        fmt::format("{}: {}\n", statusWord(report.status), sentence(report, options));
    for (const LinkContact& contact : shownOf(report))
    {
        text += readableContact(contact, names);
    }
    if (report.shown < report.contacts.size())
    {
        text +=
            fmt::format("  and {} more: raise --contacts\n", report.contacts.size() - report.shown);
    }
    for (const auto& [name, time] : stopsOf(report, names))
    {
        text += fmt::format("  stopped     {} at {:.9g}\n", name, time);
    }
    const ArticulatedCounters& c = report.counters;
    return text + fmt::format(
                      "  pairs       {}, culled by space {}, by time {}\n"
                      "  examined    {} node pairs, {} triangle pairs, {} states, {} "
                      "intervals halved\n"
                      "{}"
                      "  took        {:.1f} microseconds\n",
                      c.pairs,
                      c.culledBySpace,
                      c.culledByTime,
                      c.nodePairs,
                      c.trianglePairs,
                      c.states,
                      c.subdivisions,
                      report.needed ? readableText(*report.needed) : "",
                      report.microseconds);
}

std::string jsonText(const ArticulatedReport& report, const ArticulatedNames& names)
{
    std::string contacts;
    for (const LinkContact& contact : shownOf(report))
    {
        contacts += contacts.empty() ? "" : ",";
        contacts += jsonContact(contact, names);
    }
    std::string stops;
    for (const auto& [name, time] : stopsOf(report, names))
    {
        stops += fmt::format("{}{}: {}", stops.empty() ? "" : ", ", quoted(name), time);
    }
    const ArticulatedCounters& c = report.counters;
    return fmt::format(
        R"({{
  "status": "{}",
  "toi": {},
  "contacts": {},
  "contact_count": {},
  "stop_times": {},
  "pairs": {},
  "culled_by_space": {},
  "culled_by_time": {},
  "node_pairs": {},
  "triangle_pairs": {},
  "states": {},
  "subdivisions": {},{}
  "microseconds": {}
}}
)",
        statusWord(report.status),
        report.time,
        contacts.empty() ? "null" : fmt::format("[{}\n  ]", contacts),
        report.contacts.size(),
        report.stopTimes.empty() ? "null" : fmt::format("{{{}}}", stops),
        c.pairs,
        c.culledBySpace,
        c.culledByTime,
        c.nodePairs,
        c.trianglePairs,
        c.states,
        c.subdivisions,
        report.needed ? "\n  " + jsonText(*report.needed) + "," : "",
        report.microseconds);
}

std::string articulatedHeader()
{
    return "id,status,toi,contacts,link,obstacle,other_link,stop_joint,gap,px,py,pz,nx,ny,nz,"
           "triangle_link,triangle_other,pairs,culled_by_space,culled_by_time,subdivisions,"
           "iterations,microseconds";
}

std::string articulatedRow(const std::string& id,
                           const ArticulatedAnswer& answer,
                           const ArticulatedNames& names)
{
    const ArticulatedToiResult& result = answer.result;
    std::string contact = ",,,,,,,,,,,,";
    if (isContact(result.status) && !result.contacts.empty())
    {
        const LinkContact& first = result.contacts[0];
        const Eigen::Vector3d p = 0.5 * (first.pointLink + first.pointOther);
        const Eigen::Vector3d& n = first.normal;
        const std::string other = csvCell(otherName(first, names));
        contact =
            fmt::format("{},{},{},{},{},{},{},{},{},{}",
                        csvCell(names.links.linkName(first.link)),
                        fmt::format(fmt::runtime(first.obstacle != kNone ? "{}," : ",{}"), other),
                        csvCell(stopName(first, names)),
                        first.gap,
                        p.x(),
                        p.y(),
                        p.z(),
                        hasNormal(first) ? fmt::format("{},{},{}", n.x(), n.y(), n.z()) : ",,",
                        first.triangleLink,
                        first.triangleOther);
    }
    const ArticulatedCounters& c = result.counters;
    return fmt::format("{},{},{},{},{},{},{},{},{},{},{}",
                       csvCell(id),
                       statusWord(result.status),
                       result.time,
                       result.contacts.size(),
                       contact,
                       c.pairs,
                       c.culledBySpace,
                       c.culledByTime,
                       c.subdivisions,
                       c.nodePairs + c.trianglePairs,
                       answer.microseconds);
}
}  // namespace bullet_ccd::tools
