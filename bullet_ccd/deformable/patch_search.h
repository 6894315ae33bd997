/// Which patches of two surfaces, or of one, can meet in the step. Internal to the room.
#pragma once

#include "bullet_ccd/deformable/kernels/surface_kernels.h"
#include "bullet_ccd/deformable/surface_data.h"

#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// Two surfaces that are tested against each other, or one against itself.
struct SurfacePair
{
    const DeformableSurface::Data* a = nullptr;
    const DeformableSurface::Data* b = nullptr;
    std::int32_t bodyA = kNone;
    std::int32_t bodyB = kNone;
    double separation = 0.0;  ///< that has to be kept [m]
    /// What has one of these bits on both sides is left out: kRests, also kUnchanged.
    std::uint8_t idle = kRests;
    /// From the centre of one to that of the other, widened by the distance at which boxes count as
    /// touching, see PatchPair.
    MovingBox shift[2];

    [[nodiscard]] bool isOneSurface() const { return bodyA == bodyB; }
};

/// @param distance  features that come so close must be found: separation and tolerance [m]
[[nodiscard]] SurfacePair surfacePair(const DeformableSurface::Data& a,
                                      const DeformableSurface::Data& b,
                                      double separation,
                                      double distance);

[[nodiscard]] inline MovingBox shifted(const MovingBox& box, const MovingBox& shift)
{
    MovingBox result;
    for (int k = 0; k < 8; ++k)
    {
        result.low[k] = box.low[k] + shift.low[k];
        result.high[k] = box.high[k] + shift.high[k];
    }
    return result;
}

/// A patch of A and one of B; those of one surface come once.
struct PatchTask
{
    std::int32_t surfacePair = 0;
    std::int32_t patchA = 0;
    std::int32_t patchB = 0;
    float entry = 0.0F;  ///< they do not meet before it
};

/// Appends all pairs of patches whose boxes meet, but for those that are idle. Returns false, with
/// some of them, if `tasks` would grow beyond `most`.
[[nodiscard]] bool findPatchPairs(const SurfacePair& pair,
                                  std::int32_t index,
                                  std::size_t most,
                                  int threads,
                                  std::vector<PatchTask>& tasks);
}  // namespace bullet_ccd
