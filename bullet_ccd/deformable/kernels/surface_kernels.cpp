// Chooses between the copies of the kernels that were compiled for different instruction sets.
#include "bullet_ccd/deformable/kernels/surface_kernels.h"

#include "bullet_ccd/math/simd_level.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace bullet_ccd
{
namespace
{
using ChildrenMeeting = unsigned(const SurfaceNode&, const MovingBox&, float*);
using Candidates = void(const PatchPair&, PatchCandidates&);
using Separated = unsigned(const FeatureBatch&);
}  // namespace

#define BULLET_CCD_DECLARE_SURFACE_KERNELS(isa) \
    namespace isa                               \
    {                                           \
    ChildrenMeeting childrenMeeting;            \
    Candidates patchCandidates;                 \
    Separated separatedVertexFaces;             \
    Separated separatedEdges;                   \
    }
BULLET_CCD_DECLARE_SURFACE_KERNELS(baseline)
#if defined(BULLET_CCD_AVX2)
BULLET_CCD_DECLARE_SURFACE_KERNELS(avx2)
BULLET_CCD_DECLARE_SURFACE_KERNELS(avx512)
#endif

namespace
{
/// By SimdLevel.
constexpr std::array kSurfaceKernels
{
    SurfaceKernels{.level = "baseline",
                   .childrenMeeting = baseline::childrenMeeting,
                   .patchCandidates = baseline::patchCandidates,
                   .separatedVertexFaces = baseline::separatedVertexFaces,
                   .separatedEdges = baseline::separatedEdges},
#if defined(BULLET_CCD_AVX2)
        SurfaceKernels{.level = "avx2",
                       .childrenMeeting = avx2::childrenMeeting,
                       .patchCandidates = avx2::patchCandidates,
                       .separatedVertexFaces = avx2::separatedVertexFaces,
                       .separatedEdges = avx2::separatedEdges},
        SurfaceKernels{.level = "avx512",
                       .childrenMeeting = avx512::childrenMeeting,
                       .patchCandidates = avx512::patchCandidates,
                       .separatedVertexFaces = avx512::separatedVertexFaces,
                       .separatedEdges = avx512::separatedEdges},
#endif
};

std::span<const SurfaceKernels> upTo(SimdLevel level)
{
    return std::span(kSurfaceKernels)
        .first(std::min(kSurfaceKernels.size(), std::size_t(level) + 1));
}
}  // namespace

std::span<const SurfaceKernels> availableSurfaceKernels()
{
    return upTo(processorSimdLevel());
}

const SurfaceKernels& surfaceKernels()
{
    return upTo(simdLevel()).back();
}
}  // namespace bullet_ccd
