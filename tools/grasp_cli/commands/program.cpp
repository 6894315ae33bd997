#include "tools/grasp_cli/commands/program.h"

#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/options/config_option.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
constexpr const char* kGraspFooter =
    "'grasp VERB --help' shows the options of a verb.\n"
    "\n"
    "Lengths are in metres and angles in radians. A hand or an object is given by a file or by the "
    "name of one that ships. What ships is found beside the program or in $BULLET_CCD_SHARE. What "
    "is inferred of a hand without an SRDF is kept in $BULLET_CCD_CACHE, else in bullet_ccd in the "
    "user's cache folder. "
    "docs/glossary.md defines tolerance, gap, margin, friction, mass and effort.\n"
    "\n"
    "Exit codes: 0 if something was found or everything holds, 1 if not, 2 for wrong options, 3 "
    "for bad "
    "input, 130 after Ctrl-C, which keeps what was done. The help of a verb says what it looks "
    "for.\n"
    "\n"
    "Examples:\n"
    "  grasp plan --hand anthropomorphic_hand --object mug -n 20 -o out\n"
    "  grasp close --hand parallel_gripper --object box.obj --pose 0 0 -0.13 1 0 0 0\n"
    "  grasp check out/grasps.jsonl\n"
    "  grasp export out/grasps.jsonl --rank 1 -o mjcf\n"
    "  grasp force out/grasps.jsonl --mass 0.4 --effort 5 --objective firm\n"
    "  grasp quality out/grasps.jsonl --model soft --friction 0.8\n"
    "  grasp hand my_hand.urdf";

/// Also of the commands below it.
void addCacheOption(CLI::App& command)
{
    for (CLI::App* below : command.get_subcommands([](CLI::App*) { return true; }))
    {
        addCacheOption(*below);
    }
    command
        .add_flag_callback(
            "--no-cache",
            [] { setenv("BULLET_CCD_CACHE", "", 1); },
            "Infer anew what is kept of hands without an SRDF, and keep nothing.")
        ->group("Configuration");
}

void addVerbs(CLI::App& app, int& exitCode)
{
    app.require_subcommand(1);
    addPlanCommand(app, exitCode);
    addCloseCommand(app, exitCode);
    addCheckCommand(app, exitCode);
    addExportCommand(app, exitCode);
    addForceCommand(app, exitCode);
    addHandCommand(app, exitCode);
    addQualityCommand(app, exitCode);
    addTaskCommand(app, exitCode);
    addTrialCommand(app, exitCode);
    for (CLI::App* verb : app.get_subcommands([](CLI::App*) { return true; }))
    {
        addCacheOption(*verb);
        addConfigOptions(*verb);
    }
}

/// The verbs `bench` and `table` are a program of their own since 0.2; for one more release they
/// run it, with the arguments behind them. Returns if they cannot.
int runMoved(int argc, char** argv)
{
    const bool isTable = std::string_view(argv[1]) == "table";
    std::error_code error;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::string program = (self.parent_path() / "bench_grasps").string();
    fmt::print(stderr, "grasp: {} is a verb of the program bench_grasps now\n", argv[1]);
    std::vector<char*> arguments(argv + (isTable ? 1 : 2), argv + argc);
    arguments.insert(arguments.begin(), const_cast<char*>(program.c_str()));
    arguments.push_back(nullptr);
    execv(program.c_str(), arguments.data());
    fmt::print(stderr,
               "grasp: {}: cannot be run: build it with cmake --build build/release --target "
               "bench_grasps\n",
               program);
    return kUsage;
}
}  // namespace

int runGrasp(int argc, char** argv)
{
    if (argc > 1 && (argv[1] == std::string_view("bench") || argv[1] == std::string_view("table")))
    {
        return runMoved(argc, argv);
    }
    return runProgram(argc,
                      argv,
                      {.name = "grasp",
                       .about = "Plans grasps: a hand approaches an object and closes until its "
                                "first contacts; the grasps "
                                "are scored and ranked.",
                       .footer = kGraspFooter},
                      addVerbs);
}
}  // namespace bullet_ccd::tools
