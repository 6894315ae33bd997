/// The exact check for a Bullet world (double precision): every pose at which a step changes a
/// velocity, and the motion in between.
///
/// Bullet moves everything at constant velocity from the start of a step to its first impact, from
/// there to the next, and so on to the end. The impact listener notes where everything is at each
/// impact; between two of these knots bodies are where betweenPoses() puts them, joints of a
/// multibody at constant rates.
#pragma once

#include "benchmarks/reference/audit/mesh_audit.h"
#include "bullet_ccd/bullet/btCcdControl.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <map>
#include <memory>
#include <utility>
#include <vector>

class btMultiBody;

namespace bullet_ccd::reference
{
/// In a step so many poses are looked at that no point moves farther from one to the next than
/// `longestMove`, but at most `mostSamples`; and at each knot the bodies that meet there.
struct AuditDensity
{
    double longestMove = 1e-3;  ///< [m]
    int mostSamples = 1;        ///< 1: only where the step ends, and knots
};

class WorldAudit : public btCcdImpactListener
{
public:
    WorldAudit(btDiscreteDynamicsWorld& world, AuditDensity density)
        : m_world(&world), m_density(density)
    {
    }

    /// A collider to be looked at; its number in the results. `X_OM` is the mesh in its frame.
    std::int32_t add(btCollisionObject* object,
                     std::shared_ptr<const AuditMesh> mesh,
                     const Eigen::Isometry3d& X_OM = Eigen::Isometry3d::Identity());
    /// For links: the joints between knots are interpolated, not the links' poses. The base is
    /// fixed. After add().
    void addMultiBody(btMultiBody* body);
    void ignore(std::int32_t a, std::int32_t b) { m_scene.ignored.insert(std::minmax(a, b)); }

    /// Looks at the present poses and remembers them as the start of the next step.
    AuditResult start();
    /// One step of the world, without sub-division, and what is found in it.
    AuditResult step(double timeStep);
    /// Of the processor, that the steps of the world have taken so far.
    [[nodiscard]] double seconds() const { return m_seconds; }

    btCcdAfterImpact onImpact(const btCcdImpact& impact) override;

    /// Bodies that met most often, and how often; kNone if none did.
    struct Busiest
    {
        std::int32_t bodyA = kNone;
        std::int32_t bodyB = kNone;
        std::int64_t impacts = 0;
    };
    [[nodiscard]] Busiest busiestPair() const;

private:
    struct Knot
    {
        double time = 0.0;
        BodyPoses poses = {};
        std::vector<double> joints = {};         // of all multibodies, one after the other
        std::vector<std::int32_t> meeting = {};  // bodies that have an impact then
    };

    btDiscreteDynamicsWorld* m_world;
    AuditDensity m_density;
    AuditScene m_scene;
    std::vector<std::shared_ptr<const AuditMesh>> m_meshes;
    std::vector<btCollisionObject*> m_objects;
    std::vector<double> m_reaches;  // of each body's mesh from its origin
    std::vector<btMultiBody*> m_multiBodies;
    std::vector<Knot> m_knots;
    double m_time = 0.0;
    double m_seconds = 0.0;
    std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, std::int64_t> m_impacts;

    [[nodiscard]] Knot now(double time) const;
    void setJoints(const std::vector<double>& joints);
    [[nodiscard]] std::int32_t indexOf(const btCollisionObject* object) const;
    /// What any point moves from one to the other, at most [m].
    [[nodiscard]] double motionBetween(const Knot& from, const Knot& to) const;
    [[nodiscard]] Knot between(const Knot& from, const Knot& to, double s);
};
}  // namespace bullet_ccd::reference
