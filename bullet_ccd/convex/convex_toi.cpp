#include "bullet_ccd/convex/convex_toi.h"

#include "bullet_ccd/convex/box_separation.h"
#include "bullet_ccd/convex/closest_points.h"
#include "bullet_ccd/convex/convex_pair.h"
#include "bullet_ccd/convex/kernels/moving_boxes.h"
#include "bullet_ccd/convex/support.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/toi/search/pair_step.h"
#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// @param isPlain of the body: see isPlain()
void checkConvexBody(const ConvexBody& body, bool isPlain, const char* name)
{
    if (!isPose(body.motion.X_W0))
    {
        failPose(std::string("time of impact: X_W0 of body ") + name, body.motion.X_W0);
    }
    if (!isPlain && !isPose(body.X_BG))
    {
        failPose(std::string("time of impact: X_BG of body ") + name, body.X_BG);
    }
    // Zero times NaN and infinity is NaN.
    const RigidMotion& m = body.motion;
    require(
        (0.0 * m.v_W + 0.0 * m.w_W + 0.0 * m.reference_B).sum() == 0.0,
        "time of impact: a velocity or the reference point of a convex body is NaN or infinite");
}

/// The time in which the balls about two shapes can be within `reach` of each other.
struct Window
{
    double begin = 0.0;
    double end = 1.0;
    bool isEmpty = false;
};

/// |D0 + t V| <= reach, rounded outwards by more than gaps are.
Window meetingOfBalls(const ConvexCourse& pair, double reach)
{
    constexpr double kUp = 1.0 + 1e-13;
    constexpr double kUnit = 1e-14;
    const double a = pair.V.squaredNorm();
    const double b = pair.D0.dot(pair.V);
    const double square = pair.farthest * pair.farthest;
    const double c = pair.D0.squaredNorm() - reach * reach * kUp - kUnit * square;
    if (c <= 0.0)
    {
        // Near from the start; they may part.
        const double root = std::sqrt(std::max(0.0, b * b - a * c)) * kUp;
        const double end = a > 0.0 ? (root - b) / a * kUp : 1.0;
        return {.begin = 0.0, .end = std::clamp(end, 0.0, 1.0)};
    }
    const double discriminant = b * b - a * c + kUnit * a * square;
    if (b >= 0.0 || discriminant < 0.0)
    {
        return {.isEmpty = true};
    }
    const double root = std::sqrt(discriminant);
    const double begin = c / (root - b) * (1.0 - 1e-13);
    return {.begin = begin, .end = std::min(1.0, (root - b) / a * kUp), .isEmpty = begin > 1.0};
}

class ConvexQuery
{
public:
    ConvexQuery(const ConvexCourse& course,
                const ConvexBody& bodyA,
                const ConvexBody& bodyB,
                const ToiOptions& options,
                const PairLimits& limits)
        : m_bodyB(bodyB),
          m_pair(course, bodyA, bodyB),
          m_options(options),
          m_limits(limits),
          m_radii(bodyA.shape->radius + bodyB.shape->radius),
          m_areBoxes(bodyA.shape->core == ConvexCore::Box && bodyB.shape->core == ConvexCore::Box)
    {
    }

    /// @param window the balls around the shapes are apart outside of it
    ToiResult run(const Window& window);

private:
    /// Whether a gap of the cores, up to rounding, says that the shapes are farther apart.
    [[nodiscard]] bool isBeyond(double gap, double distance) const
    {
        return gap > distance + m_radii + m_pair.rounding;
    }
    void setNormal(const Vector3d& n_B)
    {
        m_direction.n_B = n_B;
        m_direction.n = m_places.RB() * n_B;
    }
    void look(double t);
    void lookAtBoxes();
    void lookAtGround();
    [[nodiscard]] bool touchesAtStart();
    [[nodiscard]] double advance(double end);
    [[nodiscard]] Vector3d rateOfFeatures(const Vector3d& edgeA, const Vector3d& edgeB) const;
    void followSimplex();
    [[nodiscard]] ToiResult answer(ToiStatus status, double t) const;
    [[nodiscard]] ToiResult describe(ToiStatus status) const;

    const ConvexBody& m_bodyB;
    ConvexPair m_pair;
    const ToiOptions& m_options;
    PairLimits m_limits;
    double m_radii = 0.0;
    bool m_areBoxes = false;

    ConvexPlaces m_places;
    TurningDirection m_direction;  ///< separates the cores where they are
    BoxAxis m_axis;                ///< that of the direction, of two boxes
    bool m_isExact = false;        ///< the closest points are known, not only a direction
    ClosestPoints m_closest;
    Simplex m_simplex;
    bool m_touches = false;
    bool m_presses = false;
    ToiCounters m_counters;
};

/// How the normal of two features turns, so that it stays normal to both: its derivative has the
/// component -n . (w x e) along every edge e that lies in a feature; a zero edge is a corner.
Vector3d ConvexQuery::rateOfFeatures(const Vector3d& edgeA, const Vector3d& edgeB) const
{
    const Vector3d& n = m_direction.n;
    const Vector3d& wA = m_pair.spinA.velocity;
    const Vector3d& wB = m_pair.spinB.velocity;
    const double alongA = edgeA.dot(n.cross(wA));
    const double alongB = edgeB.dot(n.cross(wB));
    const double cosine = edgeA.dot(edgeB);
    const double square = 1.0 - cosine * cosine;
    constexpr double kParallel = 1e-6;
    if (edgeB.isZero(0.0) || square < kParallel)
    {
        return -alongA * n.cross(edgeA);
    }
    if (edgeA.isZero(0.0))
    {
        return -alongB * n.cross(edgeB);
    }
    const Vector3d change = ((alongA - cosine * alongB) / square) * edgeA +
                            ((alongB - cosine * alongA) / square) * edgeB;
    return 0.5 * n.dot(wA + wB) * n - n.cross(change);
}

/// The same for the features that carry the closest points.
void ConvexQuery::followSimplex()
{
    const auto count = static_cast<std::size_t>(m_simplex.size);
    const auto spanOf = [&](const std::array<Vector3d, 4>& points, Vector3d& edge)
    {
        int distinct = 1;
        edge.setZero();
        for (std::size_t i = 1; i < count; ++i)
        {
            if (points[i] != points[0] && (i < 2 || points[i] != points[i - 1]))
            {
                edge = (points[i] - points[0]).normalized();
                ++distinct;
            }
        }
        return distinct;
    };
    Vector3d edgeA;
    Vector3d edgeB;
    const int distinctA = spanOf(m_simplex.a, edgeA);
    const int distinctB = spanOf(m_simplex.b, edgeB);
    if (distinctA >= 3 || distinctB >= 3)
    {
        m_direction.with =
            distinctB >= 3 ? TurningDirection::With::BodyB : TurningDirection::With::BodyA;
        return;
    }
    m_direction.with = TurningDirection::With::Itself;
    m_direction.w = rateOfFeatures(m_places.RA() * edgeA, m_places.RB() * edgeB);
}

/// Finds a direction that separates the cores at time t; m_isExact says whether it is that of the
/// closest points.
void ConvexQuery::look(double t)
{
    ++m_counters.states;
    m_pair.at(t, m_places);
    m_isExact = false;
    if (m_pair.shapeB->core == ConvexCore::HalfSpace)
    {
        lookAtGround();
        return;
    }
    if (m_areBoxes)
    {
        lookAtBoxes();
    }
    // What touches at the start is judged by its distance.
    const double near = t == 0.0 ? m_limits.threshold : m_limits.near();
    if (!m_areBoxes || (!m_isExact && !isBeyond(m_closest.gap, near)))
    {
        m_closest = closestPoints(*m_pair.shapeA,
                                  *m_pair.shapeB,
                                  m_places.X_BA,
                                  m_limits.threshold + m_radii + m_pair.rounding,
                                  t > 0.0,  // a time that is certified
                                  m_simplex);
        m_isExact = true;
        setNormal(m_closest.normal);
        followSimplex();
    }
}

void ConvexQuery::lookAtBoxes()
{
    const Vector3d& halfA = m_pair.shapeA->half;
    const Vector3d& halfB = m_pair.shapeB->half;
    const Placement& pose = m_places.X_BA;
    // Where the features of the last axis still face each other, they are the closest ones.
    m_isExact = m_counters.states > 1 && refreshAxis(halfA, halfB, pose, m_axis) &&
                facingPoints(halfA, halfB, pose, m_axis, m_closest);
    if (!m_isExact)
    {
        m_axis = bestBoxAxis(halfA, halfB, pose);
        m_isExact = !isBeyond(m_axis.gap, m_limits.threshold) && m_axis.gap > 0.0 &&
                    facingPoints(halfA, halfB, pose, m_axis, m_closest);
    }
    m_closest.gap = m_axis.gap;
    setNormal(m_axis.normal);
    if (m_axis.edgeA < 0 || m_axis.edgeB < 0)
    {
        m_direction.with =
            m_axis.edgeA < 0 ? TurningDirection::With::BodyB : TurningDirection::With::BodyA;
        return;
    }
    m_direction.with = TurningDirection::With::Itself;
    m_direction.w =
        rateOfFeatures(m_places.RA().col(m_axis.edgeA), m_places.RB().col(m_axis.edgeB));
}

/// Above a half-space, its normal is the only direction.
void ConvexQuery::lookAtGround()
{
    const Placement& pose = m_places.X_BA;
    const Vector3d n = -m_pair.shapeB->half;
    const Vector3d a = supportPoint(*m_pair.shapeA, pose.R.transpose() * n);
    m_closest.pointA = pose.R * a + pose.p;
    m_closest.gap = -n.dot(m_closest.pointA) - m_pair.shapeB->offset;
    m_closest.distance = std::max(0.0, m_closest.gap);
    m_closest.normal = n;
    m_closest.pointB = m_closest.pointA + m_closest.distance * n;
    m_isExact = true;
    setNormal(n);
    m_direction.with = TurningDirection::With::BodyB;
}

/// How far the direction certifies; the time of the places if not at all.
double ConvexQuery::advance(double end)
{
    const double margin = m_limits.margin() + m_radii + m_pair.rounding;
    const GapAlong along(m_pair, m_places, m_direction);
    double t = m_places.t;
    double room = along.gap() - margin;
    double rate = along.rate();
    const double little = 0.25 * room;
    constexpr int kProbes = 4;
    for (int probe = 0; probe < kProbes && room > little; ++probe)
    {
        ++m_counters.nodePairs;
        double length = end - t;
        if (-rate * length > room)
        {
            length = room / -rate;
        }
        // Where the bend is what counts, a shorter look sees farther.
        if (along.bend() * length * length > 4.0 * room)
        {
            length = std::min(length, std::sqrt(4.0 * room / along.bend()));
        }
        const bool toEnd = length >= end - t;
        const double there = toEnd ? end : t + length;
        const double next = along.gapAt(there) - margin;
        const double root = certifiedRoot(room, next, there - t, along.bend());
        if (root < there - t)
        {
            return std::max(t, std::nextafter(t + root, 0.0));
        }
        if (toEnd)
        {
            return end;
        }
        rate = (next - room) / (there - t);
        room = next;
        t = there;
    }
    return t;
}

ToiResult ConvexQuery::answer(ToiStatus status, double t) const
{
    ToiResult result;
    result.status = status;
    result.time = t;
    result.gap = m_limits.margin();
    result.counters = m_counters;
    return result;
}

/// The closest points, in W.
ToiResult ConvexQuery::describe(ToiStatus status) const
{
    ToiResult result = answer(status, m_places.t);
    const RigidMotion& motion = m_bodyB.motion;
    const auto R_WB = m_places.RB();
    const Vector3d p_WB =
        motion.X_W0 * motion.reference_B + m_places.t * motion.v_W + R_WB * m_pair.armB;
    // Of cores that a ball sweeps the closest points say the direction best: the normal is that of
    // the largest gap, which is right to second order only.
    const bool isRounded = m_radii > 0.0 && m_closest.distance > 0.0;
    const Vector3d n = isRounded
                           ? Vector3d((m_closest.pointB - m_closest.pointA) / m_closest.distance)
                           : m_closest.normal;
    result.gap = std::max(0.0, m_closest.distance - m_radii);
    result.pointA = p_WB + R_WB * (m_closest.pointA + m_pair.shapeA->radius * n);
    result.pointB = p_WB + R_WB * (m_closest.pointB - m_pair.shapeB->radius * n);
    if (result.gap > 0.0)
    {
        result.normal = R_WB * n;
    }
    return result;
}

/// The shapes are within the tolerance at t = 0. From now on they must close in further to count as
/// in contact. Returns false if they are as near as they may be.
bool ConvexQuery::touchesAtStart()
{
    const double distance = m_closest.distance - m_radii;
    if (distance <= m_limits.floor + 4.0 * m_pair.rounding)
    {
        return false;
    }
    m_touches = true;
    const Vector3d n = m_places.RB() * m_closest.normal;
    const Vector3d a =
        m_places.RB() * (m_closest.pointA - m_places.X_BA.p) + m_places.RA() * m_pair.armA;
    const Vector3d b = m_places.RB() * (m_closest.pointB + m_pair.armB);
    const Spin& spinA = m_pair.spinA;
    const Spin& spinB = m_pair.spinB;
    const double closing = n.dot(spinA.velocity.cross(a) - spinB.velocity.cross(b) - m_pair.V);
    const double scale = m_pair.speed + spinA.rate * m_pair.reachA + spinB.rate * m_pair.reachB;
    constexpr double kRestingSpeed = 1e-12;  // below this part of the speed it is rounding
    m_presses = closing > kRestingSpeed * scale;
    m_limits.threshold =
        std::min(m_limits.threshold, m_limits.floor + 0.75 * (distance - m_limits.floor));
    return true;
}

ToiResult ConvexQuery::run(const Window& window)
{
    double t = window.begin;
    while (true)
    {
        if (m_counters.states >= m_options.maxIterations)
        {
            return answer(ToiStatus::IterationLimit, t);
        }
        if (m_options.stop.isGiven() && m_options.stop.isDue())
        {
            return answer(ToiStatus::Stopped, t);
        }
        look(t);
        const double distance = m_closest.distance - m_radii;
        const ToiStatus hit = m_presses ? ToiStatus::TouchingPressing : ToiStatus::Hit;
        if (m_isExact && t == 0.0 && distance <= m_limits.threshold)
        {
            if (!touchesAtStart())
            {
                return describe(ToiStatus::Overlapping);
            }
        }
        else if (m_isExact && distance <= m_limits.near())
        {
            return describe(hit);
        }
        const double next = advance(window.end);
        if (next >= window.end)
        {
            return answer(m_touches ? ToiStatus::TouchingLeaving : ToiStatus::Separated, 1.0);
        }
        if (next <= t)
        {
            const bool isNear = m_isExact && distance <= m_limits.threshold;
            return isNear ? describe(hit) : answer(ToiStatus::IterationLimit, t);
        }
        t = next;
    }
}

/// The box as the kernel takes it; `axes` is scratch.
MovingBox movingBox(
    const ConvexBody& body, bool isPlain, const Vector3d& arm, double reach, Matrix3d& axes)
{
    if (!isPlain)
    {
        axes = body.motion.X_W0.linear() * body.X_BG.linear();
    }
    const auto axis = [&](Eigen::Index k)
    { return isPlain ? &body.motion.X_W0.matrix().coeffRef(0, k) : &axes.coeffRef(0, k); };
    return {.axes = {axis(0), axis(1), axis(2)},
            .half = body.shape->half.data(),
            .arm = arm.data(),
            .w = body.motion.w_W.data(),
            .reach = reach};
}

/// What the kernel for two boxes finds out.
BoxesMeeting meetBoxes(BoxKernel& kernel,
                       const ConvexCourse& course,
                       const ConvexBody& bodyA,
                       const ConvexBody& bodyB,
                       const PairLimits& limits,
                       const Window& window,
                       std::int64_t mostLooks)
{
    Matrix3d axesA;
    Matrix3d axesB;
    const double radii = bodyA.shape->radius + bodyB.shape->radius;
    return kernel({.a = movingBox(bodyA, course.isPlainA, course.armA, course.reachA, axesA),
                   .b = movingBox(bodyB, course.isPlainB, course.armB, course.reachB, axesB),
                   .D0 = course.D0.data(),
                   .V = course.V.data(),
                   .farthest = course.farthest,
                   .sizes = course.sizes,
                   .floor = limits.floor + radii,
                   .threshold = limits.threshold + radii,
                   .aim = limits.aim,
                   .begin = window.begin,
                   .end = window.end,
                   .mostLooks = mostLooks});
}

/// The same as an answer.
ToiResult answerOf(const BoxesMeeting& meeting, const ConvexBody& bodyA, const ConvexBody& bodyB)
{
    ToiResult result;
    result.status = meeting.touches ? ToiStatus::TouchingLeaving : ToiStatus::Separated;
    result.time = meeting.time;
    result.gap = std::max(0.0, meeting.gap - bodyA.shape->radius - bodyB.shape->radius);
    result.counters.states = meeting.looks;
    result.counters.nodePairs = meeting.probes;
    if (meeting.outcome == BoxesMeeting::Outcome::Hit)
    {
        result.status = meeting.presses ? ToiStatus::TouchingPressing : ToiStatus::Hit;
        const RigidMotion& motion = bodyB.motion;
        const Vector3d p_WB = motion.X_W0 * motion.reference_B + meeting.time * motion.v_W;
        const Vector3d n(meeting.normal);
        result.pointA = p_WB + Vector3d(meeting.pointA) + bodyA.shape->radius * n;
        result.pointB = p_WB + Vector3d(meeting.pointB) - bodyB.shape->radius * n;
        if (result.gap > 0.0)
        {
            result.normal = n;
        }
    }
    return result;
}

/// @param names of the bodies, for errors
ToiResult ask(const ConvexBody& bodyA,
              const ConvexBody& bodyB,
              const ToiOptions& options,
              const std::array<const char*, 2>& names)
{
    const PairLimits limits{.floor = options.minimumSeparation,
                            .threshold = options.minimumSeparation + options.tolerance,
                            .aim = options.aim};
    const ConvexCourse course(bodyA, bodyB);
    checkConvexBody(bodyA, course.isPlainA, names[0]);
    checkConvexBody(bodyB, course.isPlainB, names[1]);
    Window window;
    if (bodyB.shape->core != ConvexCore::HalfSpace)
    {
        window = meetingOfBalls(course,
                                course.reachA + course.reachB + limits.threshold +
                                    bodyA.shape->radius + bodyB.shape->radius);
        if (window.isEmpty)
        {
            ToiResult result;
            result.gap = limits.margin();
            return result;
        }
    }
    ToiCounters counters;
    BoxKernel* const kernel = boxKernel();
    constexpr double kSquare = kMostTurning * kMostTurning;
    if (kernel != nullptr && bodyA.shape->core == ConvexCore::Box &&
        bodyB.shape->core == ConvexCore::Box && bodyA.motion.w_W.squaredNorm() < kSquare &&
        bodyB.motion.w_W.squaredNorm() < kSquare &&
        !options.stop.isGiven())  // which is looked at step by step
    {
        constexpr std::int64_t kMostLooks = 1000;
        const BoxesMeeting meeting = meetBoxes(*kernel,
                                               course,
                                               bodyA,
                                               bodyB,
                                               limits,
                                               window,
                                               std::min(options.maxIterations, kMostLooks));
        if (meeting.outcome != BoxesMeeting::Outcome::Open)
        {
            return answerOf(meeting, bodyA, bodyB);
        }
        window.begin = meeting.time;
        counters.states = meeting.looks;
        counters.nodePairs = meeting.probes;
    }
    ToiResult result = ConvexQuery(course, bodyA, bodyB, options, limits).run(window);
    result.counters.states += counters.states;
    result.counters.nodePairs += counters.nodePairs;
    return result;
}
}  // namespace

ToiResult convexToi(const ConvexBody& bodyA, const ConvexBody& bodyB, const ToiOptions& options)
{
    checkOptions(options);
    require(bodyA.shape != nullptr && bodyB.shape != nullptr,
            "time of impact: a convex body has no shape: make one, such as boxShape()");
    const bool isGround = bodyA.shape->core == ConvexCore::HalfSpace;
    require(!isGround || bodyB.shape->core != ConvexCore::HalfSpace,
            "time of impact: two half-spaces always meet; one of the shapes must be bounded");
    if (isGround)
    {
        ToiResult result = ask(bodyB, bodyA, options, {"B", "A"});
        std::swap(result.pointA, result.pointB);
        result.normal = -result.normal;
        return result;
    }
    return ask(bodyA, bodyB, options, {"A", "B"});
}
}  // namespace bullet_ccd
