#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/shapes/btCcdDebugDraw.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/bullet/recording_drawer.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Lines = std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>;

constexpr double kDrawnExactly = kDouble ? 1e-6 : 1e-5;  // the volumes are single precision

/// An oriented box from the twelve edges of its drawing; may be flat.
struct WireBox
{
    Eigen::Vector3d m_center = Eigen::Vector3d::Zero();
    Eigen::Matrix3d m_axes;
    Eigen::Vector3d m_lengths;

    explicit WireBox(const Lines& lines, std::size_t first)
    {
        for (std::size_t i = first; i < first + 12; ++i)
        {
            m_center += (lines[i].first + lines[i].second) / 24.0;
        }
        // The first two edges meet; the fifth leaves their face.
        const auto edge = [&](std::size_t i) -> Eigen::Vector3d
        { return lines[first + i].second - lines[first + i].first; };
        m_axes.col(0) = edge(0).normalized();
        m_axes.col(1) = edge(1).normalized();
        m_axes.col(2) = m_axes.col(0).cross(m_axes.col(1));
        m_lengths = {edge(0).norm(), edge(1).norm(), edge(4).norm()};
    }

    bool contains(const Eigen::Vector3d& point) const
    {
        const Eigen::Vector3d local = m_axes.transpose() * (point - m_center);
        return (local.cwiseAbs().array() <= 0.5 * m_lengths.array() + kDrawnExactly).all();
    }
    double volume() const { return m_lengths.prod(); }
};

std::vector<WireBox> boxesOf(const Lines& lines)
{
    std::vector<WireBox> boxes;
    for (std::size_t first = 0; first + 12 <= lines.size(); first += 12)
    {
        boxes.emplace_back(lines, first);
    }
    return boxes;
}

bool anyContains(const std::vector<WireBox>& boxes, const Eigen::Vector3d& point)
{
    return std::any_of(
        boxes.begin(), boxes.end(), [&](const WireBox& box) { return box.contains(point); });
}

double volumeOf(const std::vector<WireBox>& boxes)
{
    double sum = 0.0;
    for (const WireBox& box : boxes)
    {
        sum += box.volume();
    }
    return sum;
}
}  // namespace

TEST(DebugDraw, BoxesOfEveryLevelEncloseTheShape)
{
    Scene scene(Kind::Stock);
    const TriangleMesh torus = makeTorus(0.05, 0.02, 24, 12);
    btCompoundShape compound;
    compound.addChildShape(poseAt(vec(1, 2, 3), 0.5), scene.mesh(torus));
    btCcdShapeCache cache;
    const btCcdShapeModel& model = *cache.find(&compound);
    const btTransform pose = poseAt(vec(-1, 0.5, 0), 1.0);
    std::vector<double> volumes;
    for (const int level : {0, 1, 2, 4, 6})
    {
        RecordingDrawer drawer;
        btCcdDrawHierarchy({model, pose}, level, drawer);
        ASSERT_EQ(drawer.m_lines.size() % 12, 0U);
        const std::vector<WireBox> boxes = boxesOf(drawer.m_lines);
        EXPECT_TRUE(level > 0 || boxes.size() == 1U);
        volumes.push_back(volumeOf(boxes));
        const Eigen::Isometry3d X_WG = btCcdToEigen(pose * compound.getChildTransform(0));
        for (const Eigen::Vector3d& vertex : torus.vertices)
        {
            EXPECT_TRUE(anyContains(boxes, X_WG * vertex)) << "level " << level;
        }
    }
    EXPECT_LT(volumes.back(), 0.2 * volumes.front()) << "the boxes of finer levels are no smaller";

    // Below the last leaf there is nothing more to draw.
    RecordingDrawer leaves;
    btCcdDrawHierarchy({model, pose}, 100, leaves);
    EXPECT_EQ(leaves.m_lines.size(), 12U * torus.triangles.size());
}

TEST(DebugDraw, ARoundShapeIsEnclosedWithItsRadius)
{
    btCapsuleShape capsule(btScalar(0.1), btScalar(0.4));
    btCcdShapeCache cache;
    const btTransform pose = poseAt(vec(1, 0, 0), SIMD_HALF_PI);
    RecordingDrawer drawer;
    btCcdDrawHierarchy({*cache.find(&capsule), pose}, 0, drawer);
    const std::vector<WireBox> boxes = boxesOf(drawer.m_lines);
    ASSERT_EQ(boxes.size(), 1U);
    Random random(7);
    for (int i = 0; i < 100; ++i)
    {
        const btVector3 n = btCcdToBullet(random.direction());
        EXPECT_TRUE(boxes[0].contains(btCcdToEigen(pose * capsule.localGetSupportingVertex(n))));
    }
    EXPECT_FALSE(boxes[0].contains({1.31, 0, 0}));
    EXPECT_NEAR(boxes[0].volume(), 0.6 * 0.2 * 0.2, 1e-5);
}

TEST(DebugDraw, ASweptBoxIsDrawnAsItIs)
{
    RecordingDrawer drawer;
    btCcdDrawSweptBox(vec(-1, -2, -3), vec(3, 2, 1), drawer);
    ASSERT_EQ(drawer.m_lines.size(), 12U);
    const WireBox box(drawer.m_lines, 0);
    EXPECT_TRUE(box.contains({3, 2, 1}));
    EXPECT_FALSE(box.contains({3.01, 2, 1}));
    EXPECT_NEAR(box.volume(), 4.0 * 4.0 * 4.0, 1e-5);
}

TEST(DebugDraw, AnImpactShowsBothVolumesThePointsAndTheNormal)
{
    btBoxShape large(vec(1, 1, 1));
    btBoxShape small(vec(0.5, 0.5, 0.5));
    btCcdShapeCache cache;
    const btCcdPosedModel a{*cache.find(&large), poseAt(vec(0, 0, 0))};
    const btCcdPosedModel b{*cache.find(&small), poseAt(vec(1.5, 0, 0))};
    RecordingDrawer drawer;
    btCcdDrawImpact(a, vec(1, 0, 0), b, vec(1.001, 0, 0), vec(1, 0, 0), drawer);
    ASSERT_EQ(drawer.m_lines.size(), 12U + 12U + 3U + 3U + 1U);
    EXPECT_TRUE(WireBox(drawer.m_lines, 0).contains({-1, -1, -1}));
    EXPECT_TRUE(WireBox(drawer.m_lines, 12).contains({2, 0.5, 0.5}));
    EXPECT_FALSE(WireBox(drawer.m_lines, 12).contains({0.9, 0, 0}));
    const auto& [from, to] = drawer.m_lines.back();
    EXPECT_LT((from - Eigen::Vector3d(1, 0, 0)).norm(), 1e-6);
    EXPECT_NEAR((to - from).x(), 0.25 * std::sqrt(0.75), 1e-6);
    EXPECT_EQ((to - from).tail<2>().norm(), 0.0);
}

namespace
{
/// What a world draws beyond Bullet's own lines, in that mode.
Lines linesOfOurs(Scene& scene, int mode)
{
    scene.addHooks();
    RecordingDrawer drawer;
    drawer.setDebugMode(mode);
    scene.world().setDebugDrawer(&drawer);
    scene.world().btCollisionWorld::debugDrawWorld();
    const auto own = std::ptrdiff_t(drawer.m_lines.size());
    drawer.m_lines.clear();
    drawer.m_colors.clear();
    scene.world().debugDrawWorld();
    scene.world().setDebugDrawer(nullptr);
    return Lines(drawer.m_lines.begin() + own, drawer.m_lines.end());
}

constexpr std::size_t kBox = 12;
constexpr std::size_t kImpact = 2 * kBox + 3 + 3 + 1;
}  // namespace

TEST(DebugDraw, WorldsAndActionsShowHierarchiesSweptBoxesAndImpacts)
{
    for (const Kind kind : kOurKinds)
    {
        for (const WorldClass worldClass : {WorldClass::Rigid, WorldClass::MultiBody})
        {
            Scene scene(kind, worldClass);
            scene.body(scene.boxMesh(vec(0.5, 0.5, 0.001)), 0.0, poseAt(vec(0, 0, 0)));
            btRigidBody* box =
                scene.body(scene.boxMesh(vec(0.01, 0.02, 0.03)), 0.1, poseAt(vec(0, 0, 0.5)));
            box->setLinearVelocity(vec(1, 0, -30));

            // Nothing has moved yet: a box for each shape.
            EXPECT_EQ(linesOfOurs(scene, btIDebugDraw::DBG_DrawWireframe).size(), 2 * kBox);
            EXPECT_TRUE(linesOfOurs(scene, btIDebugDraw::DBG_NoDebug).empty());
            scene.ccd().setCcdDrawLevel(20);
            EXPECT_EQ(linesOfOurs(scene, btIDebugDraw::DBG_DrawWireframe).size(), 24 * kBox)
                << "every triangle";
            scene.ccd().setCcdDrawLevel(0);

            // 10 cm down: the way is free, and its box is drawn.
            scene.step(0.1 / 30.0);
            const Lines free = linesOfOurs(scene, btIDebugDraw::DBG_DrawWireframe);
            ASSERT_EQ(free.size(), 3 * kBox);
            const WireBox swept(free, 2 * kBox);
            EXPECT_TRUE(swept.contains({0, 0, 0.53}));
            EXPECT_TRUE(swept.contains({0.1 / 30.0, 0, 0.37}));
            EXPECT_FALSE(swept.contains({0, 0, 0.3}));

            // Half a metre: it hits the plate.
            scene.step(0.5 / 30.0);
            const Lines hit = linesOfOurs(scene, btIDebugDraw::DBG_DrawWireframe);
            ASSERT_EQ(hit.size(), 3 * kBox + kImpact);
            // The colliders of an impact are drawn in the order of their age.
            const WireBox plate(hit, 3 * kBox);
            const WireBox there(hit, 4 * kBox);
            EXPECT_TRUE(plate.contains({0.5, 0.5, 0}));
            const double bottom = there.m_center.z() - 0.03;
            EXPECT_GT(bottom, 0.001 + 2.0 * btCcdMeshShape::kDefaultMargin - kDrawnExactly);
            EXPECT_LT(bottom, 0.001 + 2.2 * btCcdMeshShape::kDefaultMargin);
            // It has travelled sideways until then, and no further.
            EXPECT_NEAR(there.m_center.x(), (0.5 - there.m_center.z()) / 30.0, 1e-5);
            const auto& [from, to] = hit.back();
            EXPECT_NEAR(from.z(), 0.001, 1e-5);
            EXPECT_GT(to.z(), from.z());
            EXPECT_LT((to - from).head<2>().norm(), 1e-5);

            // Excluded objects are not drawn, and impacts are those of the last step.
            scene.ccd().setCcdEnabled(box, false);
            box->setLinearVelocity(vec(0, 0, 1));
            scene.step(0.01);
            EXPECT_EQ(linesOfOurs(scene, btIDebugDraw::DBG_DrawWireframe).size(), kBox);
        }
    }
}
}  // namespace bullet_ccd::tests
