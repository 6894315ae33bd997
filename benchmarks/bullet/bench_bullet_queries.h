/// Times of impact of two shapes: Bullet's own methods beside ours, on queries with known answers.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// A flies at B, which rests. All of a body is within the radius of its mesh.
struct QueryBody
{
    TriangleMesh mesh;
    double radius = 0.0;
    std::function<std::unique_ptr<btCollisionShape>()> shape = nullptr;
    /// The same for GImpact; null: not asked.
    std::function<std::unique_ptr<btCollisionShape>()> gimpact = nullptr;
};

struct BulletQuery
{
    RigidMotion motionA;  ///< turns by less than 45 degrees, which is all that Bullet takes
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    bool hit = false;
    double time = 1.0;  ///< of contact, to 1e-9 of the motion
    double gap = 0.0;   ///< without contact: smallest distance, or less [m]
};

struct QueryFamily
{
    std::string name;
    QueryBody a;
    QueryBody b;
    bool convex = true;
    std::vector<BulletQuery> queries = {};
    int dropped = 0;  ///< queries whose answer could not be proved
};

/// @param count queries of each family
[[nodiscard]] std::vector<QueryFamily> queryFamilies(int count, std::uint64_t seed);

/// An answer to a query.
struct CastAnswer
{
    bool hit = false;
    double time = 1.0;
};

/// One way to answer. prepare() is not timed.
struct CastMethod
{
    std::string name;
    std::function<void(const BulletQuery&)> prepare;
    std::function<CastAnswer()> ask;
};

/// All methods that can answer the family. They keep references to it.
[[nodiscard]] std::vector<CastMethod> castMethods(const QueryFamily& family);

/// Answers are checked, then all methods are timed in turns.
/// @return one row per method: "hits" that it found, "missed", "late" (answers after the contact,
/// by
///         more than 0.2 mm of the way), "latest" of them [mm], "false" (hits of bodies that stay 2
///         mm apart), "error" (mean distance on the way between answer and contact [mm]), "us"
[[nodiscard]] std::vector<nlohmann::json> runFamily(const QueryFamily& family, int repeats);
}  // namespace bullet_ccd::benchmarks
