// A walking, running and kicking human of 15 links among 16 chessmen on their board, from one frame
// of the recorded motion to the next: answers checked, then timed in turns with each pair of a link
// and an obstacle on its own, with FCL's samples, and with stages of the query switched off.
#include "benchmarks/articulated/human_peers.h"
#include "benchmarks/articulated/human_scene.h"
#include "benchmarks/support/counters.h"
#include "benchmarks/support/files.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/distance/triangle_distance.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Sums over the queries of a method.
struct Mix
{
    std::string method{};
    int queries = 0;
    int contacts = 0;
    int exemptContacts = 0;  ///< of those, by a pair that intersects at the start, elsewhere on it
    int busy = 0;            ///< free with three pairs or more after spatial culling
    int exempt = 0;          ///< with pairs that intersect at the start
    int wrong = 0;
    double late = 0.0;   ///< largest, against rigidToi() on each pair
    double early = 0.0;  ///< the same
    ArticulatedCounters counters{};
    double micros = 0.0;
    double microsOfContacts = 0.0;  ///< of those queries alone
};

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
/// One motion in its scene.
class HumanRun
{
public:
    HumanRun(const std::filesystem::path& data, const std::string& name, bool withFcl);

    void describe() const;

    /// Asks all and compares the answers, then takes the times of all but FCL in turns.
    /// @return the stages, then rigidToi() on each pair, then FCL if it is asked
    [[nodiscard]] std::vector<Mix> run(std::span<const Stage> stages, int repeats);

private:
    void askPeers();
    [[nodiscard]] Mix check(const Stage& stage, std::vector<bool>& hits);
    [[nodiscard]] bool isWrong(std::size_t query, const ArticulatedToiResult& result) const;
    [[nodiscard]] bool isApartAt(const HumanQuery& query, const LinkContact& contact) const;
    [[nodiscard]] double distanceOf(const HumanQuery& query, const LinkContact& contact) const;

    std::string m_name;
    HumanScene m_scene;
    Environment m_environment;
    std::unique_ptr<FclHuman> m_fcl;
    std::vector<double> m_rigidTimes;   ///< of contact
    std::vector<double> m_sampleTimes;  ///< FCL's first sample that overlaps
    double m_fclMicros = 0.0;
    ToiWorkspace m_work;
};

HumanRun::HumanRun(const std::filesystem::path& data, const std::string& name, bool withFcl)
    : m_name(name), m_scene(makeHumanScene(data, name)), m_environment(m_scene.obstacles)
{
    if (withFcl)
    {
        m_fcl = std::make_unique<FclHuman>(m_scene);
    }
}

void HumanRun::describe() const
{
    std::size_t exempt = 0;
    for (const HumanQuery& query : m_scene.queries)
    {
        exempt += query.masks.size();
    }
    fmt::print(
        "{}: {} queries; {} links of {} triangles; {} obstacles of {} triangles; {} pairs "
        "intersect at the start\n",
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
        m_rigidTimes.push_back(rigidTime(m_scene, query, kHumanTolerance, m_work));
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
    return distance > kHumanTolerance || distance <= 0.0 ||
           !isApartAt(m_scene.queries[query], contact);
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
    { keep(rigidTime(m_scene, m_scene.queries[f], kHumanTolerance, m_work)); };
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
struct HumanOptions
{
    std::filesystem::path data = defaultDataFolder();
    std::vector<std::string> motions{"walk", "run", "kick"};
    int repeats = 7;
    bool fcl = true;
};

nlohmann::json rowOfMix(const Mix& mix)
{
    nlohmann::json row{{"method", mix.method}, {"us", mix.micros / mix.queries}};
    if (mix.counters.pairs > 0)
    {
        row.update(rowOf(mix.counters, mix.queries));
        row.update({{"wrong", mix.wrong}, {"late", mix.late}, {"early", mix.early}});
    }
    return row;
}

/// The whole query first.
void printTable(const std::vector<Mix>& mixes)
{
    const Mix& whole = mixes.front();
    const int free = whole.queries - whole.contacts;
    const auto share = [&](int part) { return 100.0 * part / whole.queries; };
    fmt::print(
        "  contact in {} queries ({:.0f} %), {} of them by a pair that intersects at the start\n"
        "  free with three pairs or more {} ({:.0f} %); with exempt pairs {} ({:.0f} %)\n"
        "  {}: {:.1f} us with contact, {:.1f} us free\n",
        whole.contacts,
        share(whole.contacts),
        whole.exemptContacts,
        whole.busy,
        share(whole.busy),
        whole.exempt,
        share(whole.exempt),
        whole.method,
        whole.microsOfContacts / std::max(1, whole.contacts),
        (whole.micros - whole.microsOfContacts) / std::max(1, free));
    const Table table(
        fmt::format("method:<20|us:>9.1f|wrong:>5|{}|late:>7.0e|early:>7.0e", kCounterColumns));
    for (const Mix& mix : mixes)
    {
        table.print(rowOfMix(mix));
    }
}

bool must(const char* what, double value, double bound, bool isUpper)
{
    const bool holds = isUpper ? value <= bound : value >= bound;
    fmt::print("  {:<45} {:9.3f}  must be {} {:<5} {}\n",
               what,
               value,
               isUpper ? "<=" : ">=",
               bound,
               holds ? "holds" : "MISSED");
    return holds;
}

bool judge(const std::vector<Mix>& mixes)
{
    const Mix& mix = mixes.front();
    const auto timesOurs = [&](const std::string& method)
    { return std::ranges::find(mixes, method, &Mix::method)->micros / mix.micros; };
    const double count = mix.queries;
    bool holds = must("share of queries with contact", mix.contacts / count, 0.3, false);
    holds = must("share free with three pairs or more", mix.busy / count, 0.3, false) && holds;
    holds =
        must("rigidToi on each pair / ours (goal 10)", timesOurs("rigidToi on each"), 3.0, false) &&
        holds;
    if (mixes.back().method == "FCL x 1,001")
    {
        holds = must("FCL x 1,001 per link / ours", timesOurs("FCL x 1,001"), 10.0, false) && holds;
    }
    return holds;
}

bool runHuman(const HumanOptions& options)
{
    const std::vector<Stage> stages = humanStages();
    std::vector<Mix> all;
    for (const std::string& name : options.motions)
    {
        HumanRun motion(options.data, name, options.fcl);
        motion.describe();
        const std::vector<Mix> mixes = motion.run(stages, options.repeats);
        printTable(mixes);
        all.resize(mixes.size());
        for (std::size_t k = 0; k < mixes.size(); ++k)
        {
            add(all[k], mixes[k]);
        }
    }
    fmt::print("all: {} queries\n", all.front().queries);
    printTable(all);
    int wrong = 0;
    for (const Mix& mix : all)
    {
        wrong += mix.wrong;
    }
    const bool isRight = must("wrong answers of all stages", wrong, 0.0, true);
    return judge(all) && isRight;
}

}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    HumanOptions human;
    return runProgram(
        argc,
        argv,
        {.name = "bench_articulated",
         .about = "Queries of moving linkages: answers checked, then timed",
         .options = {{"--data", &human.data, "data folder"}},
         .verbs = {{.name = "human",
                    .about = "15 links among 16 chessmen, beside FCL",
                    .options = {{"--motion", &human.motions, "walk, run, kick"},
                                {"--repeats", &human.repeats, "passes; the median counts"},
                                {"!--no-fcl", &human.fcl, "without FCL"}},
                    .run = [&] { return runHuman(human); }}}});
}
