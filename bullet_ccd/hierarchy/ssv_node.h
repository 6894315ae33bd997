/// One volume of a hierarchy, as plain data that the SIMD kernels share.
#pragma once

#include <cstdint>

namespace bullet_ccd
{
/// The volume {center + sum_k s_k axis_k + b : |s_k| <= half_k, |b| <= radius} with axis_2 =
/// axis_0 x axis_1. Its frame is the frame of the tree: that of the mesh, moved so that
/// SsvTree::origin() is its origin. The axes are unit and orthogonal to single precision only; the
/// half-extents include what that costs. Lengths are in metres.
struct alignas(64) SsvNode
{
    float center[3];     // 12 bytes
    float axis0[3];      // 12
    float axis1[3];      // 12
    float half[3];       // 12
    float radius;        // 4
    float coreRadius;    // 4: |half|, the circumscribed radius of the core, rounded up
    std::int32_t first;  // 4: first of `count` adjacent children; for a leaf its triangle's slot
    std::int32_t count;  // 4: number of children, 0 for a leaf

    [[nodiscard]] bool isLeaf() const { return count == 0; }
    /// Circumscribed radius.
    [[nodiscard]] float size() const { return coreRadius + radius; }
};
static_assert(sizeof(SsvNode) == 64);
}  // namespace bullet_ccd
