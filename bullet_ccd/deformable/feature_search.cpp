#include "bullet_ccd/deformable/feature_search.h"

#include "bullet_ccd/deformable/pursue.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// What childrenMeeting() leaves as slack in its times.
constexpr double kEntrySlack = 1e-5;

Eigen::Vector3d pointOf(const double* x)
{
    return {x[0], x[1], x[2]};
}

template <class T>
void swapEdges(std::array<T, 4>& ends)
{
    std::swap(ends[0], ends[2]);
    std::swap(ends[1], ends[3]);
}
}  // namespace

void FeatureSearch::prefetch(const PatchTask& task) const
{
    const SurfacePair& surfaces = m_state.surfaces[static_cast<std::size_t>(task.surfacePair)];
    const auto fetch = [](const DeformableSurface::Data& data, std::int32_t index)
    {
        const SurfacePatch& patch = data.patch(index);
        constexpr std::size_t kCacheLine = 64;
        for (std::size_t line = 0; line < sizeof(SurfacePatch); line += kCacheLine)
        {
            __builtin_prefetch(reinterpret_cast<const char*>(&patch) + line);
        }
        __builtin_prefetch(&data.patchBoxes[static_cast<std::size_t>(index)]);
    };
    fetch(*surfaces.a, task.patchA);
    fetch(*surfaces.b, task.patchB);
}

void FeatureSearch::examine(const PatchTask& task)
{
    if (m_state.firstOnly && task.entry - kEntrySlack > m_state.earliest.load())
    {
        return;
    }
    const SurfacePair& surfaces = m_state.surfaces[static_cast<std::size_t>(task.surfacePair)];
    if (m_surfaces != &surfaces)
    {
        finish();
        m_surfaces = &surfaces;
    }
    const DeformableSurface::Data& a = *surfaces.a;
    const DeformableSurface::Data& b = *surfaces.b;
    const SurfacePatch& patchA = a.patch(task.patchA);
    const SurfacePatch& patchB = b.patch(task.patchB);
    ++m_counters.patchPairs;
    m_kernels.patchCandidates(
        {.a = &patchA,
         .b = &patchB,
         .shift = surfaces.shift,
         .boxA = shifted(a.patchBoxes[static_cast<std::size_t>(task.patchA)], surfaces.shift[0]),
         .boxB = shifted(b.patchBoxes[static_cast<std::size_t>(task.patchB)], surfaces.shift[1]),
         .isOneSurface = surfaces.isOneSurface()},
        m_candidates);
    for (int i = 0; i < m_candidates.edgePairs; ++i)
    {
        const auto& [indexA, indexB] = m_candidates.edgePair[i];
        add(m_edges,
            a,
            b,
            {patchA.vertex[patchA.edgeA[indexA]],
             patchA.vertex[patchA.edgeB[indexA]],
             patchB.vertex[patchB.edgeA[indexB]],
             patchB.vertex[patchB.edgeB[indexB]]},
            false);
    }
    const auto vertexAndFace = [](const SurfacePatch& ofVertex,
                                  const SurfacePatch& ofFace,
                                  const std::uint8_t(&local)[2]) -> std::array<std::int32_t, 4>
    {
        const auto& [vertex, face] = local;
        return {ofVertex.vertex[vertex],
                ofFace.vertex[ofFace.faceA[face]],
                ofFace.vertex[ofFace.faceB[face]],
                ofFace.vertex[ofFace.faceC[face]]};
    };
    for (int i = 0; i < m_candidates.vertexFaces; ++i)
    {
        add(m_vertexFaces, a, b, vertexAndFace(patchA, patchB, m_candidates.vertexFace[i]), false);
    }
    for (int i = 0; i < m_candidates.faceVertices; ++i)
    {
        add(m_vertexFaces, b, a, vertexAndFace(patchB, patchA, m_candidates.faceVertex[i]), true);
    }
}

void FeatureSearch::finish()
{
    flush(m_vertexFaces);
    flush(m_edges);
}

void FeatureSearch::add(Waiting& waiting,
                        const DeformableSurface::Data& first,
                        const DeformableSurface::Data& second,
                        const std::array<std::int32_t, 4>& vertices,
                        bool isTurned)
{
    const auto lane = static_cast<std::size_t>(waiting.count);
    const std::size_t ofFirst = &waiting == &m_edges ? 2 : 1;
    if ((m_surfaces->idle & kUnchanged) != 0)
    {
        std::uint8_t idle = kUnchanged;
        for (std::size_t k = 0; k < 4; ++k)
        {
            idle &=
                (k < ofFirst ? first : second).vertexIdle[static_cast<std::size_t>(vertices[k])];
        }
        if (idle != 0)
        {
            return;
        }
    }
    for (std::size_t k = 0; k < 4; ++k)
    {
        const DeformableSurface::Data& data = k < ofFirst ? first : second;
        const VertexStep* step = &data.steps[static_cast<std::size_t>(vertices[k])];
        waiting.batch.vertex[k][lane] = step;
        __builtin_prefetch(step);  // it is needed when the batch is full
    }
    waiting.vertices[lane] = vertices;
    waiting.isTurned[lane] = isTurned;
    if (++waiting.count == kLanes)
    {
        flush(waiting);
    }
}

void FeatureSearch::flush(Waiting& waiting)
{
    if (waiting.count == 0)
    {
        return;
    }
    for (int lane = waiting.count; lane < kLanes; ++lane)
    {
        for (auto& vertex : waiting.batch.vertex)
        {
            vertex[lane] = vertex[0];
        }
    }
    // A pair that stays farther apart than this is no contact for elementaryToi() either, so what
    // is left out here changes no answer.
    waiting.batch.margin = m_surfaces->separation + m_state.options->tolerance;
    waiting.batch.until =
        m_state.firstOnly ? std::min(1.0, m_state.earliest.load(std::memory_order_relaxed)) : 1.0;
    const unsigned separated = &waiting == &m_edges ? m_kernels.separatedEdges(waiting.batch)
                                                    : m_kernels.separatedVertexFaces(waiting.batch);
    m_counters.featurePairs += waiting.count;
    const unsigned used = (1U << static_cast<unsigned>(waiting.count)) - 1U;
    for (unsigned open = used & ~separated; open != 0; open &= open - 1)
    {
        advance(waiting, std::countr_zero(open));
    }
    waiting.count = 0;
}

void FeatureSearch::advance(const Waiting& waiting, int lane)
{
    const bool areEdges = &waiting == &m_edges;
    const auto i = static_cast<std::size_t>(lane);
    const bool isTurned = waiting.isTurned[i];
    const DeformableSurface::Data& first = isTurned ? *m_surfaces->b : *m_surfaces->a;
    const DeformableSurface::Data& second = isTurned ? *m_surfaces->a : *m_surfaces->b;
    ElementaryPair pair{.kind = areEdges ? ElementaryKind::EdgeEdge : ElementaryKind::VertexFace};
    std::array<std::int32_t, 4> vertices{};
    bool rests = true;
    for (std::size_t k = 0; k < 4; ++k)
    {
        const VertexStep& vertex = *waiting.batch.vertex[k][lane];
        const DeformableSurface::Data& data = k < (areEdges ? 2U : 1U) ? first : second;
        vertices[k] = data.meshVertex[static_cast<std::size_t>(waiting.vertices[i][k])];
        pair.start[k] = pointOf(vertex.start);
        pair.end[k] = pointOf(vertex.end);
        rests = rests && pair.start[k] == pair.end[k];
    }
    if (rests)
    {
        return;
    }
    if (areEdges && m_surfaces->isOneSurface() &&
        std::pair(vertices[2], vertices[3]) < std::pair(vertices[0], vertices[1]))
    {
        swapEdges(vertices);
        swapEdges(pair.start);
        swapEdges(pair.end);
    }
    ++m_counters.advanced;
    const DeformableOptions& options = *m_state.options;
    const ElementaryResult result =
        uncheckedElementaryToi(pair,
                               {.tolerance = options.tolerance,
                                .minimumSeparation = m_surfaces->separation,
                                .depth = options.depth,
                                .maxIterations = options.maxIterationsOfPair});
    const bool isApart = !isContact(result.status) && !gaveUp(result.status);
    if (isApart || (m_state.firstOnly && result.time > m_state.earliest.load()))
    {
        return;
    }
    const DeformableContact contact{.kind = pair.kind,
                                    .status = result.status,
                                    .bodyA = isTurned ? m_surfaces->bodyB : m_surfaces->bodyA,
                                    .bodyB = isTurned ? m_surfaces->bodyA : m_surfaces->bodyB,
                                    .vertices = vertices,
                                    .time = result.time,
                                    .gap = result.gap,
                                    .normal = result.normal,
                                    .weights = result.weights};
    if (options.isExempt && options.isExempt(contact))
    {
        return;
    }
    if (m_state.firstOnly)
    {
        double earliest = m_state.earliest.load();
        while (contact.time < earliest &&
               !m_state.earliest.compare_exchange_weak(earliest, contact.time))
        {
        }
    }
    m_contacts.push_back(contact);
}
}  // namespace bullet_ccd
