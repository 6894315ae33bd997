/// Options by which verbs are given a hand and an object, or grasps of them.
#pragma once

#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/grasp_cli/inputs/grasp_records.h"
#include "tools/support/option_values.h"

#include <CLI/CLI.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace bullet_ccd::tools
{
/// --hand, --object and --object-scale. `Names` is a text, or a list of texts for a verb that takes
/// several of each.
template <typename Names>
void addInputOptions(CLI::App& command, Names& hand, Names& object, double& objectScale)
{
    const std::string more = std::is_same_v<Names, std::string> ? "" : " It may be repeated.";
    command
        .add_option(
            "--hand", hand, "A URDF, xacro or MJCF file, or the name of a hand that ships." + more)
        ->type_name("HAND")
        ->required()
        ->group("Input");
    command
        .add_option("--object", object, "A mesh file, or the name of an object that ships." + more)
        ->type_name("OBJECT")
        ->required()
        ->group("Input");
    command
        .add_option(
            "--object-scale", objectScale, "How many metres one unit of the object's mesh is.")
        ->type_name("S")
        ->check(within(1e-9, 1e9))
        ->capture_default_str()
        ->group("Input");
}

/// One hand, perhaps with an SRDF of the user's, and one object.
struct PairOptions
{
    std::string hand;
    std::string object;
    std::string srdf;
    double objectScale = 1.0;
};
/// addInputOptions() and --srdf.
void addPairOptions(CLI::App& command, PairOptions& pair);

/// --scene: obstacles.
void addSceneOption(CLI::App& command, std::vector<std::string>& files);

/// Throw as loadNamedHand() and loadNamedObject() do.
[[nodiscard]] LoadedHand loadHandOf(const PairOptions& pair);
[[nodiscard]] LoadedObject loadObjectOf(const PairOptions& pair);

/// FILE, --hand and --object.
void addRecordOptions(CLI::App& command, RecordArguments& arguments);
/// --rank and --candidate.
void addChoiceOptions(CLI::App& command, RecordChoice& choice);
}  // namespace bullet_ccd::tools
