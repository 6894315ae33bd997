/// Shapes that are thrown in the tunnelling table, with what the judge needs to know about them.
#pragma once

#include "benchmarks/reference/bullet/scene.h"

#include <Eigen/Core>

#include <functional>
#include <utility>
#include <vector>

namespace bullet_ccd::reference
{
/// Something about 1 cm in size.
struct Missile
{
    const char* name;
    std::function<btCollisionShape*(Scene&)> make;
    std::vector<Eigen::Vector3d> inside;  ///< points well inside of it
    TriangleMesh surface;                 ///< all points within `radius` of these triangles
    double radius;
    double inner;                             ///< of a ball about the origin inside of it
    Eigen::Vector3d spin = {3.0, 20.0, 5.0};  ///< [rad/s]
};

/// A thin plate or a sheet in the plane z = 0.
struct Target
{
    const char* name;
    std::function<btCollisionShape*(Scene&)> make;
    TriangleMesh surface;
};
inline constexpr double kTargetHalf = 0.2;

struct Shot
{
    Missile missile;
    Target target;
};

[[nodiscard]] Missile boxMissile();
/// Bullet's own shape for meshes that move.
[[nodiscard]] std::unique_ptr<btCollisionShape> makeGimpactShape(const TriangleMesh& triangles,
                                                                 double margin);
/// The same with the margin of ours.
[[nodiscard]] btCollisionShape* gimpactShape(Scene& scene, const TriangleMesh& triangles);
[[nodiscard]] std::vector<Shot> shotsAtTargets();
[[nodiscard]] std::vector<std::pair<Missile, Missile>> headOnPairs();
}  // namespace bullet_ccd::reference
