#include "tools/grasp_cli/options/input_options.h"

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
    return loadNamedHand(pair.hand, pair.srdf);
}

LoadedObject loadObjectOf(const PairOptions& pair)
{
    return loadNamedObject(pair.object, pair.objectScale);
}

void addRecordOptions(CLI::App& command, RecordArguments& arguments)
{
    command.add_option("file", arguments.file, "grasps.jsonl that grasp plan wrote")
        ->type_name("FILE")
        ->required();
    command.add_option("--hand", arguments.hand, "where the hand is now, if it moved")
        ->type_name("HAND");
    command.add_option("--object", arguments.object, "where the object is now, if it moved")
        ->type_name("OBJECT");
}

void addChoiceOptions(CLI::App& command, RecordChoice& choice)
{
    command
        .add_option("--rank",
                    choice.ranks,
                    "only the grasp of that rank; may be repeated;\n"
                    "default: all force closures of the file")
        ->type_name("N");
    command
        .add_option("--candidate",
                    choice.candidates,
                    "only the grasp of that candidate number; may be repeated")
        ->type_name("N");
}
}  // namespace bullet_ccd::tools
