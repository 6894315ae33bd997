#include "tools/grasp_cli/inputs/catalogue.h"

#include "bullet_ccd/io/mesh_file.h"
#include "grasp/hand/hand_model.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace fs = std::filesystem;

namespace
{
std::string knownNames(const std::vector<std::string>& names, const fs::path& share)
{
    if (share.empty())
    {
        return "no shipped ones were found either; set BULLET_CCD_SHARE to the folder that holds "
               "robots/ and objects/";
    }
    return names.empty() ? fmt::format("none ship in {}", share.string())
                         : fmt::format("shipped are: {}", joined(names, ", "));
}

fs::path existingFile(const fs::path& path, const char* kind)
{
    if (fs::is_directory(path))
    {
        throw std::runtime_error(
            fmt::format("{}: is a folder: give the {} in it", path.string(), kind));
    }
    return path;
}
}  // namespace

fs::path viewerFile(const std::string& name)
{
    const fs::path file = shareFolder() / name;
    return fs::exists(file) ? file : fs::path();
}

fs::path cacheFolder()
{
    const auto set = [](const char* name) -> std::optional<fs::path>
    {
        const char* const value = std::getenv(name);
        return value == nullptr ? std::nullopt : std::optional<fs::path>(value);
    };
    if (const std::optional<fs::path> folder = set("BULLET_CCD_CACHE"))
    {
        return *folder;
    }
    // A relative $XDG_CACHE_HOME is to be ignored, by its specification.
    fs::path user = set("XDG_CACHE_HOME").value_or(fs::path());
    if (user.is_relative())
    {
        const fs::path home = set("HOME").value_or(fs::path());
        // A home that does not exist, such as that of nobody, is not made.
        std::error_code error;
        user = home.is_absolute() && fs::is_directory(home, error) ? home / ".cache" : fs::path();
    }
    return user.empty() ? user : user / "bullet_ccd";
}

std::vector<std::string> shippedHands(const fs::path& share)
{
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(share / "robots", error))
    {
        const std::string name = entry.path().filename().string();
        if (fs::exists(entry.path() / (name + ".urdf")))
        {
            names.push_back(name);
        }
    }
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> shippedObjects(const fs::path& share)
{
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(share / "objects", error))
    {
        if (entry.path().extension() == ".obj")
        {
            names.push_back(entry.path().stem().string());
        }
    }
    std::sort(names.begin(), names.end());
    return names;
}

fs::path resolveHand(const std::string& nameOrPath)
{
    const fs::path share = shareFolder();
    const fs::path shipped = share / "robots" / nameOrPath / (nameOrPath + ".urdf");
    // A folder of that name, such as one with earlier outputs, does not hide what ships.
    const bool ships = !share.empty() && fs::exists(shipped);
    if (fs::exists(nameOrPath) && !(ships && fs::is_directory(nameOrPath)))
    {
        return existingFile(nameOrPath, "URDF or MJCF file");
    }
    if (ships)
    {
        return shipped;
    }
    throw std::runtime_error(fmt::format("hand \"{}\": neither a file nor a shipped hand; {}",
                                         nameOrPath,
                                         knownNames(shippedHands(share), share)));
}

fs::path resolveObject(const std::string& nameOrPath)
{
    const fs::path share = shareFolder();
    const fs::path shipped = share / "objects" / (nameOrPath + ".obj");
    // A folder of that name, such as one with earlier outputs, does not hide what ships.
    const bool ships = !share.empty() && fs::exists(shipped);
    if (fs::exists(nameOrPath) && !(ships && fs::is_directory(nameOrPath)))
    {
        return existingFile(nameOrPath, "mesh file");
    }
    if (ships)
    {
        return shipped;
    }
    throw std::runtime_error(fmt::format("object \"{}\": neither a file nor a shipped object; {}",
                                         nameOrPath,
                                         knownNames(shippedObjects(share), share)));
}

LoadedHand loadNamedHand(const std::string& nameOrPath, const fs::path& srdf)
{
    const fs::path file = fs::absolute(resolveHand(nameOrPath)).lexically_normal();
    LoadedHand loaded{
        .hand = grasp::loadHand(
            file, srdf.empty() ? std::nullopt : std::optional(srdf), shareFolder(), cacheFolder()),
        .file = file};
    if (fs::path& used = loaded.hand.srdfFile; !used.empty())
    {
        used = fs::absolute(used).lexically_normal();
    }
    return loaded;
}

LoadedObject loadNamedObject(const std::string& nameOrPath, double scale)
{
    const fs::path file = fs::absolute(resolveObject(nameOrPath)).lexically_normal();
    MeshFile loaded = loadMeshFile(file, {.scale = scale});
    LoadedObject result{
        .object = grasp::makeGraspObject(file.stem().string(), std::move(loaded.mesh)),
        .file = file,
        .notes = std::move(loaded.notes)};
    if (!result.object.watertight)
    {
        result.notes.emplace_back(
            "not watertight: the centre of mass is taken from its bounding box, and vertices "
            "inside it cannot be noticed");
    }
    constexpr double kSmall = 2e-3;  // [m] radius below which units are probably wrong
    constexpr double kLarge = 2.0;
    if (result.object.radius < kSmall || result.object.radius > kLarge)
    {
        result.notes.push_back(fmt::format(
            "radius {:.3g} m: if the file is in other units than metres, use --object-scale",
            result.object.radius));
    }
    return result;
}
}  // namespace bullet_ccd::tools
