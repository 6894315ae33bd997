#include "grasp/hand/searched_hand.h"

#include "bullet_ccd/math/replace_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/hand/hash.h"
#include "grasp/hand/search_version.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <system_error>

namespace bullet_ccd::grasp
{
namespace
{
namespace fs = std::filesystem;

constexpr const char* kHeader = "bullet_ccd_searched_hand";

/// Empty if there is no such file.
std::string contentOf(const fs::path& path)
{
    std::error_code error;
    if (!fs::is_regular_file(path, error))
    {
        return {};  // reading a folder throws
    }
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string hashOf(const std::string& text)
{
    Hash hash;
    hash.add(text);
    return hexadecimal(hash.value());
}

/// The shortest digits that are read as the same number.
std::string numbersText(std::span<const double> numbers)
{
    std::string text;
    for (const double number : numbers)
    {
        std::array<char, 32> digits{};
        text += ' ';
        text.append(digits.data(),
                    std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
    }
    return text;
}

std::string frameText(const Eigen::Isometry3d& X)
{
    return numbersText({X.matrix().data(), static_cast<std::size_t>(X.matrix().size())});
}

/// Words between spaces; after a wrong one all is wrong.
class Words
{
public:
    explicit Words(const std::string& text) : m_text(text) {}

    [[nodiscard]] bool isGood() const { return m_isGood; }
    /// True if there is one more.
    [[nodiscard]] bool next(std::string& word) { return static_cast<bool>(m_text >> word); }

    std::vector<double> numbers(std::size_t count)
    {
        std::vector<double> numbers;
        while (m_isGood && numbers.size() < count)
        {
            std::string word;
            double number = 0.0;
            m_isGood = next(word);
            const char* const end = word.data() + word.size();
            const auto [to, error] = std::from_chars(word.data(), end, number);
            m_isGood = m_isGood && error == std::errc{} && to == end && std::isfinite(number);
            numbers.push_back(number);
        }
        return numbers;
    }

    Eigen::Isometry3d frame()
    {
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        const std::vector<double> entries = numbers(static_cast<std::size_t>(X.matrix().size()));
        if (m_isGood)
        {
            std::ranges::copy(entries, X.matrix().data());
        }
        return X;
    }

private:
    std::istringstream m_text;
    bool m_isGood = true;
};
}  // namespace

std::string searchedHandFileName(const RobotModel& robot, const fs::path& srdf)
{
    Hash hash;
    hash.add(std::string(BULLET_CCD_VERSION));
    hash.add(std::string(kSearchVersion));
    hash.add(contentOf(srdf));
    for (std::size_t link = 0; link < robot.tree.size(); ++link)
    {
        hash.add(robot.tree.links[link]);
        hash.add(contentHash(robot.linkMeshes[link]));
    }
    return hexadecimal(hash.value()) + ".hand";
}

std::optional<SearchedHand> loadSearchedHand(const fs::path& file, std::size_t links)
{
    std::istringstream content(contentOf(file));
    std::string header;
    std::string hash;
    content >> header >> hash;
    const bool isLine = content.get() == '\n';
    const std::string text{std::istreambuf_iterator<char>(content),
                           std::istreambuf_iterator<char>()};
    if (!isLine || header != kHeader || hash != hashOf(text))
    {
        return std::nullopt;
    }
    Words words(text);
    SearchedHand hand;
    for (std::string what; words.isGood() && words.next(what);)
    {
        if (what == "speeds")
        {
            hand.speeds = words.numbers(links);
        }
        else if (what == "frame")
        {
            hand.frames.push_back(words.frame());
        }
        else if (std::string name; what.starts_with("preshape") && words.next(name))
        {
            hand.preshapes.push_back({.name = name, .positions = words.numbers(links)});
            if (what == "preshape_with_frame")
            {
                hand.preshapes.back().X_RG = words.frame();
            }
        }
        else
        {
            return std::nullopt;
        }
    }
    return words.isGood() ? std::optional(std::move(hand)) : std::nullopt;
}

void saveSearchedHand(const SearchedHand& hand, const fs::path& file)
{
    std::string text;
    for (const Preshape& preshape : hand.preshapes)
    {
        text += (preshape.X_RG ? "preshape_with_frame " : "preshape ") + preshape.name +
                numbersText(preshape.positions) +
                (preshape.X_RG ? frameText(*preshape.X_RG) : std::string()) + '\n';
    }
    for (const Eigen::Isometry3d& frame : hand.frames)
    {
        text += "frame" + frameText(frame) + '\n';
    }
    if (!hand.speeds.empty())
    {
        text += "speeds" + numbersText(hand.speeds) + '\n';
    }
    const std::string header = std::string(kHeader) + ' ' + hashOf(text) + '\n';
    std::error_code ignored;  // the search is repeated next time
    fs::create_directories(file.parent_path(), ignored);
    ignored = replaceFile(file, {header, text});
}
}  // namespace bullet_ccd::grasp
