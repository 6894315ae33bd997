#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// Floor of strips along y, 10 cm wide: part k is two triangles over x from 0.1 k to 0.1 (k + 1).
/// Every part begins with a triangle without area, which is in nobody's way.
class Strips
{
public:
    static constexpr int kCount = 4;

    Strips()
    {
        for (int k = 0; k < kCount; ++k)
        {
            const double low = 0.1 * k;
            const double high = 0.1 * (k + 1);
            m_vertices.push_back(
                {vec(low, -1, 0), vec(high, -1, 0), vec(high, 1, 0), vec(low, 1, 0)});
        }
        for (auto& part : m_vertices)
        {
            btIndexedMesh mesh;
            mesh.m_numTriangles = 3;
            mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(kIndices.data());
            mesh.m_triangleIndexStride = 3 * int(sizeof(int));
            mesh.m_numVertices = 4;
            mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(part.data());
            mesh.m_vertexStride = int(sizeof(btVector3));
            m_interface.addIndexedMesh(mesh);
        }
    }
    btStridingMeshInterface* interface() { return &m_interface; }

    /// Of the triangle at a point of the floor, half of a strip.
    static std::pair<int, int> idAt(const btVector3& point)
    {
        const int part = int(double(point.x()) / 0.1);
        // The diagonal runs from (low, -1) to (high, 1).
        const double across = (double(point.x()) - 0.1 * part) / 0.1;
        return {part, across > 0.5 * (double(point.y()) + 1.0) ? 1 : 2};
    }

private:
    static constexpr std::array<int, 9> kIndices{0, 0, 1, 0, 1, 2, 0, 2, 3};
    std::vector<std::array<btVector3, 4>> m_vertices;
    btTriangleIndexVertexArray m_interface;
};

struct Seen
{
    std::pair<int, int> m_floor;
    std::pair<int, int> m_other;
    std::pair<int, int> m_inPoint;  // of the floor, as the manifold keeps it
    btVector3 m_at;
    int m_childOfOther;
};
std::vector<Seen> seen;
const btCollisionObject* theFloor = nullptr;
int processed = 0;

bool onAdded(btManifoldPoint& point,
             const btCollisionObjectWrapper* object0,
             int part0,
             int index0,
             const btCollisionObjectWrapper* object1,
             int part1,
             int index1)
{
    const bool floorFirst = object0->getCollisionObject() == theFloor;
    const std::pair<int, int> of0(part0, index0);
    const std::pair<int, int> of1(part1, index1);
    seen.push_back({floorFirst ? of0 : of1,
                    floorFirst ? of1 : of0,
                    floorFirst ? std::pair(point.m_partId0, point.m_index0)
                               : std::pair(point.m_partId1, point.m_index1),
                    floorFirst ? point.getPositionWorldOnA() : point.getPositionWorldOnB(),
                    floorFirst ? object1->m_index : object0->m_index});
    point.m_combinedFriction = btScalar(0.125);
    return true;
}

class ContactCallbacks : public testing::Test
{
protected:
    void SetUp() override
    {
        seen.clear();
        processed = 0;
        gContactAddedCallback = onAdded;
        gContactProcessedCallback = [](btManifoldPoint&, void*, void*) { return ++processed > 0; };
    }
    void TearDown() override
    {
        gContactAddedCallback = nullptr;
        gContactProcessedCallback = nullptr;
    }

    static btRigidBody* addFloor(Scene& scene, btCollisionShape* shape)
    {
        shape->setMargin(btScalar(5e-4));
        btRigidBody* floor = scene.body(shape, 0.0, poseAt(vec(0, 0, 0)));
        floor->setCollisionFlags(floor->getCollisionFlags() |
                                 btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
        theFloor = floor;
        return floor;
    }
    /// Of every point that was added.
    static void expectFloorIds()
    {
        ASSERT_FALSE(seen.empty());
        for (const Seen& one : seen)
        {
            EXPECT_EQ(one.m_floor, Strips::idAt(one.m_at)) << "at x = " << double(one.m_at.x());
            EXPECT_EQ(one.m_inPoint, one.m_floor);
        }
    }
    static std::set<int> partsSeen()
    {
        std::set<int> parts;
        for (const Seen& one : seen)
        {
            parts.insert(one.m_floor.first);
        }
        return parts;
    }
};

/// Which comes first: the order of the objects decides how Bullet asks for the pair.
constexpr std::array kOrders{true, false};
}  // namespace

TEST_F(ContactCallbacks, NameTheTriangleOfAStaticMeshAsItsInterfaceDoes)
{
    Strips strips;
    for (const bool floorFirst : kOrders)
    {
        seen.clear();
        Scene scene(Kind::World);
        btBvhTriangleMeshShape shape(strips.interface(), true);
        btCcdMeshShape* mesh = scene.boxMesh(vec(0.12, 0.03, 0.01));
        const btTransform above = poseAt(vec(0.19, 0.3, 0.0109), 0.1);
        if (floorFirst)
        {
            addFloor(scene, &shape);
        }
        scene.body(mesh, 1.0, above);
        if (!floorFirst)
        {
            addFloor(scene, &shape);
        }
        scene.step(0.001);
        scene.step(0.001);
        expectFloorIds();
        EXPECT_EQ(partsSeen(), (std::set{0, 3}));  // the corners of the box
        for (const Seen& one : seen)
        {
            EXPECT_EQ(one.m_other.first, 0);
            ASSERT_GE(one.m_other.second, 0);
            ASSERT_LT(one.m_other.second, 12);
            // The triangle that is named reaches the point.
            double lowest = 1.0;
            for (const std::int32_t vertex :
                 mesh->tree().mesh().triangles[std::size_t(one.m_other.second)])
            {
                lowest = std::min(lowest, mesh->tree().mesh().vertices[std::size_t(vertex)].z());
            }
            EXPECT_NEAR(lowest, -0.01, 1e-8);
        }
        EXPECT_GT(processed, 0);
        // What the callback has set is what the solver gets.
        const btPersistentManifold* manifold =
            scene.world().getDispatcher()->getManifoldByIndexInternal(0);
        EXPECT_EQ(manifold->getContactPoint(0).m_combinedFriction, btScalar(0.125));
    }
}

TEST_F(ContactCallbacks, AreLeftAloneWithoutTheFlag)
{
    Strips strips;
    Scene scene(Kind::World);
    btBvhTriangleMeshShape shape(strips.interface(), true);
    btRigidBody* floor = addFloor(scene, &shape);
    floor->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
    scene.body(scene.boxMesh(vec(0.12, 0.03, 0.01)), 1.0, poseAt(vec(0.19, 0.3, 0.0109)));
    scene.step(0.001);
    EXPECT_EQ(scene.world().getDispatcher()->getNumManifolds(), 1);
    EXPECT_TRUE(seen.empty());
}

TEST_F(ContactCallbacks, NameTheTriangleOfAGImpactMesh)
{
    Strips strips;
    Scene scene(Kind::World);
    btGImpactMeshShape shape(strips.interface());
    shape.updateBound();
    addFloor(scene, &shape);
    scene.body(scene.box(vec(0.12, 0.03, 0.01)), 1.0, poseAt(vec(0.19, 0.3, 0.0103), 0.1));
    scene.step(0.001);
    expectFloorIds();
    for (const Seen& one : seen)
    {
        EXPECT_EQ(one.m_other, std::pair(-1, -1)) << "a box has no triangles";
    }
}

TEST_F(ContactCallbacks, NameTheTriangleOfACcdMeshMadeOfAnInterface)
{
    Scene scene(Kind::World);
    addFloor(scene, scene.mesh(floorAt(0.0, 1.0)));
    scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.1))),
               1.0,
               poseAt(vec(0.5, -0.3, 0.1003)));
    scene.body(scene.keep(std::make_unique<btSphereShape>(btScalar(0.1))),
               1.0,
               poseAt(vec(-0.5, 0.3, 0.1003)));
    scene.step(0.001);
    std::set<int> triangles;
    for (const Seen& one : seen)
    {
        EXPECT_EQ(one.m_floor.first, 0);
        triangles.insert(one.m_floor.second);
    }
    EXPECT_EQ(triangles, (std::set{0, 1}));
}

TEST_F(ContactCallbacks, NameTheChildOfACompoundAsStockBulletDoes)
{
    // In stock Bullet the floor is a static mesh; here too, and a mesh of ours.
    Strips strips;
    const auto childrenSeen = [&](Kind kind, bool ours)
    {
        seen.clear();
        Scene scene(kind);
        btBvhTriangleMeshShape stock(strips.interface(), true);
        addFloor(scene,
                 ours ? static_cast<btCollisionShape*>(
                            scene.keep(btCcdMeshShape::fromInterface(strips.interface())))
                      : &stock);
        auto* compound = scene.keep(std::make_unique<btCompoundShape>());
        for (const double x : {0.05, 0.25})
        {
            compound->addChildShape(poseAt(vec(x, 0.3, 0)), scene.box(vec(0.02, 0.02, 0.02)));
        }
        scene.body(compound, 1.0, poseAt(vec(0, 0, 0.0203)));
        scene.step(0.001);
        std::set<std::array<int, 4>> ids;
        for (const Seen& one : seen)
        {
            ids.insert(
                {one.m_floor.first, one.m_other.first, one.m_other.second, one.m_childOfOther});
        }
        return ids;
    };
    const auto stock = childrenSeen(Kind::Stock, false);
    EXPECT_EQ(stock, (std::set<std::array<int, 4>>{{0, -1, 0, 0}, {2, -1, 1, 1}}));
    EXPECT_EQ(childrenSeen(Kind::World, false), stock);
    // One part is all that a mesh of ours has.
    EXPECT_EQ(childrenSeen(Kind::World, true),
              (std::set<std::array<int, 4>>{{0, -1, 0, 0}, {0, -1, 1, 1}}));
}

TEST_F(ContactCallbacks, FindTheImpactThatAPointComesFrom)
{
    static std::vector<std::optional<btCcdImpact>> impacts;
    static int marks[2];
    static bool keepsMarks = true;
    impacts.clear();
    gContactAddedCallback = [](btManifoldPoint& point,
                               const btCollisionObjectWrapper* object0,
                               int,
                               int,
                               const btCollisionObjectWrapper* object1,
                               int,
                               int)
    {
        keepsMarks = keepsMarks && (point.m_userPersistentData == nullptr ||
                                    point.m_userPersistentData == &marks[0]);
        point.m_userPersistentData = &marks[0];
        impacts.push_back(
            btCcdImpactOf(point, object0->getCollisionObject(), object1->getCollisionObject()));
        if (impacts.back())
        {
            EXPECT_EQ(impacts.back()->m_objectA, object0->getCollisionObject());
            EXPECT_EQ(impacts.back()->m_objectB, object1->getCollisionObject());
        }
        return true;
    };
    for (const Kind kind : kOurKinds)
    {
        impacts.clear();
        Scene scene(kind);
        // Another world has met nothing.
        Scene other(kind);
        other.body(other.box(vec(1, 1, 1)), 1.0, poseAt(vec(0, 0, 0)));
        other.step(0.01);
        addFloor(scene, scene.boxMesh(vec(1, 1, 0.1)));
        btRigidBody* body =
            scene.body(scene.boxMesh(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 1)));
        body->setLinearVelocity(vec(0, 0, -100));
        scene.step(0.01);
        scene.step(0.01);
        ASSERT_FALSE(impacts.empty()) << nameOf(kind);
        ASSERT_TRUE(impacts.back().has_value()) << nameOf(kind);
        EXPECT_NEAR(double(impacts.back()->m_time), (0.8 - 0.001) / 100, 1e-5) << nameOf(kind);
        const double side = impacts.back()->m_objectA == theFloor ? 1.0 : -1.0;
        EXPECT_NEAR(double(impacts.back()->m_normal.z()), side, 1e-4) << nameOf(kind);
        body->setLinearVelocity(vec(0, 0, 0));
        impacts.clear();
        scene.step(0.01);
        impacts.clear();
        scene.step(0.01);
        for (const std::optional<btCcdImpact>& impact : impacts)
        {
            EXPECT_FALSE(impact.has_value()) << "nothing has met in the last step";
        }
    }
    EXPECT_TRUE(keepsMarks) << "the pointer is the user's";
}
}  // namespace bullet_ccd::tests
