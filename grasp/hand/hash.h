/// FNV-1a over 64-bit words: names for what hands and objects are made of.
#pragma once

#include "bullet_ccd/motion/kinematic_tree.h"

#include <cstdint>
#include <string>

namespace bullet_ccd::grasp
{
/// The same content has the same hash, in every program.
class Hash
{
public:
    void add(std::uint64_t word);
    void add(double value);
    void add(std::int32_t value);
    void add(const std::string& text);
    void add(const Eigen::Isometry3d& X);
    /// All of it that closing and reaching depend on.
    void add(const Link& link);

    [[nodiscard]] std::uint64_t value() const { return m_value; }

private:
    std::uint64_t m_value = 0xcbf29ce484222325U;
};

/// 16 hexadecimal digits.
[[nodiscard]] std::string hexadecimal(std::uint64_t value);
}  // namespace bullet_ccd::grasp
