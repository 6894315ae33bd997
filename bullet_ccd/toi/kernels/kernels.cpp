// Chooses between the copies of the kernels that were compiled for different instruction sets.
#include "bullet_ccd/math/simd_level.h"
#include "bullet_ccd/toi/kernels/node_batch.h"
#include "bullet_ccd/toi/kernels/triangle_approach.h"

#include <atomic>

namespace bullet_ccd
{
namespace baseline
{
decltype(bullet_ccd::nodeSteps) nodeSteps;
decltype(bullet_ccd::rigidPoses) rigidPoses;
decltype(bullet_ccd::approachTriangles) approachTriangles;
decltype(bullet_ccd::approachAlong) approachAlong;
}  // namespace baseline
#if defined(BULLET_CCD_AVX2)
namespace avx2
{
decltype(bullet_ccd::nodeSteps) nodeSteps;
decltype(bullet_ccd::rigidPoses) rigidPoses;
decltype(bullet_ccd::approachTriangles) approachTriangles;
decltype(bullet_ccd::approachAlong) approachAlong;
}  // namespace avx2
#endif

namespace
{
struct Kernels
{
    decltype(&baseline::nodeSteps) steps;
    decltype(&baseline::rigidPoses) poses;
    decltype(&baseline::approachTriangles) triangles;
    decltype(&baseline::approachAlong) along;
};

constexpr Kernels kBaseline{.steps = baseline::nodeSteps,
                            .poses = baseline::rigidPoses,
                            .triangles = baseline::approachTriangles,
                            .along = baseline::approachAlong};
#if defined(BULLET_CCD_AVX2)
constexpr Kernels kAvx2{.steps = avx2::nodeSteps,
                        .poses = avx2::rigidPoses,
                        .triangles = avx2::approachTriangles,
                        .along = avx2::approachAlong};
#endif

const Kernels& choose()
{
#if defined(BULLET_CCD_AVX2)
    if (simdLevel() >= SimdLevel::Avx2)
    {
        return kAvx2;
    }
#endif
    return kBaseline;
}

/// Chosen at the first query, so that queries may be made by constructors of other files' globals.
constinit std::atomic<const Kernels*> chosen = nullptr;

const Kernels& kernels()
{
    const Kernels* known = chosen.load(std::memory_order_relaxed);
    if (known == nullptr) [[unlikely]]
    {
        known = &choose();
        chosen.store(known, std::memory_order_relaxed);
    }
    return *known;
}
}  // namespace

void nodeSteps(NodeBatch& batch)
{
    kernels().steps(batch);
}

void rigidPoses(const RigidPoses& poses,
                const double (&times)[NodeBatch::kLanes],
                float slackPerMeter,
                float slackFloor,
                NodeBatch& batch)
{
    kernels().poses(poses, times, slackPerMeter, slackFloor, batch);
}

void approachTriangles(const RelativeMotion& motion,
                       const double* cornersA,
                       const double* cornersB,
                       double margin,
                       TriangleApproach& approach)
{
    kernels().triangles(motion, cornersA, cornersB, margin, approach);
}

void approachAlong(const RelativeMotion& motion,
                   const double* cornersA,
                   const double* cornersB,
                   const double* n,
                   double margin,
                   TriangleApproach& approach)
{
    kernels().along(motion, cornersA, cornersB, n, margin, approach);
}
}  // namespace bullet_ccd
