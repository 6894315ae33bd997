/// A triangle mesh with a bounding-volume hierarchy that may move.
#ifndef BT_CCD_MESH_SHAPE_H
#define BT_CCD_MESH_SHAPE_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <memory>
#include <vector>

class btBvhTriangleMeshShape;
class btCollisionWorld;
class btOptimizedBvh;
class btStridingMeshInterface;

/// Collision shape over a shared, immutable hierarchy. Rigid bodies and multibody links may use it,
/// moving or not. Stock Bullet collides it with convex shapes triangle by triangle, casts rays and
/// sweeps convex shapes at it and draws it; two of these shapes meet through btCcd's algorithm
/// only.
///
/// Files: btSerializer writes it as a static triangle mesh, which every loader of .bullet files
/// reads. btCcdImporter makes it what it was, bit for bit, on bodies that move; the hierarchy is
/// built again.
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

    /// The shape that was saved, from the mesh interface that a loader has made of it: the same
    /// bits, and the hierarchy that buildSsvTree() gives. Null for any other mesh. Throws
    /// std::invalid_argument as buildSsvTree() does for a damaged one.
    static std::unique_ptr<btCcdMeshShape> fromSaved(const btStridingMeshInterface* mesh);

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
    /// mesh: put the mesh into its principal axes if the rest of the tensor matters. A sheet has
    /// that of its flat bounding box.
    void calculateLocalInertia(btScalar mass, btVector3 & inertia) const override;
    const char* getName() const override
    {
        return "CcdMesh";
    }

    int calculateSerializeBufferSize() const override;
    /// Fills in a btTriangleMeshShapeData.
    const char* serialize(void* dataBuffer, btSerializer* serializer) const override;

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

/// For loaders: stands for a saved mesh until btCcdRestoreMeshes(), with its box and inertia, and
/// is the caller's. Null for any other mesh, and, with a message on the standard error output, for
/// one that is damaged.
BULLET_CCD_API btBvhTriangleMeshShape* btCcdStandInForSaved(btStridingMeshInterface* mesh);
/// Puts the meshes in the place of what stands for them, in all objects of the world and in their
/// compounds.
/// @return the meshes, which must live as long as the objects use them
BULLET_CCD_API std::vector<std::shared_ptr<btCcdMeshShape>> btCcdRestoreMeshes(
    btCollisionWorld& world);

/// Loader of .bullet files that hold btCcdMeshShapes: `Importer` is btBulletWorldImporter or
/// another btWorldImporter (Bullet's extras; Debian's libbullet-extras-dev).
///
///     btCcdImporter<btBulletWorldImporter> importer(&world);
///     importer.loadFile("scene.bullet");
///     const auto meshes = btCcdRestoreMeshes(world);  // before the first step
template <class Importer>
class btCcdImporter : public Importer
{
public:
    using Importer::Importer;

    btBvhTriangleMeshShape* createBvhTriangleMeshShape(btStridingMeshInterface* mesh,
                                                       btOptimizedBvh* bvh) override
    {
        btBvhTriangleMeshShape* shape = btCcdStandInForSaved(mesh);
        if (shape == nullptr)
        {
            return Importer::createBvhTriangleMeshShape(mesh, bvh);
        }
        this->m_allocatedCollisionShapes.push_back(shape);
        return shape;
    }
};

#endif  // BT_CCD_MESH_SHAPE_H
