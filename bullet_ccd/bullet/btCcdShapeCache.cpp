#include "bullet_ccd/bullet/btCcdShapeCache.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/mesh/make_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <LinearMath/btConvexHullComputer.h>

#include <optional>
#include <utility>

using bullet_ccd::Triangle;
using bullet_ccd::TriangleMesh;

namespace
{
constexpr int kSphereSubdivisions = 4;
constexpr int kRoundSegments = 72;    // chord error r (1 - cos(pi / 72)) = 0.1 % of the radius
constexpr double kPlaneHalf = 500.0;  // [m]

class TriangleCollector : public btTriangleCallback
{
public:
    TriangleMesh m_mesh;

    void processTriangle(btVector3* corners, int, int) override
    {
        const auto first = std::int32_t(m_mesh.vertices.size());
        for (int k = 0; k < 3; ++k)
        {
            m_mesh.vertices.push_back(btCcdToEigen(corners[k]));
        }
        m_mesh.triangles.push_back({first, first + 1, first + 2});
    }
};

TriangleMesh collectTriangles(const btConcaveShape& shape)
{
    TriangleCollector collector;
    const btVector3 all(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    shape.processAllTriangles(&collector, -all, all);
    bullet_ccd::repairMesh(collector.m_mesh);
    return std::move(collector.m_mesh);
}

TriangleMesh hullMesh(const btConvexHullShape& shape)
{
    btAlignedObjectArray<btVector3> points;
    for (int i = 0; i < shape.getNumPoints(); ++i)
    {
        points.push_back(shape.getScaledPoint(i));
    }
    btConvexHullComputer computer;
    computer.compute(&points[0].x(), int(sizeof(btVector3)), points.size(), 0, 0);

    // The computer works on rounded coordinates, but names the point that each vertex came from.
    TriangleMesh mesh;
    for (int i = 0; i < computer.vertices.size(); ++i)
    {
        mesh.vertices.push_back(btCcdToEigen(points[computer.original_vertex_index[i]]));
    }
    for (int i = 0; i < computer.faces.size(); ++i)
    {
        const auto* first = &computer.edges[computer.faces[i]];
        const auto* edge = first->getNextEdgeOfFace();
        for (; edge->getTargetVertex() != first->getSourceVertex();
             edge = edge->getNextEdgeOfFace())
        {
            mesh.triangles.push_back(
                {first->getSourceVertex(), edge->getSourceVertex(), edge->getTargetVertex()});
        }
    }
    if (mesh.triangles.empty() && !mesh.vertices.empty())
    {
        // A hull without faces (a point, a segment): still something to hit.
        const auto last = std::int32_t(mesh.vertices.size()) - 1;
        mesh.triangles.push_back({0, last, last});
    }
    return mesh;
}

TriangleMesh planeMesh(const btStaticPlaneShape& plane)
{
    const Eigen::Vector3d normal = btCcdToEigen(plane.getPlaneNormal()).normalized();
    const Eigen::Vector3d center = normal * double(plane.getPlaneConstant());
    const Eigen::Vector3d side = kPlaneHalf * normal.unitOrthogonal();
    const Eigen::Vector3d other = normal.cross(side);
    return {{center - side - other,
             center + side - other,
             center + side + other,
             center - side + other},
            {Triangle{0, 1, 2}, Triangle{0, 2, 3}}};
}

/// Turns a mesh about z into one about the given axis.
TriangleMesh alongAxis(TriangleMesh mesh, int axis)
{
    bullet_ccd::transformMesh(
        mesh,
        Eigen::Affine3d(Eigen::Quaterniond::FromTwoVectors(
            Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Unit(Eigen::Index(axis)))));
    return mesh;
}

TriangleMesh cylinderMesh(const btCylinderShape& cylinder)
{
    const double height = 2.0 * double(cylinder.getHalfExtentsWithMargin()[cylinder.getUpAxis()]);
    return alongAxis(bullet_ccd::makeCylinder(double(cylinder.getRadius()), height, kRoundSegments),
                     cylinder.getUpAxis());
}

TriangleMesh capsuleMesh(const btCapsuleShape& capsule)
{
    return alongAxis(
        bullet_ccd::makeCapsule(
            double(capsule.getRadius()), 2.0 * double(capsule.getHalfHeight()), kRoundSegments),
        capsule.getUpAxis());
}

std::optional<TriangleMesh> makeStockMesh(const btCollisionShape& shape)
{
    switch (shape.getShapeType())
    {
        case BOX_SHAPE_PROXYTYPE:
            return bullet_ccd::makeBox(
                btCcdToEigen(static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin()));
        case CONVEX_HULL_SHAPE_PROXYTYPE:
            return hullMesh(static_cast<const btConvexHullShape&>(shape));
        case SPHERE_SHAPE_PROXYTYPE:
            return bullet_ccd::makeSphere(
                double(static_cast<const btSphereShape&>(shape).getRadius()), kSphereSubdivisions);
        case CAPSULE_SHAPE_PROXYTYPE:
            return capsuleMesh(static_cast<const btCapsuleShape&>(shape));
        case CYLINDER_SHAPE_PROXYTYPE:
            return cylinderMesh(static_cast<const btCylinderShape&>(shape));
        case STATIC_PLANE_PROXYTYPE:
            return planeMesh(static_cast<const btStaticPlaneShape&>(shape));
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case TERRAIN_SHAPE_PROXYTYPE:
            return collectTriangles(static_cast<const btConcaveShape&>(shape));
        default:
            return std::nullopt;
    }
}
}  // namespace

void btCcdShapeCache::beginRound()
{
    std::erase_if(m_entries, [this](const auto& item) { return item.second.m_round != m_round; });
    ++m_round;
}

bool btCcdShapeCache::appendParts(const btCollisionShape* shape, std::vector<btCcdShapePart>& parts)
{
    const std::size_t before = parts.size();
    const bool covered = append(shape, Eigen::Isometry3d::Identity(), parts);
    if (!covered)
    {
        parts.resize(before);
    }
    return covered;
}

bool btCcdShapeCache::append(const btCollisionShape* shape,
                             const Eigen::Isometry3d& X_SG,
                             std::vector<btCcdShapePart>& parts)
{
    if (shape->getShapeType() == COMPOUND_SHAPE_PROXYTYPE)
    {
        const auto& compound = static_cast<const btCompoundShape&>(*shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i)
        {
            const Eigen::Isometry3d X_SC = X_SG * btCcdToEigen(compound.getChildTransform(i));
            if (!append(compound.getChildShape(i), X_SC, parts))
            {
                return false;
            }
        }
        return true;
    }
    if (const auto* mesh = dynamic_cast<const btCcdMeshShape*>(shape))
    {
        parts.push_back({&mesh->tree(), X_SG, false});
        return true;
    }
    const bullet_ccd::SsvTree* tree = convert(shape);
    if (tree != nullptr)
    {
        parts.push_back({tree, X_SG, true});
    }
    return tree != nullptr;
}

const bullet_ccd::SsvTree* btCcdShapeCache::convert(const btCollisionShape* shape)
{
    btVector3 low;
    btVector3 high;
    shape->getAabb(btTransform::getIdentity(), low, high);
    if (const auto found = m_entries.find(shape); found != m_entries.end())
    {
        Entry& entry = found->second;
        if (entry.m_type == shape->getShapeType() && entry.m_boundsMin == low &&
            entry.m_boundsMax == high && entry.m_scaling == shape->getLocalScaling())
        {
            entry.m_round = m_round;
            return &entry.m_tree;
        }
        m_entries.erase(found);
    }
    std::optional<TriangleMesh> mesh = makeStockMesh(*shape);
    if (!mesh || mesh->triangles.empty())
    {
        return nullptr;
    }
    Entry entry{bullet_ccd::buildSsvTree(*std::move(mesh)),
                shape->getShapeType(),
                shape->getLocalScaling(),
                low,
                high,
                m_round};
    return &m_entries.emplace(shape, std::move(entry)).first->second.m_tree;
}
