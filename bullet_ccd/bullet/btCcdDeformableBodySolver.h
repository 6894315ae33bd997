/// btDeformableBodySolver with continuous collision detection for soft bodies.
#ifndef BT_CCD_DEFORMABLE_BODY_SOLVER_H
#define BT_CCD_DEFORMABLE_BODY_SOLVER_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/export.h"

#include <BulletSoftBody/btDeformableBodySolver.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

class btCcdSoftStep;
class btIDebugDraw;

/// Counts since the solver was made or the counters were reset.
struct btCcdSoftCounters
{
    std::int64_t m_queries = 0;     ///< questions for all contacts of a step; one if nothing meets
    std::int64_t m_contacts = 0;    ///< pairs of features that came near
    std::int64_t m_rounds = 0;      ///< in which paths that had been bent met something else
    std::int64_t m_held = 0;        ///< paths of nodes that were shortened, in all rounds
    std::int64_t m_heldBodies = 0;  ///< rigid bodies and multibodies that a step took back
    std::int64_t m_overlaps = 0;    ///< pairs of features that touched when their step began
    std::int64_t m_squeezed = 0;    ///< contacts that are left between what cannot give way
    std::int64_t m_unchecked = 0;   ///< steps with too many contacts: all soft bodies were held
    std::int64_t m_uncovered = 0;   ///< colliders near soft bodies that the last step did not cover
};

/// Drop-in for btDeformableBodySolver. The world stays what it is:
///
///     btCcdDeformableBodySolver* solver = new btCcdDeformableBodySolver;  // changed
///
/// Before positions are integrated, the paths of all nodes are checked against each other and
/// against all colliders: vertices against faces and edges against edges, continuously in time.
/// What would meet is given new velocities and shorter paths.
///
/// Guarantee: surfaces that are apart when a step begins stay apart; they keep half of the
/// separation, and pairs that begin nearer keep half of what they have. Nodes go straight from the
/// place where the step finds them to where it leaves them, and so do the vertices of colliders.
/// Excepted: nodes that are pinned or anchored and meet what they cannot evade, and what is
/// squeezed between objects that nothing can stop (kinematic objects); both are counted
/// (m_squeezed). A multibody between which and something else a soft body is squeezed is held
/// back with all its joints; a kinematic object does not move it through a soft body, as it does
/// rigid bodies. Of a soft body that intersects itself or something else already, the
/// features that intersect are left alone. Faces and links of an anchored node are not tested
/// against the object that it hangs on, which they touch where it is anchored.
///
/// Contacts are inelastic or bounce as btCollisionObject::getRestitution() of both says, and rub
/// with the product of the coefficients of friction (of a soft body m_cfg.kDF). Impulses between
/// soft bodies, and between them and rigid bodies or multibodies, are equal and opposite. At rest,
/// surfaces lie at the separation.
///
/// Stock contacts of soft bodies with convex shapes stay, with their margins. Those with concave
/// shapes (meshes, height fields, planes), from which Bullet keeps 6 cm, and those of soft bodies
/// with each other and themselves (VF_DD in m_cfg.collisions) do not: all these meet at the
/// separation.
///
/// Covered: cloth, ropes (links without faces), volumes (their faces or the boundary of their
/// tetrahedra); every collider that btCcdControl covers. Filters are Bullet's; a soft body meets
/// itself if setSelfCollision(true) says so.
ATTRIBUTE_ALIGNED16(class)
BULLET_CCD_API btCcdDeformableBodySolver : public btDeformableBodySolver
{
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    btCcdDeformableBodySolver();
    ~btCcdDeformableBodySolver() override;

    /// Distance at which surfaces rest [m], 1e-3 unless set; in effect at most a fifth of the
    /// shortest edge of a soft body. In single precision take at least 1000 times the rounding of
    /// the largest coordinate. Throws std::invalid_argument unless it is positive and finite.
    void setCcdSeparation(double separation);
    [[nodiscard]] double getCcdSeparation() const;
    /// Threads that look for contacts; the outcome does not depend on them. Throws
    /// std::invalid_argument if there is none.
    void setCcdThreads(int threads);
    /// Off: stock Bullet.
    void setCcdEnabled(bool enabled)
    {
        m_isEnabled = enabled;
    }
    [[nodiscard]] const btCcdSoftCounters& getCcdSoftCounters() const;
    void resetCcdSoftCounters();
    /// For shapes of colliders that were changed in place.
    void forgetCcdShape(const btCollisionShape* shape);

    /// In wire-frame mode: contacts of the last step (red: the closest points of both features and
    /// the normal), and the paths that were bent or shortened (yellow). Contacts are kept from the
    /// first call on. The world of the same name calls it in debugDrawWorld().
    void debugDraw(btIDebugDraw * drawer);

    void predictMotion(btScalar timeStep) override;
    void solveDeformableConstraints(btScalar timeStep) override;
    void applyTransforms(btScalar timeStep) override;
    void processCollision(btSoftBody * softBody, const btCollisionObjectWrapper* collider) override;
    void processCollision(btSoftBody * softBody, btSoftBody * other) override
    {
        btDeformableBodySolver::processCollision(softBody, other);
    }

private:
    std::unique_ptr<btCcdSoftStep> m_step;
    /// Soft bodies with their activation states. They sleep while Bullet answers contacts of soft
    /// bodies with each other: at another distance, and without regard to momentum.
    std::vector<std::pair<btSoftBody*, int>> m_leftOut;
    bool m_isEnabled = true;
};

#endif  // BT_CCD_DEFORMABLE_BODY_SOLVER_H
