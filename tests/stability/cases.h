/// Scenarios with a closed-form first contact time, for every method and benchmark that wants them.
///
/// A case is a scene, its exact answer written as a formula of the scene's numbers, and what is
/// needed to judge an answer at a given tolerance. Smooth bodies are inscribed polyhedra with a
/// vertex exactly at the analytic contact point, so that the mesh touches when the smooth body
/// does.
#pragma once

#include "bullet_ccd/motion/joint_motion.h"
#include "tests/support/rigid_scene.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
/// The exact answer.
struct CaseAnswer
{
    std::optional<double> time = {};   ///< first contact; none: they never touch
    double closingSpeed = 0.0;         ///< just before the contact; 0 at a tangency
    double closingAcceleration = 0.0;  ///< second derivative of the distance, where it is positive
    double clearance = 0.0;            ///< without contact: the distance is never smaller
    double length = 1.0;               ///< characteristic length
    /// Of the contact, in units of `length`.
    std::vector<double> tolerances = {1e-3, 1e-6};
};

struct RigidCase
{
    std::string id;
    RigidScene scene = {};
    CaseAnswer answer = {};
};

struct ArticulatedCase
{
    std::string id;
    KinematicTree tree = {};
    std::vector<TriangleMesh> linkMeshes = {};  ///< one a link; empty where it has no geometry
    JointMotion motion = {};
    std::vector<std::pair<std::int32_t, std::int32_t>> selfPairs = {};
    std::vector<TriangleMesh> obstacles = {};  ///< at rest
    CaseAnswer answer = {};
    /// Links in contact at that time, ties included.
    std::vector<std::int32_t> links = {};
};

/// How long before the contact the distance falls to `gap`, to first or second order.
[[nodiscard]] double leadTime(const CaseAnswer& answer, double gap);

[[nodiscard]] std::vector<RigidCase> translationCases();
[[nodiscard]] std::vector<RigidCase> rotationCases();
[[nodiscard]] std::vector<RigidCase> grazingCases();
[[nodiscard]] std::vector<RigidCase> degenerateCases();

/// All of them.
[[nodiscard]] std::vector<RigidCase> rigidCases();
[[nodiscard]] std::vector<ArticulatedCase> articulatedCases();
}  // namespace bullet_ccd::tests
