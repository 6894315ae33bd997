/// A kinematic tree in motion, boiled down to what moves: one frame for every joint that does.
///
/// Joints at rest disappear: links that do not move relative to each other share a frame. Every
/// frame turns about or slides along its own z axis, so that a chain costs a dozen products a joint
/// and no general rotation. A root that moves contributes up to two frames: a slide and a turn.
#pragma once

#include "bullet_ccd/motion/kinematic_tree.h"

#include <optional>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// Frame F of a joint that moves. Its pose in the parent frame P at time t is X_PF, then a turn
/// about its own z axis, or a slide along it, of path.at(t).
struct MovingFrame
{
    std::int32_t parent = kNone;  ///< smaller than the frame's own index
    bool slides = false;
    bool curves = false;       ///< the path is not linear
    JointPath path{};          ///< [rad] or [m]
    JointPathBounds bounds{};  ///< of the path
    Eigen::Isometry3d X_PF = Eigen::Isometry3d::Identity();
    std::int32_t link = kNone;  ///< whose joint it is; 0 for the root
};

/// Where a link is fixed.
struct LinkPlace
{
    std::int32_t frame = 0;
    Eigen::Isometry3d X_FL = Eigen::Isometry3d::Identity();
};

/// Bound of the speed of points at distance r from a frame's origin: constant + perRadius r.
struct SpeedBound
{
    double constant = 0.0;
    double perRadius = 0.0;
};

/// A plane in which all points of a body accelerate: it turns about parallel axes, and slides at
/// constant speed or across them.
struct AccelerationPlane
{
    /// Unit, at rest both in the frame that the body is seen from and in the body; zero if the body
    /// does not turn, so that any plane will do.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    AccelerationBound across{};  ///< along the normal after all: axes are parallel up to rounding
};

class MovingFrames
{
public:
    /// Allocates nothing once it has seen a tree of that size. The tree and motion are not kept.
    /// @pre sizes agree
    void reset(const KinematicTree& tree, const JointMotion& motion);

    /// Frame 0 is W, at rest; parents come first.
    [[nodiscard]] std::span<const MovingFrame> frames() const { return m_frames; }
    [[nodiscard]] const LinkPlace& place(std::int32_t link) const
    {
        return m_places[static_cast<std::size_t>(link)];
    }

    /// Deepest frame that both are in or below.
    [[nodiscard]] std::int32_t commonFrame(std::int32_t a, std::int32_t b) const;

    /// The frame as seen from `base`. States are remembered: frames that are asked for at the same
    /// time share those above them.
    /// @pre base is `frame` or above it
    [[nodiscard]] const MotionState& stateAt(std::int32_t base, std::int32_t frame, double t);

    /// Bound of the acceleration of points of the frame relative to `base`, over the whole step.
    ///
    /// With W_i the angular velocity of frame i, a point at r from the last origin accelerates by
    /// at most sum_i (|W_i|^2 + |W'_i|) |offset_i| + (|W_n|^2 + |W'_n|) r, and by twice |q' W x z|
    /// and |q''| for every slide. |W_i| is bounded from joint to joint by its part along the
    /// joint's axis, which adds up with its sign, and its part across, so that joints that turn
    /// against each other cancel; never worse than the sum of the products of all speeds.
    [[nodiscard]] AccelerationBound accelerationBound(std::int32_t base, std::int32_t frame) const;

    /// The plane of the accelerations of the frame relative to `base`, if there is one.
    [[nodiscard]] std::optional<AccelerationPlane> accelerationPlane(std::int32_t base,
                                                                     std::int32_t frame) const;

    /// Bound of the speed of points of the frame relative to `base`: the sum of what every joint
    /// can contribute, in whatever direction.
    [[nodiscard]] SpeedBound speedBound(std::int32_t base, std::int32_t frame) const;

private:
    struct Memory
    {
        std::int32_t base = kNone;
        double time = -1.0;
        MotionState state;
    };

    void addRoot(const RigidMotion& root);
    void addLink(const KinematicTree& tree, const JointMotion& motion, std::int32_t link);
    [[nodiscard]] const MovingFrame& at(std::int32_t frame) const
    {
        return m_frames[static_cast<std::size_t>(frame)];
    }

    std::vector<MovingFrame> m_frames;
    std::vector<LinkPlace> m_places;
    std::vector<Memory> m_memory;
};

/// The motion of a frame that moves by one slide and one turn about the same origin at most, seen
/// from `base`: exactly that of a rigid body. Returns false, and leaves `motion` alone, for all
/// others.
/// @pre base is `frame` or above it
[[nodiscard]] bool asRigidMotion(const MovingFrames& frames,
                                 std::int32_t base,
                                 std::int32_t frame,
                                 RigidMotion& motion);
}  // namespace bullet_ccd
