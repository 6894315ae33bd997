// bullet_ccd_mesh_reader: reads one mesh file by assimp, for the library; see io/reader_process.h.
#include "bullet_ccd/io/mesh_reader/assimp_scene.h"
#include "bullet_ccd/io/mesh_reader/ply_header.h"
#include "bullet_ccd/io/soup_pipe.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <new>
#include <string>
#include <sys/resource.h>

namespace
{
using namespace bullet_ccd;

constexpr int kPipe = 3;

bool isPly(const std::string& name)
{
    std::string extension = std::filesystem::path(name).extension().string();
    std::transform(extension.begin(),
                   extension.end(),
                   extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".ply";
}

bool answer(const std::string& name, int seconds, int mebibytes)
{
    try
    {
        if (isPly(name))
        {
            requirePlausiblePly(name);
        }
        return sendSoup(kPipe, readScene(name, seconds, mebibytes));
    }
    catch (const std::bad_alloc&)
    {
        return sendComplaint(
            kPipe,
            name + ": reading needs more than " + std::to_string(mebibytes) +
                " MiB of memory and 64 per MiB of the file: export the mesh again, "
                "as OBJ if possible");
    }
    catch (const std::exception& error)
    {
        const std::string what = error.what();
        return sendComplaint(
            kPipe,
            what.rfind(name, 0) == 0 ? what : name + ": " + what + ": export the mesh again");
    }
}
}  // namespace

int main(int count, char** words)
{
    if (count != 4 || ::fcntl(kPipe, F_GETFD) < 0)
    {
        std::fprintf(stderr,
                     "bullet_ccd_mesh_reader FILE SECONDS MEBIBYTES: reads a mesh file for the "
                     "library bullet_ccd, which starts this program by itself and takes the mesh "
                     "from file descriptor %d.\n",
                     kPipe);
        return 2;
    }
    // A crash is expected: no core file.
    const rlimit none{0, 0};
    static_cast<void>(::setrlimit(RLIMIT_CORE, &none));
    try
    {
        return answer(words[1], std::stoi(words[2]), std::stoi(words[3])) ? 0 : 1;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "bullet_ccd_mesh_reader: %s\n", error.what());
        return 2;
    }
}
