#include "tools/ccd_cli/text/result_text.h"

#include "bullet_ccd/math/check.h"
#include "tools/support/csv_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fmt/format.h>

namespace bullet_ccd::tools
{
namespace
{
bool hasPoints(const ToiResult& result)
{
    return isContact(result.status) && result.triangleA != kNone;
}

bool hasNormal(const ToiResult& result)
{
    return hasPoints(result) && !result.normal.isZero(0.0);
}

bool hasGap(const ToiResult& result)
{
    return !gaveUp(result.status) && std::isfinite(result.gap);
}

Eigen::Vector3d middle(const Eigen::Vector3d& pointA, const Eigen::Vector3d& pointB)
{
    return 0.5 * (pointA + pointB);
}

std::int64_t iterations(const ToiResult& result)
{
    return result.counters.nodePairs + result.counters.trianglePairs;
}

std::string cells(const Eigen::Vector3d& v, bool present)
{
    return present ? fmt::format("{},{},{}", v.x(), v.y(), v.z()) : ",,";
}

const char* kindWord(FeatureKind kind)
{
    switch (kind)
    {
        case FeatureKind::Vertex:
            return "vertex";
        case FeatureKind::Edge:
            return "edge";
        case FeatureKind::Face:
            return "face";
    }
    BULLET_CCD_ASSERT(false);
    return "";
}

std::string vertexNumbers(const Feature& feature, const char* separator)
{
    std::string text;
    for (const std::int32_t vertex : feature.vertices)
    {
        if (vertex != kNone)
        {
            text += (text.empty() ? "" : separator) + std::to_string(vertex);
        }
    }
    return text;
}

std::string jsonFeature(const Feature& feature, std::int32_t triangle)
{
    return fmt::format(R"({{"kind": "{}", "vertices": [{}], "triangle": {}}})",
                       kindWord(feature.kind),
                       vertexNumbers(feature, ", "),
                       triangle);
}

std::string jsonContacts(std::span<const FeatureContact> contacts)
{
    std::string text;
    for (const FeatureContact& c : contacts)
    {
        text += fmt::format(
            R"({}
    {{"a": {}, "b": {}, "gap": {}, "point_a": {}, "point_b": {}, "normal": {}}})",
            text.empty() ? "" : ",",
            jsonFeature(c.featureA, c.triangleA),
            jsonFeature(c.featureB, c.triangleB),
            c.gap,
            jsonArray(c.pointA),
            jsonArray(c.pointB),
            jsonArray(c.normal));
    }
    return text.empty() ? "null" : "[" + text + "\n  ]";
}

/// A table, one contact a line.
std::string readableContacts(std::span<const FeatureContact> contacts, double threshold)
{
    if (contacts.empty())
    {
        return {};
    }
    std::string text = fmt::format(
        "  contacts    {} within {:.6g}: feature of A - of B by mesh vertices from 0; "
        "gap; point; normal\n",
        contacts.size(),
        threshold);
    const auto name = [](const Feature& feature)
    { return fmt::format("{} {}", kindWord(feature.kind), vertexNumbers(feature, " ")); };
    const std::span shown = contacts.first(std::min(contacts.size(), kShownContacts));
    std::size_t width = 0;
    for (const FeatureContact& c : shown)
    {
        width = std::max(width, name(c.featureA).size() + 3 + name(c.featureB).size());
    }
    for (const FeatureContact& c : shown)
    {
        const Eigen::Vector3d point = middle(c.pointA, c.pointB);
        // Without the minus of a zero.
        const Eigen::Vector3d normal =
            (1e4 * c.normal).array().round() / 1e4 + Eigen::Array3d::Zero();
        text += fmt::format("    {:<{}}  {:<9.3g}  {:.6g} {:.6g} {:.6g}  {:.4f} {:.4f} {:.4f}\n",
                            name(c.featureA) + " - " + name(c.featureB),
                            width,
                            c.gap,
                            point.x(),
                            point.y(),
                            point.z(),
                            normal.x(),
                            normal.y(),
                            normal.z());
    }
    if (shown.size() < contacts.size())
    {
        text += fmt::format("    and {} more (--json has all)\n", contacts.size() - shown.size());
    }
    return text;
}

std::string words(const Eigen::Vector3d& v, bool present)
{
    return present ? fmt::format("{:.12g} {:.12g} {:.12g}", v.x(), v.y(), v.z()) : "none";
}

/// What the answer promises, in one sentence.
std::string sentence(const ToiResult& result, const ToiOptions& options)
{
    const std::string clear = excludedWords(options);
    switch (result.status)
    {
        case ToiStatus::Separated:
            return fmt::format(
                "{} is never reached; the distance is always at least {:.12g}", clear, result.gap);
        case ToiStatus::Hit:
            return fmt::format(
                "{} is not reached before t = {}; there the distance is {:.12g}, the tolerance {}",
                clear,
                result.time,
                result.gap,
                options.tolerance);
        case ToiStatus::Overlapping:
            return options.minimumSeparation > 0.0
                       ? "the bodies are closer than the minimum separation at the start"
                       : "the surfaces intersect at the start";
        case ToiStatus::TouchingLeaving:
            return fmt::format("the bodies touch at the start ({:.12g}) but {} is never reached",
                               result.gap,
                               clear);
        case ToiStatus::TouchingPressing:
            return fmt::format(
                "the bodies touch at the start and approach; they may move until t = {}, there "
                "the distance is {:.12g}",
                result.time,
                result.gap);
        case ToiStatus::IterationLimit:
            return fmt::format(
                "gave up; {} is not reached before t = {}, what follows is unknown: raise "
                "--max-iterations",
                clear,
                result.time);
        case ToiStatus::Stopped:
            return fmt::format(
                "stopped; {} is not reached before t = {}, what follows is unknown: raise "
                "--time-limit",
                clear,
                result.time);
    }
    return {};
}
}  // namespace

std::string statusWord(ToiStatus status)
{
    switch (status)
    {
        case ToiStatus::Separated:
            return "separated";
        case ToiStatus::Hit:
            return "hit";
        case ToiStatus::Overlapping:
            return "overlapping";
        case ToiStatus::TouchingLeaving:
            return "touching_leaving";
        case ToiStatus::TouchingPressing:
            return "touching_pressing";
        case ToiStatus::IterationLimit:
            return "iteration_limit";
        case ToiStatus::Stopped:
            return "stopped";
    }
    BULLET_CCD_ASSERT(false);
    return {};
}

std::string jsonArray(const Eigen::Vector3d& v, bool present)
{
    return present ? fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()) : "null";
}

std::string excludedWords(const ToiOptions& options)
{
    return options.minimumSeparation > 0.0
               ? fmt::format("a distance of {}", options.minimumSeparation)
               : "contact";
}

std::string resultHeader(bool warm)
{
    return std::string("id,status,toi,gap,px,py,pz,nx,ny,nz,iterations,microseconds") +
           (warm ? ",warm_microseconds" : "");
}

std::string resultRow(const std::string& id, const TimedAnswer& answer, bool warm)
{
    const ToiResult& result = answer.result;
    return fmt::format("{},{},{},{},{},{},{},{}{}",
                       csvCell(id),
                       statusWord(result.status),
                       result.time,
                       hasGap(result) ? fmt::format("{}", result.gap) : "",
                       cells(middle(result.pointA, result.pointB), hasPoints(result)),
                       cells(result.normal, hasNormal(result)),
                       iterations(result),
                       answer.microseconds,
                       warm ? fmt::format(",{}", answer.warmMicroseconds) : "");
}

std::string badResultRow(const std::string& id, bool warm)
{
    return fmt::format("{},{},,,,,,,,,,{}", csvCell(id), kBadRowWord, warm ? "," : "");
}

std::string jsonText(const TimedAnswer& answer, std::span<const FeatureContact> contacts)
{
    const ToiResult& result = answer.result;
    return fmt::format(
        R"({{
  "status": "{}",
  "toi": {},
  "gap": {},
  "point_a": {},
  "point_b": {},
  "normal": {},
  "contacts": {},
  "node_pairs": {},
  "triangle_pairs": {},
  "states": {},{}
  "microseconds": {}
}}
)",
        statusWord(result.status),
        result.time,
        hasGap(result) ? fmt::format("{}", result.gap) : "null",
        jsonArray(result.pointA, hasPoints(result)),
        jsonArray(result.pointB, hasPoints(result)),
        jsonArray(result.normal, hasNormal(result)),
        jsonContacts(contacts),
        result.counters.nodePairs,
        result.counters.trianglePairs,
        result.counters.states,
        answer.needed ? "\n  " + jsonText(*answer.needed) + "," : "",
        answer.microseconds);
}

std::string readableText(const TimedAnswer& answer,
                         const ToiOptions& options,
                         std::span<const FeatureContact> contacts)
{
    const ToiResult& result = answer.result;
    return fmt::format(
        "{}: {}\n"
        "  toi         {} of the interval\n"
        "  gap         {}\n"
        "  point on A  {}\n"
        "  point on B  {}\n"
        "  normal      {}{}\n"
        "{}"
        "  examined    {} node pairs, {} triangle pairs, {} states\n"
        "{}"
        "  took        {:.1f} microseconds\n",
        statusWord(result.status),
        sentence(result, options),
        result.time,
        hasGap(result) ? fmt::format("{:.12g}", result.gap) : "unknown",
        words(result.pointA, hasPoints(result)),
        words(result.pointB, hasPoints(result)),
        words(result.normal, hasNormal(result)),
        hasNormal(result) ? " (from A to B)" : "",
        readableContacts(contacts, options.minimumSeparation + options.tolerance),
        result.counters.nodePairs,
        result.counters.trianglePairs,
        result.counters.states,
        answer.needed ? readableText(*answer.needed) : "",
        answer.microseconds);
}
}  // namespace bullet_ccd::tools
