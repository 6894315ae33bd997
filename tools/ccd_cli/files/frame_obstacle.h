/// Obstacles of a mesh that deforms, and where they are in its frames.
#pragma once

#include "bullet_ccd/deformable/deformable_toi.h"
#include "tools/ccd_cli/files/frame_files.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tools
{
/// A mesh that rests, one that has a pose in every frame, or the frames of one that deforms itself.
class FrameObstacle
{
public:
    /// @param file  a mesh of any format; with one * in its name, OBJ frames in the order of their
    ///              numbers (see framesOf())
    /// @param frames  how many frames the deforming mesh has
    /// Throws std::runtime_error "<file>: <what>: <remedy>", also for another number of frames.
    FrameObstacle(const std::string& file, std::size_t frames);
    /// @param poses  CSV with the columns qw, qx, qy, qz, tx, ty, tz and a row for every frame
    FrameObstacle(const std::string& file, const std::string& poses, std::size_t frames);

    /// The step from one frame to another. A pose goes to the next one along the shortest arc.
    /// Throws std::runtime_error for what deformable surfaces refuse.
    void setStep(std::size_t begin, std::size_t end, int threads);
    [[nodiscard]] DeformableBody body() const
    {
        return {.surface = &m_surface, .selfCollision = false, .deviation = m_deviation};
    }

private:
    std::string m_name;
    FrameFile m_frame;  ///< of those of a mesh that deforms the last one that was read
    TriangleMesh m_mesh;
    DeformableSurface m_surface;
    std::vector<std::filesystem::path> m_frames;
    std::vector<Eigen::Isometry3d> m_poses;
    double m_deviation = 0.0;

    FrameObstacle(FrameFile first, const std::string& name);
    [[nodiscard]] const FrameFile& frame(std::size_t index);
};

/// The surface of a mesh. Throws std::runtime_error that names the file.
[[nodiscard]] DeformableSurface surfaceOf(const std::string& file,
                                          const TriangleMesh& mesh,
                                          bool weld);
}  // namespace bullet_ccd::tools
