/// A walking, running and kicking human of 15 links among 16 chessmen on their board, from one
/// frame of the recorded motion to the next: answers checked, then timed beside FCL's samples,
/// beside each pair of a link and an obstacle on its own, and with every stage of the query
/// switched off.
#include "benchmarks/human_peers.h"
#include "benchmarks/human_scene.h"
#include "benchmarks/rigid_run.h"
#include "benchmarks/rigid_targets.h"
#include "benchmarks/timing.h"
#include "bullet_ccd/distance/triangle_distance.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
constexpr double kTolerance = 1e-5;
constexpr double kNever = 2.0;  ///< time of no contact

struct Options
{
    std::string data = defaultDataFolder().string();
    std::vector<std::string> motions{"walk", "run", "kick"};
    double aside = 0.45;
    int repeats = 5;
    bool fcl = true;
    bool list = false;
};

struct Stage
{
    const char* name;
    ArticulatedToiOptions options;
};

ArticulatedToiOptions ours()
{
    return {.toi = {.tolerance = kTolerance}};
}

std::vector<Stage> stages()
{
    std::vector<Stage> all{{"articulatedToi", ours()},
                           {"without subdivision", ours()},
                           {"without space", ours()},
                           {"without time", ours()},
                           {"directional bound", ours()},
                           {"sum bound", ours()}};
    all[1].options.subdivide = false;
    all[2].options.cullBySpace = false;
    all[3].options.cullByTime = false;
    all[4].options.bound = MotionBound::Directional;
    all[5].options.bound = MotionBound::Sum;
    return all;
}

/// What the other methods say of one query.
struct Reference
{
    double rigid = kNever;
    double sample = kNever;  ///< FCL's first; kNever too if FCL was not asked
};

/// Sums over the queries of one motion.
struct Mix
{
    int queries = 0;
    int contacts = 0;
    int busy = 0;  ///< free with three pairs or more after spatial culling
    int masked = 0;
    int wrong = 0;
    double latest = 0.0;
    double earliest = 0.0;
    ArticulatedCounters counters;
};

void add(Mix& sum, const Mix& more)
{
    sum.queries += more.queries;
    sum.contacts += more.contacts;
    sum.busy += more.busy;
    sum.masked += more.masked;
    sum.wrong += more.wrong;
    sum.latest = std::max(sum.latest, more.latest);
    sum.earliest = std::max(sum.earliest, more.earliest);
    sum.counters.pairs += more.counters.pairs;
    sum.counters.culledBySpace += more.counters.culledBySpace;
    sum.counters.culledByTime += more.counters.culledByTime;
    sum.counters.nodePairs += more.counters.nodePairs;
    sum.counters.trianglePairs += more.counters.trianglePairs;
    sum.counters.states += more.counters.states;
    sum.counters.subdivisions += more.counters.subdivisions;
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

/// Distance of the triangles that a contact names, placed anew.
double distanceOf(const HumanScene& scene, const HumanQuery& query, const LinkContact& contact)
{
    const RigidBody& obstacle = scene.obstacles[static_cast<std::size_t>(contact.obstacle)];
    const Eigen::Isometry3d X_WL =
        linkStateAt(scene.tree, query.motion, kNone, contact.link, contact.time).X_W;
    return triangleDistance(corners(*scene.linkTrees[static_cast<std::size_t>(contact.link)],
                                    contact.triangleLink,
                                    X_WL),
                            corners(*obstacle.tree, contact.triangleOther, obstacle.motion.X_W0))
        .distance;
}

/// True if the answer cannot be: later than another method, or without a contact where it says.
bool isWrong(const HumanScene& scene,
             const HumanQuery& query,
             const ArticulatedToiResult& result,
             const Reference& reference,
             const FclHuman* fcl)
{
    const bool isHit = isContact(result.status);
    const double time = isHit ? result.time : kNever;
    // The other method stops up to its own tolerance early.
    constexpr double kSlack = 1e-6;
    if (result.status == ToiStatus::IterationLimit || result.status == ToiStatus::Overlapping ||
        time > reference.rigid + kSlack || time > reference.sample)
    {
        return true;
    }
    if (!isHit)
    {
        return false;
    }
    const LinkContact& contact = result.contacts.at(0);
    const double distance = distanceOf(scene, query, contact);
    const bool isMasked = query.maskOf(contact.link, contact.obstacle) != nullptr;
    const bool overlaps = fcl != nullptr && !isMasked &&
                          fcl->distanceOf(query, contact.link, contact.obstacle, time) <= 0.0;
    return distance > kTolerance || distance <= 0.0 || overlaps;
}

/// One motion in its scene.
class MotionRun
{
public:
    MotionRun(const Options& options, std::string name)
        : m_options(options),
          m_name(std::move(name)),
          m_scene(makeHumanScene(options.data, m_name, options.aside)),
          m_environment(m_scene.obstacles)
    {
        if (options.fcl && isFclPresent())
        {
            m_fcl = std::make_unique<FclHuman>(m_scene);
        }
    }

    void describe() const
    {
        fmt::print("{}: {} queries, 15 links of {} triangles, {} obstacles of {}\n",
                   m_name,
                   m_scene.queries.size(),
                   m_scene.humanTriangles,
                   m_scene.obstacles.size(),
                   m_scene.obstacleTriangles);
        for (std::size_t f = 0; m_options.list && f < m_scene.queries.size(); ++f)
        {
            for (const LinkMask& mask : m_scene.queries[f].masks)
            {
                fmt::print("  frame {}: {} and {} intersect at the start, exempt there\n",
                           f,
                           m_scene.tree.links[static_cast<std::size_t>(mask.link)].name,
                           m_scene.obstacleNames[static_cast<std::size_t>(mask.obstacle)]);
            }
        }
    }

    /// Asks the other methods, once each, and times them.
    void askPeers()
    {
        for (const HumanQuery& query : m_scene.queries)
        {
            Reference& reference = m_references.emplace_back();
            m_rigidMicros += microsecondsOf(
                [&] { reference.rigid = rigidTime(m_scene, query, kTolerance, m_work); });
            if (m_fcl != nullptr)
            {
                m_fclMicros += microsecondsOf(
                    [&] { reference.sample = m_fcl->firstSample(query, kNaiveSamples); });
            }
        }
    }

    /// Asks all queries once, checks and counts.
    Mix check(const Stage& stage)
    {
        Mix mix;
        for (std::size_t f = 0; f < m_scene.queries.size(); ++f)
        {
            const HumanQuery& query = m_scene.queries[f];
            const ArticulatedToiResult result =
                articulatedToi(m_scene.body(query), m_environment, stage.options, m_work);
            Mix one{
                .queries = 1, .masked = query.masks.empty() ? 0 : 1, .counters = result.counters};
            const ArticulatedCounters& c = result.counters;
            one.contacts = isContact(result.status) ? 1 : 0;
            one.busy = one.contacts == 0 && c.pairs - c.culledBySpace >= 3 ? 1 : 0;
            one.wrong = isWrong(m_scene, query, result, m_references[f], m_fcl.get()) ? 1 : 0;
            const double time = one.contacts != 0 ? result.time : kNever;
            one.latest = std::max(0.0, time - m_references[f].rigid);
            one.earliest = std::max(0.0, m_references[f].rigid - time);
            add(mix, one);
        }
        return mix;
    }

    /// Mean of the medians over repeats, summed over the queries.
    double time(const Stage& stage)
    {
        std::vector<std::vector<double>> times(m_scene.queries.size());
        for (int repeat = 0; repeat < m_options.repeats; ++repeat)
        {
            for (std::size_t f = 0; f < m_scene.queries.size(); ++f)
            {
                const ArticulatedBody body = m_scene.body(m_scene.queries[f]);
                times[f].push_back(microsecondsOf(
                    [&]
                    { keep(articulatedToi(body, m_environment, stage.options, m_work).time); }));
            }
        }
        return meanOfMedians(times) * static_cast<double>(times.size());
    }

    [[nodiscard]] double rigidMicros() const { return m_rigidMicros; }
    [[nodiscard]] double fclMicros() const { return m_fclMicros; }

private:
    const Options& m_options;
    std::string m_name;
    HumanScene m_scene;
    Environment m_environment;
    std::unique_ptr<FclHuman> m_fcl;
    std::vector<Reference> m_references;
    ToiWorkspace m_work;
    double m_rigidMicros = 0.0;
    double m_fclMicros = 0.0;
};

void print(const char* name, const Mix& mix, double micros)
{
    const ArticulatedCounters& c = mix.counters;
    const auto mean = [&](std::int64_t sum) { return static_cast<double>(sum) / mix.queries; };
    const auto share = [&](std::int64_t part)
    { return 100.0 * static_cast<double>(part) / static_cast<double>(c.pairs); };
    fmt::print(
        "  {:<20} {:9.2f} us; wrong {}; pairs {:.0f}, by space {:.1f} %, by time {:.2f} %; nodes "
        "{:.0f}, triangles {:.1f}, states {:.0f}, halved {:.2f}; against rigidToi late {:.0e}, "
        "early {:.0e}\n",
        name,
        micros / mix.queries,
        mix.wrong,
        mean(c.pairs),
        share(c.culledBySpace),
        share(c.culledByTime),
        mean(c.nodePairs),
        mean(c.trianglePairs),
        mean(c.states),
        mean(c.subdivisions),
        mix.latest,
        mix.earliest);
}

void printMix(const Mix& mix)
{
    const auto share = [&](int part) { return 100.0 * part / mix.queries; };
    fmt::print(
        "  contact {} ({:.0f} %), free with three pairs or more {} ({:.0f} %), with exempt "
        "pairs {} ({:.0f} %)\n",
        mix.contacts,
        share(mix.contacts),
        mix.busy,
        share(mix.busy),
        mix.masked,
        share(mix.masked));
}

/// Mean time of FCL on the recorded bunny queries; 0 without FCL.
double unitMicros(const Options& options)
{
    if (!options.fcl || !isFclPresent())
    {
        return 0.0;
    }
    MeshLibrary meshes(options.data);
    const std::array sets{makeRigidSet("bunny_ident", meshes)};
    Hierarchies hierarchies;
    NaiveCache cache("");
    return runTogether(sets, {.repeats = 1, .fclRepeats = 1, .check = false}, hierarchies, cache)
        .at(0)
        .fclMicros;
}

bool must(const char* what, double value, double bound, bool isUpper)
{
    const bool holds = isUpper ? value <= bound : value >= bound;
    fmt::print("  {:<58} {:8.3f}  must be {} {:<5} {}\n",
               what,
               value,
               isUpper ? "<=" : ">=",
               bound,
               holds ? "holds" : "MISSED");
    return holds;
}

int run(const Options& options)
{
    const double unit = unitMicros(options);
    const std::vector<Stage> all = stages();
    std::vector<double> micros(all.size(), 0.0);
    std::vector<Mix> mixes(all.size());
    double rigid = 0.0;
    double fcl = 0.0;
    for (const std::string& name : options.motions)
    {
        MotionRun motion(options, name);
        motion.describe();
        motion.askPeers();
        for (std::size_t k = 0; k < all.size(); ++k)
        {
            const Mix mix = motion.check(all[k]);
            const double time = motion.time(all[k]);
            if (k == 0)
            {
                printMix(mix);
                fmt::print("  {:<20} {:9.2f} us\n  {:<20} {:9.2f} us\n",
                           "rigidToi per pair",
                           motion.rigidMicros() / mix.queries,
                           "FCL x 1,001 per link",
                           motion.fclMicros() / mix.queries);
            }
            print(all[k].name, mix, time);
            add(mixes[k], mix);
            micros[k] += time;
        }
        rigid += motion.rigidMicros();
        fcl += motion.fclMicros();
    }
    const double count = mixes[0].queries;
    fmt::print("all: {} queries\n", mixes[0].queries);
    printMix(mixes[0]);
    for (std::size_t k = 0; k < all.size(); ++k)
    {
        print(all[k].name, mixes[k], micros[k]);
    }
    bool holds = must("wrong answers", mixes[0].wrong, 0.0, true);
    holds = must("share of queries with contact", mixes[0].contacts / count, 0.3, false) && holds;
    holds = must("share free with three pairs or more", mixes[0].busy / count, 0.3, false) && holds;
    holds = must("rigidToi on each pair / ours", rigid / micros[0], 3.0, false) && holds;
    if (unit > 0.0)
    {
        holds = must("FCL x 1,001 per link / ours", fcl / micros[0], 10.0, false) && holds;
        fmt::print("  FCL x 1,001 on bunny_ident {:.0f} us\n", unit);
        holds = must("ours / FCL x 1,001 on bunny_ident", micros[0] / count / unit, 0.10, true) &&
                holds;
    }
    return holds ? 0 : 1;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    bullet_ccd::benchmarks::Options options;
    CLI::App app("A human of 15 links among chessmen: answers checked, then timed beside FCL");
    app.add_option("DATA", options.data, "data folder")->capture_default_str();
    app.add_option("--motion", options.motions, "walk, run, kick")->type_name("NAME");
    app.add_option("--aside", options.aside, "distance of the chessmen from the path, m")
        ->capture_default_str();
    app.add_option("--repeats", options.repeats, "passes; the median counts")
        ->capture_default_str();
    app.add_flag("--list", options.list, "list pairs that intersect at the start");
    app.add_flag("!--no-fcl", options.fcl, "without FCL");
    app.footer("Exit codes: 0 all that must hold does, 1 not, 2 usage or missing files.");
    try
    {
        app.parse(argc, argv);
        return bullet_ccd::benchmarks::run(options);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : 2;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "bench_articulated: %s\n", error.what());
        return 2;
    }
}
