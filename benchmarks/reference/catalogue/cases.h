/// Scenarios with a closed-form first contact time, for every method and benchmark that wants them.
///
/// A case is a scene, its exact answer written as a formula of the scene's numbers, and what is
/// needed to judge an answer at a given tolerance. Smooth bodies are inscribed polyhedra with a
/// vertex exactly at the analytic contact point, so that the mesh touches when the smooth body
/// does.
#pragma once

#include "benchmarks/reference/scenes/articulated_scene.h"
#include "benchmarks/reference/scenes/rigid_scene.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/toi/toi.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bullet_ccd::reference
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
    std::optional<ToiStatus> status =
        {};  ///< that this library has to give, where only one is right
    /// The gap at the start is within the tolerance already: any time before `time` is tight.
    bool startsTouching = false;
    /// Distance 0 at the start: rounding of poses or units decides whether the surfaces meet.
    bool hangsOnRounding = false;

    /// The finest tolerance [m].
    [[nodiscard]] double finest() const { return tolerances.back() * length; }
};

struct RigidCase
{
    std::string id;
    RigidScene scene = {};
    CaseAnswer answer = {};
    bool nested = false;     ///< a body is inside the other or linked with it: hulls overlap
    std::string title = {};  ///< what is hard; see catalogue.h
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
    std::string title = {};
};

/// How long before the contact the distance falls to `gap`, to first or second order.
[[nodiscard]] double leadTime(const CaseAnswer& answer, double gap);

/// What a reported time has to be within at a tolerance, where there is a contact: not late beyond
/// rounding, early by no more than the distance takes from the tolerance to zero. The distance is
/// not exactly linear over the tolerance: 10 % more.
struct RightTimes
{
    double earliest = 0.0;
    double latest = 0.0;
};
[[nodiscard]] RightTimes rightTimes(const CaseAnswer& answer, double tolerance, double rounding);

/// The case without its answer; obstacles at rest.
[[nodiscard]] ArticulatedScene sceneOf(const ArticulatedCase& tested);

/// Rounding of a distance in the case: 64 units in the last place of its coordinates [m].
[[nodiscard]] double roundingOf(const RigidCase& tested);
[[nodiscard]] double roundingOf(const ArticulatedCase& tested);

[[nodiscard]] std::vector<RigidCase> translationCases();
[[nodiscard]] std::vector<RigidCase> rotationCases();
[[nodiscard]] std::vector<RigidCase> grazingCases();
[[nodiscard]] std::vector<RigidCase> degenerateCases();
[[nodiscard]] std::vector<RigidCase> stateCases();
/// What once broke something in this project, and what sampling and other codes get wrong.
[[nodiscard]] std::vector<RigidCase> foundCases();

[[nodiscard]] std::vector<ArticulatedCase> chainCases();
[[nodiscard]] std::vector<ArticulatedCase> graspCases();
[[nodiscard]] std::vector<ArticulatedCase> foundChainCases();

/// All of them, with their titles, in the order of their ids.
[[nodiscard]] std::vector<RigidCase> rigidCases();
[[nodiscard]] std::vector<ArticulatedCase> articulatedCases();

/// Throws std::invalid_argument for an id that none has.
[[nodiscard]] ArticulatedCase articulatedCase(std::string_view id);
}  // namespace bullet_ccd::reference
