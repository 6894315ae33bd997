#include "bullet_ccd/io/mesh_reader/ply_header.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace bullet_ccd
{
namespace
{
[[noreturn]] void fail(const std::string& name, const std::string& what)
{
    throw std::runtime_error(name + ": " + what + ": export the mesh again");
}

std::vector<std::string> wordsOf(const std::string& line)
{
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;)
    {
        words.push_back(word);
    }
    return words;
}

/// The number that a word of at most 18 digits is.
std::optional<std::int64_t> parseCount(const std::string& word)
{
    const bool isCount = !word.empty() && word.size() <= 18 &&
                         word.find_first_not_of("0123456789") == std::string::npos;
    return isCount ? std::optional<std::int64_t>(std::stoll(word)) : std::nullopt;
}

/// Bytes of a scalar of a binary PLY file; 0 for a type that does not exist.
std::int64_t plyScalarSize(const std::string& type)
{
    constexpr std::array<std::pair<std::string_view, std::int64_t>, 16> kTypes = {{{"char", 1},
                                                                                   {"uchar", 1},
                                                                                   {"int8", 1},
                                                                                   {"uint8", 1},
                                                                                   {"short", 2},
                                                                                   {"ushort", 2},
                                                                                   {"int16", 2},
                                                                                   {"uint16", 2},
                                                                                   {"int", 4},
                                                                                   {"uint", 4},
                                                                                   {"int32", 4},
                                                                                   {"uint32", 4},
                                                                                   {"float", 4},
                                                                                   {"float32", 4},
                                                                                   {"double", 8},
                                                                                   {"float64", 8}}};
    for (const auto& [known, size] : kTypes)
    {
        if (known == type)
        {
            return size;
        }
    }
    return 0;
}

/// What a PLY header promises about the data behind it.
class PlyHeader
{
public:
    explicit PlyHeader(const std::filesystem::path& path) : m_name(path.string())
    {
        std::ifstream stream(path, std::ios::binary);
        std::string line;
        for (int number = 1; std::getline(stream, line); ++number)
        {
            readLine(wordsOf(line), number);
            if (m_isComplete)
            {
                const std::streamoff end = stream.tellg();
                const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
                m_dataBytes = end < 0 ? 0 : size - end;
                return;
            }
        }
        fail(m_name, "PLY header without 'end_header'");
    }

    void requireEnoughData() const
    {
        std::int64_t bytes = 0;
        for (const Element& element : m_elements)
        {
            if (element.count > m_dataBytes)
            {
                fail(m_name,
                     "PLY header promises " + std::to_string(element.count) + " " + element.name +
                         " elements, only " + std::to_string(m_dataBytes) + " bytes follow");
            }
            // In text, a number and its separator are two bytes (the last one may lack the latter).
            bytes += element.count * (m_isBinary ? element.bytes : 2 * element.properties);
        }
        if (bytes > m_dataBytes + 1)
        {
            fail(m_name,
                 "PLY header promises at least " + std::to_string(bytes) + " bytes of data, " +
                     std::to_string(m_dataBytes) + " follow");
        }
    }

private:
    struct Element
    {
        std::string name;
        std::int64_t count = 0;
        std::int64_t properties = 0;
        std::int64_t bytes = 0;  ///< of one element at least: lists may be empty
    };

    void readLine(const std::vector<std::string>& words, int number)
    {
        const std::string keyword = words.empty() ? "" : words[0];
        const auto require = [&](bool condition)
        {
            if (!condition)
            {
                fail(m_name, "line " + std::to_string(number) + " of the PLY header is not valid");
            }
        };
        if (number <= 2)
        {
            require(number == 1 ? words == std::vector<std::string>{"ply"}
                                : keyword == "format" && words.size() == 3 &&
                                      (words[1] == "ascii" || words[1] == "binary_little_endian" ||
                                       words[1] == "binary_big_endian"));
            m_isBinary = number == 2 && words[1] != "ascii";
        }
        else if (keyword == "element")
        {
            require(words.size() == 3 && parseCount(words[2]));
            m_elements.push_back({words[1], *parseCount(words[2]), 0, 0});
        }
        else if (keyword == "property")
        {
            const bool isList = words.size() == 5 && words[1] == "list";
            require(!m_elements.empty() && (isList || words.size() == 3));
            const std::int64_t size = plyScalarSize(words[isList ? 2 : 1]);
            require(size > 0 && (!isList || plyScalarSize(words[3]) > 0));
            m_elements.back().bytes += size;
            ++m_elements.back().properties;
        }
        else
        {
            m_isComplete = words == std::vector<std::string>{"end_header"};
            require(m_isComplete || keyword == "comment" || keyword == "obj_info");
        }
    }

    std::string m_name;
    bool m_isBinary = false;
    bool m_isComplete = false;
    std::int64_t m_dataBytes = 0;
    std::vector<Element> m_elements;
};

}  // namespace

void requirePlausiblePly(const std::filesystem::path& path)
{
    PlyHeader(path).requireEnoughData();
}
}  // namespace bullet_ccd
