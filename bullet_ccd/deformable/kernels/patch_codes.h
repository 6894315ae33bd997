/// What the kernel of boxes is made of: a box against the children of a node, codes of the vertices
/// of a patch against a box, and what follows from codes for edges and faces. Included once per
/// instruction set; without AVX2 it is plain loops, the reference of the rest.
#pragma once

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
}  // namespace
}  // namespace bullet_ccd
