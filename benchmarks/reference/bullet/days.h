/// Ordinary and less ordinary days of programs that use Bullet, in a stock world or ours.
#pragma once

#include "benchmarks/reference/bullet/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
/// A day under way.
struct DayUnderWay
{
    std::function<void(int)> before = [](int) {};  ///< a step, which it is told
    std::function<int()> wrong;                    ///< at the end: how many bodies fared badly
};

struct Day
{
    std::string name;
    std::string wrong;  ///< what is counted
    int steps;
    /// @param ours meshes that move are meshes; else they are boxes, as stock Bullet has them
    std::function<DayUnderWay(Scene& scene, bool ours)> begin;
    double seconds = 1.0 / 60.0;  ///< of a step
    WorldClass worldClass = WorldClass::Rigid;

    /// Nothing of ours may go through, and no more may fare badly than in stock Bullet.
    [[nodiscard]] bool isGood(int ours, int stock) const
    {
        return ours == 0 || (wrong != "through" && ours <= stock);
    }
};

[[nodiscard]] std::vector<Day> days();

/// Plays a day and returns how many bodies fared badly.
/// @param step makes one step
[[nodiscard]] int play(
    const Day& day,
    Kind kind,
    const std::function<void(Scene&, double seconds)>& step = [](Scene& scene, double seconds)
    { scene.step(seconds); });
}  // namespace bullet_ccd::reference
