#include "tools/grasp_cli/commands.h"
#include "tools/grasp_cli/config_option.h"

#include <cstdio>
#include <exception>
#include <fmt/format.h>

namespace
{
constexpr const char* kFooter =
    "Lengths are metres, angles radians. --hand and --object take a path or the name of a robot "
    "or\n"
    "object that ships; what ships is found beside the program or in $BULLET_CCD_SHARE.\n"
    "docs/glossary.md defines tolerance, gap, margin, friction, mass and effort.\n"
    "\n"
    "Exit codes: 0 ok, 1 nothing found (check: a grasp failed; table: a criterion failed; force: "
    "no\n"
    "grasp can hold the load; close: nothing touched), 2 usage, 3 bad input.\n"
    "\n"
    "Examples:\n"
    "  grasp plan --hand anthropomorphic_hand --object mug -n 20 -o out/\n"
    "  grasp close --hand parallel_gripper --object box.obj --pose 0 0 -0.13 1 0 0 0\n"
    "  grasp plan --config plan.yaml --seed 2   # options from a file; --print-config writes one\n"
    "  grasp check out/grasps.jsonl\n"
    "  grasp force out/grasps.jsonl --mass 0.4 --effort 5 --objective firm\n"
    "  grasp quality out/grasps.jsonl --model soft --friction 0.8\n"
    "  grasp hand my_hand.urdf";

int run(int argc, char** argv)
{
    using namespace bullet_ccd::tools;
    int exitCode = kFound;
    CLI::App app("Plans grasps: approach, close until first contact, score, rank.", "grasp");
    app.set_version_flag("--version", "grasp " BULLET_CCD_VERSION);
    app.require_subcommand(1);
    app.footer(kFooter);
    app.get_formatter()->column_width(34);
    addPlanCommand(app, exitCode);
    addCloseCommand(app, exitCode);
    addCheckCommand(app, exitCode);
    addForceCommand(app, exitCode);
    addHandCommand(app, exitCode);
    addQualityCommand(app, exitCode);
    addTableCommand(app, exitCode);
    addBenchCommand(app, exitCode);
    for (CLI::App* verb : app.get_subcommands([](CLI::App*) { return true; }))
    {
        addConfigOptions(*verb);
    }
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? kFound : kUsage;
    }
    return exitCode;
}
}  // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        fmt::print(stderr, "grasp: {}\n", error.what());
        return bullet_ccd::tools::kBadInput;
    }
}
