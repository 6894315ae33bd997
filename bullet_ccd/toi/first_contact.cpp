#include "bullet_ccd/toi/first_contact.h"

#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/distance/triangle_distance.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

/// What stays the same for a pair of bodies during a query.
struct PairConstants
{
    const SsvTree* treeA = nullptr;
    const SsvTree* treeB = nullptr;
    std::int32_t base = kNone;  ///< link whose frame is the frame of the query
    AccelerationBound accelerationA{};
    AccelerationBound accelerationB{};
    Vector3d offsetA{};  ///< from the body's origin to the tree's, in the tree's axes
    Vector3d offsetB{};
    double threshold = 0.0;  ///< in contact at this distance
};

/// Relative state of a pair at one time; everything in the axes of B's tree.
struct PairState
{
    std::int32_t pair = kNone;
    double time = -1.0;
    Matrix3d R{};  ///< A's tree in B's
    Vector3d p{};
    Vector3d vA{}, wA{}, vB{}, wB{};  ///< velocities of the trees' origins, angular velocities
    double spinA = 0.0, spinB = 0.0;
    double rounding = 0.0;
};

Isometry3d treeInBody(const MovingBody& body)
{
    Isometry3d X = body.X_BG;
    X.translation() = body.X_BG * body.tree->origin();
    return X;
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
        s = std::get<RigidMotion>(body.motion).at(t);
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

/// Longest time in which a gap g > 0 cannot close, if it closes at speed a now and at an
/// acceleration of at most b: the root of a s + b s^2 / 2 = g.
double closingTime(double g, double a, double b)
{
    const double root = std::sqrt(a * a + 2.0 * b * g);
    if (a >= 0.0)
    {
        return a + root > 0.0 ? 2.0 * g / (a + root) : kInfinity;
    }
    // Moving apart: without cancellation for b > 0; never closes for b = 0.
    return b > 0.0 ? (root - a) / b : kInfinity;
}

/// What a step from one pose certifies.
struct Step
{
    double time = 0.0;  ///< no contact before it, counted from the pose
    double gap = -kInfinity;
};

/// Certified step of two volumes: the best over all separating axes. Speeds: that of the centres,
/// plus that of the core about its centre; the ball swept around the core does not feel rotation.
Step nodeStep(const PairConstants& c,
              const PairState& s,
              const SsvNode& nodeA,
              const SsvNode& nodeB)
{
    const PlacedSsv b = place(nodeB);
    PlacedSsv a = place(nodeA);
    const double reachA = (a.center + c.offsetA).norm() + a.coreRadius;
    const double reachB = (b.center + c.offsetB).norm() + b.coreRadius;
    const Vector3d armA = s.R * a.center;
    a.center = armA + s.p;
    a.axes = s.R * a.axes;

    const double acceleration = c.accelerationA.constant + c.accelerationB.constant +
                                c.accelerationA.perRadius * reachA +
                                c.accelerationB.perRadius * reachB;
    const double turning = s.spinA * a.coreRadius + s.spinB * b.coreRadius;
    const Vector3d closing = s.vA + s.wA.cross(armA) - s.vB - s.wB.cross(b.center);
    const Vector3d closingA = a.axes.transpose() * closing;
    const Vector3d closingB = b.axes.transpose() * closing;
    const double margin = 0.5 * c.threshold + s.rounding;

    Step step;
    forEachSeparatingAxis(a,
                          b,
                          [&](double gap, const auto& along)
                          {
                              step.gap = std::max(step.gap, gap);
                              if (gap > margin)
                              {
                                  const double speed = along(closingA, closingB) + turning;
                                  step.time = std::max(
                                      step.time, closingTime(gap - margin, speed, acceleration));
                              }
                              return s.time + step.time > 1.0;
                          });
    return step;
}

/// Two triangles at one pose: exact distance and the certified step.
struct TriangleStep
{
    TriangleDistance distance;
    double time = 0.0;
};

/// One corner: where it is, and its velocity and acceleration bound.
struct MovingCorner
{
    Vector3d point;
    Vector3d velocity;
    double acceleration;
};

/// Step along direction n (unit, from A to B): every pair of corners has its own gap and speed.
/// Also returns the smallest gap, the separation of the two triangles along n.
Step cornerStep(const std::array<MovingCorner, 3>& a,
                const std::array<MovingCorner, 3>& b,
                const Vector3d& n,
                double margin)
{
    Step step{.time = kInfinity, .gap = kInfinity};
    for (const MovingCorner& cornerA : a)
    {
        for (const MovingCorner& cornerB : b)
        {
            const double gap = n.dot(cornerB.point - cornerA.point);
            step.gap = std::min(step.gap, gap);
            if (gap <= margin)
            {
                step.time = 0.0;
                continue;
            }
            const double speed = n.dot(cornerA.velocity - cornerB.velocity);
            step.time = std::min(
                step.time,
                closingTime(gap - margin, speed, cornerA.acceleration + cornerB.acceleration));
        }
    }
    return step;
}

std::array<MovingCorner, 3> movingCorners(const TriangleCorners& corners,
                                          const Vector3d& offset,
                                          const AccelerationBound& bound,
                                          const Matrix3d& R,
                                          const Vector3d& p,
                                          const Vector3d& v,
                                          const Vector3d& w)
{
    std::array<MovingCorner, 3> moving;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const Vector3d arm = R * corners[k];
        moving[k].point = arm + p;
        moving[k].velocity = v + w.cross(arm);
        moving[k].acceleration = bound.constant + bound.perRadius * (corners[k] + offset).norm();
    }
    return moving;
}

/// Best step over all directions that can separate two triangles; the fallback where the closest
/// points are too close, or too badly conditioned, to give a direction.
Step separatingStep(const std::array<MovingCorner, 3>& a,
                    const std::array<MovingCorner, 3>& b,
                    double margin)
{
    Step best;
    const auto consider = [&](const Vector3d& direction)
    {
        const double length = direction.norm();
        if (!(length > 0.0))
        {
            return;
        }
        for (const double sign : {1.0, -1.0})
        {
            const Step step = cornerStep(a, b, (sign / length) * direction, margin);
            if (step.gap > best.gap)
            {
                best = step;
            }
        }
    };
    std::array<Vector3d, 3> edgesA;
    std::array<Vector3d, 3> edgesB;
    for (std::size_t k = 0; k < 3; ++k)
    {
        edgesA[k] = a[(k + 1) % 3].point - a[k].point;
        edgesB[k] = b[(k + 1) % 3].point - b[k].point;
    }
    consider(edgesA[0].cross(edgesA[1]));
    consider(edgesB[0].cross(edgesB[1]));
    for (const Vector3d& edgeA : edgesA)
    {
        for (const Vector3d& edgeB : edgesB)
        {
            consider(edgeA.cross(edgeB));
        }
    }
    return best;
}

TriangleStep triangleStep(const PairConstants& c,
                          const PairState& s,
                          std::int32_t triangleA,
                          std::int32_t triangleB)
{
    const auto a = movingCorners(
        c.treeA->corners(triangleA), c.offsetA, c.accelerationA, s.R, s.p, s.vA, s.wA);
    const auto b = movingCorners(c.treeB->corners(triangleB),
                                 c.offsetB,
                                 c.accelerationB,
                                 Matrix3d::Identity(),
                                 Vector3d::Zero(),
                                 s.vB,
                                 s.wB);
    TriangleStep result;
    result.distance = triangleDistance({a[0].point, a[1].point, a[2].point},
                                       {b[0].point, b[1].point, b[2].point});
    const double margin = 0.5 * c.threshold + s.rounding;
    const double d = result.distance.distance;
    if (d <= 0.0)
    {
        return result;
    }
    Step step = cornerStep(a, b, (result.distance.pointB - result.distance.pointA) / d, margin);
    if (step.gap < 0.99 * d)
    {
        const Step other = separatingStep(a, b, margin);
        step = other.gap > step.gap ? other : step;
    }
    result.time = step.time;
    return result;
}

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
            visitTriangles(entry, a.triangle, b.triangle);
        }
        else if (entry.advance)
        {
            examine(entry.pair, entry.nodeA, entry.nodeB, entry.time);
        }
        else if (b.isLeaf() || (!a.isLeaf() && a.coreRadius >= b.coreRadius))
        {
            examine(entry.pair, a.child, entry.nodeB, entry.time);
            examine(entry.pair, a.child + 1, entry.nodeB, entry.time);
        }
        else
        {
            examine(entry.pair, entry.nodeA, b.child, entry.time);
            examine(entry.pair, entry.nodeA, b.child + 1, entry.time);
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
        Isometry3d X_BA = Isometry3d::Identity();
        X_BA.linear() = state.R;
        X_BA.translation() = state.p + c.treeB->origin() - state.R * c.treeA->origin();
        const double start =
            std::min(upperBound, treeDistance(*c.treeA, *c.treeB, X_BA, upperBound).distance);
        if (start <= 4.0 * state.rounding)
        {
            return true;
        }
        c.threshold = std::min(c.threshold, 0.75 * start);
        return false;
    }

    void finish(const Entry& entry,
                const TriangleDistance& d,
                std::int32_t triangleA,
                std::int32_t triangleB)
    {
        m_done = true;
        m_result.status = entry.time == 0.0 ? ToiStatus::Overlapping : ToiStatus::Hit;
        m_result.time = entry.time;
        m_result.gap = d.distance;
        m_result.pair = entry.pair;
        m_result.triangleA = triangleA;
        m_result.triangleB = triangleB;
        const Isometry3d X_WB = m_scene.worldOfB(entry.pair, entry.time);
        m_result.pointA = X_WB * d.pointA;
        m_result.pointB = X_WB * d.pointB;
        if (d.distance > 0.0)
        {
            m_result.normal = X_WB.linear() * (d.pointB - d.pointA) / d.distance;
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
    return rigid(std::get<RigidMotion>(body.motion));
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
    return std::get<RigidMotion>(body.motion).at(t).X_W * body.X_BG;
}
}  // namespace bullet_ccd
