#include "tools/support/yaml_file.h"

#include "bullet_ccd/io/nearest_name.h"
#include "tools/support/pose_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::tools
{
YAML::Node YamlFile::load(const std::string& remedy) const
{
    try
    {
        return YAML::LoadFile(m_path.string());
    }
    catch (const YAML::BadFile&)
    {
        throw std::runtime_error(m_path.string() + ": cannot be read: " + remedy);
    }
    catch (const YAML::ParserException& error)
    {
        throw std::runtime_error(fmt::format("{}:{}: not YAML: {}: correct the line",
                                             m_path.string(),
                                             error.mark.line + 1,
                                             error.msg));
    }
}

void YamlFile::checkKeys(const YAML::Node& map, const std::vector<std::string>& known) const
{
    std::vector<std::string> seen;
    for (const auto& entry : map)
    {
        const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
        if (std::ranges::find(known, key) == known.end())
        {
            fail(entry.first,
                 key + ": ",
                 fmt::format("no such key: did you mean {}?", nearestName(key, known)));
        }
        if (std::ranges::find(seen, key) != seen.end())
        {
            fail(entry.first, key + ": ", "there twice: drop one");
        }
        if (entry.second.IsNull())
        {
            fail(entry.first, key + ": ", "no value: write one or drop the key");
        }
        seen.push_back(key);
    }
}

std::string YamlFile::textOf(const YAML::Node& node, const std::string& key) const
{
    if (!node.IsScalar() || node.Scalar().empty())
    {
        fail(node, key + ": ", "no value: write one word or a text in quotes");
    }
    return node.Scalar();
}

double YamlFile::numberOf(const YAML::Node& node, const std::string& key) const
{
    try
    {
        return numberFrom(textOf(node, key));
    }
    catch (const std::invalid_argument& error)
    {
        fail(node, key + ": ", error.what());
    }
}

std::vector<double> YamlFile::numbersOf(const YAML::Node& node,
                                        const std::string& key,
                                        std::size_t count) const
{
    if (!node.IsSequence() || node.size() != count)
    {
        fail(node,
             key + ": ",
             fmt::format("not a list of {} numbers: write them in brackets, with commas between",
                         count));
    }
    std::vector<double> numbers;
    for (const YAML::Node& each : node)
    {
        numbers.push_back(numberOf(each, key));
    }
    return numbers;
}

std::string YamlFile::place(const YAML::Node& node) const
{
    return fmt::format("{}:{}: ", m_path.string(), std::max(node.Mark().line, 0) + 1);
}

void YamlFile::fail(const YAML::Node& node, const std::string& key, const std::string& what) const
{
    throw std::runtime_error(place(node) + key + what);
}
}  // namespace bullet_ccd::tools
