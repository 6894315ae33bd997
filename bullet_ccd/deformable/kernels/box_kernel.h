/// A patch against a patch: pairs of their features whose boxes meet. Included once per instruction
/// set.
#pragma once

#include "bullet_ccd/deformable/kernels/patch_codes.h"
#include "bullet_ccd/deformable/kernels/surface_kernels.h"

namespace bullet_ccd
{
namespace
{
/// What is left of a patch against the box of another one.
struct FeaturesMeeting
{
    std::uint32_t vertices;  ///< that belong to the patch
    std::uint32_t edges;
    std::uint32_t faces;
};

inline FeaturesMeeting featuresMeeting(const SurfacePatch& patch, const MovingBox& box)
{
    const Bytes codes = outcodes(patch, box.low, box.high);
    return {.vertices = zeros(codes) & patch.own,
            .edges = edgesMeeting(patch, codes, noBits()),
            .faces = facesMeeting(patch, codes, noBits())};
}

/// The vertices of a patch, a row each, against those of another one. A vertex of B that is beyond
/// a vertex of A on a side gets that bit. It is beyond the box of a feature of A if it is beyond
/// all vertices of it: codes of features are what the codes of their vertices have in common.
struct VertexRows
{
    Bytes codes[kPatchVertices];  ///< of the vertices of B
    Bytes same[kPatchVertices];   ///< not 0 for those that count as one with the vertex of A

    /// Makes the rows that features of A need.
    void fill(const SurfacePatch& a,
              const FeaturesMeeting& ofA,
              const SurfacePatch& b,
              const MovingBox& shift,
              bool isOneSurface)
    {
        std::uint32_t needed = ofA.vertices;
        const auto need = [&needed](int i) { needed |= 1U << static_cast<unsigned>(i); };
        for (std::uint32_t m = ofA.edges; m != 0; m &= m - 1)
        {
            need(a.edgeA[lowestBit(m)]);
            need(a.edgeB[lowestBit(m)]);
        }
        for (std::uint32_t m = ofA.faces; m != 0; m &= m - 1)
        {
            need(a.faceA[lowestBit(m)]);
            need(a.faceB[lowestBit(m)]);
            need(a.faceC[lowestBit(m)]);
        }
        const ShiftedPatch shifted(b, shift);
        for (; needed != 0; needed &= needed - 1)
        {
            const int i = lowestBit(needed);
            codes[i] = shifted.outcodes(a, i);
            same[i] = isOneSurface ? labelled(b, a.label[i]) : noBits();
        }
    }
};

/// Rows of bits first, without branches, then the few bits that are left.
struct FeatureRows
{
    std::uint32_t row[kPatchEdges];
    std::uint8_t index[kPatchEdges];
    int count = 0;

    void add(std::uint32_t m, int i)
    {
        row[count] = m;
        index[count] = static_cast<std::uint8_t>(i);
        count += m != 0 ? 1 : 0;
    }
    /// Writes (index of the row, bit), or the other way round.
    int write(std::uint8_t (*pairs)[2], bool isTurned) const
    {
        int n = 0;
        for (int k = 0; k < count; ++k)
        {
            for (std::uint32_t m = row[k]; m != 0; m &= m - 1)
            {
                pairs[n][isTurned ? 1 : 0] = index[k];
                pairs[n][isTurned ? 0 : 1] = static_cast<std::uint8_t>(lowestBit(m));
                ++n;
            }
        }
        return n;
    }
};

/// Edges of A against edges of B.
inline int edgePairs(const VertexRows& vertices,
                     const SurfacePatch& a,
                     std::uint32_t edgesA,
                     const SurfacePatch& b,
                     std::uint32_t edgesB,
                     bool isTurned,
                     std::uint8_t (*out)[2])
{
    FeatureRows rows;
    for (; edgesA != 0; edgesA &= edgesA - 1)
    {
        const int i = lowestBit(edgesA);
        const int p = a.edgeA[i];
        const int q = a.edgeB[i];
        const std::uint32_t later = &a == &b ? ~lowBits(i + 1) : ~0U;
        rows.add(edgesMeeting(b,
                              bothOf(vertices.codes[p], vertices.codes[q]),
                              eitherOf(vertices.same[p], vertices.same[q])) &
                     edgesB & later,
                 i);
    }
    return rows.write(out, isTurned);
}

/// Vertices of A against faces of B: (vertex, face).
inline int vertexFacePairs(const VertexRows& vertices,
                           std::uint32_t verticesA,
                           const SurfacePatch& b,
                           std::uint32_t facesB,
                           std::uint8_t (*out)[2])
{
    FeatureRows rows;
    for (; verticesA != 0; verticesA &= verticesA - 1)
    {
        const int i = lowestBit(verticesA);
        rows.add(facesMeeting(b, vertices.codes[i], vertices.same[i]) & facesB, i);
    }
    return rows.write(out, false);
}

/// Faces of A against vertices of B: (vertex, face).
inline int faceVertexPairs(const VertexRows& vertices,
                           const SurfacePatch& a,
                           std::uint32_t facesA,
                           std::uint32_t verticesB,
                           std::uint8_t (*out)[2])
{
    FeatureRows rows;
    for (; facesA != 0; facesA &= facesA - 1)
    {
        const int i = lowestBit(facesA);
        const int p = a.faceA[i];
        const int q = a.faceB[i];
        const int r = a.faceC[i];
        const Bytes codes = bothOf(bothOf(vertices.codes[p], vertices.codes[q]), vertices.codes[r]);
        const Bytes same = eitherOf(eitherOf(vertices.same[p], vertices.same[q]), vertices.same[r]);
        rows.add(zeros(eitherOf(codes, same)) & verticesB, i);
    }
    return rows.write(out, true);
}
}  // namespace

namespace BULLET_CCD_ISA
{
unsigned childrenMeeting(const SurfaceNode& node, const MovingBox& box, float* entry)
{
    return meetingChildren(node, box, entry);
}

void patchCandidates(const PatchPair& pair, PatchCandidates& out)
{
    const SurfacePatch& a = *pair.a;
    const SurfacePatch& b = *pair.b;
    out.edgePairs = 0;
    out.vertexFaces = 0;
    out.faceVertices = 0;
    VertexRows rows;
    if (&a == &b)
    {
        const FeaturesMeeting all{
            .vertices = lowBits(a.vertices), .edges = lowBits(a.edges), .faces = lowBits(a.faces)};
        rows.fill(a, all, a, pair.shift[0], true);
        out.edgePairs = edgePairs(rows, a, all.edges, a, all.edges, false, out.edgePair);
        out.vertexFaces = vertexFacePairs(rows, a.own, a, all.faces, out.vertexFace);
        return;
    }
    FeaturesMeeting ofA = featuresMeeting(a, pair.boxB);
    FeaturesMeeting ofB = featuresMeeting(b, pair.boxA);
    const auto keepPairs = [](std::uint32_t& one, std::uint32_t& other)
    {
        one = other != 0 ? one : 0;
        other = one != 0 ? other : 0;
    };
    keepPairs(ofA.edges, ofB.edges);
    keepPairs(ofA.vertices, ofB.faces);
    keepPairs(ofA.faces, ofB.vertices);
    if ((ofA.edges | ofA.vertices | ofA.faces) == 0)
    {
        return;
    }
    // Rows are vertices of the one of which less is left.
    if (__builtin_popcount(ofA.edges) <= __builtin_popcount(ofB.edges))
    {
        rows.fill(a, ofA, b, pair.shift[0], pair.isOneSurface);
        out.edgePairs = edgePairs(rows, a, ofA.edges, b, ofB.edges, false, out.edgePair);
        out.vertexFaces = vertexFacePairs(rows, ofA.vertices, b, ofB.faces, out.vertexFace);
        out.faceVertices = faceVertexPairs(rows, a, ofA.faces, ofB.vertices, out.faceVertex);
    }
    else
    {
        rows.fill(b, ofB, a, pair.shift[1], pair.isOneSurface);
        out.edgePairs = edgePairs(rows, b, ofB.edges, a, ofA.edges, true, out.edgePair);
        out.vertexFaces = faceVertexPairs(rows, b, ofB.faces, ofA.vertices, out.vertexFace);
        out.faceVertices = vertexFacePairs(rows, ofB.vertices, a, ofA.faces, out.faceVertex);
    }
}
}  // namespace BULLET_CCD_ISA
}  // namespace bullet_ccd
