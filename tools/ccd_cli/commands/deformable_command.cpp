#include "bullet_ccd/deformable/deformable_toi.h"
#include "tools/ccd_cli/commands/commands.h"
#include "tools/ccd_cli/files/frame_files.h"
#include "tools/ccd_cli/files/frame_obstacle.h"
#include "tools/support/command_line.h"
#include "tools/support/option_values.h"
#include "tools/support/stop_request.h"
#include "tools/support/stopwatch.h"
#include "tools/support/text_file.h"

#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
struct DeformableArguments
{
    std::vector<std::string> frames;
    std::string sequence;
    std::vector<std::string> obstacles;
    std::vector<std::pair<std::string, std::string>> moving;  ///< mesh and poses
    std::string output;
    DeformableOptions options;
    bool self = false;
    bool first = false;
    bool weld = false;
    bool summary = false;
    double timeLimit = 0.0;
};

/// The files, and from which to which each step goes.
struct Frames
{
    std::vector<std::filesystem::path> files;
    std::vector<std::pair<std::size_t, std::size_t>> steps;
};

Frames stepsOf(const DeformableArguments& arguments)
{
    Frames frames;
    if (!arguments.sequence.empty())
    {
        frames.files = framesOf(arguments.sequence);
        for (std::size_t i = 1; i < frames.files.size(); ++i)
        {
            frames.steps.emplace_back(i - 1, i);
        }
        return frames;
    }
    if (arguments.frames.empty() || arguments.frames.size() % 2 != 0)
    {
        throw CLI::ValidationError(
            "FRAMES",
            fmt::format("{} file{}: give two per step, where it begins and where it ends, or "
                        "--sequence",
                        arguments.frames.size(),
                        arguments.frames.size() == 1 ? "" : "s"));
    }
    frames.files.assign(arguments.frames.begin(), arguments.frames.end());
    for (std::size_t i = 0; i < arguments.frames.size(); i += 2)
    {
        frames.steps.emplace_back(i, i + 1);
    }
    return frames;
}

/// The mesh that deforms, with the obstacles around it.
class FrameSeries
{
public:
    FrameSeries(const DeformableArguments& arguments, Frames frames, StopCondition stop)
        : m_arguments(arguments), m_frames(std::move(frames)), m_stop(stop)
    {
        for (const std::string& file : arguments.obstacles)
        {
            m_obstacles.emplace_back(file, m_frames.files.size());
        }
        for (const auto& [file, poses] : arguments.moving)
        {
            m_obstacles.emplace_back(file, poses, m_frames.files.size());
        }
    }

    /// One row for every contact; nullopt if it was stopped.
    std::optional<std::string> step(std::size_t frame)
    {
        const auto& [first, second] = m_frames.steps[frame];
        const std::filesystem::path& startFile = m_frames.files[first];
        FrameFile start =
            m_last && m_last->path == startFile ? std::move(*m_last) : readFrame(startFile);
        FrameFile end = readFrame(m_frames.files[second]);
        requireSameTopology(start, end);
        const Stopwatch buildWatch;
        const bool isNew = !m_surface || !start.hasTopologyOf(m_topology);
        if (isNew)
        {
            build(start);
        }
        const double buildSeconds = isNew ? buildWatch.seconds() : 0.0;
        const Stopwatch refitWatch;
        try
        {
            m_surface->setStep(start.soup.vertices, end.soup.vertices, m_arguments.options.threads);
        }
        catch (const std::invalid_argument& error)
        {
            throw std::runtime_error(
                fmt::format("{} to {}: {}", start.path.string(), end.path.string(), error.what()));
        }
        for (FrameObstacle& obstacle : m_obstacles)
        {
            obstacle.setStep(first, second, m_arguments.options.threads);
        }
        const double refitSeconds = refitWatch.seconds();
        const Stopwatch queryWatch;
        const DeformableResult result = query();
        const double querySeconds = queryWatch.seconds();
        if (result.status == ToiStatus::Stopped)
        {
            return std::nullopt;
        }
        if (result.status == ToiStatus::IterationLimit && result.contacts.empty())
        {
            fmt::print(stderr,
                       "bullet-ccd: step {} was NOT checked: more than {} pairs may touch: raise "
                       "--max-iterations, or repair the frames\n",
                       frame,
                       m_arguments.options.maxIterations);
            m_isComplete = false;
        }
        if (m_arguments.summary)
        {
            fmt::print(
                "step {}: {} triangles, {} contacts, first at {}, {} pairs of features; "
                "ms: build {:.2f}, refit {:.2f}, query {:.2f}\n",
                frame,
                m_surface->triangleCount(),
                result.contacts.size(),
                result.time,
                result.counters.featurePairs,
                1e3 * buildSeconds,
                1e3 * refitSeconds,
                1e3 * querySeconds);
        }
        m_last = std::move(end);
        return rows(frame, result);
    }

    [[nodiscard]] bool isComplete() const { return m_isComplete; }

private:
    void build(const FrameFile& frame)
    {
        const TriangleMesh mesh = frame.triangles();
        m_surface.emplace(surfaceOf(frame.path.string(), mesh, m_arguments.weld));
        m_topology = frame;
        m_parts = connectedParts(mesh);
        m_partCount = 0;
        for (const std::int32_t part : m_parts)
        {
            m_partCount = std::max(m_partCount, part + 1);
        }
    }

    DeformableResult query()
    {
        std::vector<DeformableBody> bodies{{.surface = &*m_surface}};
        for (const FrameObstacle& obstacle : m_obstacles)
        {
            bodies.push_back(obstacle.body());
        }
        bodies[0].selfCollision = m_arguments.self || m_partCount > 1;
        DeformableOptions options = m_arguments.options;
        options.stop = m_stop;
        if (!m_arguments.self)
        {
            options.isExempt = [this](const DeformableContact& contact)
            { return partOfA(contact) == partOfB(contact); };
        }
        return m_arguments.first ? deformableToi(bodies, options, m_work)
                                 : deformableContacts(bodies, options, m_work);
    }

    /// Connected parts of the mesh, then the obstacles.
    [[nodiscard]] std::int32_t partOf(std::int32_t body, std::int32_t vertex) const
    {
        return body == 0 ? m_parts[static_cast<std::size_t>(vertex)] : m_partCount + body - 1;
    }
    [[nodiscard]] std::int32_t partOfA(const DeformableContact& contact) const
    {
        return partOf(contact.bodyA, contact.vertices.front());
    }
    [[nodiscard]] std::int32_t partOfB(const DeformableContact& contact) const
    {
        return partOf(contact.bodyB, contact.vertices.back());
    }

    [[nodiscard]] std::string rows(std::size_t frame, const DeformableResult& result) const
    {
        std::string text;
        for (const DeformableContact& contact : result.contacts)
        {
            text +=
                fmt::format("{},{},{},{},{},{},{},{},{},{}\n",
                            frame,
                            contact.time,
                            contact.kind == ElementaryKind::EdgeEdge ? "edge_edge" : "vertex_face",
                            contact.vertices[0],
                            contact.vertices[1],
                            contact.vertices[2],
                            contact.vertices[3],
                            partOfA(contact),
                            partOfB(contact),
                            contact.gap);
        }
        return text;
    }

    const DeformableArguments& m_arguments;
    Frames m_frames;
    StopCondition m_stop;
    std::vector<FrameObstacle> m_obstacles;
    std::optional<DeformableSurface> m_surface;
    FrameFile m_topology;  ///< that the surface was built from
    std::optional<FrameFile> m_last;
    std::vector<std::int32_t> m_parts;
    std::int32_t m_partCount = 0;
    bool m_isComplete = true;
    DeformableWorkspace m_work;
};

int runDeformable(const DeformableArguments& arguments)
{
    const Frames frames = stepsOf(arguments);
    for (const std::filesystem::path& file : frames.files)
    {
        requireOtherFile(arguments.output, {file.string()});
    }
    requireWritable(arguments.output);
    const StopRequest stop(arguments.timeLimit);
    FrameSeries series(arguments, frames, stop.condition());
    std::string table = "frame,toi,kind,a0,a1,a2,a3,body_a,body_b,gap\n";
    std::size_t done = 0;
    try
    {
        for (; done < frames.steps.size() && !stop.isDue(); ++done)
        {
            const std::optional<std::string> rows = series.step(done);
            if (!rows)
            {
                break;
            }
            table += *rows;
        }
    }
    catch (const std::exception&)
    {
        if (done > 0)
        {
            writeWholeFile(arguments.output, table);
            fmt::print(stderr,
                       "bullet-ccd deformable: {} has the first {} of {} steps\n",
                       arguments.output,
                       done,
                       frames.steps.size());
        }
        throw;
    }
    writeWholeFile(arguments.output, table);
    const bool isChecked = series.isComplete() && done == frames.steps.size();
    return stop.finish("bullet-ccd deformable",
                       done,
                       frames.steps.size(),
                       "steps",
                       isChecked ? kDone : kNothingFound);
}

constexpr const char* kDeformableFooter =
    "FRAMES are OBJ files, two per step: the same mesh where the step begins and where it ends. "
    "Vertices move on straight lines over t = 0 to 1. Contacts of a vertex and a face and of two "
    "edges are found between connected parts of the mesh, with --self within them, too, and with "
    "the obstacles. Features that share a vertex are neighbours and do not count.\n"
    "\n"
    "An obstacle rests, or has frames of its own, or a pose in each frame. POSES has the columns "
    "qw, qx, qy, qz, tx, ty, tz and one row per frame, also where a frame is given twice. Between "
    "two poses it turns along the shortest arc. Its vertices go straight in a step, and what they "
    "are off the arc is kept in addition to the minimum separation, so take steps with small "
    "turns; --exact needs obstacles that do not turn.\n"
    "\n"
    "RESULTS has the columns frame, toi, kind, a0, a1, a2, a3, body_a, body_b, gap and one row per "
    "contact, sorted by step, then by toi, before which these two features certainly do not touch. "
    "kind is vertex_face (vertex a0, face a1 a2 a3) or edge_edge (edges a0 a1 and a2 a3), and "
    "vertices count from 0. The connected parts are the bodies from 0, in the order of their first "
    "vertices; the obstacles come after them. gap is the distance at toi.\n"
    "\n"
    "No contact is ever missed. Without --exact, a contact may be a pair that comes within the "
    "tolerance and does not touch.\n"
    "\n"
    "Exit codes: 0 if every step was checked, 1 if one has too many pairs or the time limit left "
    "some out, 2 for wrong options, 3 for bad input, 130 after Ctrl-C. After Ctrl-C, at the time "
    "limit, or where a frame is bad, RESULTS has the steps that were done before; stderr says how "
    "many.\n"
    "\n"
    "Examples:\n"
    "  bullet-ccd deformable f0.obj f1.obj --self -o contacts.csv\n"
    "  bullet-ccd deformable --sequence 'f_*.obj' --obstacle table.obj -o c.csv\n"
    "  bullet-ccd deformable --sequence 'f_*.obj' --moving-obstacle a.stl a.csv";

void addDeformableFlags(CLI::App& command, DeformableArguments& arguments)
{
    addDepthOptions(command, arguments.options.depth);
    command.add_flag(
        "--self", arguments.self, "Test connected parts of the mesh against themselves, too.");
    command.add_flag("--first", arguments.first, "Find only the first contact of each step.");
    command.add_flag("--weld",
                     arguments.weld,
                     "Let vertices at exactly the same place count as one. Otherwise they are an "
                     "error, because their triangles touch from the start.");
    command.add_flag(
        "--summary", arguments.summary, "Print counts and times of each step when it is done.");
    command
        .add_option("-j,--jobs",
                    arguments.options.threads,
                    "The number of threads. It changes nothing but the times.")
        ->type_name("N")
        ->check(within(1, 1024))
        ->capture_default_str();
    command
        .add_option("--max-iterations",
                    arguments.options.maxIterations,
                    "How many pairs a step may have before it is given up.")
        ->type_name("N")
        ->check(within(std::int64_t{1}, std::int64_t{1'000'000'000'000}))
        ->capture_default_str();
}
}  // namespace

void addDeformableCommand(CLI::App& app, int& exitCode)
{
    CLI::App* command =
        app.add_subcommand("deformable", "Finds the contacts of a deforming mesh between frames.");
    command->footer(kDeformableFooter);
    const auto arguments = std::make_shared<DeformableArguments>();
    CLI::Option* frames =
        command->add_option("FRAMES", arguments->frames, "The frames, two per step.")
            ->type_name("OBJ");
    command
        ->add_option(
            "--sequence",
            arguments->sequence,
            "The frames of a sequence instead, by a name with one *, in quotes. Each frame "
            "ends the step that the one before begins.")
        ->type_name("PATTERN")
        ->excludes(frames);
    command
        ->add_option("--obstacle",
                     arguments->obstacles,
                     "A mesh that rests; with one * in its name, in quotes, the OBJ frames of one "
                     "that moves, as many as the mesh has. The option may be given several times.")
        ->type_name("MESH")
        ->allow_extra_args(false);
    command
        ->add_option("--moving-obstacle",
                     arguments->moving,
                     "A mesh and its pose in every frame. The option may be given several times.")
        ->type_name("MESH POSES");
    addTimeLimitOption(*command, arguments->timeLimit, "Stop the steps");
    command
        ->add_option(
            "-o,--output", arguments->output, "Where to write RESULTS, one row per contact.")
        ->type_name("CSV")
        ->required();
    addDistanceOptions(
        *command, arguments->options.tolerance, arguments->options.minimumSeparation);
    addDeformableFlags(*command, *arguments);
    command->callback([arguments, &exitCode] { exitCode = runDeformable(*arguments); });
}
}  // namespace bullet_ccd::tools
