#include "bullet_ccd/reduce/reduce_mesh.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "bullet_ccd/reduce/collapse_edges.h"
#include "bullet_ccd/reduce/convex_hull.h"
#include "bullet_ccd/reduce/simple_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <meshoptimizer.h>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
using Eigen::Vector3d;

std::string text(double number)
{
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.3g", number);
    return digits.data();
}

double extentOf(const TriangleMesh& mesh)
{
    return bounds(mesh).sizes().maxCoeff();
}

/// Signed volume of the tetrahedra over all triangles: positive if the surface is wound outwards.
double signedVolume(const TriangleMesh& mesh)
{
    const Vector3d origin = bounds(mesh).center();
    double volume = 0.0;
    for (const Triangle& t : mesh.triangles)
    {
        const auto corner = [&](std::size_t k) -> Vector3d
        { return mesh.vertices[static_cast<std::size_t>(t[k])] - origin; };
        volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
    }
    return volume;
}

/// How often a closed surface winds around a point: the solid angle of its triangles as seen from
/// there (Van Oosterom and Strackee 1983), over that of the sphere.
double windingNumber(const TriangleMesh& mesh, const Vector3d& point)
{
    double angle = 0.0;
    for (const Triangle& t : mesh.triangles)
    {
        std::array<Vector3d, 3> rays;
        for (std::size_t k = 0; k < 3; ++k)
        {
            rays[k] = (mesh.vertices[static_cast<std::size_t>(t[k])] - point).stableNormalized();
        }
        angle += 2.0 * std::atan2(rays[0].dot(rays[1].cross(rays[2])),
                                  1.0 + rays[0].dot(rays[1]) + rays[1].dot(rays[2]) +
                                      rays[2].dot(rays[0]));
    }
    return angle / (4.0 * std::numbers::pi);
}

/// One vertex of each connected part.
std::vector<std::int32_t> oneVertexPerPart(const TriangleMesh& mesh)
{
    std::vector<std::int32_t> parent(mesh.vertices.size());
    for (std::size_t i = 0; i < parent.size(); ++i)
    {
        parent[i] = static_cast<std::int32_t>(i);
    }
    const auto rootOf = [&](std::int32_t i)
    {
        while (parent[static_cast<std::size_t>(i)] != i)
        {
            auto& up = parent[static_cast<std::size_t>(i)];
            up = parent[static_cast<std::size_t>(up)];
            i = up;
        }
        return i;
    };
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t other : {t[1], t[2]})
        {
            parent[static_cast<std::size_t>(rootOf(other))] = rootOf(t[0]);
        }
    }
    std::vector<std::int32_t> result;
    for (const Triangle& t : mesh.triangles)
    {
        result.push_back(rootOf(t[0]));
    }
    std::ranges::sort(result);
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

/// The mesh with every vertex moved outwards, so far that all its triangles move by `distance`
/// along their normals, or by less at sharp corners.
TriangleMesh movedOutwards(TriangleMesh mesh, double distance)
{
    std::vector<Vector3d> sum(mesh.vertices.size(), Vector3d::Zero());
    std::vector<double> least(mesh.vertices.size(), 1.0);
    const auto normalOf = [&](const Triangle& t) -> Vector3d
    {
        const Vector3d& corner = mesh.vertices[static_cast<std::size_t>(t[0])];
        return (mesh.vertices[static_cast<std::size_t>(t[1])] - corner)
            .cross(mesh.vertices[static_cast<std::size_t>(t[2])] - corner)
            .stableNormalized();
    };
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t vertex : t)
        {
            sum[static_cast<std::size_t>(vertex)] += normalOf(t);
        }
    }
    for (Vector3d& direction : sum)
    {
        direction = direction.stableNormalized();
    }
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t vertex : t)
        {
            const auto i = static_cast<std::size_t>(vertex);
            least[i] = std::min(least[i], normalOf(t).dot(sum[i]));
        }
    }
    constexpr double kSharpest = 0.35;  // no vertex moves by more than three times the distance
    for (std::size_t i = 0; i < sum.size(); ++i)
    {
        mesh.vertices[i] += distance / std::max(kSharpest, least[i]) * sum[i];
    }
    return mesh;
}

/// Looks for models of one mesh.
class Reducer
{
public:
    Reducer(const TriangleMesh& mesh, const ReduceOptions& options)
        : m_mesh(mesh), m_options(options), m_full(buildSsvTree(mesh))
    {
    }

    std::optional<ReducedModel> model(ModelKind kind)
    {
        switch (kind)
        {
            case ModelKind::Sphere:
                return roundModel(sphereAround(m_mesh));
            case ModelKind::Capsule:
                return capsule();
            case ModelKind::Box:
                return box();
            case ModelKind::Hull:
                return compared({.kind = ModelKind::Hull, .mesh = convexHull(m_mesh)});
            case ModelKind::Mesh:
                return smallestMesh();
        }
        return std::nullopt;
    }

    /// The full mesh.
    [[nodiscard]] ReducedModel full() const { return {.mesh = m_mesh}; }

private:
    [[nodiscard]] bool keepsAccuracy(const ReducedModel& model) const
    {
        return model.deviation() <= m_options.accuracy;
    }

    /// The model with its deviations, if it keeps the accuracy.
    [[nodiscard]] std::optional<ReducedModel> compared(ReducedModel model) const
    {
        if (model.mesh.triangles.empty())
        {
            return std::nullopt;
        }
        const double accuracy = m_options.accuracy;
        const StopCondition& stop = m_options.stop;
        model.fullFromModel =
            surfaceDeviation(m_mesh, buildSsvTree(model.mesh), 0.5 * accuracy, accuracy, stop);
        if (model.fullFromModel.upper <= accuracy)
        {
            model.modelFromFull =
                surfaceDeviation(model.mesh, m_full, 0.5 * accuracy, accuracy, stop);
            if (keepsAccuracy(model))
            {
                return model;
            }
        }
        return std::nullopt;
    }

    [[nodiscard]] std::optional<ReducedModel> roundModel(ReducedModel model) const
    {
        if (model.mesh.triangles.empty())
        {
            return std::nullopt;
        }
        compareRound(m_mesh, m_full, m_options.accuracy, m_options.stop, model);
        return keepsAccuracy(model) ? std::optional(std::move(model)) : std::nullopt;
    }

    [[nodiscard]] std::optional<ReducedModel> capsule() const
    {
        for (const MeshFrame& frame : meshFrames(m_mesh))
        {
            for (int axis = 0; axis < 3; ++axis)
            {
                if (auto found = roundModel(capsuleAround(m_mesh, frame, axis)))
                {
                    return found;
                }
            }
        }
        return std::nullopt;
    }

    [[nodiscard]] std::optional<ReducedModel> box() const
    {
        for (const MeshFrame& frame : meshFrames(m_mesh))
        {
            if (frame.half.minCoeff() > 0.0)
            {
                if (auto found = compared(boxAround(frame)))
                {
                    return found;
                }
            }
        }
        return std::nullopt;
    }

    /// What the simplifier leaves if it is told this error [m]; nothing if that is not less.
    [[nodiscard]] std::optional<TriangleMesh> simplified(double error) const
    {
        const Vector3d origin = bounds(m_mesh).center();
        std::vector<float> positions;
        positions.reserve(3 * m_mesh.vertices.size());
        for (const Vector3d& vertex : m_mesh.vertices)
        {
            const Eigen::Vector3f p = (vertex - origin).cast<float>();
            positions.insert(positions.end(), p.data(), p.data() + 3);
        }
        std::vector<unsigned int> indices;
        indices.reserve(3 * m_mesh.triangles.size());
        for (const Triangle& t : m_mesh.triangles)
        {
            for (const std::int32_t vertex : t)
            {
                indices.push_back(static_cast<unsigned int>(vertex));
            }
        }
        std::vector<unsigned int> kept(indices.size());
        kept.resize(meshopt_simplify(kept.data(),
                                     indices.data(),
                                     indices.size(),
                                     positions.data(),
                                     m_mesh.vertices.size(),
                                     3 * sizeof(float),
                                     0,
                                     static_cast<float>(error / extentOf(m_mesh)),
                                     0,
                                     nullptr));
        if (kept.empty() || kept.size() >= indices.size())
        {
            return std::nullopt;
        }
        TriangleMesh result{.vertices = m_mesh.vertices, .triangles = {}};
        for (std::size_t i = 0; i < kept.size(); i += 3)
        {
            result.triangles.push_back({static_cast<std::int32_t>(kept[i]),
                                        static_cast<std::int32_t>(kept[i + 1]),
                                        static_cast<std::int32_t>(kept[i + 2])});
        }
        repairMesh(result);
        return result.triangles.empty() ? std::nullopt : std::optional(std::move(result));
    }

    /// True if the solid of `outer`, which is closed, contains that of the full mesh: no point of
    /// the one surface is on the other, and the outer one winds around a vertex of each part.
    [[nodiscard]] bool containsFull(const TriangleMesh& outer) const
    {
        const DistanceBounds found = distanceBounds(m_full,
                                                    buildSsvTree(outer),
                                                    Eigen::Isometry3d::Identity(),
                                                    std::numeric_limits<double>::infinity(),
                                                    m_options.stop);
        if (!found.isComplete)
        {
            throw QueryStopped("reduce: the search was stopped before its end");
        }
        if (!(found.nearest.distance > smallestAccuracy(m_mesh)))
        {
            return false;
        }
        return std::ranges::all_of(
            oneVertexPerPart(m_mesh),
            [&](std::int32_t vertex) {
                return windingNumber(outer, m_mesh.vertices[static_cast<std::size_t>(vertex)]) >
                       0.5;
            });
    }

    /// A mesh by the simplifier, moved outwards until it contains the full one.
    [[nodiscard]] std::optional<ReducedModel> outside(const TriangleMesh& simple) const
    {
        if (!isWatertight(simple))
        {
            return std::nullopt;
        }
        const double inner = surfaceDeviation(m_mesh,
                                              buildSsvTree(simple),
                                              0.1 * m_options.accuracy,
                                              std::numeric_limits<double>::infinity(),
                                              m_options.stop)
                                 .upper;
        for (const double factor : {0.5, 1.0, 1.5, 2.0})
        {
            const double distance = std::max(factor * inner, 2.0 * smallestAccuracy(m_mesh));
            if (distance >= m_options.accuracy)
            {
                break;
            }
            TriangleMesh moved = movedOutwards(simple, distance);
            if (containsFull(moved))
            {
                return compared({.mesh = std::move(moved)});
            }
        }
        return std::nullopt;
    }

    /// What the simplifier leaves of the full mesh far within the accuracy, with edges collapsed up
    /// to it.
    [[nodiscard]] std::optional<ReducedModel> smallestMesh() const
    {
        constexpr double kStart = 0.1;
        const std::optional<TriangleMesh> start = simplified(kStart * m_options.accuracy);
        for (const double share : {0.98, 0.9, 0.8, 0.6, 0.4, 0.2})
        {
            TriangleMesh simple =
                collapseEdges(start ? *start : m_mesh,
                              m_full,
                              (m_options.contains ? 0.5 : 1.0) * share * m_options.accuracy,
                              m_options.stop);
            if (simple.triangles.empty() || simple.triangles.size() >= m_mesh.triangles.size())
            {
                continue;
            }
            std::optional<ReducedModel> model =
                m_options.contains ? outside(simple) : compared({.mesh = std::move(simple)});
            if (model)
            {
                return model;
            }
        }
        return std::nullopt;
    }

    const TriangleMesh& m_mesh;
    const ReduceOptions& m_options;
    SsvTree m_full;
};
}  // namespace

const char* modelKindName(ModelKind kind)
{
    switch (kind)
    {
        case ModelKind::Sphere:
            return "sphere";
        case ModelKind::Capsule:
            return "capsule";
        case ModelKind::Box:
            return "box";
        case ModelKind::Hull:
            return "hull";
        case ModelKind::Mesh:
            return "mesh";
    }
    return "";
}

double smallestAccuracy(const TriangleMesh& mesh)
{
    const Eigen::AlignedBox3d box = bounds(mesh);
    return 1e-9 * std::max({box.sizes().maxCoeff(),
                            box.min().cwiseAbs().maxCoeff(),
                            box.max().cwiseAbs().maxCoeff()});
}

std::optional<ReducedModel> reduceMesh(const TriangleMesh& mesh, const ReduceOptions& options)
{
    checkMesh(mesh, "the mesh");
    const double smallest = smallestAccuracy(mesh);
    require(options.accuracy >= smallest && std::isfinite(options.accuracy),
            "the accuracy is " + text(options.accuracy) + ": it must be a length of at least " +
                text(smallest) + ", a billionth of the mesh; less is lost in rounding");
    require(!options.contains || (isWatertight(mesh) && signedVolume(mesh) > 0.0),
            "the mesh encloses no volume, so nothing can contain it: close it and wind its "
            "triangles outwards, or do without a model that contains it");
    Reducer reducer(mesh, options);
    if (options.kind)
    {
        return reducer.model(*options.kind);
    }
    for (const ModelKind kind :
         {ModelKind::Sphere, ModelKind::Capsule, ModelKind::Box, ModelKind::Hull, ModelKind::Mesh})
    {
        if (std::optional<ReducedModel> found = reducer.model(kind))
        {
            return found;
        }
    }
    return reducer.full();
}
}  // namespace bullet_ccd
