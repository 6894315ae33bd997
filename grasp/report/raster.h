/// Software renderer: triangles into a picture with depth, seen without perspective.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace bullet_ccd::grasp
{
using Color = Eigen::Vector3f;  ///< linear blend of red, green, blue in [0, 1]

/// Orthographic camera; pixel x runs right, y down, depth away from the viewer.
struct Camera
{
    Eigen::Matrix3d R_CW = Eigen::Matrix3d::Identity();  ///< rows: right, up, towards the viewer
    Eigen::Vector3d center_W = Eigen::Vector3d::Zero();  ///< in the middle of the picture
    double pixelsPerMetre = 1.0;
    int width = 0;
    int height = 0;

    /// (x, y) in pixels, depth [m].
    [[nodiscard]] Eigen::Vector3d project(const Eigen::Vector3d& point_W) const
    {
        const Eigen::Vector3d p = R_CW * (point_W - center_W);
        return {
            0.5 * width + pixelsPerMetre * p.x(), 0.5 * height - pixelsPerMetre * p.y(), -p.z()};
    }
};

/// Camera that looks from `direction` (unit, towards the viewer) with `up` upwards as far as
/// possible.
[[nodiscard]] Eigen::Matrix3d lookFrom(const Eigen::Vector3d& direction, const Eigen::Vector3d& up);

/// A mesh in W with one normal a corner: smooth across shallow edges, broken at sharp ones.
struct Shape
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    std::vector<std::array<Eigen::Vector3f, 3>> normals;
    Color color = Color::Zero();
    std::int32_t id = kNone;
};
[[nodiscard]] BULLET_CCD_API Shape makeShape(const TriangleMesh& mesh,
                                             const Eigen::Isometry3d& pose);

/// What is nearest to the viewer, per pixel.
struct Layer
{
    Layer(int w, int h)
        : width(w),
          height(h),
          depth(static_cast<std::size_t>(w) * static_cast<std::size_t>(h),
                std::numeric_limits<float>::infinity()),
          id(depth.size(), kNone),
          color(depth.size(), Color::Zero())
    {
    }
    [[nodiscard]] std::size_t at(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }

    int width;
    int height;
    std::vector<float> depth;      ///< infinite: nothing there
    std::vector<std::int32_t> id;  ///< of the shape
    std::vector<Color> color;
};

void drawShape(Layer& layer, const Camera& camera, const Shape& shape);
}  // namespace bullet_ccd::grasp
