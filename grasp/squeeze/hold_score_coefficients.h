/// Written by tools/fit_score. Of the features of hold_score.h, in their order.
#pragma once

#include <array>

namespace bullet_ccd::grasp
{
inline constexpr std::array kHoldScore{
    0.0,  // one
    5.0,  // epsilon_root
    1.0,  // log_weights
    0.0,  // links
};
}  // namespace bullet_ccd::grasp
