/// Moving boxes against the children of a node, and a patch against a patch. Included once per
/// instruction set; without AVX2 it is plain loops, the reference of the rest.
#include "bullet_ccd/deformable/kernels/surface_kernels.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace bullet_ccd
{
namespace
{
constexpr float kTimeSlack = 1e-5F;

inline std::uint32_t lowBits(int count)
{
    return static_cast<std::uint32_t>((std::uint64_t{1} << static_cast<unsigned>(count)) - 1U);
}
inline int lowestBit(std::uint32_t m)
{
    return __builtin_ctz(m);
}

#if defined(__AVX2__)

using Floats8 = float __attribute__((vector_size(32)));
using Ints8 = int __attribute__((vector_size(32)));
using Bytes = __m128i;

inline Floats8 eight(const float* p)
{
    return _mm256_load_ps(p);
}
inline unsigned bitsOf8(Ints8 m)
{
    return static_cast<unsigned>(_mm256_movemask_ps((__m256)m));
}

inline unsigned meetingChildren(const SurfaceNode& node, const MovingBox& box, float* entry)
{
    Floats8 f[6];
    Floats8 g[6];
    for (int k = 0; k < 6; ++k)
    {
        f[k] = box.high[k] - eight(node.low[k]);
        g[k] = eight(node.high[k]) - box.low[k];
    }
    Ints8 apart = {};
    for (int k = 0; k < 3; ++k)
    {
        apart |= ((f[k] < 0.0F) & (f[k + 3] < 0.0F)) | ((g[k] < 0.0F) & (g[k + 3] < 0.0F));
    }
    unsigned meeting = ~bitsOf8(apart) & lowBits(node.count);
    if (meeting == 0)
    {
        return 0;
    }
    Floats8 in = {};
    Floats8 out = Floats8{} + 1.0F;
    for (int k = 0; k < 3; ++k)
    {
        for (const Floats8* gap : {f, g})
        {
            const Floats8 root = gap[k] / (gap[k] - gap[k + 3]);
            in = (gap[k] < 0.0F) & (root > in) ? root : in;
            out = (gap[k + 3] < 0.0F) & (root < out) ? root : out;
        }
    }
    meeting &= ~bitsOf8(in > out + kTimeSlack);
    _mm256_storeu_ps(entry, (__m256)in);
    return meeting;
}

/// A byte for each vertex of the patch: bit 2 k (2 k + 1) says that it is above (below) the box
/// along axis k at both ends. A feature is apart from the box if its vertices have a bit in common.
inline Bytes outcodes(const SurfacePatch& patch, Floats8 boxLow, Floats8 boxHigh)
{
#if defined(__AVX512BW__) && defined(__AVX512VL__)
    Bytes codes = _mm_setzero_si128();
    for (int k = 0; k < 3; ++k)
    {
        const __m512 start = _mm512_load_ps(patch.place[k]);
        const __m512 end = _mm512_load_ps(patch.place[k + 3]);
        const __mmask16 above = _mm512_mask_cmp_ps_mask(
            _mm512_cmp_ps_mask(start, _mm512_set1_ps(boxHigh[k]), _CMP_GT_OQ),
            end,
            _mm512_set1_ps(boxHigh[k + 3]),
            _CMP_GT_OQ);
        const __mmask16 below = _mm512_mask_cmp_ps_mask(
            _mm512_cmp_ps_mask(start, _mm512_set1_ps(boxLow[k]), _CMP_LT_OQ),
            end,
            _mm512_set1_ps(boxLow[k + 3]),
            _CMP_LT_OQ);
        codes = _mm_or_si128(codes, _mm_maskz_set1_epi8(above, static_cast<char>(1 << (2 * k))));
        codes = _mm_or_si128(codes, _mm_maskz_set1_epi8(below, static_cast<char>(2 << (2 * k))));
    }
    return codes;
#else
    Ints8 half[2];
    for (int h = 0; h < 2; ++h)
    {
        half[h] = Ints8{};
        for (int k = 0; k < 3; ++k)
        {
            const Floats8 start = eight(patch.place[k] + 8 * h);
            const Floats8 end = eight(patch.place[k + 3] + 8 * h);
            half[h] |= (start > boxHigh[k]) & (end > boxHigh[k + 3]) & (1 << (2 * k));
            half[h] |= (start < boxLow[k]) & (end < boxLow[k + 3]) & (2 << (2 * k));
        }
    }
    const __m256i words =
        _mm256_permute4x64_epi64(_mm256_packs_epi32((__m256i)half[0], (__m256i)half[1]), 0xD8);
    return _mm_packs_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
#endif
}

inline Bytes pick(Bytes codes, const std::uint8_t* index)
{
    return _mm_shuffle_epi8(codes, _mm_loadu_si128(reinterpret_cast<const __m128i*>(index)));
}
inline std::uint32_t zeros(Bytes codes)
{
    return static_cast<std::uint32_t>(
        _mm_movemask_epi8(_mm_cmpeq_epi8(codes, _mm_setzero_si128())));
}

inline std::uint32_t edgesMeeting(const SurfacePatch& patch, Bytes codes)
{
    std::uint32_t m = zeros(_mm_and_si128(pick(codes, patch.edgeA), pick(codes, patch.edgeB)));
    if (patch.edges > 16)
    {
        m |= zeros(_mm_and_si128(pick(codes, patch.edgeA + 16), pick(codes, patch.edgeB + 16)))
             << 16U;
    }
    return m & lowBits(patch.edges);
}
inline std::uint32_t facesMeeting(const SurfacePatch& patch, Bytes codes)
{
    const Bytes common =
        _mm_and_si128(_mm_and_si128(pick(codes, patch.faceA), pick(codes, patch.faceB)),
                      pick(codes, patch.faceC));
    return zeros(common) & lowBits(patch.faces);
}
inline std::uint32_t verticesMeeting(const SurfacePatch& patch, Bytes codes)
{
    return zeros(codes) & patch.own;
}

/// A byte for each vertex of the patch that is not 0 if it has one of the labels.
inline Bytes labelled(const SurfacePatch& patch, std::int32_t a, std::int32_t b)
{
    __m256i half[2];
    for (int h = 0; h < 2; ++h)
    {
        const __m256i labels =
            _mm256_load_si256(reinterpret_cast<const __m256i*>(patch.label + 8 * h));
        half[h] = _mm256_or_si256(_mm256_cmpeq_epi32(labels, _mm256_set1_epi32(a)),
                                  _mm256_cmpeq_epi32(labels, _mm256_set1_epi32(b)));
    }
    const __m256i words = _mm256_permute4x64_epi64(_mm256_packs_epi32(half[0], half[1]), 0xD8);
    return _mm_packs_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
}
inline std::uint32_t edgesAt(const SurfacePatch& patch, Bytes at)
{
    std::uint32_t m = ~zeros(_mm_or_si128(pick(at, patch.edgeA), pick(at, patch.edgeB))) & 0xFFFFU;
    if (patch.edges > 16)
    {
        m |= ~zeros(_mm_or_si128(pick(at, patch.edgeA + 16), pick(at, patch.edgeB + 16))) << 16U;
    }
    return m;
}
inline std::uint32_t facesAt(const SurfacePatch& patch, Bytes at)
{
    return ~zeros(_mm_or_si128(_mm_or_si128(pick(at, patch.faceA), pick(at, patch.faceB)),
                               pick(at, patch.faceC)));
}

inline Floats8 minimum(Floats8 a, Floats8 b)
{
    return _mm256_min_ps(a, b);
}
inline Floats8 maximum(Floats8 a, Floats8 b)
{
    return _mm256_max_ps(a, b);
}

#else

struct Floats8
{
    float v[8];
    float operator[](int k) const { return v[k]; }
};
inline Floats8 eight(const float* p)
{
    Floats8 x;
    for (int k = 0; k < 8; ++k)
    {
        x.v[k] = p[k];
    }
    return x;
}
inline Floats8 operator+(const Floats8& a, const Floats8& b)
{
    Floats8 x;
    for (int k = 0; k < 8; ++k)
    {
        x.v[k] = a.v[k] + b.v[k];
    }
    return x;
}
inline Floats8 minimum(const Floats8& a, const Floats8& b)
{
    Floats8 x;
    for (int k = 0; k < 8; ++k)
    {
        x.v[k] = a.v[k] < b.v[k] ? a.v[k] : b.v[k];
    }
    return x;
}
inline Floats8 maximum(const Floats8& a, const Floats8& b)
{
    Floats8 x;
    for (int k = 0; k < 8; ++k)
    {
        x.v[k] = a.v[k] > b.v[k] ? a.v[k] : b.v[k];
    }
    return x;
}

inline unsigned meetingChildren(const SurfaceNode& node, const MovingBox& box, float* entry)
{
    unsigned meeting = 0;
    for (int i = 0; i < node.count; ++i)
    {
        bool isApart = false;
        float in = 0.0F;
        float out = 1.0F;
        for (int k = 0; k < 3; ++k)
        {
            for (int side = 0; side < 2; ++side)
            {
                const float start =
                    side == 0 ? box.high[k] - node.low[k][i] : node.high[k][i] - box.low[k];
                const float end = side == 0 ? box.high[k + 3] - node.low[k + 3][i]
                                            : node.high[k + 3][i] - box.low[k + 3];
                isApart = isApart || (start < 0.0F && end < 0.0F);
                const float root = start / (start - end);
                in = start < 0.0F && root > in ? root : in;
                out = end < 0.0F && root < out ? root : out;
            }
        }
        meeting |= isApart || in > out + kTimeSlack ? 0U : 1U << static_cast<unsigned>(i);
        entry[i] = in;
    }
    return meeting;
}

struct Bytes
{
    std::uint8_t of[kPatchVertices];
};

/// A byte for each vertex of the patch: bit 2 k (2 k + 1) says that it is above (below) the box
/// along axis k at both ends. A feature is apart from the box if its vertices have a bit in common.
inline Bytes outcodes(const SurfacePatch& patch, const Floats8& boxLow, const Floats8& boxHigh)
{
    Bytes codes;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        unsigned code = 0;
        for (int k = 0; k < 3; ++k)
        {
            const float start = patch.place[k][j];
            const float end = patch.place[k + 3][j];
            code |= start > boxHigh[k] && end > boxHigh[k + 3] ? 1U << (2 * k) : 0U;
            code |= start < boxLow[k] && end < boxLow[k + 3] ? 2U << (2 * k) : 0U;
        }
        codes.of[j] = static_cast<std::uint8_t>(code);
    }
    return codes;
}

inline std::uint32_t edgesMeeting(const SurfacePatch& patch, const Bytes& codes)
{
    std::uint32_t m = 0;
    for (int i = 0; i < patch.edges; ++i)
    {
        const bool isMeeting = (codes.of[patch.edgeA[i]] & codes.of[patch.edgeB[i]]) == 0;
        m |= isMeeting ? 1U << static_cast<unsigned>(i) : 0U;
    }
    return m;
}
inline std::uint32_t facesMeeting(const SurfacePatch& patch, const Bytes& codes)
{
    std::uint32_t m = 0;
    for (int i = 0; i < patch.faces; ++i)
    {
        const bool isMeeting =
            (codes.of[patch.faceA[i]] & codes.of[patch.faceB[i]] & codes.of[patch.faceC[i]]) == 0;
        m |= isMeeting ? 1U << static_cast<unsigned>(i) : 0U;
    }
    return m;
}
inline std::uint32_t verticesMeeting(const SurfacePatch& patch, const Bytes& codes)
{
    std::uint32_t m = 0;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        m |= codes.of[j] == 0 ? 1U << static_cast<unsigned>(j) : 0U;
    }
    return m & patch.own;
}

/// A byte for each vertex of the patch that is not 0 if it has one of the labels.
inline Bytes labelled(const SurfacePatch& patch, std::int32_t a, std::int32_t b)
{
    Bytes at;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        at.of[j] = patch.label[j] == a || patch.label[j] == b ? 1 : 0;
    }
    return at;
}
inline std::uint32_t edgesAt(const SurfacePatch& patch, const Bytes& at)
{
    std::uint32_t m = 0;
    for (int i = 0; i < patch.edges; ++i)
    {
        m |= (at.of[patch.edgeA[i]] | at.of[patch.edgeB[i]]) != 0 ? 1U << static_cast<unsigned>(i)
                                                                  : 0U;
    }
    return m;
}
inline std::uint32_t facesAt(const SurfacePatch& patch, const Bytes& at)
{
    std::uint32_t m = 0;
    for (int i = 0; i < patch.faces; ++i)
    {
        const int any = at.of[patch.faceA[i]] | at.of[patch.faceB[i]] | at.of[patch.faceC[i]];
        m |= any != 0 ? 1U << static_cast<unsigned>(i) : 0U;
    }
    return m;
}

#endif

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
