/// Deformable worlds for tests, soaks and benchmarks: soft bodies that fall onto things, and a
/// judge that shares nothing with the library: segments against triangles.
#pragma once

#include "bullet_ccd/bullet/btCcdDeformableBodySolver.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <Eigen/Geometry>

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <vector>

class btMultiBody;

namespace bullet_ccd::reference
{
enum class SoftWorld : std::uint8_t
{
    Stock,
    Solver,  ///< stock world, the library's solver
    World,   ///< the library's world
};

/// What went wrong so far.
struct SoftVerdict
{
    int through = 0;   ///< nodes that went through a triangle of an obstacle
    int crossing = 0;  ///< edges that cross triangles of soft bodies, when last looked at
    int notFinite = 0;
    [[nodiscard]] bool isClean() const { return through + crossing + notFinite == 0; }
};

std::ostream& operator<<(std::ostream& out, const SoftVerdict& verdict);

class SoftScene
{
public:
    explicit SoftScene(SoftWorld kind, const btVector3& gravity = btVector3(0, btScalar(-10), 0));
    ~SoftScene();
    SoftScene(const SoftScene&) = delete;
    SoftScene& operator=(const SoftScene&) = delete;

    /// A square of cells * cells * 2 triangles, horizontal in the frame X.
    btSoftBody* cloth(const Eigen::Isometry3d& X, double side, int cells, double mass);
    /// A chain of links along x.
    btSoftBody* rope(const Eigen::Isometry3d& X, double length, int links, double mass);
    /// A cube of cells^3 * 5 tetrahedra.
    btSoftBody* block(const Eigen::Isometry3d& X, double side, int cells, double mass);
    /// @param judged  what no node may go through, in the frame of the body
    btRigidBody* obstacle(std::unique_ptr<btCollisionShape> shape,
                          const TriangleMesh& judged,
                          const Eigen::Isometry3d& X = Eigen::Isometry3d::Identity(),
                          double mass = 0.0);
    /// A multibody with one prismatic joint along y, whose link has the shape.
    btMultiBody* slider(std::unique_ptr<btCollisionShape> shape,
                        const TriangleMesh& judged,
                        double mass);

    void step(double timeStep);
    /// Looks at all pairs of edges and triangles of soft bodies, and at the nodes.
    SoftVerdict judge();

    btDeformableMultiBodyDynamicsWorld& world() { return *m_world; }
    btCcdDeformableBodySolver* solver() { return m_ccdSolver; }  ///< null in a stock world
    /// Sum over nodes, rigid bodies and the base and links of multibodies [kg m/s].
    [[nodiscard]] Eigen::Vector3d momentum() const;
    [[nodiscard]] double seconds() const { return m_seconds; }  ///< processor time of all steps
    /// Of them where the library's solver checks and answers, with Bullet's integration of nodes.
    [[nodiscard]] double checkSeconds() const { return m_checkSeconds; }

private:
    struct Judged
    {
        const btCollisionObject* m_object;
        TriangleMesh m_mesh;
        Eigen::Isometry3d m_before;
    };

    std::unique_ptr<btCollisionConfiguration> m_configuration;
    std::unique_ptr<btCollisionDispatcher> m_dispatcher;
    std::unique_ptr<btBroadphaseInterface> m_broadphase;
    std::unique_ptr<btDeformableBodySolver> m_solver;
    std::unique_ptr<btDeformableMultiBodyConstraintSolver> m_constraintSolver;
    std::unique_ptr<btDeformableMultiBodyDynamicsWorld> m_world;
    btCcdDeformableBodySolver* m_ccdSolver = nullptr;
    btVector3 m_gravity;
    std::vector<std::unique_ptr<btDeformableLagrangianForce>> m_forces;
    std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
    std::vector<std::unique_ptr<btCollisionObject>> m_objects;
    std::vector<std::unique_ptr<btMultiBody>> m_multiBodies;
    std::vector<Judged> m_judged;
    std::vector<std::vector<std::uint8_t>> m_through;  // by soft body and node
    double m_seconds = 0.0;
    double m_checkSeconds = 0.0;

    void addSoft(btSoftBody* body, double mass, double stiffness);
};

/// True if the open segment from p to q meets the triangle.
[[nodiscard]] bool segmentMeetsTriangle(const Eigen::Vector3d& p,
                                        const Eigen::Vector3d& q,
                                        const Eigen::Vector3d& a,
                                        const Eigen::Vector3d& b,
                                        const Eigen::Vector3d& c);
}  // namespace bullet_ccd::reference
