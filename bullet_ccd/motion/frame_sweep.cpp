#include "bullet_ccd/motion/frame_sweep.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Row = std::array<TaylorModel, 3>;

/// A dozen roundings of what passes through a pose.
constexpr double kPoseRounding = 16.0 * kTaylorUnit;

TaylorModel along(const Row& row, const Vector3d& v)
{
    return combined({v.x(), v.y(), v.z()}, row[0], row[1], row[2]);
}

/// Row i of a constant matrix.
Row constantRow(const Matrix3d& R, Eigen::Index i)
{
    Row row;
    for (std::size_t j = 0; j < 3; ++j)
    {
        row[j] = constantModel(R(i, static_cast<Eigen::Index>(j)), kPoseRounding);
    }
    return row;
}

/// The frame's own motion, applied to one row of its rotation: M is that before it.
Row turnedRow(const Row& m, const SineCosine& turn)
{
    return {turn.cosine * m[0] + turn.sine * m[1], turn.cosine * m[1] - turn.sine * m[0], m[2]};
}

/// The same for a row of numbers.
Row turnedRow(const Vector3d& m, const SineCosine& turn)
{
    Row row{scaled(m.x(), turn.cosine) + scaled(m.y(), turn.sine),
            scaled(m.y(), turn.cosine) - scaled(m.x(), turn.sine),
            constantModel(m.z(), kPoseRounding)};
    row[0].error += kPoseRounding;
    row[1].error += kPoseRounding;
    return row;
}

struct OwnMotion
{
    TaylorModel shift;
    SineCosine turn;
};

/// The path over [begin, end], of s in [-1, 1].
TaylorModel pathModel(const JointPath& path, double begin, double end)
{
    // Taylor's series about the middle; a unit of its time is half the interval.
    const std::array<double, 6> d = path.partOf(0.5 * (begin + end), end).c;
    // s^4 = s^2 - 1/8 +- 1/8, s^5 = (5 s^3 - 5/4 s) / 4 +- 1/16.
    TaylorModel model;
    model.c = {d[0] - 0.125 * d[4], d[1] - 0.3125 * d[5], d[2] + d[4], d[3] + 1.25 * d[5]};
    double size = 0.0;  // the sizes of all terms of the series add up to no more: |t| <= 1
    for (const double coefficient : path.c)
    {
        size += std::abs(coefficient);
    }
    // A hundred roundings, and the end points, which are rounded, too: models hold a little beyond.
    model.error =
        (0.125 * std::abs(d[4]) + 0.0625 * std::abs(d[5]) + 256.0 * kTaylorUnit * size) * kTaylorUp;
    return model;
}

OwnMotion ownMotion(const MovingFrame& frame, double begin, double end)
{
    OwnMotion own;
    if (frame.curves)
    {
        const TaylorModel path = pathModel(frame.path, begin, end);
        if (frame.slides)
        {
            own.shift = path;
        }
        else
        {
            own.turn = sineCosine(path);
        }
        return own;
    }
    // The end points are rounded, so the models are to hold a little beyond them.
    const double position = frame.path.c[0];
    const double rate = frame.path.c[1];
    const double middle = position + 0.5 * (begin + end) * rate;
    const double slope = 0.5 * (end - begin) * rate * (1.0 + 2.0 * kTaylorUnit);
    const double error = 4.0 * kTaylorUnit * (std::abs(position) + std::abs(rate));
    if (frame.slides)
    {
        own.shift = linearModel(middle, slope);
        own.shift.error += error;
    }
    else
    {
        own.turn = sineCosine(middle, slope, error);
    }
    return own;
}

/// A frame on the base itself.
void startChain(const MovingFrame& frame, const OwnMotion& own, FrameModel& model)
{
    const Matrix3d R = frame.X_PF.linear();
    const Vector3d& p = frame.X_PF.translation();
    for (std::size_t i = 0; i < 3; ++i)
    {
        const auto row = static_cast<Eigen::Index>(i);
        model.origin[i] = constantModel(p[row], kPoseRounding * (1.0 + p.norm()));
        if (frame.slides)
        {
            model.R[i] = constantRow(R, row);
            model.origin[i] = model.origin[i] + scaled(R(row, 2), own.shift);
        }
        else
        {
            model.R[i] = turnedRow(R.row(row).transpose(), own.turn);
        }
    }
}

void continueChain(const MovingFrame& frame,
                   const OwnMotion& own,
                   const FrameModel& parent,
                   FrameModel& model)
{
    const Matrix3d& R = frame.X_PF.linear();
    for (std::size_t i = 0; i < 3; ++i)
    {
        const Row& row = parent.R[i];
        const Row m{along(row, R.col(0)), along(row, R.col(1)), along(row, R.col(2))};
        model.origin[i] = parent.origin[i] + along(row, frame.X_PF.translation());
        if (frame.slides)
        {
            model.R[i] = m;
            model.origin[i] = model.origin[i] + m[2] * own.shift;
        }
        else
        {
            model.R[i] = turnedRow(m, own.turn);
        }
    }
}

/// Bound of the size of a coordinate of a vector that is a unit one to single precision.
double unitMagnitude(const TaylorModel& p)
{
    return std::min(1.0 + 1e-6, range(p).magnitude());
}
}  // namespace

void FrameSweep::reset(const MovingFrames& frames, std::int32_t base, double begin, double end)
{
    m_frames = &frames;
    m_base = base;
    m_begin = begin;
    m_end = end;
    ++m_sweep;
    if (m_models.size() < frames.frames().size())
    {
        m_models.resize(frames.frames().size());
        m_sweepOf.resize(m_models.size(), 0);
    }
}

const FrameModel& FrameSweep::model(std::int32_t frame)
{
    const auto index = static_cast<std::size_t>(frame);
    if (m_sweepOf[index] != m_sweep)
    {
        const MovingFrame& here = m_frames->frames()[index];
        const OwnMotion own = ownMotion(here, m_begin, m_end);
        if (here.parent == m_base)
        {
            startChain(here, own, m_models[index]);
        }
        else
        {
            continueChain(here, own, model(here.parent), m_models[index]);
        }
        m_sweepOf[index] = m_sweep;
    }
    return m_models[index];
}

SweptBox FrameSweep::boxOver(std::int32_t frame, const OrientedBox& box)
{
    if (frame == m_base)
    {
        return {.box = boundsOf(Eigen::Isometry3d::Identity(), box), .excess = 0.0};
    }
    // The two ends of the longest side each have a model of their own; the other two sides only
    // widen what lies between.
    Eigen::Index longest = 0;
    box.half.maxCoeff(&longest);
    const Vector3d arm = box.half[longest] * box.axes.col(longest);
    const Vector3d first = box.center - arm;
    const Vector3d last = box.center + arm;
    const FrameModel& pose = model(frame);
    SweptBox result;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const Row& row = pose.R[i];
        const TaylorModel atFirst = pose.origin[i] + along(row, first);
        const TaylorModel atLast = pose.origin[i] + along(row, last);
        const Interval a = range(atFirst);
        const Interval b = range(atLast);
        double margin = box.radius;
        double excess = std::max(atFirst.error, atLast.error);
        for (const Eigen::Index k : {(longest + 1) % 3, (longest + 2) % 3})
        {
            if (box.half[k] > 0.0)
            {
                const TaylorModel side = along(row, box.axes.col(k));
                margin += box.half[k] * unitMagnitude(side);
                excess += box.half[k] * std::min(1.0, side.error);
            }
        }
        margin *= kTaylorUp;
        const auto k = static_cast<Eigen::Index>(i);
        // Poses of links that rest on each other were multiplied before: a few roundings each.
        const double slack = 256.0 * kTaylorUnit * (a.magnitude() + b.magnitude() + margin);
        result.box.min()[k] = std::min(a.low, b.low) - margin - slack;
        result.box.max()[k] = std::max(a.high, b.high) + margin + slack;
        result.excess = std::max(result.excess, excess);
    }
    return result;
}

Eigen::AlignedBox3d boundsOf(const Eigen::Isometry3d& X, const OrientedBox& box)
{
    const Vector3d center = X * box.center;
    const Vector3d reach =
        (X.linear() * box.axes).cwiseAbs() * box.half + Vector3d::Constant(box.radius);
    const double slack =
        64.0 * kTaylorUnit * (X.translation().norm() + box.center.norm() + reach.norm());
    const Vector3d wide = reach + Vector3d::Constant(slack);
    return {center - wide, center + wide};
}
}  // namespace bullet_ccd
