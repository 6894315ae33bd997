#include "benchmarks/grasp/bench_log.h"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace fs = std::filesystem;
using nlohmann::json;

BenchLog::BenchLog(fs::path file, const json& settings, bool resume) : m_file(std::move(file))
{
    const bool exists = fs::exists(m_file);
    if (exists && !resume)
    {
        throw std::runtime_error(fmt::format(
            "{}: exists already: --resume goes on with it, another --output leaves it alone",
            m_file.string()));
    }
    if (exists)
    {
        read(settings);
    }
    // What is good is written again: a line that was cut off must not stay in the middle.
    const fs::path whole = m_file.string() + ".new";
    {
        std::ofstream out(whole);
        out << settings.dump() << '\n';
        for (const json& row : m_rows)
        {
            out << row.dump() << '\n';
        }
        out.flush();
        if (!out)
        {
            throw std::runtime_error(fmt::format(
                "{}: cannot be written: is the folder there, the disk full?", whole.string()));
        }
    }
    fs::rename(whole, m_file);
    m_out.open(m_file, std::ios::app);
}

void BenchLog::read(const json& settings)
{
    std::ifstream in(m_file);
    std::string line;
    for (int number = 1; std::getline(in, line); ++number)
    {
        const bool last = in.peek() == std::ifstream::traits_type::eof();
        json row = json::parse(line, nullptr, false);
        const bool good = number == 1
                              ? row == settings
                              : row.is_object() && row.contains("hand") && row.contains("object");
        if (!good && !(last && number > 1))
        {
            throw std::runtime_error(
                fmt::format("{}:{}: {}: name another --output",
                            m_file.string(),
                            number,
                            number == 1 ? "begun with other settings, or by another version"
                                        : "no result of a hand and an object"));
        }
        if (good && number > 1)
        {
            m_rows.push_back(std::move(row));
        }
    }
}

bool BenchLog::has(const std::string& hand, const std::string& object) const
{
    const std::lock_guard lock(m_mutex);
    return std::any_of(m_rows.begin(),
                       m_rows.end(),
                       [&](const json& row)
                       { return row["hand"] == hand && row["object"] == object; });
}

void BenchLog::add(const json& row)
{
    const std::lock_guard lock(m_mutex);
    m_rows.push_back(row);
    m_out << row.dump() << std::endl;
    if (!m_out)
    {
        throw std::runtime_error(
            fmt::format("{}: cannot be written: is the disk full?", m_file.string()));
    }
}
}  // namespace bullet_ccd::benchmarks
