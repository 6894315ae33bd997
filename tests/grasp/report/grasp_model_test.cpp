// Reads .glb files back byte by byte, and with assimp, as viewers do.
#include "grasp/report/grasp_model.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/grasp/planner/test_hands.h"
#include "tests/grasp/report/report_scene.h"

#include <assimp/Importer.hpp>
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
using Json = nlohmann::json;
using tests::outputFile;

constexpr double kFriction = 0.7;
constexpr double kRadius = 0.05;
constexpr double kSingle = 1e-7;  ///< rounding of metres below 1 to single precision

/// The container taken apart.
struct Glb
{
    Json json;
    std::string binary;

    /// The 4-byte number at `offset` of the binary chunk.
    template <typename T>
    [[nodiscard]] T number(std::size_t offset) const
    {
        T value{};
        std::memcpy(&value, binary.data() + offset, sizeof(T));
        return value;
    }
    [[nodiscard]] const Json& node(const std::string& name) const
    {
        for (const Json& node : json.at("nodes"))
        {
            if (node.at("name") == name)
            {
                return node;
            }
        }
        throw std::out_of_range("no node \"" + name + "\"");
    }
    [[nodiscard]] std::vector<std::string> childrenOf(const std::string& name) const
    {
        std::vector<std::string> names;
        for (const Json& child : node(name).value("children", Json::array()))
        {
            names.push_back(json["nodes"][child.get<std::size_t>()]["name"]);
        }
        return names;
    }
    [[nodiscard]] const Json& primitive(const std::string& node_) const
    {
        return json["meshes"][node(node_)["mesh"].get<std::size_t>()]["primitives"][0];
    }
    [[nodiscard]] const Json& accessor(const Json& index) const
    {
        return json["accessors"][index.get<std::size_t>()];
    }
    [[nodiscard]] const Json& view(const Json& ofAccessor) const
    {
        return json["bufferViews"][ofAccessor["bufferView"].get<std::size_t>()];
    }
};

std::uint32_t wordAt(const std::string& bytes, std::size_t offset)
{
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + offset, sizeof(word));
    return word;
}

/// Header of 12 bytes, a chunk of JSON, a chunk of numbers; all little endian.
Glb readGlb(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(wordAt(bytes, 4), 2U);
    EXPECT_EQ(wordAt(bytes, 8), bytes.size());
    const std::size_t jsonLength = wordAt(bytes, 12);
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    const std::size_t binaryAt = 20 + jsonLength;
    EXPECT_EQ(jsonLength % 4, 0U);
    EXPECT_EQ(bytes.substr(binaryAt + 4, 4), std::string("BIN\0", 4));
    EXPECT_EQ(wordAt(bytes, binaryAt) % 4, 0U);
    EXPECT_EQ(binaryAt + 8 + wordAt(bytes, binaryAt), bytes.size());
    return {Json::parse(bytes.substr(20, jsonLength)), bytes.substr(binaryAt + 8)};
}

Eigen::Vector3d vectorOf(const Json& json)
{
    const auto v = json.get<std::vector<double>>();
    return {v.at(0), v.at(1), v.at(2)};
}

/// glTF writes x, y, z, w.
Eigen::Quaterniond rotationOf(const Json& node)
{
    const auto q = node.at("rotation").get<std::vector<double>>();
    return {q.at(3), q.at(0), q.at(1), q.at(2)};
}

void expectNear(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected, double tolerance)
{
    EXPECT_LE((actual - expected).lpNorm<Eigen::Infinity>(), tolerance)
        << actual.transpose() << " instead of " << expected.transpose();
}

/// A gripper turned a quarter about z, its jaws moved by 10 and 15 mm, and a ball.
class GraspModelFile : public ::testing::Test
{
protected:
    GraspModelFile()
    {
        m_grasp.preshape = "open";
        m_grasp.X_WH = Eigen::Translation3d(0.1, 0.2, 0.3) *
                       Eigen::AngleAxisd(std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ());
        m_grasp.positions = {0.0, 0.01, 0.015};
        m_grasp.approach_W = -Eigen::Vector3d::UnitZ();
        for (const double side : {1.0, -1.0})
        {
            const Eigen::Vector3d normal = Eigen::Vector3d(0.6 * side, 0.0, 0.8);
            m_grasp.contacts.push_back(
                {.link = side > 0.0 ? 1 : 2, .point = -kRadius * normal, .normal = normal});
        }
    }

    [[nodiscard]] std::filesystem::path write() const
    {
        std::filesystem::path file = outputFile("grasp.glb");
        writeGraspModel(m_hand, m_ball, m_grasp, kFriction, file);
        return file;
    }

    HandModel m_hand = tests::makeGripper(false);
    GraspObject m_ball = makeGraspObject("ball", makeSphere(kRadius, 3));
    Grasp m_grasp;
};

TEST_F(GraspModelFile, ObstaclesAreNodesOfTheirOwn)
{
    const SsvTree plate = buildSsvTree(makeBox({0.3, 0.3, 0.001}));
    const std::vector<RigidBody> obstacles{{.tree = &plate, .motion = {}},
                                           {.tree = &plate, .motion = {}}};
    const std::filesystem::path file = outputFile("obstacles.glb");
    writeGraspModel(m_hand, m_ball, m_grasp, kFriction, file, obstacles);
    const std::string text = readGlb(file).json["nodes"].dump();
    EXPECT_NE(text.find("\"obstacles\""), std::string::npos);
    EXPECT_NE(text.find("\"obstacle 2\""), std::string::npos);
    EXPECT_EQ(text.find("\"obstacle 3\""), std::string::npos);
}

TEST_F(GraspModelFile, NumbersLieInTheBufferAndIndicesInRange)
{
    const Glb glb = readGlb(write());
    EXPECT_EQ(glb.json["asset"]["version"], "2.0");
    ASSERT_EQ(glb.json["buffers"].size(), 1U);
    const std::size_t length = glb.json["buffers"][0]["byteLength"];
    EXPECT_LE(length, glb.binary.size());
    EXPECT_LT(glb.binary.size(), length + 4);
    for (const Json& accessor : glb.json["accessors"])
    {
        const Json& view = glb.view(accessor);
        const std::size_t size = accessor["type"] == "VEC3" ? 12 : 4;
        const std::size_t offset = view.value("byteOffset", std::size_t{0});
        EXPECT_EQ(offset % 4, 0U);
        EXPECT_EQ(accessor["count"].get<std::size_t>() * size, view["byteLength"]);
        EXPECT_LE(offset + view["byteLength"].get<std::size_t>(), length);
    }
    ASSERT_EQ(glb.json["meshes"].size(), 7U);  // three links, ball, contact, cone, box
    for (const Json& mesh : glb.json["meshes"])
    {
        const Json& primitive = mesh["primitives"][0];
        const Json& points = glb.accessor(primitive["attributes"]["POSITION"]);
        const Json& indices = glb.accessor(primitive["indices"]);
        EXPECT_EQ(indices["componentType"], 5125) << "unsigned 32 bits";
        std::uint32_t largest = 0;
        for (std::size_t i = 0; i < indices["count"]; ++i)
        {
            const std::size_t offset = glb.view(indices).value("byteOffset", std::size_t{0});
            largest = std::max(largest, glb.number<std::uint32_t>(offset + 4 * i));
        }
        EXPECT_EQ(largest + 1, points["count"]) << mesh["name"];
        EXPECT_LT(primitive["material"].get<std::size_t>(), glb.json["materials"].size());
    }
}

TEST_F(GraspModelFile, BoundsInTheFileAreThoseOfItsNumbers)
{
    const Glb glb = readGlb(write());
    for (const Json& mesh : glb.json["meshes"])
    {
        const Json& attributes = mesh["primitives"][0]["attributes"];
        const Json& points = glb.accessor(attributes["POSITION"]);
        const std::size_t offset = glb.view(points).value("byteOffset", std::size_t{0});
        Eigen::AlignedBox3d box;
        for (std::size_t i = 0; i < points["count"]; ++i)
        {
            const std::size_t at = offset + 12 * i;
            box.extend(Eigen::Vector3f(glb.number<float>(at),
                                       glb.number<float>(at + 4),
                                       glb.number<float>(at + 8))
                           .cast<double>());
        }
        EXPECT_EQ(vectorOf(points["min"]), box.min()) << mesh["name"];
        EXPECT_EQ(vectorOf(points["max"]), box.max()) << mesh["name"];
        if (!attributes.contains("NORMAL"))
        {
            continue;  // lines
        }
        const Json& normals = glb.accessor(attributes["NORMAL"]);
        ASSERT_EQ(normals["count"], points["count"]);
        for (std::size_t i = 0; i < normals["count"]; ++i)
        {
            const std::size_t at = glb.view(normals)["byteOffset"].get<std::size_t>() + 12 * i;
            const Eigen::Vector3f normal(
                glb.number<float>(at), glb.number<float>(at + 4), glb.number<float>(at + 8));
            ASSERT_NEAR(normal.norm(), 1.0F, 1e-5F) << mesh["name"];
        }
    }
}

TEST_F(GraspModelFile, LinksArePosed)
{
    const Glb glb = readGlb(write());
    EXPECT_THAT(glb.childrenOf("hand"), ::testing::ElementsAre("palm", "left", "right"));
    struct Expected
    {
        const char* link;
        Eigen::Vector3d center;  ///< W
        Eigen::Vector3d halfExtents;
    };
    // The hand's x is y of W, and its y is -x: jaws at x = -45 mm + 10 mm and 45 mm - 15 mm.
    for (const Expected& expected :
         {Expected{"palm", {0.1, 0.2, 0.3 - 0.025}, {0.015, 0.06, 0.02}},
          Expected{"left", {0.1, 0.2 - 0.035, 0.33}, {0.01, 0.005, 0.03}},
          Expected{"right", {0.1, 0.2 + 0.030, 0.33}, {0.01, 0.005, 0.03}}})
    {
        const Json& primitive = glb.primitive(expected.link);
        const Json& points = glb.accessor(primitive["attributes"]["POSITION"]);
        EXPECT_EQ(points["count"], 24) << "8 corners of a box, 3 faces each";
        EXPECT_EQ(glb.accessor(primitive["indices"])["count"], 36);
        expectNear(vectorOf(points["min"]), expected.center - expected.halfExtents, kSingle);
        expectNear(vectorOf(points["max"]), expected.center + expected.halfExtents, kSingle);
    }
    const Json& ball = glb.accessor(glb.primitive("object: ball")["attributes"]["POSITION"]);
    EXPECT_EQ(ball["count"], 10 * 64 + 2) << "an icosahedron divided three times, smooth";
    EXPECT_LE(vectorOf(ball["max"]).maxCoeff(), kRadius + kSingle);
    EXPECT_GE(vectorOf(ball["max"]).minCoeff(), 0.98 * kRadius);
}

TEST_F(GraspModelFile, TheRootTurnsZUpToYUp)
{
    const Glb glb = readGlb(write());
    const Json& roots = glb.json["scenes"][glb.json["scene"].get<std::size_t>()]["nodes"];
    ASSERT_EQ(roots.size(), 1U);
    const Json& root = glb.json["nodes"][roots[0].get<std::size_t>()];
    EXPECT_EQ(root["name"], "grasp");
    expectNear(rotationOf(root) * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), 1e-15);
    expectNear(rotationOf(root) * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX(), 1e-15);
    EXPECT_THAT(glb.childrenOf("grasp"),
                ::testing::ElementsAre(
                    "hand", "object: ball", "contacts", "friction cones", "swept boxes"));
}

TEST_F(GraspModelFile, ConesOpenFromTheContactsAlongTheNormals)
{
    const Glb glb = readGlb(write());
    EXPECT_THAT(glb.childrenOf("contacts"),
                ::testing::ElementsAre("contact 1: left", "contact 2: right"));
    const std::vector<std::string> cones = glb.childrenOf("friction cones");
    ASSERT_EQ(cones.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i)
    {
        const GraspContact& contact = m_grasp.contacts[i];
        const Json& cone = glb.node(cones[i]);
        expectNear(vectorOf(cone["translation"]), contact.point, 1e-15);
        expectNear(rotationOf(cone) * Eigen::Vector3d::UnitZ(), contact.normal, 1e-12);
    }
    const Json& points = glb.accessor(glb.primitive(cones[0])["attributes"]["POSITION"]);
    const Eigen::Vector3d high = vectorOf(points["max"]);
    EXPECT_EQ(points["min"][2], 0.0) << "the apex";
    EXPECT_GT(high.z(), 0.0);
    EXPECT_NEAR(high.x(), kFriction * high.z(), kSingle);
    const Json& material =
        glb.json["materials"][glb.primitive(cones[0])["material"].get<std::size_t>()];
    EXPECT_LT(material["pbrMetallicRoughness"]["baseColorFactor"][3].get<double>(), 1.0);
}

TEST_F(GraspModelFile, SweptBoxesAreLinesAboutAllThatAJawPasses)
{
    const Glb glb = readGlb(write());
    EXPECT_EQ(glb.primitive("swept box: left")["mode"], 1) << "lines";
    EXPECT_EQ(glb.accessor(glb.primitive("swept box: left")["indices"])["count"], 2 * 12);
    const Json& frame = glb.node("swept boxes");
    expectNear(vectorOf(frame["translation"]), m_grasp.X_WH.translation(), 1e-15);
    expectNear(rotationOf(frame) * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), 1e-15);
    // The left jaw, 10 mm wide, slides from -45 mm by 39 mm.
    const Json& left = glb.node("swept box: left");
    expectNear(vectorOf(left["scale"]), {0.049, 0.02, 0.06}, 1e-6);
    expectNear(vectorOf(left["translation"]), {-0.0255, 0.0, 0.03}, 1e-6);
}

TEST_F(GraspModelFile, ColoursAreThoseOfThePicturesInLinearLight)
{
    const Glb glb = readGlb(write());
    const Json& material =
        glb.json["materials"][glb.primitive("object: ball")["material"].get<std::size_t>()];
    EXPECT_EQ(material["alphaMode"], "BLEND");
    // The orange of the pictures, (0.93, 0.62, 0.27) on screen, by IEC 61966-2-1.
    const Json& color = material["pbrMetallicRoughness"]["baseColorFactor"];
    expectNear(vectorOf(color), {0.8481, 0.3424, 0.0593}, 1e-4);
    EXPECT_NEAR(color[3].get<double>(), 0.6, 1e-6);
    const Json& palm = glb.json["materials"][glb.primitive("palm")["material"].get<std::size_t>()];
    EXPECT_NE(palm.value("alphaMode", "OPAQUE"), "BLEND");
}

TEST_F(GraspModelFile, AssimpReadsIt)
{
    Assimp::Importer importer;
    const aiScene* scene = importer.ReadFile(write().string(), 0);
    ASSERT_NE(scene, nullptr) << importer.GetErrorString();
    ASSERT_EQ(scene->mNumMeshes, 7U);
    unsigned vertices = 0;
    unsigned faces = 0;
    for (const aiMesh* mesh : std::span(scene->mMeshes, scene->mNumMeshes))
    {
        if (mesh->mPrimitiveTypes == aiPrimitiveType_TRIANGLE && mesh->mNumVertices == 24)
        {
            vertices += mesh->mNumVertices;
            faces += mesh->mNumFaces;
        }
    }
    EXPECT_EQ(vertices, 3U * 24U) << "three links";
    EXPECT_EQ(faces, 3U * 12U);
    const aiNode* contact = scene->mRootNode->FindNode("contact 2: right");
    ASSERT_NE(contact, nullptr);
    aiMatrix4x4 toRoot;
    for (const aiNode* node = contact; node != nullptr; node = node->mParent)
    {
        toRoot = node->mTransformation * toRoot;
    }
    // (x, y, z) of W is (x, z, -y) where y is up.
    const Eigen::Vector3d& point = m_grasp.contacts[1].point;
    expectNear({toRoot.a4, toRoot.b4, toRoot.c4}, {point.x(), point.z(), -point.y()}, kSingle);
}

TEST_F(GraspModelFile, WithoutContactsAndPreshapeTheirNodesAreEmpty)
{
    m_grasp.contacts.clear();
    m_grasp.preshape = "of another hand";
    const Glb glb = readGlb(write());
    for (const char* name : {"contacts", "friction cones", "swept boxes"})
    {
        EXPECT_TRUE(glb.childrenOf(name).empty()) << name;
    }
    EXPECT_EQ(glb.json["meshes"].size(), 4U);
}

TEST_F(GraspModelFile, RefusesWhatCannotBeDrawnOrWritten)
{
    const std::filesystem::path file = outputFile("refused.glb");
    EXPECT_THROW(writeGraspModel(m_hand, m_ball, m_grasp, 0.0, file), std::invalid_argument);
    try
    {
        writeGraspModel(m_hand, m_ball, m_grasp, kFriction, outputFile("no/such/folder.glb"));
        FAIL() << "written into a folder that does not exist";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_THAT(error.what(), ::testing::HasSubstr("no/such/folder.glb: cannot be written"));
    }
    m_grasp.positions.clear();
    EXPECT_THROW(writeGraspModel(m_hand, m_ball, m_grasp, kFriction, file), std::invalid_argument);
    EXPECT_FALSE(std::filesystem::exists(file));
}
}  // namespace
}  // namespace bullet_ccd::grasp
