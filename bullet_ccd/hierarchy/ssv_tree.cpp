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

void SsvTree::placeCorners()
{
    m_corners.clear();
    m_corners.reserve(m_triangles.size());
    double radiusSquared = 0.0;
    for (const std::int32_t triangle : m_triangles)
    {
        m_corners.push_back(cornersOfTriangle(triangle));
        rotateToSmallest(m_corners.back());
        for (const Eigen::Vector3d& corner : m_corners.back())
        {
            radiusSquared = std::max(radiusSquared, corner.squaredNorm());
        }
    }
    m_radius = std::sqrt(radiusSquared);
}

void SsvTree::findFaces()
{
    m_faces = findFaceSlabs(m_nodes, m_corners);
}

void SsvTree::refit(std::span<const Eigen::Vector3d> vertices)
{
    require(vertices.size() == m_mesh.vertices.size(),
            "refit: " + std::to_string(vertices.size()) + " vertices for a mesh of " +
                std::to_string(m_mesh.vertices.size()) + ": give one for each");
    for (std::size_t i = 0; i < vertices.size(); ++i)
    {
        require(vertices[i].allFinite(),
                "refit: vertex " + std::to_string(i) + " is not finite: repair the deformation");
    }
    openAll();
    m_blocks = {};
    m_mesh.vertices.assign(vertices.begin(), vertices.end());
    m_origin = bounds(m_mesh).center();
    placeCorners();
    fitNodes(branchesOf(m_nodes), m_corners, m_nodes);
    findFaces();
}

namespace
{
void checkForTree(const TriangleMesh& mesh)
{
    checkMesh(mesh, "buildSsvTree");
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
    SsvTopology topology = splitTriangles(tree.m_mesh, tree.m_origin);
    tree.m_triangles = std::move(topology.triangles);
    tree.placeCorners();
    tree.m_nodes.resize(topology.branches.size());
    fitNodes(topology.branches, tree.m_corners, tree.m_nodes);
    tree.findFaces();
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
    tree.m_corners.resize(upper.triangles.size());
    const SsvBlock& last = upper.blocks.back();
    tree.m_nodes.resize(static_cast<std::size_t>(last.root + 2 * (last.end - last.begin) - 1));
    std::ranges::copy(upper.nodes, tree.m_nodes.begin());
    tree.m_faces = findUpperSlabs(upper, tree.m_mesh, tree.m_origin, tree.m_nodes.size());
    tree.m_triangles = std::move(upper.triangles);
    tree.m_blocks = SsvBlocksOwner(
        std::make_unique<SsvBlocks>(std::move(upper.blocks),
                                    SsvBlocks::Parts{.vertices = tree.m_mesh.vertices,
                                                     .meshTriangles = tree.m_mesh.triangles,
                                                     .origin = tree.m_origin,
                                                     .nodes = tree.m_nodes,
                                                     .corners = tree.m_corners,
                                                     .triangles = tree.m_triangles,
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
    return m_blocks.get() != nullptr ? m_blocks.get()->builtTriangles() : m_triangles.size();
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
