#include "tools/grasp_cli/plan/plan_journal.h"

#include "grasp/formats/content_hash.h"
#include "tools/support/text_table.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <stdexcept>
#include <sys/file.h>
#include <unistd.h>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using grasp::Grasp;

std::string fingersText(const grasp::ClosingOptions& closing)
{
    return closing.firstFingers.empty() ? std::string(grasp::toString(closing.order))
                                        : joined(closing.firstFingers, ",");
}

std::string speedsText(const grasp::ClosingOptions& closing)
{
    std::string text = "of the hand";
    for (const auto& [joint, ratio] : closing.speeds)
    {
        text += fmt::format(", {}={}", joint, ratio);
    }
    return text;
}

std::string approachText(const grasp::ApproachOptions& options)
{
    const Eigen::Vector3d& up = options.up;
    return fmt::format(
        "from {}{} (up {} {} {}, tilt {}), standoff {}, reach {}{}",
        grasp::toString(options.source),
        options.tableTop ? " above a table" : "",
        up.x(),
        up.y(),
        up.z(),
        options.maxTilt,
        options.standoff,
        options.reach,
        options.roll ? fmt::format(", roll {} to {}", options.roll->from, options.roll->to) : "");
}

/// In what, of all that candidates depend on, the two differ.
std::vector<std::string> differences(const grasp::GraspFileSource& then,
                                     const grasp::GraspRun& now,
                                     const grasp::HandModel& hand,
                                     const grasp::GraspObject& object)
{
    std::vector<std::string> texts;
    const auto compare = [&](const char* name, const auto& a, const auto& b)
    {
        if (a != b)
        {
            texts.push_back(fmt::format("{} {}, now {}", name, a, b));
        }
    };
    const auto orNone = [](const std::string& hash) { return hash.empty() ? "none" : hash; };
    const grasp::PlannerOptions& a = then.run.options;
    const grasp::PlannerOptions& b = now.options;
    compare("hand with content hash", then.handHash, grasp::contentHash(hand));
    compare("object with content hash", then.objectHash, grasp::contentHash(object));
    compare(
        "obstacles with content hash", orNone(then.run.obstaclesHash), orNone(now.obstaclesHash));
    compare("robot", orNone(then.run.robot), orNone(now.robot));
    compare("seed", a.seed, b.seed);
    compare("candidates", a.candidates, b.candidates);
    compare(
        "engine", std::string(grasp::toString(a.engine)), std::string(grasp::toString(b.engine)));
    compare("approach", approachText(a.approach), approachText(b.approach));
    compare("fingers", fingersText(a.closing), fingersText(b.closing));
    compare("closing speeds", speedsText(a.closing), speedsText(b.closing));
    compare("friction", a.friction, b.friction);
    compare("cone edges", a.coneEdges, b.coneEdges);
    compare("least epsilon", a.forceClosureThreshold, b.forceClosureThreshold);
    compare("tolerance", a.closing.tolerance, b.closing.tolerance);
    compare("contact threshold", a.closing.contactThreshold, b.closing.contactThreshold);
    compare("contact spacing", a.minContactSpacing, b.minContactSpacing);
    compare("bullet_ccd", then.version, std::string(grasp::recorderVersion()));
    return texts;
}

/// Of the finished lines of a file [bytes].
std::uintmax_t finishedLength(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const std::size_t last = text.rfind('\n');
    return last == std::string::npos ? 0 : last + 1;
}
}  // namespace

PlanJournal::PlanJournal(const fs::path& folder,
                         const grasp::GraspRun& run,
                         const grasp::HandModel& hand,
                         const grasp::GraspObject& object,
                         bool resume)
    : m_file(folder / "grasps.journal.jsonl"), m_recorder(run, hand, object)
{
    open();
    try
    {
        fs::resize_file(m_file, finishedLength(m_file));
        if (fs::file_size(m_file) > 0 && resume)
        {
            takeOver(run, hand, object);
        }
        else if (fs::file_size(m_file) > 0)
        {
            m_setAside = m_file.string() + ".old";
            fs::rename(m_file, m_setAside);
            close();
            open();
        }
    }
    catch (...)
    {
        close();
        throw;
    }
}

PlanJournal::~PlanJournal()
{
    std::error_code ignored;
    if (m_descriptor >= 0 && fs::file_size(m_file, ignored) == 0)
    {
        fs::remove(m_file, ignored);
    }
    close();
}

void PlanJournal::open()
{
    constexpr mode_t kReadableByAll = 0644;
    m_descriptor = ::open(m_file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, kReadableByAll);
    if (m_descriptor < 0)
    {
        fail(fmt::format("cannot be written ({}): choose another folder with -o",
                         std::strerror(errno)));
    }
    // A file system without locks is taken as it is.
    if (::flock(m_descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    {
        close();
        fail("another run is writing it: wait for its end or choose another folder with -o");
    }
}

void PlanJournal::close()
{
    if (m_descriptor >= 0)
    {
        ::close(m_descriptor);
        m_descriptor = -1;
    }
}

void PlanJournal::takeOver(const grasp::GraspRun& run,
                           const grasp::HandModel& hand,
                           const grasp::GraspObject& object)
{
    const std::vector<std::string> other =
        differences(grasp::readGraspSource(m_file), run, hand, object);
    if (!other.empty())
    {
        fail(
            fmt::format("the stopped run had {}: give what it was given, or plan afresh without "
                        "--resume",
                        joined(other, "; ")));
    }
    m_known = grasp::readGrasps(m_file, hand);
    std::set<std::int64_t> numbers;
    for (const Grasp& grasp : m_known)
    {
        if (grasp.candidate < 0 || grasp.candidate >= run.options.candidates ||
            !numbers.insert(grasp.candidate).second)
        {
            fail(
                fmt::format("candidate {} is there twice or is none of {}: plan afresh without "
                            "--resume",
                            grasp.candidate,
                            run.options.candidates));
        }
    }
}

void PlanJournal::append(const Grasp& grasp)
{
    const std::string line = m_recorder.exact(grasp) + '\n';
    const std::scoped_lock lock(m_mutex);
    const ssize_t written = ::write(m_descriptor, line.data(), line.size());
    if (written != static_cast<ssize_t>(line.size()))
    {
        fail("cannot be written: is the disk full? What is in it can be gone on with by --resume");
    }
}

void PlanJournal::remove()
{
    std::error_code ignored;
    fs::remove(m_file, ignored);
    close();
}

void PlanJournal::fail(const std::string& what) const
{
    throw std::runtime_error(fmt::format("{}: {}", m_file.string(), what));
}
}  // namespace bullet_ccd::tools
