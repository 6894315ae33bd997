/// Pictures of what continuous collision detection works with, as lines of a btIDebugDraw.
#ifndef BT_CCD_DEBUG_DRAW_H
#define BT_CCD_DEBUG_DRAW_H

#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"

#include <LinearMath/btIDebugDraw.h>

/// A shape's model and a pose of the shape in the world.
struct btCcdPosedModel
{
    const btCcdShapeModel& m_model;
    btTransform m_pose;
};

/// Wire boxes around the bounding volumes that are `level` below the roots of all parts (0: the
/// roots), and around leaves that end above it: together they enclose the shape.
void btCcdDrawHierarchy(const btCcdPosedModel& posed, int level, btIDebugDraw& draw);

/// Wire box of what a collider passes through in a step, in the axes of the world.
void btCcdDrawSweptBox(const btVector3& low, const btVector3& high, btIDebugDraw& draw);

/// Two colliders at their time of impact: the root volumes of both at the poses they have then, the
/// closest points as crosses, and from the point on A the normal, unit from A to B, drawn a quarter
/// as long as the smaller of them reaches.
void btCcdDrawImpact(const btCcdPosedModel& a,
                     const btVector3& pointA,
                     const btCcdPosedModel& b,
                     const btVector3& pointB,
                     const btVector3& normal,
                     btIDebugDraw& draw);

/// The way of a node of a soft body in a step.
void btCcdDrawPath(const btVector3& from, const btVector3& to, btIDebugDraw& draw);

/// A contact of a soft body: the closest points of both, and from the point on A the normal, unit
/// from A to B, drawn as long as said.
void btCcdDrawSoftContact(const btVector3& pointA,
                          const btVector3& pointB,
                          const btVector3& normal,
                          btScalar length,
                          btIDebugDraw& draw);

#endif  // BT_CCD_DEBUG_DRAW_H
