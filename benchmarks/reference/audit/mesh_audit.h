/// Independent check of poses: do solids intersect, how deep, where. Shares no code with the
/// distance and time-of-impact queries of the library.
#pragma once

#include "benchmarks/reference/audit/exact_triangles.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::reference
{
/// A mesh with a tree of axis-aligned boxes in its own frame. Immutable.
class AuditMesh
{
public:
    explicit AuditMesh(TriangleMesh mesh);

    struct Node
    {
        Eigen::AlignedBox3d box;
        std::int32_t first = 0;  ///< child `first` and `first` + 1; of a leaf: position in order()
        std::int32_t count = 0;  ///< triangles of a leaf; 0: inner node
    };
    [[nodiscard]] const TriangleMesh& mesh() const { return m_mesh; }
    [[nodiscard]] bool watertight() const { return m_watertight; }
    [[nodiscard]] const std::vector<Node>& nodes() const { return m_nodes; }
    [[nodiscard]] const std::vector<std::int32_t>& order() const { return m_order; }
    [[nodiscard]] const Eigen::AlignedBox3d& box() const { return m_nodes.front().box; }
    /// Corners of a triangle on the grid.
    [[nodiscard]] GridTriangle corners(std::int32_t triangle) const;
    /// Moved by `X` and put on the grid.
    [[nodiscard]] GridTriangle corners(std::int32_t triangle, const Eigen::Isometry3d& X) const;
    /// True if the solid contains the point (mesh frame): the winding number of the surface about
    /// it is not zero. False for meshes that are not watertight.
    [[nodiscard]] bool contains(const Eigen::Vector3d& point) const;
    /// Distance of a point (mesh frame) from the surface, by all triangles.
    [[nodiscard]] double distance(const Eigen::Vector3d& point) const;

private:
    TriangleMesh m_mesh;
    bool m_watertight;
    std::vector<GridPoint> m_grid;  // vertices
    std::vector<Node> m_nodes;
    std::vector<std::int32_t> m_order;

    void split(std::int32_t node, std::int32_t begin, std::int32_t end);
};

struct PairAudit
{
    std::int64_t crossings = 0;  ///< pairs of triangles that meet, exactly (edges, touching: too)
    bool contained = false;      ///< no crossing, but one solid lies inside the other
    /// Largest distance behind the other's surface of the vertices of either, and of nine points of
    /// each edge of a crossing triangle
    /// (of the first 64 pairs) [m]; 0 if none of them is inside.
    double depth = 0.0;
    Eigen::Vector3d point_W = Eigen::Vector3d::Zero();  ///< where; of the first crossing if depth 0
    [[nodiscard]] bool clean() const { return crossings == 0 && !contained; }
};

[[nodiscard]] PairAudit auditPair(const AuditMesh& a,
                                  const Eigen::Isometry3d& X_WA,
                                  const AuditMesh& b,
                                  const Eigen::Isometry3d& X_WB);

/// A mesh of a body in a scene.
struct AuditPart
{
    const AuditMesh* mesh = nullptr;
    std::int32_t body = 0;
    Eigen::Isometry3d X_BM = Eigen::Isometry3d::Identity();  ///< mesh frame in the body's
};

struct AuditScene
{
    std::vector<AuditPart> parts = {};
    std::vector<bool> fixed =
        {};  ///< one entry a body: true if it never moves; two of them are no pair
    /// Pairs of bodies, smaller index first, that may intersect: joint neighbours.
    std::set<std::pair<std::int32_t, std::int32_t>> ignored = {};
};

using BodyPoses = std::vector<Eigen::Isometry3d>;  ///< X_WB, one entry a body

struct AuditResult
{
    std::int64_t poses = 0;         ///< how often all bodies were looked at
    std::int64_t pairs = 0;         ///< pairs of parts whose boxes met, summed over the poses
    std::int64_t intersecting = 0;  ///< of these, not clean
    PairAudit worst = {};           ///< deepest of them
    std::int32_t bodyA = kNone;     ///< of the worst
    std::int32_t bodyB = kNone;
    double time = 0.0;

    [[nodiscard]] bool clean() const { return intersecting == 0; }
    void add(const AuditResult& other);
};

/// "mug 3 and plate 7 are 1.2e-05 m inside each other at 0.52 s near (0.1, 0.0, 0.2)".
/// @param names  one per body
[[nodiscard]] std::string describe(const AuditResult& result, std::span<const std::string> names);

/// Looks at all pairs of parts of different bodies. `time` is only noted.
/// @param only  if not empty: only at pairs with one of these bodies
[[nodiscard]] AuditResult auditPoses(const AuditScene& scene,
                                     const BodyPoses& X_WB,
                                     double time,
                                     const std::vector<std::int32_t>& only = {});

/// A rigid motion at constant velocity and rate of rotation (less than half a turn) from one pose
/// to another, at fraction s: what Bullet integrates between two changes of velocity.
[[nodiscard]] Eigen::Isometry3d betweenPoses(const Eigen::Isometry3d& from,
                                             const Eigen::Isometry3d& to,
                                             double s);
}  // namespace bullet_ccd::reference
