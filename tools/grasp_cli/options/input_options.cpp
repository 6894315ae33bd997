#include "tools/grasp_cli/options/input_options.h"

namespace bullet_ccd::tools
{
void addPairOptions(CLI::App& command, PairOptions& pair)
{
    addInputOptions(command, pair.hand, pair.object, pair.objectScale);
    command
        .add_option("--srdf",
                    pair.srdf,
                    "Where fingers and preshapes are read from. Default: the SRDF beside the URDF, "
                    "else the "
                    "one that ships for a robot of that name; else they are inferred.")
        ->type_name("FILE")
        ->group("Input");
}

void addSceneOption(CLI::App& command, std::vector<std::string>& files)
{
    command
        .add_option(
            "--scene",
            files,
            "Obstacles in the frame of the object: meshes, or scenes (.csv, .yaml) of meshes with "
            "poses. A grasp that touches one is rejected.")
        ->type_name("FILE...")
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
    command
        .add_option("file", arguments.file, "The file grasps.jsonl that grasp plan or close wrote.")
        ->type_name("FILE")
        ->required();
    command.add_option("--hand", arguments.hand, "Where the hand is now, if it has moved since.")
        ->type_name("HAND")
        ->group("Input");
    command
        .add_option("--object", arguments.object, "Where the object is now, if it has moved since.")
        ->type_name("OBJECT")
        ->group("Input");
}

void addChoiceOptions(CLI::App& command, RecordChoice& choice)
{
    command
        .add_option(
            "--rank",
            choice.ranks,
            "Take only the grasp of this rank. It may be repeated. Default: all force closures of "
            "the file.")
        ->type_name("N")
        ->check(within(1, 1'000'000'000))
        ->group("Input");
    command
        .add_option("--candidate",
                    choice.candidates,
                    "Take only the grasp of this candidate number. It may be repeated.")
        ->type_name("N")
        ->check(within(std::int64_t{0}, std::int64_t{1'000'000'000}))
        ->group("Input");
}
}  // namespace bullet_ccd::tools
