/// Hands and objects, for all files that ask about grasps.
#pragma once

#include "grasp/grasp.h"

#include <filesystem>
#include <optional>

namespace bullet_ccd::python
{
struct Hand
{
    grasp::HandModel model;
    std::filesystem::path file;
    std::optional<std::filesystem::path> srdf{};
};

struct Object
{
    grasp::GraspObject model;
    std::filesystem::path file;
    double scale = 1.0;
};
}  // namespace bullet_ccd::python
