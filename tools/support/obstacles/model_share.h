/// What a scene needed: the last line of answers to an accuracy, as text and as JSON.
#pragma once

#include "bullet_ccd/toi/model_use.h"

#include <cstddef>
#include <span>
#include <string>

namespace bullet_ccd::tools
{
/// How much of the models was looked at, and how much there is.
struct ModelShare
{
    std::size_t bodies = 0;
    std::size_t ofBodies = 0;
    std::size_t triangles = 0;
    std::size_t ofTriangles = 0;
    std::size_t joints = 0;  ///< that move; the others are merged into their links
    std::size_t ofJoints = 0;

    ModelShare() = default;
    /// Of the trees of a scene, one entry a body; null: a body without a mesh.
    /// @param uses  one for each thread that asked: what any of them looked at counts, once
    ModelShare(std::span<const ModelUse> uses, std::span<const SsvTree* const> trees);
    ModelShare(const ModelUse& use, std::span<const SsvTree* const> trees)
        : ModelShare(std::span(&use, 1), trees)
    {
    }
};

/// "2 of 41 bodies, 1,312 of 655,360 triangles", with joints, if there are any ", 2 of 7 joints"
[[nodiscard]] std::string plainText(const ModelShare& share);

/// "  needed      2 of 41 bodies, 1,312 of 655,360 triangles\n"
[[nodiscard]] std::string readableText(const ModelShare& share);

/// "needed": {"bodies": 2, "of_bodies": 41, "triangles": 1312, "of_triangles": 655360},
/// likewise
[[nodiscard]] std::string jsonText(const ModelShare& share);
}  // namespace bullet_ccd::tools
