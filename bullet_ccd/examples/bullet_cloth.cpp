// Cloth in Bullet's deformable world with btCcdDeformableBodySolver: one falls at 20 m/s onto a
// figure of triangles and lies on it, another is pulled through a ring. The stock solver, which
// differs in one line, lets the first fall through.
#include "bullet_ccd/bullet/btCcdDeformableBodySolver.h"
#include "bullet_ccd/examples/example_support.h"

#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::examples;
using Eigen::Vector3d;

constexpr double kTimeStep = 1.0 / 120.0;  // [s]

btVector3 vec(double x, double y, double z)
{
    return {btScalar(x), btScalar(y), btScalar(z)};
}

class ClothWorld
{
public:
    btSoftBodyRigidBodyCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    btDbvtBroadphase m_broadphase;
    btCcdDeformableBodySolver m_solver;
    btDeformableMultiBodyConstraintSolver m_constraintSolver;
    std::unique_ptr<btDeformableMultiBodyDynamicsWorld> m_world;
    btDeformableMassSpringForce m_springs{btScalar(5), btScalar(0.1), true};
    btDeformableGravityForce m_weight{vec(0, -10, 0)};
    std::unique_ptr<btCcdMeshShape> m_shape;
    std::unique_ptr<btRigidBody> m_obstacle;
    std::unique_ptr<btSoftBody> m_cloth;

    ClothWorld(TriangleMesh obstacle, double side, double height)
    {
        m_constraintSolver.setDeformableSolver(&m_solver);
        m_world = std::make_unique<btDeformableMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, &m_constraintSolver, &m_configuration, &m_solver);
        m_world->setGravity(vec(0, -10, 0));
        m_world->getWorldInfo().m_gravity = vec(0, -10, 0);
        m_world->setUseProjection(true);
        m_shape = meshShape(std::move(obstacle));
        m_obstacle = std::make_unique<btRigidBody>(
            btRigidBody::btRigidBodyConstructionInfo(0, nullptr, m_shape.get()));
        m_obstacle->setFriction(btScalar(0.5));
        m_world->addRigidBody(m_obstacle.get());
        const double s = 0.5 * side;
        m_cloth.reset(btSoftBodyHelpers::CreatePatch(m_world->getWorldInfo(),
                                                     vec(-s, height, -s),
                                                     vec(s, height, -s),
                                                     vec(-s, height, s),
                                                     vec(s, height, s),
                                                     25,
                                                     25,
                                                     0,
                                                     true));
        m_cloth->generateBendingConstraints(2);
        m_cloth->getCollisionShape()->setMargin(btScalar(0.005));
        m_cloth->setTotalMass(btScalar(0.5));
        m_cloth->m_cfg.kDF = btScalar(0.5);
        m_cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RD |
                                    btSoftBody::fCollision::SDF_RDN | btSoftBody::fCollision::VF_DD;
        m_cloth->setSelfCollision(true);
        m_world->addSoftBody(m_cloth.get());
        m_world->addForce(m_cloth.get(), &m_springs);
        m_world->addForce(m_cloth.get(), &m_weight);
    }
    ~ClothWorld()
    {
        m_world->removeSoftBodyForce(m_cloth.get());
        m_world->removeSoftBody(m_cloth.get());
        m_world->removeRigidBody(m_obstacle.get());
    }

    void run(double seconds)
    {
        const long steps = std::lround(seconds / kTimeStep);
        for (long i = 0; i < steps; ++i)
        {
            m_world->stepSimulation(btScalar(kTimeStep), 0);
        }
    }

    /// Nodes below the given height [m].
    [[nodiscard]] int countBelow(double height) const
    {
        int count = 0;
        for (int i = 0; i < m_cloth->m_nodes.size(); ++i)
        {
            count += m_cloth->m_nodes[i].m_x.y() < btScalar(height) ? 1 : 0;
        }
        return count;
    }
    /// The node nearest to the axis x = z = 0.
    btSoftBody::Node& middle()
    {
        int nearest = 0;
        const auto offAxis = [this](int i)
        {
            const btVector3& x = m_cloth->m_nodes[i].m_x;
            return x.x() * x.x() + x.z() * x.z();
        };
        for (int i = 1; i < m_cloth->m_nodes.size(); ++i)
        {
            nearest = offAxis(i) < offAxis(nearest) ? i : nearest;
        }
        return m_cloth->m_nodes[nearest];
    }
};

/// Something with a head and ears, on a plate.
TriangleMesh figure()
{
    TriangleMesh mesh = makeBox({2.0, 0.01, 2.0});
    const auto add = [&mesh](TriangleMesh part, const Vector3d& place)
    {
        transformMesh(part, Eigen::Affine3d(Eigen::Translation3d(place)));
        appendMesh(mesh, part);
    };
    add(makeSphere(0.2, 3), {0.0, 0.22, 0.0});
    add(makeSphere(0.12, 3), {0.15, 0.45, 0.0});
    for (const double side : {-1.0, 1.0})
    {
        TriangleMesh ear = makeCapsule(0.025, 0.15, 12);
        transformMesh(
            ear, Eigen::Affine3d(Eigen::AngleAxisd(-std::numbers::pi / 2.0, Vector3d::UnitX())));
        add(ear, {0.13, 0.6, 0.06 * side});
    }
    return mesh;
}

void dropOntoFigure()
{
    ClothWorld world(figure(), 1.2, 1.0);
    world.m_cloth->setVelocity(vec(0, -20, 0));
    world.run(0.5);
    const int through = world.countBelow(0.0);
    std::printf("%d of %d nodes are below the plate\n", through, world.m_cloth->m_nodes.size());
    check(through == 0, "the cloth lies on the figure");
}

void pullThroughRing()
{
    TriangleMesh ring = makeTorus(0.15, 0.03, 32, 12);
    transformMesh(ring,
                  Eigen::Affine3d(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3d::UnitX())));
    ClothWorld world(ring, 0.6, 0.1);
    // A node without mass goes as fast as it was told to.
    btSoftBody::Node& hand = world.middle();
    hand.m_im = 0;
    hand.m_v = vec(0, -0.5, 0);
    world.run(0.4);
    const int early = world.countBelow(-0.03);
    world.run(1.2);
    const int late = world.countBelow(-0.03);
    std::printf("of %d nodes %d are below the ring after 0.4 s, %d after 1.6 s\n",
                world.m_cloth->m_nodes.size(),
                early,
                late);
    check(early > 0 && early < world.m_cloth->m_nodes.size() && late > early,
          "the cloth is pulled through the ring");
    check(world.m_solver.getCcdSoftCounters().m_squeezed == 0,
          "nothing is squeezed through the ring");
}
}  // namespace

int main()
{
    dropOntoFigure();
    pullThroughRing();
    return exitCode();
}
