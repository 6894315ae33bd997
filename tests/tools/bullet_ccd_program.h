/// The program bullet-ccd, with a cube and a plate to query.
#pragma once

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fmt/format.h>
#include <string>

namespace bullet_ccd::tools
{
class BulletCcdProgram : public ::testing::Test
{
protected:
    void SetUp() override
    {
        writeObj(makeBox({1.0, 1.0, 1.0}), m_cube);
        writeObj(makeBox({10.0, 10.0, 0.1}), m_plate);
    }

    [[nodiscard]] static Outcome run(const std::string& arguments)
    {
        return runProgram(std::string(BULLET_CCD_PROGRAM) + " " + arguments);
    }

    [[nodiscard]] std::string cubeAndPlate() const
    {
        return fmt::format("'{}' '{}' ", m_cube.string(), m_plate.string());
    }

    tests::TempFolder m_temp;
    std::filesystem::path m_cube = m_temp.path() / "cube.obj";
    std::filesystem::path m_plate = m_temp.path() / "plate.obj";
};

/// A cube of edge 2 whose lower face starts 0.9 above the upper face of the plate.
inline RigidMotion fallingCube(double speed)
{
    RigidMotion motion{.v_W = {0.0, 0.0, -speed}};
    motion.X_W0.translation().z() = 2.0;
    return motion;
}
}  // namespace bullet_ccd::tools
