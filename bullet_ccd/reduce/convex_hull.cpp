#include "bullet_ccd/reduce/convex_hull.h"

#include "bullet_ccd/reduce/qhull_state.h"

#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
/// Triangles of points, wound outwards.
std::vector<Triangle> trianglesOf(QhullState& hull)
{
    qhT& state = hull.state();
    std::vector<Triangle> result;
    for (facetT* facet = state.facet_list; facet != nullptr && facet->next != nullptr;
         facet = facet->next)
    {
        Triangle triangle{};
        std::size_t count = 0;
        for (setelemT* element = facet->vertices->e;
             element->p != nullptr && count < triangle.size();
             ++element)
        {
            const auto* vertex = static_cast<vertexT*>(element->p);
            triangle[count++] = qh_pointid(&state, vertex->point);
        }
        if ((facet->toporient ^ qh_ORIENTclock) != 0)
        {
            std::swap(triangle[1], triangle[2]);
        }
        result.push_back(triangle);
    }
    return result;
}
}  // namespace

TriangleMesh convexHull(const TriangleMesh& mesh)
{
    std::vector<double> coordinates;
    coordinates.reserve(3 * mesh.vertices.size());
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        coordinates.insert(coordinates.end(), vertex.data(), vertex.data() + 3);
    }
    QhullState hull;
    char options[] = "qhull Qt Pp";  // Qt: facets are triangles. Pp: no reports of precision.
    if (!hull.build(options, coordinates.data(), 3, static_cast<int>(mesh.vertices.size())))
    {
        return {};
    }
    TriangleMesh result{.vertices = mesh.vertices, .triangles = trianglesOf(hull)};
    repairMesh(result);
    if (massProperties(result).volume > 0.0 && isWatertight(result))
    {
        return result;
    }
    return {};
}
}  // namespace bullet_ccd
