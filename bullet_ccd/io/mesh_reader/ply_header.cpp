#include "bullet_ccd/io/mesh_reader/ply_header.h"

#include <algorithm>
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
                if (!m_isBinary && m_dataBytes > 0)
                {
                    m_text.resize(static_cast<std::size_t>(m_dataBytes));
                    stream.read(m_text.data(), m_dataBytes);
                }
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
            bytes +=
                element.count *
                (m_isBinary ? element.bytes : 2 * static_cast<std::int64_t>(element.isList.size()));
        }
        if (bytes > m_dataBytes + 1)
        {
            fail(m_name,
                 "PLY header promises at least " + std::to_string(bytes) + " bytes of data, " +
                     std::to_string(m_dataBytes) + " follow");
        }
    }

    /// Text may end early although its numbers are many enough in all. Assimp would fill what is
    /// missing with copies.
    void requireWholeText() const
    {
        std::string_view rest = m_text;
        for (const Element& element : m_elements)
        {
            for (std::int64_t i = 0; !m_isBinary && i < element.count; ++i)
            {
                for (const bool isList : element.isList)
                {
                    const std::optional<std::int64_t> words =
                        isList ? parseCount(std::string(nextWord(rest))) : 1;
                    for (std::int64_t k = 0; k < words.value_or(0); ++k)
                    {
                        if (nextWord(rest).empty())
                        {
                            fail(m_name,
                                 "the file ends in " + element.name + " " + std::to_string(i) +
                                     " of " + std::to_string(element.count));
                        }
                    }
                    if (!words && rest.empty())
                    {
                        fail(m_name,
                             "the file ends before " + element.name + " " + std::to_string(i) +
                                 " of " + std::to_string(element.count));
                    }
                }
            }
        }
    }

private:
    struct Element
    {
        std::string name;
        std::int64_t count = 0;
        std::int64_t bytes = 0;      ///< of one element at least: lists may be empty
        std::vector<bool> isList{};  ///< for each property
    };

    static std::string_view nextWord(std::string_view& text)
    {
        constexpr std::string_view kBlanks = " \t\r\n\v\f";
        text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
        const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
        text.remove_prefix(word.size());
        return word;
    }

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
            m_elements.push_back({words[1], *parseCount(words[2])});
        }
        else if (keyword == "property")
        {
            const bool isList = words.size() == 5 && words[1] == "list";
            require(!m_elements.empty() && (isList || words.size() == 3));
            const std::int64_t size = plyScalarSize(words[isList ? 2 : 1]);
            require(size > 0 && (!isList || plyScalarSize(words[3]) > 0));
            m_elements.back().bytes += size;
            m_elements.back().isList.push_back(isList);
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
    std::string m_text;  ///< behind the header, unless that is binary
};

}  // namespace

void requirePlausiblePly(const std::filesystem::path& path)
{
    const PlyHeader header(path);
    header.requireEnoughData();
    header.requireWholeText();
}
}  // namespace bullet_ccd
