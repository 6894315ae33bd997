// Boxes of a step, from the vertices up.
#include "bullet_ccd/deformable/surface_data.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace bullet_ccd
{
namespace
{
constexpr float kHuge = std::numeric_limits<float>::max();

MovingBox emptyBox()
{
    MovingBox box;
    std::fill_n(box.low, 8, kHuge);
    std::fill_n(box.high, 8, -kHuge);
    return box;
}

void growBox(MovingBox& box, const float* low, const float* high)
{
    for (int k = 0; k < 8; ++k)
    {
        box.low[k] = std::min(box.low[k], low[k]);
        box.high[k] = std::max(box.high[k], high[k]);
    }
}

bool isSame(const double* a, const double* b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/// Calls the function for all indices below `count`; few are not worth a thread.
template <class Function>
void forAll(std::size_t count, int threads, const Function& function, std::size_t atOnce = 1024)
{
    using Range = tbb::blocked_range<std::size_t>;
    const auto some = [&](const Range& range)
    {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
        {
            function(i);
        }
    };
    if (threads == 1 || count < 2 * atOnce)
    {
        some(Range(0, count));
        return;
    }
    tbb::task_arena arena(threads);
    arena.execute([&] { tbb::parallel_for(Range(0, count, atOnce), some); });
}

void placeVertices(std::span<const Eigen::Vector3d> start,
                   std::span<const Eigen::Vector3d> end,
                   int threads,
                   DeformableSurface::Data& data)
{
    constexpr std::size_t kBlock = 1024;
    std::vector<Eigen::AlignedBox3d> boxes((data.steps.size() + kBlock - 1) / kBlock);
    const auto placeBlock = [&](std::size_t block)
    {
        const std::size_t last = std::min(data.steps.size(), (block + 1) * kBlock);
        for (std::size_t i = block * kBlock; i < last; ++i)
        {
            const auto v = static_cast<std::size_t>(data.meshVertex[i]);
            const Eigen::Vector3d& p = start[v];
            const Eigen::Vector3d& q = end[v];
            const VertexStep step{{p.x(), p.y(), p.z(), 0.0}, {q.x(), q.y(), q.z(), 0.0}};
            VertexStep& known = data.steps[i];
            const bool isUnchanged = isSame(step.start, known.start) && isSame(step.end, known.end);
            data.vertexIdle[i] = static_cast<std::uint8_t>(
                (isSame(step.start, step.end) ? kRests : 0) | (isUnchanged ? kUnchanged : 0));
            known = step;
            boxes[block].extend(p);
            boxes[block].extend(q);
        }
    };
    forAll(boxes.size(), threads, placeBlock, 1);
    Eigen::AlignedBox3d all;
    for (const Eigen::AlignedBox3d& box : boxes)
    {
        all.extend(box);
    }
    const Eigen::Vector3d c = 0.5 * all.min() + 0.5 * all.max();
    data.bounds = all;
    data.centre = c;
    data.halfExtent = 0.5 * all.sizes().maxCoeff();
}

void refitPatch(DeformableSurface::Data& data, std::size_t index)
{
    SurfacePatch& patch = data.patches[index];
    MovingBox box = emptyBox();
    std::uint8_t idle = kRests | kUnchanged;
    for (int j = 0; j < patch.vertices; ++j)
    {
        const auto v = static_cast<std::size_t>(patch.vertex[j]);
        const VertexStep& step = data.steps[v];
        float place[8] = {};
        for (int k = 0; k < 3; ++k)
        {
            place[k] = static_cast<float>(step.start[k] - data.centre[k]);
            place[k + 3] = static_cast<float>(step.end[k] - data.centre[k]);
        }
        growBox(box, place, place);
        for (int k = 0; k < 6; ++k)
        {
            patch.place[k][j] = place[k];
        }
        idle &= data.vertexIdle[v];
    }
    data.patchBoxes[index] = box;
    data.patchIdle[index] = idle;
}

void refitNode(DeformableSurface::Data& data, std::size_t index)
{
    SurfaceNode& node = data.nodes[index];
    MovingBox box = emptyBox();
    std::uint8_t idle = kRests | kUnchanged;
    for (int i = 0; i < 8; ++i)
    {
        MovingBox child = emptyBox();
        if (i < node.count)
        {
            child = data.box(node.child[i]);
            idle &= data.idle(node.child[i]);
            growBox(box, child.low, child.high);
        }
        for (int k = 0; k < 6; ++k)
        {
            node.low[k][i] = child.low[k];
            node.high[k][i] = child.high[k];
        }
    }
    data.nodeBoxes[index] = box;
    data.nodeIdle[index] = idle;
}
}  // namespace

void refitSurface(std::span<const Eigen::Vector3d> start,
                  std::span<const Eigen::Vector3d> end,
                  int threads,
                  DeformableSurface::Data& data)
{
    placeVertices(start, end, threads, data);
    forAll(data.patches.size(), threads, [&](std::size_t i) { refitPatch(data, i); });
    for (std::size_t i = data.nodes.size(); i-- > 0;)  // children before their parents
    {
        refitNode(data, i);
    }
    data.isUnchanged = false;
}
}  // namespace bullet_ccd
