/// What PyBullet calls by name, and what bullet_ccd/pybullet.py calls beside that. Nothing of this
/// lets an exception out.
#include "python/pybullet/commands.h"
#include "python/pybullet/fit.h"
#include "python/pybullet/host_interface.h"
#include "python/pybullet/session.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <string>

#define PLUGIN_API extern "C" __attribute__((visibility("default")))

namespace
{
/// By number. PyBullet calls with Python's lock held, and so does bullet_ccd/pybullet.py.
std::map<int, std::unique_ptr<Session>>& sessions()
{
    static auto* const all = new std::map<int, std::unique_ptr<Session>>;
    return *all;  // never destroyed: clients may disconnect after the statics are gone
}

int numberOf(const HostContext& context)
{
    return int(reinterpret_cast<std::intptr_t>(context.m_user));
}

Session* sessionOf(const HostContext& context)
{
    const auto found = sessions().find(numberOf(context));
    return found == sessions().end() ? nullptr : found->second.get();
}

int complain(const char* what, const std::string& why)
{
    std::fprintf(stderr, "bullet_ccd: %s: %s\n", what, why.c_str());
    return -1;
}

int load(HostContext& context)
{
    constexpr const char* kRefused = "the PyBullet plugin was not loaded";
    const std::string misfit = misfitOfHost(context);
    if (!misfit.empty())
    {
        return complain(kRefused, misfit);
    }
    const auto isSame = [&](const auto& entry)
    { return &entry.second->processor() == context.m_processor; };
    if (std::any_of(sessions().begin(), sessions().end(), isSame))
    {
        return complain(kRefused, "this client has it already, by another path");
    }
    auto session = std::make_unique<Session>(*context.m_processor);
    if (!session->problem().empty())
    {
        return complain(kRefused, session->problem());
    }
    static int number = 0;
    ++number;
    sessions().emplace(number, std::move(session));
    context.m_user = reinterpret_cast<void*>(std::intptr_t(number));
    return kHostApi;
}
}  // namespace

PLUGIN_API int initPlugin(HostContext* context)
try
{
    return load(*context);
}
catch (const std::exception& error)
{
    return complain("the PyBullet plugin was not loaded", error.what());
}

PLUGIN_API void exitPlugin(HostContext* context)
{
    sessions().erase(numberOf(*context));
    context->m_user = nullptr;
}

PLUGIN_API int preTickPluginCallback(HostContext* context)
{
    if (Session* session = sessionOf(*context))
    {
        session->beforeStep();
    }
    return 0;
}

PLUGIN_API int postTickPluginCallback(HostContext* context)
{
    if (Session* session = sessionOf(*context))
    {
        session->afterStep();
    }
    return 0;
}

PLUGIN_API int executePluginCommand(HostContext* context, const HostArguments* arguments)
try
{
    Session* const session = sessionOf(*context);
    if (session == nullptr)
    {
        return complain("executePluginCommand", "the plugin is not loaded");
    }
    if (std::string(arguments->m_text, 8) == std::string("session\0", 8))
    {
        return numberOf(*context);
    }
    return execute(*session, *arguments);
}
catch (const std::exception& error)
{
    return complain("executePluginCommand", error.what());
}

/// Counters in the order of kCounters, then the lost time [s], the tolerance [m] and the impacts
/// that were not kept. Returns how many there are, or -1 without such a session or action.
PLUGIN_API int bulletCcdCounters(int number, double* values, int most)
try
{
    btCcdAction& action = sessions().at(number)->action();
    std::vector<double> all;
    all.reserve(kCounters.size() + 3);
    for (const NamedCounter& counter : kCounters)
    {
        all.push_back(double(action.getCcdCounters().*counter.m_counter));
    }
    all.push_back(action.getCcdCounters().m_lostTime);
    all.push_back(action.getCcdTolerance());
    all.push_back(double(sessions().at(number)->lostImpacts()));
    std::copy_n(all.begin(), std::min(all.size(), std::size_t(std::max(most, 0))), values);
    return int(all.size());
}
catch (const std::exception&)
{
    return -1;
}

/// Moves the oldest impacts to `rows`, at most `most` of 14 numbers: time, body and link of A and
/// B, the points on A and B, the normal. Returns how many, or -1 without such a session.
PLUGIN_API int bulletCcdTakeImpacts(int number, double* rows, int most)
try
{
    const std::vector<Impact> impacts =
        sessions().at(number)->takeImpacts(std::size_t(std::max(most, 0)));
    for (const Impact& impact : impacts)
    {
        *rows++ = impact.m_time;
        *rows++ = impact.m_bodyA;
        *rows++ = impact.m_linkA;
        *rows++ = impact.m_bodyB;
        *rows++ = impact.m_linkB;
        for (const btVector3* vector : {&impact.m_pointA, &impact.m_pointB, &impact.m_normal})
        {
            rows = std::copy_n(&vector->x(), 3, rows);
        }
    }
    return int(impacts.size());
}
catch (const std::exception&)
{
    return -1;
}
