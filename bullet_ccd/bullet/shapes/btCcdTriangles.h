/// Triangles as Bullet hands them out.
#ifndef BT_CCD_TRIANGLES_H
#define BT_CCD_TRIANGLES_H

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"

#include <BulletCollision/CollisionShapes/btTriangleCallback.h>

/// Takes triangles from Bullet.
class btCcdTriangleCollector : public btTriangleCallback, public btInternalTriangleIndexCallback
{
public:
    btVector3 m_scaling = btVector3(1, 1, 1);
    bullet_ccd::TriangleMesh m_mesh;  // every triangle has vertices of its own
    std::vector<btCcdTriangleId> m_ids;

    void processTriangle(btVector3* corners, int part, int index) override
    {
        m_ids.push_back({part, index});
        const auto first = std::int32_t(m_mesh.vertices.size());
        for (int k = 0; k < 3; ++k)
        {
            m_mesh.vertices.push_back(btCcdToEigen(corners[k] * m_scaling));
        }
        m_mesh.triangles.push_back({first, first + 1, first + 2});
    }
    void internalProcessTriangleIndex(btVector3* corners, int part, int index) override
    {
        processTriangle(corners, part, index);
    }
};

/// Ids of the triangles that a repair has left, in their order; null if they are what they would be
/// without.
std::shared_ptr<const std::vector<btCcdTriangleId>> btCcdIdsOf(
    const bullet_ccd::TriangleMesh& repaired, const btCcdTriangleCollector& collected);

#endif  // BT_CCD_TRIANGLES_H
