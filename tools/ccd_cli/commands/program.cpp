#include "tools/ccd_cli/commands/program.h"

#include "tools/ccd_cli/commands/commands.h"
#include "tools/support/command_line.h"

namespace bullet_ccd::tools
{
namespace
{
constexpr const char* kBulletCcdFooter =
    "'bullet-ccd VERB --help' shows the options of a verb.\n"
    "\n"
    "Lengths and tolerances are in the unit of the meshes, and angles are in radians. A motion "
    "runs "
    "over the interval t = 0 to 1. Meshes are OBJ, STL, PLY, OFF, DAE, glTF or GLB files. "
    "docs/glossary.md defines tolerance, gap and minimum separation.\n"
    "\n"
    "Exit codes: 0 if everything was answered, 1 if a trajectory was not certified, 2 for wrong "
    "options, 3 for bad input, 130 after Ctrl-C, which keeps what was done.\n"
    "\n"
    "Examples:\n"
    "  bullet-ccd toi cube.obj plate.obj --a0 1,0,0,0,0,0,2 --a-velocity 0,0,-4\n"
    "  bullet-ccd batch bunny.ply bunny.ply queries.csv -o results.csv --summary\n"
    "  bullet-ccd articulated arm.urdf --from start.csv --to goal.csv \\\n"
    "      --obstacles table.stl --self\n"
    "  bullet-ccd certify arm.urdf --trajectory path.csv --obstacles scene.yaml";
}  // namespace

int runBulletCcd(int argc, char** argv)
{
    return runProgram(
        argc,
        argv,
        {.name = "bullet-ccd",
         .about =
             "Finds when moving meshes, robots and cloth touch (continuous collision detection).",
         .footer = kBulletCcdFooter},
        [](CLI::App& app, int& exitCode)
        {
            app.require_subcommand(1);
            addToiCommand(app, exitCode);
            addBatchCommand(app, exitCode);
            addArticulatedCommand(app, exitCode);
            addCertifyCommand(app, exitCode);
            addDeformableCommand(app, exitCode);
            addElementaryCommand(app, exitCode);
            addReduceCommand(app, exitCode);
            addAdviseCommand(app, exitCode);
            addManifestCommand(app, exitCode);
        });
}
}  // namespace bullet_ccd::tools
