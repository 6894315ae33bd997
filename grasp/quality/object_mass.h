/// What an object weighs where nobody says it: one answer for plans, forces, squeezes, trials and
/// tasks.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/grasp_types.h"

#include <cstdint>
#include <optional>
#include <string>

namespace bullet_ccd::grasp
{
/// Of water [kg/m^3]: filled bottles, tins and fruit have about this, cartons, tools and toys half
/// of it.
inline constexpr double kUsualDensity = 1000.0;
/// Of sheets, which have no volume [m].
inline constexpr double kUsualThickness = 1e-3;

/// What a mass follows from.
enum class MassSource : std::uint8_t
{
    Given,
    Volume,      ///< of the closed mesh
    ConvexHull,  ///< of a mesh that is not closed, or is closed inside out: its convex hull, so
                 ///< more than the truth for what is hollow
    Surface,     ///< of a mesh in a plane: its area times kUsualThickness
};
[[nodiscard]] BULLET_CCD_API const char* toString(MassSource source);

struct ObjectMass
{
    double mass = 0.0;  ///< [kg]
    MassSource source = MassSource::Given;
};

/// The given mass, or else that of the object's volume at kUsualDensity. A volume is measured anew
/// in each call, which takes milliseconds for a detailed mesh.
[[nodiscard]] BULLET_CCD_API ObjectMass massOf(const GraspObject& object,
                                               std::optional<double> given = std::nullopt);

/// Such as "0.31 kg (volume of the closed mesh at 1000 kg/m3)".
[[nodiscard]] BULLET_CCD_API std::string massText(const ObjectMass& mass);
}  // namespace bullet_ccd::grasp
