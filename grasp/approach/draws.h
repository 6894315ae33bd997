/// Random numbers of the sampler.
#pragma once

#include <cstdint>

namespace bullet_ccd::grasp
{
/// Random numbers by counter: the k-th draw of candidate `number` depends on nothing but (seed,
/// number, k), so candidates can be made in any order and on any thread.
class Draws
{
public:
    Draws(std::uint64_t seed, std::uint64_t number) : m_state(mix(mix(seed) ^ number)) {}

    /// In [0, 1).
    [[nodiscard]] double unit() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
    [[nodiscard]] double between(double low, double high) { return low + (high - low) * unit(); }
    [[nodiscard]] bool coin() { return (next() >> 63) != 0; }

private:
    /// The finalizer of SplitMix64 (Steele, Lea, Flood 2014).
    [[nodiscard]] static std::uint64_t mix(std::uint64_t z)
    {
        z += 0x9e3779b97f4a7c15U;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
        return z ^ (z >> 31);
    }
    [[nodiscard]] std::uint64_t next() { return m_state = mix(m_state); }

    std::uint64_t m_state;
};
}  // namespace bullet_ccd::grasp
