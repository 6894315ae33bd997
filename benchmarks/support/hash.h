/// Tells contents apart: FNV-1a, 64 bits.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace bullet_ccd::benchmarks
{
class ContentHash
{
public:
    void add(std::string_view bytes)
    {
        for (const char byte : bytes)
        {
            m_value = (m_value ^ static_cast<unsigned char>(byte)) * 0x100000001b3ULL;
        }
    }
    void add(std::span<const double> values)
    {
        add({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
    }
    [[nodiscard]] std::uint64_t value() const { return m_value; }

private:
    std::uint64_t m_value = 0xcbf29ce484222325ULL;
};
}  // namespace bullet_ccd::benchmarks
