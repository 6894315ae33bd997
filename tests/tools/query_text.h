/// Query files that tests write.
#pragma once

#include "bullet_ccd/motion/rigid_motion.h"

#include <array>
#include <cstdio>
#include <string>

namespace bullet_ccd::tools
{
/// Every digit of the numbers, each with a comma in front.
inline std::string cellsOf(const Eigen::VectorXd& numbers)
{
    std::string text;
    for (const double number : numbers)
    {
        std::array<char, 40> digits{};
        (void)std::snprintf(digits.data(), digits.size(), ",%.17g", number);
        text += digits.data();
    }
    return text;
}

inline std::string cellsOf(const Eigen::Isometry3d& X)
{
    const Eigen::Quaterniond q(X.linear());
    Eigen::VectorXd numbers(7);
    numbers << q.w(), q.x(), q.y(), q.z(), X.translation();
    return cellsOf(numbers);
}

/// The names with the prefix, each with a comma in front.
inline std::string namesOf(const std::string& prefix, const std::string& names)
{
    std::string text;
    for (std::size_t k = 0; k < names.size(); k += 2)
    {
        text += "," + prefix + "_" + names.substr(k, 2);
    }
    return text;
}

inline std::string posesHeader()
{
    const std::string pose = "qwqxqyqztxtytz";
    return "id" + namesOf("a0", pose) + namesOf("a1", pose) + namesOf("b0", pose) +
           namesOf("b1", pose) + "\n";
}

inline std::string twistsHeader()
{
    const std::string pose = "qwqxqyqztxtytz";
    const std::string twist = "vxvyvzwxwywz";
    return "id" + namesOf("a0", pose) + namesOf("a", twist) + namesOf("b0", pose) +
           namesOf("b", twist) + "\n";
}

inline std::string posesRow(const std::string& id, const RigidMotion& a, const RigidMotion& b)
{
    return id + cellsOf(a.X_W0) + cellsOf(a.at(1.0).X_W) + cellsOf(b.X_W0) +
           cellsOf(b.at(1.0).X_W) + "\n";
}

inline std::string twistCells(const RigidMotion& motion)
{
    Eigen::VectorXd twist(6);
    twist << motion.v_W, motion.w_W;
    return cellsOf(motion.X_W0) + cellsOf(twist);
}

inline std::string twistsRow(const std::string& id, const RigidMotion& a, const RigidMotion& b)
{
    return id + twistCells(a) + twistCells(b) + "\n";
}
}  // namespace bullet_ccd::tools
