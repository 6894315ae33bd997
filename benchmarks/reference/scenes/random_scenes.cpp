#include "benchmarks/reference/scenes/random_scenes.h"

#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::reference
{
using Eigen::Vector3d;

TriangleMesh randomMesh(Random& random)
{
    switch (random.integer(0, 4))
    {
        case 0:
            return sphereWithPole(random.uniform(0.3, 1.0), random.direction(), 4);
        case 1:
        {
            const Vector3d half = Vector3d::Constant(0.1) + 0.6 * random.inBox(1.0).cwiseAbs();
            return box(-half, half);
        }
        default:
            return soup(random, random.integer(1, 30), 0.6, random.logUniform(0.05, 0.6));
    }
}

RigidScene randomRigidScene(Random& random)
{
    RigidScene scene{.meshA = randomMesh(random), .meshB = randomMesh(random)};
    const double fastest = random.chance(0.2) ? 20.0 : 4.0;
    scene.motionA = randomRigidMotion(random, fastest);
    scene.motionB = randomRigidMotion(random, fastest);
    const Vector3d away = random.uniform(1.5, 3.5) * random.direction();
    scene.motionA.X_W0.translation() = scene.motionB.X_W0.translation() + away;
    // Roughly at each other, and past.
    scene.motionA.v_W = scene.motionB.v_W - random.uniform(0.3, 1.5) * away + random.inBox(1.3);
    return scene;
}

ToiResult queryToi(const RigidScene& scene, double tolerance)
{
    return queryToi(scene, ToiOptions{.tolerance = tolerance});
}

ToiResult queryToi(const RigidScene& scene, const ToiOptions& options)
{
    const SsvTree treeA = buildSsvTree(scene.meshA);
    const SsvTree treeB = buildSsvTree(scene.meshB);
    ToiWorkspace work;
    return rigidToi({.tree = &treeA, .motion = scene.motionA},
                    {.tree = &treeB, .motion = scene.motionB},
                    options,
                    work);
}

double roundingOf(const RigidScene& scene)
{
    const auto extent = [](const TriangleMesh& mesh, const RigidMotion& motion)
    { return radiusOf(mesh) + motion.X_W0.translation().norm() + motion.v_W.norm(); };
    return 64.0 * 1.2e-16 *
           (extent(scene.meshA, scene.motionA) + extent(scene.meshB, scene.motionB));
}
}  // namespace bullet_ccd::reference
