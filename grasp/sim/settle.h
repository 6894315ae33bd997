/// Where things come to rest that are let go above a table, such as for scenes of clutter.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/grasp_types.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
struct ClutterOptions
{
    std::uint64_t seed = 1;
    /// Opposite corners of the level rectangle above which objects are let go, W [m].
    Eigen::Vector2d from = {-0.3, -0.3};
    Eigen::Vector2d to = {0.3, 0.3};
    double height = 0.0;     ///< of what they stand on, W [m]
    double distance = 5e-3;  ///< between their circles about z where there is room [m]
    double friction = 0.5;   ///< Coulomb coefficient
    /// Share of its spin that an object loses in a second, so that balls do not roll for ever.
    double spinDamping = 0.9;
    double longest = 6.0;  ///< after which what still moves is left where it is [s]
};

struct SettledObjects
{
    std::vector<Eigen::Isometry3d> X_WO;  ///< one an object, in the order given
    bool atRest = false;                  ///< none moves by more than 1 mm in half a second
    double seconds = 0.0;                 ///< simulated
};

/// Lets the objects go, upright and turned about z by chance: where there is room, each at a place
/// of its own, else above the others. They fall in a Bullet world (continuous, double precision),
/// with the masses of their volumes. Deterministic.
/// @param obstacles  at rest, among them what they fall on
/// Throws std::invalid_argument without objects, and for a rectangle that is none.
[[nodiscard]] BULLET_CCD_API SettledObjects settle(std::span<const GraspObject* const> objects,
                                                   std::span<const RigidBody> obstacles,
                                                   const ClutterOptions& options = {});
}  // namespace bullet_ccd::grasp
