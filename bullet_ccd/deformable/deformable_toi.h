/// Contacts of deforming surfaces in a step: between bodies and within a body, all of them or the
/// first.
///
/// A contact is a pair of features, a vertex and a face or two edges, for which elementaryToi()
/// reports one. Hierarchy, instruction set and threads only decide how fast they are found: the
/// answer is that of elementaryToi() for every pair of features, in the order that
/// DeformableContact says, bit for bit. Features that share a vertex are not tested against each
/// other, nor those that both rest.
#pragma once

#include "bullet_ccd/deformable/deformable_surface.h"
#include "bullet_ccd/deformable/elementary_toi.h"
#include "bullet_ccd/export.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/toi.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// A surface in its step.
struct DeformableBody
{
    const DeformableSurface* surface = nullptr;
    bool selfCollision = true;  ///< test the features of this body against each other, too
    /// How far points may be off the straight paths of the step [m]. It is kept in addition to the
    /// minimum separation. rigidStep() says it of a body that turns.
    double deviation = 0.0;
};

/// A contact of two features; ElementaryResult says more of the members of the same name.
struct DeformableContact
{
    ElementaryKind kind = ElementaryKind::VertexFace;
    /// Hit, Overlapping or TouchingPressing; IterationLimit where the search in time of this pair
    /// gave up: not known to be apart after `time`.
    ToiStatus status = ToiStatus::Hit;
    std::int32_t bodyA = kNone;  ///< has the vertex, or the first edge
    std::int32_t bodyB = kNone;
    /// Of the meshes: the vertex of A and the corners of a triangle of B in its order, or the ends
    /// of an edge of A and of one of B, the lower index first. Of two edges of one body the lower
    /// comes first.
    std::array<std::int32_t, 4> vertices{kNone, kNone, kNone, kNone};
    double time = 1.0;
    double gap = 0.0;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
};

/// What a query of deforming surfaces is asked. The members of ElementaryOptions that it knows mean
/// the same here.
struct DeformableOptions
{
    double tolerance = kDefaultTolerance;
    double minimumSeparation = 0.0;
    ElementaryDepth depth = ElementaryDepth::Tolerance;
    /// Pairs of patches, and of features, after which the query gives up.
    std::int64_t maxIterations = 20'000'000;
    /// Of the search in time of a pair of features; what needs more counts as contact.
    std::int64_t maxIterationsOfPair = 10'000;
    int threads = 1;
    /// Contacts for which this is true do not count: pins, seams between bodies. Called from all
    /// threads, and only for contacts; none is exempt if it is empty.
    std::function<bool(const DeformableContact&)> isExempt = nullptr;
};

/// What a query cost.
struct DeformableCounters
{
    std::int64_t patchPairs = 0;    ///< pairs of up to eight triangles each
    std::int64_t featurePairs = 0;  ///< whose boxes meet
    std::int64_t advanced = 0;      ///< that no fixed direction separates
};

/// Contacts of a step.
struct DeformableResult
{
    /// That of the first contact; Separated without one. IterationLimit without contacts: the query
    /// gave up, nothing is known.
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;  ///< certified: no contact before it
    /// By time, then kind, bodies and vertices.
    std::vector<DeformableContact> contacts;
    DeformableCounters counters;
};

/// Scratch memory of queries over deforming surfaces. It is reusable; use one per query at a time.
class BULLET_CCD_API DeformableWorkspace
{
public:
    DeformableWorkspace();
    ~DeformableWorkspace();
    DeformableWorkspace(DeformableWorkspace&&) noexcept;
    DeformableWorkspace& operator=(DeformableWorkspace&&) noexcept;

    struct Scratch;
    [[nodiscard]] Scratch& scratch() { return *m_scratch; }

private:
    std::unique_ptr<Scratch> m_scratch;
};

/// All contacts of the step: the first one of each pair of features.
///
/// Guarantee: a pair of features that comes within the minimum separation in the step, and is not
/// exempt, neighbouring or at rest, is among the contacts, no later than it does. The answer does
/// not depend on the number of threads. Throws std::invalid_argument for a body without a surface,
/// a deviation that is negative, and options that elementaryToi() refuses.
[[nodiscard]] BULLET_CCD_API DeformableResult
deformableContacts(std::span<const DeformableBody> bodies,
                   const DeformableOptions& options,
                   DeformableWorkspace& work);

/// The first contact of the step only, or those that are the first at the same time: the beginning
/// of what deformableContacts() gives. What cannot meet before the earliest contact so far is left
/// out.
[[nodiscard]] BULLET_CCD_API DeformableResult deformableToi(std::span<const DeformableBody> bodies,
                                                            const DeformableOptions& options,
                                                            DeformableWorkspace& work);

/// The step of a rigid mesh, for DeformableSurface::setStep(), so that it can be an obstacle.
struct RigidStep
{
    std::vector<Eigen::Vector3d> start;
    std::vector<Eigen::Vector3d> end;
    /// No point of the mesh is farther than this from its straight path [m], for
    /// DeformableBody::deviation. It grows with the square of the turn: divide steps with large
    /// turns.
    double deviation = 0.0;
};
/// Throws std::invalid_argument for motions that are not finite.
[[nodiscard]] BULLET_CCD_API RigidStep rigidStep(const TriangleMesh& mesh,
                                                 const RigidMotion& motion);
}  // namespace bullet_ccd
