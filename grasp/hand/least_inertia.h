/// What simulators give links that have no mass, or next to none. Internal to the library.
#pragma once

namespace bullet_ccd::grasp
{
// Bullet divides by masses and moments, and MuJoCo refuses moving bodies without any. A link
// without gets those of a small part of a finger, which is less than what a geared motor adds to a
// joint.
inline constexpr double kLeastLinkMass = 5e-3;    // [kg]
inline constexpr double kLeastLinkMoment = 1e-6;  // [kg m^2]
}  // namespace bullet_ccd::grasp
