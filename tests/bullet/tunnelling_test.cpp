#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "tests/bullet/scene.h"
#include "tests/oracles/brute_force_distance.h"
#include "tests/support/shapes.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace bullet_ccd::tests
{
namespace
{
// A link of 60 x 2 x 10 mm, hinged at the origin, swings down on a plate 0.5 mm thick that stands
// 45 degrees below the x-axis.
const Eigen::Vector3d kLinkHalf(0.03, 0.001, 0.005);
const Eigen::Vector3d kPlateHalf(0.03, 0.00025, 0.03);
constexpr double kPlateAngle = -std::numbers::pi / 4;
constexpr int kPhases = 20;

/// What the link and the plate are made of.
enum class Shapes
{
    Boxes,       ///< stock boxes
    MeshOnBox,   ///< our mesh on a stock box
    MeshOnMesh,  ///< two of our meshes
    MeshOnBvh,   ///< our mesh on Bullet's static triangle mesh
};

struct Swing
{
    const char* name;
    double timeStep;
    double rate;  // [rad/s]
};
constexpr Swing kSwings[] = {
    {"20 mm a step", 1.0 / 60.0, 20.0},
    {"37 mm a step", 1.0 / 240.0, 150.0},
    {"60 mm a step", 1.0 / 60.0, 60.0},
    {"150 mm a step", 1.0 / 60.0, 150.0},
};

btTransform platePose()
{
    return poseAt(vec(0.06 * std::cos(kPlateAngle), 0.06 * std::sin(kPlateAngle), 0.0),
                  kPlateAngle);
}

btCollisionShape* plate(Scene& scene, Shapes shapes)
{
    const btVector3 half = btCcdToBullet(kPlateHalf);
    switch (shapes)
    {
        case Shapes::MeshOnMesh:
            return scene.boxMesh(half);
        case Shapes::MeshOnBvh:
        {
            static const auto triangles = []
            {
                auto mesh = std::make_unique<btTriangleMesh>();
                const TriangleMesh box = makeBox(kPlateHalf);
                for (const Triangle& t : box.triangles)
                {
                    mesh->addTriangle(btCcdToBullet(box.vertices[std::size_t(t[0])]),
                                      btCcdToBullet(box.vertices[std::size_t(t[1])]),
                                      btCcdToBullet(box.vertices[std::size_t(t[2])]));
                }
                return mesh;
            }();
            return scene.keep(std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true));
        }
        default:
            return scene.box(half);
    }
}

/// Smallest distance on the way between two joint positions, by brute force.
double gapOnTheWay(double from, double to)
{
    const TriangleMesh link = shifted(makeBox(kLinkHalf), {kLinkHalf.x(), 0.0, 0.0});
    const TriangleMesh obstacle = makeBox(kPlateHalf);
    const Eigen::Isometry3d X_WP = btCcdToEigen(platePose());
    double gap = 1.0;
    // 1 mm of the tip between samples: the plate and the link together are thicker.
    const int samples = 1 + int(std::abs(to - from) * 0.06 / 0.001);
    for (int i = 0; i <= samples; ++i)
    {
        const double q = from + (to - from) * i / samples;
        if (q > -0.6)
        {
            continue;  // more than 5 mm away
        }
        const Eigen::Isometry3d X_PL = X_WP.inverse() * poseOf(Eigen::Vector3d::Zero(), q);
        gap = std::min(gap, bruteForceMeshDistance(link, obstacle, X_PL).distance);
    }
    return gap;
}

struct Outcome
{
    bool through = false;
    double gap = 1.0;     ///< smallest on all of the way
    double lowest = 1.0;  ///< joint position
};

Outcome swing(Kind kind, Shapes shapes, const Swing& swing, int phase, bool checkWay)
{
    Scene scene(kind);
    scene.body(plate(scene, shapes), 0.0, platePose());
    const btVector3 half = btCcdToBullet(kLinkHalf);
    btCollisionShape* link = shapes == Shapes::Boxes
                                 ? static_cast<btCollisionShape*>(scene.box(half))
                                 : static_cast<btCollisionShape*>(scene.boxMesh(half));
    btMultiBody* body = scene.chain({link}, kLinkHalf.x(), btTransform::getIdentity());
    const double spread = std::min(swing.rate * swing.timeStep, 0.9);
    body->setJointPos(0, btScalar(0.3 - spread * phase / kPhases));
    body->setJointVel(0, btScalar(-swing.rate));
    Scene::placeColliders(*body);

    Outcome outcome;
    const int steps = int(1.6 / (swing.rate * swing.timeStep)) + 4;
    for (int i = 0; i < steps && !outcome.through; ++i)
    {
        const double before = double(body->getJointPos(0));
        scene.step(swing.timeStep);
        const double after = double(body->getJointPos(0));
        outcome.lowest = std::min(outcome.lowest, after);
        // Beyond, the middle of the link has passed the middle of the plate.
        outcome.through = after < kPlateAngle - 0.045;
        if (checkWay)
        {
            outcome.gap = std::min(outcome.gap, gapOnTheWay(before, after));
        }
    }
    return outcome;
}

std::string nameOf(const testing::TestParamInfo<Shapes>& test)
{
    constexpr const char* kNames[] = {"Boxes", "MeshOnBox", "MeshOnMesh", "MeshOnBvh"};
    return kNames[static_cast<std::size_t>(test.param)];
}
}  // namespace

TEST(Tunnelling, StockWorldLosesTheSwingingLink)
{
    int through = 0;
    int runs = 0;
    for (const Swing& each : kSwings)
    {
        for (int phase = 0; phase < kPhases; ++phase)
        {
            through += swing(Kind::Stock, Shapes::Boxes, each, phase, false).through ? 1 : 0;
            ++runs;
        }
    }
    // The control: without this share of losses the tests below would prove nothing.
    EXPECT_GT(through, runs / 2);
}

class SwingingLink : public testing::TestWithParam<Shapes>
{
};

TEST_P(SwingingLink, NeverPassesThePlate)
{
    for (const Swing& each : kSwings)
    {
        for (int phase = 0; phase < kPhases; ++phase)
        {
            const Outcome outcome = swing(Kind::Ccd, GetParam(), each, phase, true);
            const std::string where = std::string(each.name) + ", phase " + std::to_string(phase);
            EXPECT_FALSE(outcome.through) << where;
            // It did come near: nothing invisible stopped it.
            EXPECT_LT(outcome.lowest, -0.70) << where;
            if (GetParam() == Shapes::Boxes)
            {
                // Stock boxes in contact are left to Bullet's solver, which lets them touch.
                EXPECT_GT(outcome.lowest, kPlateAngle) << where;
            }
            else
            {
                EXPECT_GT(outcome.gap, 1e-5) << where;
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Tunnelling,
    SwingingLink,
    testing::Values(Shapes::Boxes, Shapes::MeshOnBox, Shapes::MeshOnMesh, Shapes::MeshOnBvh),
    nameOf);

namespace
{
/// A box of 10 mm, spinning, flies at the plate. Returns how far it gets beyond it.
double shoot(Kind kind, bool meshes, double speed, int phase)
{
    Scene scene(kind);
    const btVector3 half = vec(0.05, 0.05, 0.00025);
    const btVector3 small = vec(0.005, 0.005, 0.005);
    const auto shape = [&](const btVector3& extents) -> btCollisionShape*
    {
        return meshes ? static_cast<btCollisionShape*>(scene.boxMesh(extents))
                      : static_cast<btCollisionShape*>(scene.box(extents));
    };
    scene.body(shape(half), 0.0, poseAt(vec(0, 0, 0)));
    btRigidBody* box =
        scene.body(shape(small), 0.02, poseAt(vec(0, 0, 0.1 + 0.04 * phase / kPhases)));
    box->setLinearVelocity(vec(0.02, 0, -speed));
    box->setAngularVelocity(vec(3, 20, 5));
    double lowest = 1.0;
    for (int i = 0; i < int(0.2 * 240 / speed) + 12; ++i)
    {
        scene.step(1.0 / 240.0);
        lowest = std::min(lowest, double(box->getWorldTransform().getOrigin().z()));
    }
    return lowest;
}
}  // namespace

TEST(Tunnelling, FreeBodyDoesNotPassTheWall)
{
    int stock = 0;
    for (const double speed : {5.0, 10.0, 40.0})
    {
        for (int phase = 0; phase < kPhases; ++phase)
        {
            stock += shoot(Kind::Stock, false, speed, phase) < 0.0 ? 1 : 0;
            for (const bool meshes : {false, true})
            {
                // The centre stays half an edge away; stock boxes may sink in, not to their cores.
                EXPECT_GT(shoot(Kind::Ccd, meshes, speed, phase), meshes ? 0.005 : 0.003)
                    << speed << " m/s, phase " << phase;
            }
        }
    }
    EXPECT_GT(stock, 3 * kPhases / 2) << "the control is vacuous";
}
}  // namespace bullet_ccd::tests
