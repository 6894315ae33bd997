#include "bullet_ccd/hierarchy/face_slabs.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/math/replace_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace bullet_ccd
{
namespace
{
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "files are written as memory is: a big-endian machine needs conversions");

/// Raise it whenever buildSsvTree() would give another tree for the same mesh, or the layout
/// changes.
constexpr std::uint32_t kVersion = 3;
/// Earlier versions of the library also wrote hierarchies of other volumes, with other numbers.
constexpr std::uint32_t kRoundedBoxes = 1;
constexpr std::array<char, 8> kMagic = {'S', 'S', 'V', 'T', 'R', 'E', 'E', '\n'};

/// Followed by the nodes and then by the triangle in each slot.
struct Header
{
    std::array<char, 8> magic = kMagic;
    std::uint32_t version = kVersion;
    std::uint32_t volumes = kRoundedBoxes;
    std::uint64_t meshHash = 0;
    std::uint64_t nodes = 0;
    std::uint64_t triangles = 0;
    std::uint64_t checksum = 0;  ///< of everything that follows
};
static_assert(sizeof(Header) == 48);

/// 64-bit hash of words: four sums that are multiplied and rotated independently, so that the
/// multiplications overlap. Not cryptographic; it finds damage and tells meshes apart.
class WordHash
{
public:
    void add(const void* data, std::size_t bytes)
    {
        const auto* const begin = static_cast<const char*>(data);
        for (std::size_t i = 0; i < bytes; i += sizeof(std::uint64_t))
        {
            std::uint64_t word = 0;
            std::memcpy(&word, begin + i, std::min(sizeof(word), bytes - i));
            std::uint64_t& lane = m_lanes[(i / sizeof(word)) % m_lanes.size()];
            lane = std::rotl((lane ^ word) * 0x9E3779B97F4A7C15U, 29);
        }
        m_bytes += bytes;
    }
    [[nodiscard]] std::uint64_t value() const
    {
        std::uint64_t hash = m_bytes;
        for (const std::uint64_t lane : m_lanes)
        {
            hash = (hash ^ (hash >> 32U) ^ lane) * 0xD6E8FEB86659FD93U;
        }
        return hash ^ (hash >> 32U);
    }

private:
    std::array<std::uint64_t, 4> m_lanes = {
        0x243F6A8885A308D3U, 0x13198A2E03707344U, 0xA4093822299F31D0U, 0x082EFA98EC4E6C89U};
    std::uint64_t m_bytes = 0;
};

std::uint64_t hashOf(const TriangleMesh& mesh)
{
    static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
    WordHash hash;
    const std::uint64_t vertices = mesh.vertices.size();
    hash.add(&vertices, sizeof(vertices));
    hash.add(mesh.vertices.data(), mesh.vertices.size() * sizeof(Eigen::Vector3d));
    hash.add(mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle));
    return hash.value();
}

std::uint64_t checksumOf(std::span<const SsvNode> nodes, std::span<const std::int32_t> triangles)
{
    WordHash hash;
    hash.add(nodes.data(), nodes.size_bytes());
    hash.add(triangles.data(), triangles.size_bytes());
    return hash.value();
}

template <typename T>
std::string_view bytesOf(std::span<const T> things)
{
    return {reinterpret_cast<const char*>(things.data()), things.size_bytes()};
}

[[noreturn]] void fail(const fs::path& path, const std::string& what)
{
    throw std::runtime_error(path.string() + ": " + what);
}

constexpr const char* kRebuild = ": build the hierarchy and save it again";

Header readHeader(std::istream& file,
                  std::uint64_t bytes,
                  const TriangleMesh& mesh,
                  const fs::path& path)
{
    Header header;
    file.read(reinterpret_cast<char*>(&header), sizeof(header));
    if (!file || header.magic != kMagic)
    {
        fail(path, "not a hierarchy of bullet_ccd: name a file that saveSsvTree() wrote");
    }
    if (header.version != kVersion)
    {
        fail(path,
             "version " + std::to_string(header.version) + " of the format, this library has " +
                 std::to_string(kVersion) + kRebuild);
    }
    if (header.volumes != kRoundedBoxes)
    {
        fail(path, std::string("it holds volumes that this library does not build") + kRebuild);
    }
    // The counts first: without them the hash of a changed mesh would be all that protects memory.
    const std::uint64_t triangles = mesh.triangles.size();
    if (header.triangles != triangles || header.meshHash != hashOf(mesh))
    {
        fail(path, std::string("made from another mesh") + kRebuild);
    }
    if (header.nodes < 1 || header.nodes >= 2 * triangles ||
        bytes != sizeof(Header) + header.nodes * sizeof(SsvNode) + triangles * sizeof(std::int32_t))
    {
        fail(path, std::string("truncated or damaged: the size is wrong") + kRebuild);
    }
    return header;
}

bool isFiniteVolume(const SsvNode& node)
{
    bool finite = std::isfinite(node.radius) && node.radius >= 0.0F &&
                  std::isfinite(node.coreRadius) && node.coreRadius >= 0.0F;
    for (int k = 0; k < 3; ++k)
    {
        finite = finite && std::isfinite(node.center[k]) && std::isfinite(node.axis0[k]) &&
                 std::isfinite(node.axis1[k]) && std::isfinite(node.half[k]) &&
                 node.half[k] >= 0.0F;
    }
    return finite;
}

/// True if the nodes are a tree in which children follow their parent, each slot has one leaf and
/// each triangle one slot, not deeper than a query can walk.
bool isTree(std::span<const SsvNode> nodes, std::span<const std::int32_t> triangles)
{
    const std::size_t slots = triangles.size();
    std::vector<bool> slotSeen(slots, false);
    std::vector<bool> triangleSeen(slots, false);
    std::vector<std::uint8_t> depth(nodes.size(), 0);  // 0: not reached yet
    depth[0] = 1;
    const auto deepest =
        static_cast<std::uint8_t>(8 + 6 * std::bit_width(static_cast<std::uint32_t>(slots)));
    std::size_t leaves = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
        const SsvNode& node = nodes[i];
        if (depth[i] == 0 || depth[i] > deepest || node.first < 0 || !isFiniteVolume(node))
        {
            return false;
        }
        const auto first = static_cast<std::size_t>(node.first);
        if (node.isLeaf())
        {
            if (first >= slots || slotSeen[first])
            {
                return false;
            }
            slotSeen[first] = true;
            ++leaves;
            continue;
        }
        if (node.count < 2 || node.count > kArity || first <= i ||
            first + static_cast<std::size_t>(node.count) > nodes.size())
        {
            return false;
        }
        for (std::size_t k = first; k < first + static_cast<std::size_t>(node.count); ++k)
        {
            if (depth[k] != 0)
            {
                return false;
            }
            depth[k] = static_cast<std::uint8_t>(depth[i] + 1);
        }
    }
    for (const std::int32_t triangle : triangles)
    {
        const auto index = static_cast<std::size_t>(triangle);
        if (triangle < 0 || index >= slots || triangleSeen[index])
        {
            return false;
        }
        triangleSeen[index] = true;
    }
    return leaves == slots;
}
bool isDoor(const SsvNode& node)
{
    return node.count == 1;
}

/// The nodes of a tree that is open, without doors.
std::vector<SsvNode> wholeNodes(std::span<const SsvNode> nodes)
{
    const auto behindDoors = [&](const SsvNode& node) -> const SsvNode&
    { return isDoor(node) ? nodes[static_cast<std::size_t>(node.first)] : node; };
    std::vector<SsvNode> whole{behindDoors(nodes[0])};
    for (std::size_t i = 0; i < whole.size(); ++i)
    {
        const SsvNode node = whole[i];
        whole[i].first = node.isLeaf() ? node.first : static_cast<std::int32_t>(whole.size());
        for (std::int32_t k = 0; k < node.count; ++k)
        {
            whole.push_back(behindDoors(nodes[static_cast<std::size_t>(node.first + k)]));
        }
    }
    return whole;
}
}  // namespace

void saveSsvTree(const SsvTree& tree, const fs::path& path)
{
    tree.openAll();
    const bool hasDoors = std::ranges::any_of(tree.nodes(), isDoor);
    const std::vector<SsvNode> whole = hasDoors ? wholeNodes(tree.nodes()) : std::vector<SsvNode>{};
    std::vector<std::int32_t> triangles(tree.mesh().triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
        triangles[i] = tree.triangle(static_cast<std::int32_t>(i));
    }
    const std::span<const SsvNode> nodes = hasDoors ? whole : tree.nodes();
    const Header header{.meshHash = hashOf(tree.mesh()),
                        .nodes = nodes.size(),
                        .triangles = triangles.size(),
                        .checksum = checksumOf(nodes, triangles)};

    if (replaceFile(path,
                    {bytesOf(std::span<const Header>(&header, 1)),
                     bytesOf(nodes),
                     bytesOf(std::span<const std::int32_t>(triangles))}))
    {
        fail(path, "cannot be written: check the folder, its permissions and the space on it");
    }
}

SsvTree loadSsvTree(TriangleMesh mesh, const fs::path& path)
{
    checkMesh(mesh, "loadSsvTree");
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file)
    {
        fail(path, "cannot be read: check the path and its permissions");
    }
    const auto bytes = static_cast<std::uint64_t>(file.tellg());
    file.seekg(0);
    const Header header = readHeader(file, bytes, mesh, path);

    SsvTree tree(std::move(mesh));
    tree.m_nodes.resize(header.nodes);
    std::vector<std::int32_t> triangles(header.triangles);
    file.read(reinterpret_cast<char*>(tree.m_nodes.data()),
              static_cast<std::streamsize>(tree.m_nodes.size() * sizeof(SsvNode)));
    file.read(reinterpret_cast<char*>(triangles.data()),
              static_cast<std::streamsize>(triangles.size() * sizeof(std::int32_t)));
    if (!file || header.checksum != checksumOf(tree.m_nodes, triangles) ||
        !isTree(tree.m_nodes, triangles))
    {
        fail(path, std::string("damaged: the content does not match its checksum") + kRebuild);
    }
    tree.m_faces = findFaceSlabs(tree.m_nodes, tree.place(triangles));
    return tree;
}

fs::path ssvTreeFileName(const TriangleMesh& mesh)
{
    std::ostringstream name;
    name << std::hex << std::setfill('0') << std::setw(16) << hashOf(mesh) << '_' << std::dec
         << kRoundedBoxes << "_v" << kVersion << ".ssv";
    return name.str();
}

SsvTree loadOrBuildSsvTree(TriangleMesh mesh, const fs::path& cacheFolder)
{
    checkMesh(mesh, "loadOrBuildSsvTree");
    const fs::path path = cacheFolder / ssvTreeFileName(mesh);
    std::error_code error;
    if (fs::exists(path, error))
    {
        try
        {
            return loadSsvTree(mesh, path);
        }
        catch (const std::runtime_error&)
        {
            // Stale or damaged: what is built now takes its place.
        }
    }
    SsvTree tree = buildSsvTree(std::move(mesh));
    fs::create_directories(cacheFolder, error);
    try
    {
        saveSsvTree(tree, path);
    }
    catch (const std::runtime_error&)
    {
        // The tree is right all the same.
    }
    return tree;
}
}  // namespace bullet_ccd
