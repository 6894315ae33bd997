/// Query sets of the rigid benchmarks: pairs of meshes and seeded or recorded motions.
///
/// File sets come with a certified bracket of the first contact; generated sets are made here from
/// fixed seeds and never overlap at the start. Lengths are in model units.
#pragma once

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
struct RigidQuery
{
    std::int32_t id = 0;
    RigidMotion motionA;
    RigidMotion motionB;
};

/// What is known of a query: surfaces are apart at timeLow and intersect at time.
struct RigidReference
{
    bool hit = false;
    double timeLow = 1.0;
    double time = 1.0;
    double timeAtTolerance = -1.0;  ///< of a step at which the distance was <= 1e-4; -1: never
    double closestDistance = 0.0;   ///< smallest distance met
    double speedBound = 0.0;        ///< of any point of A against B [units per motion]
};

struct RigidSet
{
    std::string name;
    std::shared_ptr<const TriangleMesh> meshA;
    std::shared_ptr<const TriangleMesh> meshB;  ///< the same object as meshA where they are equal
    std::vector<RigidQuery> queries{};
    std::vector<RigidReference> references{};  ///< one a query, or none
    /// By how much the vertices may differ from those that the references were computed with.
    double vertexRounding = 0.0;
};

/// Meshes by name ("bunny", "finger", "plate", "torus", "knot_64k", ..), made once.
class MeshLibrary
{
public:
    /// @param dataFolder holds motions/ and rigid_queries/
    explicit MeshLibrary(std::filesystem::path dataFolder) : m_dataFolder(std::move(dataFolder)) {}

    /// Throws std::invalid_argument for an unknown name, std::runtime_error for a missing file.
    [[nodiscard]] std::shared_ptr<const TriangleMesh> mesh(const std::string& name);
    [[nodiscard]] const std::filesystem::path& dataFolder() const { return m_dataFolder; }

private:
    std::filesystem::path m_dataFolder;
    std::map<std::string, std::shared_ptr<const TriangleMesh>> m_meshes;
};

/// Recorded sets (bunny_ident, .., convex_hull162_rot40), then generated ones (bunny_random, ..).
[[nodiscard]] const std::vector<std::string>& fileSetNames();
[[nodiscard]] const std::vector<std::string>& generatedSetNames();

/// Throws std::invalid_argument for an unknown name, std::runtime_error for files that are missing
/// or malformed.
/// @param seedShift added to the seed of a generated set: other queries of the same recipe
[[nodiscard]] RigidSet makeRigidSet(const std::string& name,
                                    MeshLibrary& meshes,
                                    std::uint64_t seedShift = 0);
/// The same for a generated set.
[[nodiscard]] RigidSet generateSet(const std::string& name,
                                   MeshLibrary& meshes,
                                   std::uint64_t seedShift);
}  // namespace bullet_ccd::benchmarks
