/// Contacts of what deforms: of two features (elementaryToi()), and of whole surfaces in a step
/// (DeformableSurface, deformableContacts(), deformableToi()).
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/toi.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace bullet_ccd
{
// First contact of two features that deform: a vertex and a face, or two edges, whose vertices
// move on straight lines. What cloth and soft bodies are made of.
//
// The two features are subtracted from each other. The pair touches if and only if the origin lies
// in a moving convex polygon: a triangle for a vertex and a face, a parallelogram for two edges.
// Time is certified interval by interval, by a direction along which all corners of the polygon
// stay on one side of the origin; the direction turns linearly with time, so that an interval is
// decided by quadratics in closed form. Directions come from the nearest point of the polygon, but
// need not be trusted: a bad one certifies less, never something wrong. README.md has the proofs.
//
// A vertex and an edge, or two vertices, are the same with corners that coincide.

/// Which two features meet.
enum class ElementaryKind : std::uint8_t
{
    VertexFace,  ///< vertex 0 against the triangle of vertices 1, 2, 3
    EdgeEdge,    ///< the edge of vertices 0 and 1 against that of 2 and 3
};

/// Farther from the origin no vertex may be [m]: rounding would be above 1.4 cm there, and beyond
/// 1e38 nothing would be right any more.
inline constexpr double kLargestCoordinate = 1e12;

/// True if all coordinates are finite and within kLargestCoordinate.
[[nodiscard]] inline bool isPlace(const Eigen::Vector3d& x)
{
    return x.cwiseAbs().maxCoeff() <= kLargestCoordinate && x.allFinite();
}

/// The places of the four vertices of a pair at one time [m].
using FourPoints = std::array<Eigen::Vector3d, 4>;

/// Two features and how they move: vertex k is at (1 - t) start[k] + t end[k], t in [0, 1].
struct ElementaryPair
{
    ElementaryKind kind = ElementaryKind::VertexFace;
    FourPoints start{};
    FourPoints end{};
};

/// What becomes of a pair whose gap has come down to the tolerance.
enum class ElementaryDepth : std::uint8_t
{
    Tolerance,  ///< it is a contact
    Decide,     ///< it is followed further, by a bounded effort: most then pass each other, or come
                ///< down to the rounding error of double precision; what is still open is a contact
    Exact,      ///< as Decide, and what is still open is decided without rounding: the answer is a
                ///< contact if and only if the features touch, or come within the minimum
                ///< separation
};

/// What an elementary query is asked. The members of ToiOptions that it knows mean the same here.
struct ElementaryOptions
{
    /// Features that are already closer at t = 0 count as in contact at half of that distance.
    double tolerance = kDefaultTolerance;
    double minimumSeparation = 0.0;
    ElementaryDepth depth = ElementaryDepth::Tolerance;
    std::int64_t maxIterations = 10'000;  ///< of the search in time
};

/// First contact of two features. The normal points from the first feature to the second.
struct ElementaryResult
{
    ToiStatus status = ToiStatus::Separated;
    double time = 1.0;  ///< certified: no contact before it
    /// Distance of the features at `time` [m]; without a contact the minimum separation, which they
    /// exceed at all times.
    double gap = 0.0;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, at `time`; zero without a contact
    /// Of the vertices in the vector from the first feature's nearest point to the second's, at
    /// `time`: (-1, a, b, c) for a vertex and a face, (u - 1, -u, 1 - v, v) for two edges. Zero
    /// without a contact.
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    std::int64_t iterations = 0;  ///< evaluations of the nearest point
};

/// First time in [0, 1] at which two features come within `options.tolerance`.
///
/// Guarantee: no contact for t in [0, result.time); ToiStatus says what each outcome promises. No
/// contact is missed through rounding: with M the largest coordinate of the difference of any two
/// vertices of different features, all rounding stays below 64 * 2^-53 M, which is added to the
/// separation that is kept. So a contact may be reported whose gap is tolerance + 1.5e-14 M.
/// With ElementaryDepth::Exact a contact is reported if and only if the features touch, or with a
/// minimum separation, if they come within it.
/// Throws std::invalid_argument for coordinates that are not finite or above kLargestCoordinate, a
/// tolerance that is not positive, and a minimum separation that is negative.
[[nodiscard]] BULLET_CCD_API ElementaryResult elementaryToi(const ElementaryPair& pair,
                                                            const ElementaryOptions& options);

// A triangle mesh that deforms: its topology and hierarchy, built once, and where its vertices are
// at both ends of a step, set for every step.
//
// The triangles are kept in patches of at most sixteen, under a hierarchy with eight children a
// node whose boxes move: one box at t = 0, one at t = 1. Every vertex and edge belongs to one
// patch, so that no pair of features is met twice.

/// How a surface is built.
struct DeformableSurfaceOptions
{
    /// Vertices at exactly the same place count as one: features that share such a vertex are
    /// neighbours and never tested against each other. Otherwise they are refused. Each keeps a
    /// path of its own, so a contact with the edge of a seam is reported for both edges there.
    bool weldDuplicates = false;
    /// Pairs of vertices that are sewn together: they count as one as well, wherever they are.
    std::span<const std::array<std::int32_t, 2>> seams{};
};

/// A mesh that deforms. Two triangles with a vertex in common are neighbours and not tested where
/// they share it. A triangle may name a vertex twice: then it is an edge (a rope is such
/// triangles). Vertices of no triangle are ignored; a triangle that is there twice counts once.
class BULLET_CCD_API DeformableSurface
{
public:
    /// Builds the hierarchy over the mesh at rest, and sets a step in which it stays there.
    /// Throws std::invalid_argument for a mesh that checkMesh() refuses, vertices beyond
    /// kLargestCoordinate, seams that name no vertex, and vertices at the same place, unless they
    /// are welded.
    explicit DeformableSurface(const TriangleMesh& rest,
                               const DeformableSurfaceOptions& options = {});
    ~DeformableSurface();
    DeformableSurface(DeformableSurface&&) noexcept;
    DeformableSurface& operator=(DeformableSurface&&) noexcept;

    /// Where the vertices are when the step begins and ends; in between they move on straight
    /// lines. Refits the hierarchy. Quality, not correctness, suffers when the mesh has changed its
    /// shape much since it was built; then build another.
    /// @param start,end  one place for every vertex of the mesh that the surface was built from [m]
    /// @param threads    that share the work; the outcome does not depend on them
    /// Throws std::invalid_argument for another number of places, for one that is not finite or
    /// beyond kLargestCoordinate, and without a thread; the step before stays.
    void setStep(std::span<const Eigen::Vector3d> start,
                 std::span<const Eigen::Vector3d> end,
                 int threads = 1);
    /// Says that the step is the same as before, for updateContacts().
    void keepStep();

    [[nodiscard]] std::size_t vertexCount() const;
    [[nodiscard]] std::size_t triangleCount() const;
    /// Bytes that the surface holds.
    [[nodiscard]] std::size_t memory() const;

    struct Data;
    [[nodiscard]] const Data& data() const { return *m_data; }

private:
    std::unique_ptr<Data> m_data;
};

// Contacts of deforming surfaces in a step: between bodies and within a body, all of them or the
// first.
//
// A contact is a pair of features, a vertex and a face or two edges, for which elementaryToi()
// reports one. Hierarchy, instruction set and threads only decide how fast they are found: the
// answer is that of elementaryToi() for every pair of features, in the order that
// DeformableContact says, bit for bit. Features that share a vertex are not tested against each
// other, nor those that both rest.

/// A surface in its step.
struct DeformableBody
{
    const DeformableSurface* surface = nullptr;
    bool selfCollision = true;  ///< test the features of this body against each other, too
    /// How far points may be off the straight paths of the step [m]. It is kept in addition to the
    /// minimum separation. rigidStep() and linkStep() say it of bodies that turn.
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
    /// Pairs of bodies, the lower index first, for which this is true are not tested. A body
    /// against itself is such a pair as well; all are tested if it is empty. Asked only of pairs
    /// whose boxes come near in the step.
    std::function<bool(std::int32_t, std::int32_t)> isPairExempt = nullptr;
    /// Contacts for which this is true do not count: pins, seams between bodies. Called from all
    /// threads, and only for contacts; none is exempt if it is empty.
    std::function<bool(const DeformableContact&)> isExempt = nullptr;
    StopCondition stop{};  ///< deadline and cancellation; the status is then Stopped
};

/// What a query cost.
struct DeformableCounters
{
    std::int64_t patchPairs = 0;    ///< pairs of up to sixteen triangles each
    std::int64_t featurePairs = 0;  ///< whose boxes meet
    std::int64_t advanced = 0;      ///< that no fixed direction separates
};

/// Contacts of a step.
struct DeformableResult
{
    /// That of the first contact; Separated without one. IterationLimit or Stopped without
    /// contacts: the query gave up, nothing is known.
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

/// Brings all contacts of a step up to date after some paths have changed, as a response does that
/// bends the paths that meet and asks again: only features of which a vertex goes another way than
/// before are looked at.
///
/// Guarantee: the result is then that of deformableContacts(), bit for bit, but for the counters.
/// @pre  Since `result` was the answer for the same bodies and options, every surface was given its
///       step once, by setStep() or keepStep().
/// @param result  that answer; one that gave up (IterationLimit or Stopped, without contacts) is
///       found anew, in the memory that it has
/// Throws what deformableContacts() does; the result is then as before.
BULLET_CCD_API void updateContacts(std::span<const DeformableBody> bodies,
                                   const DeformableOptions& options,
                                   DeformableWorkspace& work,
                                   DeformableResult& result);

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
/// The same of a link of an articulated body, whose path all joints between it and the world bend.
/// @param mesh  of the link, in its frame [m]
/// @pre   the tree has the link, and the motion is one of the tree
/// Throws std::invalid_argument for motions that are not finite.
[[nodiscard]] BULLET_CCD_API RigidStep linkStep(const TriangleMesh& mesh,
                                                const KinematicTree& tree,
                                                const JointMotion& motion,
                                                std::int32_t link);
}  // namespace bullet_ccd
