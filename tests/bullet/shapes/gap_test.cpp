/// The lower bound of the distance of two shapes that most pairs are sorted out by.
#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/shapes/btCcdGap.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// The bound is lower by the rounding of poses some metres away.
constexpr double kRound = sizeof(btScalar) == 8 ? 1e-10 : 1e-3;

std::vector<std::unique_ptr<btConvexInternalShape>> someShapes()
{
    std::vector<std::unique_ptr<btConvexInternalShape>> shapes;
    shapes.push_back(std::make_unique<btBoxShape>(vec(0.1, 0.5, 1.0)));
    shapes.push_back(std::make_unique<btSphereShape>(btScalar(0.4)));
    shapes.push_back(std::make_unique<btCapsuleShape>(btScalar(0.1), btScalar(1.0)));
    shapes.push_back(std::make_unique<btCylinderShape>(vec(0.2, 0.6, 0.2)));
    return shapes;
}

/// Points of the surface, in the world.
std::vector<btVector3> surface(const btConvexInternalShape& shape,
                               const btTransform& pose,
                               Random& random)
{
    std::vector<btVector3> points;
    for (int i = 0; i < 60; ++i)
    {
        points.push_back(pose * shape.localGetSupportingVertex(btCcdToBullet(random.direction())));
    }
    return points;
}

double nearest(const std::vector<btVector3>& a, const std::vector<btVector3>& b)
{
    double least = 1e30;
    for (const btVector3& p : a)
    {
        for (const btVector3& q : b)
        {
            least = std::min(least, double(p.distance(q)));
        }
    }
    return least;
}
}  // namespace

TEST(Gap, IsNeverMoreThanTheDistanceOfAnyTwoPoints)
{
    Random random(7);
    const auto shapes = someShapes();
    int positive = 0;
    for (int i = 0; i < 2000; ++i)
    {
        const btConvexInternalShape& a = *shapes[std::size_t(i) % shapes.size()];
        const btConvexInternalShape& b = *shapes[std::size_t(i / 4) % shapes.size()];
        const btTransform poseA = btCcdToBullet(random.pose(1.5));
        const btTransform poseB = btCcdToBullet(random.pose(1.5));
        const double gap = btCcdGap(btCcdExtentOf(a), poseA, btCcdExtentOf(b), poseB);
        EXPECT_LE(gap, nearest(surface(a, poseA, random), surface(b, poseB, random)) + kRound);
        positive += gap > 0.0 ? 1 : 0;
    }
    EXPECT_GT(positive, 500);  // else the bound would be of no use
}

TEST(Gap, IsTheDistanceOfBoxesFaceToFaceAndOfASphereAboveAPlane)
{
    const btBoxShape box(vec(0.5, 0.5, 0.5));
    const btCcdExtent extent = btCcdExtentOf(box);
    EXPECT_NEAR(
        btCcdGap(extent, poseAt(vec(0, 0, 0)), extent, poseAt(vec(3, 0.2, 0))), 2.0, kRound);

    const btStaticPlaneShape plane(vec(0, 1, 0), btScalar(0.25));
    const btSphereShape sphere(btScalar(0.5));
    const btTransform raised = poseAt(vec(0, 1, 0));
    const btTransform above = poseAt(vec(40, 3, -7));
    EXPECT_NEAR(btCcdGap(btCcdExtentOf(plane), raised, btCcdExtentOf(sphere), above), 1.25, kRound);
    EXPECT_NEAR(btCcdGap(btCcdExtentOf(sphere), above, btCcdExtentOf(plane), raised), 1.25, kRound);
    EXPECT_LT(btCcdGap(btCcdExtentOf(plane), raised, btCcdExtentOf(plane), above), 0.0);
}

TEST(Gap, OfAScaledPoseIsNotKnown)
{
    const btSphereShape sphere(btScalar(0.5));
    const btStaticPlaneShape plane(vec(0, 1, 0), btScalar(0));
    const btTransform here = poseAt(vec(0, 3, 0));
    for (const double scale : {0.5, 2.0})
    {
        btTransform scaled = here;
        scaled.setBasis(btMatrix3x3::getIdentity().scaled(vec(scale, 1, scale)));
        EXPECT_FALSE(btCcdIsRotation(scaled.getBasis()));
        const btCcdExtent extent = btCcdExtentOf(sphere);
        const btTransform far = poseAt(vec(9, 3, 0));
        EXPECT_LT(btCcdGap(extent, scaled, extent, far), 0.0);
        EXPECT_LT(btCcdGap(extent, far, extent, scaled), 0.0);
        EXPECT_LT(btCcdGap(btCcdExtentOf(plane), poseAt(vec(0, 0, 0)), extent, scaled), 0.0);
    }
    EXPECT_TRUE(btCcdIsRotation(btMatrix3x3(btQuaternion(vec(0.6, 0, 0.8), btScalar(1.0)))));
    EXPECT_FALSE(btCcdIsRotation(btMatrix3x3(1, 0, 0, btScalar(0.6), btScalar(0.8), 0, 0, 0, 1)));
}

TEST(Gap, OfWhatOverlapsIsNotPositive)
{
    const btBoxShape box(vec(0.5, 0.5, 0.5));
    const btCcdExtent extent = btCcdExtentOf(box);
    EXPECT_LE(btCcdGap(extent, poseAt(vec(0, 0, 0)), extent, poseAt(vec(0, 0, 0))), 0.0);
    EXPECT_LE(btCcdGap(extent, poseAt(vec(0, 0, 0)), extent, poseAt(vec(0.9, 0, 0))), 0.0);
}
}  // namespace bullet_ccd::tests
