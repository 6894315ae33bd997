/// Links and joints of an articulated body, and their motion over a step, in URDF's convention: the
/// frame of a link is the frame of the joint above it, moved by that joint.
///
/// Parents are stored before their children, and link 0 is the root. Joints have no index of their
/// own: joint i is the one above link i. Joint positions are vectors with one entry per link. The
/// entries of the root, of fixed joints and of spherical joints are ignored.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd
{
enum class JointType : std::uint8_t
{
    Fixed,
    Revolute,  ///< also URDF's continuous, which has no limits
    Prismatic,
    Spherical,  ///< any rotation; its motion is a BallMotion, not a position
};

/// The joint above a link. Its position is in [rad], or in [m] for a prismatic joint.
struct Joint
{
    std::string name;
    JointType type = JointType::Fixed;
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit, in the link's frame
    double lower = -std::numeric_limits<double>::infinity();
    double upper = std::numeric_limits<double>::infinity();
    double maxEffort = std::numeric_limits<double>::infinity();    ///< [N m] or [N]
    double maxVelocity = std::numeric_limits<double>::infinity();  ///< [rad/s] or [m/s]
    /// The joint that this one follows, or kNone: position = mimicMultiplier * position[mimicOf] +
    /// mimicOffset. mimicOf is not a mimic joint itself.
    std::int32_t mimicOf = kNone;
    double mimicMultiplier = 1.0;
    double mimicOffset = 0.0;

    [[nodiscard]] bool isMovable() const { return type != JointType::Fixed; }
};

/// A link, its place under its parent, and its inertia.
struct Link
{
    std::string name;
    std::int32_t parent = kNone;                              ///< smaller than the link's own index
    Eigen::Isometry3d X_PL0 = Eigen::Isometry3d::Identity();  ///< pose in the parent at position 0
    Joint joint{};
    double mass = 0.0;                                       ///< [kg]
    Eigen::Vector3d centerOfMass = Eigen::Vector3d::Zero();  ///< link frame [m]
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();       ///< about it, link axes [kg m^2]
};

/// All links of an articulated body.
struct BULLET_CCD_API KinematicTree
{
    std::vector<Link> links;

    [[nodiscard]] std::size_t size() const { return links.size(); }
    /// Index of the link of that name, or kNone.
    [[nodiscard]] std::int32_t findLink(const std::string& name) const;
    /// Index of the link below the joint of that name, or kNone.
    [[nodiscard]] std::int32_t findJoint(const std::string& name) const;
};

/// Pose of the link in its parent at joint position `q` [rad or m]. For a spherical joint it is the
/// pose without rotation of the joint.
[[nodiscard]] BULLET_CCD_API Eigen::Isometry3d linkInParent(const Link& link, double q);

/// Poses of all links in W, one entry per link.
/// @param X_WR      pose of the root
/// @param positions one entry per link [rad or m]; the entries of mimic joints are used as they are
///                  (see applyMimics())
[[nodiscard]] BULLET_CCD_API std::vector<Eigen::Isometry3d> linkPoses(
    const KinematicTree& tree, const Eigen::Isometry3d& X_WR, std::span<const double> positions);

/// Sets the position of every mimic joint from the joint that it follows.
/// @param positions one entry per link [rad or m]
BULLET_CCD_API void applyMimics(const KinematicTree& tree, std::span<double> positions);

/// True if `ancestor` is `link` or lies between it and the root, inclusive.
[[nodiscard]] BULLET_CCD_API bool isAncestorOrSelf(const KinematicTree& tree,
                                                   std::int32_t ancestor,
                                                   std::int32_t link);

// Motion of a kinematic tree over a step. Time t runs over [0, 1]. Joint positions change
// linearly, q(t) = q0 + t * rate, or as polynomials, and the root moves rigidly.

/// What holds of a path at all times of the step, rounded outwards.
struct JointPathBounds
{
    double lowestRate = 0.0;  ///< of the velocity
    double highestRate = 0.0;
    double bend = 0.0;   ///< of the size of the acceleration; 0 if the path is linear
    double reach = 0.0;  ///< of the size of the position

    [[nodiscard]] double speed() const
    {
        return highestRate > -lowestRate ? highestRate : -lowestRate;
    }
};

/// Position of one joint over a step, q(t) = sum_k c[k] t^k for t in [0, 1], in [rad] or [m]: a
/// polynomial of fifth degree at most. That covers lines, the cubics through positions and
/// velocities, the quintics through accelerations too, and the pieces of B-splines.
struct BULLET_CCD_API JointPath
{
    std::array<double, 6> c{};

    [[nodiscard]] bool isLinear() const
    {
        return c[2] == 0.0 && c[3] == 0.0 && c[4] == 0.0 && c[5] == 0.0;
    }
    [[nodiscard]] bool isConstant() const { return c[1] == 0.0 && isLinear(); }

    [[nodiscard]] double at(double t) const
    {
        return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
    }
    /// Velocity [rad or m per step].
    [[nodiscard]] double rateAt(double t) const
    {
        return c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * (4.0 * c[4] + t * (5.0 * c[5]))));
    }

    /// The part of the path from `begin` to `end` as a path over [0, 1].
    [[nodiscard]] JointPath partOf(double begin, double end) const;

    /// Guarantee: the bounds hold on [0, 1]. They are exact for linear paths; for others they are
    /// those of the Bernstein coefficients of each half of the step.
    [[nodiscard]] JointPathBounds bounds() const;
};

/// Motion of a spherical joint over the step: X_PL(t) = X_PL0 exp(t [rate]) start. The joint turns
/// about an axis at rest in the parent, at constant speed, by any number of revolutions.
struct BallMotion
{
    Eigen::Matrix3d start = Eigen::Matrix3d::Identity();  ///< rotation at t = 0
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();       ///< [rad per step], axes of X_PL0
};

/// The turn by the shortest arc from one rotation to another. The sense of a half turn is that of
/// motionBetween().
[[nodiscard]] BULLET_CCD_API BallMotion ballBetween(const Eigen::Matrix3d& start,
                                                    const Eigen::Matrix3d& end);

/// What the position of a joint has beyond position + t rate: coefficients of t^2 to t^5.
using JointCurve = std::array<double, 4>;

/// Motion of the root and of all joints.
struct JointMotion
{
    RigidMotion root;               ///< motion of link 0
    std::vector<double> positions;  ///< at t = 0, one entry per link
    /// Velocities at t = 0 [per step], one entry per link (mimic joints too): the change over the
    /// step where there are no curves.
    std::vector<double> rates;
    /// One entry per link, used for spherical joints; may be empty if there are none.
    std::vector<BallMotion> balls{};
    /// One entry per link, not used for spherical joints; empty if all positions are linear.
    std::vector<JointCurve> curves{};

    /// @pre the joint above `link` is spherical
    [[nodiscard]] const BallMotion& ball(std::int32_t link) const
    {
        return balls[static_cast<std::size_t>(link)];
    }
    /// The position of the joint above `link`, which is not spherical.
    [[nodiscard]] JointPath path(std::int32_t link) const
    {
        const auto i = static_cast<std::size_t>(link);
        JointPath path{{positions[i], rates[i]}};
        if (!curves.empty())
        {
            std::copy(curves[i].begin(), curves[i].end(), path.c.begin() + 2);
        }
        return path;
    }
    /// Sets it. With curves empty, the path has to be linear.
    void setPath(std::int32_t link, const JointPath& path)
    {
        const auto i = static_cast<std::size_t>(link);
        positions[i] = path.c[0];
        rates[i] = path.c[1];
        if (!curves.empty())
        {
            std::copy(path.c.begin() + 2, path.c.end(), curves[i].begin());
        }
    }
};

/// The part of the motion from `begin` to `end` as a motion over [0, 1].
[[nodiscard]] BULLET_CCD_API JointMotion partOf(const JointMotion& motion,
                                                double begin,
                                                double end);

/// Pose and velocity of the link at time t as seen from `base`: in that link's frame, or in W if
/// `base` is kNone.
/// @pre base is kNone or an ancestor of `link` (or itself)
[[nodiscard]] BULLET_CCD_API MotionState linkStateAt(const KinematicTree& tree,
                                                     const JointMotion& motion,
                                                     std::int32_t base,
                                                     std::int32_t link,
                                                     double t);

/// Bound of the acceleration of points of the link relative to `base`.
///
/// Guarantee: the bound holds at every time of the step.
/// Source: it is the sum of |q'_j| |q'_k| reach over all pairs of joints between the two and of
/// |q''_k| reach, which bounds the second derivative of a point of a chain
/// (bullet_ccd/toi/README.md, "Articulated bodies").
[[nodiscard]] BULLET_CCD_API AccelerationBound linkAccelerationBound(const KinematicTree& tree,
                                                                     const JointMotion& motion,
                                                                     std::int32_t base,
                                                                     std::int32_t link);

/// The deepest link that is an ancestor of both links; a link counts as its own ancestor.
[[nodiscard]] BULLET_CCD_API std::int32_t commonAncestor(const KinematicTree& tree,
                                                         std::int32_t linkA,
                                                         std::int32_t linkB);

/// True if a joint that does not rest lies between `base` (exclusive) and `link` (inclusive), or
/// `base` is kNone and the root moves.
[[nodiscard]] BULLET_CCD_API bool moves(const KinematicTree& tree,
                                        const JointMotion& motion,
                                        std::int32_t base,
                                        std::int32_t link);
}  // namespace bullet_ccd
