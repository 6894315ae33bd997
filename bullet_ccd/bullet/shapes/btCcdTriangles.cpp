#include "bullet_ccd/bullet/shapes/btCcdTriangles.h"

#include "bullet_ccd/math/check.h"

std::shared_ptr<const std::vector<btCcdTriangleId>> btCcdIdsOf(
    const bullet_ccd::TriangleMesh& repaired, const btCcdTriangleCollector& collected)
{
    auto ids = std::make_shared<std::vector<btCcdTriangleId>>();
    bool isPlain = true;
    for (std::size_t i = 0; i < collected.m_ids.size() && ids->size() < repaired.triangles.size();
         ++i)
    {
        bool isLeft = true;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto vertex = std::size_t(repaired.triangles[ids->size()][k]);
            isLeft = isLeft && repaired.vertices[vertex] == collected.m_mesh.vertices[3 * i + k];
        }
        if (isLeft)
        {
            isPlain = isPlain && collected.m_ids[i] == btCcdTriangleId{0, int(ids->size())};
            ids->push_back(collected.m_ids[i]);
        }
    }
    BULLET_CCD_ASSERT(ids->size() == repaired.triangles.size());
    return isPlain ? nullptr : ids;
}
