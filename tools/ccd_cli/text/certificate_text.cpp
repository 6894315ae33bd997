#include "tools/ccd_cli/text/certificate_text.h"

#include "tools/ccd_cli/text/result_text.h"
#include "tools/support/csv_text.h"

#include <fmt/format.h>

namespace bullet_ccd::tools
{
namespace
{
/// A link, and the link or obstacle beside it: of contacts and of least distances.
struct Sides
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;
    std::int32_t otherLink = kNone;
};

template <typename Answer>
Sides sidesOf(const Answer& answer)
{
    return {.link = answer.link, .obstacle = answer.obstacle, .otherLink = answer.otherLink};
}

const std::string& secondName(const Sides& sides, const ArticulatedNames& names)
{
    return sides.obstacle != kNone ? names.obstacles[static_cast<std::size_t>(sides.obstacle)].name
                                   : names.links.linkName(sides.otherLink);
}

std::string sidesText(const Sides& sides, const ArticulatedNames& names)
{
    return fmt::format("link {} and {} {}",
                       names.links.linkName(sides.link),
                       sides.obstacle != kNone ? "obstacle" : "link",
                       secondName(sides, names));
}

std::string sidesCells(const Sides& sides, const ArticulatedNames& names)
{
    const std::string second = csvCell(secondName(sides, names));
    return fmt::format("{},{},{}",
                       csvCell(names.links.linkName(sides.link)),
                       sides.obstacle != kNone ? second : "",
                       sides.obstacle != kNone ? "" : second);
}

std::string numbers(const Eigen::Vector3d& v, const char* separator)
{
    return fmt::format("{1:.9g}{0}{2:.9g}{0}{3:.9g}", separator, v.x(), v.y(), v.z());
}

std::string placeLines(const Eigen::Vector3d& pointA,
                       const Eigen::Vector3d& pointB,
                       const Eigen::Vector3d& normal)
{
    return fmt::format("    points     {} - {}\n    normal     {}\n",
                       numbers(pointA, " "),
                       numbers(pointB, " "),
                       normal.isZero(0.0) ? "none: the surfaces intersect" : numbers(normal, " "));
}

std::string contactText(const Certificate& certificate,
                        const ArticulatedNames& names,
                        const ToiOptions& options)
{
    const TrajectoryToiResult& toi = certificate.toi;
    const LinkContact& contact = toi.contacts[0];
    const bool isStart = toi.status == ToiStatus::Overlapping;
    std::string what =
        options.minimumSeparation > 0.0
            ? fmt::format("the margin of {:.6g} is reached", options.minimumSeparation)
            : "contact";
    if (isStart)
    {
        what = options.minimumSeparation > 0.0
                   ? fmt::format("closer than the margin of {:.6g}", options.minimumSeparation)
                   : "surfaces intersect";
    }
    std::string text = fmt::format("contact: {} at {:.9g} s, {} segment {}: {}, gap {:.4g}\n",
                                   what,
                                   toi.time,
                                   isStart ? "at the start of" : "in",
                                   toi.segment,
                                   sidesText(sidesOf(contact), names),
                                   contact.gap) +
                       placeLines(contact.pointLink, contact.pointOther, contact.normal);
    if (toi.contacts.size() > 1)
    {
        text += fmt::format("    and {} more at that time\n", toi.contacts.size() - 1);
    }
    return text;
}

std::string freeText(const Certificate& certificate,
                     const ArticulatedNames& names,
                     const ToiOptions& options)
{
    std::string text = fmt::format("free: {} is never reached from {:.9g} to {:.9g} s, {} {}\n",
                                   excludedWords(options),
                                   certificate.start,
                                   certificate.toi.time,
                                   certificate.segments,
                                   certificate.segments == 1 ? "segment" : "segments");
    if (certificate.least)
    {
        const TrajectoryLeastDistance& least = *certificate.least;
        if (least.link == kNone)
        {
            return text + "  the search for the least distance ended before it found one: raise " +
                   (least.status == ToiStatus::Stopped ? "--time-limit\n" : "--max-iterations\n");
        }
        if (gaveUp(least.status))
        {
            text += fmt::format(
                "  the search for the least distance gave up: it is between {:.9g} "
                "and {:.9g}\n",
                least.distance,
                least.found);
        }
        text += fmt::format("  {} distance {:.9g} at {:.9g} s, in segment {}: {}\n",
                            gaveUp(least.status) ? "found" : "least",
                            gaveUp(least.status) ? least.found : least.distance,
                            least.seconds,
                            least.segment,
                            sidesText(sidesOf(least), names)) +
                placeLines(least.pointA, least.pointB, least.normal);
    }
    return text;
}
}  // namespace

std::string verdictWord(Verdict verdict)
{
    switch (verdict)
    {
        case Verdict::Free:
            return "free";
        case Verdict::Contact:
            return "contact";
        case Verdict::Unknown:
            return "unknown";
        case Verdict::BadInput:
            return "bad_input";
    }
    return {};
}

std::string readableText(const Certificate& certificate,
                         const ArticulatedNames& names,
                         const ToiOptions& options)
{
    switch (verdictOf(certificate))
    {
        case Verdict::Free:
            return freeText(certificate, names, options);
        case Verdict::Contact:
            return contactText(certificate, names, options);
        case Verdict::Unknown:
            return fmt::format(
                "unknown: {} is not reached before {:.9g} s, what follows is unknown: raise {}\n",
                excludedWords(options),
                certificate.toi.time,
                certificate.toi.status == ToiStatus::Stopped ? "--time-limit" : "--max-iterations");
        case Verdict::BadInput:
            return {};
    }
    return {};
}

std::string certificateHeader()
{
    return "trajectory,result,time,segment,link,obstacle,other_link,gap,px,py,pz,nx,ny,nz,"
           "least_distance,least_found,least_time,least_link,least_obstacle,least_other_link,"
           "microseconds";
}

std::string certificateRow(const Certificate& certificate, const ArticulatedNames& names)
{
    const Verdict verdict = verdictOf(certificate);
    const std::string start =
        fmt::format("{},{},", csvCell(certificate.name), verdictWord(verdict));
    if (verdict == Verdict::BadInput)
    {
        return start + ",,,,,,,,,,,,,,,,,,";
    }
    const TrajectoryToiResult& toi = certificate.toi;
    std::string contact = ",,,,,,,,,";
    if (verdict == Verdict::Contact)
    {
        const LinkContact& first = toi.contacts[0];
        const Eigen::Vector3d p = 0.5 * (first.pointLink + first.pointOther);
        const Eigen::Vector3d& n = first.normal;
        contact = fmt::format("{},{},{},{},{},{}",
                              sidesCells(sidesOf(first), names),
                              first.gap,
                              p.x(),
                              p.y(),
                              p.z(),
                              n.isZero(0.0) ? ",," : fmt::format("{},{},{}", n.x(), n.y(), n.z()));
    }
    std::string least = ",,,,,";
    if (certificate.least && certificate.least->link != kNone)
    {
        least = fmt::format("{},{},{},{}",
                            certificate.least->distance,
                            certificate.least->found,
                            certificate.least->seconds,
                            sidesCells(sidesOf(*certificate.least), names));
    }
    return start + fmt::format("{},{},{},{},{}",
                               toi.time,
                               toi.segment == kNone ? "" : fmt::format("{}", toi.segment),
                               contact,
                               least,
                               certificate.microseconds);
}
}  // namespace bullet_ccd::tools
