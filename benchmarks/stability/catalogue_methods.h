/// The methods that the catalogue runs through, with their settings and what they cannot do.
#pragma once

#include "benchmarks/stability/catalogue_peer.h"

#include <functional>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
template <typename Case>
struct Method
{
    std::string name;
    std::string owner;  ///< ours, sampled, fcl, bullet
    std::string setting;
    std::function<PeerAnswer(const Case&)> run;
    /// Why the method cannot be asked this, or "".
    std::function<std::string(const Case&)> notApplicable = [](const Case&) { return ""; };
};

/// Steps of sampling are prime numbers: many of the catalogue's contact times are multiples of
/// 1/1000, which round numbers of steps would hit by luck.
[[nodiscard]] std::vector<Method<RigidCase>> rigidMethods();
[[nodiscard]] std::vector<Method<ArticulatedCase>> articulatedMethods();

/// True for closed convex surfaces and for single triangles, segments, points and rectangles: for
/// what is the same to a query as its convex hull, as long as the other body is outside.
[[nodiscard]] bool isConvex(const TriangleMesh& mesh);
}  // namespace bullet_ccd::tests
