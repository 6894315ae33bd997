#include "benchmarks/articulated/linkage_run.h"

#include "benchmarks/support/counters.h"
#include "benchmarks/support/timing.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;

constexpr double kTolerance = 1e-5;  ///< [m]

BoundingBall ballOf(const TriangleMesh& mesh)
{
    BoundingBall ball{.center = bounds(mesh).center(), .radius = 0.0};
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        ball.radius = std::max(ball.radius, (vertex - ball.center).norm());
    }
    return ball;
}

double fastestJoint(const LinkageQuery& query)
{
    double fastest = 0.0;
    for (const double rate : query.motion.rates)
    {
        fastest = std::max(fastest, std::abs(rate));
    }
    return fastest;
}

std::vector<RigidBody> obstaclesOf(const LinkageQuery& query)
{
    if (query.object == nullptr)
    {
        return {};
    }
    return {{.tree = &query.object->tree, .motion = restAt(query.X_WO)}};
}
}  // namespace

LinkageObject::LinkageObject(const TriangleMesh& mesh)
    : tree(buildSsvTree(mesh)), model(mesh), ball(ballOf(mesh))
{
}

Linkage::Linkage(const KinematicTree& tree,
                 std::span<const SsvTree* const> linkTrees,
                 std::span<const std::pair<std::int32_t, std::int32_t>> selfPairs)
    : m_tree(tree), m_linkTrees(linkTrees), m_selfPairs(selfPairs)
{
    for (const SsvTree* link : linkTrees)
    {
        const bool hasGeometry = link != nullptr;
        m_modelOfLink.push_back(hasGeometry ? static_cast<std::int32_t>(m_models.size()) : kNone);
        m_balls.push_back(hasGeometry ? ballOf(link->mesh()) : BoundingBall{});
        if (hasGeometry)
        {
            m_models.emplace_back(link->mesh());
        }
    }
}

/// kNone is the object.
const FclModel& Linkage::modelOf(const LinkageQuery& query, std::int32_t link) const
{
    if (link == kNone)
    {
        return query.object->model;
    }
    return m_models[static_cast<std::size_t>(m_modelOfLink[static_cast<std::size_t>(link)])];
}

ArticulatedBody Linkage::body(const LinkageQuery& query) const
{
    return {.tree = &m_tree,
            .linkTrees = m_linkTrees,
            .motion = &query.motion,
            .selfPairs = m_selfPairs};
}

/// Pairs of links, and of links and the object (kNone).
Linkage::Pairs Linkage::pairsOf(const LinkageQuery& query, bool movingOnly) const
{
    Pairs pairs;
    for (std::size_t i = 0; query.object != nullptr && i < m_linkTrees.size(); ++i)
    {
        const auto link = static_cast<std::int32_t>(i);
        if (m_linkTrees[i] != nullptr && (!movingOnly || moves(m_tree, query.motion, kNone, link)))
        {
            pairs.emplace_back(link, kNone);
        }
    }
    for (const auto& [a, b] : m_selfPairs)
    {
        const std::int32_t common = commonAncestor(m_tree, a, b);
        if (moves(m_tree, query.motion, common, a) || moves(m_tree, query.motion, common, b))
        {
            pairs.emplace_back(a, b);
        }
    }
    return pairs;
}

SweepHit Linkage::overlapAt(const LinkageQuery& query, const Pairs& pairs, double t) const
{
    std::vector<double> positions = query.motion.positions;
    for (std::size_t i = 0; i < positions.size(); ++i)
    {
        positions[i] += t * query.motion.rates[i];
    }
    const std::vector<Isometry3d> X_WL = linkPoses(m_tree, query.motion.root.at(t).X_W, positions);
    for (const auto& [a, b] : pairs)
    {
        const auto indexA = static_cast<std::size_t>(a);
        const auto indexB = static_cast<std::size_t>(b);
        const Isometry3d& X_WB = b == kNone ? query.X_WO : X_WL[indexB];
        const BoundingBall& ballA = m_balls[indexA];
        const BoundingBall& ballB = b == kNone ? query.object->ball : m_balls[indexB];
        const double apart = (X_WL[indexA] * ballA.center - X_WB * ballB.center).norm();
        if (apart <= (ballA.radius + ballB.radius) * (1.0 + 1e-9) &&
            fclOverlap(modelOf(query, a), X_WL[indexA], modelOf(query, b), X_WB))
        {
            return {.found = true, .time = t, .link = a, .otherLink = b};
        }
    }
    return {};
}

bool Linkage::isFree(const LinkageQuery& query, double t) const
{
    return !overlapAt(query, pairsOf(query, false), t).found;
}

SweepHit Linkage::sweep(const LinkageQuery& query, double step) const
{
    const Pairs pairs = pairsOf(query, true);
    const int steps = std::max(1, static_cast<int>(std::ceil(fastestJoint(query) / step)));
    for (int i = 0; i <= steps; ++i)
    {
        const SweepHit hit = overlapAt(query, pairs, static_cast<double>(i) / steps);
        if (hit.found)
        {
            return hit;
        }
    }
    return {};
}

/// FCL's distance says that the two are within the tolerance, its overlap test that they do not
/// intersect. (Its distance of some triangles less than a micrometre apart is 0.)
bool Linkage::isContactAt(const LinkageQuery& query, const LinkContact& contact) const
{
    const auto placed = [&](std::int32_t link)
    { return restAt(linkStateAt(m_tree, query.motion, kNone, link, contact.time).X_W); };
    const std::int32_t other = contact.otherLink;
    const RigidMotion motion = placed(contact.link);
    const RigidMotion ofOther = other == kNone ? restAt(query.X_WO) : placed(other);
    const FclBody a{.model = modelOf(query, contact.link), .motion = motion};
    const FclBody b{.model = modelOf(query, other), .motion = ofOther};
    constexpr double kRounding = 1e-9;  // FCL's
    return !fclOverlap(a, b, 0.0) && fclDistance(a, b, 0.0) <= kTolerance + kRounding;
}

void Linkage::compare(const LinkageQuery& query,
                      const ArticulatedToiResult& result,
                      LinkageTally& tally) const
{
    SweepHit sample;
    tally.sweepMicros += microsecondsOf([&] { sample = sweep(query, kSweepStep); });
    ++tally.queries;
    tally.counters += result.counters;
    if (result.status != ToiStatus::Hit)
    {
        tally.late += sample.found || result.status != ToiStatus::Separated ? 1 : 0;
        return;
    }
    ++tally.hits;
    const LinkContact& contact = result.contacts.at(0);
    tally.selfHits += contact.otherLink != kNone ? 1 : 0;
    tally.notThere += isContactAt(query, contact) ? 0 : 1;
    if (!sample.found)
    {
        ++tally.betweenSteps;
        return;
    }
    tally.late += result.time > sample.time ? 1 : 0;
    const double lag = (sample.time - result.time) * fastestJoint(query);
    if (lag > 2.0 * kSweepStep)
    {
        ++tally.betweenSteps;
        return;
    }
    tally.worstLag = std::max(tally.worstLag, lag);
    const bool isSame =
        std::any_of(result.contacts.begin(),
                    result.contacts.end(),
                    [&](const LinkContact& c)
                    { return c.link == sample.link && c.otherLink == sample.otherLink; });
    tally.samePair += isSame ? 1 : 0;
}

LinkageTally Linkage::run(std::span<const LinkageQuery> queries, int repeats) const
{
    const ArticulatedToiOptions options{.toi = {.tolerance = kTolerance}};
    ToiWorkspace work;
    LinkageTally tally;
    std::vector<Environment> environments;
    for (const LinkageQuery& query : queries)
    {
        environments.emplace_back(obstaclesOf(query));
        const ArticulatedToiResult result =
            articulatedToi(body(query), environments.back(), options, work);
        compare(query, result, tally);
    }
    const auto ask = [&](std::size_t i)
    { keep(articulatedToi(body(queries[i]), environments[i], options, work).time); };
    const TimedMethod timed{.queries = queries.size(), .passes = repeats, .ask = ask};
    tally.micros = meanOf(timeInTurns(std::span(&timed, 1)).at(0));
    tally.sweepMicros /= std::max(1, tally.queries);
    return tally;
}

Table linkageTable()
{
    return Table(
        fmt::format("robot:<18|queries:>7|hits:>5|self:>5|late:>5|wrong:>5|same:>6|between:>7|"
                    "lag rad=lag:>7.5f|us:>9.0f|sweep ms=sweep:>9.1f|{}",
                    kCounterColumns));
}

void printLinkage(const Table& table, const std::string& robot, const LinkageTally& tally)
{
    nlohmann::json row = rowOf(tally.counters, tally.queries);
    row.update({{"robot", robot},
                {"queries", tally.queries},
                {"hits", tally.hits},
                {"self", tally.selfHits},
                {"late", tally.late},
                {"wrong", tally.notThere},
                {"same", tally.samePair},
                {"between", tally.betweenSteps},
                {"lag", tally.worstLag},
                {"us", tally.micros},
                {"sweep", 1e-3 * tally.sweepMicros}});
    table.print(row);
}

bool isRight(const LinkageTally& tally)
{
    return tally.late == 0 && tally.notThere == 0;
}
}  // namespace bullet_ccd::benchmarks
