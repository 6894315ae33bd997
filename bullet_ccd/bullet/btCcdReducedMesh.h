/// Shapes for the models of bodies that keep an accuracy. Programs that include this file link
/// bullet_ccd::reduce, too.
#ifndef BT_CCD_REDUCED_MESH_H
#define BT_CCD_REDUCED_MESH_H

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "bullet_ccd/reduce/reduce_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <cstddef>
#include <memory>
#include <utility>

/// The cheapest model of a body that keeps an accuracy, see bullet_ccd::reduceMesh(), for a world
/// of that accuracy (btCcdControl::setCcdAccuracy()): a stock sphere, capsule or box, whose
/// contacts are Bullet's own and cheap; else a mesh. Hulls are meshes, too, because Bullet's
/// contacts of so many corners are not cheaper.
class btCcdReducedMesh
{
public:
    /// The part of the accuracy by which a model may deviate from its body. Where two models meet,
    /// the bodies are up to twice as much nearer or farther: so they do not come into each other by
    /// the accuracy where meshes keep apart, and the rest is for stock shapes, which sink in.
    static constexpr double kShare = 0.4;

    /// Throws std::invalid_argument as reduceMesh() does.
    /// @param accuracy of the world [m]
    btCcdReducedMesh(const bullet_ccd::TriangleMesh& mesh, double accuracy)
        : m_model(*bullet_ccd::reduceMesh(mesh, {.accuracy = kShare * accuracy})),
          m_tree(
              std::make_shared<const bullet_ccd::SsvTree>(bullet_ccd::buildSsvTree(m_model.mesh)))
    {
    }

    /// In the frame of the mesh; all meshes share one hierarchy.
    /// @param margin of a mesh [m]
    [[nodiscard]] std::unique_ptr<btCollisionShape> makeShape(
        btScalar margin = btScalar(btCcdMeshShape::kDefaultMargin)) const
    {
        using bullet_ccd::ModelKind;
        std::unique_ptr<btCollisionShape> part;
        switch (m_model.kind)
        {
            case ModelKind::Sphere:
                part = std::make_unique<btSphereShape>(btScalar(m_model.radius));
                break;
            case ModelKind::Capsule:
                part = std::make_unique<btCapsuleShapeZ>(btScalar(m_model.radius),
                                                         btScalar(m_model.height));
                break;
            case ModelKind::Box:
                part = std::make_unique<btBoxShape>(btCcdToBullet(m_model.halfExtents));
                break;
            case ModelKind::Hull:
            case ModelKind::Mesh:
                return std::make_unique<btCcdMeshShape>(m_tree, margin);
        }
        return std::make_unique<Placed>(std::move(part), btCcdToBullet(m_model.pose));
    }
    [[nodiscard]] const bullet_ccd::ReducedModel& model() const { return m_model; }
    /// "sphere", "capsule", "box" or "mesh", and how many triangles that has.
    [[nodiscard]] const char* name() const
    {
        return bullet_ccd::modelKindName(isStock() ? m_model.kind : bullet_ccd::ModelKind::Mesh);
    }
    [[nodiscard]] std::size_t triangles() const
    {
        return isStock() ? 0 : m_model.mesh.triangles.size();
    }

private:
    [[nodiscard]] bool isStock() const
    {
        return m_model.kind != bullet_ccd::ModelKind::Hull &&
               m_model.kind != bullet_ccd::ModelKind::Mesh;
    }

    /// Owns what is in it.
    struct Placed : btCompoundShape
    {
        Placed(std::unique_ptr<btCollisionShape> part, const btTransform& pose)
            : btCompoundShape(false, 1), m_part(std::move(part))
        {
            addChildShape(pose, m_part.get());
        }
        std::unique_ptr<btCollisionShape> m_part;
    };

    bullet_ccd::ReducedModel m_model;
    std::shared_ptr<const bullet_ccd::SsvTree> m_tree;
};

#endif  // BT_CCD_REDUCED_MESH_H
