#include "bullet_ccd/motion/moving_frames.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Bounds are made of a few dozen roundings.
constexpr double kUp = 1.0 + 1e-12;

/// A rotation that takes the z axis to the unit vector `axis`.
Matrix3d frameAlong(const Vector3d& axis)
{
    const double sign = std::copysign(1.0, axis.z());
    const double a = -1.0 / (sign + axis.z());
    const double b = axis.x() * axis.y() * a;
    Matrix3d R;
    R.col(0) = Vector3d(1.0 + sign * axis.x() * axis.x() * a, sign * b, -sign * axis.x());
    R.col(1) = Vector3d(b, sign + axis.y() * axis.y() * a, -axis.y());
    R.col(2) = axis;
    return R;
}

/// Appends a frame and the transform from it to what follows, which is `here` if nothing moved.
void append(std::vector<MovingFrame>& frames,
            MovingFrame frame,
            const Vector3d& axis,
            LinkPlace& place)
{
    const Matrix3d along = frameAlong(axis);
    frame.curves = !frame.path.isLinear();
    frame.bounds = frame.path.bounds();
    frame.parent = place.frame;
    frame.X_PF = place.X_FL;
    frame.X_PF.linear() *= along;
    place.frame = static_cast<std::int32_t>(frames.size());
    place.X_FL = Isometry3d::Identity();
    place.X_FL.linear() = along.transpose();
    frames.push_back(frame);
}

/// Pose and velocities after the frame's own motion.
void compose(const MovingFrame& frame, const MotionState& parent, double t, MotionState& state)
{
    const std::array<double, 6>& c = frame.path.c;
    const double q = frame.curves ? frame.path.at(t) : c[0] + t * c[1];
    const double rate = frame.curves ? frame.path.rateAt(t) : c[1];
    const Matrix3d R = parent.X_W.linear() * frame.X_PF.linear();
    const Vector3d arm = parent.X_W.linear() * frame.X_PF.translation();
    state.X_W.makeAffine();
    state.w_W = parent.w_W;
    if (frame.slides)
    {
        const Vector3d reach = arm + q * R.col(2);
        state.X_W.linear() = R;
        state.X_W.translation() = parent.X_W.translation() + reach;
        state.v_W = parent.v_W + parent.w_W.cross(reach) + rate * R.col(2);
        return;
    }
    const double sine = std::sin(q);
    const double cosine = std::cos(q);
    state.X_W.linear().col(0) = cosine * R.col(0) + sine * R.col(1);
    state.X_W.linear().col(1) = cosine * R.col(1) - sine * R.col(0);
    state.X_W.linear().col(2) = R.col(2);
    state.X_W.translation() = parent.X_W.translation() + arm;
    state.v_W = parent.v_W + parent.w_W.cross(arm);
    state.w_W += rate * R.col(2);
}

/// What is known of the angular velocity of a frame over the step: its part along the axis z of the
/// frame, an interval, and the size of what is across.
struct Spin
{
    double low = 0.0;
    double high = 0.0;
    double across = 0.0;
    double sum = 0.0;     ///< of all angular speeds
    double bends = 0.0;   ///< of all angular accelerations of the joints themselves
    double change = 0.0;  ///< bound of the derivative of the angular velocity

    /// Seen along the axis of the next frame: `z` in the axes of this one.
    void seenAlong(const Vector3d& z)
    {
        const double c = z.z();
        const double s = std::min(1.0, std::hypot(z.x(), z.y()) + 1e-15);
        const double size = std::max(std::abs(low), std::abs(high));
        const double first = std::min(low * c, high * c) - across * s;
        const double last = std::max(low * c, high * c) + across * s;
        const double total = std::hypot(size, across);
        across = std::min(total, size * s + across);
        low = first;
        high = last;
    }
    /// Norm of the map from an arm at rest in the frame to its acceleration.
    [[nodiscard]] double bend() const
    {
        const double size = std::max(std::abs(low), std::abs(high));
        return std::min(sum * sum + bends, size * size + across * across + change);
    }
};
}  // namespace

void MovingFrames::addRoot(const RigidMotion& root)
{
    LinkPlace place;
    const double speed = root.v_W.norm();
    const double spin = root.w_W.norm();
    if (speed == 0.0 && spin == 0.0)
    {
        place.X_FL = root.X_W0;
        m_places.push_back(place);
        return;
    }
    // The reference slides, the body turns about it.
    place.X_FL.translation() = root.X_W0 * root.reference_B;
    if (speed > 0.0)
    {
        append(
            m_frames, {.slides = true, .path = {{0.0, speed}}, .link = 0}, root.v_W / speed, place);
    }
    if (spin > 0.0)
    {
        append(m_frames, {.path = {{0.0, spin}}, .link = 0}, root.w_W / spin, place);
    }
    Isometry3d X_RB = Isometry3d::Identity();
    X_RB.linear() = root.X_W0.linear();
    X_RB.translation() = -(root.X_W0.linear() * root.reference_B);
    place.X_FL = place.X_FL * X_RB;
    m_places.push_back(place);
}

void MovingFrames::addLink(const KinematicTree& tree, const JointMotion& motion, std::int32_t link)
{
    const auto index = static_cast<std::size_t>(link);
    const Link& here = tree.links[index];
    LinkPlace place = m_places[static_cast<std::size_t>(here.parent)];
    if (here.joint.type == JointType::Spherical)
    {
        const BallMotion& ball = motion.ball(link);
        const double spin = ball.rate.norm();
        place.X_FL = place.X_FL * here.X_PL0;
        if (spin > 0.0)
        {
            append(m_frames, {.path = {{0.0, spin}}, .link = link}, ball.rate / spin, place);
        }
        place.X_FL.linear() *= ball.start;
    }
    else if (!here.joint.isMovable() || motion.path(link).isConstant())
    {
        place.X_FL = place.X_FL * linkInParent(here, motion.positions[index]);
    }
    else
    {
        place.X_FL = place.X_FL * here.X_PL0;
        append(m_frames,
               {.slides = here.joint.type == JointType::Prismatic,
                .path = motion.path(link),
                .link = link},
               here.joint.axis,
               place);
    }
    m_places.push_back(place);
}

void MovingFrames::reset(const KinematicTree& tree, const JointMotion& motion)
{
    BULLET_CCD_ASSERT(motion.positions.size() == tree.size());
    m_frames.clear();
    m_places.clear();
    m_frames.push_back({});
    for (std::int32_t link = 0; link < static_cast<std::int32_t>(tree.size()); ++link)
    {
        if (tree.links[static_cast<std::size_t>(link)].parent == kNone)
        {
            addRoot(motion.root);
        }
        else
        {
            addLink(tree, motion, link);
        }
    }
    m_memory.resize(m_frames.size());
    for (Memory& memory : m_memory)
    {
        memory.base = kNone;
    }
}

std::int32_t MovingFrames::commonFrame(std::int32_t a, std::int32_t b) const
{
    while (a != b)
    {
        std::int32_t& deeper = a > b ? a : b;
        deeper = at(deeper).parent;
    }
    return a;
}

const MotionState& MovingFrames::stateAt(std::int32_t base, std::int32_t frame, double t)
{
    Memory& memory = m_memory[static_cast<std::size_t>(frame)];
    if (memory.base == base && memory.time == t)
    {
        return memory.state;
    }
    if (frame == base)
    {
        memory.state = {};
    }
    else
    {
        const MovingFrame& here = at(frame);
        compose(here, stateAt(base, here.parent, t), t, memory.state);
    }
    memory.base = base;
    memory.time = t;
    return memory.state;
}

AccelerationBound MovingFrames::accelerationBound(std::int32_t base, std::int32_t frame) const
{
    // Down the chain, which is known from below: the indices of deep chains are kept in a list.
    std::array<std::int32_t, 128> chain{};
    std::size_t depth = 0;
    for (std::int32_t k = frame; k != base && depth < chain.size(); k = at(k).parent)
    {
        chain[depth++] = k;
    }
    AccelerationBound bound;
    Spin spin;
    if (depth == chain.size())
    {
        // Too long to be worth it: as if the frames above the first of the list turned along with
        // the base at the sum of all their speeds.
        const SpeedBound speed = speedBound(base, frame);
        bound.perRadius = speed.perRadius * speed.perRadius * kUp;
        bound.constant = 2.0 * speed.perRadius * speed.constant * kUp;
        return bound;
    }
    while (depth > 0)
    {
        const MovingFrame& here = at(chain[--depth]);
        bound.constant += spin.bend() * here.X_PF.translation().norm();
        spin.seenAlong(here.X_PF.linear().col(2));
        const double speed = here.bounds.speed();
        if (here.slides)
        {
            bound.constant += spin.bend() * here.bounds.reach +
                              2.0 * speed * std::min(spin.across, spin.sum) + here.bounds.bend;
            continue;
        }
        spin.change += speed * spin.across + here.bounds.bend;
        spin.low += here.bounds.lowestRate;
        spin.high += here.bounds.highestRate;
        spin.sum += speed;
        spin.bends += here.bounds.bend;
    }
    bound.perRadius = spin.bend() * kUp;
    bound.constant *= kUp;
    return bound;
}

std::optional<AccelerationPlane> MovingFrames::accelerationPlane(std::int32_t base,
                                                                 std::int32_t frame) const
{
    constexpr double kParallel = 1e-14;   // sines of deviations
    constexpr double kDeviation = 1e-12;  // of all of them together
    AccelerationPlane plane;
    double turn = 0.0;
    double bend = 0.0;
    double slide = 0.0;
    double slideBend = 0.0;
    double reach = 0.0;
    for (std::int32_t k = frame; k != base; k = at(k).parent)
    {
        const MovingFrame& here = at(k);
        if (here.slides)
        {
            slide += here.bounds.speed();
            reach += here.bounds.reach;
            slideBend += here.bounds.bend;
        }
        else
        {
            if (plane.normal.head<2>().norm() > kParallel)
            {
                return std::nullopt;
            }
            plane.normal = Vector3d::UnitZ();
            turn += here.bounds.speed();
            bend += here.bounds.bend;
        }
        plane.normal = here.X_PF.linear() * plane.normal;
        reach += here.X_PF.translation().norm();
    }
    // Slides that accelerate have to do so in the plane. Turns about its normal do not matter.
    for (std::int32_t k = frame; k != base && slideBend > 0.0; k = at(k).parent)
    {
        Vector3d axis = Vector3d::UnitZ();
        for (std::int32_t above = k; above != base; above = at(above).parent)
        {
            axis = at(above).X_PF.linear() * axis;
        }
        if (at(k).slides && at(k).curves &&
            (plane.normal.isZero(0.0) || std::abs(axis.dot(plane.normal)) > kParallel))
        {
            return std::nullopt;
        }
    }
    plane.across.perRadius = kDeviation * (turn * turn + bend);
    plane.across.constant =
        plane.across.perRadius * reach + kDeviation * (2.0 * turn * slide + slideBend);
    return plane;
}

SpeedBound MovingFrames::speedBound(std::int32_t base, std::int32_t frame) const
{
    SpeedBound bound;
    double reach = 0.0;  // of the last origin from that of the frame in hand
    for (std::int32_t k = frame; k != base; k = at(k).parent)
    {
        const MovingFrame& here = at(k);
        const double speed = here.bounds.speed();
        if (here.slides)
        {
            bound.constant += speed;
            reach += here.bounds.reach;
        }
        else
        {
            bound.constant += speed * reach;
            bound.perRadius += speed;
        }
        reach += here.X_PF.translation().norm();
    }
    bound.constant *= kUp;
    bound.perRadius *= kUp;
    return bound;
}

bool asRigidMotion(const MovingFrames& frames,
                   std::int32_t base,
                   std::int32_t frame,
                   RigidMotion& motion)
{
    RigidMotion result;
    Isometry3d X_W0 = Isometry3d::Identity();
    std::int32_t turn = kNone;
    for (std::int32_t k = frame; k != base; k = frames.frames()[static_cast<std::size_t>(k)].parent)
    {
        const MovingFrame& here = frames.frames()[static_cast<std::size_t>(k)];
        const bool isFirst = here.parent == base;
        if (here.curves || (here.slides ? !isFirst : turn != kNone))
        {
            return false;
        }
        turn = here.slides ? turn : k;
        Isometry3d X_PF = here.X_PF;
        if (here.slides)
        {
            result.v_W = here.path.c[1] * here.X_PF.linear().col(2);
            X_PF.translation() += here.path.c[0] * here.X_PF.linear().col(2);
        }
        else
        {
            X_PF.linear() *=
                Eigen::AngleAxisd(here.path.c[0], Vector3d::UnitZ()).toRotationMatrix();
        }
        X_W0 = X_PF * X_W0;
    }
    if (turn != kNone)
    {
        // The turn may be fixed below the slide: its axis keeps its direction there, too.
        const MovingFrame& here = frames.frames()[static_cast<std::size_t>(turn)];
        result.w_W = here.path.c[1] * X_W0.linear().col(2);
    }
    result.X_W0 = X_W0;
    motion = result;
    return true;
}
}  // namespace bullet_ccd
