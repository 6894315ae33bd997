/// Scenes of an articulated body among obstacles.
#pragma once

#include "bullet_ccd/toi/articulated_toi.h"

#include <utility>
#include <vector>

namespace bullet_ccd::reference
{
struct ArticulatedScene
{
    KinematicTree tree;
    JointMotion motion;
    std::vector<TriangleMesh> linkMeshes;
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs;
    std::vector<TriangleMesh> obstacles;
    std::vector<RigidMotion> obstacleMotions;
};

/// Hierarchies and bodies of a scene, which must outlive it.
class BuiltScene
{
public:
    explicit BuiltScene(const ArticulatedScene& scene);
    BuiltScene(const BuiltScene&) = delete;
    BuiltScene& operator=(const BuiltScene&) = delete;

    [[nodiscard]] ArticulatedBody body() const;
    [[nodiscard]] const std::vector<RigidBody>& obstacles() const { return m_obstacles; }
    [[nodiscard]] const SsvTree& linkTree(std::size_t link) const { return *m_links[link]; }

private:
    const ArticulatedScene& m_scene;
    std::vector<SsvTree> m_hierarchies;
    std::vector<const SsvTree*> m_links;
    std::vector<RigidBody> m_obstacles;
};

[[nodiscard]] ArticulatedToiResult query(const ArticulatedScene& scene,
                                         const ArticulatedToiOptions& options);
[[nodiscard]] ArticulatedToiResult query(const ArticulatedScene& scene, double tolerance);
}  // namespace bullet_ccd::reference
