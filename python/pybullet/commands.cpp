#include "python/pybullet/commands.h"

#include "python/pybullet/host_interface.h"
#include "python/pybullet/session.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{
constexpr const char* kHelp =
    "commands: off | on | tolerance METRES | exclude BODY [LINK] | include BODY [LINK] | "
    "teleported BODY | "
    "reset_counters | lost_time (microseconds) | keep_impacts COUNT | the name of a counter:";

/// A word and the numbers behind it.
struct Command
{
    std::string m_name;
    std::vector<double> m_numbers;

    double number(std::size_t index) const
    {
        if (index >= m_numbers.size())
        {
            throw std::invalid_argument(m_name + ": a number is missing");
        }
        return m_numbers[index];
    }
    int whole(std::size_t index) const
    {
        const double value = number(index);
        if (!(std::abs(value) < INT_MAX) || value != std::floor(value))
        {
            throw std::invalid_argument(m_name + ": " + std::to_string(value) +
                                        " is not a whole number");
        }
        return int(value);
    }
    int link() const { return m_numbers.size() > 1 ? whole(1) : -1; }
    void atMost(std::size_t count) const
    {
        if (m_numbers.size() > count)
        {
            throw std::invalid_argument(m_name + " takes at most " + std::to_string(count) +
                                        " numbers");
        }
    }
};

Command parse(const HostArguments& arguments)
{
    Command command;
    std::istringstream text(
        std::string(arguments.m_text, strnlen(arguments.m_text, sizeof arguments.m_text)));
    text >> command.m_name;
    for (double number = 0.0; text >> number;)
    {
        command.m_numbers.push_back(number);
    }
    text.clear();
    std::string rest;
    if (text >> rest)
    {
        throw std::invalid_argument(command.m_name + ": \"" + rest + "\" is not a number");
    }
    const auto count = [](int given, std::size_t most)
    { return std::min(std::size_t(std::max(given, 0)), most); };
    command.m_numbers.insert(
        command.m_numbers.end(),
        arguments.m_ints,
        arguments.m_ints + count(arguments.m_numInts, std::size(arguments.m_ints)));
    command.m_numbers.insert(
        command.m_numbers.end(),
        arguments.m_floats,
        arguments.m_floats + count(arguments.m_numFloats, std::size(arguments.m_floats)));
    return command;
}

int clipped(double value)
{
    return int(std::min(value, double(INT_MAX)));
}
}  // namespace

int execute(Session& session, const HostArguments& arguments)
{
    const Command command = parse(arguments);
    const std::string& name = command.m_name;
    for (const NamedCounter& counter : kCounters)
    {
        if (name == counter.m_name)
        {
            command.atMost(0);
            return clipped(double(session.action().getCcdCounters().*counter.m_counter));
        }
    }
    if (name == "lost_time")
    {
        command.atMost(0);
        return clipped(1e6 * session.action().getCcdCounters().m_lostTime);
    }
    if (name == "reset_counters")
    {
        command.atMost(0);
        session.action().resetCcdCounters();
        return 0;
    }
    if (name == "off" || name == "on")
    {
        command.atMost(0);
        session.switchOn(name == "on");
        return 0;
    }
    if (name == "tolerance")
    {
        command.atMost(1);
        session.setTolerance(command.number(0));
        return 0;
    }
    if (name == "exclude" || name == "include")
    {
        command.atMost(2);
        session.setEnabled(command.whole(0), command.link(), name == "include");
        return 0;
    }
    if (name == "teleported")
    {
        command.atMost(1);
        session.teleported(command.whole(0));
        return 0;
    }
    if (name == "keep_impacts")
    {
        command.atMost(1);
        if (command.whole(0) < 0)
        {
            throw std::invalid_argument("keep_impacts: the count must not be negative");
        }
        session.setImpactCapacity(std::size_t(command.whole(0)));
        return 0;
    }
    std::string known;
    for (const NamedCounter& counter : kCounters)
    {
        known += " " + std::string(counter.m_name);
    }
    throw std::invalid_argument("\"" + name + "\" is no command; " + kHelp + known);
}
