/// Written by tools/fit_score. Of the features of hold_score.h, in their order.
#pragma once

#include <array>

namespace bullet_ccd::grasp
{
inline constexpr std::array kHoldScore{
    -1.4487,  // one
    1.2775,   // log_mass_ratio
    3.4303,   // spread
};
}  // namespace bullet_ccd::grasp
