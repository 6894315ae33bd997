#include "bullet_ccd/io/off_file.h"

#include "bullet_ccd/io/number_text.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace bullet_ccd
{
namespace
{
/// The words of a text, with comments and white space between them.
class Words
{
public:
    explicit Words(std::string_view text) : m_text(text) {}

    /// The next word, on this line or a later one; empty at the end of the text.
    std::string_view next()
    {
        while (skipBlanks(), isAtLineEnd() && m_at < m_text.size())
        {
            m_line += m_text[m_at] == '\n' ? 1 : 0;
            ++m_at;
        }
        const std::size_t begin = m_at;
        while (m_at < m_text.size() && !isBlank(m_text[m_at]) && !isAtLineEnd() &&
               m_text[m_at] != '#')
        {
            ++m_at;
        }
        return m_text.substr(begin, m_at - begin);
    }

    /// Goes on behind the first `count` letters of the word that next() has just returned.
    void split(std::string_view word, std::size_t count) { m_at -= word.size() - count; }

    /// True if no word follows on this line.
    bool lineIsOver()
    {
        skipBlanks();
        return isAtLineEnd();
    }

    void finishLine()
    {
        while (!isAtLineEnd())
        {
            ++m_at;
        }
    }

    [[nodiscard]] std::int64_t line() const { return m_line; }

private:
    static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
    [[nodiscard]] bool isAtLineEnd() const
    {
        return m_at >= m_text.size() || m_text[m_at] == '\n' || m_text[m_at] == '\r';
    }
    /// Up to a word or the end of the line.
    void skipBlanks()
    {
        while (m_at < m_text.size() && isBlank(m_text[m_at]))
        {
            ++m_at;
        }
        if (m_at < m_text.size() && m_text[m_at] == '#')
        {
            finishLine();
        }
    }

    std::string_view m_text;
    std::size_t m_at = 0;
    std::int64_t m_line = 1;
};

/// The format does not say how many colours a vertex or a face has: what is left of their line.
/// But some writers put several on a line.
struct Layout
{
    bool vertexEndsItsLine = false;  ///< else what the keyword promises follows its coordinates
    bool faceEndsItsLine = true;     ///< else nothing follows its corners
};

class OffReader
{
public:
    OffReader(std::string_view text, std::string name) : m_words(text), m_name(std::move(name))
    {
        readKeyword();
        m_vertices = readCount("number of vertices");
        m_faces = readCount("number of faces");
        skipEdges();
    }

    /// Throws if the text does not come out even.
    [[nodiscard]] PolygonSoup read(const Layout& layout)
    {
        for (std::int64_t i = 0; i < m_vertices; ++i)
        {
            readVertex(layout);
        }
        for (std::int64_t i = 0; i < m_faces; ++i)
        {
            readFace(layout);
        }
        if (const std::string_view rest = m_words.next(); !rest.empty())
        {
            m_facesBegun = 0;
            fail(quoted(rest) + " stands behind the last of " + std::to_string(m_vertices) +
                 " vertices and " + std::to_string(m_faces) + " faces");
        }
        return std::move(m_soup);
    }

private:
    /// [ST][C][N][4][n]OFF, or nothing; the first number may follow without a space.
    void readKeyword()
    {
        const Words start = m_words;
        const std::string_view word = m_words.next();
        const std::size_t end = word.find("OFF");
        if (end == std::string_view::npos)
        {
            m_words = start;
            return;
        }
        m_words.split(word, end + 3);
        std::string_view prefix = word.substr(0, end);
        const auto take = [&](std::string_view letters)
        {
            const bool isThere = prefix.substr(0, letters.size()) == letters;
            prefix.remove_prefix(isThere ? letters.size() : 0);
            return isThere;
        };
        const int texture = take("ST") ? 2 : 0;
        const int color = take("C") ? 4 : 0;
        const bool hasNormal = take("N");
        m_isHomogeneous = take("4");
        const bool hasDimension = take("n");
        if (!prefix.empty())
        {
            fail(quoted(word) + " is no kind of OFF");
        }
        const Words behind = m_words;
        if (m_words.next() == "BINARY")
        {
            throw std::runtime_error(m_name + ": binary OFF: convert it to text OFF or to OBJ");
        }
        m_words = behind;
        m_dimension = hasDimension ? readCount("dimension") : 3;
        if (m_dimension < 1 || m_dimension > 3)
        {
            fail("dimension " + std::to_string(m_dimension) + " is not in [1, 3]");
        }
        m_extras = texture + color + (hasNormal ? static_cast<int>(m_dimension) : 0);
    }

    /// The third number of the header counts edges, is of no use and may be missing.
    void skipEdges()
    {
        const Words start = m_words;
        const bool isOnThisLine = !m_words.lineIsOver();
        m_words.next();
        if (!isOnThisLine && !m_words.lineIsOver())
        {
            m_words = start;
        }
    }

    std::int64_t readCount(const char* what)
    {
        const std::string_view word = m_words.next();
        const std::optional<std::int64_t> count = parseNumber<std::int64_t>(word);
        if (!count || *count < 0 || *count > std::numeric_limits<std::int32_t>::max())
        {
            fail(std::string(what) + " is " + said(word) + ", a whole number below 2^31 is needed");
        }
        return *count;
    }

    double readCoordinate(std::size_t k)
    {
        const std::string_view word = m_words.next();
        const std::optional<double> number = parseNumber<double>(word);
        if (!number)
        {
            fail("vertex " + std::to_string(m_soup.vertices.size()) + " of " +
                 std::to_string(m_vertices) + ": coordinate " + "xyzw"[k] + " is " + said(word) +
                 ", a number of double range is needed");
        }
        return *number;
    }

    void readVertex(const Layout& layout)
    {
        Eigen::Vector3d point = Eigen::Vector3d::Zero();
        for (int k = 0; k < m_dimension; ++k)
        {
            point[k] = readCoordinate(static_cast<std::size_t>(k));
        }
        if (m_isHomogeneous)
        {
            point /= readCoordinate(3);
        }
        m_soup.vertices.push_back(point);
        if (layout.vertexEndsItsLine)
        {
            m_words.finishLine();
            return;
        }
        for (int k = 0; k < m_extras; ++k)
        {
            m_words.next();
        }
    }

    void readFace(const Layout& layout)
    {
        ++m_facesBegun;
        const std::int64_t corners = readCount("corner count");
        const std::size_t begin = m_soup.corners.size();
        for (std::int64_t k = 0; k < corners; ++k)
        {
            const std::string_view word = m_words.next();
            const std::optional<std::int64_t> corner = parseNumber<std::int64_t>(word);
            if (!corner || *corner < 0 || *corner >= m_vertices)
            {
                fail("corner " + std::to_string(k) + " is " + said(word) + ", a vertex in [0, " +
                     std::to_string(m_vertices) + ") is needed");
            }
            m_soup.corners.push_back(static_cast<std::int32_t>(*corner));
        }
        if (corners < 3)
        {
            m_soup.corners.resize(begin);
            ++m_soup.droppedElements;
        }
        else
        {
            m_soup.polygonEnds.push_back(m_soup.corners.size());
        }
        if (layout.faceEndsItsLine)
        {
            m_words.finishLine();
        }
    }

    static std::string said(std::string_view word)
    {
        return word.empty() ? "missing" : quoted(word);
    }

    [[noreturn]] void fail(const std::string& what) const
    {
        const std::string place =
            m_facesBegun == 0 ? "" : "face " + std::to_string(m_facesBegun - 1) + ": ";
        throw std::runtime_error(m_name + ": line " + std::to_string(m_words.line()) + ": " +
                                 place + what + ": correct the line or export the mesh again");
    }

    Words m_words;
    std::string m_name;
    bool m_isHomogeneous = false;
    int m_extras = 0;  ///< numbers behind the coordinates of a vertex, by the keyword
    std::int64_t m_dimension = 3;
    std::int64_t m_vertices = 0;
    std::int64_t m_faces = 0;
    std::int64_t m_facesBegun = 0;
    PolygonSoup m_soup;
};
}  // namespace

PolygonSoup readOff(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    std::ostringstream content;
    content << file.rdbuf();
    if (!file || !content)
    {
        throw std::runtime_error(path.string() + ": cannot be read: check its permissions");
    }
    const std::string text = std::move(content).str();
    // Only the right layout uses the text up exactly; the first one is what the format says, so it
    // is the one to complain about.
    constexpr std::array<Layout, 4> kLayouts = {
        {{false, true}, {true, true}, {false, false}, {true, false}}};
    const OffReader start(text, path.string());
    std::string complaint;
    for (const Layout& layout : kLayouts)
    {
        try
        {
            return OffReader(start).read(layout);
        }
        catch (const std::runtime_error& error)
        {
            complaint = complaint.empty() ? error.what() : complaint;
        }
    }
    throw std::runtime_error(complaint);
}
}  // namespace bullet_ccd
