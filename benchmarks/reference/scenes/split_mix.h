/// A small engine for RandomFrom: the sets of rigid queries are drawn from it, and with another one
/// they would be other queries.
#pragma once

#include <cstdint>

namespace bullet_ccd::reference
{
/// SplitMix64 (Steele, Lea, Flood 2014).
class SplitMix64
{
public:
    explicit SplitMix64(std::uint64_t seed) : m_state(seed) {}

    std::uint64_t operator()()
    {
        m_state += 0x9e3779b97f4a7c15ULL;
        std::uint64_t z = m_state;
        z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
        return z ^ (z >> 31U);
    }

private:
    std::uint64_t m_state;
};
}  // namespace bullet_ccd::reference
