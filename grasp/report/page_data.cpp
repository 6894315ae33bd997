#include "grasp/report/page_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace bullet_ccd::grasp
{
double rounded(double value)
{
    return std::round(value * 1e6) / 1e6;
}

PageJson poseList(const Eigen::Isometry3d& X)
{
    const Eigen::Quaterniond q = Eigen::Quaterniond(X.linear()).normalized();
    const Eigen::Vector3d& p = X.translation();
    return PageJson::array({p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
}

std::string hexColor(const Color& color)
{
    std::array<char, 8> text{};
    std::array<unsigned, 3> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i)
    {
        const float value = std::clamp(color[static_cast<Eigen::Index>(i)], 0.0F, 1.0F);
        bytes[i] = static_cast<unsigned>(std::lround(255.0F * value));
    }
    std::snprintf(text.data(), text.size(), "#%02x%02x%02x", bytes[0], bytes[1], bytes[2]);
    return text.data();
}

std::size_t MeshList::add(const TriangleMesh& mesh)
{
    const PackedMesh packed = packMesh(mesh);
    const auto found = std::find(m_meshes.begin(), m_meshes.end(), packed);
    if (found == m_meshes.end())
    {
        m_meshes.push_back(packed);
        return m_meshes.size() - 1;
    }
    return static_cast<std::size_t>(found - m_meshes.begin());
}

PageJson MeshList::json() const
{
    PageJson list = PageJson::array();
    for (const PackedMesh& mesh : m_meshes)
    {
        list.push_back({{"origin", {mesh.origin.x(), mesh.origin.y(), mesh.origin.z()}},
                        {"step", {mesh.step.x(), mesh.step.y(), mesh.step.z()}},
                        {"points", mesh.points},
                        {"triangles", mesh.triangles}});
    }
    return list;
}

std::string scriptText(const PageJson& json)
{
    const std::string text =
        json.dump(-1, ' ', false, PageJson::error_handler_t::replace);  // names may be no UTF-8
    std::string result;
    result.reserve(text.size());
    for (const char letter : text)
    {
        result += letter == '<' ? std::string("\\u003c") : std::string(1, letter);
    }
    return result;
}

std::string filledTemplate(const std::filesystem::path& file,
                           const std::vector<std::pair<std::string, std::string>>& marks)
{
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::string filled;
    std::size_t from = 0;
    for (const auto& [mark, value] : marks)
    {
        const std::size_t at = text.find(mark, from);
        if (!in || at == std::string::npos)
        {
            throw std::runtime_error(file.string() +
                                     ": is not the viewer of the page: build the target viewer, or "
                                     "remove the file to get the page of pictures");
        }
        filled += text.substr(from, at - from) + value;
        from = at + mark.size();
    }
    return filled + text.substr(from);
}
}  // namespace bullet_ccd::grasp
