/// Mesh files as strings: one tetrahedron in every format, with corners (0,0,0), (1,0,0), (0,1,0),
/// (0,0,1): volume 1/6, wound outwards.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
inline constexpr std::array<std::array<float, 3>, 4> kTetraCorners = {
    {{0.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}, {0.0F, 0.0F, 1.0F}}};
inline constexpr std::array<std::array<std::uint16_t, 3>, 4> kTetraFaces = {
    {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};

/// Appends the bytes of a value (little endian machines).
template <class Value>
void appendBytes(std::string& bytes, const Value& value)
{
    char raw[sizeof(Value)];
    std::memcpy(raw, &value, sizeof(Value));
    bytes.append(raw, sizeof(Value));
}

inline std::string tetraObj()
{
    return "# tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
           "f 1 3 2\nf 1 2 4\nf 1//1 4//1 3//1\nf -3 -2 -1\n";
}

inline std::string tetraStlText()
{
    std::string text = "solid tetra\n";
    for (const auto& face : kTetraFaces)
    {
        text += " facet normal 0 0 0\n  outer loop\n";
        for (const std::uint16_t corner : face)
        {
            text += "   vertex";
            for (const float x : kTetraCorners[corner])
            {
                text += x > 0.5F ? " 1" : " 0";
            }
            text += '\n';
        }
        text += "  endloop\n endfacet\n";
    }
    return text + "endsolid tetra\n";
}

inline std::string tetraStlBinary()
{
    std::string bytes(80, ' ');
    appendBytes(bytes, std::uint32_t{4});
    for (const auto& face : kTetraFaces)
    {
        for (int k = 0; k < 3; ++k)
        {
            appendBytes(bytes, 0.0F);
        }
        for (const std::uint16_t corner : face)
        {
            for (const float x : kTetraCorners[corner])
            {
                appendBytes(bytes, x);
            }
        }
        appendBytes(bytes, std::uint16_t{0});
    }
    return bytes;
}

inline std::string tetraPlyText()
{
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
           "property float z\nelement face 4\nproperty list uchar int vertex_indices\n"
           "end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

inline std::string tetraPlyBinary()
{
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nelement face 4\n"
        "property list uchar int vertex_indices\nend_header\n";
    for (const auto& corner : kTetraCorners)
    {
        for (const float x : corner)
        {
            appendBytes(bytes, x);
        }
    }
    for (const auto& face : kTetraFaces)
    {
        appendBytes(bytes, std::uint8_t{3});
        for (const std::uint16_t corner : face)
        {
            appendBytes(bytes, std::int32_t{corner});
        }
    }
    return bytes;
}

inline std::string tetraOff()
{
    return "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
}

/// @param asset  content of <asset>, e.g. unit and up axis
/// @param matrix of the node, row by row
inline std::string tetraDae(const std::string& asset = "",
                            const std::string& matrix = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1")
{
    return "<?xml version=\"1.0\"?>\n"
           "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n"
           "<asset>" +
           asset +
           "</asset>\n<library_geometries><geometry id=\"g\" name=\"g\"><mesh>\n"
           "<source id=\"p\"><float_array id=\"pa\" count=\"12\">0 0 0 1 0 0 0 1 0 0 0 1"
           "</float_array><technique_common><accessor source=\"#pa\" count=\"4\" stride=\"3\">"
           "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
           "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>\n"
           "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\n"
           "<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
           "<p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>\n</mesh></geometry></library_geometries>\n"
           "<library_visual_scenes><visual_scene id=\"s\"><node id=\"n\"><matrix>" +
           matrix +
           "</matrix><instance_geometry url=\"#g\"/></node></visual_scene>"
           "</library_visual_scenes>\n<scene><instance_visual_scene url=\"#s\"/></scene>\n"
           "</COLLADA>\n";
}

/// Buffer of the glTF files: positions, then indices.
inline std::string tetraBuffer()
{
    std::string bytes;
    for (const auto& corner : kTetraCorners)
    {
        for (const float x : corner)
        {
            appendBytes(bytes, x);
        }
    }
    for (const auto& face : kTetraFaces)
    {
        for (const std::uint16_t corner : face)
        {
            appendBytes(bytes, corner);
        }
    }
    return bytes;
}

inline std::string tetraGltfJson(const std::string& buffer)
{
    return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
           "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
           "{\"POSITION\":0},\"indices\":1}]}],\"buffers\":[{" +
           buffer +
           "\"byteLength\":72}],\"bufferViews\":["
           "{\"buffer\":0,\"byteOffset\":0,\"byteLength\":48},"
           "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":24}],\"accessors\":["
           "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
           "\"min\":[0,0,0],\"max\":[1,1,1]},"
           "{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}]}";
}

inline std::string base64(const std::string& bytes)
{
    const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3)
    {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto byte = i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U;
            group = group << 8U | byte;
        }
        for (std::size_t k = 0; k < 4; ++k)
        {
            text += i + k <= bytes.size() ? digits[group >> (18U - 6U * k) & 63U] : '=';
        }
    }
    return text;
}

inline std::string tetraGltf()
{
    return tetraGltfJson("\"uri\":\"data:application/octet-stream;base64," + base64(tetraBuffer()) +
                         "\",");
}

inline std::string tetraGlb()
{
    std::string json = tetraGltfJson("");
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::string buffer = tetraBuffer();
    std::string bytes = "glTF";
    appendBytes(bytes, std::uint32_t{2});
    appendBytes(bytes, static_cast<std::uint32_t>(28 + json.size() + buffer.size()));
    appendBytes(bytes, static_cast<std::uint32_t>(json.size()));
    bytes += "JSON" + json;
    appendBytes(bytes, static_cast<std::uint32_t>(buffer.size()));
    bytes += std::string("BIN\0", 4) + buffer;
    return bytes;
}

/// Any mesh as binary STL.
inline std::string stlBinary(const TriangleMesh& mesh)
{
    std::string bytes(80, ' ');
    bytes.reserve(84 + 50 * mesh.triangles.size());
    appendBytes(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const Triangle& triangle : mesh.triangles)
    {
        bytes.append(12, '\0');
        for (const std::int32_t corner : triangle)
        {
            const Eigen::Vector3f v = mesh.vertices[static_cast<std::size_t>(corner)].cast<float>();
            bytes.append(reinterpret_cast<const char*>(v.data()), 12);
        }
        bytes.append(2, '\0');
    }
    return bytes;
}

/// File name and content.
inline std::vector<std::pair<std::string, std::string>> allTetraFiles()
{
    return {{"tetra.obj", tetraObj()},
            {"text.stl", tetraStlText()},
            {"binary.stl", tetraStlBinary()},
            {"text.ply", tetraPlyText()},
            {"binary.ply", tetraPlyBinary()},
            {"tetra.off", tetraOff()},
            {"tetra.dae", tetraDae()},
            {"tetra.gltf", tetraGltf()},
            {"tetra.glb", tetraGlb()}};
}
}  // namespace bullet_ccd::tests
