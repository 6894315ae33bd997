#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/approach/approach_sampler.h"
#include "grasp/closing/closing.h"
#include "grasp/force/grasp_forces.h"
#include "grasp/hand/hand_model.h"
#include "grasp/hand/srdf_writer.h"
#include "grasp/planner/grasp_planner.h"
#include "grasp/report/grasp_picture.h"
#include "grasp/report/viewer_page.h"
#include "grasp/squeeze/squeeze.h"
#include "tools/grasp_cli/commands/commands.h"
#include "tools/grasp_cli/inputs/catalogue.h"
#include "tools/support/text_file.h"
#include "tools/support/text_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using grasp::HandModel;

struct HandArguments
{
    std::string hand;
    std::string srdf;
    std::string output;
};

std::string fingerOf(const HandModel& hand, std::int32_t link)
{
    for (const grasp::Finger& finger : hand.fingers)
    {
        if (std::find(finger.links.begin(), finger.links.end(), link) != finger.links.end())
        {
            return finger.name;
        }
    }
    return "-";
}

std::string closingText(const HandModel& hand, std::size_t link)
{
    const Joint& joint = hand.robot.tree.links[link].joint;
    if (joint.mimicOf != kNone)
    {
        const Link& driver = hand.robot.tree.links[static_cast<std::size_t>(joint.mimicOf)];
        return fmt::format("follows {} x {:g}", driver.joint.name, joint.mimicMultiplier);
    }
    const std::string speed = hand.closingSpeeds.empty() || hand.closingSpeeds[link] == 1.0
                                  ? ""
                                  : fmt::format(", speed {:g}", hand.closingSpeeds[link]);
    switch (hand.closingDirections[link])
    {
        case 1:
            return "closes to its upper limit" + speed;
        case -1:
            return "closes to its lower limit" + speed;
        default:
            return "keeps its preshape";
    }
}

/// The most that the motor of a joint presses by; with a star if the robot states none that it has.
std::string effortText(const grasp::JointEffort& effort)
{
    return fmt::format("{:.3g}{}", effort.limit, effort.isAssumed ? "*" : "");
}

TextTable jointTable(const HandModel& hand)
{
    TextTable table{
        .header =
            {"joint", "link", "finger", "type", "lower", "upper", "states", "presses", "closing"},
        .rows = {}};
    const std::vector<std::int32_t> motors = grasp::independentJoints(hand.robot.tree);
    const std::vector<grasp::JointEffort> efforts = grasp::jointEfforts(hand);
    for (const grasp::Preshape& preshape : hand.preshapes)
    {
        table.header.push_back(preshape.name);
    }
    for (std::size_t link = 1; link < hand.robot.tree.size(); ++link)
    {
        const Link& itsLink = hand.robot.tree.links[link];
        if (!itsLink.joint.isMovable())
        {
            continue;
        }
        const auto motor = std::ranges::find(motors, static_cast<std::int32_t>(link));
        table.rows.push_back(
            {itsLink.joint.name,
             itsLink.name,
             fingerOf(hand, static_cast<std::int32_t>(link)),
             itsLink.joint.type == JointType::Revolute ? "turns" : "slides",
             fmt::format("{:.3f}", itsLink.joint.lower),
             fmt::format("{:.3f}", itsLink.joint.upper),
             std::isfinite(itsLink.joint.maxEffort) ? fmt::format("{:g}", itsLink.joint.maxEffort)
                                                    : "none",
             motor == motors.end()
                 ? "-"
                 : effortText(
                       efforts[static_cast<std::size_t>(std::distance(motors.begin(), motor))]),
             closingText(hand, link)});
        for (const grasp::Preshape& preshape : hand.preshapes)
        {
            table.rows.back().push_back(fmt::format("{:.3f}", preshape.positions[link]));
        }
    }
    return table;
}

/// Pairs of links with geometry that are not tested against each other.
std::vector<std::string> disabledPairs(const HandModel& hand)
{
    std::vector<std::string> texts;
    const auto count = static_cast<std::int32_t>(hand.robot.tree.size());
    for (std::int32_t a = 0; a < count; ++a)
    {
        for (std::int32_t b = a + 1; b < count; ++b)
        {
            const bool both = hand.linkTrees[static_cast<std::size_t>(a)] != nullptr &&
                              hand.linkTrees[static_cast<std::size_t>(b)] != nullptr;
            const bool tested =
                std::find(hand.selfPairs.begin(), hand.selfPairs.end(), std::pair(a, b)) !=
                hand.selfPairs.end();
            if (both && !tested)
            {
                texts.push_back(fmt::format("{} - {}", linkName(hand, a), linkName(hand, b)));
            }
        }
    }
    return texts;
}

void printFingers(const HandModel& hand)
{
    fmt::print("{} finger{} on {}\n",
               hand.fingers.size(),
               hand.fingers.size() == 1 ? "" : "s",
               linkName(hand, hand.palm));
    for (const grasp::Finger& finger : hand.fingers)
    {
        std::vector<std::string> names;
        for (const std::int32_t link : finger.links)
        {
            names.push_back(linkName(hand, link));
        }
        fmt::print("  {}: {}\n", finger.name, joined(names, " > "));
    }
}

/// What reading the robot and then understanding it as a hand had to assume.
void printNotes(const HandModel& hand)
{
    const bool none = hand.robot.notes.empty() && hand.notes.empty();
    fmt::print("\n{}\n", none ? "nothing was inferred" : "notes:");
    for (const auto* notes : {&hand.robot.notes, &hand.notes})
    {
        for (const std::string& note : *notes)
        {
            fmt::print("  {}\n", note);
        }
    }
}

/// @param isOne the frame is that of all preshapes
void printGraspFrame(const HandModel& hand, const grasp::Preshape& preshape, bool isOne)
{
    const Eigen::Isometry3d& X_RG = grasp::graspFrame(hand, preshape);
    const auto text = [](const Eigen::Vector3d& v, int digits) {
        return fmt::format(
            "({:.{}f}, {:.{}f}, {:.{}f})", v.x(), digits, v.y(), digits, v.z(), digits);
    };
    fmt::print("grasp frame{} in {}: origin {} m, approaches along {}, opposes along {}\n",
               isOne ? "" : fmt::format(" of '{}'", preshape.name),
               linkName(hand, 0),
               text(X_RG.translation(), 4),
               text(X_RG.linear().col(2), 3),
               text(X_RG.linear().col(0), 3));
}

/// How far the fingers are apart in each preshape.
std::string openingsText(const HandModel& hand)
{
    std::vector<std::string> texts;
    for (const grasp::Preshape& preshape : hand.preshapes)
    {
        texts.push_back(
            fmt::format("{} {:.0f} mm", preshape.name, 1e3 * openHand(hand, preshape).opening));
    }
    return joined(texts, ", ");
}

/// One picture a preshape, named after it.
void drawPreshapes(const HandModel& hand, const fs::path& folder)
{
    fmt::print("\n");
    for (const grasp::Preshape& preshape : hand.preshapes)
    {
        std::string name = preshape.name;
        std::ranges::replace_if(
            name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
        const fs::path file = folder / (name + ".png");
        grasp::drawPreshape(hand, preshape, {.width = 1600, .height = 480}, file);
        fmt::print("wrote {}: preshape '{}' from four sides\n", file.string(), preshape.name);
    }
}

/// Every preshape comes at a small ball where its fingers meet, and closes on it.
void writePreshapePage(const LoadedHand& loaded, const fs::path& viewer, const fs::path& file)
{
    constexpr double kRadius = 0.01;  // [m]
    constexpr double kWay = 0.1;      // [m]
    const HandModel& hand = loaded.hand;
    const grasp::GraspObject ball =
        grasp::makeGraspObject("a ball where the fingers meet", makeSphere(kRadius, 3));
    std::vector<grasp::Grasp> grasps;
    for (const grasp::Preshape& preshape : hand.preshapes)
    {
        const Eigen::Vector3d way = kWay * Eigen::Vector3d::UnitZ();
        const Eigen::Isometry3d X_WStart =
            Eigen::Translation3d(-way) * grasp::graspFrame(hand, preshape).inverse();
        grasps.push_back(
            grasp::closeAtPose(hand, ball, X_WStart, way, preshape, {}, grasp::kinematicClosing()));
        grasps.back().candidate = static_cast<std::int64_t>(grasps.size()) - 1;
    }
    grasp::GraspRun run{
        .handFile = loaded.file, .srdfFile = hand.srdfFile, .objectFile = {}, .options = {}};
    run.options.candidates = static_cast<std::int64_t>(grasps.size());
    grasp::writeViewerPage(run, hand, ball, grasps, {}, viewer, file);
    fmt::print(
        "wrote {}: every preshape closes on a ball of {:g} mm\n", file.string(), 2000.0 * kRadius);
}

/// Throws std::runtime_error if there can be none.
void makeFolder(const fs::path& folder)
{
    std::error_code error;
    fs::create_directories(folder, error);
    if (error || !fs::is_directory(folder))
    {
        throw std::runtime_error(
            fmt::format("{}: no folder can be made there ({}): name another one with --output",
                        folder.string(),
                        error ? error.message() : "it is a file"));
    }
}

int show(const HandArguments& arguments)
{
    const LoadedHand loaded = loadNamedHand(arguments.hand, arguments.srdf);
    if (!arguments.output.empty())
    {
        makeFolder(arguments.output);
    }
    const HandModel& hand = loaded.hand;
    std::size_t triangles = 0;
    for (const SsvTree& tree : hand.trees)
    {
        triangles += tree.mesh().triangles.size();
    }
    fmt::print(
        "{} ({})\nfingers and preshapes from {}\n{} links, {} with geometry, {} triangles; root "
        "{}\n\n",
        hand.robot.name,
        loaded.file.string(),
        hand.srdfFile.empty() ? "inference: no SRDF is used" : hand.srdfFile.string(),
        hand.robot.tree.size(),
        hand.trees.size(),
        triangles,
        linkName(hand, 0));
    printFingers(hand);
    fmt::print(
        "\njoints; the effort that the file states and that by which a motor presses [N m or N], "
        "*: assumed;\nthe last columns are the preshapes [rad or m]\n{}",
        alignedText(jointTable(hand)));
    fmt::print("\n");
    const bool isOne = std::ranges::none_of(
        hand.preshapes, [](const grasp::Preshape& preshape) { return preshape.X_RG.has_value(); });
    for (const grasp::Preshape& preshape : hand.preshapes)
    {
        printGraspFrame(hand, preshape, isOne);
        if (isOne)
        {
            break;
        }
    }
    fmt::print("openings: {}\n", openingsText(hand));
    const std::vector<std::string> disabled = disabledPairs(hand);
    fmt::print("{} pairs of links tested against each other, {} not:\n",
               hand.selfPairs.size(),
               disabled.size());
    for (const std::string& pair : disabled)
    {
        fmt::print("  {}\n", pair);
    }
    printNotes(hand);
    if (!arguments.output.empty())
    {
        drawPreshapes(hand, arguments.output);
        if (const fs::path viewer = viewerFile(); !viewer.empty())
        {
            writePreshapePage(loaded, viewer, fs::path(arguments.output) / "report.html");
        }
    }
    return kDone;
}

void addShowOptions(CLI::App& command, HandArguments& arguments)
{
    command
        .add_option(
            "hand", arguments.hand, "A URDF, xacro or MJCF file, or the name of a hand that ships.")
        ->type_name("HAND");
    command
        .add_option("--srdf",
                    arguments.srdf,
                    "Where fingers and preshapes are read from. Default: as in grasp plan.")
        ->type_name("FILE");
    command
        .add_option(
            "-o,--output",
            arguments.output,
            "Also draw every preshape from four sides into this folder, as PNG: the grasp "
            "frame (x red, y green, z blue) and the ways of the fingertips. With the page in "
            "three dimensions, report.html shows every preshape close on a small ball.")
        ->type_name("FOLDER");
}

struct InitArguments
{
    std::string hand;
    std::string output;
};

int init(const InitArguments& arguments)
{
    const fs::path file = fs::absolute(resolveHand(arguments.hand)).lexically_normal();
    if (!arguments.output.empty())
    {
        requireOtherFile(arguments.output, {file.string()});
        if (fs::is_regular_file(arguments.output))
        {
            throw std::runtime_error(arguments.output +
                                     ": exists already: name another file, or remove it");
        }
        requireWritable(arguments.output);
    }
    const HandModel hand = grasp::inferHand(file, cacheFolder());
    const std::string srdf = grasp::handSrdf(hand);
    if (arguments.output.empty())
    {
        fmt::print("{}", srdf);
        return kDone;
    }
    writeWholeFile(arguments.output, srdf);
    fmt::print("wrote {}: {} fingers, {} preshapes\n",
               arguments.output,
               hand.fingers.size(),
               hand.preshapes.size());
    return kDone;
}

void addInitCommand(CLI::App& hand, int& exitCode)
{
    auto* command = hand.add_subcommand(
        "init", "Writes what is inferred of a hand as an SRDF with comments, to be corrected.");
    command->footer(
        "Everything is inferred from the URDF or MJCF alone, whatever SRDF there is. An SRDF "
        "beside the "
        "URDF that has its name is found by all verbs.\n"
        "\n"
        "Elements that are read of an SRDF, with examples; what is left out is inferred:\n"
        "  <group name=\"thumb\"><chain base_link=\"palm\" tip_link=\"thumb_3\"/></group>\n"
        "      a finger: the links below base_link down to tip_link\n"
        "  <group_state name=\"wrap\" group=\"thumb\"><joint name=\"turn\" value=\"1.2\"/>\n"
        "  </group_state>\n"
        "      a part of the preshape wrap [rad or m]; joints not listed are at 0\n"
        "  <passive_joint name=\"turn\"/>\n"
        "      keeps its preshape while the hand closes\n"
        "  <closing joint=\"thumb_1\" direction=\"+1\" speed=\"0.5\"/>\n"
        "      closes towards its upper limit (-1: its lower one), half as fast as usual\n"
        "  <grasp_frame preshape=\"wrap\" link=\"palm\" xyz=\"0.05 0 0.1\" rpy=\"0 1.2 0\"/>\n"
        "      origin where the fingers meet, z the way towards an object, x across which the\n"
        "      fingers oppose each other; without preshape: of all that have none\n"
        "  <disable_collisions link1=\"a\" link2=\"b\" reason=\"Never\"/>\n"
        "      links that are not tested against each other; grasp hand check proposes them\n"
        "\n"
        "Exit codes: 0 if it is written, 2 for wrong options, 3 for bad input and for an output "
        "that exists.\n"
        "\n"
        "Example:\n"
        "  grasp hand init my_hand.urdf -o my_hand.srdf");
    const auto arguments = std::make_shared<InitArguments>();
    command
        ->add_option("hand",
                     arguments->hand,
                     "A URDF, xacro or MJCF file, or the name of a hand that ships.")
        ->type_name("HAND")
        ->required();
    command->add_option("-o,--output", arguments->output, "The file. Default: it is printed.")
        ->type_name("FILE");
    command->callback([arguments, &exitCode] { exitCode = init(*arguments); });
}

int showNamed(const HandArguments& arguments)
{
    if (arguments.hand.empty())
    {
        throw CLI::RequiredError("hand");
    }
    return show(arguments);
}
}  // namespace

void addHandCommand(CLI::App& app, int& exitCode)
{
    constexpr const char* kWhat = "Shows what is understood of a hand, and what was inferred.";
    auto* command = app.add_subcommand("hand", kWhat);
    command->footer(
        "It prints the fingers, the joints with their efforts and preshapes, the grasp frame and "
        "the pairs of "
        "links that are not tested against each other. 'grasp hand HAND' is short for 'grasp hand "
        "show HAND'.\n"
        "\n"
        "Exit codes: 0 if the hand could be read, 2 for wrong options, 3 for bad input.\n"
        "\n"
        "Examples:\n"
        "  grasp hand anthropomorphic_hand\n"
        "  grasp hand show my_hand.urdf -o pictures\n"
        "  grasp hand check my_hand.urdf\n"
        "  grasp hand init my_hand.urdf -o my_hand.srdf");
    const auto arguments = std::make_shared<HandArguments>();
    addShowOptions(*command, *arguments);
    CLI::App* shown = command->add_subcommand("show", kWhat);
    addShowOptions(*shown, *arguments);
    shown->callback([arguments, &exitCode] { exitCode = showNamed(*arguments); });
    addHandCheckCommand(*command, exitCode);
    addInitCommand(*command, exitCode);
    command->callback(
        [command, arguments, &exitCode]
        {
            if (command->get_subcommands().empty())
            {
                exitCode = showNamed(*arguments);
            }
        });
}
}  // namespace bullet_ccd::tools
