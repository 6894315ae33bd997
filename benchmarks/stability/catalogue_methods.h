/// The methods that the catalogue runs through: a case in, contact and time out.
#pragma once

#include "benchmarks/reference/catalogue/cases.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
enum class PeerOutcome : std::uint8_t
{
    Free,
    Contact,
    GaveUp,  ///< says itself that it has no answer
};

struct PeerAnswer
{
    PeerOutcome outcome = PeerOutcome::Free;
    double time = 1.0;       ///< of the contact, a fraction of the motion
    std::int64_t pairs = 0;  ///< of nodes and triangles that were looked at; 0 if not counted
};

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

/// This library with every strategy at the finest tolerance of the case, FCL's sampling and its
/// conservative advancement, Bullet's casts and the closest points of its hulls at sampled poses;
/// for chains, sampling with exact distances and with FCL's overlap test. Numbers of steps
/// are primes: many of the catalogue's contact times are multiples of 1/1000, which round numbers
/// of steps would hit by luck.
[[nodiscard]] std::vector<Method<reference::RigidCase>> rigidMethods();
[[nodiscard]] std::vector<Method<reference::ArticulatedCase>> articulatedMethods();

/// True for closed convex surfaces and for single triangles, segments, points and rectangles: for
/// what is the same to a query as its convex hull, as long as the other body is outside.
[[nodiscard]] bool isConvex(const TriangleMesh& mesh);
}  // namespace bullet_ccd::benchmarks
