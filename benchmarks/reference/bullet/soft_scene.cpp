#include "benchmarks/reference/bullet/soft_scene.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdDeformableMultiBodyDynamicsWorld.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <ostream>
#include <set>
#include <utility>

namespace bullet_ccd::reference
{
using Eigen::Vector3d;

namespace
{
double processorTime()
{
    return double(std::clock()) / double(CLOCKS_PER_SEC);
}

class TimedSolver : public btCcdDeformableBodySolver
{
public:
    explicit TimedSolver(double& seconds) : m_seconds(seconds) {}
    void applyTransforms(btScalar timeStep) override
    {
        const double begin = processorTime();
        btCcdDeformableBodySolver::applyTransforms(timeStep);
        m_seconds += processorTime() - begin;
    }

private:
    double& m_seconds;
};

std::vector<Vector3d> placesOf(const btSoftBody& body)
{
    std::vector<Vector3d> places;
    for (int i = 0; i < body.m_nodes.size(); ++i)
    {
        places.push_back(btCcdToEigen(body.m_nodes[i].m_x));
    }
    return places;
}

using Edge = std::pair<const btSoftBody::Node*, const btSoftBody::Node*>;

/// Edges of the faces; without faces all links.
std::set<Edge> edgesOf(const btSoftBody& body)
{
    std::set<Edge> edges;
    for (int i = 0; i < body.m_faces.size(); ++i)
    {
        for (int k = 0; k < 3; ++k)
        {
            edges.insert(std::minmax<const btSoftBody::Node*>(body.m_faces[i].m_n[k],
                                                              body.m_faces[i].m_n[(k + 1) % 3]));
        }
    }
    for (int i = 0; i < body.m_links.size() && body.m_faces.size() == 0; ++i)
    {
        edges.insert(
            std::minmax<const btSoftBody::Node*>(body.m_links[i].m_n[0], body.m_links[i].m_n[1]));
    }
    return edges;
}

/// Edges of bodyA that cross triangles of bodyB; features with a common node are left out.
int crossings(const btSoftBody& bodyA, const btSoftBody& bodyB)
{
    struct Face
    {
        std::array<Vector3d, 3> m_x;
        Eigen::AlignedBox3d m_box;
    };
    std::vector<Face> faces;
    for (int i = 0; i < bodyB.m_faces.size(); ++i)
    {
        Face face;
        for (int k = 0; k < 3; ++k)
        {
            face.m_x[std::size_t(k)] = btCcdToEigen(bodyB.m_faces[i].m_n[k]->m_x);
            face.m_box.extend(face.m_x[std::size_t(k)]);
        }
        faces.push_back(face);
    }
    int count = 0;
    for (const auto& [first, second] : edgesOf(bodyA))
    {
        const Vector3d p = btCcdToEigen(first->m_x);
        const Vector3d q = btCcdToEigen(second->m_x);
        const Eigen::AlignedBox3d box(p.cwiseMin(q), p.cwiseMax(q));
        for (std::size_t f = 0; f < faces.size(); ++f)
        {
            if (!box.intersects(faces[f].m_box))
            {
                continue;
            }
            const btSoftBody::Face& face = bodyB.m_faces[int(f)];
            bool isNeighbour = false;
            for (int k = 0; k < 3; ++k)
            {
                isNeighbour = isNeighbour || face.m_n[k] == first || face.m_n[k] == second;
            }
            const std::array<Vector3d, 3>& x = faces[f].m_x;
            count += !isNeighbour && segmentMeetsTriangle(p, q, x[0], x[1], x[2]) ? 1 : 0;
        }
    }
    return count;
}
}  // namespace

bool segmentMeetsTriangle(
    const Vector3d& p, const Vector3d& q, const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    const Vector3d normal = (b - a).cross(c - a);
    const double before = normal.dot(p - a);
    const double after = normal.dot(q - a);
    if (!(before * after < 0.0))
    {
        return false;
    }
    const Vector3d x = p + before / (before - after) * (q - p);
    return normal.dot((b - a).cross(x - a)) >= 0.0 && normal.dot((c - b).cross(x - b)) >= 0.0 &&
           normal.dot((a - c).cross(x - c)) >= 0.0;
}

SoftScene::SoftScene(SoftWorld kind, const btVector3& gravity)
    : m_configuration(std::make_unique<btSoftBodyRigidBodyCollisionConfiguration>()),
      m_dispatcher(std::make_unique<btCollisionDispatcher>(m_configuration.get())),
      m_broadphase(std::make_unique<btDbvtBroadphase>()),
      m_constraintSolver(std::make_unique<btDeformableMultiBodyConstraintSolver>()),
      m_gravity(gravity)
{
    if (kind == SoftWorld::Stock)
    {
        m_solver = std::make_unique<btDeformableBodySolver>();
    }
    else
    {
        auto solver = std::make_unique<TimedSolver>(m_checkSeconds);
        m_ccdSolver = solver.get();
        m_solver = std::move(solver);
    }
    m_constraintSolver->setDeformableSolver(m_solver.get());
    if (kind == SoftWorld::World)
    {
        m_world = std::make_unique<btCcdDeformableMultiBodyDynamicsWorld>(m_dispatcher.get(),
                                                                          m_broadphase.get(),
                                                                          m_constraintSolver.get(),
                                                                          m_configuration.get(),
                                                                          m_ccdSolver);
    }
    else
    {
        m_world = std::make_unique<btDeformableMultiBodyDynamicsWorld>(m_dispatcher.get(),
                                                                       m_broadphase.get(),
                                                                       m_constraintSolver.get(),
                                                                       m_configuration.get(),
                                                                       m_solver.get());
    }
    m_world->setGravity(gravity);
    btSoftBodyWorldInfo& info = m_world->getWorldInfo();
    info.m_gravity = gravity;
    info.m_sparsesdf.setDefaultVoxelsz(btScalar(0.01));
    info.m_sparsesdf.Reset();
    info.m_maxDisplacement = btScalar(10);
    m_world->setUseProjection(true);
    m_world->setImplicit(false);
    m_world->setLineSearch(false);
}

SoftScene::~SoftScene()
{
    for (std::unique_ptr<btMultiBody>& body : m_multiBodies)
    {
        m_world->removeMultiBody(body.get());
    }
    for (std::unique_ptr<btCollisionObject>& object : m_objects)
    {
        if (btSoftBody* body = btSoftBody::upcast(object.get()))
        {
            m_world->removeSoftBodyForce(body);
            m_world->removeSoftBody(body);
        }
        else
        {
            m_world->removeCollisionObject(object.get());
        }
    }
}

void SoftScene::addSoft(btSoftBody* body, double mass, double stiffness)
{
    m_objects.emplace_back(body);
    body->getCollisionShape()->setMargin(btScalar(0.005));
    body->setTotalMass(btScalar(mass));
    body->m_cfg.kKHR = 1;
    body->m_cfg.kCHR = 1;
    body->m_cfg.kDF = btScalar(0.3);
    body->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN |
                             btSoftBody::fCollision::SDF_RDF | btSoftBody::fCollision::VF_DD;
    body->setSpringStiffness(btScalar(4));
    m_world->addSoftBody(body);
    body->setSelfCollision(true);
    m_forces.push_back(
        std::make_unique<btDeformableMassSpringForce>(btScalar(stiffness), btScalar(0.05), true));
    m_world->addForce(body, m_forces.back().get());
    m_forces.push_back(std::make_unique<btDeformableGravityForce>(m_gravity));
    m_world->addForce(body, m_forces.back().get());
    m_through.emplace_back(std::size_t(body->m_nodes.size()), 0);
}

btSoftBody* SoftScene::cloth(const Eigen::Isometry3d& X, double side, int cells, double mass)
{
    const double s = 0.5 * side;
    btSoftBody* body = btSoftBodyHelpers::CreatePatch(m_world->getWorldInfo(),
                                                      btCcdToBullet(X * Vector3d(-s, 0, -s)),
                                                      btCcdToBullet(X * Vector3d(s, 0, -s)),
                                                      btCcdToBullet(X * Vector3d(-s, 0, s)),
                                                      btCcdToBullet(X * Vector3d(s, 0, s)),
                                                      cells + 1,
                                                      cells + 1,
                                                      0,
                                                      true);
    body->generateBendingConstraints(2);
    addSoft(body, mass, 2.0);
    return body;
}

btSoftBody* SoftScene::rope(const Eigen::Isometry3d& X, double length, int links, double mass)
{
    btSoftBody* body =
        btSoftBodyHelpers::CreateRope(m_world->getWorldInfo(),
                                      btCcdToBullet(X * Vector3d(-0.5 * length, 0, 0)),
                                      btCcdToBullet(X * Vector3d(0.5 * length, 0, 0)),
                                      links - 1,
                                      0);
    addSoft(body, mass, 2.0);
    return body;
}

btSoftBody* SoftScene::block(const Eigen::Isometry3d& X, double side, int cells, double mass)
{
    const int n = cells + 1;
    std::vector<btVector3> places;
    for (int i = 0; i < n * n * n; ++i)
    {
        const Vector3d grid(i % n, i / n % n, i / (n * n));
        places.push_back(
            btCcdToBullet(X * Vector3d(side * (grid / cells - Vector3d::Constant(0.5)))));
    }
    const std::vector<btScalar> masses(places.size(), btScalar(1));
    auto* body =
        new btSoftBody(&m_world->getWorldInfo(), int(places.size()), places.data(), masses.data());
    const auto index = [n](int x, int y, int z) { return x + n * (y + n * z); };
    for (int i = 0; i < cells * cells * cells; ++i)
    {
        const int x = i % cells;
        const int y = i / cells % cells;
        const int z = i / (cells * cells);
        std::array<int, 8> corner{};
        for (int k = 0; k < 8; ++k)
        {
            corner[std::size_t(k)] = index(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
        }
        // Cells alternate, so that the diagonals of neighbours are the same.
        const int flip = (x + y + z) % 2;
        const std::array<std::array<int, 4>, 5> tetras{
            {{0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}}};
        for (const std::array<int, 4>& tetra : tetras)
        {
            std::array<int, 4> v{};
            for (std::size_t k = 0; k < 4; ++k)
            {
                v[k] = corner[std::size_t(tetra[k] ^ flip)];
            }
            body->appendTetra(v[0], v[1], v[2], v[3]);
            for (int a = 0; a < 4; ++a)
            {
                for (int b = 0; b < a; ++b)
                {
                    body->appendLink(v[std::size_t(a)], v[std::size_t(b)], nullptr, true);
                }
            }
        }
    }
    btSoftBodyHelpers::generateBoundaryFaces(body);
    body->initializeDmInverse();
    body->m_tetraScratches.resize(body->m_tetras.size());
    body->m_tetraScratchesTn.resize(body->m_tetras.size());
    addSoft(body, mass, 20.0);
    return body;
}

btRigidBody* SoftScene::obstacle(std::unique_ptr<btCollisionShape> shape,
                                 const TriangleMesh& judged,
                                 const Eigen::Isometry3d& X,
                                 double mass)
{
    btVector3 inertia(0, 0, 0);
    if (mass > 0.0)
    {
        shape->calculateLocalInertia(btScalar(mass), inertia);
    }
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = btCcdToBullet(X);
    auto body = std::make_unique<btRigidBody>(info);
    btRigidBody* result = body.get();
    m_world->addRigidBody(result);
    m_judged.push_back({result, judged, btCcdToEigen(result->getWorldTransform())});
    m_shapes.push_back(std::move(shape));
    m_objects.push_back(std::move(body));
    return result;
}

btMultiBody* SoftScene::slider(std::unique_ptr<btCollisionShape> shape,
                               const TriangleMesh& judged,
                               double mass)
{
    auto body = std::make_unique<btMultiBody>(1, btScalar(1), btVector3(1, 1, 1), true, false);
    btVector3 inertia;
    shape->calculateLocalInertia(btScalar(mass), inertia);
    body->setupPrismatic(0,
                         btScalar(mass),
                         inertia,
                         -1,
                         btQuaternion(0, 0, 0, 1),
                         btVector3(0, 1, 0),
                         btVector3(0, 0, 0),
                         btVector3(0, 0, 0),
                         true);
    body->finalizeMultiDof();
    m_world->addMultiBody(body.get());
    auto collider = std::make_unique<btMultiBodyLinkCollider>(body.get(), 0);
    collider->setCollisionShape(shape.get());
    body->getLink(0).m_collider = collider.get();
    m_world->addCollisionObject(collider.get());
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> places;
    body->forwardKinematics(turns, places);
    body->updateCollisionObjectWorldTransforms(turns, places);
    m_judged.push_back({collider.get(), judged, btCcdToEigen(collider->getWorldTransform())});
    m_shapes.push_back(std::move(shape));
    m_objects.push_back(std::move(collider));
    m_multiBodies.push_back(std::move(body));
    return m_multiBodies.back().get();
}

void SoftScene::step(double timeStep)
{
    const btSoftBodyArray& bodies = m_world->getSoftBodyArray();
    std::vector<std::vector<Vector3d>> before;
    for (int i = 0; i < bodies.size(); ++i)
    {
        before.push_back(placesOf(*bodies[i]));
    }
    const double begin = processorTime();
    m_world->stepSimulation(btScalar(timeStep), 0);
    m_seconds += processorTime() - begin;
    for (Judged& judged : m_judged)
    {
        // The way of a node in the frame of the object is a chord of a curve, if the object turns:
        // it may cut through what the node has gone round. So may the chord with the turn left out.
        const Eigen::Isometry3d X_W1 = btCcdToEigen(judged.m_object->getWorldTransform());
        const Eigen::Isometry3d X_B0W = judged.m_before.inverse();
        Eigen::Isometry3d unturned = X_W1;
        unturned.translation() = judged.m_before.translation();
        const Eigen::Isometry3d X_U0W = unturned.inverse();
        const Eigen::Isometry3d X_B1W = X_W1.inverse();
        judged.m_before = X_W1;
        const Eigen::AlignedBox3d box = bounds(judged.m_mesh);
        const std::vector<Vector3d>& x = judged.m_mesh.vertices;
        for (std::size_t i = 0; i < before.size(); ++i)
        {
            for (std::size_t v = 0; v < before[i].size(); ++v)
            {
                const Vector3d q = X_B1W * btCcdToEigen(bodies[int(i)]->m_nodes[int(v)].m_x);
                const auto isThrough = [&](const Vector3d& p)
                {
                    const auto meets = [&](const Triangle& t)
                    {
                        return segmentMeetsTriangle(
                            p, q, x[std::size_t(t[0])], x[std::size_t(t[1])], x[std::size_t(t[2])]);
                    };
                    return box.intersects(Eigen::AlignedBox3d(p.cwiseMin(q), p.cwiseMax(q))) &&
                           std::ranges::any_of(judged.m_mesh.triangles, meets);
                };
                if (isThrough(X_B0W * before[i][v]) && isThrough(X_U0W * before[i][v]))
                {
                    m_through[i][v] = 1;
                }
            }
        }
    }
}

SoftVerdict SoftScene::judge()
{
    SoftVerdict verdict;
    const btSoftBodyArray& bodies = m_world->getSoftBodyArray();
    for (int i = 0; i < bodies.size(); ++i)
    {
        for (const std::uint8_t through : m_through[std::size_t(i)])
        {
            verdict.through += through;
        }
        for (const Vector3d& x : placesOf(*bodies[i]))
        {
            verdict.notFinite += x.allFinite() ? 0 : 1;
        }
        for (int j = 0; j < bodies.size(); ++j)
        {
            verdict.crossing += crossings(*bodies[i], *bodies[j]);
        }
    }
    return verdict;
}

std::ostream& operator<<(std::ostream& out, const SoftVerdict& verdict)
{
    return out << verdict.through << " nodes went through, " << verdict.crossing
               << " edges cross faces, " << verdict.notFinite << " nodes are not finite";
}

Eigen::Vector3d SoftScene::momentum() const
{
    Vector3d sum = Vector3d::Zero();
    for (const std::unique_ptr<btCollisionObject>& object : m_objects)
    {
        if (const btSoftBody* soft = btSoftBody::upcast(object.get()))
        {
            for (int i = 0; i < soft->m_nodes.size(); ++i)
            {
                const btSoftBody::Node& node = soft->m_nodes[i];
                sum += node.m_im > 0 ? Vector3d(btCcdToEigen(node.m_v) / double(node.m_im))
                                     : Vector3d::Zero();
            }
        }
        else if (const btRigidBody* rigid = btRigidBody::upcast(object.get()))
        {
            sum += rigid->getInvMass() > 0 ? Vector3d(btCcdToEigen(rigid->getLinearVelocity()) /
                                                      double(rigid->getInvMass()))
                                           : Vector3d::Zero();
        }
    }
    for (const std::unique_ptr<btMultiBody>& body : m_multiBodies)
    {
        sum.y() += double(body->getLinkMass(0)) * double(body->getJointVel(0));
    }
    return sum;
}
}  // namespace bullet_ccd::reference
