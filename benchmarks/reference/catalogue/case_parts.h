/// What several files of the catalogue build their cases of.
#pragma once

#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::reference
{
inline constexpr double kPi = std::numbers::pi;

/// A segment from the origin along x.
[[nodiscard]] inline TriangleMesh rod(double length)
{
    return segment({0, 0, 0}, {length, 0, 0});
}

/// Rods for a chain of those lengths; the base has no geometry.
[[nodiscard]] inline std::vector<TriangleMesh> rods(const std::vector<double>& lengths)
{
    std::vector<TriangleMesh> meshes(1);
    for (const double length : lengths)
    {
        meshes.push_back(rod(length));
    }
    return meshes;
}

/// A gap of 1 that is closed at speed 2.
[[nodiscard]] inline RigidCase falls(const std::string& id, TriangleMesh body, TriangleMesh ground)
{
    return {.id = id,
            .scene = {.meshA = std::move(body),
                      .meshB = std::move(ground),
                      .motionA = {.v_W = {0, 0, -2}}},
            .answer = {.time = 0.5, .closingSpeed = 2.0}};
}
}  // namespace bullet_ccd::reference
