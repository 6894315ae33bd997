/// Written by tools/fit_score. Of the features of hold_score.h, in their order.
#pragma once

#include <array>

namespace bullet_ccd::grasp
{
inline constexpr std::array kHoldScore{
    -1.8917,  // one
    1.2166,  // log_mass_ratio
    4.1445,  // spread
};
}  // namespace bullet_ccd::grasp
