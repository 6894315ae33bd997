#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeContent.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeParts.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btPolyhedralConvexShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <utility>

using bullet_ccd::SsvTree;
using bullet_ccd::TriangleMesh;

namespace
{
/// Hash of what defines a shape. Asked for every shape in every step, so only a few numbers of
/// large shapes enter.
class Fingerprint : btCcdHash
{
public:
    explicit Fingerprint(const btCollisionShape& shape) { add(shape); }
    Fingerprint(int type, const btVector3& scaling, btScalar margin, std::uint64_t content)
    {
        add(type);
        add(scaling);
        add(margin);
        addBits(content);
    }
    using btCcdHash::value;

private:
    using btCcdHash::add;
    void add(const btCollisionShape& shape);
    void addBounds(const btCollisionShape& shape);
    void addSpheres(const btMultiSphereShape& spheres);
    void addVertices(const btPolyhedralConvexShape& polyhedron);
    void addMesh(const btStridingMeshInterface* mesh);
    void addGImpact(const btGImpactShapeInterface& shape);
    void addChildren(const btCompoundShape& compound);
};

void Fingerprint::addBounds(const btCollisionShape& shape)
{
    btVector3 low;
    btVector3 high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    add(low);
    add(high);
    add(shape.getMargin());
}

void Fingerprint::addSpheres(const btMultiSphereShape& spheres)
{
    add(spheres.getSphereCount());
    add(spheres.getLocalScaling());
    for (int i = 0; i < spheres.getSphereCount(); ++i)
    {
        add(spheres.getSpherePosition(i));
        add(spheres.getSphereRadius(i));
    }
}

/// All of up to four vertices, a sample of more.
void Fingerprint::addVertices(const btPolyhedralConvexShape& polyhedron)
{
    addBounds(polyhedron);
    const int last = polyhedron.getNumVertices() - 1;
    add(last);
    for (int k = 0; k <= std::min(last, 3); ++k)
    {
        btVector3 vertex;
        polyhedron.getVertex(last <= 3 ? k : int(std::int64_t(last) * k / 3), vertex);
        add(vertex);
    }
}

void Fingerprint::addMesh(const btStridingMeshInterface* mesh)
{
    add(mesh);
    add(mesh->getScaling());
    add(mesh->getNumSubParts());
    if (mesh->getNumSubParts() > 0)
    {
        btCcdVisitMeshPart(*mesh,
                           0,
                           [this](const btCcdMeshPart& part)
                           {
                               add(part.m_vertices);
                               add(part.m_indices);
                               add(part.m_vertexCount);
                               add(part.m_triangleCount);
                           });
    }
}

void Fingerprint::addGImpact(const btGImpactShapeInterface& shape)
{
    add(int(shape.getGImpactShapeType()));
    add(shape.getMargin());
    if (shape.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE_PART)
    {
        const auto& part = static_cast<const btGImpactMeshShapePart&>(shape);
        add(part.getPart());
        add(part.getLocalScaling());
        using Manager = btGImpactMeshShapePart::TrimeshPrimitiveManager;
        addMesh(static_cast<const Manager*>(part.getPrimitiveManager())->m_meshInterface);
    }
    else if (shape.getGImpactShapeType() == CONST_GIMPACT_TRIMESH_SHAPE)
    {
        const auto& mesh = static_cast<const btGImpactMeshShape&>(shape);
        for (int i = 0; i < mesh.getMeshPartCount(); ++i)
        {
            addGImpact(*mesh.getMeshPart(i));
        }
    }
}

void Fingerprint::addChildren(const btCompoundShape& compound)
{
    add(compound.getNumChildShapes());
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
    {
        const btTransform& pose = compound.getChildTransform(i);
        add(pose.getOrigin());
        add(pose.getBasis()[0]);
        add(pose.getBasis()[1]);
        add(pose.getBasis()[2]);
        add(compound.getChildShape(i));
        add(*compound.getChildShape(i));
    }
}

void Fingerprint::add(const btCollisionShape& shape)
{
    add(shape.getShapeType());
    switch (shape.getShapeType())
    {
        case BOX_SHAPE_PROXYTYPE:
        case SPHERE_SHAPE_PROXYTYPE:
            add(static_cast<const btConvexInternalShape&>(shape).getImplicitShapeDimensions());
            add(shape.getMargin());
            break;
        case CAPSULE_SHAPE_PROXYTYPE:
            add(static_cast<const btCapsuleShape&>(shape).getImplicitShapeDimensions());
            add(static_cast<const btCapsuleShape&>(shape).getUpAxis());
            break;
        case CYLINDER_SHAPE_PROXYTYPE:
            add(static_cast<const btCylinderShape&>(shape).getImplicitShapeDimensions());
            add(static_cast<const btCylinderShape&>(shape).getUpAxis());
            add(shape.getMargin());
            break;
        case CONE_SHAPE_PROXYTYPE:
            add(static_cast<const btConeShape&>(shape).getRadius());
            add(static_cast<const btConeShape&>(shape).getHeight());
            add(static_cast<const btConeShape&>(shape).getConeUpIndex());
            add(shape.getMargin());
            break;
        case MULTI_SPHERE_SHAPE_PROXYTYPE:
            addSpheres(static_cast<const btMultiSphereShape&>(shape));
            break;
        case CONVEX_HULL_SHAPE_PROXYTYPE:
        case CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE:
        case TETRAHEDRAL_SHAPE_PROXYTYPE:
        case TRIANGLE_SHAPE_PROXYTYPE:
            addVertices(static_cast<const btPolyhedralConvexShape&>(shape));
            break;
        case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE:
            addBounds(shape);
            addMesh(static_cast<const btConvexTriangleMeshShape&>(shape).getMeshInterface());
            break;
        case STATIC_PLANE_PROXYTYPE:
            add(static_cast<const btStaticPlaneShape&>(shape).getPlaneNormal());
            add(static_cast<const btStaticPlaneShape&>(shape).getPlaneConstant());
            break;
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
            addBounds(shape);
            addMesh(static_cast<const btBvhTriangleMeshShape&>(shape).getMeshInterface());
            break;
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
            addBounds(shape);
            addMesh(static_cast<const btScaledBvhTriangleMeshShape&>(shape)
                        .getChildShape()
                        ->getMeshInterface());
            break;
        case TERRAIN_SHAPE_PROXYTYPE:
            addBounds(shape);
            addBits(btCcdRevisionOf(shape));
            break;
        case GIMPACT_SHAPE_PROXYTYPE:
            addGImpact(static_cast<const btGImpactShapeInterface&>(shape));
            break;
        case FAST_CONCAVE_MESH_PROXYTYPE:
            if (const auto* mesh = dynamic_cast<const btCcdMeshShape*>(&shape))
            {
                add(mesh->sharedTree().get());
                add(mesh->getMargin());
            }
            break;
        case COMPOUND_SHAPE_PROXYTYPE:
            addChildren(static_cast<const btCompoundShape&>(shape));
            break;
        default:
            break;
    }
}

/// How far the farthest corner of the shape's box is from its origin.
double farthestCorner(const btCollisionShape& shape)
{
    btVector3 low;
    btVector3 high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    return btCcdToEigen(low).cwiseAbs().cwiseMax(btCcdToEigen(high).cwiseAbs()).norm();
}

void sumUp(btCcdShapeModel& model, const btCollisionShape& shape)
{
    model.m_depth = model.m_parts.front().m_depth;
    model.m_reach = 0.0;
    model.m_hasMesh = false;
    model.m_isOwn = true;
    model.m_reserve = std::numeric_limits<double>::infinity();
    for (const btCcdShapePart& part : model.m_parts)
    {
        model.m_depth = std::min(model.m_depth, part.m_depth);
        model.m_hasMesh = model.m_hasMesh || part.m_core == nullptr;
        const double share = btCcdShareOfMargin * part.m_margin;
        model.m_reserve = std::min(model.m_reserve, part.m_core == nullptr ? share : part.m_depth);
        model.m_isOwn = model.m_isOwn && part.m_ownContacts;
        if (part.m_ownContacts)
        {
            model.m_ownMargin = std::min(model.m_ownMargin, part.m_margin);
        }
        if (part.m_isPlane)
        {
            model.m_reach = btCcdPlaneReach;
        }
        if (part.m_tree == nullptr)
        {
            model.m_reach = std::max(model.m_reach, farthestCorner(shape));
            continue;
        }
        for (const Eigen::Vector3d& vertex : part.m_tree->mesh().vertices)
        {
            model.m_reach = std::max(model.m_reach,
                                     (part.X_SG * vertex).norm() + part.m_radius + part.m_margin);
        }
    }
}
/// Hulls and meshes that were converted last, of all worlds, by what defines them: whoever makes a
/// world anew like the one before, finds them again. Hulls of scanned parts take milliseconds each.
class RecentParts
{
public:
    static RecentParts& all()
    {
        static RecentParts recent;
        return recent;
    }
    /// Nothing for shapes that are quickly converted or not made of points.
    static std::optional<std::uint64_t> keyOf(const btCollisionShape& shape)
    {
        const int type = shape.getShapeType();
        const bool isHull =
            type == CONVEX_HULL_SHAPE_PROXYTYPE &&
            static_cast<const btConvexHullShape&>(shape).getNumPoints() > kFewPoints;
        if (!isHull && type != TRIANGLE_MESH_SHAPE_PROXYTYPE)
        {
            return std::nullopt;
        }
        return Fingerprint(shape.getShapeType(),
                           shape.getLocalScaling(),
                           shape.getMargin(),
                           btCcdContentOf(shape))
            .value();
    }
    std::optional<btCcdShapePart> find(std::uint64_t key)
    {
        const std::lock_guard lock(m_mutex);
        const auto found = m_parts.find(key);
        if (found == m_parts.end())
        {
            return std::nullopt;
        }
        found->second.m_used = ++m_clock;
        return found->second.m_part;
    }
    void keep(std::uint64_t key, const btCcdShapePart& part)
    {
        const std::lock_guard lock(m_mutex);
        if (m_parts.try_emplace(key, Kept{part, ++m_clock}).second)
        {
            m_triangles += trianglesOf(part);
        }
        while (m_triangles > kMostTriangles)
        {
            const auto oldest = std::min_element(m_parts.begin(),
                                                 m_parts.end(),
                                                 [](const auto& a, const auto& b)
                                                 { return a.second.m_used < b.second.m_used; });
            m_triangles -= trianglesOf(oldest->second.m_part);
            m_parts.erase(oldest);
        }
    }

private:
    static constexpr std::size_t kMostTriangles = 200'000;
    /// A hull of so few is made in less than a millisecond, and takes as much memory as a hundred
    /// triangles of a larger one.
    static constexpr int kFewPoints = 32;

    struct Kept
    {
        btCcdShapePart m_part;
        std::uint64_t m_used;
    };

    std::mutex m_mutex;
    std::unordered_map<std::uint64_t, Kept> m_parts;
    std::size_t m_triangles = 0;
    std::uint64_t m_clock = 0;

    static std::size_t trianglesOf(const btCcdShapePart& part)
    {
        return part.m_tree->mesh().triangles.size() +
               (part.m_core != nullptr ? part.m_core->mesh().triangles.size() : 0);
    }
};
}  // namespace

Eigen::Isometry3d btCcdMeshPose(const btCcdShapePart& part, const Eigen::Vector3d& point_S)
{
    Eigen::Isometry3d X_SG = part.X_SG;
    if (part.m_isPlane)
    {
        const Eigen::Vector3d normal = X_SG.linear().col(2);
        const Eigen::Vector3d offset = point_S - X_SG.translation();
        X_SG.translation() += offset - normal.dot(offset) * normal;
    }
    return X_SG;
}

std::shared_ptr<const SsvTree> btCcdTreeStore::tree(TriangleMesh mesh)
{
    std::weak_ptr<const SsvTree>& known = m_trees[bullet_ccd::contentHash(mesh)];
    std::shared_ptr<const SsvTree> tree = known.lock();
    if (tree == nullptr || tree->mesh().vertices != mesh.vertices ||
        tree->mesh().triangles != mesh.triangles)
    {
        const bool isKept = !m_folder.empty() && mesh.triangles.size() >= kLarge;
        tree = std::make_shared<const SsvTree>(
            isKept ? bullet_ccd::loadOrBuildSsvTree(std::move(mesh), m_folder)
                   : bullet_ccd::buildSsvTree(std::move(mesh)));
        known = tree;
    }
    return tree;
}

void btCcdTreeStore::keep(const SsvTree& tree) const
{
    if (m_folder.empty() || tree.mesh().triangles.size() < kLarge)
    {
        return;
    }
    const std::filesystem::path path = m_folder / bullet_ccd::ssvTreeFileName(tree.mesh());
    std::error_code error;
    if (std::filesystem::exists(path, error))
    {
        return;
    }
    std::filesystem::create_directories(m_folder, error);
    try
    {
        bullet_ccd::saveSsvTree(tree, path);
    }
    catch (const std::runtime_error&)
    {
        // It is built again next time.
    }
}

void btCcdTreeStore::dropUnused()
{
    std::erase_if(m_trees, [](const auto& item) { return item.second.expired(); });
}

void btCcdShapeCache::check(const btCollisionShape* shape)
{
    const auto known = m_entries.find(shape);
    if (known != m_entries.end() && known->second.m_content != btCcdContentOf(*shape))
    {
        forget(shape);
    }
}

const btCcdShapeModel* btCcdShapeCache::find(const btCollisionShape* shape)
{
    const std::uint64_t fingerprint = Fingerprint(*shape).value();
    Entry& entry = m_entries[shape];  // converting children does not move it
    if (entry.m_round == 0 || entry.m_fingerprint != fingerprint)
    {
        entry.m_model = convert(*shape);
        entry.m_fingerprint = fingerprint;
        entry.m_content = btCcdContentOf(*shape);
        entry.m_covered = !entry.m_model.m_parts.empty();
        if (entry.m_covered)
        {
            sumUp(entry.m_model, *shape);
        }
    }
    entry.m_round = m_round;
    return entry.m_covered ? &entry.m_model : nullptr;
}

bool btCcdIsEmpty(const btCollisionShape& shape)
{
    if (shape.getShapeType() != COMPOUND_SHAPE_PROXYTYPE)
    {
        return shape.getShapeType() == EMPTY_SHAPE_PROXYTYPE;
    }
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
    {
        if (!btCcdIsEmpty(*compound.getChildShape(i)))
        {
            return false;
        }
    }
    return true;
}

btCcdShapeModel btCcdShapeCache::convert(const btCollisionShape& shape)
{
    btCcdShapeModel model;
    if (shape.getShapeType() != COMPOUND_SHAPE_PROXYTYPE)
    {
        const std::optional<std::uint64_t> key = RecentParts::keyOf(shape);
        std::optional<btCcdShapePart> part = key ? RecentParts::all().find(*key) : std::nullopt;
        const bool isKnown = part.has_value();
        if (!isKnown)
        {
            part = btCcdConvertShape(shape, m_trees);
        }
        if (part)
        {
            if (key && !isKnown && part->m_tree != nullptr)  // a mesh in tiles reads from its shape
            {
                RecentParts::all().keep(*key, *part);
            }
            model.m_parts.push_back(*std::move(part));
        }
        return model;
    }
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
    {
        const btCollisionShape* shapeOfChild = compound.getChildShape(i);
        const btCcdShapeModel* child = find(shapeOfChild);
        if (child == nullptr)
        {
            model.m_uncovered = btCcdIsEmpty(*shapeOfChild) ? model.m_uncovered : shapeOfChild;
            continue;
        }
        model.m_uncovered = child->m_uncovered != nullptr ? child->m_uncovered : model.m_uncovered;
        const Eigen::Isometry3d X_SC = btCcdToEigen(compound.getChildTransform(i));
        for (const btCcdShapePart& part : child->m_parts)
        {
            model.m_parts.push_back(part);
            model.m_parts.back().X_SG = X_SC * part.X_SG;
        }
    }
    return model;
}

void btCcdShapeCache::endRound()
{
    ++m_round;
    if (m_round % kRoundsKept == 0)
    {
        std::erase_if(m_entries,
                      [this](const auto& item)
                      { return item.second.m_round < m_round - kRoundsKept; });
        m_trees.dropUnused();
    }
}

void btCcdShapeCache::keep(const btCcdShapeModel& model) const
{
    for (const btCcdShapePart& part : model.m_parts)
    {
        if (part.m_tree != nullptr)
        {
            m_trees.keep(*part.m_tree);
        }
        if (part.m_core != nullptr)
        {
            m_trees.keep(*part.m_core);
        }
    }
}

void btCcdShapeCache::forget(const btCollisionShape* shape)
{
    m_entries.erase(shape);
    if (shape->getShapeType() == COMPOUND_SHAPE_PROXYTYPE)
    {
        const auto& compound = static_cast<const btCompoundShape&>(*shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i)
        {
            forget(compound.getChildShape(i));
        }
    }
}
