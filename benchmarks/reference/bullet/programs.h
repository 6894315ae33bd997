/// Programs in the style of Bullet's own examples, in which a hook that has nothing to do must
/// change nothing.
#pragma once

#include "benchmarks/reference/bullet/scene.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
/// A world with everything in it.
struct Program
{
    std::unique_ptr<Scene> scene;
    double timeStep = 1.0 / 60.0;                 ///< [s]
    std::function<void(int step)> act = nullptr;  ///< before a step
};

struct ProgramEntry
{
    const char* name;
    WorldClass worldClass;
    int steps;
    bool calm;  ///< nothing moves so fast that it could cross anything
    /// One of Bullet's own examples, which may cost 3 % more instructions. The others are harder:
    /// small chains in which every link may meet every other, worlds of three objects.
    bool limited;
    std::function<Program(Kind)> make;
};

[[nodiscard]] std::vector<ProgramEntry> programs();

/// Where everything is and how it moves after one step, bit for bit.
[[nodiscard]] std::vector<btScalar> stateOf(Scene& scene);

struct Trace
{
    std::vector<std::vector<btScalar>> states;  ///< one for every step
    int firstEvent = -1;                        ///< step with the first time of impact; -1: none
};
[[nodiscard]] Trace runProgram(const ProgramEntry& entry, Kind kind);

/// First step after which the states differ, -1 if none does.
[[nodiscard]] int firstDifference(const Trace& a, const Trace& b);
}  // namespace bullet_ccd::reference
