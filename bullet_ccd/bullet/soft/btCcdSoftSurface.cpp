#include "bullet_ccd/bullet/soft/btCcdSoftSurface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

using bullet_ccd::Triangle;
using bullet_ccd::TriangleMesh;
using Eigen::Vector3d;

namespace
{
std::int32_t nodeIndex(const btSoftBody& body, const btSoftBody::Node* node)
{
    return std::int32_t(node - &body.m_nodes[0]);
}

/// Triangles that belong to one tetrahedron only.
std::vector<Triangle> boundaryOfTetras(const btSoftBody& body)
{
    std::map<Triangle, std::pair<Triangle, int>> faces;
    for (int i = 0; i < body.m_tetras.size(); ++i)
    {
        for (int left = 0; left < 4; ++left)
        {
            Triangle face{};
            for (int k = 0; k < 3; ++k)
            {
                face[std::size_t(k)] = nodeIndex(body, body.m_tetras[i].m_n[(left + 1 + k) % 4]);
            }
            Triangle key = face;
            std::ranges::sort(key);
            auto& [kept, count] = faces[key];
            kept = face;
            ++count;
        }
    }
    std::vector<Triangle> boundary;
    for (const auto& [key, face] : faces)
    {
        if (face.second == 1)
        {
            boundary.push_back(face.first);
        }
    }
    return boundary;
}

double shortestEdge(const TriangleMesh& mesh)
{
    double shortest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : mesh.triangles)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            const double length =
                (mesh.vertices[std::size_t(t[k])] - mesh.vertices[std::size_t(t[(k + 1) % 3])])
                    .norm();
            shortest = length > 0.0 ? std::min(shortest, length) : shortest;
        }
    }
    return shortest;
}

/// How many nodes there are, and the nodes of all faces, links and tetrahedra: a body may be
/// changed in place, or another one come to the same address, without a change of their numbers.
void readTopology(const btSoftBody& body, std::vector<std::int32_t>& topology)
{
    topology.assign({body.m_nodes.size(), body.m_faces.size(), body.m_links.size()});
    const auto add = [&](const auto& elements)
    {
        for (int i = 0; i < elements.size(); ++i)
        {
            for (const btSoftBody::Node* node : elements[i].m_n)
            {
                topology.push_back(nodeIndex(body, node));
            }
        }
    };
    add(body.m_faces);
    add(body.m_links);
    add(body.m_tetras);
}

/// The velocity that Bullet leaves to a node when it integrates.
btVector3 clampedVelocity(const btSoftBody& body, const btSoftBody::Node& node, btScalar timeStep)
{
    const btScalar most = body.m_worldInfo->m_maxDisplacement / timeStep;
    btVector3 v = node.m_v;
    for (int k = 0; k < 3; ++k)
    {
        btClamp(v[k], -most, most);
    }
    return v;
}

/// Returns false if a node is or becomes not finite.
bool setStepOf(btSoftBody& body, btScalar timeStep, btCcdSoftPart& part)
{
    const auto count = std::size_t(body.m_nodes.size());
    part.m_start.resize(count);
    part.m_end.resize(count);
    part.m_velocity.resize(count);
    part.m_inverseMass.resize(count);
    part.m_anchor.assign(count, nullptr);
    part.m_bent.assign(count, 0);
    part.m_hasChanged = true;
    bool isFinite = true;
    for (std::size_t i = 0; i < count; ++i)
    {
        const btSoftBody::Node& node = body.m_nodes[int(i)];
        part.m_start[i] = btCcdToEigen(node.m_x);
        part.m_end[i] = btCcdToEigen(btCcdNextPlace(body, node, timeStep));
        part.m_velocity[i] = btCcdToEigen(clampedVelocity(body, node, timeStep));
        part.m_inverseMass[i] = double(node.m_im);
        isFinite = isFinite && bullet_ccd::isPlace(part.m_start[i]) &&
                   bullet_ccd::isPlace(part.m_end[i]) && part.m_velocity[i].allFinite();
    }
    for (int i = 0; i < body.m_deformableAnchors.size(); ++i)
    {
        const btSoftBody::DeformableNodeRigidAnchor& anchor = body.m_deformableAnchors[i];
        const auto node = std::size_t(nodeIndex(body, anchor.m_node));
        part.m_end[node] =
            btCcdToEigen(anchor.m_cti.m_colObj->getWorldTransform() * anchor.m_local);
        part.m_inverseMass[node] = 0.0;
        part.m_anchor[node] = const_cast<btCollisionObject*>(anchor.m_cti.m_colObj);
    }
    return isFinite;
}
}  // namespace

TriangleMesh btCcdSoftMesh(const btSoftBody& body)
{
    TriangleMesh mesh;
    for (int i = 0; i < body.m_nodes.size(); ++i)
    {
        mesh.vertices.push_back(btCcdToEigen(body.m_nodes[i].m_x));
    }
    for (int i = 0; i < body.m_faces.size(); ++i)
    {
        const btSoftBody::Face& face = body.m_faces[i];
        mesh.triangles.push_back({nodeIndex(body, face.m_n[0]),
                                  nodeIndex(body, face.m_n[1]),
                                  nodeIndex(body, face.m_n[2])});
    }
    if (mesh.triangles.empty())
    {
        mesh.triangles = boundaryOfTetras(body);
    }
    std::vector<bool> isCovered(mesh.vertices.size(), false);
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t v : t)
        {
            isCovered[std::size_t(v)] = true;
        }
    }
    for (int i = 0; i < body.m_tetras.size(); ++i)
    {
        for (const btSoftBody::Node* node : body.m_tetras[i].m_n)
        {
            const std::int32_t v = nodeIndex(body, node);
            if (!isCovered[std::size_t(v)])
            {
                mesh.triangles.push_back({v, v, v});
                isCovered[std::size_t(v)] = true;
            }
        }
    }
    for (int i = 0; i < body.m_links.size(); ++i)
    {
        const std::int32_t a = nodeIndex(body, body.m_links[i].m_n[0]);
        const std::int32_t b = nodeIndex(body, body.m_links[i].m_n[1]);
        if (body.m_links[i].m_bbending == 0 &&
            !(isCovered[std::size_t(a)] && isCovered[std::size_t(b)]))
        {
            mesh.triangles.push_back({a, b, b});
        }
    }
    return mesh;
}

btVector3 btCcdNextPlace(const btSoftBody& body, const btSoftBody::Node& node, btScalar timeStep)
{
    return node.m_x + timeStep * (clampedVelocity(body, node, timeStep) + node.m_splitv);
}

btCcdSoftPart* btCcdSoftSurfaces::find(btSoftBody& body, btScalar timeStep)
{
    Entry& entry = m_entries[&body];
    entry.m_used = true;
    btCcdSoftPart& part = entry.m_part;
    part.m_object = part.m_soft = &body;
    if (body.m_nodes.size() == 0)
    {
        return nullptr;
    }
    if (!setStepOf(body, timeStep, part))
    {
        if (!entry.m_warned)
        {
            std::fprintf(stderr,
                         "bullet_ccd: a soft body of %d nodes has places or velocities that are "
                         "not finite, or beyond 1e12 m. It is left to Bullet: take a smaller time "
                         "step or softer "
                         "springs\n",
                         body.m_nodes.size());
        }
        entry.m_warned = true;
        return nullptr;
    }
    readTopology(body, m_topology);
    if (entry.m_topology != m_topology)
    {
        entry.m_topology = m_topology;
        const TriangleMesh mesh = btCcdSoftMesh(body);
        part.m_shortestEdge = shortestEdge(mesh);
        part.m_surface.reset();
        if (!mesh.triangles.empty())
        {
            part.m_surface = std::make_unique<bullet_ccd::DeformableSurface>(
                mesh, bullet_ccd::DeformableSurfaceOptions{.weldDuplicates = true});
        }
    }
    return part.m_surface != nullptr ? &part : nullptr;
}

void btCcdSoftSurfaces::endRound()
{
    std::erase_if(m_entries, [](const auto& entry) { return !entry.second.m_used; });
    for (auto& [body, entry] : m_entries)
    {
        entry.m_used = false;
    }
}
