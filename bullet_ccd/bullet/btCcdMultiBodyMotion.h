/// A btMultiBody as a kinematic tree of the core, and its motion over a step.
///
/// Bullet's link frame sits at the centre of mass, turned with the link; the core's link frame has
/// the same axes and its origin on the joint (the pivot). So a point p of Bullet's link frame i is
/// p + m_dVector in the core's frame of link i + 1, and the core's link 0 is Bullet's base.
/// The forward kinematics is the core's, over Bullet's public link data: Bullet's own prediction of
/// link poses is wrong for revolute joints that are off their parent's centre of mass.
#ifndef BT_CCD_MULTI_BODY_MOTION_H
#define BT_CCD_MULTI_BODY_MOTION_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/motion/joint_motion.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>

struct btCcdMultiBodyMotion
{
    bullet_ccd::KinematicTree m_tree;
    bullet_ccd::JointMotion m_motion;

    /// Pose of Bullet's frame of `link` (-1: the base) in the core's frame of link + 1.
    Eigen::Isometry3d bulletFrame(const btMultiBody& body, int link) const;
};

/// True if all joints are revolute, prismatic or fixed and positions are integrated by Bullet's
/// default scheme (not Runge-Kutta, which is not linear in time).
bool btCcdIsCovered(const btMultiBody& body);

/// True if a step of the world moves the body: it is awake.
bool btCcdIsStepped(const btMultiBody& body);

/// Tree and motion over `timeStep` at the velocities that the body has now: what the world's
/// integrateTransforms() will do. Links of static or kinematic colliders keep their joint.
/// @pre btCcdIsCovered(body)
void btCcdReadMotion(const btMultiBody& body, btScalar timeStep, btCcdMultiBodyMotion& motion);

#endif  // BT_CCD_MULTI_BODY_MOTION_H
