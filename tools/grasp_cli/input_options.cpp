#include "tools/grasp_cli/input_options.h"

namespace bullet_ccd::tools
{
void addPairOptions(CLI::App& command, PairOptions& pair)
{
    addInputOptions(command, pair.hand, pair.object, pair.objectScale);
    command
        .add_option("--srdf",
                    pair.srdf,
                    "fingers and preshapes; default: the one beside the URDF,\n"
                    "else a shipped one for the robot's name, else inferred")
        ->type_name("FILE")
        ->group("Input");
}

LoadedHand loadHandOf(const PairOptions& pair)
{
    return loadNamedHand(
        pair.hand,
        pair.srdf.empty() ? std::nullopt : std::optional<std::filesystem::path>(pair.srdf));
}

LoadedObject loadObjectOf(const PairOptions& pair)
{
    return loadNamedObject(pair.object, pair.objectScale);
}
}  // namespace bullet_ccd::tools
