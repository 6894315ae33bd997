/// The commands of p.executePluginCommand().
#ifndef PYTHON_PYBULLET_COMMANDS_H
#define PYTHON_PYBULLET_COMMANDS_H

#include "bullet_ccd/bullet/btCcdControl.h"

#include <array>
#include <string_view>

class Session;
struct HostArguments;

/// A counter and its name in a command.
struct NamedCounter
{
    std::string_view m_name;
    std::int64_t btCcdCounters::*m_counter;
};

inline constexpr std::array kCounters{
    NamedCounter{"queries", &btCcdCounters::m_queries},
    NamedCounter{"impacts", &btCcdCounters::m_impacts},
    NamedCounter{"clamps", &btCcdCounters::m_clamps},
    NamedCounter{"overlaps", &btCcdCounters::m_overlaps},
    NamedCounter{"event_limits", &btCcdCounters::m_eventLimits},
    NamedCounter{"settled", &btCcdCounters::m_settled},
    NamedCounter{"iteration_limits", &btCcdCounters::m_iterationLimits},
    NamedCounter{"unsupported", &btCcdCounters::m_unsupported},
};

/// Does what the text says, with numbers behind it or in the lists of the arguments.
/// @return the counter that was asked for, or 0
/// Throws std::invalid_argument for a command that is not known or has wrong numbers.
int execute(Session& session, const HostArguments& arguments);

#endif  // PYTHON_PYBULLET_COMMANDS_H
