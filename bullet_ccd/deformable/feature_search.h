/// Which features of a pair of patches touch. Internal to the room.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/deformable/patch_search.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// What the threads of one query share.
struct FeatureSearchState
{
    std::span<const SurfacePair> surfaces;
    const DeformableOptions* options = nullptr;
    bool firstOnly = false;
    /// Of the contacts so far the earliest; nothing later matters if firstOnly.
    std::atomic<double> earliest = std::numeric_limits<double>::infinity();
};

/// One thread's part. Candidates wait until there are eight of a kind, because the kernel that
/// leaves out most of them takes eight at once. Those of several threads stand side by side: none
/// writes into a cache line that another reads.
class alignas(128) FeatureSearch
{
public:
    /// @param contacts  gets those that are not later than the earliest when they are found
    FeatureSearch(FeatureSearchState& state, std::vector<DeformableContact>& contacts)
        : m_state(state), m_contacts(contacts)
    {
    }

    /// Has the patches of a task that comes soon brought into the cache: they lie scattered in
    /// memory, and most of the time would be spent on waiting for them.
    void prefetch(const PatchTask& task) const;
    void examine(const PatchTask& task);
    /// Examines what is still waiting. To be called last.
    void finish();

    [[nodiscard]] const DeformableCounters& counters() const { return m_counters; }

private:
    static constexpr int kLanes = FeatureBatch::kLanes;

    /// Candidates of one kind that wait.
    struct Waiting
    {
        FeatureBatch batch{};
        std::array<std::array<std::int32_t, 4>, kLanes> vertices{};
        std::array<bool, kLanes> isTurned{};  ///< the first feature is of B
        int count = 0;
    };

    void add(Waiting& waiting,
             const DeformableSurface::Data& first,
             const DeformableSurface::Data& second,
             const std::array<std::int32_t, 4>& vertices,
             bool isTurned);
    void flush(Waiting& waiting);
    void advance(const Waiting& waiting, int lane);

    FeatureSearchState& m_state;
    const SurfacePair* m_surfaces = nullptr;  ///< of all that is waiting
    const SurfaceKernels& m_kernels = surfaceKernels();
    PatchCandidates m_candidates{};
    Waiting m_vertexFaces;
    Waiting m_edges;
    std::vector<DeformableContact>& m_contacts;
    DeformableCounters m_counters;
};
}  // namespace bullet_ccd
