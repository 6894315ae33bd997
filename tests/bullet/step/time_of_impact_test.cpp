#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr double kShellWidth = 1.0 / 16.0;

/// A shape and, made apart from the code under test, what it is to the core.
struct Subject
{
    std::unique_ptr<btCollisionShape> m_shape = nullptr;
    std::shared_ptr<const SsvTree> m_tree = nullptr;
    double m_radius = 0.0;
    double m_margin = 0.0;  // of a mesh
};

std::shared_ptr<const SsvTree> treeOf(TriangleMesh mesh)
{
    return std::make_shared<const SsvTree>(buildSsvTree(std::move(mesh)));
}

Subject meshSubject(TriangleMesh mesh, double margin)
{
    Subject subject{.m_tree = treeOf(std::move(mesh)), .m_margin = double(btScalar(margin))};
    subject.m_shape = std::make_unique<btCcdMeshShape>(subject.m_tree, btScalar(margin));
    return subject;
}

std::vector<Subject> subjects()
{
    std::vector<Subject> all;
    all.push_back(meshSubject(makeTorus(0.3, 0.1, 16, 8), 1e-3));
    all.push_back(meshSubject(makeBox({0.4, 0.2, 0.1}), 5e-4));
    all.push_back(meshSubject(makeSphere(0.25, 2), 2e-3));
    const btVector3 half = vec(0.125, 0.25, 0.5);
    all.push_back({std::make_unique<btBoxShape>(half), treeOf(makeBox(btCcdToEigen(half)))});
    const double radius = double(btScalar(0.2));
    all.push_back({std::make_unique<btSphereShape>(btScalar(radius)),
                   treeOf(segment({0, 0, 0}, {0, 0, 0})),
                   radius});
    all.push_back({std::make_unique<btCapsuleShape>(btScalar(radius), btScalar(0.5)),
                   treeOf(segment({0, -0.25, 0}, {0, 0.25, 0})),
                   radius});
    const std::vector<btVector3> corners{
        vec(-0.25, -0.25, -0.25), vec(0.25, -0.25, 0), vec(0, 0.25, -0.125), vec(0, 0, 0.375)};
    auto hull = std::make_unique<btConvexHullShape>(&corners[0].x(), 4, int(sizeof(btVector3)));
    hull->setMargin(btScalar(0.0625));
    TriangleMesh tetrahedron{{}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    for (const btVector3& corner : corners)
    {
        tetrahedron.vertices.push_back(btCcdToEigen(corner));
    }
    all.push_back({std::move(hull), treeOf(std::move(tetrahedron)), 0.0625});
    return all;
}

/// What the algorithm that is registered for a pair answers.
class Asker
{
public:
    Asker() : m_dispatcher(&m_configuration)
    {
        btCcdCollisionAlgorithm::registerAlgorithm(&m_dispatcher);
    }
    ~Asker() { btCcdCollisionAlgorithm::unregisterAlgorithm(&m_dispatcher); }
    Asker(const Asker&) = delete;
    Asker& operator=(const Asker&) = delete;

    double ask(btCollisionObject& a, btCollisionObject& b, double timeStep = 1.0)
    {
        const btCollisionObjectWrapper wrapA(
            nullptr, a.getCollisionShape(), &a, a.getWorldTransform(), -1, -1);
        const btCollisionObjectWrapper wrapB(
            nullptr, b.getCollisionShape(), &b, b.getWorldTransform(), -1, -1);
        btCollisionAlgorithm* algorithm =
            m_dispatcher.findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
        EXPECT_NE(dynamic_cast<btCcdCollisionAlgorithm*>(algorithm), nullptr);
        btDispatcherInfo info;
        info.m_timeStep = btScalar(timeStep);
        btManifoldResult result(&wrapA, &wrapB);
        const double fraction = double(algorithm->calculateTimeOfImpact(&a, &b, info, &result));
        algorithm->~btCollisionAlgorithm();
        m_dispatcher.freeCollisionAlgorithm(algorithm);
        return fraction;
    }

private:
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher;
};

btTransform randomPose(Random& random, double half)
{
    return btCcdToBullet(random.pose(half));
}

RigidMotion motionOf(const btCollisionObject& object)
{
    return motionBetween(btCcdToEigen(object.getWorldTransform()),
                         btCcdToEigen(object.getInterpolationWorldTransform()));
}

/// The distance to keep, and how near to it a hit may be, as the documents of the pair say.
ToiOptions optionsOf(const Subject& a, const Subject& b)
{
    const double margins = a.m_margin + b.m_margin;
    ToiOptions options;
    options.minimumSeparation = a.m_radius + b.m_radius + margins;
    options.tolerance = margins > 0.0 ? kShellWidth * margins : btCcdContext::kDefaultTolerance;
    options.aim = 0.5;
    return options;
}

bool startsApart(const Subject& a, const Subject& b, const RigidBody& bodyA, const RigidBody& bodyB)
{
    const ToiOptions options = optionsOf(a, b);
    const double reach = options.minimumSeparation + 1.01 * options.tolerance;
    return treeDistance(
               *a.m_tree, *b.m_tree, bodyB.motion.X_W0.inverse() * bodyA.motion.X_W0, reach)
               .triangleA == kNone;
}
}  // namespace

/// Meshes are asked as they are here. What is convex is asked without triangles, which gives
/// another time between the first at which the distance is within the tolerance and the first at
/// which it is the one to keep.
TEST(TimeOfImpact, EqualsTheCoresAnswerRoundedDown)
{
    const auto bound = [](const RigidBody& a, const RigidBody& b, double separation)
    {
        constexpr double kLittle = 1e-9;
        ToiWorkspace scratch;
        return rigidToi(
                   a, b, {.tolerance = kLittle, .minimumSeparation = separation - kLittle}, scratch)
            .time;
    };
    const std::vector<Subject> all = subjects();
    Asker asker;
    ToiWorkspace work;
    Random random(20);
    int asked = 0;
    int hits = 0;
    while (asked < 1000)
    {
        const auto pick = [&] { return std::size_t(random.integer(0, int(all.size()) - 1)); };
        const Subject& a = all[pick()];
        const Subject& b = all[pick()];
        btCollisionObject objectA;
        btCollisionObject objectB;
        objectA.setCollisionShape(a.m_shape.get());
        objectB.setCollisionShape(b.m_shape.get());
        for (btCollisionObject* object : {&objectA, &objectB})
        {
            object->setWorldTransform(randomPose(random, 1.0));
            object->setInterpolationWorldTransform(randomPose(random, 1.0));
        }
        const RigidBody bodyA{.tree = a.m_tree.get(), .motion = motionOf(objectA)};
        const RigidBody bodyB{.tree = b.m_tree.get(), .motion = motionOf(objectB)};
        if (!startsApart(a, b, bodyA, bodyB))
        {
            continue;
        }
        ++asked;
        for (const bool swapped : {false, true})
        {
            const ToiResult core = swapped ? rigidToi(bodyB, bodyA, optionsOf(b, a), work)
                                           : rigidToi(bodyA, bodyB, optionsOf(a, b), work);
            const double ours = swapped ? asker.ask(objectB, objectA) : asker.ask(objectA, objectB);
            const ToiOptions options = optionsOf(a, b);
            const bool isConvex = a.m_margin + b.m_margin == 0.0;
            const double nearest = options.minimumSeparation + 1e-9;
            const double latest = isConvex ? bound(bodyA, bodyB, nearest) : core.time;
            const double earliest =
                isConvex ? bound(bodyA, bodyB, nearest + options.tolerance) : core.time;
            EXPECT_LE(ours, latest);
            EXPECT_GE(ours, earliest * (1.0 - double(std::numeric_limits<btScalar>::epsilon())));
            if (!isConvex)
            {
                EXPECT_EQ(ours == 1.0, core.status == ToiStatus::Separated);
            }
            hits += core.status == ToiStatus::Hit ? 1 : 0;
        }
    }
    EXPECT_GT(hits, 400) << "hardly anything meets";
    EXPECT_LT(hits, 1600) << "hardly anything misses";
}

namespace
{
/// Three links that turn or slide about random axes; some have a base that flies.
std::unique_ptr<btMultiBody> randomChain(Random& random, bool fixedBase)
{
    auto body = std::make_unique<btMultiBody>(3, btScalar(1), vec(1, 1, 1), fixedBase, false);
    body->setBaseWorldTransform(btTransform::getIdentity());
    for (int i = 0; i < 3; ++i)
    {
        const btQuaternion turned =
            btCcdToBullet(Eigen::Quaterniond(Eigen::Matrix3d(random.rotation())));
        const btVector3 axis = btCcdToBullet(random.direction());
        const btVector3 pivot = btCcdToBullet(random.inBox(0.2));
        const btVector3 center = btCcdToBullet(random.inBox(0.2));
        if (random.chance(0.7))
        {
            body->setupRevolute(
                i, btScalar(1), vec(1, 1, 1), i - 1, turned, axis, pivot, center, true);
        }
        else
        {
            body->setupPrismatic(
                i, btScalar(1), vec(1, 1, 1), i - 1, turned, axis, pivot, center, true);
        }
    }
    body->finalizeMultiDof();
    for (int i = 0; i < 3; ++i)
    {
        body->setJointPos(i, btScalar(random.uniform(-1, 1)));
        body->setJointVel(i, btScalar(random.uniform(-8, 8)));
    }
    if (!fixedBase)
    {
        body->setBaseVel(btCcdToBullet(random.inBox(2.0)));
        body->setBaseOmega(btCcdToBullet(random.inBox(3.0)));
    }
    return body;
}

/// Poses of the links after Bullet itself has integrated the joints for that time.
std::vector<Eigen::Isometry3d> stepped(btMultiBody& body, double seconds)
{
    const btTransform base = body.getBaseWorldTransform();
    std::vector<btScalar> joints;
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        joints.push_back(body.getJointPos(i));
    }
    body.stepPositionsMultiDof(btScalar(seconds));
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        poses.push_back(btCcdToEigen(body.getLink(i).m_collider->getWorldTransform()));
    }
    body.setBaseWorldTransform(base);
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        body.setJointPos(i, joints[std::size_t(i)]);
    }
    Scene::placeColliders(body);
    return poses;
}
}  // namespace

/// A thing that is smaller than what it is pressed into may be wholly below the surface.
TEST(TimeOfImpact, OfWhatIsInsideIsThatOfTheCores)
{
    const btBoxShape wall(vec(2, 2, 0.05));
    const btSphereShape ball(btScalar(0.002));
    btCollisionObject a;
    btCollisionObject b;
    a.setCollisionShape(const_cast<btBoxShape*>(&wall));
    b.setCollisionShape(const_cast<btSphereShape*>(&ball));
    a.setInterpolationWorldTransform(a.getWorldTransform());
    Asker asker;
    for (const bool swapped : {false, true})
    {
        const auto ask = [&](double from, double to)
        {
            b.setWorldTransform(poseAt(vec(0.3, 0.2, from)));
            b.setInterpolationWorldTransform(poseAt(vec(0.3, 0.2, to)));
            return swapped ? asker.ask(b, a) : asker.ask(a, b);
        };
        // 13 mm deep. It may go on to the core, which begins some 25 mm deep, and no farther.
        const double fraction = ask(0.037, -0.163);
        EXPECT_GT(fraction, 0.0);
        EXPECT_LT(0.037 - 0.2 * fraction, 0.037);
        EXPECT_GT(0.037 - 0.2 * fraction, 0.02);
        EXPECT_EQ(ask(0.037, 0.2), 1.0);
        // In the core it is Bullet's, whichever way it goes.
        EXPECT_EQ(ask(0.001, 0.2), 1.0);
        EXPECT_EQ(ask(0.001, -0.2), 1.0);
    }
}

/// Of a polyhedron of 72 sides it would be as much as a millimetre late.
TEST(TimeOfImpact, OfCylindersAndConesIsExact)
{
    constexpr double kRadius = 1.0;
    constexpr double kHalf = 1.5;
    constexpr double kFace = 4.0;
    const btBoxShape wall(vec(1, 20, 20));
    const btCylinderShapeX cylinderX(vec(kHalf, kRadius, kRadius));
    const btCylinderShape cylinderY(vec(kRadius, kHalf, kRadius));
    const btCylinderShapeZ cylinderZ(vec(kRadius, kRadius, kHalf));
    const btConeShapeX coneX(btScalar(kRadius), btScalar(2.0 * kHalf));
    const btConeShape coneY(btScalar(kRadius), btScalar(2.0 * kHalf));
    const btConeShapeZ coneZ(btScalar(kRadius), btScalar(2.0 * kHalf));
    const std::vector<const btCollisionShape*> shapes{
        &cylinderX, &cylinderY, &cylinderZ, &coneX, &coneY, &coneZ};
    btCollisionObject a;
    btCollisionObject b;
    a.setCollisionShape(const_cast<btBoxShape*>(&wall));
    a.setWorldTransform(poseAt(vec(kFace + 1.0, 0, 0)));
    a.setInterpolationWorldTransform(a.getWorldTransform());
    Asker asker;
    Random random(22);
    for (int trial = 0; trial < 120; ++trial)
    {
        const std::size_t which = std::size_t(trial) % shapes.size();
        b.setCollisionShape(const_cast<btCollisionShape*>(shapes[which]));
        const btTransform from = randomPose(random, 0.5);
        btTransform to = from;
        to.getOrigin() += vec(5, 0, 0);
        b.setWorldTransform(from);
        b.setInterpolationWorldTransform(to);
        const Eigen::Vector3d ahead =
            btCcdToEigen(from).linear().transpose() * Eigen::Vector3d::UnitX();
        const double along = ahead[Eigen::Index(which % 3)];
        const double across = std::sqrt(1.0 - along * along);
        const double reach = which < 3 ? kRadius * across + kHalf * std::abs(along)
                                       : std::max(kHalf * along, kRadius * across - kHalf * along) +
                                             double(shapes[which]->getMargin());
        const double gap = kFace - double(from.getOrigin().x()) - reach;
        const double rounding = kDouble ? 1e-9 : 1e-5;
        for (const double fraction : {asker.ask(a, b), asker.ask(b, a)})
        {
            EXPECT_LE(5.0 * fraction, gap + rounding) << shapes[which]->getName();
            EXPECT_GE(5.0 * fraction, gap - btCcdContext::kDefaultTolerance - rounding)
                << shapes[which]->getName();
        }
    }
}

TEST(TimeOfImpact, OfLinksIsThatOfBulletsOwnIntegration)
{
    constexpr double kStep = 0.1;
    constexpr int kSamples = 100;
    const TriangleMesh rod = makeBox({0.1, 0.02, 0.03});
    const std::shared_ptr<const SsvTree> tree = treeOf(rod);
    btCcdMeshShape shape(tree, btScalar(1e-3));
    const double shell = 2.0 * double(shape.getMargin());
    // Coordinates of a few decimetres, rounded once a joint.
    const double rounding = kDouble ? 1e-9 : 3e-6;
    Asker asker;
    Random random(21);
    int hits = 0;
    int misses = 0;
    for (int i = 0; i < 100; ++i)
    {
        const std::unique_ptr<btMultiBody> body = randomChain(random, random.chance(0.5));
        std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
        for (int link = 0; link < 3; ++link)
        {
            colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(body.get(), link));
            colliders.back()->setCollisionShape(&shape);
            body->getLink(link).m_collider = colliders.back().get();
        }
        Scene::placeColliders(*body);
        btCollisionObject obstacle;
        obstacle.setCollisionShape(&shape);
        // Near a place that the last link comes by.
        const Eigen::Vector3d passed =
            stepped(*body, random.uniform(0.3, 1.0) * kStep)[2] * Eigen::Vector3d::Zero();
        obstacle.setWorldTransform(randomPose(random, 0.1));
        obstacle.getWorldTransform().getOrigin() += btCcdToBullet(passed);
        obstacle.setInterpolationWorldTransform(obstacle.getWorldTransform());
        // The last link meets the obstacle, or another link of its own body.
        const bool self = i % 3 == 0;
        btCollisionObject& other = self ? static_cast<btCollisionObject&>(*colliders[0]) : obstacle;
        const auto distance = [&](double fraction)
        {
            const std::vector<Eigen::Isometry3d> poses = stepped(*body, fraction * kStep);
            const Eigen::Isometry3d X_WB =
                self ? poses[0] : btCcdToEigen(obstacle.getWorldTransform());
            return treeDistance(*tree, *tree, X_WB.inverse() * poses[2], 1e9).distance;
        };
        if (distance(0.0) < shell * (1.0 + 2.0 * kShellWidth))
        {
            continue;
        }
        const double fraction = asker.ask(*colliders[2], other, kStep);
        EXPECT_EQ(asker.ask(other, *colliders[2], kStep) == 1.0, fraction == 1.0);
        for (int k = 0; k <= kSamples; ++k)
        {
            EXPECT_GT(distance(fraction * k / kSamples), shell - rounding) << "chain " << i;
        }
        if (fraction < 1.0)
        {
            EXPECT_LT(distance(fraction), shell * (1.0 + kShellWidth) + rounding) << "chain " << i;
        }
        (fraction < 1.0 ? hits : misses) += 1;
    }
    EXPECT_GT(hits, 20);
    EXPECT_GT(misses, 20);
}

namespace
{
/// All triangles of a shape, as they come.
struct AllTriangles : btTriangleCallback
{
    TriangleMesh m_mesh;
    void processTriangle(btVector3* corners, int /*part*/, int /*index*/) override
    {
        const auto first = std::int32_t(m_mesh.vertices.size());
        m_mesh.triangles.push_back({first, first + 1, first + 2});
        for (int k = 0; k < 3; ++k)
        {
            m_mesh.vertices.push_back(btCcdToEigen(corners[k]));
        }
    }
};

/// A hilly height field with so many triangles that it is converted in pieces, the same as one mesh
/// of Bullet's, and as meshes that are small enough to be converted as wholes.
struct Hills
{
    static constexpr int kSide = 103;
    Scene m_scene{Kind::Stock};
    std::vector<btScalar> m_heights;
    btHeightfieldTerrainShape* m_terrain;
    btCollisionShape* m_mesh;
    btCompoundShape* m_parts;

    Hills() : m_heights(std::size_t(kSide * kSide))
    {
        for (int i = 0; i < kSide * kSide; ++i)
        {
            m_heights[std::size_t(i)] =
                btScalar(2.0 * std::sin(0.31 * (i % kSide)) * std::cos(0.23 * (i / kSide)));
        }
        m_terrain = m_scene.keep(
            std::make_unique<btHeightfieldTerrainShape>(kSide,
                                                        kSide,
                                                        m_heights.data(),
                                                        btScalar(1),
                                                        btScalar(-2),
                                                        btScalar(2),
                                                        1,
                                                        kDouble ? PHY_DOUBLE : PHY_FLOAT,
                                                        false));
        m_terrain->setMargin(btScalar(0));
        AllTriangles all;
        const btVector3 far = vec(1e3, 1e3, 1e3);
        m_terrain->processAllTriangles(&all, -far, far);
        m_mesh = m_scene.staticMesh(all.m_mesh);
        m_mesh->setMargin(btScalar(0));
        m_parts = m_scene.keep(std::make_unique<btCompoundShape>());
        constexpr std::size_t kParts = 4;
        const std::size_t size = all.m_mesh.triangles.size() / kParts;
        for (std::size_t part = 0; part < kParts; ++part)
        {
            TriangleMesh mesh = all.m_mesh;
            const auto begin = mesh.triangles.begin() + std::ptrdiff_t(part * size);
            mesh.triangles = {begin, begin + std::ptrdiff_t(size)};
            btCollisionShape* child = m_scene.staticMesh(mesh);
            child->setMargin(btScalar(0));
            m_parts->addChildShape(btTransform::getIdentity(), child);
        }
    }
};

std::size_t trianglesIn(const btCcdShapeModel& model)
{
    std::size_t count = 0;
    for (const btCcdShapePart& part : model.m_parts)
    {
        count += part.m_tree != nullptr ? part.m_tree->mesh().triangles.size() : 0;
    }
    return count;
}
}  // namespace

/// Whatever flies over, into or through the hills, or is hit by them as they move themselves.
TEST(LargeMeshes, InPiecesAnswerAsWholeOnes)
{
    Hills hills;
    btCcdShapeCache cache;
    ASSERT_EQ(trianglesIn(*cache.find(hills.m_terrain)), 0U);
    ASSERT_EQ(trianglesIn(*cache.find(hills.m_mesh)), 0U);
    ASSERT_EQ(trianglesIn(*cache.find(hills.m_parts)),
              std::size_t(2 * (Hills::kSide - 1) * (Hills::kSide - 1)));

    Asker asker;
    Random random(3);
    const std::vector<Subject> all = subjects();
    int hits = 0;
    int runs = 0;
    for (int i = 0; i < (120); ++i)
    {
        const Subject& subject = all[std::size_t(i) % all.size()];
        btCollisionObject flier;
        flier.setCollisionShape(subject.m_shape.get());
        const double side = 0.5 * Hills::kSide;
        const Eigen::Vector3d place(random.uniform(-side, side), 4.0, random.uniform(-side, side));
        const double length = random.logUniform(1.0, 60.0);
        btTransform from = randomPose(random, 0.1);
        from.setOrigin(btCcdToBullet(place));
        btTransform to = randomPose(random, 0.1);
        to.setOrigin(btCcdToBullet(Eigen::Vector3d(place + length * random.direction())));
        const btTransform moved = randomPose(random, 0.2);
        const bool hillsMove = i % 3 == 0;
        std::vector<double> fractions;
        for (btCollisionShape* shape : {static_cast<btCollisionShape*>(hills.m_parts),
                                        hills.m_mesh,
                                        static_cast<btCollisionShape*>(hills.m_terrain)})
        {
            btCollisionObject ground;
            ground.setCollisionShape(shape);
            ground.setWorldTransform(hillsMove ? moved : btTransform::getIdentity());
            ground.setInterpolationWorldTransform(ground.getWorldTransform());
            flier.setWorldTransform(from);
            flier.setInterpolationWorldTransform(to);
            if (hillsMove)
            {
                ground.setInterpolationWorldTransform(btTransform(
                    btQuaternion(vec(1, 2, 1).normalized(), btScalar(0.05)), vec(0, 1, 0)));
            }
            fractions.push_back(i % 2 == 0 ? asker.ask(flier, ground) : asker.ask(ground, flier));
        }
        // Both stop within the same distances of touching.
        const double room =
            2.0 * btCcdContext::kDefaultTolerance / length + (kDouble ? 1e-9 : 1e-5);
        for (std::size_t k = 1; k < fractions.size(); ++k)
        {
            const bool bothHit = fractions[0] < 1.0 && fractions[k] < 1.0;
            EXPECT_EQ(fractions[0] < 1.0, fractions[k] < 1.0) << i;
            EXPECT_NEAR(fractions[0], fractions[k], bothHit ? 4.0 * room : 0.0) << i;
        }
        hits += fractions[0] < 1.0 ? 1 : 0;
        ++runs;
    }
    EXPECT_GT(hits, runs / 5);
    EXPECT_LT(hits, 4 * runs / 5);
}
/// Contacts of meshes look at the piece next to them: across the edge of two pieces, too.
TEST(LargeMeshes, InPiecesCarryMeshes)
{
    for (const Kind kind : kOurKinds)
    {
        constexpr int kSide = Hills::kSide;
        Scene scene(kind);
        scene.world().setGravity(vec(0, -10, 0));
        std::vector<btScalar> heights(std::size_t(kSide * kSide), btScalar(0));
        auto* terrain =
            scene.keep(std::make_unique<btHeightfieldTerrainShape>(kSide,
                                                                   kSide,
                                                                   heights.data(),
                                                                   btScalar(1),
                                                                   btScalar(-1),
                                                                   btScalar(1),
                                                                   1,
                                                                   kDouble ? PHY_DOUBLE : PHY_FLOAT,
                                                                   false));
        terrain->setMargin(btScalar(5e-4));
        scene.body(terrain, 0.0, poseAt(vec(0, 0, 0)));
        btCollisionShape* cube = scene.boxMesh(vec(0.1, 0.1, 0.1));
        std::vector<btRigidBody*> cubes;
        for (int i = 0; i < 8; ++i)
        {
            cubes.push_back(scene.body(cube, 1.0, poseAt(vec(1.9 * i - 7.0, 0.12, 0.45 * i))));
        }
        for (int i = 0; i < 60; ++i)
        {
            scene.step(1.0 / 120.0);
        }
        for (const btRigidBody* body : cubes)
        {
            EXPECT_NEAR(double(body->getWorldTransform().getOrigin().y()), 0.101, 5e-4);
        }
    }
}
}  // namespace bullet_ccd::tests
