// generate_robots: writes the link meshes of the robots that ship; run by the build.
#include "bullet_ccd/io/mesh_file.h"
#include "robots/shapes/robot_meshes.h"

#include <exception>
#include <filesystem>
#include <iostream>
#include <string_view>

namespace
{
constexpr std::string_view kUsage =
    "usage: generate_robots FOLDER\n"
    "Writes FOLDER/<robot>/<mesh>.obj for every robot that ships.\n";
}  // namespace

int main(int argc, char** argv)
{
    using namespace bullet_ccd;
    const std::string_view argument = argc == 2 ? argv[1] : "";
    if (argument == "--help" || argument == "-h")
    {
        std::cout << kUsage;
        return 0;
    }
    if (argument.empty() || argument.starts_with('-'))
    {
        std::cerr << kUsage;
        return 2;
    }
    try
    {
        for (const shapes::RobotMeshes& robot : {shapes::anthropomorphicHandMeshes(),
                                                 shapes::threeFingerGripperMeshes(),
                                                 shapes::parallelGripperMeshes()})
        {
            const std::filesystem::path folder = std::filesystem::path(argument) / robot.robot;
            std::filesystem::create_directories(folder);
            for (const shapes::NamedMesh& link : robot.links)
            {
                writeObj(link.mesh, folder / (link.name + ".obj"));
            }
        }
    }
    catch (const std::exception& error)
    {
        std::cerr << "generate_robots: " << error.what() << '\n';
        return 1;
    }
    return 0;
}
