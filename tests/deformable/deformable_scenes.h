/// Small surfaces that deform, and all contacts of a step by brute force.
#pragma once

#include "benchmarks/reference/scenes/deforming_scenes.h"
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
/// A mesh and its step.
struct MovingMesh
{
    TriangleMesh mesh;  ///< at the start
    std::vector<Eigen::Vector3d> end;
};

/// A crumpled cloth whose vertices go different ways.
inline MovingMesh crumpledCloth(reference::Random& random, int n, double crumple, double motion)
{
    MovingMesh moving{.mesh = reference::sheet(n), .end = {}};
    const Eigen::Isometry3d pose = random.pose(0.3);
    const Eigen::Vector3d common = random.inBox(motion);
    for (Eigen::Vector3d& x : moving.mesh.vertices)
    {
        x = pose * (x + random.inBox(crumple));
        moving.end.push_back(x + common + random.inBox(motion));
    }
    return moving;
}

/// All edges, the lower index first, in order.
inline std::set<std::array<std::int32_t, 2>> edgesOf(const TriangleMesh& mesh)
{
    std::set<std::array<std::int32_t, 2>> edges;
    for (const Triangle& t : mesh.triangles)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const std::int32_t a = t[k];
            const std::int32_t b = t[(k + 1) % 3];
            if (a != b)
            {
                edges.insert({std::min(a, b), std::max(a, b)});
            }
        }
    }
    return edges;
}

/// elementaryToi() for every pair of features that have no vertex in common.
class BruteForceContacts
{
public:
    BruteForceContacts(const std::vector<MovingMesh>& meshes,
                       bool selfCollision,
                       const ElementaryOptions& options)
        : m_meshes(meshes), m_options(options)
    {
        for (std::size_t a = 0; a < meshes.size(); ++a)
        {
            for (std::size_t b = 0; b < meshes.size(); ++b)
            {
                if (a != b || selfCollision)
                {
                    vertexFaces(a, b);
                }
                if (a < b || (a == b && selfCollision))
                {
                    edges(a, b);
                }
            }
        }
        std::ranges::sort(contacts,
                          [](const DeformableContact& x, const DeformableContact& y)
                          { return keyOf(x) < keyOf(y); });
    }

    static std::
        tuple<double, ElementaryKind, std::int32_t, std::int32_t, std::array<std::int32_t, 4>>
        keyOf(const DeformableContact& c)
    {
        return {c.time, c.kind, c.bodyA, c.bodyB, c.vertices};
    }

    std::vector<DeformableContact> contacts;
    int pairs = 0;

private:
    void vertexFaces(std::size_t a, std::size_t b)
    {
        std::set<std::int32_t> vertices;
        for (const Triangle& t : m_meshes[a].mesh.triangles)
        {
            vertices.insert(t.begin(), t.end());
        }
        for (const std::int32_t v : vertices)
        {
            for (const Triangle& t : m_meshes[b].mesh.triangles)
            {
                if (a != b || std::ranges::find(t, v) == t.end())
                {
                    examine(ElementaryKind::VertexFace, a, b, {v, t[0], t[1], t[2]});
                }
            }
        }
    }

    void edges(std::size_t a, std::size_t b)
    {
        for (const auto& [p, q] : edgesOf(m_meshes[a].mesh))
        {
            for (const auto& [r, s] : edgesOf(m_meshes[b].mesh))
            {
                const bool isNeighbour = p == r || p == s || q == r || q == s;
                if (a != b || (!isNeighbour && std::pair(p, q) < std::pair(r, s)))
                {
                    examine(ElementaryKind::EdgeEdge, a, b, {p, q, r, s});
                }
            }
        }
    }

    void examine(ElementaryKind kind,
                 std::size_t a,
                 std::size_t b,
                 const std::array<std::int32_t, 4>& vertices)
    {
        ElementaryPair pair{.kind = kind};
        const std::size_t ofA = kind == ElementaryKind::EdgeEdge ? 2 : 1;
        for (std::size_t k = 0; k < 4; ++k)
        {
            const MovingMesh& moving = m_meshes[k < ofA ? a : b];
            const auto v = static_cast<std::size_t>(vertices[k]);
            pair.start[k] = moving.mesh.vertices[v];
            pair.end[k] = moving.end[v];
        }
        ++pairs;
        const ElementaryResult result = elementaryToi(pair, m_options);
        if (pair.start != pair.end &&
            (isContact(result.status) || result.status == ToiStatus::IterationLimit))
        {
            contacts.push_back({.kind = kind,
                                .status = result.status,
                                .bodyA = static_cast<std::int32_t>(a),
                                .bodyB = static_cast<std::int32_t>(b),
                                .vertices = vertices,
                                .time = result.time,
                                .gap = result.gap,
                                .normal = result.normal,
                                .weights = result.weights});
        }
    }

    const std::vector<MovingMesh>& m_meshes;
    ElementaryOptions m_options;
};
}  // namespace bullet_ccd::tests
