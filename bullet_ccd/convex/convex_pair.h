/// Two moving cores: where they are, and the gap between them along a direction that may turn.
///
/// All vectors are in W's axes. D(t) = D0 + t V leads from A's reference point to B's; both bodies
/// turn about their reference points.
#pragma once

#include "bullet_ccd/convex/certified_root.h"
#include "bullet_ccd/convex/closest_points.h"
#include "bullet_ccd/convex/turn.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <Eigen/Geometry>

#include <cstdint>

namespace bullet_ccd
{
struct ConvexBody;

/// Both bodies at one time.
struct ConvexPlaces
{
    double t = 0.0;
    MatrixNumbers axesA;  ///< of A's shape
    MatrixNumbers axesB;
    Eigen::Vector3d D = Eigen::Vector3d::Zero();
    Placement X_BA;  ///< A's core in the frame of B's

    [[nodiscard]] Eigen::Map<const Eigen::Matrix3d> RA() const
    {
        return Eigen::Map<const Eigen::Matrix3d>(axesA.data());
    }
    [[nodiscard]] Eigen::Map<const Eigen::Matrix3d> RB() const
    {
        return Eigen::Map<const Eigen::Matrix3d>(axesB.data());
    }
};

/// What the balls around two moving cores depend on. Most queries end with these.
struct ConvexCourse
{
    const ConvexShape* shapeA = nullptr;
    const ConvexShape* shapeB = nullptr;
    Eigen::Vector3d armA = Eigen::Vector3d::Zero();  ///< from reference to shape, in its own axes
    Eigen::Vector3d armB = Eigen::Vector3d::Zero();
    bool isPlainA = true;  ///< see isPlain()
    bool isPlainB = true;
    bool hasArms = false;  ///< a shape is not centred at its reference
    Eigen::Vector3d D0 = Eigen::Vector3d::Zero();
    Eigen::Vector3d V = Eigen::Vector3d::Zero();
    double reachA = 0.0;  ///< farthest point of the core from the reference
    double reachB = 0.0;
    double farthest = 0.0;  ///< |D(t)| at most
    double sizes = 0.0;     ///< of all that is added up to a gap

    ConvexCourse(const ConvexBody& bodyA, const ConvexBody& bodyB);
};

/// Whether the axes and the origin of the shape are those of its body.
[[nodiscard]] bool isPlain(const ConvexBody& body);

struct ConvexPair : ConvexCourse
{
    Spin spinA;
    Spin spinB;
    TurnedAxes axesA;  ///< of the shapes
    TurnedAxes axesB;
    double spread = 0.0;    ///< bound of the acceleration, per distance from the reference, with
                            ///< which one body is seen to turn from the other
    double speed = 0.0;     ///< |V|
    double rounding = 0.0;  ///< of a gap, at all times of the step

    ConvexPair(const ConvexCourse& course, const ConvexBody& bodyA, const ConvexBody& bodyB);

    void at(double t, ConvexPlaces& places) const;
};

/// A unit direction n, and how it turns from then on.
struct TurningDirection
{
    enum class With : std::uint8_t
    {
        BodyA,
        BodyB,
        Itself,  ///< at the angular velocity w
    };

    Eigen::Vector3d n = Eigen::Vector3d::UnitX();
    Eigen::Vector3d n_B = Eigen::Vector3d::UnitX();  ///< the same in the axes of B
    With with = With::Itself;
    Eigen::Vector3d w = Eigen::Vector3d::Zero();  ///< [rad per step]; used for Itself only
};

/// The gap of two cores along a direction that turns, as a function of time,
///     G(t) = n(t) . D(t) - max_{a in A} n(t) . a(t) + min_{b in B} n(t) . b(t).
///
/// G is semi-concave: G(t) - bend t^2 / 2 is concave, because G is a minimum of smooth functions,
/// one for each pair of points, whose second derivatives are at most `bend`. So between two times
/// G is not below its chord by more than bend s (S - s) / 2, which needs no derivative and no
/// knowledge of which points are nearest.
class GapAlong
{
public:
    /// The direction is that at the time of `places`, which this refers to.
    GapAlong(const ConvexPair& pair, const ConvexPlaces& places, const TurningDirection& direction);

    [[nodiscard]] double gap() const { return m_gap; }  ///< at the time of the places
    /// Derivative there, for the points that are then nearest along the direction.
    [[nodiscard]] double rate() const { return m_rate; }
    [[nodiscard]] double gapAt(double t) const;
    [[nodiscard]] double bend() const { return m_bend; }

private:
    const ConvexPair& m_pair;
    const ConvexPlaces& m_places;
    TurningDirection::With m_with;
    Eigen::Vector3d m_n;    ///< at the time of the places; in W's axes
    double m_height = 0.0;  ///< of the body with which the direction turns
    Spin m_spin;            ///< of a direction that turns with itself
    double m_gap = 0.0;
    double m_rate = 0.0;
    double m_bend = 0.0;
};
}  // namespace bullet_ccd
