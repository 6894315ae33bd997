#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/nearest_name.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/trajectory_file.h"
#include "tools/ccd_cli/run/certify_run.h"
#include "tools/ccd_cli/text/certificate_text.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/pose_text.h"
#include "tools/support/stop_request.h"
#include "tools/support/text_file.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
struct CertifyArguments
{
    std::string urdf;
    std::string srdf;
    std::vector<std::string> trajectories;
    std::string base;
    std::vector<std::string> obstacles;
    std::vector<std::string> attached;
    std::vector<std::string> allowed;
    std::vector<std::string> without;
    bool self = false;
    double jointReach = kDefaultJointReach;
    double tolerance = ToiOptions{}.tolerance;
    double margin = 0.0;
    std::int64_t maxIterations = ToiOptions{}.maxIterations;
    bool noDistance = false;
    int jobs = 0;
    std::string output;
    double timeLimit = 0.0;
};

Eigen::Isometry3d poseOfText(const std::string& text)
{
    const std::vector<double> values = numbersFrom(text, 7);
    return poseFrom(std::span<const double, 7>(values.data(), 7));
}

/// FILE@LINK, or FILE@LINK@POSE.
struct Attachment
{
    std::string file;
    std::string link;
    Eigen::Isometry3d X_LO = Eigen::Isometry3d::Identity();
};

Attachment attachmentFrom(const std::string& text)
{
    const std::size_t first = text.find('@');
    if (first == std::string::npos || first == 0 || first + 1 == text.size())
    {
        throw std::invalid_argument(
            fmt::format("'{}' is not FILE@LINK: name a mesh and the link that carries it", text));
    }
    const std::size_t second = text.find('@', first + 1);
    Attachment attachment{.file = text.substr(0, first),
                          .link = text.substr(first + 1, second - first - 1)};
    if (second != std::string::npos)
    {
        attachment.X_LO = poseOfText(text.substr(second + 1));
    }
    return attachment;
}

AllowedPair allowedFrom(const std::string& text)
{
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos || comma == 0 || comma + 1 == text.size())
    {
        throw std::invalid_argument(
            fmt::format("'{}' is not NAME,NAME: name two links, objects or obstacles", text));
    }
    return {.a = text.substr(0, comma), .b = text.substr(comma + 1)};
}

void attach(RobotLinks& links, const std::string& text, bool testsSelf)
{
    const Attachment attachment = attachmentFrom(text);
    const std::int32_t link = links.robot.tree.findLink(attachment.link);
    if (link == kNone)
    {
        std::vector<std::string> known;
        for (const Link& each : links.robot.tree.links)
        {
            known.push_back(each.name);
        }
        throw std::runtime_error(
            fmt::format("--attach: {}: the robot has no link {}: did you mean "
                        "{}?",
                        text,
                        attachment.link,
                        nearestName(attachment.link, known)));
    }
    const std::string name = std::filesystem::path(attachment.file).filename().string();
    if (links.robot.tree.findLink(name) != kNone)
    {
        throw std::runtime_error(fmt::format(
            "--attach: {}: there is a link or an attached object {} already: rename the file",
            text,
            name));
    }
    attachObject(links, name, loadMeshFile(attachment.file).mesh, link, attachment.X_LO, testsSelf);
}

/// The robot with what it carries, and what stands around it.
struct Surroundings
{
    RobotLinks links;
    std::vector<Obstacle> obstacles;
    std::vector<RigidBody> bodies;
};

Surroundings loadSurroundings(const CertifyArguments& a)
{
    Surroundings world{.links = loadRobotLinks(a.urdf), .obstacles = {}, .bodies = {}};
    const bool testsSelf = a.self || !a.srdf.empty();
    if (testsSelf)
    {
        addSelfPairs(world.links, a.srdf, a.jointReach);
    }
    for (const std::string& text : a.attached)
    {
        attach(world.links, text, testsSelf);
    }
    world.obstacles = loadObstacles(a.obstacles);
    for (const std::string& name : a.without)
    {
        if (std::erase_if(world.obstacles,
                          [&](const Obstacle& obstacle) { return obstacle.name == name; }) == 0)
        {
            throw std::runtime_error("--without: there is no obstacle " + name);
        }
    }
    world.bodies = bodiesOf(world.obstacles);
    for (const std::string& text : a.allowed)
    {
        allowPair(world.links, world.obstacles, allowedFrom(text));
    }
    for (const std::string& note : world.links.notes)
    {
        fmt::print(stderr, "bullet-ccd: {}\n", note);
    }
    return world;
}

/// One file; what is wrong with it becomes part of the answer.
Certificate certifyFile(const Surroundings& world,
                        const std::filesystem::path& path,
                        const Eigen::Isometry3d& X_WR,
                        const CertifyOptions& options)
{
    try
    {
        const TrajectoryFile file = readTrajectoryFile(path, world.links.robot.tree, X_WR);
        for (const std::string& note : file.notes)
        {
            fmt::print(stderr, "bullet-ccd: {}\n", note);
        }
        Certificate certificate = certify(world.links, world.bodies, file.trajectory, options);
        certificate.name = path.string();
        return certificate;
    }
    catch (const std::runtime_error& error)
    {
        fmt::print(stderr, "bullet-ccd: {}\n", error.what());
        Certificate certificate;
        certificate.name = path.string();
        certificate.error = error.what();
        return certificate;
    }
}

int worstCodeOf(const std::vector<Certificate>& certificates)
{
    int code = kDone;
    for (const Certificate& certificate : certificates)
    {
        const Verdict verdict = verdictOf(certificate);
        code = std::max<int>(code,
                             verdict == Verdict::BadInput ? kBadInput
                             : verdict == Verdict::Free   ? kDone
                                                          : kNothingFound);
    }
    return code;
}

int runCertify(const CertifyArguments& a)
{
    if (a.obstacles.empty() && !a.self && a.srdf.empty())
    {
        throw CLI::ValidationError("--obstacles",
                                   "there is nothing to touch: give --obstacles, --self or --srdf");
    }
    if (!a.output.empty())
    {
        requireOtherFile(a.output, {a.urdf, a.srdf});
        requireWritable(a.output);
    }
    const Surroundings world = loadSurroundings(a);
    const std::vector<std::filesystem::path> files = trajectoryFilesOf(a.trajectories);
    const Eigen::Isometry3d X_WR =
        a.base.empty() ? Eigen::Isometry3d::Identity() : poseOfText(a.base);
    const auto jobs = static_cast<std::size_t>(
        a.jobs > 0 ? a.jobs : std::max(1U, std::thread::hardware_concurrency()));
    std::vector<ToiWorkspace> work(jobs);
    const StopRequest stop(a.timeLimit);
    const CertifyOptions options{.toi = {.tolerance = a.tolerance,
                                         .minimumSeparation = a.margin,
                                         .maxIterations = a.maxIterations,
                                         .stop = stop.condition()},
                                 .wantsDistance = !a.noDistance,
                                 .work = work};
    const ArticulatedNames names{.links = world.links, .obstacles = world.obstacles};
    std::vector<Certificate> certificates;
    std::string table = certificateHeader() + "\n";
    for (const std::filesystem::path& path : files)
    {
        if (stop.isDue())
        {
            break;
        }
        const Certificate& certificate =
            certificates.emplace_back(certifyFile(world, path, X_WR, options));
        table += certificateRow(certificate, names) + "\n";
        if (a.output.empty() && verdictOf(certificate) != Verdict::BadInput)
        {
            fmt::print("{}{}",
                       files.size() > 1 ? path.string() + ": " : "",
                       readableText(certificate, names, options.toi));
        }
    }
    if (!a.output.empty())
    {
        writeWholeFile(a.output, table);
    }
    const auto stopped =
        std::ranges::count_if(certificates,
                              [](const Certificate& certificate)
                              { return certificate.toi.status == ToiStatus::Stopped; });
    const std::size_t done = certificates.size() - static_cast<std::size_t>(stopped);
    const int code = worstCodeOf(certificates);
    return stop.finish("bullet-ccd certify",
                       done,
                       files.size(),
                       "trajectories",
                       done < files.size() ? std::max<int>(code, kNothingFound) : code);
}

constexpr const char* kCertifyFooter =
    "A trajectory in CSV names joints in its first line and has one waypoint per row, as the files "
    "of "
    "'bullet-ccd articulated', with a column time [s] (default: a second from row to row). Its "
    "motion is linear between waypoints. A trajectory in YAML has the keys of ROS's "
    "trajectory_msgs/JointTrajectory: joint_names, and points with positions, velocities, "
    "accelerations and time_from_start. Between points with velocities its motion is cubic, and "
    "with accelerations too quintic. The base rests.\n"
    "\n"
    "The whole motion is tested, not samples of it: free means that no link comes nearer than the "
    "margin at any time. The least distance that is printed is never above the truth, and at most "
    "the tolerance below it. Two parts are tested while they move relative to each other.\n"
    "\n"
    "Obstacles and --self are as in 'bullet-ccd articulated'. An attached object is tested against "
    "the obstacles and, with --self, against all links that move relative to it.\n"
    "\n"
    "Of a folder all files that end in .csv, .yaml or .yml are certified. A file that cannot be "
    "read is reported, and the others are certified.\n"
    "\n"
    "Exit codes: 0 if all trajectories are free, 1 if one is in contact or could not be decided "
    "within --max-iterations or --time-limit, 2 for wrong options, 3 for bad input, 130 after "
    "Ctrl-C.\n"
    "\n"
    "Example:\n"
    "  bullet-ccd certify arm.urdf --srdf arm.srdf --trajectory path.yaml \\\n"
    "      --obstacles scene.yaml --attach cup.obj@hand --margin 0.005";

void addTestedOptions(CLI::App& command, CertifyArguments& a)
{
    const char* group = "What it may touch";
    command.add_option("--obstacles", a.obstacles, "Meshes, and scenes of meshes (.csv, .yaml).")
        ->type_name("FILE...")
        ->group(group);
    command
        .add_option("--attach",
                    a.attached,
                    "An object that a link carries. Its mesh is placed in the frame of the link, "
                    "at @QW,QX,QY,QZ,TX,TY,TZ behind the link if that is given.")
        ->type_name("MESH@LINK...")
        ->check(parsedBy(attachmentFrom))
        ->group(group);
    command.add_flag("--self", a.self, "Test the links against each other.")->group(group);
    command.add_option("--srdf", a.srdf, "As --self, without the pairs of links that it disables.")
        ->type_name("SRDF")
        ->group(group);
    command
        .add_option("--allow",
                    a.allowed,
                    "Two links, attached objects or obstacles that may touch each other.")
        ->type_name("NAME,NAME...")
        ->check(parsedBy(allowedFrom))
        ->group(group);
    command
        .add_option("--without",
                    a.without,
                    "Obstacles of these names are left out, such as the object that is attached.")
        ->type_name("NAME...")
        ->group(group);
    command
        .add_option("--joint-reach",
                    a.jointReach,
                    "With --self: how near triangles of joined links must come to each other, at a "
                    "position within the limits of the joint, to be exempt [m].")
        ->type_name("D")
        ->check(within(0.0, 1e6))
        ->capture_default_str()
        ->group(group);
}

void addCertificateOptions(CLI::App& command, CertifyArguments& a)
{
    command.add_option("--margin", a.margin, "The distance that has to be kept at all times [m].")
        ->type_name("D")
        ->check(within(0.0, 1e6))
        ->capture_default_str();
    command
        .add_option("--tolerance",
                    a.tolerance,
                    "How large the gap beyond the margin of a reported contact may be, and how far "
                    "below the truth the least distance [m].")
        ->type_name("D")
        ->check(within(1e-12, 1e6))
        ->capture_default_str();
    command
        .add_option("--max-iterations",
                    a.maxIterations,
                    "How many pairs of nodes and triangles are examined for one segment.")
        ->type_name("N")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000'000'000}))
        ->capture_default_str();
    command.add_flag("--no-distance", a.noDistance, "Do not look for the least distance.");
    command.add_option("--jobs", a.jobs, "How many threads work on the segments; 0: one per core.")
        ->type_name("N")
        ->check(within(0, 1024))
        ->capture_default_str();
    command
        .add_option("-o,--output", a.output, "Where to write a table with one row per trajectory.")
        ->type_name("CSV");
    addTimeLimitOption(command, a.timeLimit, "Stop the queries");
}
}  // namespace

void addCertifyCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command = app.add_subcommand(
        "certify", "Proves that trajectories of a robot are free, or finds their first contact.");
    command->footer(kCertifyFooter);
    const auto arguments = std::make_shared<CertifyArguments>();
    command->add_option("ROBOT", arguments->urdf, "The robot.")->type_name("URDF")->required();
    command
        ->add_option("--trajectory", arguments->trajectories, "Trajectories, and folders of them.")
        ->type_name("FILE...")
        ->required();
    command->add_option("--base", arguments->base, "The pose of the root. Default: the identity.")
        ->type_name("QW,QX,QY,QZ,TX,TY,TZ")
        ->check(parsedBy(poseOfText));
    addTestedOptions(*command, *arguments);
    addCertificateOptions(*command, *arguments);
    command->callback([arguments, &exitCode] { exitCode = runCertify(*arguments); });
}
}  // namespace bullet_ccd::tools
