/// Runs one program in the style of Bullet's examples in one kind of world; tools/transparency
/// counts the instructions of its steps.
#include "tests/bullet/programs.h"

#include <cstdio>
#include <cstring>
#include <string>

using namespace bullet_ccd::tests;

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

int main(int argc, char** argv)
{
    if (argc == 2 && std::strcmp(argv[1], "--list") == 0)
    {
        for (const ProgramEntry& entry : programs())
        {
            std::printf("%s\n", entry.name);
        }
        return 0;
    }
    for (const ProgramEntry& entry : programs())
    {
        for (const Kind kind : kAllKinds)
        {
            if (argc == 3 && std::string(argv[1]) == entry.name &&
                std::string(argv[2]) == codeOf(kind))
            {
                Program program = entry.make(kind);
                stepProgram(program, entry.steps);
                std::printf("time-of-impact events: %lld\n",
                            static_cast<long long>(program.scene->counters().m_impacts));
                return 0;
            }
        }
    }
    std::fprintf(stderr, "usage: %s --list | PROGRAM KIND\n", argv[0]);
    return 2;
}
