#include "bullet_ccd/hierarchy/ssv_tree.h"

#include "bullet_ccd/hierarchy/face_slabs.h"
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
    m_mesh.vertices.assign(vertices.begin(), vertices.end());
    m_origin = bounds(m_mesh).center();
    placeCorners();
    fitNodes(branchesOf(m_nodes), m_corners, m_nodes);
    findFaces();
}

SsvTree buildSsvTree(TriangleMesh mesh)
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
    SsvTree tree(std::move(mesh));
    SsvTopology topology = splitTriangles(tree.m_mesh, tree.m_origin);
    tree.m_triangles = std::move(topology.triangles);
    tree.placeCorners();
    tree.m_nodes.resize(topology.branches.size());
    fitNodes(topology.branches, tree.m_corners, tree.m_nodes);
    tree.findFaces();
    return tree;
}
}  // namespace bullet_ccd
