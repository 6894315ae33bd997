#include "bullet_ccd/toi/first_contact.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/toi/pair_step.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A gap is believed less this fraction of the coordinates it was computed from (64 roundings).
constexpr double kRounding = 64.0 * 1.11e-16;

/// A pair of nodes, certified to be apart before `time`.
struct Entry
{
    double time;
    std::int32_t pair;
    std::int32_t nodeA;
    std::int32_t nodeB;
    bool advance;  ///< look at the same nodes again at `time` rather than at their children

    /// Total order, so that the answer depends on nothing but the query.
    [[nodiscard]] bool operator>(const Entry& other) const
    {
        return std::tie(time, pair, nodeA, nodeB) >
               std::tie(other.time, other.pair, other.nodeA, other.nodeB);
    }
};

/// Motion of one tree's frame, seen from the frame of the query.
struct TreeState
{
    Isometry3d X;
    Vector3d v;  ///< velocity of the tree's origin
    Vector3d w;
};
Isometry3d treeInBody(const MovingBody& body)
{
    Isometry3d X = body.X_BG;
    X.translation() = body.X_BG * body.tree->origin();
    return X;
}

/// State in W of a body that is not a link.
MotionState freeStateAt(const MovingBody& body, double t)
{
    if (const auto* user = std::get_if<const UserMotion*>(&body.motion))
    {
        return (*user)->at(t);
    }
    return std::get<RigidMotion>(body.motion).at(t);
}

TreeState treeStateAt(const MovingBody& body, std::int32_t base, double t)
{
    MotionState s;
    if (const auto* link = std::get_if<LinkMotion>(&body.motion))
    {
        s = linkStateAt(*link->tree, *link->motion, base, link->link, t);
    }
    else
    {
        s = freeStateAt(body, t);
    }
    const Isometry3d X = s.X_W * treeInBody(body);
    return {.X = X, .v = s.v_W + s.w_W.cross(X.translation() - s.X_W.translation()), .w = s.w_W};
}

AccelerationBound accelerationOf(const MovingBody& body, std::int32_t base)
{
    if (const auto* link = std::get_if<LinkMotion>(&body.motion))
    {
        return linkAccelerationBound(*link->tree, *link->motion, base, link->link);
    }
    if (const auto* user = std::get_if<const UserMotion*>(&body.motion))
    {
        return (*user)->accelerationBound();
    }
    return std::get<RigidMotion>(body.motion).accelerationBound();
}

/// Links of one tree are compared in the frame of their common ancestor, all else in W.
std::int32_t frameOf(const MovingBody& a, const MovingBody& b)
{
    const auto* linkA = std::get_if<LinkMotion>(&a.motion);
    const auto* linkB = std::get_if<LinkMotion>(&b.motion);
    const bool oneTree = linkA != nullptr && linkB != nullptr && linkA->motion == linkB->motion;
    return oneTree ? commonAncestor(*linkA->tree, linkA->link, linkB->link) : kNone;
}

/// Bodies of the query, the pairs, and the state of the pair last looked at.
class Scene
{
public:
    Scene(std::span<const MovingBody> bodies,
          std::span<const BodyPair> pairs,
          double tolerance,
          std::vector<PairConstants>& constants)
        : m_bodies(bodies), m_pairs(pairs), m_constants(constants)
    {
        m_constants.clear();
        for (const BodyPair& pair : pairs)
        {
            const MovingBody& a = bodyA(pair);
            const MovingBody& b = bodyB(pair);
            PairConstants c{.treeA = a.tree, .treeB = b.tree, .base = frameOf(a, b)};
            c.accelerationA = accelerationOf(a, c.base);
            c.accelerationB = accelerationOf(b, c.base);
            c.offsetA = a.X_BG.linear().transpose() * treeInBody(a).translation();
            c.offsetB = b.X_BG.linear().transpose() * treeInBody(b).translation();
            c.threshold = tolerance;
            m_constants.push_back(c);
        }
    }

    [[nodiscard]] PairConstants& constants(std::int32_t pair)
    {
        return m_constants[static_cast<std::size_t>(pair)];
    }

    [[nodiscard]] const PairState& stateAt(std::int32_t pair, double t, ToiCounters& counters)
    {
        if (m_state.pair != pair || m_state.time != t)
        {
            ++counters.states;
            m_state = compute(pair, t);
        }
        return m_state;
    }

    [[nodiscard]] Isometry3d worldOfB(std::int32_t pair, double t) const
    {
        return treeStateAt(bodyB(m_pairs[static_cast<std::size_t>(pair)]), kNone, t).X;
    }

private:
    [[nodiscard]] const MovingBody& bodyA(const BodyPair& pair) const
    {
        return m_bodies[static_cast<std::size_t>(pair.bodyA)];
    }
    [[nodiscard]] const MovingBody& bodyB(const BodyPair& pair) const
    {
        return m_bodies[static_cast<std::size_t>(pair.bodyB)];
    }

    [[nodiscard]] PairState compute(std::int32_t index, double t)
    {
        const BodyPair& pair = m_pairs[static_cast<std::size_t>(index)];
        const PairConstants& c = constants(index);
        const TreeState a = treeStateAt(bodyA(pair), c.base, t);
        const TreeState b = treeStateAt(bodyB(pair), c.base, t);
        const Matrix3d toB = b.X.linear().transpose();
        PairState state{.pair = index, .time = t};
        state.R = toB * a.X.linear();
        state.p = toB * (a.X.translation() - b.X.translation());
        state.vA = toB * a.v;
        state.wA = toB * a.w;
        state.vB = toB * b.v;
        state.wB = toB * b.w;
        state.spinA = a.w.norm();
        state.spinB = b.w.norm();
        state.rounding =
            kRounding * (a.X.translation().norm() + b.X.translation().norm() + c.treeA->radius() +
                         c.treeB->radius() + c.treeA->origin().norm() + c.treeB->origin().norm());
        return state;
    }

    std::span<const MovingBody> m_bodies;
    std::span<const BodyPair> m_pairs;
    std::vector<PairConstants>& m_constants;
    PairState m_state;
};

/// Time reached by a step, rounded down.
double reached(double t, double step)
{
    return std::nextafter(t + step * (1.0 - 1e-15), 0.0);
}
}  // namespace

struct ToiWorkspace::Scratch
{
    std::vector<Entry> heap;
    std::vector<PairConstants> constants;
};

ToiWorkspace::ToiWorkspace() : m_scratch(std::make_unique<Scratch>()) {}
ToiWorkspace::~ToiWorkspace() = default;
ToiWorkspace::ToiWorkspace(ToiWorkspace&&) noexcept = default;
ToiWorkspace& ToiWorkspace::operator=(ToiWorkspace&&) noexcept = default;

namespace
{
/// The loop. Invariant: every pair of triangles that could touch before 1 is below an entry of the
/// heap whose time is a lower bound of its contact. It ends because every entry popped either goes
/// down one level of a finite tree or moves ahead by a step that is bounded below by half of the
/// tolerance over the largest speed.
class Search
{
public:
    Search(Scene& scene, std::vector<Entry>& heap, const ToiOptions& options)
        : m_scene(scene), m_heap(heap), m_options(options)
    {
        m_heap.clear();
    }

    FirstContactResult run(std::size_t pairs)
    {
        for (std::size_t i = 0; i < pairs; ++i)
        {
            examine(static_cast<std::int32_t>(i), 0, 0, 0.0);
        }
        while (!m_heap.empty() && !m_done)
        {
            const Entry entry = pop();
            if (m_result.counters.nodePairs + m_result.counters.trianglePairs >
                m_options.maxIterations)
            {
                m_result.status = ToiStatus::IterationLimit;
                m_result.time = entry.time;
                m_result.pair = entry.pair;
                return m_result;
            }
            visit(entry);
        }
        return m_result;
    }

private:
    void push(const Entry& entry)
    {
        m_heap.push_back(entry);
        std::push_heap(m_heap.begin(), m_heap.end(), std::greater<>());
    }

    Entry pop()
    {
        std::pop_heap(m_heap.begin(), m_heap.end(), std::greater<>());
        const Entry entry = m_heap.back();
        m_heap.pop_back();
        return entry;
    }

    /// Bounds a pair of nodes at time t and queues it, unless it cannot touch before 1.
    void examine(std::int32_t pair, std::int32_t nodeA, std::int32_t nodeB, double t)
    {
        ++m_result.counters.nodePairs;
        const PairConstants& c = m_scene.constants(pair);
        const PairState& state = m_scene.stateAt(pair, t, m_result.counters);
        const SsvNode& a = c.treeA->nodes()[static_cast<std::size_t>(nodeA)];
        const SsvNode& b = c.treeB->nodes()[static_cast<std::size_t>(nodeB)];
        const Step step = nodeStep(c, state, a, b);
        if (t + step.time > 1.0)
        {
            return;
        }
        // Far apart for their size: the same pair can be trusted for another step.
        constexpr double kFar = 0.7;
        const double size = static_cast<double>(std::max(a.coreRadius, b.coreRadius));
        const double next = std::max(t, reached(t, step.time));
        push({.time = next,
              .pair = pair,
              .nodeA = nodeA,
              .nodeB = nodeB,
              .advance = step.gap > kFar * size && next > t});
    }

    void visit(const Entry& entry)
    {
        const PairConstants& c = m_scene.constants(entry.pair);
        const SsvNode& a = c.treeA->nodes()[static_cast<std::size_t>(entry.nodeA)];
        const SsvNode& b = c.treeB->nodes()[static_cast<std::size_t>(entry.nodeB)];
        if (a.isLeaf() && b.isLeaf())
        {
            visitTriangles(entry, a.first, b.first);
        }
        else if (entry.advance)
        {
            examine(entry.pair, entry.nodeA, entry.nodeB, entry.time);
        }
        else if (b.isLeaf() || (!a.isLeaf() && a.coreRadius >= b.coreRadius))
        {
            for (std::int32_t k = 0; k < a.count; ++k)
            {
                examine(entry.pair, a.first + k, entry.nodeB, entry.time);
            }
        }
        else
        {
            for (std::int32_t k = 0; k < b.count; ++k)
            {
                examine(entry.pair, entry.nodeA, b.first + k, entry.time);
            }
        }
    }

    void visitTriangles(const Entry& entry, std::int32_t triangleA, std::int32_t triangleB)
    {
        ++m_result.counters.trianglePairs;
        PairConstants& c = m_scene.constants(entry.pair);
        const PairState& state = m_scene.stateAt(entry.pair, entry.time, m_result.counters);
        const TriangleStep step = triangleStep(c, state, triangleA, triangleB);
        if (entry.time == 0.0 && step.distance.distance <= c.threshold &&
            !startsClose(c, state, step.distance.distance))
        {
            push(entry);  // again, against the smaller threshold
            return;
        }
        const double next = reached(entry.time, step.time);
        if (step.distance.distance <= c.threshold || next <= entry.time)
        {
            finish(entry, step.distance, triangleA, triangleB);
        }
        else if (entry.time + step.time <= 1.0)
        {
            push({.time = next,
                  .pair = entry.pair,
                  .nodeA = entry.nodeA,
                  .nodeB = entry.nodeB,
                  .advance = true});
        }
    }

    /// The bodies are within the tolerance where the query begins: from now on they must close in
    /// further to count as in contact, so that they can separate or slide. Returns true if they
    /// touch already, so that there is nothing to be done.
    [[nodiscard]] bool startsClose(PairConstants& c, const PairState& state, double upperBound)
    {
        const double start = closestWithin(c, state, upperBound).distance;
        if (start <= 4.0 * state.rounding)
        {
            return true;
        }
        c.threshold = std::min(c.threshold, 0.75 * start);
        return false;
    }

    /// The closest triangles of the two meshes if they are closer than `upperBound`.
    [[nodiscard]] static TrianglePair closestWithin(const PairConstants& c,
                                                    const PairState& state,
                                                    double upperBound)
    {
        Isometry3d X_BA = Isometry3d::Identity();
        X_BA.linear() = state.R;
        X_BA.translation() = state.p + c.treeB->origin() - state.R * c.treeA->origin();
        return treeDistance(*c.treeA, *c.treeB, X_BA, upperBound);
    }

    /// The first triangles that came up within the tolerance need not be the closest at that time:
    /// those are what is reported.
    void finish(const Entry& entry,
                const TriangleDistance& d,
                std::int32_t triangleA,
                std::int32_t triangleB)
    {
        const PairConstants& c = m_scene.constants(entry.pair);
        TrianglePair closest = closestWithin(
            c, m_scene.stateAt(entry.pair, entry.time, m_result.counters), d.distance);
        if (closest.triangleA == kNone)
        {
            closest = {.triangleA = c.treeA->triangle(triangleA),
                       .triangleB = c.treeB->triangle(triangleB),
                       .distance = d.distance,
                       .pointA = d.pointA + c.treeB->origin(),
                       .pointB = d.pointB + c.treeB->origin()};
        }
        m_done = true;
        m_result.status = entry.time == 0.0 ? ToiStatus::Overlapping : ToiStatus::Hit;
        m_result.time = entry.time;
        m_result.gap = closest.distance;
        m_result.pair = entry.pair;
        m_result.triangleA = closest.triangleA;
        m_result.triangleB = closest.triangleB;
        const Isometry3d X_WB = m_scene.worldOfB(entry.pair, entry.time);
        m_result.pointA = X_WB * (closest.pointA - c.treeB->origin());
        m_result.pointB = X_WB * (closest.pointB - c.treeB->origin());
        if (closest.distance > 0.0)
        {
            m_result.normal = X_WB.linear() * (closest.pointB - closest.pointA).stableNormalized();
        }
    }

    Scene& m_scene;
    std::vector<Entry>& m_heap;
    const ToiOptions& m_options;
    FirstContactResult m_result;
    bool m_done = false;
};

bool isFinite(const MovingBody& body)
{
    const auto rigid = [](const RigidMotion& m)
    { return m.X_W0.matrix().allFinite() && m.v_W.allFinite() && m.w_W.allFinite(); };
    const auto all = [](const std::vector<double>& values) {
        return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
    };
    if (const auto* link = std::get_if<LinkMotion>(&body.motion))
    {
        return rigid(link->motion->root) && all(link->motion->positions) &&
               all(link->motion->rates);
    }
    const auto* free = std::get_if<RigidMotion>(&body.motion);
    return free == nullptr || (rigid(*free) && free->reference_B.allFinite());
}
}  // namespace

FirstContactResult firstContact(std::span<const MovingBody> bodies,
                                std::span<const BodyPair> pairs,
                                const ToiOptions& options,
                                ToiWorkspace& work)
{
    require(options.tolerance > 0.0 && std::isfinite(options.tolerance),
            "time of impact: the tolerance must be positive and finite");
    for (const MovingBody& body : bodies)
    {
        require(isFinite(body),
                "time of impact: a pose, velocity or joint position is NaN or infinite");
    }
    ToiWorkspace::Scratch& scratch = work.scratch();
    Scene scene(bodies, pairs, options.tolerance, scratch.constants);
    return Search(scene, scratch.heap, options).run(pairs.size());
}

Eigen::Isometry3d geometryPoseAt(const MovingBody& body, double t)
{
    if (const auto* link = std::get_if<LinkMotion>(&body.motion))
    {
        return linkStateAt(*link->tree, *link->motion, kNone, link->link, t).X_W * body.X_BG;
    }
    return freeStateAt(body, t).X_W * body.X_BG;
}
}  // namespace bullet_ccd
