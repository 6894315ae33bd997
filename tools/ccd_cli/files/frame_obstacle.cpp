#include "tools/ccd_cli/files/frame_obstacle.h"

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "tools/support/csv_table.h"

#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
namespace
{
bool isPattern(const std::string& file)
{
    return file.find('*') != std::string::npos;
}

std::vector<std::filesystem::path> obstacleFrames(const std::string& pattern, std::size_t count)
{
    std::vector<std::filesystem::path> frames = framesOf(pattern);
    if (frames.size() != count)
    {
        throw std::runtime_error(fmt::format(
            "{}: {} frames, but the mesh has {}: an obstacle that deforms needs one for "
            "each of them",
            pattern,
            frames.size(),
            count));
    }
    return frames;
}

std::vector<Eigen::Isometry3d> readPoses(const std::string& file, std::size_t count)
{
    const CsvTable table =
        readCsvTable(file, "give a CSV file with the columns qw, qx, qy, qz, tx, ty, tz");
    const std::optional<PoseColumns> columns = poseColumns(table, "");
    if (!columns)
    {
        table.failNames("no poses: name the columns qw, qx, qy, qz, tx, ty, tz");
    }
    if (table.rows.size() != count)
    {
        throw std::runtime_error(
            fmt::format("{}: {} poses, but the mesh has {} frames: give one for each",
                        file,
                        table.rows.size(),
                        count));
    }
    std::vector<Eigen::Isometry3d> poses;
    for (const CsvRow& row : table.rows)
    {
        poses.push_back(poseOf(table, row, *columns));
    }
    return poses;
}
}  // namespace

DeformableSurface surfaceOf(const std::string& file, const TriangleMesh& mesh, bool weld)
{
    try
    {
        return DeformableSurface(mesh, {.weldDuplicates = weld});
    }
    catch (const std::invalid_argument& error)
    {
        throw std::runtime_error(
            fmt::format("{}: {}{}",
                        file,
                        error.what(),
                        weld ? "" : " (--weld lets vertices at one place count as one)"));
    }
}

FrameObstacle::FrameObstacle(FrameFile first, const std::string& name)
    : m_name(name),
      m_frame(std::move(first)),
      m_mesh(m_frame.path.empty() ? loadMeshFile(name).mesh : m_frame.triangles()),
      m_surface(surfaceOf(name, m_mesh, true))
{
}

FrameObstacle::FrameObstacle(const std::string& file, std::size_t frames)
    : FrameObstacle(isPattern(file) ? readFrame(framesOf(file).front()) : FrameFile{}, file)
{
    if (isPattern(file))
    {
        m_frames = obstacleFrames(file, frames);
    }
}

FrameObstacle::FrameObstacle(const std::string& file, const std::string& poses, std::size_t frames)
    : FrameObstacle(FrameFile{}, file)
{
    m_poses = readPoses(poses, frames);
}

const FrameFile& FrameObstacle::frame(std::size_t index)
{
    if (m_frame.path != m_frames[index])
    {
        FrameFile next = readFrame(m_frames[index]);
        requireSameTopology(m_frame, next);
        m_frame = std::move(next);
    }
    return m_frame;
}

void FrameObstacle::setStep(std::size_t begin, std::size_t end, int threads)
try
{
    if (!m_poses.empty())
    {
        const RigidStep step = rigidStep(m_mesh, motionBetween(m_poses[begin], m_poses[end]));
        m_surface.setStep(step.start, step.end, threads);
        m_deviation = step.deviation;
    }
    else if (!m_frames.empty())
    {
        const std::vector<Eigen::Vector3d> start = frame(begin).soup.vertices;
        m_surface.setStep(start, frame(end).soup.vertices, threads);
    }
}
catch (const std::invalid_argument& error)
{
    throw std::runtime_error(fmt::format("{}: {}", m_name, error.what()));
}
}  // namespace bullet_ccd::tools
