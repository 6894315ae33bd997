/// FCL, the packaged open-source peer: same meshes in double precision, same motions.
///
/// Motions are given to FCL as rotation and translation at both ends and the reference point, the
/// only one of its constructors that moves as asked; so they must not turn by more than half a
/// turn.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
/// "FCL 0.7.0".
[[nodiscard]] std::string fclVersion();

/// A mesh with FCL's hierarchy of oriented boxes and swept rectangles.
class FclModel
{
public:
    explicit FclModel(const TriangleMesh& mesh);

    struct Data;
    [[nodiscard]] const Data& data() const { return *m_data; }

private:
    std::shared_ptr<const Data> m_data;
};

/// A model and its motion.
struct FclBody
{
    const FclModel& model;
    const RigidMotion& motion;
};

struct FclAnswer
{
    bool hit = false;
    double time = 1.0;
};

/// Of the yardstick.
inline constexpr int kNaiveSamples = 1001;

/// Tests for overlap at `samples` times from 0 to 1, in order, until one overlaps.
[[nodiscard]] FclAnswer fclNaive(const FclBody& a, const FclBody& b, int samples);

/// Conservative advancement; may take minutes.
[[nodiscard]] FclAnswer fclAdvancement(const FclBody& a,
                                       const FclBody& b,
                                       double timeTolerance,
                                       int iterations = 1'000'000);

/// First contact of two features, by the cubic equation that says when they are coplanar.
[[nodiscard]] FclAnswer fclFeatures(const ElementaryPair& pair);

/// A mesh that deforms, with FCL's hierarchy of boxes.
class FclSurface
{
public:
    explicit FclSurface(const TriangleMesh& mesh);
    /// Takes the next step, from where the last one ended.
    void setEnd(const std::vector<Eigen::Vector3d>& end);

    struct Data;
    [[nodiscard]] const Data& data() const { return *m_data; }

private:
    std::shared_ptr<Data> m_data;
};
/// First contact of the two in their steps, of all pairs of triangles.
[[nodiscard]] FclAnswer fclSurfaces(const FclSurface& a, const FclSurface& b);

/// Whether the surfaces intersect at these poses.
[[nodiscard]] bool fclOverlap(const FclModel& a,
                              const Eigen::Isometry3d& X_WA,
                              const FclModel& b,
                              const Eigen::Isometry3d& X_WB);

/// Exact distance of the surfaces at these poses; 0 where they intersect.
[[nodiscard]] double fclDistance(const FclModel& a,
                                 const Eigen::Isometry3d& X_WA,
                                 const FclModel& b,
                                 const Eigen::Isometry3d& X_WB);

/// The same two at time t.
[[nodiscard]] inline bool fclOverlap(const FclBody& a, const FclBody& b, double t)
{
    return fclOverlap(a.model, a.motion.at(t).X_W, b.model, b.motion.at(t).X_W);
}
[[nodiscard]] inline double fclDistance(const FclBody& a, const FclBody& b, double t)
{
    return fclDistance(a.model, a.motion.at(t).X_W, b.model, b.motion.at(t).X_W);
}

/// First overlap in (from, end], to 1e-12: steps that double, then bisection, so that one that
/// lasts shorter than its distance from `from` may be stepped over. None if nothing overlaps.
[[nodiscard]] std::optional<double> firstOverlap(double from,
                                                 double end,
                                                 const std::function<bool(double)>& overlaps);
[[nodiscard]] inline std::optional<double> firstOverlap(const FclBody& a,
                                                        const FclBody& b,
                                                        double from,
                                                        double end)
{
    return firstOverlap(from, end, [&](double t) { return fclOverlap(a, b, t); });
}
}  // namespace bullet_ccd::benchmarks
