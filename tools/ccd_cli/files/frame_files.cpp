#include "tools/ccd_cli/files/frame_files.h"

#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/io/obj_file.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;

/// Digits count as one number, so that frame 10 comes after frame 9.
bool naturalLess(const std::string& a, const std::string& b)
{
    const auto isDigit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < a.size() && j < b.size())
    {
        if (isDigit(a[i]) && isDigit(b[j]))
        {
            const auto number = [&](const std::string& text, std::size_t& at)
            {
                const std::size_t begin = std::min(text.find_first_not_of('0', at), text.size());
                at = begin;
                while (at < text.size() && isDigit(text[at]))
                {
                    ++at;
                }
                return std::pair(at - begin, text.substr(begin, at - begin));
            };
            const auto numberA = number(a, i);
            const auto numberB = number(b, j);
            if (numberA != numberB)
            {
                return numberA < numberB;
            }
            continue;
        }
        if (a[i] != b[j])
        {
            return a[i] < b[j];
        }
        ++i;
        ++j;
    }
    return a.size() - i < b.size() - j;
}
}  // namespace

bool FrameFile::hasTopologyOf(const FrameFile& other) const
{
    return soup.vertices.size() == other.soup.vertices.size() &&
           soup.polygonEnds == other.soup.polygonEnds && soup.corners == other.soup.corners;
}

TriangleMesh FrameFile::triangles() const
{
    return triangulate(soup, path.string());
}

FrameFile readFrame(const fs::path& path)
{
    if (path.extension() != ".obj" && path.extension() != ".OBJ")
    {
        throw std::runtime_error(path.string() +
                                 ": is no OBJ file: frames are OBJ files, whose vertices keep "
                                 "their order; export the mesh as OBJ");
    }
    FrameFile frame{.path = path, .soup = readObj(path)};
    if (frame.soup.polygonEnds.empty())
    {
        throw std::runtime_error(path.string() + ": has no faces: give a mesh");
    }
    for (std::size_t v = 0; v < frame.soup.vertices.size(); ++v)
    {
        const Eigen::Vector3d& x = frame.soup.vertices[v];
        if (!isPlace(x))
        {
            throw std::runtime_error(
                fmt::format("{}: vertex {} (from 1) is at ({}, {}, {}): give finite coordinates "
                            "within {:g}",
                            path.string(),
                            v + 1,
                            x.x(),
                            x.y(),
                            x.z(),
                            kLargestCoordinate));
        }
    }
    return frame;
}

void requireSameTopology(const FrameFile& start, const FrameFile& end)
{
    if (end.hasTopologyOf(start))
    {
        return;
    }
    const std::string places = fmt::format("{}: ", end.path.string());
    const std::string before = start.path.string();
    const char* const remedy =
        "both frames of a step need the same mesh with moved vertices; where the mesh changes, "
        "begin "
        "another pair of frames";
    if (start.soup.vertices.size() != end.soup.vertices.size())
    {
        throw std::runtime_error(fmt::format("{}{} vertices instead of {} as in {}: {}",
                                             places,
                                             end.soup.vertices.size(),
                                             start.soup.vertices.size(),
                                             before,
                                             remedy));
    }
    if (start.soup.polygonEnds.size() != end.soup.polygonEnds.size())
    {
        throw std::runtime_error(fmt::format("{}{} faces instead of {} as in {}: {}",
                                             places,
                                             end.soup.polygonEnds.size(),
                                             start.soup.polygonEnds.size(),
                                             before,
                                             remedy));
    }
    std::size_t face = 0;
    std::size_t begin = 0;
    for (; face + 1 < end.soup.polygonEnds.size(); ++face)
    {
        const std::size_t last = end.soup.polygonEnds[face];
        if (start.soup.polygonEnds[face] != last ||
            !std::equal(end.soup.corners.begin() + static_cast<std::ptrdiff_t>(begin),
                        end.soup.corners.begin() + static_cast<std::ptrdiff_t>(last),
                        start.soup.corners.begin() + static_cast<std::ptrdiff_t>(begin)))
        {
            break;
        }
        begin = last;
    }
    throw std::runtime_error(fmt::format(
        "{}face {} has other corners than in {}: {}", places, face + 1, before, remedy));
}

std::vector<fs::path> framesOf(const std::string& pattern)
{
    const fs::path folder = fs::path(pattern).parent_path();
    const std::string name = fs::path(pattern).filename().string();
    const std::size_t star = name.find('*');
    if (star == std::string::npos || name.find('*', star + 1) != std::string::npos)
    {
        throw std::runtime_error(pattern +
                                 ": needs one * in the name of the files, such as "
                                 "'frames/cloth_*.obj'");
    }
    const std::string head = name.substr(0, star);
    const std::string tail = name.substr(star + 1);
    std::vector<fs::path> frames;
    std::error_code error;
    for (const fs::directory_entry& entry :
         fs::directory_iterator(folder.empty() ? fs::path(".") : folder, error))
    {
        const std::string file = entry.path().filename().string();
        if (file.size() >= head.size() + tail.size() && file.starts_with(head) &&
            file.ends_with(tail))
        {
            frames.push_back(folder / file);
        }
    }
    std::ranges::sort(frames,
                      [](const fs::path& a, const fs::path& b)
                      { return naturalLess(a.filename().string(), b.filename().string()); });
    if (frames.size() < 2)
    {
        throw std::runtime_error(
            fmt::format("{}: {} file{} of that name: a sequence has at least two frames",
                        pattern,
                        frames.size(),
                        frames.size() == 1 ? "" : "s"));
    }
    return frames;
}

std::vector<std::int32_t> connectedParts(const TriangleMesh& mesh)
{
    std::vector<std::int32_t> parents(mesh.vertices.size());
    std::iota(parents.begin(), parents.end(), 0);
    const auto parentOf = [&](std::int32_t v) -> std::int32_t&
    { return parents[static_cast<std::size_t>(v)]; };
    const auto find = [&](std::int32_t v)
    {
        while (parentOf(v) != v)
        {
            v = parentOf(v) = parentOf(parentOf(v));
        }
        return v;
    };
    std::vector<bool> isUsed(mesh.vertices.size(), false);
    for (const Triangle& t : mesh.triangles)
    {
        for (const std::int32_t v : t)
        {
            isUsed[static_cast<std::size_t>(v)] = true;
            const std::int32_t a = find(v);
            const std::int32_t b = find(t[0]);
            parentOf(std::max(a, b)) = std::min(a, b);
        }
    }
    std::vector<std::int32_t> parts(mesh.vertices.size(), kNone);
    std::int32_t count = 0;
    for (std::size_t v = 0; v < parts.size(); ++v)
    {
        if (isUsed[v])
        {
            const std::int32_t root = find(static_cast<std::int32_t>(v));
            parts[v] = static_cast<std::size_t>(root) == v ? count++
                                                           : parts[static_cast<std::size_t>(root)];
        }
    }
    return parts;
}
}  // namespace bullet_ccd::tools
