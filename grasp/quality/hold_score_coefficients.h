/// Written by tools/fit_score. Of the features of hold_score.h, in their order.
#pragma once

#include <array>

namespace bullet_ccd::grasp
{
inline constexpr std::array kHoldScore{
    -1.8533,  // one
    2.8538,   // log_mass_ratio
    12.9854,  // epsilon
};
}  // namespace bullet_ccd::grasp
