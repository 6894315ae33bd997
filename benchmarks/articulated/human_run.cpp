#include "benchmarks/articulated/human_run.h"

#include "benchmarks/support/timing.h"
#include "bullet_ccd/distance/triangle_distance.h"

#include <algorithm>
#include <fmt/format.h>

namespace bullet_ccd::benchmarks
{
namespace
{
constexpr double kTolerance = 1e-5;  ///< [m]

TriangleCorners corners(const SsvTree& tree, std::int32_t triangle, const Eigen::Isometry3d& X)
{
    const Triangle& t = tree.mesh().triangles[static_cast<std::size_t>(triangle)];
    TriangleCorners result;
    for (std::size_t k = 0; k < 3; ++k)
    {
        result[k] = X * tree.mesh().vertices[static_cast<std::size_t>(t[k])];
    }
    return result;
}
}  // namespace

std::vector<Stage> humanStages()
{
    const ArticulatedToiOptions whole{.toi = {.tolerance = kTolerance}};
    std::vector<Stage> all{{"articulatedToi", whole},
                           {"without halving", whole},
                           {"without space", whole},
                           {"without time", whole}};
    all[1].options.subdivide = false;
    all[2].options.cullBySpace = false;
    all[3].options.cullByTime = false;
    return all;
}

void add(Mix& sum, const Mix& more)
{
    sum.method = sum.method.empty() ? more.method : sum.method;
    sum.queries += more.queries;
    sum.contacts += more.contacts;
    sum.exemptContacts += more.exemptContacts;
    sum.busy += more.busy;
    sum.exempt += more.exempt;
    sum.wrong += more.wrong;
    sum.late = std::max(sum.late, more.late);
    sum.early = std::max(sum.early, more.early);
    sum.counters += more.counters;
    sum.micros += more.micros;
    sum.microsOfContacts += more.microsOfContacts;
}

HumanRun::HumanRun(const std::filesystem::path& data, const std::string& name, bool withFcl)
    : m_name(name), m_scene(makeHumanScene(data, name)), m_environment(m_scene.obstacles)
{
    if (withFcl)
    {
        m_fcl = std::make_unique<FclHuman>(m_scene);
    }
}

void HumanRun::describe(bool listExempt) const
{
    std::size_t exempt = 0;
    for (std::size_t f = 0; f < m_scene.queries.size(); ++f)
    {
        for (const LinkMask& mask : m_scene.queries[f].masks)
        {
            ++exempt;
            if (listExempt)
            {
                fmt::print("  frame {}: {} and {} intersect at the start\n",
                           f,
                           m_scene.tree.links[static_cast<std::size_t>(mask.link)].name,
                           m_scene.obstacleNames[static_cast<std::size_t>(mask.obstacle)]);
            }
        }
    }
    fmt::print(
        "{}: {} queries; {} links of {} triangles; {} obstacles of {} triangles; {} pairs "
        "intersect "
        "at the start\n",
        m_name,
        m_scene.queries.size(),
        m_scene.links.size(),
        m_scene.humanTriangles,
        m_scene.obstacles.size(),
        m_scene.obstacleTriangles,
        exempt);
}

void HumanRun::askPeers()
{
    for (const HumanQuery& query : m_scene.queries)
    {
        m_rigidTimes.push_back(rigidTime(m_scene, query, kTolerance, m_work));
        m_sampleTimes.push_back(kNever);
        if (m_fcl != nullptr)
        {
            m_fclMicros += microsecondsOf(
                [&] { m_sampleTimes.back() = m_fcl->firstSample(query, kNaiveSamples); });
        }
    }
}

/// Distance of the triangles that a contact names, placed anew.
double HumanRun::distanceOf(const HumanQuery& query, const LinkContact& contact) const
{
    const RigidBody& obstacle = m_scene.obstacles[static_cast<std::size_t>(contact.obstacle)];
    const Eigen::Isometry3d X_WL =
        linkStateAt(m_scene.tree, query.motion, kNone, contact.link, contact.time).X_W;
    return triangleDistance(corners(*m_scene.linkTrees[static_cast<std::size_t>(contact.link)],
                                    contact.triangleLink,
                                    X_WL),
                            corners(*obstacle.tree, contact.triangleOther, obstacle.motion.X_W0))
        .distance;
}

/// Whether FCL, too, finds the two apart at the time of their contact; not known without FCL, or if
/// they intersect elsewhere from the start.
bool HumanRun::isApartAt(const HumanQuery& query, const LinkContact& contact) const
{
    return m_fcl == nullptr || query.maskOf(contact.link, contact.obstacle) != nullptr ||
           m_fcl->distanceOf(query, contact.link, contact.obstacle, contact.time) > 0.0;
}

/// True if the answer cannot be: later than another method, or without a contact where it says.
bool HumanRun::isWrong(std::size_t query, const ArticulatedToiResult& result) const
{
    const bool isHit = isContact(result.status);
    const double time = isHit ? result.time : kNever;
    // Both methods may stop at different distances below the tolerance.
    constexpr double kSlack = 1e-6;
    if (result.status == ToiStatus::IterationLimit || result.status == ToiStatus::Overlapping ||
        time > m_rigidTimes[query] + kSlack || time > m_sampleTimes[query])
    {
        return true;
    }
    if (!isHit)
    {
        return false;
    }
    const LinkContact& contact = result.contacts.at(0);
    const double distance = distanceOf(m_scene.queries[query], contact);
    return distance > kTolerance || distance <= 0.0 || !isApartAt(m_scene.queries[query], contact);
}

Mix HumanRun::check(const Stage& stage, std::vector<bool>& hits)
{
    Mix mix{.method = stage.name};
    for (std::size_t f = 0; f < m_scene.queries.size(); ++f)
    {
        const HumanQuery& query = m_scene.queries[f];
        const ArticulatedToiResult result =
            articulatedToi(m_scene.body(query), m_environment, stage.options, m_work);
        const bool isHit = isContact(result.status);
        hits.push_back(isHit);
        const double time = isHit ? result.time : kNever;
        Mix one{.queries = 1,
                .contacts = isHit ? 1 : 0,
                .exempt = query.masks.empty() ? 0 : 1,
                .wrong = isWrong(f, result) ? 1 : 0,
                .late = std::max(0.0, time - m_rigidTimes[f]),
                .early = std::max(0.0, m_rigidTimes[f] - time),
                .counters = result.counters};
        if (isHit)
        {
            const LinkContact& contact = result.contacts.at(0);
            one.exemptContacts = query.maskOf(contact.link, contact.obstacle) != nullptr ? 1 : 0;
        }
        const ArticulatedCounters& c = result.counters;
        one.busy = !isHit && c.pairs - c.culledBySpace >= 3 ? 1 : 0;
        add(mix, one);
    }
    return mix;
}

std::vector<Mix> HumanRun::run(std::span<const Stage> stages, int repeats)
{
    askPeers();
    std::vector<Mix> mixes;
    std::vector<std::vector<bool>> hits(stages.size());
    std::vector<TimedMethod> timed;
    const std::size_t count = m_scene.queries.size();
    for (const Stage& stage : stages)
    {
        mixes.push_back(check(stage, hits[mixes.size()]));
        const auto ask = [&](std::size_t f)
        {
            const ArticulatedBody body = m_scene.body(m_scene.queries[f]);
            keep(articulatedToi(body, m_environment, stage.options, m_work).time);
        };
        timed.push_back({.queries = count, .passes = repeats, .ask = ask});
    }
    const auto askRigid = [&](std::size_t f)
    { keep(rigidTime(m_scene, m_scene.queries[f], kTolerance, m_work)); };
    timed.push_back({.queries = count, .passes = repeats, .ask = askRigid});
    mixes.push_back({.method = "rigidToi on each", .queries = static_cast<int>(count)});

    const std::vector<std::vector<double>> micros = timeInTurns(timed);
    for (std::size_t k = 0; k < mixes.size(); ++k)
    {
        mixes[k].micros = sumOf(micros[k]);
        for (std::size_t f = 0; k < hits.size() && f < count; ++f)
        {
            mixes[k].microsOfContacts += hits[k][f] ? micros[k][f] : 0.0;
        }
    }
    if (m_fcl != nullptr)
    {
        mixes.push_back(
            {.method = "FCL x 1,001", .queries = static_cast<int>(count), .micros = m_fclMicros});
    }
    return mixes;
}
}  // namespace bullet_ccd::benchmarks
