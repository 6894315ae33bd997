#include "grasp/report/canvas.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <png.h>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
using Glyph = std::array<std::uint8_t, 7>;  ///< rows from the top, 5 bits each, leftmost highest

constexpr std::array<Glyph, 10> kDigits = {{{14, 17, 19, 21, 25, 17, 14},
                                            {4, 12, 4, 4, 4, 4, 14},
                                            {14, 17, 1, 6, 8, 16, 31},
                                            {30, 1, 1, 14, 1, 1, 30},
                                            {2, 6, 10, 18, 31, 2, 2},
                                            {31, 16, 30, 1, 1, 17, 14},
                                            {6, 8, 16, 30, 17, 17, 14},
                                            {31, 1, 2, 4, 4, 4, 4},
                                            {14, 17, 17, 14, 17, 17, 14},
                                            {14, 17, 17, 15, 1, 2, 12}}};
constexpr Glyph kLetterM = {0, 0, 26, 21, 21, 21, 21};
constexpr Glyph kSpace = {};
constexpr int kGlyphAdvance = 6;

const Glyph& glyphOf(char letter)
{
    if (letter >= '0' && letter <= '9')
    {
        return kDigits[static_cast<std::size_t>(letter - '0')];
    }
    return letter == 'm' ? kLetterM : kSpace;
}

void blend(Canvas& canvas, int x, int y, const Ink& ink)
{
    if (x >= 0 && y >= 0 && x < canvas.width && y < canvas.height)
    {
        Color& pixel = canvas.at(x, y);
        pixel += ink.opacity * (ink.color - pixel);
    }
}

/// Inks the pixels of a box around `points`, grown by `margin`, whose centre passes `covers`.
template <typename Covers>
void fillWhere(Canvas& canvas,
               const std::vector<Eigen::Vector2d>& points,
               double margin,
               const Ink& ink,
               const Covers& covers)
{
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& point : points)
    {
        box.extend(point);
    }
    const Eigen::Vector2i low = (box.min().array() - margin).floor().cast<int>().max(0);
    const Eigen::Vector2i high = (box.max().array() + margin)
                                     .ceil()
                                     .cast<int>()
                                     .min(Eigen::Array2i(canvas.width - 1, canvas.height - 1));
    for (int y = low.y(); y <= high.y(); ++y)
    {
        for (int x = low.x(); x <= high.x(); ++x)
        {
            if (covers(Eigen::Vector2d(x + 0.5, y + 0.5)))
            {
                blend(canvas, x, y, ink);
            }
        }
    }
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
    return a.x() * b.y() - a.y() * b.x();
}
}  // namespace

void drawLine(Canvas& canvas,
              const Eigen::Vector2d& from,
              const Eigen::Vector2d& to,
              double width,
              const Ink& ink)
{
    const Eigen::Vector2d along = to - from;
    const double lengthSquared = along.squaredNorm();
    fillWhere(canvas,
              {from, to},
              width,
              ink,
              [&](const Eigen::Vector2d& p)
              {
                  const double s = lengthSquared > 0.0
                                       ? std::clamp((p - from).dot(along) / lengthSquared, 0.0, 1.0)
                                       : 0.0;
                  return (p - from - s * along).norm() <= 0.5 * width;
              });
}

void drawArrowHead(Canvas& canvas,
                   const Eigen::Vector2d& tip,
                   const Eigen::Vector2d& direction,
                   double size,
                   const Ink& ink)
{
    const Eigen::Vector2d back = tip - size * direction;
    const Eigen::Vector2d side = 0.5 * size * Eigen::Vector2d(-direction.y(), direction.x());
    const Eigen::Vector2d a = back + side;
    const Eigen::Vector2d b = back - side;
    fillWhere(canvas,
              {tip, a, b},
              1.0,
              ink,
              [&](const Eigen::Vector2d& p)
              {
                  const double u = cross(a - tip, p - tip);
                  const double v = cross(b - a, p - a);
                  const double w = cross(tip - b, p - b);
                  return (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
              });
}

void drawLabel(
    Canvas& canvas, const std::string& text, const Eigen::Vector2i& place, int cell, const Ink& ink)
{
    for (std::size_t i = 0; i < text.size(); ++i)
    {
        const Glyph& glyph = glyphOf(text[i]);
        const int left = place.x() + static_cast<int>(i) * kGlyphAdvance * cell;
        for (int y = 0; y < 7 * cell; ++y)
        {
            for (int x = 0; x < 5 * cell; ++x)
            {
                if (((glyph[static_cast<std::size_t>(y / cell)] >> (4 - x / cell)) & 1) != 0)
                {
                    blend(canvas, left + x, place.y() + y, ink);
                }
            }
        }
    }
}

int labelWidth(const std::string& text, int cell)
{
    return (static_cast<int>(text.size()) * kGlyphAdvance - 1) * cell;
}

void shrinkInto(Canvas& target, int left, const Canvas& source, int top)
{
    BULLET_CCD_ASSERT(left + source.width / 2 <= target.width);
    BULLET_CCD_ASSERT(top + source.height / 2 <= target.height);
    for (int y = 0; y < source.height / 2; ++y)
    {
        const Color* upper =
            source.pixels.data() + static_cast<std::ptrdiff_t>(2 * y) * source.width;
        const Color* lower = upper + source.width;
        for (int x = 0; x < source.width / 2; ++x)
        {
            target.at(left + x, top + y) =
                0.25F * (upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
        }
    }
}

void writePng(const Canvas& canvas, const std::filesystem::path& file)
{
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * canvas.pixels.size());
    for (const Color& pixel : canvas.pixels)
    {
        for (const float channel : pixel)
        {
            bytes.push_back(
                static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(channel, 0.0F, 1.0F))));
        }
    }
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(canvas.width);
    image.height = static_cast<png_uint_32>(canvas.height);
    image.format = PNG_FORMAT_RGB;
    image.flags = PNG_IMAGE_FLAG_FAST;
    if (png_image_write_to_file(&image, file.c_str(), 0, bytes.data(), 0, nullptr) == 0)
    {
        throw std::runtime_error(file.string() + ": cannot write the picture: " + image.message +
                                 ": check that the folder exists and is writable");
    }
}

Canvas readPng(const std::filesystem::path& file)
{
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    std::vector<std::uint8_t> bytes;
    if (png_image_begin_read_from_file(&image, file.c_str()) != 0)
    {
        image.format = PNG_FORMAT_RGB;
        bytes.resize(PNG_IMAGE_SIZE(image));
    }
    if (bytes.empty() || png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr) == 0)
    {
        throw std::runtime_error(file.string() + ": cannot read the picture: " + image.message +
                                 ": draw it again");
    }
    Canvas canvas(static_cast<int>(image.width), static_cast<int>(image.height));
    for (std::size_t i = 0; i < canvas.pixels.size(); ++i)
    {
        canvas.pixels[i] = Color(static_cast<float>(bytes[3 * i]),
                                 static_cast<float>(bytes[3 * i + 1]),
                                 static_cast<float>(bytes[3 * i + 2])) /
                           255.0F;
    }
    return canvas;
}
}  // namespace bullet_ccd::grasp
