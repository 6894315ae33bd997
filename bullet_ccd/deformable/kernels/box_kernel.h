/// A patch against a patch: pairs of their features whose boxes meet. Included once per instruction
/// set.
#pragma once

#include "bullet_ccd/deformable/kernels/patch_codes.h"
#include "bullet_ccd/deformable/kernels/surface_kernels.h"

namespace bullet_ccd
{
namespace
{
/// One of the two patches of a pair, and the way from its surface to the other's.
struct PatchSide
{
    const SurfacePatch& patch;
    const float (*lanes)[8];
    const MovingBox& shift;

    [[nodiscard]] Floats8 vertex(int local) const { return eight(lanes[patch.vertex[local]]); }
};

/// Every row first, without branches, then the few bits that are left.
struct PatchRows
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
    /// Appends (index of the row, bit), or the other way round.
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

inline int edgePairs(const PatchSide& a,
                     std::uint32_t edgesA,
                     const SurfacePatch& b,
                     std::uint32_t edgesB,
                     const PatchPair& pair,
                     bool isTurned,
                     std::uint8_t (*out)[2])
{
    PatchRows rows;
    for (; edgesA != 0; edgesA &= edgesA - 1)
    {
        const int i = lowestBit(edgesA);
        const int va = a.patch.edgeA[i];
        const int vb = a.patch.edgeB[i];
        const Floats8 p = a.vertex(va);
        const Floats8 q = a.vertex(vb);
        std::uint32_t m = edgesMeeting(b,
                                       outcodes(b,
                                                minimum(p, q) + eight(a.shift.low),
                                                maximum(p, q) + eight(a.shift.high))) &
                          edgesB;
        if (pair.isOneSurface)
        {
            m &= ~edgesAt(b, labelled(b, a.patch.label[va], a.patch.label[vb]));
        }
        if (pair.a == pair.b)
        {
            m &= ~lowBits(i + 1);
        }
        rows.add(m, i);
    }
    return rows.write(out, isTurned);
}

inline int vertexFacePairs(const PatchSide& a,
                           std::uint32_t verticesA,
                           const SurfacePatch& b,
                           std::uint32_t facesB,
                           const PatchPair& pair,
                           std::uint8_t (*out)[2])
{
    if (facesB == 0)
    {
        return 0;
    }
    PatchRows rows;
    for (; verticesA != 0; verticesA &= verticesA - 1)
    {
        const int i = lowestBit(verticesA);
        const Floats8 p = a.vertex(i);
        std::uint32_t m =
            facesMeeting(b, outcodes(b, p + eight(a.shift.low), p + eight(a.shift.high))) & facesB;
        if (pair.isOneSurface)
        {
            m &= ~facesAt(b, labelled(b, a.patch.label[i], a.patch.label[i]));
        }
        rows.add(m, i);
    }
    return rows.write(out, false);
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
    const PatchSide a{*pair.a, pair.lanesA, pair.shift[0]};
    const PatchSide b{*pair.b, pair.lanesB, pair.shift[1]};
    if (pair.a == pair.b)
    {
        out.edgePairs =
            edgePairs(a, lowBits(pair.a->edges), *pair.a, ~0U, pair, false, out.edgePair);
        out.vertexFaces = vertexFacePairs(a, pair.a->own, *pair.a, ~0U, pair, out.vertexFace);
        out.faceVertices = 0;
        return;
    }
    const Bytes codesA = outcodes(*pair.a, eight(pair.boxB.low), eight(pair.boxB.high));
    const Bytes codesB = outcodes(*pair.b, eight(pair.boxA.low), eight(pair.boxA.high));
    const std::uint32_t edgesA = edgesMeeting(*pair.a, codesA);
    const std::uint32_t edgesB = edgesMeeting(*pair.b, codesB);
    out.edgePairs = 0;
    if (edgesA != 0 && edgesB != 0)
    {
        out.edgePairs = __builtin_popcount(edgesA) <= __builtin_popcount(edgesB)
                            ? edgePairs(a, edgesA, *pair.b, edgesB, pair, false, out.edgePair)
                            : edgePairs(b, edgesB, *pair.a, edgesA, pair, true, out.edgePair);
    }
    out.vertexFaces = vertexFacePairs(a,
                                      verticesMeeting(*pair.a, codesA),
                                      *pair.b,
                                      facesMeeting(*pair.b, codesB),
                                      pair,
                                      out.vertexFace);
    out.faceVertices = vertexFacePairs(b,
                                       verticesMeeting(*pair.b, codesB),
                                       *pair.a,
                                       facesMeeting(*pair.a, codesA),
                                       pair,
                                       out.faceVertex);
}
}  // namespace BULLET_CCD_ISA
}  // namespace bullet_ccd
