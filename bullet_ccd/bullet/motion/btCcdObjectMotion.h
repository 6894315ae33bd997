/// How one collision object moves over a time step, as the core's queries take it.
#ifndef BT_CCD_OBJECT_MOTION_H
#define BT_CCD_OBJECT_MOTION_H

#include "bullet_ccd/bullet/motion/btCcdMultiBodyMotion.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

class btMultiBodyLinkCollider;

struct btCcdObjectMotion
{
    std::variant<bullet_ccd::RigidMotion, bullet_ccd::LinkMotion> m_motion;
    Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();  ///< frame of the shape in the body's
    /// Bound of what any point of a link moves [m].
    double m_way = std::numeric_limits<double>::infinity();

    /// A mesh of the shape, as it moves.
    [[nodiscard]] bullet_ccd::MovingBody body(const bullet_ccd::SsvTree& tree,
                                              const Eigen::Isometry3d& X_SG) const;
    [[nodiscard]] bool isFinite() const;
    /// A box in the world that a ball about a point of the shape's frame stays in.
    [[nodiscard]] Eigen::AlignedBox3d boxOf(const Eigen::Vector3d& center_S, double radius) const;
    /// Bound of what a point of the world moves as seen from the shape, if it is within this
    /// distance of the shape's origin.
    [[nodiscard]] double wayAt(double distance) const;
};

/// Who knows how objects move while a world is in the middle of its step.
struct btCcdMotionSource
{
    virtual ~btCcdMotionSource() = default;
    /// Null for objects that are not its own. Valid until the next call that changes the time.
    virtual const btCcdObjectMotion* motionOf(const btCollisionObject& object) = 0;
};

/// Pose of the shape's frame at time t.
[[nodiscard]] Eigen::Isometry3d btCcdShapePoseAt(const btCcdObjectMotion& motion, double t);

/// The motion of an object that is no link, over the last `part` of a step at its velocity. With
/// `start` = -1 that part of the motion that has just ended where the object is now, turned no
/// further than Bullet does in one call (btCcdTurn). Sleeping, static and kinematic objects are at
/// rest.
[[nodiscard]] bullet_ccd::RigidMotion btCcdRigidMotion(const btCollisionObject& object,
                                                       double timeStep,
                                                       double part,
                                                       double start);

/// The motion of a link's collider in a motion of its multibody, which must outlive the result.
[[nodiscard]] btCcdObjectMotion btCcdLinkMotion(const btMultiBodyLinkCollider& collider,
                                                const btCcdMultiBodyMotion& links);

/// Bounds, over a step of any length up to `timeStep`, of the speed of the origin of every link's
/// frame [m/s] and of its angular speed [rad/s]: two numbers a link, the base first.
void btCcdReadSpeeds(const btMultiBody& body, double timeStep, std::vector<double>& speeds);

/// From the world transform to the interpolation transform: what Bullet means by the motion of an
/// object outside of a step.
[[nodiscard]] bullet_ccd::RigidMotion btCcdInterpolatedMotion(const btCollisionObject& object);

#endif  // BT_CCD_OBJECT_MOTION_H
