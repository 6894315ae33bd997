/// When links may come near what they are tested against: balls around them in slices of time, as a
/// filter before the search.
#pragma once

#include "bullet_ccd/motion/frame_sweep.h"

#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace bullet_ccd
{
/// A ball that is fixed to a frame.
struct FrameBall
{
    std::int32_t frame = 0;
    Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< in the frame [m]
    double radius = 0.0;
};

/// The motion over [0, 1] is cut into equal slices. Within one the center of a ball stays near a
/// piece of a straight line: that of its velocity in the middle of the slice, up to its largest
/// acceleration times half the square of the time from there.
class NearTimes
{
public:
    /// Places the balls, as seen from the frame `base`. Allocates nothing once it has seen as many.
    void reset(MovingFrames& frames, std::int32_t base, std::span<const FrameBall> balls);

    /// Encloses a ball at all times of the motion.
    [[nodiscard]] Eigen::AlignedBox3d boxOf(std::size_t ball) const;

    /// The first and the last time between which a ball may be within `reach` of a box at rest, or
    /// of another ball; nothing if it never may.
    ///
    /// Guarantee: at all other times they are farther apart than that.
    [[nodiscard]] std::optional<std::pair<double, double>> near(std::size_t ball,
                                                                const OrientedBox& box,
                                                                double reach) const;
    [[nodiscard]] std::optional<std::pair<double, double>> near(std::size_t ball,
                                                                std::size_t other,
                                                                double reach) const;

private:
    /// Where a ball is within a slice: within `radius` of the piece of a line.
    struct Moved
    {
        Eigen::Vector3d center;  ///< of the piece [m]
        Eigen::Vector3d half;    ///< from there to its end [m]
        double length;           ///< of that [m]
        double radius;
    };
    [[nodiscard]] std::span<const Moved> slicesOf(std::size_t ball) const
    {
        return std::span(m_moved).subspan(ball * m_slices, m_slices);
    }
    template <typename MayMeet>
    [[nodiscard]] std::optional<std::pair<double, double>> nearWhere(const MayMeet& mayMeet) const;

    std::vector<double> m_accelerations;  ///< bounds of those of the centers [m per step squared]
    std::vector<Moved> m_moved;           ///< all slices of a ball after each other
    std::size_t m_slices = 1;
};
}  // namespace bullet_ccd
