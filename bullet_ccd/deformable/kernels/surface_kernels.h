/// What the search over deforming surfaces spends its time on, for the instruction set of the
/// machine. Plain data only: files that are compiled for different instruction sets must share no
/// inline functions that the linker could merge.
#pragma once

#include <cstdint>
#include <span>

namespace bullet_ccd
{
/// A box whose faces move linearly: components 0 to 2 bound the places at t = 0, 3 to 5 those at
/// t = 1, relative to the centre of the surface; 6 and 7 are not used.
struct alignas(32) MovingBox
{
    float low[8];
    float high[8];
};

constexpr int kPatchFaces = 16;
constexpr int kPatchVertices = 16;
constexpr int kPatchEdges = 32;

/// A few neighbouring triangles with their vertices and edges. Vertices and edges of the surface
/// belong to one patch each; others that its faces need are there as well.
struct alignas(64) SurfacePatch
{
    float place[6][kPatchVertices];       ///< of the vertices, components as in MovingBox
    std::int32_t label[kPatchVertices];   ///< vertices of one label count as one; unused ones: -1
    std::int32_t vertex[kPatchVertices];  ///< numbers of the vertices; unused ones: -1
    std::uint8_t edgeA[kPatchEdges];      ///< own edges, by index into `vertex`
    std::uint8_t edgeB[kPatchEdges];
    std::uint8_t faceA[kPatchFaces];
    std::uint8_t faceB[kPatchFaces];
    std::uint8_t faceC[kPatchFaces];
    std::uint32_t own;      ///< a bit for each vertex that belongs to the patch
    std::uint8_t vertices;  ///< how many there are
    std::uint8_t edges;
    std::uint8_t faces;
    std::uint8_t unused[9];  ///< kernels read 16 bytes from the start of any list
};
static_assert(sizeof(SurfacePatch) == 640);

/// Eight boxes in structure of arrays.
struct alignas(32) SurfaceNode
{
    float low[6][8];
    float high[6][8];
    std::int32_t child[8];  ///< a node, or ~patch
    std::int32_t count;
};

/// A vertex at both ends of the step [m].
struct alignas(64) VertexStep
{
    double start[4];
    double end[4];
};

/// Two patches, of one surface or of two.
struct PatchPair
{
    const SurfacePatch* a;
    const SurfacePatch* b;
    /// From the centre of one surface to that of the other, less and more by the distance at which
    /// boxes count as touching: [0] from A to B, [1] from B to A.
    const MovingBox* shift;
    MovingBox boxA;  ///< of A, shifted to B
    MovingBox boxB;  ///< of B, shifted to A
    bool isOneSurface;
};

/// Pairs of features by their indices in the two patches.
struct PatchCandidates
{
    int edgePairs;
    int vertexFaces;                                      ///< vertex of A, face of B
    int faceVertices;                                     ///< vertex of B, face of A
    std::uint8_t edgePair[kPatchEdges * kPatchEdges][2];  ///< A, B
    std::uint8_t vertexFace[kPatchVertices * kPatchFaces][2];
    std::uint8_t faceVertex[kPatchVertices * kPatchFaces][2];
};

/// Pairs of features of one kind, by their four vertices as ElementaryPair has them. Lanes that are
/// not used must repeat one that is.
struct FeatureBatch
{
    static constexpr int kLanes = 8;
    const VertexStep* vertex[4][kLanes];
    double margin;  ///< distance that counts as apart [m]
    double until;   ///< only the time up to here counts
};

struct SurfaceKernels
{
    const char* level;

    /// Children that the box may meet during the step, a bit each, and a time before which they do
    /// not. Two boxes are apart if they are so along one axis at both ends. Otherwise each of the
    /// six gaps, which are linear in time, leaves an interval, and they meet in the common one
    /// only. Times have a slack of 1e-5. `entry` has eight elements.
    unsigned (*childrenMeeting)(const SurfaceNode& node, const MovingBox& box, float* entry);

    /// Pairs of features whose boxes meet, that belong to the patches and have no label in common.
    /// For a patch with itself each pair comes once.
    void (*patchCandidates)(const PatchPair& pair, PatchCandidates& out);

    /// Pairs that one fixed direction keeps apart by more than the margin and the rounding error, a
    /// bit each: of vertex and face, and of two edges.
    unsigned (*separatedVertexFaces)(const FeatureBatch& batch);
    unsigned (*separatedEdges)(const FeatureBatch& batch);
};

/// All that this processor can run, the portable one first.
[[nodiscard]] std::span<const SurfaceKernels> availableSurfaceKernels();

/// Those of simdLevel().
[[nodiscard]] const SurfaceKernels& surfaceKernels();
}  // namespace bullet_ccd
