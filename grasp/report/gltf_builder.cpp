#include "grasp/report/gltf_builder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
static_assert(std::endian::native == std::endian::little, "glTF's numbers are little endian");

/// glTF wants linear light; 0.04045 and the rest are sRGB's.
double linearLight(double screen)
{
    return screen <= 0.04045 ? screen / 12.92 : std::pow((screen + 0.055) / 1.055, 2.4);
}

std::vector<double> toDoubles(const Eigen::Vector3f& v)
{
    return {v.x(), v.y(), v.z()};
}

/// Vertices with one normal each.
struct Corners
{
    std::vector<Eigen::Vector3f> points;
    std::vector<Eigen::Vector3f> normals;
    std::vector<std::uint32_t> indices;
};

Corners cornersOf(const Shape& shape)
{
    Corners corners;
    std::vector<std::vector<std::uint32_t>> ofVertex(shape.vertices.size());
    for (std::size_t t = 0; t < shape.triangles.size(); ++t)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto vertex = static_cast<std::size_t>(shape.triangles[t][k]);
            // A normal must have length 1, also where a sliver has none.
            const Eigen::Vector3f& given = shape.normals[t][k];
            const Eigen::Vector3f normal =
                given.norm() > 0.5F ? given : Eigen::Vector3f(Eigen::Vector3f::UnitZ());
            std::vector<std::uint32_t>& known = ofVertex[vertex];
            const auto same =
                std::find_if(known.begin(),
                             known.end(),
                             [&](std::uint32_t i) { return corners.normals[i] == normal; });
            if (same != known.end())
            {
                corners.indices.push_back(*same);
                continue;
            }
            known.push_back(static_cast<std::uint32_t>(corners.points.size()));
            corners.indices.push_back(known.back());
            corners.points.emplace_back(shape.vertices[vertex].cast<float>());
            corners.normals.push_back(normal);
        }
    }
    return corners;
}
}  // namespace

GltfBuilder::GltfBuilder()
{
    m_model.asset.version = "2.0";
    m_model.asset.generator = "bullet_ccd " BULLET_CCD_VERSION;
    m_model.buffers.emplace_back();
    m_model.scenes.emplace_back();
    m_model.defaultScene = 0;
}

int GltfBuilder::addMaterial(const std::string& name, const Color& color, float opacity)
{
    tinygltf::Material& material = m_model.materials.emplace_back();
    material.name = name;
    material.pbrMetallicRoughness.baseColorFactor = {
        linearLight(color.x()), linearLight(color.y()), linearLight(color.z()), opacity};
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = 0.7;
    material.alphaMode = opacity < 1.0F ? "BLEND" : "OPAQUE";
    // Meshes are soups: their triangles may be wound either way.
    material.doubleSided = true;
    return static_cast<int>(m_model.materials.size()) - 1;
}

int GltfBuilder::addTriangles(const std::string& name, const Shape& shape, int material)
{
    const Corners corners = cornersOf(shape);
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = material;
    primitive.attributes["POSITION"] = addPoints(corners.points);
    primitive.attributes["NORMAL"] = addVectors(corners.normals);
    primitive.indices = addIndices(corners.indices);
    return addMesh(name, std::move(primitive));
}

int GltfBuilder::addLines(const std::string& name,
                          std::span<const Eigen::Vector3f> points,
                          std::span<const std::array<std::uint32_t, 2>> lines,
                          int material)
{
    std::vector<std::uint32_t> indices;
    for (const auto& [from, to] : lines)
    {
        indices.push_back(from);
        indices.push_back(to);
    }
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_LINE;
    primitive.material = material;
    primitive.attributes["POSITION"] = addPoints(points);
    primitive.indices = addIndices(indices);
    return addMesh(name, std::move(primitive));
}

int GltfBuilder::addNode(const std::string& name, int parent)
{
    return addNode(name, parent, kNone, Eigen::Isometry3d::Identity());
}

int GltfBuilder::addNode(const std::string& name,
                         int parent,
                         int mesh,
                         const Eigen::Isometry3d& pose,
                         const Eigen::Vector3d& scale)
{
    const auto index = static_cast<int>(m_model.nodes.size());
    tinygltf::Node& node = m_model.nodes.emplace_back();
    node.name = name;
    node.mesh = mesh;
    if (!pose.matrix().isIdentity(0.0))
    {
        const Eigen::Quaterniond q = Eigen::Quaterniond(pose.linear()).normalized();
        const Eigen::Vector3d& p = pose.translation();
        node.rotation = {q.x(), q.y(), q.z(), q.w()};
        node.translation = {p.x(), p.y(), p.z()};
    }
    if (scale != Eigen::Vector3d::Ones())
    {
        node.scale = {scale.x(), scale.y(), scale.z()};
    }
    if (parent == kNone)
    {
        m_model.scenes.front().nodes.push_back(index);
    }
    else
    {
        m_model.nodes[static_cast<std::size_t>(parent)].children.push_back(index);
    }
    return index;
}

template <typename T>
int GltfBuilder::addView(std::span<const T> values, int target)
{
    // All numbers have four bytes, so every view starts where it must: at a multiple of four.
    static_assert(sizeof(T) % 4 == 0);
    std::vector<unsigned char>& data = m_model.buffers.front().data;
    tinygltf::BufferView& view = m_model.bufferViews.emplace_back();
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = values.size_bytes();
    view.target = target;
    const auto* first = reinterpret_cast<const unsigned char*>(values.data());
    data.insert(data.end(), first, first + values.size_bytes());
    return static_cast<int>(m_model.bufferViews.size()) - 1;
}

int GltfBuilder::addVectors(std::span<const Eigen::Vector3f> vectors)
{
    const int view = addView(vectors, TINYGLTF_TARGET_ARRAY_BUFFER);
    tinygltf::Accessor& accessor = m_model.accessors.emplace_back();
    accessor.bufferView = view;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.type = TINYGLTF_TYPE_VEC3;
    accessor.count = vectors.size();
    return static_cast<int>(m_model.accessors.size()) - 1;
}

int GltfBuilder::addPoints(std::span<const Eigen::Vector3f> points)
{
    // Of points glTF wants the bounds besides.
    const int index = addVectors(points);
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& point : points)
    {
        box.extend(point);
    }
    tinygltf::Accessor& accessor = m_model.accessors.back();
    accessor.minValues = toDoubles(box.min());
    accessor.maxValues = toDoubles(box.max());
    return index;
}

int GltfBuilder::addIndices(std::span<const std::uint32_t> indices)
{
    const int view = addView(indices, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    tinygltf::Accessor& accessor = m_model.accessors.emplace_back();
    accessor.bufferView = view;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    accessor.type = TINYGLTF_TYPE_SCALAR;
    accessor.count = indices.size();
    return static_cast<int>(m_model.accessors.size()) - 1;
}

int GltfBuilder::addNumbers(std::span<const float> numbers, std::size_t count, int type)
{
    const int view = addView(numbers, 0);
    tinygltf::Accessor& accessor = m_model.accessors.emplace_back();
    accessor.bufferView = view;
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.type = type;
    accessor.count = count;
    return static_cast<int>(m_model.accessors.size()) - 1;
}

void GltfBuilder::animate(int node,
                          std::span<const float> times,
                          std::span<const Eigen::Isometry3d> poses)
{
    if (m_model.animations.empty())
    {
        m_model.animations.emplace_back();
    }
    std::vector<float> places;
    std::vector<float> turns;
    Eigen::Quaternionf last = Eigen::Quaternionf::Identity();
    for (const Eigen::Isometry3d& pose : poses)
    {
        const Eigen::Vector3f p = pose.translation().cast<float>();
        Eigen::Quaternionf q =
            Eigen::Quaterniond(pose.linear()).normalized().cast<float>().normalized();
        if (q.dot(last) < 0.0F)  // the shorter way
        {
            q.coeffs() = -q.coeffs();
        }
        last = q;
        places.insert(places.end(), {p.x(), p.y(), p.z()});
        turns.insert(turns.end(), {q.x(), q.y(), q.z(), q.w()});
    }
    const int input = addNumbers(times, times.size(), TINYGLTF_TYPE_SCALAR);
    m_model.accessors.back().minValues = {times.front()};
    m_model.accessors.back().maxValues = {times.back()};
    tinygltf::Animation& animation = m_model.animations.front();
    const auto add = [&](const char* path, int output)
    {
        animation.channels.emplace_back();
        animation.channels.back().sampler = static_cast<int>(animation.samplers.size());
        animation.channels.back().target_node = node;
        animation.channels.back().target_path = path;
        animation.samplers.emplace_back();
        animation.samplers.back().input = input;
        animation.samplers.back().output = output;
        animation.samplers.back().interpolation = "LINEAR";
    };
    add("translation", addNumbers(places, poses.size(), TINYGLTF_TYPE_VEC3));
    add("rotation", addNumbers(turns, poses.size(), TINYGLTF_TYPE_VEC4));
}

int GltfBuilder::addMesh(const std::string& name, tinygltf::Primitive primitive)
{
    tinygltf::Mesh& mesh = m_model.meshes.emplace_back();
    mesh.name = name;
    mesh.primitives.push_back(std::move(primitive));
    return static_cast<int>(m_model.meshes.size()) - 1;
}

void GltfBuilder::write(const std::filesystem::path& file) const
{
    std::ofstream out(file, std::ios::binary);
    const bool written = out && tinygltf::TinyGLTF().WriteGltfSceneToStream(
                                    &m_model, out, /*prettyPrint=*/false, /*writeBinary=*/true);
    out.close();
    if (!written || !out)
    {
        throw std::runtime_error(
            file.string() + ": cannot be written: does the folder exist, and is the disk full?");
    }
}
}  // namespace bullet_ccd::grasp
