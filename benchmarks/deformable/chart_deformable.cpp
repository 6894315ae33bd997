// Points of the deformable chart as JSON; benchmarks/run chart runs this program and draws them.
#include "benchmarks/peers/bullet_peer.h"
#include "benchmarks/peers/fcl_peer.h"
#include "benchmarks/reference/oracles/plain_features.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/support/chart.h"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;

constexpr double kTruthTolerance = 1e-10;
constexpr double kClear = 1e-3;  ///< what stays farther apart is no contact for anybody

/// By advancement: a time that is not late, and that is early by no more than the way from the
/// tolerance to the contact takes; of misses whether they are clear.
ChartTruth truthOf(const std::vector<ElementaryPair>& pairs)
{
    ChartTruth truth{.time = 2.0, .slack = 1e-8, .clearance = kClear};
    for (const ElementaryPair& pair : pairs)
    {
        truth.time = std::min(truth.time, advancementToi(pair, kTruthTolerance));
        truth.clearance = advancementToi(pair, kClear) <= 1.0 ? 0.0 : truth.clearance;
    }
    truth.hit = truth.time <= 1.0;
    return truth;
}

/// A call is too short for the clock.
ChartMethod repeated(const std::string& name,
                     const SharedTruths& truths,
                     const std::vector<ToiSetting>& settings,
                     int times,
                     const std::function<ChartAnswer(std::size_t, double)>& answer)
{
    ChartMethod method{.name = name, .settings = {}};
    for (const ToiSetting& setting : settings)
    {
        const auto one = [=, value = setting.value](std::size_t i)
        {
            ChartAnswer result;
            const double micros = microsecondsOf(
                [&]
                {
                    for (int k = 0; k < times; ++k)
                    {
                        result = answer(i, value);
                    }
                });
            result.micros = micros / times;
            return result;
        };
        method.settings.push_back(toiSetting(
            setting.label, setting.reach, truths, [=] { return askAll(truths->size(), 3, one); }));
    }
    return method;
}

/// Vertices anywhere in a cube, at both ends. Every third pair stays in a plane, every other third
/// moves nearly as one: there the cubic equation of coplanarity vanishes or is nearly constant.
std::vector<ElementaryPair> featurePairs(ElementaryKind kind, int count)
{
    Random random(310);
    std::vector<ElementaryPair> pairs;
    for (int i = 0; i < count; ++i)
    {
        ElementaryPair& pair = pairs.emplace_back(ElementaryPair{.kind = kind});
        const Eigen::Vector3d common = random.inBox(1.0);
        for (std::size_t k = 0; k < 4; ++k)
        {
            pair.start[k] = random.inBox(1.0);
            pair.end[k] =
                i % 3 == 2 ? pair.start[k] + common + random.inBox(0.2) : random.inBox(1.0);
            if (i % 3 == 1)
            {
                pair.start[k].z() = pair.end[k].z() = 0.25;
            }
        }
    }
    return pairs;
}

ChartScene featureScene(const std::string& name, ElementaryKind kind, int count)
{
    const auto pairs =
        std::make_shared<const std::vector<ElementaryPair>>(featurePairs(kind, count));
    std::vector<ChartTruth> known;
    for (const ElementaryPair& pair : *pairs)
    {
        known.push_back(truthOf({pair}));
    }
    const auto truths = std::make_shared<const std::vector<ChartTruth>>(std::move(known));
    ChartScene scene{
        .name = name, .title = fmt::format("{} pairs: {}", count, name), .methods = {}};
    using Depth = std::pair<std::string, ElementaryDepth>;
    for (const auto& [depth, value] : {Depth{"ours", ElementaryDepth::Tolerance},
                                       Depth{"ours, decide", ElementaryDepth::Decide},
                                       Depth{"ours, exact", ElementaryDepth::Exact}})
    {
        const auto ours = [pairs, value = value](std::size_t i, double tolerance) -> ChartAnswer
        {
            const ElementaryResult result =
                elementaryToi((*pairs)[i], {.tolerance = tolerance, .depth = value});
            return {.hit = isContact(result.status), .time = result.time};
        };
        const bool stops = value == ElementaryDepth::Tolerance;  // the others go on below it
        scene.methods.push_back(
            repeated(depth, truths, stops ? tolerances(2, 9) : tolerances(6, 6), 20, ours));
    }
    const auto plain = [&](const std::string& method, int finest, auto toi)
    {
        const auto answer = [pairs, toi](std::size_t i, double tolerance) -> ChartAnswer
        {
            const double time = toi((*pairs)[i], tolerance);
            return {.hit = time <= 1.0, .time = time};
        };
        scene.methods.push_back(repeated(method, truths, tolerances(1, finest), 1, answer));
    };
    plain("bisection (Y1)", 5, bisectionToi);
    plain("advancement (Y2)", 7, advancementToi);
    const auto cubic = [pairs](std::size_t i, double /*unused*/) -> ChartAnswer
    {
        const FclAnswer answer = fclFeatures((*pairs)[i]);
        return {.hit = answer.hit, .time = answer.time};
    };
    scene.methods.push_back(repeated("FCL cubic", truths, {{.label = "default"}}, 20, cubic));
    if (kind == ElementaryKind::VertexFace)
    {
        const auto bullet = [pairs](std::size_t i, double /*unused*/) -> ChartAnswer
        {
            const BulletAnswer answer = bulletVertexFace((*pairs)[i]);
            return {.hit = answer.hit, .time = answer.time};
        };
        scene.methods.push_back(
            repeated("Bullet node and face", truths, {{.label = "halved"}}, 1, bullet));
    }
    return scene;
}

/// A cloth of n * n squares with bumps that sinks towards a sphere, and both as one mesh.
struct Drape
{
    TriangleMesh sphere = makeSphere(0.6, 3);
    TriangleMesh cloth;
    std::vector<Eigen::Vector3d> end;
    std::vector<ElementaryPair> pairs;  ///< of the two, whose boxes over the step overlap

    Drape(Random& random, int n)
    {
        const double sinks = random.uniform(0.0, 0.2);
        const double waves = random.uniform(5.0, 20.0);
        for (int v = 0; v < (n + 1) * (n + 1); ++v)
        {
            const double x = 2.0 * (v % (n + 1)) / n - 1.0;
            const double y = 2.0 * (v / (n + 1)) / n - 1.0;
            cloth.vertices.emplace_back(
                x, y, 0.65 + 0.03 * std::sin(waves * x) * std::cos(waves * y));
            end.push_back(cloth.vertices.back() -
                          Eigen::Vector3d(0.0, 0.0, sinks + random.uniform(0.0, 0.03)));
        }
        for (int i = 0; i < n * n; ++i)
        {
            const int a = i % n + (n + 1) * (i / n);
            cloth.triangles.push_back({a, a + 1, a + n + 1});
            cloth.triangles.push_back({a + 1, a + n + 2, a + n + 1});
        }
        TriangleMesh both = sphere;
        appendMesh(both, cloth);
        std::vector<Eigen::Vector3d> ends = sphere.vertices;
        ends.insert(ends.end(), end.begin(), end.end());
        const auto isOfCloth = [&](std::int32_t v)
        { return v >= std::int32_t(sphere.vertices.size()); };
        for (const FeaturePair& features : UnionBoxes(both).overlapping(both.vertices, ends, 0.1))
        {
            if (isOfCloth(features.vertices[0]) != isOfCloth(features.vertices[3]))
            {
                pairs.push_back(pairOf(features, both.vertices, ends));
            }
        }
    }
};

ChartScene drapeScene(int count, int n)
{
    Random random(311);
    const auto drapes = std::make_shared<std::vector<Drape>>();
    std::vector<ChartTruth> known;
    for (int i = 0; i < count; ++i)
    {
        drapes->emplace_back(random, n);
        known.push_back(truthOf(drapes->back().pairs));
    }
    const auto truths = std::make_shared<const std::vector<ChartTruth>>(std::move(known));
    const Drape& any = drapes->front();
    ChartScene scene{.name = "drape",
                     .title = fmt::format("a cloth of {} triangles sinks onto a sphere of {}",
                                          any.cloth.triangles.size(),
                                          any.sphere.triangles.size()),
                     .methods = {}};
    const auto surfaces = std::make_shared<std::vector<DeformableSurface>>();
    const auto peers = std::make_shared<std::vector<FclSurface>>();
    for (const TriangleMesh* mesh : {&any.sphere, &any.cloth})
    {
        surfaces->emplace_back(*mesh);
        peers->emplace_back(*mesh);
    }
    peers->front().setEnd(any.sphere.vertices);
    const auto ours = [=, work = std::make_shared<DeformableWorkspace>()](
                          std::size_t i, double tolerance) -> ChartAnswer
    {
        const Drape& drape = (*drapes)[i];
        surfaces->back().setStep(drape.cloth.vertices, drape.end);
        const std::vector<DeformableBody> bodies{
            {.surface = &surfaces->front(), .selfCollision = false},
            {.surface = &surfaces->back(), .selfCollision = false}};
        const DeformableResult result = deformableToi(bodies, {.tolerance = tolerance}, *work);
        return {.hit = isContact(result.status), .time = result.time};
    };
    scene.methods.push_back(toiMethod("ours", truths, tolerances(2, 9), ours, 3));
    const auto plain = [=](std::size_t i, double tolerance) -> ChartAnswer
    {
        double time = 2.0;
        for (const ElementaryPair& pair : (*drapes)[i].pairs)
        {
            time = std::min(time, advancementToi(pair, tolerance));
        }
        return {.hit = time <= 1.0, .time = time};
    };
    scene.methods.push_back(toiMethod("advancement (Y2)", truths, tolerances(2, 6), plain));
    const auto peer = [=](std::size_t i, double /*unused*/) -> ChartAnswer
    {
        peers->back().setEnd((*drapes)[i].cloth.vertices);
        peers->back().setEnd((*drapes)[i].end);
        const FclAnswer answer = fclSurfaces(peers->front(), peers->back());
        return {.hit = answer.hit, .time = answer.time};
    };
    scene.methods.push_back(
        toiMethod("FCL deforming meshes", truths, {{.label = "default"}}, peer));
    return scene;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    ChartFamily family = toiFamily("deformable", "Time of contact of what deforms");
    family.peers = {fclVersion(), "Bullet"};
    return runChart(
        argc,
        argv,
        {.family = family,
         .scenes = {"vertex and face", "two edges", "drape"},
         .makeScene = [](const std::string& scene, const ChartOptions& options)
         {
             const int count = options.quick ? 90 : 900;
             return scene == "drape" ? drapeScene(count / 45, options.quick ? 12 : 24)
                    : scene == "two edges"
                        ? featureScene(scene, bullet_ccd::ElementaryKind::EdgeEdge, count)
                        : featureScene(scene, bullet_ccd::ElementaryKind::VertexFace, count);
         }});
}
