#include "bullet_ccd/bullet/shapes/btCcdGap.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <algorithm>
#include <cmath>

namespace
{
/// Poses are known so well only, relative to where things are: what two gaps may be off.
constexpr double kGapRounding = sizeof(btScalar) == 8 ? 1e-12 : 1e-5;
/// What the squares of lengths in a rotation may be off 1.
constexpr btScalar kStretch = btScalar(1e-3);

bool isPlane(const btCcdExtent& extent)
{
    return !extent.m_normal.isZero();
}

/// How far the box reaches in a direction, from its center.
btScalar reachAlong(const btCcdExtent& box, const btMatrix3x3& basis, const btVector3& direction)
{
    return (direction * basis).absolute().dot(box.m_half);
}

btScalar largest(const btVector3& v)
{
    return std::max(std::max(v.x(), v.y()), v.z());
}

/// True if the rows have unit lengths.
bool keepsLengths(const btMatrix3x3& basis)
{
    const auto isUnit = [](const btVector3& row)
    { return btFabs(row.length2() - btScalar(1)) <= kStretch; };
    return isUnit(basis[0]) && isUnit(basis[1]) && isUnit(basis[2]);
}

double gapToPlane(const btCcdExtent& plane,
                  const btTransform& planePose,
                  const btCcdExtent& box,
                  const btTransform& boxPose)
{
    const btVector3 normal = planePose.getBasis() * plane.m_normal;
    const btVector3 center = boxPose * box.m_center - planePose.getOrigin();
    return double(normal.dot(center) - plane.m_offset -
                  reachAlong(box, boxPose.getBasis(), normal));
}
}  // namespace

bool btCcdIsRotation(const btMatrix3x3& basis)
{
    return keepsLengths(basis) && btFabs(basis[0].dot(basis[1])) <= kStretch &&
           btFabs(basis[1].dot(basis[2])) <= kStretch && btFabs(basis[2].dot(basis[0])) <= kStretch;
}

btCcdExtent btCcdExtentOf(const btCollisionShape& shape)
{
    btCcdExtent extent;
    if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE)
    {
        const auto& plane = static_cast<const btStaticPlaneShape&>(shape);
        extent.m_normal = plane.getPlaneNormal();
        extent.m_offset = plane.getPlaneConstant();
        return extent;
    }
    btVector3 low;
    btVector3 high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    extent.m_center = btScalar(0.5) * (low + high);
    extent.m_half = btScalar(0.5) * (high - low);
    return extent;
}

double btCcdGap(const btCcdExtent& a,
                const btTransform& poseA,
                const btCcdExtent& b,
                const btTransform& poseB,
                double enough)
{
    const double rounding =
        kGapRounding * double(poseA.getOrigin().absolute().dot({1, 1, 1}) +
                              poseB.getOrigin().absolute().dot({1, 1, 1}) +
                              a.m_half.dot({1, 1, 1}) + b.m_half.dot({1, 1, 1}));
    if (isPlane(a) || isPlane(b))
    {
        return isPlane(a) && isPlane(b)                                                   ? -1.0
               : !btCcdIsRotation(poseA.getBasis()) || !btCcdIsRotation(poseB.getBasis()) ? -1.0
               : isPlane(a) ? gapToPlane(a, poseA, b, poseB) - rounding
                            : gapToPlane(b, poseB, a, poseA) - rounding;
    }
    // Along the axes of both boxes and the line of their centers, all in A's frame.
    const btMatrix3x3 R_AB = poseA.getBasis().transposeTimes(poseB.getBasis());
    if (!keepsLengths(R_AB)) [[unlikely]]
    {
        return -1.0;
    }
    const btVector3 between_A = (poseB * b.m_center - poseA * a.m_center) * poseA.getBasis();
    const btVector3 farA = between_A.absolute();
    const btMatrix3x3 turn = R_AB.absolute();
    btScalar gap = largest(farA - a.m_half - turn * b.m_half);
    if (double(gap) - rounding > enough)
    {
        return double(gap) - rounding;
    }
    const btVector3 farB = (between_A * R_AB).absolute();
    gap = std::max(gap, largest(farB - b.m_half - a.m_half * turn));
    const btScalar distance = between_A.length();
    if (distance > btScalar(0))
    {
        gap = std::max(gap, distance - (farA.dot(a.m_half) + farB.dot(b.m_half)) / distance);
    }
    return double(std::max(gap, btScalar(-1))) - rounding;
}
