#include "benchmarks/reference/bullet/scene.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <LinearMath/btSerializer.h>
#include <gtest/gtest.h>

#ifdef BULLET_CCD_HAS_WORLD_IMPORTER
#include <BulletWorldImporter/btBulletWorldImporter.h>
#endif

#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// What a loader makes of a triangle mesh in a file, as Bullet's own does.
class LoadedMesh
{
public:
    explicit LoadedMesh(const btCollisionShape& shape)
    {
        m_serializer.startSerialization();
        shape.serializeSingleShape(&m_serializer);
        const btTriangleMeshShapeData* data = nullptr;
        for (int i = 0; i < m_serializer.getNumChunks(); ++i)
        {
            const btChunk* chunk = m_serializer.getChunk(i);
            m_chunks[chunk->m_oldPtr] = chunk + 1;
            if (chunk->m_chunkCode == BT_SHAPE_CODE)
            {
                data = reinterpret_cast<const btTriangleMeshShapeData*>(chunk + 1);
            }
        }
        EXPECT_EQ(data->m_collisionShapeData.m_shapeType, int(TRIANGLE_MESH_SHAPE_PROXYTYPE));
        EXPECT_EQ(data->m_meshInterface.m_numMeshParts, 1);
        m_margin = btScalar(data->m_collisionMargin);
        const auto& part = *at(data->m_meshInterface.m_meshPartsPtr);
        const btIntIndexData* indices = at(part.m_indices32);
        m_indices.assign(indices, indices + 3 * part.m_numTriangles);
        const btVector3DoubleData* vertices = at(part.m_vertices3d);
        m_vertices.assign(vertices, vertices + part.m_numVertices);
        btIndexedMesh mesh;
        mesh.m_numTriangles = part.m_numTriangles;
        mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(m_indices.data());
        mesh.m_triangleIndexStride = int(3 * sizeof(btIntIndexData));
        mesh.m_numVertices = part.m_numVertices;
        mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(m_vertices.data());
        mesh.m_vertexStride = int(sizeof(btVector3DoubleData));
        mesh.m_indexType = PHY_INTEGER;
        mesh.m_vertexType = PHY_DOUBLE;
        m_interface.addIndexedMesh(mesh, PHY_INTEGER);
        btVector3 scaling;
        scaling.deSerializeFloat(data->m_meshInterface.m_scaling);
        m_interface.setScaling(scaling);
    }
    LoadedMesh(const LoadedMesh&) = delete;
    LoadedMesh& operator=(const LoadedMesh&) = delete;
    ~LoadedMesh() { m_serializer.finishSerialization(); }  // which frees the chunks
    btStridingMeshInterface* interface() { return &m_interface; }
    [[nodiscard]] btScalar margin() const { return m_margin; }
    std::vector<btVector3DoubleData>& vertices() { return m_vertices; }

private:
    btDefaultSerializer m_serializer;
    std::map<const void*, const void*> m_chunks;
    std::vector<btIntIndexData> m_indices;
    std::vector<btVector3DoubleData> m_vertices;
    btTriangleIndexVertexArray m_interface;
    btScalar m_margin = 0;

    template <typename T>
    const T* at(const T* saved) const
    {
        return static_cast<const T*>(m_chunks.at(saved));
    }
};

/// With coordinates that have no short form, and a margin and scaling that need all digits.
std::unique_ptr<btCcdMeshShape> oddMesh()
{
    TriangleMesh mesh = makeTorus(0.2, 0.05, 16, 8);
    transformMesh(mesh,
                  Eigen::Affine3d(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())));
    auto shape = btCcdMeshShape::fromMesh(std::move(mesh), btScalar(1.0 / 1500.0));
    shape->setLocalScaling(vec(1.1, 1.0 / 0.9, 1.3));
    return shape;
}

/// Poses of some bodies of that shape that fall onto a floor of it and onto each other.
std::vector<btTransform> fallOf(btCollisionShape& shape)
{
    Scene scene(Kind::World);
    scene.world().setGravity(vec(0, 0, -10));
    scene.body(&shape, 0.0, poseAt(vec(0, 0, 0)));
    std::vector<btRigidBody*> bodies;
    for (int i = 0; i < 3; ++i)
    {
        bodies.push_back(scene.body(&shape, 1.0, poseAt(vec(0.1 * i, 0, 0.5 * (i + 1)), 0.3 * i)));
        bodies.back()->setLinearVelocity(vec(0, 0, -20));
    }
    std::vector<btTransform> poses;
    for (int i = 0; i < 40; ++i)
    {
        scene.step(1.0 / 60.0);
        for (const btRigidBody* body : bodies)
        {
            poses.push_back(body->getWorldTransform());
        }
    }
    EXPECT_GT(scene.counters().m_impacts, 0);
    return poses;
}
}  // namespace

TEST(Saving, AMeshComesBackBitForBit)
{
    const std::unique_ptr<btCcdMeshShape> shape = oddMesh();
    LoadedMesh loaded(*shape);
    const std::unique_ptr<btCcdMeshShape> back = btCcdMeshShape::fromSaved(loaded.interface());
    ASSERT_NE(back, nullptr);
    EXPECT_EQ(back->getMargin(), shape->getMargin());
    EXPECT_EQ(back->getLocalScaling(), shape->getLocalScaling());
    EXPECT_EQ(back->tree().mesh().vertices, shape->tree().mesh().vertices);
    EXPECT_EQ(back->tree().mesh().triangles, shape->tree().mesh().triangles);
    EXPECT_TRUE(fallOf(*shape) == fallOf(*back));
    back->setLocalScaling(vec(1, 1, 1));
    shape->setLocalScaling(vec(1, 1, 1));
    EXPECT_EQ(back->tree().mesh().vertices, shape->tree().mesh().vertices);
}

TEST(Saving, ForOtherProgramsItIsAStaticMeshOfTheSameTriangles)
{
    const std::unique_ptr<btCcdMeshShape> shape = oddMesh();
    LoadedMesh loaded(*shape);
    btBvhTriangleMeshShape stock(loaded.interface(), true);
    stock.setMargin(loaded.margin());
    btVector3 low;
    btVector3 high;
    stock.getAabb(btTransform::getIdentity(), low, high);
    btVector3 ownLow;
    btVector3 ownHigh;
    shape->getAabb(btTransform::getIdentity(), ownLow, ownHigh);
    EXPECT_LT(double((low - ownLow).length()), 1e-3) << "vertices without triangles do not count";
    EXPECT_LT(double((high - ownHigh).length()), 1e-3);
    struct Count : btTriangleCallback
    {
        int m_count = 0;
        void processTriangle(btVector3*, int, int) override { ++m_count; }
    } count;
    stock.processAllTriangles(&count, low, high);
    EXPECT_EQ(count.m_count, int(shape->tree().mesh().triangles.size()));
}

TEST(Saving, StandInsAreReplacedWhereverTheyAre)
{
    Scene scene(Kind::World);
    const auto saved = btCcdMeshShape::fromMesh(makeBox({0.1, 0.2, 0.3}));
    LoadedMesh loaded(*saved);
    btCollisionShape* shape =
        scene.keep(std::unique_ptr<btCollisionShape>(btCcdStandInForSaved(loaded.interface())));
    ASSERT_NE(shape, nullptr);
    EXPECT_FALSE(shape->isNonMoving()) << "or a loader would make its bodies static";
    auto* inner = scene.keep(std::make_unique<btCompoundShape>());
    inner->addChildShape(poseAt(vec(1, 0, 0)), shape);
    auto* outer = scene.keep(std::make_unique<btCompoundShape>());
    outer->addChildShape(poseAt(vec(0, 0, 1)), inner);
    outer->addChildShape(poseAt(vec(0, 0, 0)), scene.box(vec(0.1, 0.1, 0.1)));
    btRigidBody* single = scene.body(shape, 2.0, poseAt(vec(0, 0, 5)));
    scene.body(outer, 1.0, poseAt(vec(0, 0, 0)));
    btRigidBody* other = scene.body(scene.box(vec(1, 1, 1)), 1.0, poseAt(vec(9, 0, 0)));
    const btCollisionShape* untouched = other->getCollisionShape();
    auto meshes = btCcdRestoreMeshes(scene.world());
    ASSERT_EQ(meshes.size(), 1U) << "shared as before";
    EXPECT_EQ(single->getCollisionShape(), meshes[0].get());
    EXPECT_EQ(inner->getChildShape(0), meshes[0].get());
    EXPECT_EQ(other->getCollisionShape(), untouched);
    // A box of 2 kg: 2 / 3 (b^2 + c^2).
    EXPECT_NEAR(1.0 / double(single->getInvInertiaDiagLocal().x()), 2.0 / 3.0 * 0.13, 1e-5);
    scene.step(0.01);
    EXPECT_TRUE(btCcdRestoreMeshes(scene.world()).empty());
    EXPECT_EQ(scene.counters().m_unsupported, 0);
    // The scene's bodies go after the meshes.
    single->setCollisionShape(shape);
    inner->getChildList()[0].m_childShape = shape;
}

TEST(Saving, WhatWasNotSavedOrIsDamagedIsNoMesh)
{
    const std::unique_ptr<btTriangleMesh> plain = bulletTriangles(makeBox({1, 1, 1}));
    EXPECT_EQ(btCcdMeshShape::fromSaved(plain.get()), nullptr);
    EXPECT_EQ(btCcdMeshShape::fromSaved(nullptr), nullptr);
    EXPECT_EQ(btCcdStandInForSaved(plain.get()), nullptr);
    LoadedMesh loaded(*oddMesh());
    loaded.vertices()[3].m_floats[1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)btCcdMeshShape::fromSaved(loaded.interface()), std::invalid_argument);
    testing::internal::CaptureStderr();
    EXPECT_EQ(btCcdStandInForSaved(loaded.interface()), nullptr);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("damaged"), std::string::npos);
}

#ifdef BULLET_CCD_HAS_WORLD_IMPORTER
TEST(Saving, AWorldComesBackFromAFileBitForBit)
{
    const TempFolder folder;
    const std::string path = (folder.path() / "scene.bullet").string();
    const std::unique_ptr<btCcdMeshShape> shape = oddMesh();
    const auto poses = [](Scene& scene)
    {
        scene.world().setGravity(vec(0, 0, -10));
        std::vector<btTransform> all;
        for (int step = 0; step < 40; ++step)
        {
            for (int i = 0; i < scene.world().getNumCollisionObjects(); ++i)
            {
                all.push_back(scene.world().getCollisionObjectArray()[i]->getWorldTransform());
                if (step == 0)
                {
                    btRigidBody* body =
                        btRigidBody::upcast(scene.world().getCollisionObjectArray()[i]);
                    body->setLinearVelocity(body->getInvMass() > 0 ? vec(0, 0, -20) : vec(0, 0, 0));
                    body->setDamping(0, 0);
                    body->setActivationState(DISABLE_DEACTIVATION);
                }
            }
            scene.step(1.0 / 60.0);
        }
        EXPECT_GT(scene.counters().m_impacts, 0);
        return all;
    };
    std::vector<btTransform> original;
    {
        Scene scene(Kind::World);
        scene.body(shape.get(), 0.0, poseAt(vec(0, 0, 0)));
        for (int i = 0; i < 3; ++i)
        {
            scene.body(shape.get(), 1.0, poseAt(vec(0.1 * i, 0, 0.5 * (i + 1)), 0.3 * i));
        }
        btDefaultSerializer serializer;
        scene.world().serialize(&serializer);
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(serializer.getBufferPointer()),
                   serializer.getCurrentBufferSize());
        original = poses(scene);
    }
    Scene scene(Kind::World);
    {
        btCcdImporter<btBulletWorldImporter> importer(&scene.world());
        ASSERT_TRUE(importer.loadFile(path.c_str()));
        const auto meshes = btCcdRestoreMeshes(scene.world());
        ASSERT_EQ(meshes.size(), 1U);
        EXPECT_TRUE(poses(scene) == original);
        importer.deleteAllData();
    }
}
#endif

TEST(Saving, PreparedHierarchiesAreKeptByTheirContent)
{
    const TempFolder folder;
    const auto files = [&]
    {
        std::vector<std::filesystem::path> found;
        if (std::filesystem::exists(folder.path() / "kept"))
        {
            for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "kept"))
            {
                found.push_back(entry.path());
            }
        }
        return found;
    };
    const auto prepare = [&](double radius)
    {
        Scene scene(Kind::World);
        btCcdSettings settings;
        settings.m_hierarchyFolder = (folder.path() / "kept").string();
        scene.ccd().setCcdSettings(settings);
        const std::unique_ptr<btTriangleMesh> triangles =
            bulletTriangles(makeTorus(radius, 0.05, 32, 20));
        btGImpactMeshShape shape(triangles.get());
        shape.updateBound();
        EXPECT_TRUE(scene.ccd().prepareCcdShape(&shape));
        EXPECT_TRUE(scene.ccd().prepareCcdShape(scene.box(vec(1, 1, 1)))) << "too small for a file";
        scene.ccd().forgetCcdShape(&shape);
    };
    prepare(0.2);
    ASSERT_EQ(files().size(), 1U);
    const std::filesystem::path file = files()[0];
    const auto contentOf = [&]
    {
        std::ifstream stream(file, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    const std::string content = contentOf();
    EXPECT_GT(content.size(), 64U * 1000U);
    // Damaged, it is made anew; another mesh gets another file.
    std::ofstream(file, std::ios::binary) << content.substr(0, content.size() / 2);
    prepare(0.2);
    EXPECT_TRUE(contentOf() == content);
    prepare(0.3);
    EXPECT_EQ(files().size(), 2U);

    Scene scene(Kind::World);
    EXPECT_FALSE(scene.ccd().prepareCcdShape(scene.keep(std::make_unique<btCompoundShape>())));
}
}  // namespace bullet_ccd::tests
