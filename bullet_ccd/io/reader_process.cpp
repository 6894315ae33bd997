#include "bullet_ccd/io/reader_process.h"

#include "bullet_ccd/io/soup_pipe.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <optional>
#include <spawn.h>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace bullet_ccd
{
namespace
{
constexpr const char* kProgram = "bullet_ccd_mesh_reader";
constexpr const char* kVariable = "BULLET_CCD_MESH_READER";
constexpr const char* kWayOut = ", or convert the mesh to OBJ or OFF";

/// Where the code of this library is: in a shared library, or in the program.
std::vector<std::filesystem::path> homes()
{
    std::vector<std::filesystem::path> folders;
    std::error_code error;
    Dl_info info{};
    if (::dladdr(reinterpret_cast<const void*>(&homes), &info) != 0 && info.dli_fname != nullptr &&
        std::filesystem::path(info.dli_fname).is_absolute())
    {
        folders.push_back(std::filesystem::canonical(info.dli_fname, error).parent_path());
    }
    const std::filesystem::path program =
        std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    if (folders.empty() || folders[0] != program)
    {
        folders.push_back(program);
    }
    return folders;
}

std::filesystem::path findProgram(const std::string& name)
{
    std::error_code error;
    const auto isThere = [&](const std::filesystem::path& path)
    { return std::filesystem::is_regular_file(path, error); };
    if (const char* const wish = std::getenv(kVariable); wish != nullptr && *wish != '\0')
    {
        if (!isThere(wish))
        {
            throw std::runtime_error(name + ": no mesh reader at '" + wish +
                                     "': correct the environment variable " + kVariable + kWayOut);
        }
        return wish;
    }
    std::vector<std::filesystem::path> places;
    for (const std::filesystem::path& home : homes())
    {
        places.push_back(home / kProgram);
        places.push_back(home.parent_path() / BULLET_CCD_LIBEXEC / kProgram);
        places.push_back(home.parent_path().parent_path() / BULLET_CCD_LIBEXEC / kProgram);
    }
    places.emplace_back(BULLET_CCD_BUILT_READER);
    std::string tried;
    for (const std::filesystem::path& place : places)
    {
        if (isThere(place))
        {
            return place;
        }
        tried += "\n  " + place.string();
    }
    throw std::runtime_error(name + ": the program " + kProgram +
                             ", which reads this format, is not found: install bullet_ccd, copy "
                             "the program beside yours, name it in the environment variable " +
                             kVariable + kWayOut + "; looked for:" + tried);
}

/// Both ends of a pipe that no other child inherits.
class Pipe
{
public:
    explicit Pipe(const std::string& name)
    {
        if (::pipe2(m_ends.data(), O_CLOEXEC) != 0)
        {
            throw std::runtime_error(name + ": no pipe for the mesh reader (" +
                                     std::strerror(errno) + "): close some files");
        }
    }
    ~Pipe()
    {
        close(0);
        close(1);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    [[nodiscard]] int end(std::size_t i) const { return m_ends[i]; }
    void close(std::size_t i)
    {
        if (m_ends[i] >= 0)
        {
            ::close(m_ends[i]);
            m_ends[i] = -1;
        }
    }

private:
    std::array<int, 2> m_ends{-1, -1};
};

/// A process that does not outlive this object.
class Child
{
public:
    explicit Child(pid_t id) : m_id(id) {}
    ~Child()
    {
        if (m_id > 0)
        {
            ::kill(m_id, SIGKILL);
            static_cast<void>(wait());
        }
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// How it ended; nothing if the host waits for, or ignores, all its children.
    std::optional<int> wait()
    {
        int status = 0;
        pid_t ended = -1;
        do
        {
            ended = ::waitpid(m_id, &status, 0);
        } while (ended < 0 && errno == EINTR);
        m_id = -1;
        return ended > 0 ? std::optional<int>(status) : std::nullopt;
    }

private:
    pid_t m_id;
};

/// The program writes to file descriptor 3; what it prints is of no interest.
pid_t start(const std::string& program,
            const std::string& name,
            const ReaderLimits& limits,
            int pipe)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawnattr_init(&attributes);
    ::posix_spawn_file_actions_adddup2(&files, pipe, 3);
    ::posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
    ::posix_spawn_file_actions_addopen(&files, 2, "/dev/null", O_WRONLY, 0);
    // What the host does about signals is not the program's business.
    sigset_t signals;
    ::sigemptyset(&signals);
    ::posix_spawnattr_setsigmask(&attributes, &signals);
    ::sigfillset(&signals);
    ::posix_spawnattr_setsigdefault(&attributes, &signals);
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    std::string words[] = {
        program, name, std::to_string(limits.seconds), std::to_string(limits.mebibytes)};
    char* arguments[] = {
        words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
    pid_t child = -1;
    const int error =
        ::posix_spawn(&child, program.c_str(), &files, &attributes, arguments, environ);
    ::posix_spawnattr_destroy(&attributes);
    ::posix_spawn_file_actions_destroy(&files);
    if (error != 0)
    {
        throw std::runtime_error(name + ": the mesh reader " + program + " does not start (" +
                                 std::strerror(error) +
                                 "): check that it may be executed and that processes can be "
                                 "started" +
                                 kWayOut);
    }
    return child;
}

[[noreturn]] void failUnfinished(const std::string& program,
                                 const std::string& name,
                                 const ReaderLimits& limits,
                                 const std::optional<int>& status)
{
    constexpr int kNoLibrary = 127;  // of the dynamic linker
    if (status && WIFSIGNALED(*status) && WTERMSIG(*status) == SIGXCPU)
    {
        throw std::runtime_error(name + ": reading takes more than " +
                                 std::to_string(limits.seconds) +
                                 " s of processor time and 2 s per MiB: export the mesh again, as "
                                 "OBJ if possible");
    }
    if (status && WIFSIGNALED(*status) &&
        (WTERMSIG(*status) == SIGKILL || WTERMSIG(*status) == SIGTERM ||
         WTERMSIG(*status) == SIGINT))
    {
        throw std::runtime_error(name +
                                 ": the mesh reader was stopped from outside: read the file again "
                                 "with more memory free");
    }
    if (status && WIFEXITED(*status) && WEXITSTATUS(*status) == kNoLibrary)
    {
        throw std::runtime_error(name + ": the mesh reader " + program +
                                 " cannot run: start it by hand to see why" + kWayOut);
    }
    throw std::runtime_error(
        name +
        ": the file breaks the reader of its format: export the mesh again, as OBJ if possible");
}
}  // namespace

PolygonSoup readInProcess(const std::filesystem::path& path, const ReaderLimits& limits)
{
    const std::string name = path.string();
    const std::string program = findProgram(name).string();
    Pipe pipe(name);
    Child child(start(program, name, limits, pipe.end(1)));
    pipe.close(1);
    ReaderAnswer answer = receiveAnswer(pipe.end(0));
    // A reader that still writes ends by that.
    pipe.close(0);
    const std::optional<int> status = child.wait();
    if (!answer.isComplete)
    {
        failUnfinished(program, name, limits, status);
    }
    if (!answer.complaint.empty())
    {
        throw std::runtime_error(answer.complaint);
    }
    return std::move(answer.soup);
}
}  // namespace bullet_ccd
