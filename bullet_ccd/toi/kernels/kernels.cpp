// Chooses between the copies of the kernels that were compiled for different instruction sets.
#include "bullet_ccd/toi/kernels/node_batch.h"
#include "bullet_ccd/toi/kernels/triangle_approach.h"

#include <cstdlib>
#include <cstring>

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
    const char* level = "baseline";
    decltype(&baseline::nodeSteps) steps = baseline::nodeSteps;
    decltype(&baseline::rigidPoses) poses = baseline::rigidPoses;
    decltype(&baseline::approachTriangles) triangles = baseline::approachTriangles;
    decltype(&baseline::approachAlong) along = baseline::approachAlong;
};

/// BULLET_CCD_SIMD=baseline in the environment keeps the portable kernels, for tests.
Kernels choose()
{
#if defined(BULLET_CCD_AVX2)
    const char* wish = std::getenv("BULLET_CCD_SIMD");
    const bool baselineWanted = wish != nullptr && std::strcmp(wish, "baseline") == 0;
    if (!baselineWanted && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    {
        return {.level = "avx2",
                .steps = avx2::nodeSteps,
                .poses = avx2::rigidPoses,
                .triangles = avx2::approachTriangles,
                .along = avx2::approachAlong};
    }
#endif
    return {};
}

const Kernels kKernels = choose();
}  // namespace

void nodeSteps(NodeBatch& batch)
{
    kKernels.steps(batch);
}

void rigidPoses(const RigidPoses& poses,
                const double (&times)[NodeBatch::kLanes],
                float slackPerMeter,
                float slackFloor,
                NodeBatch& batch)
{
    kKernels.poses(poses, times, slackPerMeter, slackFloor, batch);
}

void approachTriangles(const RelativeMotion& motion,
                       const double* cornersA,
                       const double* cornersB,
                       double margin,
                       TriangleApproach& approach)
{
    kKernels.triangles(motion, cornersA, cornersB, margin, approach);
}

void approachAlong(const RelativeMotion& motion,
                   const double* cornersA,
                   const double* cornersB,
                   const double* n,
                   double margin,
                   TriangleApproach& approach)
{
    kKernels.along(motion, cornersA, cornersB, n, margin, approach);
}

const char* simdLevel()
{
    return kKernels.level;
}
}  // namespace bullet_ccd
