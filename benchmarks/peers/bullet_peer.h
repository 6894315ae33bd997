/// Bullet's convex casts: convex hulls of the same vertices, double precision.
///
/// Bullet interpolates between start and end pose by constant velocities, but never turns by more
/// than 45 degrees a query. In a build without the double-precision Bullet isBulletPresent() is
/// false and the rest throws std::logic_error.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <memory>

namespace bullet_ccd::benchmarks
{
[[nodiscard]] bool isBulletPresent();

enum class BulletCast : std::uint8_t
{
    Continuous,  ///< btContinuousConvexCollision
    Gjk,         ///< btGjkConvexCast: translation only
    Subsimplex,  ///< btSubsimplexConvexCast: translation only
};

/// A convex hull.
class BulletHull
{
public:
    BulletHull(const TriangleMesh& mesh, double margin);
    ~BulletHull();
    BulletHull(BulletHull&&) noexcept;
    BulletHull& operator=(BulletHull&&) noexcept;

    struct Data;
    [[nodiscard]] const Data& data() const { return *m_data; }

private:
    std::unique_ptr<Data> m_data;
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
}  // namespace bullet_ccd::benchmarks
