// The formats that a process of its own reads: what may go wrong with it, and that nothing goes
// wrong with large files and many readers.
#include "bullet_ccd/io/reader_process.h"

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/io/mesh_texts.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <gmock/gmock.h>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace bullet_ccd
{
namespace
{
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using tests::TempFolder;

/// Lets the library start another program as its mesh reader.
class OtherReader
{
public:
    explicit OtherReader(const std::string& program)
    {
        ::setenv("BULLET_CCD_MESH_READER", program.c_str(), 1);
    }
    ~OtherReader() { ::unsetenv("BULLET_CCD_MESH_READER"); }
    OtherReader(const OtherReader&) = delete;
    OtherReader& operator=(const OtherReader&) = delete;
};

/// Message of the exception that reading throws, or "" if it throws none.
std::string readError(const std::filesystem::path& path, const ReaderLimits& limits = {})
{
    try
    {
        static_cast<void>(readInProcess(path, limits));
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return "";
}

std::filesystem::path writeScript(const TempFolder& folder, const std::string& lines)
{
    const std::filesystem::path script = folder.write("reader", "#!/bin/sh\n" + lines);
    std::filesystem::permissions(script, std::filesystem::perms::owner_all);
    return script;
}

/// Message that reading gives if this script is the reader.
std::string errorOfScript(const std::string& lines)
{
    const TempFolder folder;
    const std::filesystem::path mesh = folder.write("a.stl", tests::tetraStlText());
    const OtherReader reader(writeScript(folder, lines).string());
    const std::string error = readError(mesh);
    EXPECT_THAT(error, StartsWith(mesh.string() + ": "));
    return error;
}

/// A node that refers to the next one twice, `depth` times over: 2^depth nodes in a small file.
std::string bomb(int depth)
{
    std::string dae = tests::tetraDae();
    std::string nodes = "<library_nodes>";
    for (int i = 0; i < depth; ++i)
    {
        const std::string next = "<instance_node url=\"#n" + std::to_string(i + 1) + "\"/>";
        nodes += "<node id=\"n" + std::to_string(i) + "\">" + next + next + "</node>";
    }
    nodes += "<node id=\"n" + std::to_string(depth) + "\"/></library_nodes>";
    const std::string scenes = "<library_visual_scenes>";
    dae.insert(dae.find(scenes), nodes);
    const std::string geometry = "<instance_geometry url=\"#g\"/>";
    return dae.insert(dae.find(geometry), "<instance_node url=\"#n0\"/>");
}

TEST(ReaderProcess, ALargeFileIsReadWhole)
{
    const TempFolder folder;
    const TriangleMesh sphere = makeSphere(1.0, 7);
    const MeshFile file = loadMeshFile(folder.write("sphere.stl", tests::stlBinary(sphere)));
    EXPECT_EQ(file.mesh.triangles.size(), sphere.triangles.size());
    EXPECT_EQ(file.mesh.vertices.size(), sphere.vertices.size());
    EXPECT_NEAR(massProperties(file.mesh).volume, massProperties(sphere).volume, 1e-6);
}

TEST(ReaderProcess, ManyThreadsReadAtATime)
{
    constexpr int kThreads = 12;
    const TempFolder folder;
    const TriangleMesh sphere = makeSphere(1.0, 5);
    const std::filesystem::path path = folder.write("sphere.stl", tests::stlBinary(sphere));
    std::atomic<int> right = 0;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < kThreads; ++i)
        {
            threads.emplace_back(
                [&]
                {
                    for (int round = 0; round < 3; ++round)
                    {
                        const MeshFile file = loadMeshFile(path);
                        right += file.mesh.triangles.size() == sphere.triangles.size() ? 1 : 0;
                    }
                });
        }
    }
    EXPECT_EQ(right, 3 * kThreads);
}

TEST(ReaderProcess, FilesThatAFileRefersToCountAsItsSize)
{
    // 4 MiB of numbers in a file beside it: more than 8 MiB are needed to read it.
    const TempFolder folder;
    std::string json = tests::tetraGltfJson("\"uri\":\"a.bin\",");
    const std::string length = "\"byteLength\":72";
    json.replace(json.find(length), length.size(), "\"byteLength\":4194304");
    std::string buffer = tests::tetraBuffer();
    buffer.resize(4194304);
    folder.write("a.bin", buffer);
    const PolygonSoup soup = readInProcess(folder.write("a.gltf", json), {.mebibytes = 8});
    EXPECT_EQ(soup.polygonEnds.size(), 4U);
}

TEST(ReaderProcess, AFileThatTakesForEverIsStoppedByProcessorTime)
{
    const TempFolder folder;
    const std::filesystem::path path = folder.write("bomb.dae", bomb(60));
    EXPECT_THAT(readError(path, {.seconds = 1, .mebibytes = 1 << 20}),
                AllOf(StartsWith(path.string()),
                      HasSubstr("takes more than 1 s of processor time and 2 s per MiB")));
}

TEST(ReaderProcess, AFileThatNeedsTooMuchMemoryIsRefused)
{
    const TempFolder folder;
    const std::filesystem::path path = folder.write("bomb.dae", bomb(60));
    EXPECT_THAT(readError(path, {.seconds = 100, .mebibytes = 64}),
                AllOf(StartsWith(path.string()), HasSubstr("needs more than 64 MiB of memory")));
    // The same file, had it fewer nodes.
    EXPECT_EQ(readInProcess(folder.write("small.dae", bomb(6))).polygonEnds.size(), 4U);
}

TEST(ReaderProcess, AReaderThatIsNotThereIsNamedWithTheRemedy)
{
    const TempFolder folder;
    const OtherReader reader("/no/such/reader");
    EXPECT_THAT(readError(folder.write("a.stl", tests::tetraStlText())),
                AllOf(HasSubstr("no mesh reader at '/no/such/reader'"),
                      HasSubstr("BULLET_CCD_MESH_READER"),
                      HasSubstr("convert the mesh to OBJ or OFF")));
    EXPECT_EQ(loadMeshFile(folder.write("a.obj", tests::tetraObj())).mesh.triangles.size(), 4U);
    EXPECT_EQ(loadMeshFile(folder.write("a.off", tests::tetraOff())).mesh.triangles.size(), 4U);
}

TEST(ReaderProcess, AReaderThatCannotBeStartedIsNamed)
{
    const TempFolder folder;
    const OtherReader reader(folder.write("reader", "#!/bin/sh\n").string());
    EXPECT_THAT(
        readError(folder.write("a.stl", tests::tetraStlText())),
        AllOf(HasSubstr("the mesh reader " + folder.path().string() + "/reader does not start"),
              HasSubstr("may be executed")));
    EXPECT_THAT(errorOfScript("exit 127\n"), HasSubstr("cannot run: start it by hand"));
}

TEST(ReaderProcess, AReaderThatIsKilledOrCrashesIsAnError)
{
    EXPECT_THAT(errorOfScript("kill -KILL $$\n"), HasSubstr("was stopped from outside"));
    EXPECT_THAT(errorOfScript("kill -SEGV $$\n"), HasSubstr("breaks the reader"));
    EXPECT_THAT(errorOfScript("exit 0\n"), HasSubstr("breaks the reader"));
    EXPECT_THAT(errorOfScript("ulimit -S -t 1\nwhile :; do :; done\n"),
                HasSubstr("s of processor time"));
}

TEST(ReaderProcess, RubbishFromTheReaderIsAnError)
{
    // Nothing; half a number; an array that no memory holds; no known kind of answer.
    for (const char* const bytes :
         {"", "s\\003\\000", "s\\377\\377\\377\\377\\377\\377\\377\\177", "x"})
    {
        SCOPED_TRACE(bytes);
        EXPECT_THAT(errorOfScript("printf '" + std::string(bytes) + "' >&3\n"),
                    HasSubstr("breaks the reader"));
    }
    // No vertices, no corners, but a polygon that ends at the third.
    const std::string zero = "\\000\\000\\000\\000\\000\\000\\000\\000";
    const std::string one = "\\001" + zero.substr(4);
    const std::string three = "\\003" + zero.substr(4);
    EXPECT_THAT(errorOfScript("printf 's" + zero + zero + one + three + zero + "' >&3\n"),
                HasSubstr("breaks the reader"));
}

TEST(ReaderProcess, WhatTheReaderPrintsIsNotTakenForTheMesh)
{
    const TempFolder folder;
    const OtherReader reader(
        writeScript(
            folder,
            "echo s; echo s >&2; printf 'c\\002\\000\\000\\000\\000\\000\\000\\000No' >&3\n")
            .string());
    EXPECT_EQ(readError(folder.write("a.stl", tests::tetraStlText())), "No");
}

TEST(ReaderProcess, SignalsOfTheHostDoNotMatter)
{
    const TempFolder folder;
    const std::filesystem::path path = folder.write("a.stl", tests::tetraStlText());
    // A host that ignores its children learns that reading failed, if not why.
    auto* const children = std::signal(SIGCHLD, SIG_IGN);
    EXPECT_EQ(readInProcess(path).polygonEnds.size(), 4U);
    EXPECT_THAT(errorOfScript("kill -KILL $$\n"), HasSubstr("breaks the reader"));
    std::signal(SIGCHLD, children);
    // One that ignores and blocks the signal of the time limit does not switch it off.
    auto* const time = std::signal(SIGXCPU, SIG_IGN);
    sigset_t blocked;
    ::sigemptyset(&blocked);
    ::sigaddset(&blocked, SIGXCPU);
    ::sigprocmask(SIG_BLOCK, &blocked, nullptr);
    EXPECT_THAT(readError(folder.write("bomb.dae", bomb(60)), {.seconds = 1, .mebibytes = 1 << 20}),
                HasSubstr("processor time"));
    ::sigprocmask(SIG_UNBLOCK, &blocked, nullptr);
    std::signal(SIGXCPU, time);
}
}  // namespace
}  // namespace bullet_ccd
