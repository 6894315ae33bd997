/// Where moving frames are over an interval of time: Taylor models of their poses, and boxes that
/// enclose what is fixed to them.
#pragma once

#include "bullet_ccd/math/taylor_model.h"
#include "bullet_ccd/motion/moving_frames.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Pose of a frame as seen from the base of the sweep, as functions of time.
struct FrameModel
{
    std::array<std::array<TaylorModel, 3>, 3> R{};  ///< row by row
    std::array<TaylorModel, 3> origin{};
};

/// An oriented box swept by a ball: {center + sum_k s_k half_k axis_k + b : |s_k| <= 1,
/// |b| <= radius}.
struct OrientedBox
{
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns, unit to single precision
    Eigen::Vector3d half = Eigen::Vector3d::Zero();
    double radius = 0.0;
};

/// A box of the base's axes, and how much of its width is doubt about the motion rather than
/// motion [m].
struct SweptBox
{
    Eigen::AlignedBox3d box{};
    double excess = 0.0;
};

class FrameSweep
{
public:
    /// Begins a sweep over [begin, end] as seen from the frame `base`. Models are computed when
    /// they are asked for, and kept. Allocates nothing once it has seen as many frames.
    /// @param frames must outlive the sweep
    void reset(const MovingFrames& frames, std::int32_t base, double begin, double end);

    /// @pre the frame is below the base of the sweep
    [[nodiscard]] const FrameModel& model(std::int32_t frame);

    /// Encloses the box, fixed to the frame, at all times of the interval, rounded outwards.
    /// @pre the frame is below the base of the sweep, or the base
    [[nodiscard]] SweptBox boxOver(std::int32_t frame, const OrientedBox& box);

private:
    const MovingFrames* m_frames = nullptr;
    std::vector<FrameModel> m_models;
    std::vector<std::uint64_t> m_sweepOf;  ///< the sweep that a model was computed in
    std::uint64_t m_sweep = 0;
    std::int32_t m_base = 0;
    double m_begin = 0.0;
    double m_end = 1.0;
};

/// Encloses a box at rest at pose X, rounded outwards.
[[nodiscard]] Eigen::AlignedBox3d boundsOf(const Eigen::Isometry3d& X, const OrientedBox& box);
}  // namespace bullet_ccd
