#include "grasp/hand/hash.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>

namespace bullet_ccd::grasp
{
void Hash::add(std::uint64_t word)
{
    for (int byte = 0; byte < 8; ++byte)
    {
        m_value = (m_value ^ ((word >> (8 * byte)) & 0xff)) * 0x100000001b3U;
    }
}

void Hash::add(double value)
{
    add(std::bit_cast<std::uint64_t>(value));
}

void Hash::add(std::int32_t value)
{
    add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
}

void Hash::add(const std::string& text)
{
    add(static_cast<std::uint64_t>(text.size()));
    for (const char c : text)
    {
        add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
    }
}

void Hash::add(const Eigen::Isometry3d& X)
{
    const Eigen::Matrix4d& matrix = X.matrix();
    std::for_each(matrix.data(), matrix.data() + matrix.size(), [&](double v) { add(v); });
}

void Hash::add(const Link& link)
{
    add(link.name);
    add(link.parent);
    add(link.X_PL0);
    add(link.joint.name);
    add(static_cast<std::int32_t>(link.joint.type));
    for (int k = 0; k < 3; ++k)
    {
        add(link.joint.axis[k]);
    }
    add(link.joint.lower);
    add(link.joint.upper);
    add(link.joint.mimicOf);
    add(link.joint.mimicMultiplier);
    add(link.joint.mimicOffset);
}

std::string hexadecimal(std::uint64_t value)
{
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}
}  // namespace bullet_ccd::grasp
