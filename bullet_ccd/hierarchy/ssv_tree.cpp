#include "bullet_ccd/hierarchy/ssv_tree.h"

#include "bullet_ccd/hierarchy/face_slabs.h"
#include "bullet_ccd/hierarchy/ssv_blocks.h"
#include "bullet_ccd/hierarchy/ssv_fit.h"
#include "bullet_ccd/hierarchy/ssv_split.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// The slots below every node, which are adjacent: from the leaves up.
std::vector<SsvBranch> branchesOf(std::span<const SsvNode> nodes)
{
    std::vector<SsvBranch> branches(nodes.size());
    for (std::size_t i = nodes.size(); i-- > 0;)
    {
        const SsvNode& node = nodes[i];
        SsvBranch& branch = branches[i];
        branch = {
            .first = node.first, .count = node.count, .begin = node.first, .end = node.first + 1};
        if (!node.isLeaf())
        {
            const auto first = static_cast<std::size_t>(node.first);
            branch.begin = branches[first].begin;
            branch.end = branches[first].end;
            for (std::size_t k = 1; k < static_cast<std::size_t>(node.count); ++k)
            {
                branch.begin = std::min(branch.begin, branches[first + k].begin);
                branch.end = std::max(branch.end, branches[first + k].end);
            }
        }
    }
    return branches;
}
}  // namespace

SsvTree::SsvTree(TriangleMesh mesh) : m_mesh(std::move(mesh)), m_origin(bounds(m_mesh).center()) {}

std::array<Eigen::Vector3d, 3> SsvTree::cornersOfTriangle(std::int32_t triangle) const
{
    const Triangle& t = m_mesh.triangles[static_cast<std::size_t>(triangle)];
    SsvCorners c;
    for (std::size_t k = 0; k < 3; ++k)
    {
        c[k] = m_mesh.vertices[static_cast<std::size_t>(t[k])] - m_origin;
    }
    return c;
}

namespace
{
std::string toText(double x)
{
    std::ostringstream text;
    text << x;
    return text.str();
}
}  // namespace

/// Puts the triangles into their slots. Returns their corners.
std::vector<SsvCorners> SsvTree::place(std::span<const std::int32_t> triangles)
{
    m_slots.resize(triangles.size());
    std::vector<SsvCorners> corners(triangles.size());
    double radiusSquared = 0.0;
    for (std::size_t slot = 0; slot < triangles.size(); ++slot)
    {
        SsvCorners& here = corners[slot];
        here = cornersOfTriangle(triangles[slot]);
        const std::size_t first = smallestOf(here);
        std::rotate(here.begin(), here.begin() + static_cast<std::ptrdiff_t>(first), here.end());
        m_slots[slot] = slotOf(triangles[slot], first);
        for (const Eigen::Vector3d& corner : here)
        {
            radiusSquared = std::max(radiusSquared, corner.squaredNorm());
        }
    }
    m_radius = std::sqrt(radiusSquared);
    return corners;
}

void SsvTree::refit(std::span<const Eigen::Vector3d> vertices)
{
    require(vertices.size() == m_mesh.vertices.size(),
            [&]
            {
                return "refit: " + std::to_string(vertices.size()) + " vertices for a mesh of " +
                       std::to_string(m_mesh.vertices.size()) + ": give one for each";
            });
    for (std::size_t i = 0; i < vertices.size(); ++i)
    {
        require(vertices[i].allFinite(),
                [&] {
                    return "refit: vertex " + std::to_string(i) +
                           " is not finite: repair the deformation";
                });
    }
    openAll();
    m_blocks = {};
    m_mesh.vertices.assign(vertices.begin(), vertices.end());
    m_origin = bounds(m_mesh).center();
    std::vector<std::int32_t> triangles(m_slots.size());
    for (std::size_t slot = 0; slot < triangles.size(); ++slot)
    {
        triangles[slot] = triangle(static_cast<std::int32_t>(slot));
    }
    const std::vector<SsvCorners> corners = place(triangles);
    fitNodes(branchesOf(m_nodes), corners, m_nodes);
    m_faces = findFaceSlabs(m_nodes, corners);
}

namespace
{
void checkForTree(const TriangleMesh& mesh)
{
    checkMesh(mesh, "buildSsvTree");
    require(mesh.triangles.size() <= kMostSsvTriangles,
            "buildSsvTree: more than 2^30 - 1 triangles: divide the mesh");
    // Single precision squares lengths: far outside of this range they vanish or overflow.
    const double size = bounds(mesh).sizes().norm();
    if (!(size == 0.0 || (size > 1e-16 && size < 1e17)))  // its text is long in the making
    {
        require(false,
                "buildSsvTree: the mesh is " + toText(size) +
                    " across: choose a unit of length in which it is between 1e-16 and 1e17");
    }
}
}  // namespace

SsvTree buildSsvTree(TriangleMesh mesh)
{
    checkForTree(mesh);
    SsvTree tree(std::move(mesh));
    const SsvTopology topology = splitTriangles(tree.m_mesh, tree.m_origin);
    const std::vector<SsvCorners> corners = tree.place(topology.triangles);
    tree.m_nodes.resize(topology.branches.size());
    fitNodes(topology.branches, corners, tree.m_nodes);
    tree.m_faces = findFaceSlabs(tree.m_nodes, corners);
    return tree;
}

SsvTree buildSsvTreeAsNeeded(TriangleMesh mesh)
{
    if (mesh.triangles.size() < kLeastAsNeeded)
    {
        return buildSsvTree(std::move(mesh));
    }
    checkForTree(mesh);
    SsvTree tree(std::move(mesh));
    SsvUpperTree upper = splitIntoBlocks(tree.m_mesh, tree.m_origin);
    tree.m_radius = upper.radius;
    const SsvBlock& last = upper.blocks.back();
    tree.m_nodes.resize(static_cast<std::size_t>(last.root + 2 * (last.end - last.begin) - 1));
    std::ranges::copy(upper.nodes, tree.m_nodes.begin());
    tree.m_faces = findUpperSlabs(upper, tree.m_mesh, tree.m_origin, tree.m_nodes.size());
    tree.m_slots.reserve(upper.triangles.size());
    for (const std::int32_t triangle : upper.triangles)
    {
        tree.m_slots.push_back(slotOf(triangle, 0));
    }
    tree.m_blocks = SsvBlocksOwner(
        std::make_unique<SsvBlocks>(std::move(upper.blocks),
                                    SsvBlocks::Parts{.vertices = tree.m_mesh.vertices,
                                                     .meshTriangles = tree.m_mesh.triangles,
                                                     .origin = tree.m_origin,
                                                     .nodes = tree.m_nodes,
                                                     .slots = tree.m_slots,
                                                     .normals = tree.m_faces.normals,
                                                     .slabs = tree.m_faces.slabs}));
    return tree;
}

void SsvTree::buildBelow(const SsvNode& node) const
{
    if (m_blocks.get() != nullptr)
    {
        m_blocks.get()->build(node.first);
    }
}

void SsvTree::openAll() const
{
    if (m_blocks.get() != nullptr)
    {
        m_blocks.get()->buildAll();
    }
}

std::size_t SsvTree::builtTriangles() const
{
    return m_blocks.get() != nullptr ? m_blocks.get()->builtTriangles() : m_slots.size();
}

SsvBlocksOwner::SsvBlocksOwner() = default;

SsvBlocksOwner::SsvBlocksOwner(std::unique_ptr<SsvBlocks> blocks) : m_blocks(std::move(blocks)) {}

SsvBlocksOwner::SsvBlocksOwner(const SsvBlocksOwner& other)
{
    if (other.m_blocks != nullptr)
    {
        other.m_blocks->buildAll();
    }
}

SsvBlocksOwner& SsvBlocksOwner::operator=(const SsvBlocksOwner& other)
{
    *this = SsvBlocksOwner(other);
    return *this;
}

SsvBlocksOwner::SsvBlocksOwner(SsvBlocksOwner&&) noexcept = default;
SsvBlocksOwner& SsvBlocksOwner::operator=(SsvBlocksOwner&&) noexcept = default;
SsvBlocksOwner::~SsvBlocksOwner() = default;
}  // namespace bullet_ccd
