#include "bullet_ccd/io/obj_file.h"

#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/number_text.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // of UTF-8

bool isBlank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// Cuts the next blank-separated word off `line`; empty at its end.
std::string_view nextWord(std::string_view& line)
{
    const auto begin = std::find_if_not(line.begin(), line.end(), isBlank);
    const auto end = std::find_if(begin, line.end(), isBlank);
    const std::string_view word(begin, end);
    line = std::string_view(end, line.end());
    return word;
}

class ObjReader
{
    struct Reference
    {
        std::int64_t line = 0;
        std::int64_t vertex = 0;  ///< counted from 1
    };

public:
    explicit ObjReader(const std::filesystem::path& path) : m_path(path) {}

    PolygonSoup read()
    {
        std::ifstream file(m_path, std::ios::binary);
        std::string line;
        std::string continuation;
        while (std::getline(file, continuation))
        {
            ++m_line;
            if (m_line == 1 && continuation.starts_with(kByteOrderMark))
            {
                continuation.erase(0, kByteOrderMark.size());
            }
            while (!continuation.empty() && continuation.back() == '\r')
            {
                continuation.pop_back();
            }
            line += continuation;
            if (!line.empty() && line.back() == '\\')
            {
                line.back() = ' ';
                continue;
            }
            readLine(line);
            line.clear();
        }
        readLine(line);
        if (file.bad() || !file.eof())
        {
            throw std::runtime_error(m_path.string() +
                                     ": cannot be read: check that it is a readable file");
        }
        checkAhead();
        return std::move(m_soup);
    }

private:
    void readLine(std::string_view line)
    {
        line = line.substr(0, line.find('#'));
        const std::string_view keyword = nextWord(line);
        if (keyword == "v")
        {
            readVertex(line);
        }
        else if (keyword == "f")
        {
            readFace(line);
        }
        else if (keyword == "l" || keyword == "p")
        {
            ++m_soup.droppedElements;
        }
    }

    void readVertex(std::string_view line)
    {
        Eigen::Vector3d point;
        for (int k = 0; k < 3; ++k)
        {
            const std::string_view word = nextWord(line);
            const std::optional<double> number = parseNumber<double>(word);
            if (!number)
            {
                fail("vertex " + std::to_string(m_soup.vertices.size() + 1) + ": coordinate " +
                     "xyz"[k] + " is " + (word.empty() ? "missing" : quoted(word)) +
                     ", a number of double range is needed");
            }
            point[k] = *number;
        }
        m_soup.vertices.push_back(point);
    }

    void readFace(std::string_view line)
    {
        const auto count = static_cast<std::int64_t>(m_soup.vertices.size());
        std::size_t corners = 0;
        for (std::string_view word = nextWord(line); !word.empty(); word = nextWord(line))
        {
            const std::optional<std::int64_t> number = parseNumber<std::int64_t>(word, true);
            const bool isValid = number && *number != 0 && *number >= -count &&
                                 *number <= std::numeric_limits<std::int32_t>::max();
            if (!isValid)
            {
                fail("face: corner " + quoted(word) + " is no vertex (" + std::to_string(count) +
                     " vertices so far, counted from 1)");
            }
            if (*number > count)
            {
                m_ahead.push_back({m_line, *number});
            }
            m_soup.corners.push_back(
                static_cast<std::int32_t>(*number > 0 ? *number - 1 : *number + count));
            ++corners;
        }
        if (corners < 3)
        {
            fail("face has " + std::to_string(corners) + " corners, at least 3 are needed");
        }
        m_soup.polygonEnds.push_back(m_soup.corners.size());
    }

    void checkAhead()
    {
        const auto count = static_cast<std::int64_t>(m_soup.vertices.size());
        for (const Reference& reference : m_ahead)
        {
            if (reference.vertex > count)
            {
                m_line = reference.line;
                fail("face refers to vertex " + std::to_string(reference.vertex) +
                     ", but the file has " + std::to_string(count));
            }
        }
    }

    [[noreturn]] void fail(const std::string& what) const
    {
        throw std::runtime_error(m_path.string() + ": line " + std::to_string(m_line) + ": " +
                                 what + ": correct the line or export the mesh again");
    }

    std::filesystem::path m_path;
    std::int64_t m_line = 0;
    std::vector<Reference> m_ahead;  ///< may come true: faces may precede their vertices
    PolygonSoup m_soup;
};
}  // namespace

PolygonSoup readObj(const std::filesystem::path& path)
{
    return ObjReader(path).read();
}

void writeObj(const TriangleMesh& mesh, const std::filesystem::path& path)
{
    std::string text;
    char digits[32];
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        text += 'v';
        for (int k = 0; k < 3; ++k)
        {
            const std::to_chars_result end =
                std::to_chars(digits, digits + sizeof(digits), vertex[k]);
            text += ' ';
            text.append(digits, end.ptr);
        }
        text += '\n';
    }
    for (const Triangle& triangle : mesh.triangles)
    {
        text += 'f';
        for (const std::int32_t corner : triangle)
        {
            text += ' ' + std::to_string(corner + 1);
        }
        text += '\n';
    }
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file)
    {
        throw std::runtime_error(path.string() +
                                 ": cannot be written: check that the folder exists, is writable "
                                 "and has space");
    }
}
}  // namespace bullet_ccd
