/// Flat drawing on a picture, and the way to a PNG file.
#pragma once

#include "grasp/report/raster.h"

#include <filesystem>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
struct Canvas
{
    Canvas(int w, int h)
        : width(w),
          height(h),
          pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), Color::Ones())
    {
    }
    [[nodiscard]] Color& at(int x, int y)
    {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(x)];
    }

    int width;
    int height;
    std::vector<Color> pixels;
};

struct Ink
{
    Color color = Color::Zero();
    float opacity = 1.0F;
};

/// Line with round ends; a disc if both ends are one. `width` is the diameter [pixels].
void drawLine(Canvas& canvas,
              const Eigen::Vector2d& from,
              const Eigen::Vector2d& to,
              double width,
              const Ink& ink);
void drawArrowHead(Canvas& canvas,
                   const Eigen::Vector2d& tip,
                   const Eigen::Vector2d& direction,
                   double size,
                   const Ink& ink);
/// Digits, space and "m"; glyphs are 5 x 7 cells of `cell` pixels, `place` is the upper left
/// corner.
void drawLabel(Canvas& canvas,
               const std::string& text,
               const Eigen::Vector2i& place,
               int cell,
               const Ink& ink);
/// Width of such a label [pixels].
[[nodiscard]] int labelWidth(const std::string& text, int cell);

/// Averages 2 x 2 pixels into one, into the part of `target` that starts at that column and row.
void shrinkInto(Canvas& target, int left, const Canvas& source, int top = 0);

/// 8 bits a channel. Throw std::runtime_error if the file cannot be written or read.
void writePng(const Canvas& canvas, const std::filesystem::path& file);
[[nodiscard]] Canvas readPng(const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
