/// Runs one program in the style of Bullet's examples in one kind of world; benchmarks/run
/// transparency counts the instructions of its steps.
#include "benchmarks/reference/bullet/programs.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

using namespace bullet_ccd::reference;

/// What is counted: by name, from outside.
extern "C" [[gnu::noinline]] void stepProgram(Program& program, int steps)
{
    for (int step = 0; step < steps; ++step)
    {
        if (program.act)
        {
            program.act(step);
        }
        program.scene->step(program.timeStep);
    }
}

namespace
{
/// Null if there is none of this name.
const Kind* kindOf(const std::string& code)
{
    for (const Kind& kind : kAllKinds)
    {
        if (code == codeOf(kind))
        {
            return &kind;
        }
    }
    return nullptr;
}

void runSteps(const ProgramEntry& entry, Kind kind, int steps)
{
    Program program = entry.make(kind);
    program.scene->addHooks();
    stepProgram(program, steps);
    std::printf("time-of-impact events: %lld\n",
                static_cast<long long>(program.scene->counters().m_impacts));
}
}  // namespace

int main(int argc, char** argv)
{
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const std::vector<ProgramEntry> all = programs();
    if (arguments.size() == 1 && arguments[0] == "--list")
    {
        for (const ProgramEntry& entry : all)
        {
            std::printf("%s %d %s\n", entry.name, entry.steps, entry.limited ? "limited" : "free");
        }
        return 0;
    }
    const bool first = arguments.size() == 3 && arguments[2] == "--first-event";
    const Kind* kind = arguments.size() == 3 ? kindOf(arguments[1]) : nullptr;
    const auto entry = std::find_if(all.begin(),
                                    all.end(),
                                    [&](const ProgramEntry& known)
                                    { return kind != nullptr && arguments[0] == known.name; });
    const int steps = entry != all.end() && !first ? std::atoi(arguments[2].c_str()) : 0;
    if (entry == all.end() || (!first && steps <= 0))
    {
        std::fprintf(stderr, "usage: %s --list | PROGRAM KIND STEPS|--first-event\n", argv[0]);
        return 2;
    }
    if (first)
    {
        std::printf("first event in step: %d\n", runProgram(*entry, *kind).firstEvent);
    }
    else
    {
        runSteps(*entry, *kind, steps);
    }
    return 0;
}
