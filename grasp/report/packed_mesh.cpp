#include "grasp/report/packed_mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kLargest = 65535.0;

/// Little-endian, whatever the machine is.
template <typename Number>
void append(std::vector<std::uint8_t>& bytes, Number value)
{
    for (std::size_t i = 0; i < sizeof(Number); ++i)
    {
        bytes.push_back(static_cast<std::uint8_t>((value >> (8 * i)) & 0xFFU));
    }
}
}  // namespace

std::string base64(std::span<const std::uint8_t> bytes)
{
    constexpr const char* kLetters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3)
    {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
        {
            group = group << 8U | (k < count ? bytes[i + k] : 0U);
        }
        for (std::size_t k = 0; k < 4; ++k)
        {
            text += k <= count ? kLetters[group >> (18 - 6 * k) & 0x3FU] : '=';
        }
    }
    return text;
}

PackedMesh packMesh(const TriangleMesh& mesh)
{
    PackedMesh packed;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        box.extend(vertex);
    }
    if (!box.isEmpty())
    {
        packed.origin = box.min();
        packed.step = box.sizes() / kLargest;
    }
    std::vector<std::uint8_t> bytes;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        for (int axis = 0; axis < 3; ++axis)
        {
            const double offset = vertex[axis] - packed.origin[axis];
            const double steps = packed.step[axis] > 0.0 ? offset / packed.step[axis] : 0.0;
            append(bytes, static_cast<std::uint16_t>(std::min(std::round(steps), kLargest)));
        }
    }
    packed.points = base64(bytes);
    bytes.clear();
    for (const Triangle& triangle : mesh.triangles)
    {
        for (const std::int32_t corner : triangle)
        {
            append(bytes, static_cast<std::uint32_t>(corner));
        }
    }
    packed.triangles = base64(bytes);
    return packed;
}
}  // namespace bullet_ccd::grasp
