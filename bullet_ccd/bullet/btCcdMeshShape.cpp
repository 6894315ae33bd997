#include "bullet_ccd/bullet/btCcdMeshShape.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/math/check.h"

#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <LinearMath/btAabbUtil2.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
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

class TriangleCollector : public btInternalTriangleIndexCallback
{
public:
    bullet_ccd::TriangleMesh m_mesh;

    void internalProcessTriangleIndex(btVector3* corners, int, int) override
    {
        const auto first = std::int32_t(m_mesh.vertices.size());
        for (int k = 0; k < 3; ++k)
        {
            m_mesh.vertices.push_back(btCcdToEigen(corners[k]));
        }
        m_mesh.triangles.push_back({first, first + 1, first + 2});
    }
};
}  // namespace

btCcdMeshShape::btCcdMeshShape(std::shared_ptr<const SsvTree> tree, btScalar margin)
    : m_tree(std::move(tree)), m_scaledTree(m_tree), m_scaling(1, 1, 1)
{
    bullet_ccd::require(m_tree != nullptr,
                        "btCcdMeshShape: the hierarchy is null: build one with buildSsvTree()");
    if (m_tree.use_count() == 0)
    {
        // It belongs to nobody, so nobody could tell when it goes.
        m_tree = m_scaledTree = std::make_shared<const SsvTree>(*m_tree);
    }
    // Not CUSTOM_CONCAVE_SHAPE_TYPE: it equals the type of signed distance fields, which stock code
    // would cast this shape to.
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
    bullet_ccd::require(std::isfinite(margin) && margin >= btScalar(0),
                        "btCcdMeshShape: margin " + std::to_string(margin) +
                            ": it must be finite and not negative");
    m_collisionMargin = margin;
    updateBounds();
}

std::unique_ptr<btCcdMeshShape> btCcdMeshShape::fromMesh(bullet_ccd::TriangleMesh mesh,
                                                         btScalar margin)
{
    bullet_ccd::checkMesh(mesh, "btCcdMeshShape::fromMesh");
    return std::make_unique<btCcdMeshShape>(
        std::make_shared<const SsvTree>(bullet_ccd::buildSsvTree(std::move(mesh))), margin);
}

std::unique_ptr<btCcdMeshShape> btCcdMeshShape::fromInterface(const btStridingMeshInterface* mesh,
                                                              btScalar margin)
{
    bullet_ccd::require(mesh != nullptr,
                        "btCcdMeshShape::fromInterface: the mesh is null: give the one that a "
                        "btBvhTriangleMeshShape would be made of");
    TriangleCollector collector;
    const btVector3 all(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    mesh->InternalProcessAllTriangles(&collector, -all, all);
    bullet_ccd::checkMesh(collector.m_mesh, "btCcdMeshShape::fromInterface");
    bullet_ccd::repairMesh(collector.m_mesh);
    return fromMesh(std::move(collector.m_mesh), margin);
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
            m_scaledTree->open(node);
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
    try
    {
        m_scaledTree = scaledTree(scaling);
    }
    catch (const std::invalid_argument& error)
    {
        std::fprintf(stderr, "bullet_ccd: %s; the scaling stays what it is\n", error.what());
        return;
    }
    m_scaling = scaling;
    updateBounds();
}

/// Throws std::invalid_argument for factors that are zero or not finite.
std::shared_ptr<const SsvTree> btCcdMeshShape::scaledTree(const btVector3& scaling) const
{
    for (int k = 0; k < 3; ++k)
    {
        const double factor = double(scaling[k]);
        bullet_ccd::require(std::isfinite(factor) && factor != 0.0,
                            "btCcdMeshShape::setLocalScaling: factor " + std::to_string(k) +
                                " is " + std::to_string(factor) +
                                ": it must be finite and not zero");
    }
    if (scaling == btVector3(1, 1, 1))
    {
        return m_tree;
    }
    bullet_ccd::TriangleMesh mesh = m_tree->mesh();
    bullet_ccd::transformMesh(mesh, Eigen::Affine3d(Eigen::Scaling(btCcdToEigen(scaling))));
    return std::make_shared<const SsvTree>(bullet_ccd::buildSsvTree(std::move(mesh)));
}

void btCcdMeshShape::setMargin(btScalar margin)
{
    if (!std::isfinite(margin) || margin < btScalar(0))
    {
        std::fprintf(stderr,
                     "bullet_ccd: btCcdMeshShape::setMargin: %g: it must be finite and not "
                     "negative; the margin stays %g\n",
                     double(margin),
                     double(m_collisionMargin));
        return;
    }
    m_collisionMargin = margin;
}

void btCcdMeshShape::calculateLocalInertia(btScalar mass, btVector3& inertia) const
{
    inertia = btCcdToBullet(
        Eigen::Vector3d(bullet_ccd::inertiaAtMass(m_scaledTree->mesh(), double(mass)).diagonal()));
}
