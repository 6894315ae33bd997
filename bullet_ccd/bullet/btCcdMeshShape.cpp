#include "bullet_ccd/bullet/btCcdMeshShape.h"

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <LinearMath/btAabbUtil2.h>

#include <utility>
#include <vector>

using bullet_ccd::SsvNode;
using bullet_ccd::SsvTree;

namespace
{
bool meets(const SsvNode& node, const Eigen::Vector3d& low, const Eigen::Vector3d& high)
{
    const Eigen::Vector3d axis0(node.axis0[0], node.axis0[1], node.axis0[2]);
    const Eigen::Vector3d axis1(node.axis1[0], node.axis1[1], node.axis1[2]);
    const Eigen::Vector3d center(node.center[0], node.center[1], node.center[2]);
    const Eigen::Vector3d reach =
        (axis0.cwiseAbs() * double(node.half[0]) + axis1.cwiseAbs() * double(node.half[1]) +
         axis0.cross(axis1).cwiseAbs() * double(node.half[2]))
            .array() +
        double(node.radius);
    return ((center - reach).array() <= high.array()).all() &&
           ((center + reach).array() >= low.array()).all();
}
}  // namespace

btCcdMeshShape::btCcdMeshShape(std::shared_ptr<const SsvTree> tree, btScalar margin)
    : m_tree(std::move(tree)), m_scaledTree(m_tree), m_scaling(1, 1, 1)
{
    // Not CUSTOM_CONCAVE_SHAPE_TYPE: it equals the type of signed distance fields, which stock code
    // would cast this shape to.
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
    m_collisionMargin = margin;
    updateBounds();
}

void btCcdMeshShape::updateBounds()
{
    const Eigen::AlignedBox3d box = bullet_ccd::bounds(m_scaledTree->mesh());
    m_boundsMin = btCcdToBullet(Eigen::Vector3d(box.min()));
    m_boundsMax = btCcdToBullet(Eigen::Vector3d(box.max()));
}

void btCcdMeshShape::getAabb(const btTransform& X, btVector3& aabbMin, btVector3& aabbMax) const
{
    btTransformAabb(m_boundsMin, m_boundsMax, getMargin(), X, aabbMin, aabbMax);
}

void btCcdMeshShape::processAllTriangles(btTriangleCallback* callback,
                                         const btVector3& aabbMin,
                                         const btVector3& aabbMax) const
{
    const Eigen::Vector3d low = btCcdToEigen(aabbMin) - m_scaledTree->origin();
    const Eigen::Vector3d high = btCcdToEigen(aabbMax) - m_scaledTree->origin();
    const bullet_ccd::TriangleMesh& mesh = m_scaledTree->mesh();
    const std::span<const SsvNode> nodes = m_scaledTree->nodes();
    std::vector<std::int32_t> open{0};
    while (!open.empty())
    {
        const SsvNode& node = nodes[std::size_t(open.back())];
        open.pop_back();
        if (!meets(node, low, high))
        {
            continue;
        }
        if (!node.isLeaf())
        {
            for (std::int32_t k = 0; k < node.count; ++k)
            {
                open.push_back(node.first + k);
            }
            continue;
        }
        const std::int32_t triangle = m_scaledTree->triangle(node.first);
        btVector3 corners[3];
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::int32_t vertex = mesh.triangles[std::size_t(triangle)][k];
            corners[k] = btCcdToBullet(mesh.vertices[std::size_t(vertex)]);
        }
        callback->processTriangle(corners, 0, triangle);
    }
}

void btCcdMeshShape::setLocalScaling(const btVector3& scaling)
{
    if (scaling == m_scaling)
    {
        return;
    }
    m_scaling = scaling;
    bullet_ccd::TriangleMesh mesh = m_tree->mesh();
    bullet_ccd::transformMesh(mesh, Eigen::Affine3d(Eigen::Scaling(btCcdToEigen(scaling))));
    m_scaledTree = std::make_shared<const SsvTree>(bullet_ccd::buildSsvTree(std::move(mesh)));
    updateBounds();
}

void btCcdMeshShape::calculateLocalInertia(btScalar mass, btVector3& inertia) const
{
    const bullet_ccd::MassProperties solid = bullet_ccd::massProperties(m_scaledTree->mesh());
    const double density = solid.volume > 0.0 ? double(mass) / solid.volume : 0.0;
    inertia = btCcdToBullet(Eigen::Vector3d(density * solid.inertia.diagonal()));
}
