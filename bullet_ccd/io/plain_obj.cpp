#include "bullet_ccd/io/plain_obj.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <oneapi/tbb/parallel_for.h>
#include <span>
#include <string_view>
#include <unistd.h>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
constexpr std::size_t kPieceBytes = std::size_t{1} << 18U;
/// Pieces that are read before what they say is collected.
constexpr std::size_t kPieces = 16;
constexpr std::size_t kLeastBytes = std::size_t{1} << 20U;

/// A file that is open for reading by several threads.
class OpenFile
{
public:
    explicit OpenFile(const std::filesystem::path& path)
        : m_descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC))
    {
    }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    ~OpenFile()
    {
        if (m_descriptor >= 0)
        {
            ::close(m_descriptor);
        }
    }

    /// 0 if it cannot be read.
    [[nodiscard]] std::size_t size() const
    {
        const off_t end = m_descriptor < 0 ? -1 : ::lseek(m_descriptor, 0, SEEK_END);
        return end > 0 ? static_cast<std::size_t>(end) : 0;
    }
    /// Reads bytes from an offset; returns how many: fewer at the end of the file, or if they
    /// cannot be read.
    std::size_t read(std::span<char> bytes, std::size_t offset) const
    {
        std::size_t got = 0;
        while (got < bytes.size())
        {
            const ssize_t more = ::pread(m_descriptor,
                                         bytes.data() + got,
                                         bytes.size() - got,
                                         static_cast<off_t>(offset + got));
            if (more <= 0)
            {
                break;
            }
            got += static_cast<std::size_t>(more);
        }
        return got;
    }

private:
    int m_descriptor;
};

/// The lines of a piece of the file, and what they say.
class Piece
{
public:
    /// Reads the lines that begin in a part of the file. Returns false for anything unusual.
    bool read(const OpenFile& file, std::size_t begin, std::size_t end)
    {
        vertices.clear();
        triangles.clear();
        if (begin == end)
        {
            return true;
        }
        std::vector<char>& buffer = m_buffer;
        const std::size_t from = begin == 0 ? 0 : begin - 1;  // does a line begin there?
        std::size_t size = end - from;
        buffer.resize(std::max(buffer.size(), size + 1));
        if (file.read(std::span(buffer).first(size), from) < size)
        {
            return false;  // it was cut off meanwhile
        }
        while (buffer[size - 1] != '\n')
        {
            constexpr std::size_t kMore = 1U << 12;
            buffer.resize(std::max(buffer.size(), size + kMore + 1));
            const auto rest = std::span(buffer).subspan(size, kMore);
            const std::size_t got = file.read(rest, from + size);
            const auto lineEnd = std::ranges::find(rest.first(got), '\n');
            size += static_cast<std::size_t>(lineEnd - rest.begin());
            if (got < kMore || lineEnd != rest.end())
            {
                buffer[size++] = '\n';  // the last line may have none
            }
        }
        std::string_view lines(buffer.data(), size);
        if (begin > 0)
        {
            lines.remove_prefix(lines.find('\n') + 1);
        }
        else if (lines.starts_with("\xEF\xBB\xBF"))  // of UTF-8
        {
            lines.remove_prefix(3);
        }
        const char* at = lines.data();
        const char* const last = at + lines.size();
        while (at < last)
        {
            const char* const lineEnd = static_cast<const char*>(
                std::memchr(at, '\n', static_cast<std::size_t>(last - at)));
            if (!readLine(at, lineEnd))
            {
                return false;
            }
            at = lineEnd + 1;
        }
        return true;
    }

    std::vector<Eigen::Vector3d> vertices{};
    std::vector<Triangle> triangles{};
    std::int64_t droppedElements = 0;
    std::int32_t largest = 0;  ///< number of a vertex, counted from 1

private:
    static bool isBlank(char c)
    {
        return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
    }
    static const char* skipBlanks(const char* at, const char* end)
    {
        while (at < end && isBlank(*at))
        {
            ++at;
        }
        return at;
    }
    static bool endsWord(const char* at, const char* end)
    {
        return at == end || isBlank(*at) || *at == '#';
    }

    bool readLine(const char* at, const char* end)
    {
        while (end > at && end[-1] == '\r')
        {
            --end;
        }
        if (end > at && end[-1] == '\\')
        {
            return false;  // it goes on
        }
        at = skipBlanks(at, end);
        if (at == end || !endsWord(at + 1, end))
        {
            return true;  // nothing, or a longer keyword
        }
        switch (*at)
        {
            case 'v':
                return readVertex(at + 1, end);
            case 'f':
                return readFace(at + 1, end);
            case 'l':
            case 'p':
                ++droppedElements;
                return true;
            default:
                return true;
        }
    }

    bool readVertex(const char* at, const char* end)
    {
        Eigen::Vector3d& point = vertices.emplace_back();
        for (double& coordinate : point)
        {
            at = skipBlanks(at, end);
            const auto [stop, error] = std::from_chars(at, end, coordinate);
            if (error != std::errc{} || !endsWord(stop, end))
            {
                return false;
            }
            at = stop;
        }
        return true;
    }

    bool readFace(const char* at, const char* end)
    {
        Triangle& triangle = triangles.emplace_back();
        std::size_t count = 0;
        for (at = skipBlanks(at, end); at < end && *at != '#'; at = skipBlanks(at, end))
        {
            constexpr int kMostDigits = 9;
            const char* const word = at;
            std::int32_t number = 0;
            while (at < end && *at >= '0' && *at <= '9')
            {
                if (at - word == kMostDigits)
                {
                    return false;
                }
                number = number * 10 + (*at++ - '0');
            }
            if (number == 0 || count == triangle.size() || !(endsWord(at, end) || *at == '/'))
            {
                return false;
            }
            while (!endsWord(at, end))
            {
                ++at;
            }
            triangle[count++] = number - 1;
            largest = std::max(largest, number);
        }
        return count == triangle.size();
    }

    std::vector<char> m_buffer;
};

}  // namespace

std::optional<PlainObj> readPlainObj(const std::filesystem::path& path)
{
    const OpenFile file(path);
    const std::size_t bytes = file.size();
    if (bytes < kLeastBytes)
    {
        return std::nullopt;
    }
    PlainObj obj;
    // More than a file of this size can hold, of which the memory that is not used costs nothing.
    constexpr std::size_t kShortestLine = 8;
    obj.mesh.vertices.reserve(bytes / kShortestLine + 1);
    obj.mesh.triangles.reserve(bytes / kShortestLine + 1);
    std::vector<Piece> pieces(kPieces);
    std::int32_t largest = 0;
    for (std::size_t start = 0; start < bytes; start += kPieces * kPieceBytes)
    {
        std::atomic<bool> isPlain = true;
        tbb::parallel_for(std::size_t{0},
                          kPieces,
                          [&](std::size_t i)
                          {
                              const std::size_t begin = std::min(start + i * kPieceBytes, bytes);
                              const std::size_t end = std::min(begin + kPieceBytes, bytes);
                              if (!pieces[i].read(file, begin, end))
                              {
                                  isPlain = false;
                              }
                          });
        if (!isPlain)
        {
            return std::nullopt;
        }
        for (const Piece& piece : pieces)
        {
            obj.mesh.vertices.insert(
                obj.mesh.vertices.end(), piece.vertices.begin(), piece.vertices.end());
            obj.mesh.triangles.insert(
                obj.mesh.triangles.end(), piece.triangles.begin(), piece.triangles.end());
            largest = std::max(largest, piece.largest);
        }
    }
    for (const Piece& piece : pieces)
    {
        obj.droppedElements += piece.droppedElements;
    }
    if (static_cast<std::size_t>(largest) > obj.mesh.vertices.size())
    {
        return std::nullopt;
    }
    return obj;
}
}  // namespace bullet_ccd
