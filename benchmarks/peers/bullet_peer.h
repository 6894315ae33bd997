/// Bullet's convex casts and closest points: convex hulls of the same corners, double precision.
///
/// Bullet interpolates between start and end pose by constant velocities, but never turns by more
/// than 45 degrees per query.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <memory>

namespace bullet_ccd::benchmarks
{
enum class BulletCast : std::uint8_t
{
    Continuous,  ///< btContinuousConvexCollision
    Gjk,         ///< btGjkConvexCast: translation only
    Subsimplex,  ///< btSubsimplexConvexCast: translation only
};

/// The convex hull of the corners of a mesh's triangles.
class BulletHull
{
public:
    BulletHull(const TriangleMesh& mesh, double margin);

    struct Data;
    [[nodiscard]] const Data& data() const { return *m_data; }

private:
    std::shared_ptr<const Data> m_data;
};

struct BulletAnswer
{
    bool hit = false;
    double time = 1.0;
};

[[nodiscard]] BulletAnswer bulletCast(BulletCast cast,
                                      const BulletHull& a,
                                      const RigidMotion& motionA,
                                      const BulletHull& b,
                                      const RigidMotion& motionB);

/// First contact of a vertex and a face by btSoftBody's own continuous test, which says only
/// whether there is one: the end of the step is halved 20 times.
[[nodiscard]] BulletAnswer bulletVertexFace(const ElementaryPair& pair);

/// Distance at these poses by Bullet's closest points, negative where the hulls overlap; infinite
/// if Bullet has no answer.
[[nodiscard]] double bulletDistance(const BulletHull& a,
                                    const Eigen::Isometry3d& X_WA,
                                    const BulletHull& b,
                                    const Eigen::Isometry3d& X_WB);
}  // namespace bullet_ccd::benchmarks
