// Chooses between the copies of the kernels that were compiled for different instruction sets.
#include "bullet_ccd/deformable/kernels/surface_kernels.h"

#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>

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

std::size_t countAvailable()
{
    std::size_t count = 1;
#if defined(BULLET_CCD_AVX2)
    __builtin_cpu_init();  // this may run before the constructor that the compiler has for it
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("popcnt"))
    {
        count = 2;
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
            __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        {
            count = 3;
        }
    }
#endif
    return count;
}
}  // namespace

std::span<const SurfaceKernels> availableSurfaceKernels()
{
    return std::span(kSurfaceKernels).first(countAvailable());
}

const SurfaceKernels& surfaceKernels()
{
    const std::span<const SurfaceKernels> available = availableSurfaceKernels();
    if (const char* wish = std::getenv("BULLET_CCD_SIMD"); wish != nullptr)
    {
        for (const SurfaceKernels& kernels : available)
        {
            if (std::strcmp(wish, kernels.level) == 0)
            {
                return kernels;
            }
        }
    }
    return available.back();
}
}  // namespace bullet_ccd
