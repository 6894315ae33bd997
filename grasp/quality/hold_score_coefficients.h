/// Written by tools/fit_score. Of the features of hold_score.h, in their order.
#pragma once

#include <array>

namespace bullet_ccd::grasp
{
inline constexpr std::array kHoldScore{
    -1.4450,  // one
    1.2746,  // log_mass_ratio
    3.4235,  // spread
};
}  // namespace bullet_ccd::grasp
