#include "benchmarks/reference/scenes/articulated_scene.h"

namespace bullet_ccd::reference
{
BuiltScene::BuiltScene(const ArticulatedScene& scene) : m_scene(scene)
{
    m_hierarchies.reserve(scene.linkMeshes.size() + scene.obstacles.size());
    for (const TriangleMesh& mesh : scene.linkMeshes)
    {
        if (!mesh.triangles.empty())
        {
            m_hierarchies.push_back(buildSsvTree(mesh));
        }
        m_links.push_back(mesh.triangles.empty() ? nullptr : &m_hierarchies.back());
    }
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    {
        m_hierarchies.push_back(buildSsvTree(scene.obstacles[i]));
        m_obstacles.push_back({&m_hierarchies.back(), scene.obstacleMotions[i]});
    }
}

ArticulatedBody BuiltScene::body() const
{
    return {.tree = &m_scene.tree,
            .linkTrees = m_links,
            .motion = &m_scene.motion,
            .selfPairs = m_scene.selfPairs};
}

ArticulatedToiResult query(const ArticulatedScene& scene, const ArticulatedToiOptions& options)
{
    const BuiltScene built(scene);
    ToiWorkspace work;
    return articulatedToi(built.body(), Environment(built.obstacles()), options, work);
}

ArticulatedToiResult query(const ArticulatedScene& scene, double tolerance)
{
    const BuiltScene built(scene);
    ToiWorkspace work;
    return articulatedToi(built.body(), built.obstacles(), {.tolerance = tolerance}, work);
}
}  // namespace bullet_ccd::reference
