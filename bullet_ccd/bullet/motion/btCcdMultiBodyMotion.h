/// A btMultiBody as a kinematic tree of the core, and its motion over a step.
///
/// Bullet's link frame sits at the centre of mass, turned with the link; the core's link frame has
/// the same axes and its origin on the joint (the pivot). So a point p of Bullet's link frame is
/// p + m_dVector in the core's frame. The forward kinematics is the core's, over Bullet's public
/// link data: Bullet's own prediction of link poses is wrong for revolute joints that are off their
/// parent's centre of mass.
///
/// Joints of several degrees of freedom over one step: Bullet turns a spherical joint at a constant
/// angular velocity in the link, so it is a hinge about that axis, from the present orientation. A
/// planar joint turns, and drifts at a constant velocity in the turning frame: a hinge with a
/// slider on it, two links of the core.
#ifndef BT_CCD_MULTI_BODY_MOTION_H
#define BT_CCD_MULTI_BODY_MOTION_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/motion/kinematic_tree.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>

#include <cstdint>
#include <vector>

struct btCcdMultiBodyMotion
{
    bullet_ccd::KinematicTree m_tree;
    bullet_ccd::JointMotion m_motion;
    std::vector<std::int32_t> m_coreLinks;  ///< by Bullet's link + 1, the base first

    /// Link of m_tree that is Bullet's `link` (-1: the base).
    std::int32_t coreLink(int link) const { return m_coreLinks[std::size_t(link + 1)]; }
    /// Pose of Bullet's frame of `link` (-1: the base) in the frame of coreLink(link).
    Eigen::Isometry3d bulletFrame(const btMultiBody& body, int link) const;
};

/// True if positions are integrated by Bullet's default scheme (not Runge-Kutta, which is not
/// linear in time) and the kind of every joint is known.
bool btCcdIsCovered(const btMultiBody& body);

/// True if a step of the world moves the body: it is awake.
bool btCcdIsStepped(const btMultiBody& body);

/// Rotation vector [rad] by which Bullet turns a body (rigid, base or spherical joint) in a step.
/// Above an eighth of a turn it is less than velocity times time: Bullet clamps half of the formula
/// that it integrates with.
Eigen::Vector3d btCcdTurn(const btVector3& angularVelocity, btScalar timeStep);

/// Which part of a step of the world a motion is.
struct btCcdPartOfStep
{
    double m_part = 1.0;      ///< how much of the step, in (0, 1]
    bool m_done = false;      ///< its last part, which ended at the present state; else to come
    bool m_inPieces = false;  ///< integrated in pieces so short that nothing is clamped (btCcdTurn)
};

/// Tree and motion over (a part of) `timeStep` at the velocities that the body has now: what the
/// world's integrateTransforms() will do, or did if it has just been done.
///
/// Poses at a fraction of the step are those of a step shortened to that fraction, unless the base
/// or a spherical joint turns more than an eighth of a turn: then its turn over the whole step is
/// spread evenly.
///
/// Bullet leaves kinematic parts where the user puts them; they are read as moving on at the
/// velocity they have: the base, and links whose ancestors are all kinematic. Other links with a
/// static or kinematic collider keep their joint.
/// @pre btCcdIsCovered(body)
void btCcdReadMotion(const btMultiBody& body,
                     btScalar timeStep,
                     btCcdMultiBodyMotion& motion,
                     const btCcdPartOfStep& which = {});

/// Puts the body where the motion begins, colliders included; velocities stay, and so do kinematic
/// parts.
/// @pre `motion` was read from this body, which has the same joints still
void btCcdPlaceAtStart(btMultiBody& body, const btCcdMultiBodyMotion& motion);

#endif  // BT_CCD_MULTI_BODY_MOTION_H
