/// Which way two meshes come apart that intersect, or of which one is inside the other.
#pragma once

#include "bullet_ccd/contact/contacts.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/export.h"
#include "bullet_ccd/hierarchy/ssv_tree.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <span>
#include <vector>

namespace bullet_ccd
{
/// True for a closed mesh that is wound so that its inside is below its triangles.
[[nodiscard]] BULLET_CCD_API bool hasInside(const TriangleMesh& mesh);

/// A mesh as it lies in the world. `isSolid` says of one with an inside that nothing else may be
/// there.
struct PosedSolid
{
    const SsvTree* tree;
    Eigen::Isometry3d X_W;
    bool isSolid;
};

/// Tries directions in which A comes out of B, and keeps the shortest way. One for each question;
/// it refers to the trees.
///
/// A is out where the distance of the meshes is at least a quarter of the shell, and none of them
/// is inside what is solid; it is moved no farther than to the whole shell. Where nothing is solid
/// a way is at most the smaller of both radii long, else twice that: beyond it, nobody knows
/// whether what is caught comes out or goes in deeper.
class BULLET_CCD_API WayOut
{
public:
    /// Meshes nearer than this part of the shell are taken apart,
    static constexpr double kNear = 1.0 / 16.0;
    /// to this part of it at least.
    static constexpr double kApart = 1.0 / 4.0;
    /// Ways of more shells than this may lead past other walls.
    static constexpr double kShort = 8.0;

    /// @param shell how far from each other contacts are to keep them [m], > 0
    WayOut(const PosedSolid& a, const PosedSolid& b, double shell);

    /// Tries to move A against the normal, a unit vector.
    void look(const Eigen::Vector3d& normal);
    /// The same for the way that they came, and, if that is no longer found or much longer than
    /// `formerWay`, against the normals of the contacts, with and against them where one is solid,
    /// and along those of the faces that meet.
    /// @param former zero if nothing is known of how they came
    void lookAlong(std::span<const Contact> contacts,
                   const Eigen::Vector3d& former,
                   double formerWay);
    /// Between walls that leave little room, such as those of a slot: tries short ways one after
    /// the other, along the normals of the contacts and of the faces that meet, and between them.
    /// Out is where the meshes are farthest apart, if that is nowhere a quarter of the shell.
    void lookNear(std::span<const Contact> contacts);
    /// Where A is wholly inside, its surface is far from that of B. From a few shells more than so
    /// far out, against the normal, it is moved back in until it meets B; not found if it comes to
    /// where it is.
    void comeBack(const Eigen::Vector3d& normal, double formerWay);
    /// Others must be this much shorter than what was found.
    void prefer(double factor) { m_limit /= factor; }

    [[nodiscard]] bool isFound() const { return !m_normal.isZero(); }
    [[nodiscard]] double way() const { return m_way; }  ///< [m]
    /// From A to B, as that of a contact: A moves against it.
    [[nodiscard]] const Eigen::Vector3d& normal() const { return m_normal; }
    /// Of A, moved out.
    [[nodiscard]] Eigen::Isometry3d poseOfA() const { return moved(m_normal, m_way); }
    /// Takes contacts found with A at poseOfA() back to where it is. Drops those that have a gap
    /// beyond `around` then.
    void takeBack(std::vector<Contact>& contacts, std::size_t first, double around) const;

    /// Something is solid.
    [[nodiscard]] bool isKnown() const { return m_a.isSolid || m_b.isSolid; }
    /// Where one is wholly inside the other, which is solid, the unit direction to the nearest
    /// surface, from A to B; zero else, and where that is farther than any way may be.
    [[nodiscard]] Eigen::Vector3d nearestOut() const;

private:
    void lookNear(const Eigen::Vector3d& normal);
    [[nodiscard]] Eigen::Isometry3d moved(const Eigen::Vector3d& normal, double way) const;
    [[nodiscard]] TrianglePair nearestOf(const Eigen::Isometry3d& X_WA, double bound) const;
    [[nodiscard]] bool isInside(const TrianglePair& nearest, const Eigen::Isometry3d& X_WA) const;
    [[nodiscard]] double distanceAt(const Eigen::Vector3d& normal, double way) const;

    PosedSolid m_a;
    PosedSolid m_b;
    double m_shell;
    double m_limit;
    double m_farthest;
    double m_way = 0.0;
    Eigen::Vector3d m_normal = Eigen::Vector3d::Zero();
};
}  // namespace bullet_ccd
