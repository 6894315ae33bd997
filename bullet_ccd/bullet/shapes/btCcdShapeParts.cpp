#include "bullet_ccd/bullet/shapes/btCcdShapeParts.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/bullet/shapes/btCcdHullMesh.h"
#include "bullet_ccd/bullet/shapes/btCcdTiles.h"
#include "bullet_ccd/bullet/shapes/btCcdTriangles.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btPolyhedralConvexShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <utility>

using bullet_ccd::Triangle;
using bullet_ccd::TriangleMesh;

namespace
{
constexpr int kRoundSegments = 72;  // chord error r (1 - cos(pi / 72)) = 0.1 % of the radius

constexpr double kRoundDown = 1.0 - 1e-9;  // more than rounding can add to a depth

using Points = std::vector<Eigen::Vector3d>;

const btVector3& everywhere()
{
    static const btVector3 kLarge(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    return kLarge;
}

/// Turns what is about z to the given axis, pointing the same way.
Eigen::Isometry3d toAxis(int axis)
{
    return Eigen::Isometry3d(bullet_ccd::rotationBetween(
        Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Unit(Eigen::Index(axis))));
}

TriangleMesh alongAxis(TriangleMesh mesh, int axis)
{
    bullet_ccd::transformMesh(mesh, Eigen::Affine3d(toAxis(axis)));
    return mesh;
}

/// Distance of an inner point from the nearest face plane; 0 for a flat polytope.
double innerDepth(const TriangleMesh& polytope, const Eigen::Vector3d& inner)
{
    double depth = std::numeric_limits<double>::infinity();
    for (const Triangle& t : polytope.triangles)
    {
        const Eigen::Vector3d& a = polytope.vertices[std::size_t(t[0])];
        const Eigen::Vector3d& b = polytope.vertices[std::size_t(t[1])];
        const Eigen::Vector3d& c = polytope.vertices[std::size_t(t[2])];
        const Eigen::Vector3d normal = (b - a).cross(c - a);
        const double length = normal.norm();
        depth = length > 0.0 ? std::min(depth, normal.dot(a - inner) / length) : 0.0;
    }
    return std::max(depth, 0.0);
}

/// The polytope with its faces moved inwards by about `inset`, not merely scaled down: the ends of
/// something long must not be left without a core.
TriangleMesh insetMesh(const TriangleMesh& polytope, double inset)
{
    std::vector<double> coordinates;
    for (const Eigen::Vector3d& point : polytope.vertices)
    {
        coordinates.insert(coordinates.end(), point.data(), point.data() + 3);
    }
    btConvexHullComputer computer;
    computer.compute(coordinates.data(),
                     int(3 * sizeof(double)),
                     int(polytope.vertices.size()),
                     btScalar(inset),
                     btScalar(0));
    Points points;
    for (int i = 0; i < computer.vertices.size(); ++i)
    {
        points.push_back(btCcdToEigen(computer.vertices[i]));
    }
    return points.empty() ? TriangleMesh{} : btCcdHullMesh(points);
}

/// Smallest distance of a vertex of `core` from the planes of the polytope; negative outside.
double depthOf(const TriangleMesh& core, const TriangleMesh& polytope)
{
    double depth = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& vertex : core.vertices)
    {
        depth = std::min(depth, innerDepth(polytope, vertex));
    }
    return core.vertices.empty() ? 0.0 : depth;
}

/// Nothing for what has so many corners that a hierarchy is faster.
std::optional<btCcdExactShape> exactHull(const TriangleMesh& polytope, double radius)
{
    constexpr std::size_t kMostCorners = 32;
    if (polytope.vertices.size() == 1)
    {
        return btCcdExactShape{bullet_ccd::sphereShape(radius),
                               Eigen::Isometry3d(Eigen::Translation3d(polytope.vertices.front()))};
    }
    if (polytope.vertices.size() > kMostCorners)
    {
        return std::nullopt;
    }
    return btCcdExactShape{bullet_ccd::hullShape(polytope.vertices).rounded(radius)};
}

/// A convex polytope swept by a ball of radius r. If all of its planes are at least d from an inner
/// point, the core is the polytope inset by d / 2, swept by r / 2: a core point is x + b with x at
/// least d / 2 from all planes and |b| <= r / 2, so a ball of radius d / 2 + r - r / 2 about it is
/// inside the swept polytope. The depth is taken from the vertices of the core as they came out.
btCcdShapePart convexPart(TriangleMesh polytope, double radius, btCcdTreeStore& trees)
{
    const Eigen::Vector3d sum = std::accumulate(polytope.vertices.begin(),
                                                polytope.vertices.end(),
                                                Eigen::Vector3d(Eigen::Vector3d::Zero()));
    const Eigen::Vector3d mean = sum / double(polytope.vertices.size());
    btCcdShapePart part;
    part.m_radius = radius;
    part.m_coreRadius = 0.5 * radius;
    TriangleMesh core = polytope;
    double inset = 0.0;
    // What is flat has no depth but that of its radius; only rounding gives its inset one.
    if (bullet_ccd::isWatertight(polytope))
    {
        TriangleMesh insetCore = insetMesh(polytope, 0.5 * innerDepth(polytope, mean));
        if (const double depth = depthOf(insetCore, polytope); depth > 0.0)
        {
            core = std::move(insetCore);
            inset = depth;
        }
    }
    part.m_depth = (inset + 0.5 * radius) * kRoundDown;
    part.m_exact = exactHull(polytope, radius);
    if (part.m_depth > 0.0)
    {
        part.m_exactCore = exactHull(core, part.m_coreRadius);
        part.m_core = trees.tree(std::move(core));
    }
    part.m_tree = trees.tree(std::move(polytope));
    return part;
}

btCcdShapePart spherePart(double radius, btCcdTreeStore& trees)
{
    return convexPart(btCcdHullMesh({Eigen::Vector3d::Zero()}), radius, trees);
}

btCcdShapePart capsulePart(const btCapsuleShape& capsule, btCcdTreeStore& trees)
{
    const Eigen::Vector3d end =
        double(capsule.getHalfHeight()) * Eigen::Vector3d::Unit(Eigen::Index(capsule.getUpAxis()));
    btCcdShapePart part;
    part.m_tree = trees.tree(btCcdHullMesh({-end, end}));
    part.m_radius = double(capsule.getRadius());
    part.m_core = part.m_tree;
    part.m_coreRadius = 0.5 * part.m_radius;
    part.m_depth = btCcdCoreDepth(part.m_radius);
    const auto exact = [&end](double radius)
    {
        return btCcdExactShape{
            bullet_ccd::hullShape(std::array<Eigen::Vector3d, 2>{-end, end}).rounded(radius)};
    };
    part.m_exact = exact(part.m_radius);
    part.m_exactCore = exact(part.m_coreRadius);
    return part;
}

btCcdShapePart boxPart(const Eigen::Vector3d& half, btCcdTreeStore& trees)
{
    btCcdShapePart part;
    part.m_tree = trees.tree(bullet_ccd::makeBox(half));
    const double inner = half.minCoeff();
    const Eigen::Vector3d core = half.array() - 0.5 * inner;
    part.m_core = trees.tree(bullet_ccd::makeBox(core));
    part.m_depth = btCcdCoreDepth(inner);
    part.m_exact = btCcdExactShape{bullet_ccd::boxShape(half)};
    part.m_exactCore = btCcdExactShape{bullet_ccd::boxShape(core)};
    return part;
}

/// The hull of spheres of one radius is a swept polytope; of several radii it is not.
std::optional<btCcdShapePart> multiSpherePart(const btMultiSphereShape& spheres,
                                              btCcdTreeStore& trees)
{
    const Eigen::Vector3d scaling = btCcdToEigen(spheres.getLocalScaling());
    if (spheres.getSphereCount() == 0 || scaling.minCoeff() != scaling.maxCoeff())
    {
        return std::nullopt;
    }
    Points centers;
    for (int i = 0; i < spheres.getSphereCount(); ++i)
    {
        if (spheres.getSphereRadius(i) != spheres.getSphereRadius(0))
        {
            return std::nullopt;
        }
        centers.push_back(btCcdToEigen(spheres.getSpherePosition(i)).cwiseProduct(scaling));
    }
    return convexPart(
        btCcdHullMesh(centers), double(spheres.getSphereRadius(0)) * scaling.x(), trees);
}

btCcdShapePart polyhedronPart(const btPolyhedralConvexShape& polyhedron, btCcdTreeStore& trees)
{
    Points points;
    for (int i = 0; i < polyhedron.getNumVertices(); ++i)
    {
        btVector3 vertex;
        polyhedron.getVertex(i, vertex);
        points.push_back(btCcdToEigen(vertex));
    }
    return convexPart(btCcdHullMesh(points), double(polyhedron.getMargin()), trees);
}

/// In the order of the interface, so that shapes over the same one get the same mesh.
btCcdTriangleCollector collectTriangles(const btStridingMeshInterface& mesh,
                                        const btVector3& scaling = btVector3(1, 1, 1))
{
    btCcdTriangleCollector collector;
    collector.m_scaling = scaling;
    mesh.InternalProcessAllTriangles(&collector, -everywhere(), everywhere());
    return collector;
}

/// The core is inset by half of the depth of the middle, which is a little more than that of the
/// polyhedron.
btCcdShapePart cylinderPart(const btCylinderShape& cylinder, btCcdTreeStore& trees)
{
    const int axis = cylinder.getUpAxis();
    const double half = double(cylinder.getHalfExtentsWithMargin()[axis]);
    const double radius = double(cylinder.getRadius());
    btCcdShapePart part = convexPart(
        alongAxis(bullet_ccd::makeCylinder(radius, 2.0 * half, kRoundSegments), axis), 0.0, trees);
    part.m_exact = btCcdExactShape{bullet_ccd::cylinderShape(radius, half), toAxis(axis)};
    if (part.m_core != nullptr)
    {
        const double inset = 0.5 * std::min(radius, half);
        part.m_exactCore =
            btCcdExactShape{bullet_ccd::cylinderShape(radius - inset, half - inset), toAxis(axis)};
    }
    return part;
}

/// The same: the core is the cone scaled by a half about the centre of its inscribed sphere.
btCcdShapePart conePart(const btConeShape& cone, btCcdTreeStore& trees)
{
    const int axis = cone.getConeUpIndex();
    const double half = 0.5 * double(cone.getHeight());
    const double radius = double(cone.getRadius());
    const double margin = double(cone.getMargin());
    const TriangleMesh mesh =
        bullet_ccd::makeRevolved({{0.0, -half}, {radius, -half}, {0.0, half}}, kRoundSegments);
    btCcdShapePart part = convexPart(alongAxis(mesh, axis), margin, trees);
    part.m_exact =
        btCcdExactShape{bullet_ccd::coneShape(radius, half).rounded(margin), toAxis(axis)};
    if (part.m_core != nullptr)
    {
        const double inscribed = 2.0 * radius * half / (radius + std::hypot(radius, 2.0 * half));
        const Eigen::Translation3d middle(0.0, 0.0, inscribed - half);
        part.m_exactCore = btCcdExactShape{
            bullet_ccd::coneShape(0.5 * radius, 0.5 * half).rounded(part.m_coreRadius),
            toAxis(axis) * Eigen::Translation3d(0.5 * middle.translation())};
    }
    return part;
}

btCcdShapePart planePart(const btStaticPlaneShape& plane)
{
    const Eigen::Vector3d normal = btCcdToEigen(plane.getPlaneNormal()).normalized();
    btCcdShapePart part;
    part.m_isPlane = true;
    part.m_tree = btCcdPlanePiece(0.0);
    part.X_SG.linear() =
        bullet_ccd::rotationBetween(Eigen::Vector3d::UnitZ(), normal).toRotationMatrix();
    part.X_SG.translation() = double(plane.getPlaneConstant()) * normal;
    return part;
}

btCcdShapePart meshPart(const btCcdTriangleCollector& collected,
                        const btCollisionShape& shape,
                        btCcdTreeStore& trees)
{
    TriangleMesh mesh = collected.m_mesh;
    bullet_ccd::repairMesh(mesh);
    btCcdShapePart part;
    part.m_triangleIds = btCcdIdsOf(mesh, collected);
    part.m_tree = trees.tree(std::move(mesh));
    part.m_margin = double(shape.getMargin());
    return part;
}

/// Straight from the primitives: the shape's own traversal needs boxes that may not be up to date.
std::optional<btCcdShapePart> gimpactPart(const btGImpactShapeInterface& shape,
                                          btCcdTreeStore& trees)
{
    btCcdTriangleCollector collector;
    const auto collect = [&](const btGImpactShapeInterface& part, int index)
    {
        part.lockChildShapes();
        for (int i = 0; i < part.getNumChildShapes(); ++i)
        {
            btTriangleShapeEx triangle;
            part.getBulletTriangle(i, triangle);
            collector.processTriangle(triangle.m_vertices1, index, i);
        }
        part.unlockChildShapes();
    };
    switch (shape.getGImpactShapeType())
    {
        case CONST_GIMPACT_TRIMESH_SHAPE_PART:
            collect(shape, 0);
            break;
        case CONST_GIMPACT_TRIMESH_SHAPE:
        {
            const auto& mesh = static_cast<const btGImpactMeshShape&>(shape);
            for (int i = 0; i < mesh.getMeshPartCount(); ++i)
            {
                collect(*mesh.getMeshPart(i), i);
            }
            break;
        }
        default:
            return std::nullopt;
    }
    return meshPart(collector, shape, trees);
}

btCcdShapePart terrainPart(const btHeightfieldTerrainShape& terrain, btCcdTreeStore& trees)
{
    btCcdTriangleCollector collector;
    terrain.processAllTriangles(&collector, -everywhere(), everywhere());
    return meshPart(collector, terrain, trees);
}

btCcdShapePart scaledMeshPart(const btScaledBvhTriangleMeshShape& shape, btCcdTreeStore& trees)
{
    return meshPart(
        collectTriangles(*shape.getChildShape()->getMeshInterface(), shape.getLocalScaling()),
        shape,
        trees);
}

std::optional<btCcdShapePart> convert(const btCollisionShape& shape, btCcdTreeStore& trees)
{
    switch (shape.getShapeType())
    {
        case BOX_SHAPE_PROXYTYPE:
            return boxPart(
                btCcdToEigen(static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin()),
                trees);
        case SPHERE_SHAPE_PROXYTYPE:
            return spherePart(double(static_cast<const btSphereShape&>(shape).getRadius()), trees);
        case MULTI_SPHERE_SHAPE_PROXYTYPE:
            return multiSpherePart(static_cast<const btMultiSphereShape&>(shape), trees);
        case CAPSULE_SHAPE_PROXYTYPE:
            return capsulePart(static_cast<const btCapsuleShape&>(shape), trees);
        case CYLINDER_SHAPE_PROXYTYPE:
            return cylinderPart(static_cast<const btCylinderShape&>(shape), trees);
        case CONE_SHAPE_PROXYTYPE:
            return conePart(static_cast<const btConeShape&>(shape), trees);
        case CONVEX_HULL_SHAPE_PROXYTYPE:
        case CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE:
        case TETRAHEDRAL_SHAPE_PROXYTYPE:
        case TRIANGLE_SHAPE_PROXYTYPE:
            return polyhedronPart(static_cast<const btPolyhedralConvexShape&>(shape), trees);
        case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE:
            return convexPart(
                btCcdHullMesh(
                    collectTriangles(
                        *static_cast<const btConvexTriangleMeshShape&>(shape).getMeshInterface())
                        .m_mesh.vertices),
                double(shape.getMargin()),
                trees);
        case STATIC_PLANE_PROXYTYPE:
            return planePart(static_cast<const btStaticPlaneShape&>(shape));
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
            return meshPart(
                collectTriangles(
                    *static_cast<const btBvhTriangleMeshShape&>(shape).getMeshInterface()),
                shape,
                trees);
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
            return scaledMeshPart(static_cast<const btScaledBvhTriangleMeshShape&>(shape), trees);
        case TERRAIN_SHAPE_PROXYTYPE:
            return terrainPart(static_cast<const btHeightfieldTerrainShape&>(shape), trees);
        case GIMPACT_SHAPE_PROXYTYPE:
            return gimpactPart(static_cast<const btGImpactShapeInterface&>(shape), trees);
        default:
            return std::nullopt;
    }
}
}  // namespace

std::shared_ptr<const bullet_ccd::SsvTree> btCcdPlanePiece(double half)
{
    static std::mutex mutex;
    static std::map<double, std::shared_ptr<const bullet_ccd::SsvTree>> pieces;
    double size = 64.0;  // [m]
    while (size < half && size < btCcdPlaneReach)
    {
        size *= 4.0;
    }
    const std::lock_guard lock(mutex);
    std::shared_ptr<const bullet_ccd::SsvTree>& piece = pieces[size];
    if (piece == nullptr)
    {
        piece = std::make_shared<const bullet_ccd::SsvTree>(bullet_ccd::buildSsvTree(
            {{{-size, -size, 0.0}, {size, -size, 0.0}, {size, size, 0.0}, {-size, size, 0.0}},
             {Triangle{0, 1, 2}, Triangle{0, 2, 3}}}));
    }
    return piece;
}

std::optional<btCcdShapePart> btCcdConvertShape(const btCollisionShape& shape,
                                                btCcdTreeStore& trees)
{
    if (const auto* mesh = shape.getShapeType() == FAST_CONCAVE_MESH_PROXYTYPE
                               ? dynamic_cast<const btCcdMeshShape*>(&shape)
                               : nullptr)
    {
        btCcdShapePart part;
        part.m_tree = mesh->sharedTree();
        part.m_margin = double(mesh->getMargin());
        part.m_ownContacts = true;
        return part;
    }
    try
    {
        if (std::shared_ptr<btCcdTiles> tiles = btCcdTiles::of(shape))
        {
            btCcdShapePart part;
            part.m_tiles = std::move(tiles);
            part.m_margin = double(shape.getMargin());
            return part;
        }
        std::optional<btCcdShapePart> part = convert(shape, trees);
        if (part)
        {
            part->m_ownContacts = shape.getShapeType() == GIMPACT_SHAPE_PROXYTYPE;
        }
        return part;
    }
    catch (const std::invalid_argument&)
    {
        return std::nullopt;  // no hierarchy: empty, flat where it must not be, or not finite
    }
}
