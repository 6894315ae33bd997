/// Whether a hierarchy contains its triangles, by a reference in extended precision, and answers as
/// another one.
#pragma once

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
struct TreeCheck
{
    int depth = 0;
    std::vector<int> leavesOfTriangle;
    double worstEscape = -std::numeric_limits<double>::infinity();  ///< relative to the node's size
    double worstCoreRadius = -std::numeric_limits<double>::infinity();
    std::size_t visited = 0;
    std::size_t doors = 0;  ///< nodes with one child, see SsvTree::nodes()
};

/// Every node against the triangles below it.
/// @param shrink factor of all extents and radii, to show that the check would notice
[[nodiscard]] TreeCheck checkTree(const SsvTree& tree, double shrink = 1.0);

/// Expects that all volumes contain their triangles, and that every triangle has one leaf.
void expectSoundTree(const SsvTree& tree, const std::string& what);

/// Expects the same distances and contacts of a mesh with itself in random passes. Distances are
/// exact whatever the volumes, times certified: they differ by what the tolerance allows along the
/// motion.
void expectSameAnswers(const SsvTree& a, const SsvTree& b, reference::Random& random, int queries);
}  // namespace bullet_ccd::tests
