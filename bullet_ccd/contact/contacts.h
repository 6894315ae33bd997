/// Contacts of two bodies: contactsAt() gives all pairs of features that touch at one time, usually
/// that of an impact, findContacts() a few points with normals that hold the bodies apart.
///
/// A contact of features is a pair of them, a vertex, edge or face of A and one of B. Their closest
/// points lie inside both features and are at most the threshold apart. Each of the two points is
/// the nearest to the other on its own surface around it, within 0.1 rad: bodies that lie on each
/// other nearly flat touch at all corners. So a cube over a plate touches with its lower corners,
/// not with its walls nor with the upper corners of a plate that is thinner than the threshold.
///
/// Where surfaces are parallel the contacts are those that bound the common patch: corners of one
/// over the other, and boundary edges that cross. Edges and vertices inside a flat part, such as
/// the diagonal of a cube's face, bound nothing and are not reported for their own sake; but a
/// corner that comes down on the diagonal is a contact of a vertex and that edge. Where surfaces
/// intersect, the edges that pierce faces are contacts of an edge and a face with gap 0; the normal
/// is that of the face, by which the middle of the edge's body stays on its side.
#pragma once

#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"
#include "bullet_ccd/math/stop_condition.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

namespace bullet_ccd
{
/// The kind of a feature.
enum class FeatureKind : std::uint8_t
{
    Vertex,
    Edge,
    Face,
};

/// A vertex, edge or triangle of a mesh, by its vertices. Vertices at exactly the same position
/// count as one and go by the smallest index among the triangles near the contact, so that the
/// triangles of a soup that share no indices are neighbours all the same.
struct Feature
{
    FeatureKind kind = FeatureKind::Vertex;
    /// Indices into the mesh, ascending; kNone at the end where there are fewer.
    std::array<std::int32_t, 3> vertices{kNone, kNone, kNone};

    friend auto operator<=>(const Feature&, const Feature&) = default;
};

/// A contact of two features.
struct FeatureContact
{
    Feature featureA = {};
    Feature featureB = {};
    /// Triangles that have the features; if several have, the pair with the smallest indices.
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();  ///< on the feature of A, in W [m]
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    /// Unit, from A to B, in W. Below a gap of 1e-9 of the larger body from the features: a vertex
    /// on a vertex or an edge has a sense by the winding of the triangles around only.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double gap = 0.0;  ///< [m]
};

/// All contacts of two bodies at a time. Each pair of features is listed once, in the order of gap,
/// then featureA, then featureB.
///
/// Guarantee: the result is not empty if the bodies are at most `threshold` apart. So it is never
/// empty at the time of a hit with minimumSeparation + tolerance as threshold.
/// @param time in [0, 1], as the motions take it
/// @param threshold largest gap [m], >= 0; rounding of the distances is allowed for
/// Throws std::invalid_argument for a time or pose that is not finite or a threshold that is
/// negative or not finite, and QueryStopped if `stop` ended the query.
[[nodiscard]] BULLET_CCD_API std::vector<FeatureContact> contactsAt(const RigidBody& bodyA,
                                                                    const RigidBody& bodyB,
                                                                    double time,
                                                                    double threshold,
                                                                    const StopCondition& stop = {});

/// A point contact; witnesses on both surfaces, in the frame of the query.
struct Contact
{
    Eigen::Vector3d pointA = Eigen::Vector3d::Zero();
    Eigen::Vector3d pointB = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, from A to B
    double gap = 0.0;                                  ///< |pointB - pointA| [m]
    std::int32_t triangleA = kNone;
    std::int32_t triangleB = kNone;
};

/// Contacts of two meshes: all pairs of features within the threshold, each of which is the nearest
/// to the other on its own surface around it to within half a right angle, so that round things
/// touch with a patch of points; clustered into patches of like normals, each patch reduced to four
/// points that span it, and the deepest if that is not one of them (see reducePatches()). The
/// nearest contact of all comes first. Deterministic order. Empty if the meshes are farther apart;
/// where surfaces intersect, the edges that pierce a face are contacts with gap 0 and the normal of
/// the face.
/// @param X_WA, X_WB poses; the result is in W
/// @param threshold features at most so far apart are in contact [m], > 0
/// Throws QueryStopped if `stop` ended the query.
[[nodiscard]] BULLET_CCD_API std::vector<Contact> findContacts(const SsvTree& treeA,
                                                               const Eigen::Isometry3d& X_WA,
                                                               const SsvTree& treeB,
                                                               const Eigen::Isometry3d& X_WB,
                                                               double threshold,
                                                               const StopCondition& stop = {});
}  // namespace bullet_ccd
