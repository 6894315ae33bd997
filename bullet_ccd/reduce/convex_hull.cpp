#include "bullet_ccd/reduce/convex_hull.h"

#include <array>
#include <cstdio>
#include <utility>
#include <vector>

extern "C"
{
#include <libqhull_r/libqhull_r.h>
#include <libqhull_r/mem_r.h>
#include <libqhull_r/qset_r.h>
}

namespace bullet_ccd
{
namespace
{
/// Owns the state of Qhull; its destructor returns all memory.
class HullOfPoints
{
public:
    HullOfPoints() : m_log(std::fopen("/dev/null", "w")) { qh_zero(&m_state, m_log); }
    HullOfPoints(const HullOfPoints&) = delete;
    HullOfPoints& operator=(const HullOfPoints&) = delete;
    ~HullOfPoints()
    {
        int longBlocks = 0;
        int longBytes = 0;
        qh_freeqhull(&m_state, !qh_ALL);
        qh_memfreeshort(&m_state, &longBlocks, &longBytes);
        if (m_log != nullptr)
        {
            std::fclose(m_log);
        }
    }

    /// Qt: facets are triangles. Pp: no reports of precision.
    bool build(std::vector<double>& coordinates)
    {
        char command[] = "qhull Qt Pp";
        return qh_new_qhull(&m_state,
                            3,
                            static_cast<int>(coordinates.size() / 3),
                            coordinates.data(),
                            False,
                            command,
                            nullptr,
                            m_log) == 0;
    }

    /// Triangles of points, wound outwards.
    [[nodiscard]] std::vector<Triangle> triangles()
    {
        std::vector<Triangle> result;
        for (facetT* facet = m_state.facet_list; facet != nullptr && facet->next != nullptr;
             facet = facet->next)
        {
            Triangle triangle{};
            std::size_t count = 0;
            for (setelemT* element = facet->vertices->e;
                 element->p != nullptr && count < triangle.size();
                 ++element)
            {
                const auto* vertex = static_cast<vertexT*>(element->p);
                triangle[count++] = qh_pointid(&m_state, vertex->point);
            }
            if ((facet->toporient ^ qh_ORIENTclock) != 0)
            {
                std::swap(triangle[1], triangle[2]);
            }
            result.push_back(triangle);
        }
        return result;
    }

private:
    qhT m_state;
    std::FILE* m_log;
};
}  // namespace

TriangleMesh convexHull(const TriangleMesh& mesh)
{
    std::vector<double> coordinates;
    coordinates.reserve(3 * mesh.vertices.size());
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        coordinates.insert(coordinates.end(), vertex.data(), vertex.data() + 3);
    }
    HullOfPoints hull;
    if (!hull.build(coordinates))
    {
        return {};
    }
    TriangleMesh result{.vertices = mesh.vertices, .triangles = hull.triangles()};
    repairMesh(result);
    if (massProperties(result).volume > 0.0 && isWatertight(result))
    {
        return result;
    }
    return {};
}
}  // namespace bullet_ccd
