// Contacts of deforming meshes: ours against union boxes with bisection and advancement.
#include "benchmarks/reference/oracles/plain_features.h"
#include "benchmarks/reference/scenes/deforming_scenes.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/deformable/kernels/surface_kernels.h"
#include "tools/ccd_cli/files/elementary_file.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;

struct Arguments
{
    std::vector<std::string> scenes = deformingScenes();
    std::vector<int> triangles{20'000};
    int steps = 2;
    int passes = 3;
    int sample = 20'000;
    double tolerance = 1e-6;
    std::string queries{};
};

/// Of several calls the median, processor time of this thread in ms.
double medianMilliseconds(int passes, const std::function<void()>& call)
{
    std::vector<double> times;
    for (int i = 0; i < passes; ++i)
    {
        times.push_back(1e-3 * microsecondsOf(call));
    }
    return medianOf(times);
}

/// What a query takes in the mean, the dearest included. False if one is missed that touches.
bool timeQueries(const Arguments& arguments)
{
    std::vector<ElementaryPair> pairs;
    std::size_t missed = 0;
    const ElementaryOptions options{.tolerance = arguments.tolerance};
    for (const std::filesystem::path& file : tools::elementaryFiles(arguments.queries))
    {
        for (const tools::ElementaryQuery& query : tools::readElementaryFile(file, {}))
        {
            pairs.push_back(query.pair);
            missed +=
                query.touches == true && !isContact(elementaryToi(query.pair, options).status);
        }
    }
    const auto mean = [&](int passes, const auto& toi)
    {
        const auto all = [&]
        { std::ranges::for_each(pairs, [&](const auto& p) { keep(toi(p)); }); };
        return 1e3 * medianMilliseconds(passes, all) / static_cast<double>(pairs.size());
    };
    const double ours = mean(9, [&](const auto& p) { return elementaryToi(p, options).time; });
    const double y1 = mean(1, [&](const auto& p) { return bisectionToi(p, options.tolerance); });
    const double y2 = mean(1, [&](const auto& p) { return advancementToi(p, options.tolerance); });
    fmt::print("{} queries, {} missed; us in the mean: ours {:.3f}", pairs.size(), missed, ours);
    fmt::print(", Y1 {:.1f} ({:.0f} x), Y2 {:.2f} ({:.1f} x)\n", y1, y1 / ours, y2, y2 / ours);
    return missed == 0;
}

/// Time of a plain method over all candidates of the frame; the pairs are a sample of them.
struct PlainTime
{
    double milliseconds = 0.0;
    std::int64_t missed = 0;  ///< pairs that touch, by the exact decision, and that we did not find
};

class SceneRun
{
public:
    SceneRun(std::string name, int triangles, const Arguments& arguments)
        : m_name(std::move(name)),
          m_arguments(arguments),
          m_scene(makeDeformingScene(m_name, triangles, arguments.steps))
    {
        m_buildMilliseconds = 1e-3 * microsecondsOf([&] { m_surface.emplace_back(m_scene.mesh); });
    }

    /// Returns whether no contact was missed and all ways gave the same answer.
    bool step(std::size_t step, const Table& table)
    {
        const std::vector<Eigen::Vector3d>& start = m_scene.frames[step];
        const std::vector<Eigen::Vector3d>& end = m_scene.frames[step + 1];
        DeformableSurface& surface = m_surface.front();
        const std::vector<DeformableBody> bodies{{.surface = &surface}};
        DeformableOptions options{.tolerance = m_arguments.tolerance};
        DeformableResult all;
        const double refit =
            medianMilliseconds(m_arguments.passes, [&] { surface.setStep(start, end); });
        const double query = medianMilliseconds(
            m_arguments.passes, [&] { all = deformableContacts(bodies, options, m_work); });
        DeformableResult first;
        const double firstOnly = medianMilliseconds(
            m_arguments.passes, [&] { first = deformableToi(bodies, options, m_work); });
        const double gain = twoThreadGain(bodies, all, first, start, end);
        std::vector<FeaturePair> candidates;
        double find = 0.0;
        if (m_arguments.sample > 0)
        {
            const UnionBoxes boxes(m_scene.mesh);
            find = medianMilliseconds(
                m_arguments.passes,
                [&] { candidates = boxes.overlapping(start, end, m_arguments.tolerance); });
        }
        const PlainTime bisection = plain(candidates, step, all, bisectionToi);
        const PlainTime advancement = plain(candidates, step, all, advancementToi);
        const double ours = refit + query;
        const auto triangles = static_cast<double>(m_scene.mesh.triangles.size());
        table.print({{"scene", m_name},
                     {"step", step},
                     {"triangles", m_scene.mesh.triangles.size()},
                     {"contacts", all.contacts.size()},
                     {"pairs", all.counters.featurePairs},
                     {"union pairs", candidates.size()},
                     {"build", m_buildMilliseconds},
                     {"refit", refit},
                     {"all", ours},
                     {"first", refit + firstOnly},
                     {"2 threads", gain},
                     {"us/triangle", 1e3 * ours / triangles},
                     {"us/contact", 1e3 * ours / std::max(1.0, double(all.contacts.size()))},
                     {"find", find},
                     {"Y1", bisection.milliseconds},
                     {"Y2", advancement.milliseconds},
                     {"Y1/all", (find + bisection.milliseconds) / ours},
                     {"Y2/all", (find + advancement.milliseconds) / ours},
                     {"bytes", double(surface.memory()) / triangles},
                     {"missed", bisection.missed + advancement.missed}});
        return m_isSame && bisection.missed + advancement.missed == 0;
    }

private:
    /// How many times faster two threads are, by the best wall times of refit and query, which have
    /// least of what else the machine does; also checks that they give the same contacts.
    double twoThreadGain(const std::vector<DeformableBody>& bodies,
                         const DeformableResult& all,
                         const DeformableResult& first,
                         const std::vector<Eigen::Vector3d>& start,
                         const std::vector<Eigen::Vector3d>& end)
    {
        std::array<std::vector<double>, 2> times;
        DeformableResult result;
        for (int i = 0; i < m_arguments.passes; ++i)
        {
            for (const int threads : {1, 2})
            {
                const DeformableOptions options{.tolerance = m_arguments.tolerance,
                                                .threads = threads};
                const auto refitAndSearch = [&]
                {
                    m_surface.front().setStep(start, end, threads);
                    result = deformableContacts(bodies, options, m_work);
                };
                times[std::size_t(threads - 1)].push_back(wallMicrosecondsOf(refitAndSearch));
            }
        }
        const auto isSame = [](const DeformableContact& a, const DeformableContact& b)
        { return a.time == b.time && a.kind == b.kind && a.vertices == b.vertices; };
        m_isSame = m_isSame && std::ranges::equal(all.contacts, result.contacts, isSame) &&
                   first.time == all.time;
        return std::ranges::min(times[0]) / std::ranges::min(times[1]);
    }

    /// Every n-th candidate by a plain method, its time for all of them.
    PlainTime plain(const std::vector<FeaturePair>& candidates,
                    std::size_t step,
                    const DeformableResult& all,
                    double (*toi)(const ElementaryPair& pair, double tolerance))
    {
        std::set<std::pair<ElementaryKind, std::array<std::int32_t, 4>>> found;
        for (const DeformableContact& contact : all.contacts)
        {
            found.emplace(contact.kind, contact.vertices);
        }
        const std::size_t stride = std::max<std::size_t>(
            1, candidates.size() / static_cast<std::size_t>(std::max(1, m_arguments.sample)));
        std::vector<FeaturePair> some;
        for (std::size_t i = 0; i < candidates.size(); i += stride)
        {
            some.push_back(candidates[i]);
        }
        const auto pair = [&](const FeaturePair& features)
        { return pairOf(features, m_scene.frames[step], m_scene.frames[step + 1]); };
        const auto isFree = [&](const FeaturePair& features)
        { return toi(pair(features), m_arguments.tolerance) > 1.0; };
        const ElementaryOptions exact{.depth = ElementaryDepth::Exact};
        const auto isMissed = [&](const FeaturePair& features)
        {
            return !found.contains({features.kind, features.vertices}) &&
                   isContact(elementaryToi(pair(features), exact).status);
        };
        const double spent = 1e-3 * microsecondsOf([&] { std::erase_if(some, isFree); });
        return {double(stride) * spent, std::ranges::count_if(some, isMissed)};
    }

    std::string m_name;
    const Arguments& m_arguments;
    DeformingScene m_scene;
    std::vector<DeformableSurface> m_surface;
    DeformableWorkspace m_work;
    double m_buildMilliseconds = 0.0;
    bool m_isSame = true;
};

bool run(const Arguments& arguments)
{
    fmt::print(
        "kernels: {}; tolerance {}; ms of processor time on one core, medians of {} passes; "
        "Y1 is bisection, Y2 advancement on the pairs of boxes over the step (every n-th, at most "
        "about {}); the plain methods are 'find', which finds those pairs, and one of them\n",
        surfaceKernels().level,
        arguments.tolerance,
        arguments.passes,
        arguments.sample);
    const Table table(
        "scene:<9|step:>4|triangles:>9|contacts:>8|pairs:>9|union pairs:>11|build:>7.1f|"
        "refit:>6.2f|all:>7.2f|first:>7.2f|2 threads:>9.2f|us/triangle:>11.3f|us/contact:>10.2f|"
        "find:>7.1f|Y1:>8.1f|Y2:>8.1f|Y1/all:>7.1f|Y2/all:>6.1f|bytes:>6.0f|missed:>6");
    bool isRight = true;
    for (const std::string& name : arguments.scenes)
    {
        for (const int triangles : arguments.triangles)
        {
            SceneRun scene(name, triangles, arguments);
            for (int step = 0; step < arguments.steps; ++step)
            {
                isRight = scene.step(static_cast<std::size_t>(step), table) && isRight;
            }
        }
    }
    fmt::print("{}\n",
               isRight ? "No contact is missing, and all ways agree."
                       : "WRONG: a contact is missing, or two ways differ.");
    return isRight;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    Arguments arguments;
    return runProgram(
        argc,
        argv,
        {.name = "bench_deformable",
         .about = "Contacts of deforming meshes in a step, beside plain methods.",
         .options =
             {{"--scenes", &arguments.scenes, "breaking, falling, layers; default: all"},
              {"-n,--triangles", &arguments.triangles, "about how many a scene has; several", 100},
              {"--steps", &arguments.steps, "of each scene"},
              {"--passes", &arguments.passes, "of which the median is shown"},
              {"--sample", &arguments.sample, "pairs that the plain methods are asked", 0},
              {"--tolerance", &arguments.tolerance, "of all methods"},
              {"--queries", &arguments.queries, "a folder of elementary queries, asked instead"}},
         .run = [&]
         { return arguments.queries.empty() ? run(arguments) : timeQueries(arguments); }});
}
