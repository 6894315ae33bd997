/// One grasp as a model for MuJoCo: hand, object and what the joints press with, as MJCF.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/reduce/convex_pieces.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"
#include "grasp/squeeze/squeeze.h"

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
/// What MuJoCo collides in place of hand and object: it takes the convex hull of every mesh.
struct MjcfPieces
{
    std::vector<ConvexPieces> links;  ///< one entry per link, in its frame; empty without geometry
    ConvexPieces object;              ///< in the mesh frame
};

struct MjcfOptions
{
    double mass = 0.5;      ///< of the object [kg]
    double friction = 0.5;  ///< Coulomb coefficient of all pairs
    /// Largest torsional moment of a contact over its normal force; 0: points that resist none [m].
    double torsion = 0.0;
    double timeStep = 2e-3;     ///< [s]
    double dampingTime = 0.02;  ///< damping over stiffness of the controllers [s]
};

/// Writes a model that MuJoCo 2.2 and later compile:
///   - the links as bodies below the world, the root at the pose of the grasp in the object's mesh
///     frame; joints with axis, limits, and couplings of mimic joints as equalities;
///   - the object as a body with a free joint, whose mass is that of the options, with the centre
///     of mass of the object and the inertia of its solid;
///   - collision geometry as convex pieces, in files of writeMjcfMeshes(); a comment says by how
///     much they bulge. Pairs of links that the hand does not list are excluded;
///   - a position controller for every independent joint, with the stiffness and effort of the
///     squeeze;
///   - the keyframe "grasp", the closed posture held by its controllers, and "squeeze", the same
///     posture with the squeeze's targets (not without a squeeze).
/// There is no gravity: what is to hold the object's weight is given by the user, and the weight of
/// the hand counts as compensated. Links without a mass, or with next to none, get 5 g and
/// 1e-6 kg m^2. Joints get the inertia of a motor (armature): damping of the controller times two
/// time steps, without which MuJoCo shakes light fingers off. A link called "world" is "world_".
/// Speed limits are not written, since MuJoCo has none.
/// @param meshes  folder of the meshes, as seen from the file
/// Throws std::invalid_argument for a grasp that was never closed, for pieces or a squeeze of
/// another hand, and for numbers that are not positive (torsion: negative).
BULLET_CCD_API void writeMjcf(std::ostream& out,
                              const HandModel& hand,
                              const GraspObject& object,
                              const Grasp& grasp,
                              const Squeeze& squeeze,
                              const MjcfPieces& pieces,
                              const MjcfOptions& options,
                              const std::string& meshes = "meshes");

/// Writes the pieces as OBJ files with the names that writeMjcf() gives them, and makes the folder.
/// Throws std::runtime_error that names the file that cannot be written.
BULLET_CCD_API void writeMjcfMeshes(const std::filesystem::path& folder, const MjcfPieces& pieces);
}  // namespace bullet_ccd::grasp
