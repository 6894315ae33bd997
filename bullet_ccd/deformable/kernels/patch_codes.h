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

#if defined(__AVX512BW__) && defined(__AVX512VL__)
/// Codes with the two bits of axis k.
inline Bytes withBits(Bytes codes, __mmask16 above, __mmask16 below, int k)
{
    codes = _mm_mask_add_epi8(codes, above, codes, _mm_set1_epi8(static_cast<char>(1 << (2 * k))));
    return _mm_mask_add_epi8(codes, below, codes, _mm_set1_epi8(static_cast<char>(2 << (2 * k))));
}
#endif
/// Low bytes of 16 numbers.
inline Bytes packed(const Ints8* half)
{
    const __m256i words =
        _mm256_permute4x64_epi64(_mm256_packs_epi32((__m256i)half[0], (__m256i)half[1]), 0xD8);
    return _mm_packs_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
}

/// A byte for each vertex of the patch: bit 2 k (2 k + 1) says that it is above (below) the box
/// along axis k at both ends. A feature is apart from the box if its vertices have a bit in common.
/// @param low,high  of the box, components as in MovingBox
inline Bytes outcodes(const SurfacePatch& patch, const float* low, const float* high)
{
#if defined(__AVX512BW__) && defined(__AVX512VL__)
    Bytes codes = _mm_setzero_si128();
    for (int k = 0; k < 3; ++k)
    {
        const __m512 start = _mm512_load_ps(patch.place[k]);
        const __m512 end = _mm512_load_ps(patch.place[k + 3]);
        const __mmask16 above =
            _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(start, _mm512_set1_ps(high[k]), _CMP_GT_OQ),
                                    end,
                                    _mm512_set1_ps(high[k + 3]),
                                    _CMP_GT_OQ);
        const __mmask16 below =
            _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(start, _mm512_set1_ps(low[k]), _CMP_LT_OQ),
                                    end,
                                    _mm512_set1_ps(low[k + 3]),
                                    _CMP_LT_OQ);
        codes = withBits(codes, above, below, k);
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
            half[h] |= (start > high[k]) & (end > high[k + 3]) & (1 << (2 * k));
            half[h] |= (start < low[k]) & (end < low[k + 3]) & (2 << (2 * k));
        }
    }
    return packed(half);
#endif
}

/// The vertices of a patch from where vertices of another one are: nearer, and farther, by the
/// distance at which they count as touching.
class ShiftedPatch
{
public:
    /// @param shift  from the other surface to that of the patch
    ShiftedPatch(const SurfacePatch& patch, const MovingBox& shift)
    {
        for (int k = 0; k < 6; ++k)
        {
            for (int h = 0; h < kParts; ++h)
            {
                const Places place = *reinterpret_cast<const Places*>(patch.place[k] + kEach * h);
                m_lower[k][h] = place - shift.high[k];
                m_upper[k][h] = place - shift.low[k];
            }
        }
    }

    /// outcodes() of the patch for a vertex of another one, by its index there.
    [[nodiscard]] Bytes outcodes(const SurfacePatch& other, int vertex) const
    {
#if defined(__AVX512BW__) && defined(__AVX512VL__)
        Bytes codes = _mm_setzero_si128();
        for (int k = 0; k < 3; ++k)
        {
            const __m512 start = _mm512_set1_ps(other.place[k][vertex]);
            const __m512 end = _mm512_set1_ps(other.place[k + 3][vertex]);
            const __mmask16 above = _mm512_mask_cmp_ps_mask(
                _mm512_cmp_ps_mask((__m512)m_lower[k][0], start, _CMP_GT_OQ),
                (__m512)m_lower[k + 3][0],
                end,
                _CMP_GT_OQ);
            const __mmask16 below = _mm512_mask_cmp_ps_mask(
                _mm512_cmp_ps_mask((__m512)m_upper[k][0], start, _CMP_LT_OQ),
                (__m512)m_upper[k + 3][0],
                end,
                _CMP_LT_OQ);
            codes = withBits(codes, above, below, k);
        }
        return codes;
#else
        Ints8 half[kParts];
        for (int h = 0; h < kParts; ++h)
        {
            half[h] = Ints8{};
            for (int k = 0; k < 3; ++k)
            {
                const float start = other.place[k][vertex];
                const float end = other.place[k + 3][vertex];
                half[h] |= (m_lower[k][h] > start) & (m_lower[k + 3][h] > end) & (1 << (2 * k));
                half[h] |= (m_upper[k][h] < start) & (m_upper[k + 3][h] < end) & (2 << (2 * k));
            }
        }
        return packed(half);
#endif
    }

private:
#if defined(__AVX512BW__) && defined(__AVX512VL__)
    static constexpr int kEach = 16;
#else
    static constexpr int kEach = 8;
#endif
    static constexpr int kParts = kPatchVertices / kEach;
    using Places = float __attribute__((vector_size(4 * kEach), may_alias));

    Places m_lower[6][kParts];
    Places m_upper[6][kParts];
};

inline Bytes bothOf(Bytes a, Bytes b)
{
    return _mm_and_si128(a, b);
}
inline Bytes eitherOf(Bytes a, Bytes b)
{
    return _mm_or_si128(a, b);
}
inline Bytes noBits()
{
    return _mm_setzero_si128();
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

/// A bit for each edge whose vertices have no bit in common.
/// @param same  not 0 for vertices whose edges do not count
inline std::uint32_t edgesMeeting(const SurfacePatch& patch, Bytes codes, Bytes same)
{
    const auto sixteen = [&](int first)
    {
        const std::uint8_t* a = patch.edgeA + first;
        const std::uint8_t* b = patch.edgeB + first;
        return zeros(eitherOf(bothOf(pick(codes, a), pick(codes, b)),
                              eitherOf(pick(same, a), pick(same, b))));
    };
    std::uint32_t m = sixteen(0);
    if (patch.edges > 16)
    {
        m |= sixteen(16) << 16U;
    }
    return m & lowBits(patch.edges);
}
/// The same of faces.
inline std::uint32_t facesMeeting(const SurfacePatch& patch, Bytes codes, Bytes same)
{
    const std::uint8_t* const a = patch.faceA;
    const std::uint8_t* const b = patch.faceB;
    const std::uint8_t* const c = patch.faceC;
    const Bytes all = bothOf(bothOf(pick(codes, a), pick(codes, b)), pick(codes, c));
    const Bytes any = eitherOf(eitherOf(pick(same, a), pick(same, b)), pick(same, c));
    return zeros(eitherOf(all, any)) & lowBits(patch.faces);
}

/// A byte for each vertex of the patch that is not 0 if it has the label.
inline Bytes labelled(const SurfacePatch& patch, std::int32_t label)
{
#if defined(__AVX512BW__) && defined(__AVX512VL__)
    return _mm_movm_epi8(
        _mm512_cmpeq_epi32_mask(_mm512_load_si512(patch.label), _mm512_set1_epi32(label)));
#else
    Ints8 half[2];
    for (int h = 0; h < 2; ++h)
    {
        const __m256i labels =
            _mm256_load_si256(reinterpret_cast<const __m256i*>(patch.label + 8 * h));
        half[h] = (Ints8)_mm256_cmpeq_epi32(labels, _mm256_set1_epi32(label));
    }
    return packed(half);
#endif
}
#else

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
/// @param low,high  of the box, components as in MovingBox
inline Bytes outcodes(const SurfacePatch& patch, const float* low, const float* high)
{
    Bytes codes;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        unsigned code = 0;
        for (int k = 0; k < 3; ++k)
        {
            const float start = patch.place[k][j];
            const float end = patch.place[k + 3][j];
            code |= start > high[k] && end > high[k + 3] ? 1U << (2 * k) : 0U;
            code |= start < low[k] && end < low[k + 3] ? 2U << (2 * k) : 0U;
        }
        codes.of[j] = static_cast<std::uint8_t>(code);
    }
    return codes;
}

/// The vertices of a patch from where vertices of another one are: nearer, and farther, by the
/// distance at which they count as touching.
class ShiftedPatch
{
public:
    /// @param shift  from the other surface to that of the patch
    ShiftedPatch(const SurfacePatch& patch, const MovingBox& shift)
    {
        for (int k = 0; k < 6; ++k)
        {
            for (int j = 0; j < kPatchVertices; ++j)
            {
                m_lower[k][j] = patch.place[k][j] - shift.high[k];
                m_upper[k][j] = patch.place[k][j] - shift.low[k];
            }
        }
    }

    /// outcodes() of the patch for a vertex of another one, by its index there.
    [[nodiscard]] Bytes outcodes(const SurfacePatch& other, int vertex) const
    {
        Bytes codes;
        for (int j = 0; j < kPatchVertices; ++j)
        {
            unsigned code = 0;
            for (int k = 0; k < 3; ++k)
            {
                const float start = other.place[k][vertex];
                const float end = other.place[k + 3][vertex];
                const bool isAbove = (m_lower[k][j] > start) & (m_lower[k + 3][j] > end);
                const bool isBelow = (m_upper[k][j] < start) & (m_upper[k + 3][j] < end);
                code |= (isAbove ? 1U << (2 * k) : 0U) | (isBelow ? 2U << (2 * k) : 0U);
            }
            codes.of[j] = static_cast<std::uint8_t>(code);
        }
        return codes;
    }

private:
    float m_lower[6][kPatchVertices];
    float m_upper[6][kPatchVertices];
};

inline Bytes bothOf(const Bytes& a, const Bytes& b)
{
    Bytes both;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        both.of[j] = a.of[j] & b.of[j];
    }
    return both;
}
inline Bytes eitherOf(const Bytes& a, const Bytes& b)
{
    Bytes either;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        either.of[j] = a.of[j] | b.of[j];
    }
    return either;
}
inline Bytes noBits()
{
    return {};
}
inline std::uint32_t zeros(const Bytes& codes)
{
    std::uint32_t m = 0;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        m |= codes.of[j] == 0 ? 1U << static_cast<unsigned>(j) : 0U;
    }
    return m;
}

/// A bit for each edge whose vertices have no bit in common.
/// @param same  not 0 for vertices whose edges do not count
inline std::uint32_t edgesMeeting(const SurfacePatch& patch, const Bytes& codes, const Bytes& same)
{
    std::uint32_t m = 0;
    for (int i = 0; i < patch.edges; ++i)
    {
        const int a = patch.edgeA[i];
        const int b = patch.edgeB[i];
        const bool isMeeting = ((codes.of[a] & codes.of[b]) | same.of[a] | same.of[b]) == 0;
        m |= isMeeting ? 1U << static_cast<unsigned>(i) : 0U;
    }
    return m;
}
/// The same of faces.
inline std::uint32_t facesMeeting(const SurfacePatch& patch, const Bytes& codes, const Bytes& same)
{
    std::uint32_t m = 0;
    for (int i = 0; i < patch.faces; ++i)
    {
        const int a = patch.faceA[i];
        const int b = patch.faceB[i];
        const int c = patch.faceC[i];
        const bool isMeeting =
            ((codes.of[a] & codes.of[b] & codes.of[c]) | same.of[a] | same.of[b] | same.of[c]) == 0;
        m |= isMeeting ? 1U << static_cast<unsigned>(i) : 0U;
    }
    return m;
}
/// A byte for each vertex of the patch that is not 0 if it has the label.
inline Bytes labelled(const SurfacePatch& patch, std::int32_t label)
{
    Bytes at;
    for (int j = 0; j < kPatchVertices; ++j)
    {
        at.of[j] = patch.label[j] == label ? 1 : 0;
    }
    return at;
}
#endif
}  // namespace
}  // namespace bullet_ccd
