#include "tools/ccd_cli/commands.h"

#include <cstdio>
#include <exception>
#include <fmt/format.h>

namespace
{
constexpr const char* kFooter =
    "Lengths, tolerances too, are in the unit of the meshes; angles are rad; the motion runs over\n"
    "the interval t = 0 to 1. Meshes: OBJ, STL, PLY, OFF, DAE, glTF, GLB.\n"
    "docs/glossary.md defines tolerance, gap and minimum separation.\n"
    "\n"
    "Exit codes: 0 answered, 2 usage, 3 bad input.\n"
    "\n"
    "Examples:\n"
    "  bullet-ccd toi cube.obj plate.obj --a0 1,0,0,0,0,0,2 --a-velocity 0,0,-4\n"
    "  bullet-ccd batch bunny.ply bunny.ply queries.csv -o results.csv --summary\n"
    "  bullet-ccd articulated arm.urdf --from start.csv --to goal.csv --obstacles table.stl --self";

int run(int argc, char** argv)
{
    using namespace bullet_ccd::tools;
    CLI::App app("Continuous collision detection: when do moving meshes and robots first touch?",
                 "bullet-ccd");
    app.set_version_flag("--version", "bullet-ccd " BULLET_CCD_VERSION);
    app.require_subcommand(1);
    app.footer(kFooter);
    app.get_formatter()->column_width(34);
    addToiCommand(app);
    addBatchCommand(app);
    addArticulatedCommand(app);
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? kAnswered : kUsage;
    }
    return kAnswered;
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
        fmt::print(stderr, "bullet-ccd: {}\n", error.what());
        return bullet_ccd::tools::kBadInput;
    }
}
