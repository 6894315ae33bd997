#include "bullet_ccd/io/robot/robot_format.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace bullet_ccd
{
namespace
{
/// The name of the first element, and where it begins; declarations and comments are skipped.
std::pair<std::string_view, std::size_t> firstElement(std::string_view text)
{
    std::size_t at = text.find('<');
    while (at != std::string_view::npos && at + 1 < text.size())
    {
        const bool comment = text.substr(at, 4) == "<!--";
        if (text[at + 1] != '?' && text[at + 1] != '!')
        {
            const std::size_t end = text.find_first_of(" \t\r\n/>", at);
            return {text.substr(at + 1, end == std::string_view::npos ? end : end - at - 1), at};
        }
        const std::size_t end = text.find(comment ? "-->" : ">", at);
        at = end == std::string_view::npos ? end : text.find('<', end);
    }
    return {{}, text.size()};
}

/// Whether elements or attributes, not comments or text, are xacro's. What xacro writes keeps the
/// declaration of the namespace, so that alone says nothing.
bool speaksXacro(std::string_view text)
{
    const bool isDeclared = text.find("xmlns:xacro") != std::string_view::npos;
    while ((text = text.substr(std::min(text.find('<'), text.size()))).size() > 1)
    {
        const std::string_view closing = text.starts_with("<!--")        ? "-->"
                                         : text.starts_with("<![CDATA[") ? "]]>"
                                                                         : ">";
        const std::string_view tag = text.substr(0, text.find(closing));
        if (text.starts_with("<xacro:") ||
            (text[1] != '!' && isDeclared && tag.find("${") != std::string_view::npos))
        {
            return true;
        }
        text.remove_prefix(tag.size());
    }
    return false;
}

bool isOnPath(const std::string& program)
{
    const char* const variable = std::getenv("PATH");
    std::string_view entries = variable == nullptr ? "" : variable;
    while (!entries.empty())
    {
        const std::size_t end = std::min(entries.find(':'), entries.size());
        const std::filesystem::path file = std::filesystem::path(entries.substr(0, end)) / program;
        entries.remove_prefix(std::min(end + 1, entries.size()));
        std::error_code error;
        if (::access(file.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(file, error))
        {
            return true;
        }
    }
    return false;
}

/// For a shell: the text as one word.
std::string shellWord(const std::string& text)
{
    std::string word = "'";
    for (const char c : text)
    {
        word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    return word + "'";
}
}  // namespace

RobotFormat robotFormat(std::string_view text)
{
    const auto [name, begin] = firstElement(text);
    if (name == "mujoco")
    {
        return RobotFormat::Mjcf;
    }
    if (name == "sdf")
    {
        return RobotFormat::Sdf;
    }
    return name == "robot" && speaksXacro(text.substr(begin)) ? RobotFormat::Xacro
                                                              : RobotFormat::Urdf;
}

void requireUrdf(std::string_view text, const std::filesystem::path& path)
{
    const std::string file = path.string();
    switch (robotFormat(text))
    {
        case RobotFormat::Mjcf:
            throw std::runtime_error(file +
                                     ": this is MJCF, and a URDF is expected: read it by "
                                     "loadRobot() or loadMjcf()");
        case RobotFormat::Xacro:
            throw std::runtime_error(file + ": this is xacro, and a URDF is expected: run xacro " +
                                     shellWord(file) + " > robot.urdf");
        case RobotFormat::Sdf:
            throw std::runtime_error(file +
                                     ": this is SDF, which is not read: give the URDF or MJCF of "
                                     "the robot");
        case RobotFormat::Urdf:
            break;
    }
}

std::string expandXacro(const std::filesystem::path& path)
{
    const std::string file = std::filesystem::absolute(path).string();
    const std::string command = "xacro " + shellWord(file);
    if (!isOnPath("xacro"))
    {
        throw std::runtime_error(path.string() +
                                 ": this is xacro, and the program xacro is not on the PATH: "
                                 "where it is, run " +
                                 command + " > robot.urdf and give robot.urdf");
    }
    std::FILE* const output = ::popen(command.c_str(), "r");
    std::string text;
    std::array<char, 65536> buffer{};
    for (std::size_t count = 0;
         output != nullptr && (count = std::fread(buffer.data(), 1, buffer.size(), output)) > 0;)
    {
        text.append(buffer.data(), count);
    }
    const int status = output == nullptr ? -1 : ::pclose(output);
    if (status != 0)
    {
        throw std::runtime_error(path.string() + ": xacro does not expand it: run " + command +
                                 " > robot.urdf to see why, and give robot.urdf");
    }
    return text;
}
}  // namespace bullet_ccd
