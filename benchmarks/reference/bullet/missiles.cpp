#include "benchmarks/reference/bullet/missiles.h"

#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <cmath>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;

constexpr double kHalf = 0.005;
const Vector3d kBox(kHalf, kHalf, kHalf);
const Vector3d kPlate(kTargetHalf, kTargetHalf, 0.00025);
constexpr double kMargin = 2e-4;

TriangleMesh point(const Vector3d& p)
{
    return triangle(p, p, p);
}

Missile sphere()
{
    return {.name = "sphere",
            .make = [](Scene& scene)
            { return scene.keep(std::make_unique<btSphereShape>(btScalar(kHalf))); },
            .inside = {Vector3d::Zero()},
            .surface = point(Vector3d::Zero()),
            .radius = kHalf,
            .inner = kHalf};
}

Missile capsule()
{
    constexpr double kRadius = 0.003;
    return {.name = "capsule",
            .make =
                [](Scene& scene) {
                    return scene.keep(
                        std::make_unique<btCapsuleShape>(btScalar(kRadius), btScalar(2 * kHalf)));
                },
            .inside = {Vector3d::Zero(), {0, kHalf, 0}, {0, -kHalf, 0}},
            .surface = segment({0, -kHalf, 0}, {0, kHalf, 0}),
            .radius = kRadius,
            .inner = kRadius};
}

/// An octahedron.
Missile hull()
{
    const TriangleMesh surface = scaled(octahedron(), 1.5 * kHalf);
    return {.name = "convex hull",
            .make =
                [surface](Scene& scene)
            {
                auto shape = std::make_unique<btConvexHullShape>();
                for (const Vector3d& v : surface.vertices)
                {
                    shape->addPoint(btCcdToBullet(v));
                }
                shape->setMargin(btScalar(kMargin));
                return scene.keep(std::move(shape));
            },
            .inside = {Vector3d::Zero()},
            .surface = surface,
            .radius = kMargin,
            .inner = 1.5 * kHalf / std::sqrt(3.0)};
}

Missile cylinder()
{
    return {.name = "cylinder",
            .make =
                [](Scene& scene)
            {
                auto shape = std::make_unique<btCylinderShapeZ>(btCcdToBullet(kBox));
                shape->setMargin(btScalar(kMargin));
                return scene.keep(std::move(shape));
            },
            .inside = {Vector3d::Zero()},
            .surface = makeCylinder(kHalf, 2 * kHalf, 24),
            .radius = 0.0,
            .inner = kHalf};
}

Missile meshBox()
{
    Missile missile = boxMissile();
    missile.name = "mesh box";
    missile.make = [](Scene& scene) { return scene.boxMesh(btCcdToBullet(kBox)); };
    return missile;
}

Missile meshSphere()
{
    const TriangleMesh surface = makeSphere(kHalf, 1);
    return {.name = "mesh ball",
            .make = [surface](Scene& scene) { return scene.mesh(surface); },
            .inside = {Vector3d::Zero()},
            .surface = surface,
            .radius = 0.0,
            .inner = 0.9 * kHalf};
}

/// A child in a compound of its own.
Missile wrapped(Missile missile, const char* name)
{
    missile.make = [make = missile.make](Scene& scene)
    {
        auto compound = std::make_unique<btCompoundShape>();
        compound->addChildShape(btTransform::getIdentity(), make(scene));
        return scene.keep(std::move(compound));
    };
    missile.name = name;
    return missile;
}

/// Two balls far apart, nothing in the middle.
Missile dumbbell()
{
    constexpr double kRadius = 0.003;
    const Vector3d ends[] = {{0.012, 0, 0}, {-0.012, 0, 0}};
    const TriangleMesh surface = merged({point(ends[0]), point(ends[1])});
    return {.name = "compound of two balls",
            .make =
                [ends0 = ends[0], ends1 = ends[1]](Scene& scene)
            {
                auto compound = std::make_unique<btCompoundShape>();
                for (const Vector3d& end : {ends0, ends1})
                {
                    compound->addChildShape(
                        poseAt(btCcdToBullet(end)),
                        scene.keep(std::make_unique<btSphereShape>(btScalar(kRadius))));
                }
                return scene.keep(std::move(compound));
            },
            .inside = {ends[0], ends[1]},
            .surface = surface,
            .radius = kRadius,
            .inner = 0.0};
}

/// 60 mm long, turning end over end.
Missile rod(bool mesh)
{
    const Vector3d half(0.03, 0.002, 0.002);
    return {
        .name = mesh ? "spinning mesh rod" : "spinning rod",
        .make = [mesh, half](Scene& scene) -> btCollisionShape*
        {
            if (mesh)
            {
                return scene.boxMesh(btCcdToBullet(half));
            }
            return scene.box(btCcdToBullet(half));
        },
        .inside = {Vector3d::Zero(), {0.028, 0, 0}, {0.014, 0, 0}, {-0.014, 0, 0}, {-0.028, 0, 0}},
        .surface = makeBox(half),
        .radius = 0.0,
        .inner = 0.002,
        .spin = {3.0, 120.0, 60.0}};
}

/// GImpact refers to its triangles until it has been destroyed: they are its first base.
using Triangles = std::unique_ptr<btTriangleMesh>;
class OwningGImpactShape : private Triangles, public btGImpactMeshShape
{
public:
    OwningGImpactShape(Triangles triangles, double margin)
        : Triangles(std::move(triangles)), btGImpactMeshShape(get())
    {
        setMargin(btScalar(margin));
        updateBound();
    }
};

Missile gimpactBox()
{
    Missile missile = boxMissile();
    missile.name = "GImpact box";
    missile.make = [](Scene& scene) { return gimpactShape(scene, makeBox(kBox)); };
    return missile;
}

Target plate()
{
    return {.name = "plate",
            .make = [](Scene& scene) { return scene.box(btCcdToBullet(kPlate)); },
            .surface = makeBox(kPlate)};
}

Target meshPlate()
{
    return {.name = "mesh plate",
            .make = [](Scene& scene) { return scene.boxMesh(btCcdToBullet(kPlate)); },
            .surface = makeBox(kPlate)};
}

/// Two triangles, open, no inside.
Target sheet()
{
    const TriangleMesh surface = floorAt(0.0, kTargetHalf);
    return {.name = "static sheet",
            .make = [surface](Scene& scene) { return scene.staticMesh(surface); },
            .surface = surface};
}
}  // namespace

Missile boxMissile()
{
    return {.name = "box",
            .make = [](Scene& scene) { return scene.box(btCcdToBullet(kBox)); },
            .inside = {Vector3d::Zero()},
            .surface = makeBox(kBox),
            .radius = 0.0,
            .inner = kHalf};
}

std::unique_ptr<btCollisionShape> makeGimpactShape(const TriangleMesh& triangles, double margin)
{
    return std::make_unique<OwningGImpactShape>(bulletTriangles(triangles), margin);
}

btCollisionShape* gimpactShape(Scene& scene, const TriangleMesh& triangles)
{
    return scene.keep(makeGimpactShape(triangles, btCcdMeshShape::kDefaultMargin));
}

std::vector<Shot> shotsAtTargets()
{
    return {{boxMissile(), plate()},
            {boxMissile(), sheet()},
            {sphere(), plate()},
            {sphere(), sheet()},
            {capsule(), plate()},
            {hull(), sheet()},
            {cylinder(), plate()},
            {meshBox(), plate()},
            {meshBox(), meshPlate()},
            {meshBox(), sheet()},
            {meshSphere(), meshPlate()},
            {wrapped(boxMissile(), "compound of a box"), plate()},
            {wrapped(meshBox(), "compound of a mesh box"), meshPlate()},
            {dumbbell(), sheet()},
            {rod(false), plate()},
            {rod(true), meshPlate()},
            {gimpactBox(), plate()},
            {gimpactBox(), meshPlate()}};
}

std::vector<std::pair<Missile, Missile>> headOnPairs()
{
    return {
        {boxMissile(), boxMissile()},
        {sphere(), sphere()},
        {sphere(), hull()},
        {meshBox(), meshBox()},
        {meshBox(), boxMissile()},
        {meshSphere(), meshBox()},
        {wrapped(boxMissile(), "compound of a box"), wrapped(capsule(), "compound of a capsule")}};
}
}  // namespace bullet_ccd::reference
