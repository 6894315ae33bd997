/// A triangle mesh with a bounding-volume hierarchy that may move.
#ifndef BT_CCD_MESH_SHAPE_H
#define BT_CCD_MESH_SHAPE_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <memory>

class btStridingMeshInterface;

/// Collision shape over a shared, immutable hierarchy. Rigid bodies and multibody links may use it,
/// moving or not. Stock Bullet collides it with convex shapes triangle by triangle, casts rays and
/// sweeps convex shapes at it and draws it; two of these shapes meet through btCcd's algorithm
/// only. It cannot be serialised.
///
/// The margin is what stock Bullet adds around the triangles in discrete contacts: resting contacts
/// settle at the sum of the two margins. Keep it above the tolerance of the world (see
/// btCcdMultiBodyDynamicsWorld::setCcdTolerance), then the solver holds what rests and the time of
/// impact stops what is too fast for it.
ATTRIBUTE_ALIGNED16(class)
BULLET_CCD_API btCcdMeshShape : public btConcaveShape
{
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    static constexpr double kDefaultMargin = 5e-4;  ///< [m]

    /// @param tree several shapes may share it; one that belongs to nobody (a std::shared_ptr that
    /// counts no owners) is copied
    /// Throws std::invalid_argument for null, and for a margin that is negative or not finite [m].
    explicit btCcdMeshShape(std::shared_ptr<const bullet_ccd::SsvTree> tree,
                            btScalar margin = btScalar(kDefaultMargin));

    /// From triangles as they are. Throws std::invalid_argument as buildSsvTree() does.
    static std::unique_ptr<btCcdMeshShape> fromMesh(bullet_ccd::TriangleMesh mesh,
                                                    btScalar margin = btScalar(kDefaultMargin));
    /// From what a btBvhTriangleMeshShape or btGImpactMeshShape is made of: all parts, the
    /// interface's scaling applied. A copy; equal vertices become one, triangles without area and
    /// second copies of a triangle are left out (triangle indices are those of tree().mesh()).
    /// Throws std::invalid_argument as buildSsvTree() does, or for null.
    static std::unique_ptr<btCcdMeshShape> fromInterface(
        const btStridingMeshInterface* mesh, btScalar margin = btScalar(kDefaultMargin));

    /// The hierarchy in force, local scaling applied.
    const bullet_ccd::SsvTree& tree() const
    {
        return *m_scaledTree;
    }
    const std::shared_ptr<const bullet_ccd::SsvTree>& sharedTree() const
    {
        return m_scaledTree;
    }

    void getAabb(const btTransform& X, btVector3& aabbMin, btVector3& aabbMax) const override;
    /// Reports the triangles whose bounding volumes meet the box, in no particular order; triangle
    /// indices are those of the mesh, the part is 0.
    void processAllTriangles(
        btTriangleCallback * callback, const btVector3& aabbMin, const btVector3& aabbMax)
        const override;
    /// A scaling other than the one in force builds a new hierarchy: O(n log n). Negative factors
    /// mirror. Factors that are zero or not finite are refused with a message on the standard error
    /// output, and the scaling stays what it is: Bullet calls this, and it knows no exceptions.
    void setLocalScaling(const btVector3& scaling) override;
    const btVector3& getLocalScaling() const override
    {
        return m_scaling;
    }
    /// A margin that is negative or not finite [m] is refused likewise.
    void setMargin(btScalar margin) override;
    /// Diagonal of the inertia of the enclosed solid about its centre of mass, in the axes of the
    /// mesh: put the mesh into its principal axes if the rest of the tensor matters.
    void calculateLocalInertia(btScalar mass, btVector3 & inertia) const override;
    const char* getName() const override
    {
        return "CcdMesh";
    }

private:
    std::shared_ptr<const bullet_ccd::SsvTree> m_tree;        // as given
    std::shared_ptr<const bullet_ccd::SsvTree> m_scaledTree;  // the same unless scaled
    btVector3 m_scaling;
    btVector3 m_boundsMin;  // of the scaled mesh
    btVector3 m_boundsMax;

    void updateBounds();
    [[nodiscard]] std::shared_ptr<const bullet_ccd::SsvTree> scaledTree(const btVector3& scaling)
        const;
};

#endif  // BT_CCD_MESH_SHAPE_H
