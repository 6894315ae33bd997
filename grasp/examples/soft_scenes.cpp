// Soft bodies in Bullet's deformable world where stock Bullet gives up: a cloth falls on a bunny,
// one is twisted and pulled through a ring, ten lie on a table, a soft ball goes between gears.
// Everything meets continuously in time.
//
//   soft_scenes FOLDER [bunny|ring|layers|gears ...]
//
// Writes a strip of pictures a scene, FOLDER/<scene>.png. A check of its own looks at edges and
// faces: none may cross. The exit code is 0 if nothing crosses and every scene ends as it should.
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdDeformableMultiBodyDynamicsWorld.h"
#include "bullet_ccd/bullet/btCcdMeshShape.h"
#include "grasp/examples/soft_support.h"
#include "grasp/report/grasp_scene.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::grasp;
using namespace bullet_ccd::grasp::examples;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kTimeStep = 1.0 / 1000.0;  // [s]
constexpr double kGravity = 9.81;           // [m/s^2], along -z
constexpr int kPictures = 6;

Isometry3d at(double x, double y, double z)
{
    Isometry3d X = Isometry3d::Identity();
    X.translation() = Vector3d(x, y, z);
    return X;
}

class SoftScene
{
public:
    SoftScene(double pixelsPerMetre,
              const Vector3d& middle,
              const Vector3d& from = Vector3d(0.75, -0.9, 0.55))
        : m_camera{.R_CW = lookFrom(from.normalized(), Vector3d::UnitZ()),
                   .center_W = middle,
                   .pixelsPerMetre = pixelsPerMetre,
                   .width = 640,
                   .height = 640}
    {
        m_constraintSolver.setDeformableSolver(&m_solver);
        m_world = std::make_unique<btCcdDeformableMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, &m_constraintSolver, &m_configuration, &m_solver);
        m_world->setGravity(vec(0, 0, 0));
        m_world->setUseProjection(true);
        m_world->getWorldInfo().m_gravity.setZero();
        m_world->getWorldInfo().m_maxDisplacement = 1;
    }
    ~SoftScene()
    {
        for (const Soft& soft : m_softs)
        {
            m_world->removeSoftBodyForce(soft.m_body.get());
            m_world->removeSoftBody(soft.m_body.get());
        }
        for (const Solid& solid : m_solids)
        {
            m_world->removeRigidBody(solid.m_body.get());
        }
    }
    SoftScene(const SoftScene&) = delete;
    SoftScene& operator=(const SoftScene&) = delete;

    /// A square across z, turned about z.
    btSoftBody& addCloth(double side, int cells, double height, double turn, const Color& color)
    {
        const auto corner = [&](double x, double y)
        {
            const Eigen::Rotation2Dd R(turn);
            const Eigen::Vector2d p = R * Eigen::Vector2d(0.5 * side * x, 0.5 * side * y);
            return vec(p.x(), p.y(), height);
        };
        btSoftBody* body = btSoftBodyHelpers::CreatePatch(m_world->getWorldInfo(),
                                                          corner(-1, -1),
                                                          corner(1, -1),
                                                          corner(-1, 1),
                                                          corner(1, 1),
                                                          cells + 1,
                                                          cells + 1,
                                                          0,
                                                          true);
        body->generateBendingConstraints(2);
        return add(body, 0.3 * side * side, color);
    }
    btSoftBody& addBall(double radius, double mass, const Isometry3d& X, const Color& color)
    {
        btSoftBody* body = makeVolume(m_world->getWorldInfo(),
                                      radius / 4.0,
                                      12,
                                      [radius](const Vector3d& x)
                                      { return (x - Vector3d(0.0, 0.0, radius)).norm() - radius; });
        body->transform(btCcdToBullet(X));
        return add(body, mass, color);
    }
    /// One that stays, or that turns about the axis y of its frame.
    void addSolid(TriangleMesh mesh, const Isometry3d& X, double turning = 0.0)
    {
        Solid solid{.m_shape = btCcdMeshShape::fromMesh(mesh), .m_turning = turning};
        btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, solid.m_shape.get());
        info.m_startWorldTransform = btCcdToBullet(X);
        solid.m_body = std::make_unique<btRigidBody>(info);
        solid.m_body->setFriction(btScalar(0.8));
        if (turning != 0.0)
        {
            solid.m_body->setCollisionFlags(solid.m_body->getCollisionFlags() |
                                            btCollisionObject::CF_KINEMATIC_OBJECT);
            solid.m_body->setActivationState(DISABLE_DEACTIVATION);
        }
        m_world->addRigidBody(solid.m_body.get());
        solid.m_mesh = std::move(mesh);
        m_solids.push_back(std::move(solid));
    }

    /// Nodes without mass turn about z and go along it.
    void setHand(btSoftBody& body, const std::vector<int>& nodes, double turning, double speed)
    {
        m_hand = [&body, nodes, turning, speed]
        {
            for (const int i : nodes)
            {
                // To where the circle leads, not along its tangent.
                const btVector3& x = body.m_nodes[i].m_x;
                const btVector3 next =
                    btMatrix3x3(btQuaternion(vec(0, 0, 1), btScalar(turning * kTimeStep))) * x;
                body.m_nodes[i].m_v = (next - x) / btScalar(kTimeStep) + vec(0, 0, speed);
            }
        };
    }

    void run(double seconds)
    {
        const int steps = int(std::lround(seconds / kTimeStep));
        const int pause = std::max(1, steps / (kPictures - 1));
        for (int i = 0; i <= steps; ++i)
        {
            if (i % pause == 0 && int(m_pictures.size()) < kPictures)
            {
                m_pictures.push_back(picture());
            }
            if (i % 25 == 0)
            {
                m_crossing += countCrossings();
                ++m_checks;
            }
            for (Solid& solid : m_solids)
            {
                if (solid.m_turning != 0.0)
                {
                    btTransform pose = solid.m_body->getWorldTransform();
                    pose.setRotation(
                        btQuaternion(vec(0, 1, 0), btScalar(i * kTimeStep * solid.m_turning)));
                    solid.m_body->setWorldTransform(pose);
                }
            }
            if (m_hand)
            {
                m_hand();
            }
            m_world->stepSimulation(btScalar(kTimeStep), 0);
        }
    }

    /// Writes the pictures and says what was seen. Returns whether nothing crossed and `holds`.
    bool finish(const std::filesystem::path& folder,
                const std::string& name,
                bool holds,
                const std::string& what) const
    {
        writeStrip(m_pictures, folder / (name + ".png"));
        int nodes = 0;
        int faces = 0;
        for (const Soft& soft : m_softs)
        {
            nodes += soft.m_body->m_nodes.size();
            faces += soft.m_body->m_faces.size();
        }
        const btCcdSoftCounters& counters = m_solver.getCcdSoftCounters();
        std::printf(
            "%-7s %5d nodes %5d faces: %d edges cross faces in %d checks; %lld contacts, %lld "
            "squeezed; %s -> %s\n",
            name.c_str(),
            nodes,
            faces,
            m_crossing,
            m_checks,
            static_cast<long long>(counters.m_contacts),
            static_cast<long long>(counters.m_squeezed),
            what.c_str(),
            m_crossing == 0 && holds ? "ok" : "FAILED");
        return m_crossing == 0 && holds;
    }

private:
    struct Soft
    {
        std::unique_ptr<btSoftBody> m_body;
        std::unique_ptr<btDeformableLagrangianForce> m_springs;
        std::unique_ptr<btDeformableLagrangianForce> m_weight;
        Color m_color;
    };
    struct Solid
    {
        std::unique_ptr<btCollisionShape> m_shape;
        double m_turning = 0.0;  // [rad/s]
        std::unique_ptr<btRigidBody> m_body = nullptr;
        TriangleMesh m_mesh{};
    };
    btSoftBodyRigidBodyCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    btDbvtBroadphase m_broadphase;
    btCcdDeformableBodySolver m_solver;
    btDeformableMultiBodyConstraintSolver m_constraintSolver;
    std::unique_ptr<btCcdDeformableMultiBodyDynamicsWorld> m_world;
    std::vector<Soft> m_softs;
    std::vector<Solid> m_solids;
    std::function<void()> m_hand;
    Camera m_camera;
    std::vector<Canvas> m_pictures;
    int m_crossing = 0;
    int m_checks = 0;

    btSoftBody& add(btSoftBody* body, double mass, const Color& color)
    {
        Soft soft{.m_body = std::unique_ptr<btSoftBody>(body),
                  .m_springs = nullptr,
                  .m_weight = std::make_unique<btDeformableGravityForce>(vec(0, 0, -kGravity)),
                  .m_color = color};
        body->setTotalMass(btScalar(mass));
        body->getCollisionShape()->setMargin(btScalar(1e-3));
        body->m_cfg.kDF = btScalar(0.5);
        body->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN |
                                 btSoftBody::fCollision::SDF_RDF;
        m_world->addSoftBody(body);
        body->setSelfCollision(true);
        // Not stiffer than an explicit step allows.
        const double ofNode = mass / body->m_nodes.size();
        soft.m_springs = std::make_unique<btDeformableMassSpringForce>(
            btScalar(0.1 * ofNode / (kTimeStep * kTimeStep)),
            btScalar(0.02 * ofNode / kTimeStep),
            true);
        m_world->addForce(body, soft.m_springs.get());
        m_world->addForce(body, soft.m_weight.get());
        m_softs.push_back(std::move(soft));
        return *body;
    }

    /// Of soft bodies with themselves, with each other and with solids.
    [[nodiscard]] int countCrossings() const
    {
        int count = 0;
        const Eigen::AlignedBox3d all(Vector3d::Constant(-1e3), Vector3d::Constant(1e3));
        std::vector<std::vector<BoxedFace>> faces;
        for (const Soft& soft : m_softs)
        {
            const TriangleMesh mesh = meshOf(*soft.m_body);
            const std::vector<BoxedFace> own = facesNear(mesh, Isometry3d::Identity(), all);
            count += crossings(own, own);
            for (const std::vector<BoxedFace>& other : faces)
            {
                count += crossings(own, other) + crossings(other, own);
            }
            for (const Solid& solid : m_solids)
            {
                const std::vector<BoxedFace> near = facesNear(
                    solid.m_mesh, btCcdToEigen(solid.m_body->getWorldTransform()), bounds(mesh));
                count += crossings(own, near) + crossings(near, own);
            }
            faces.push_back(own);
        }
        return count;
    }

    [[nodiscard]] Canvas picture() const
    {
        std::vector<Drawn> drawn;
        drawn.reserve(m_solids.size() + m_softs.size());
        for (const Solid& solid : m_solids)
        {
            drawn.push_back(
                {solid.m_mesh, btCcdToEigen(solid.m_body->getWorldTransform()), kObstacleColor});
        }
        for (const Soft& soft : m_softs)
        {
            drawn.push_back({meshOf(*soft.m_body), Isometry3d::Identity(), soft.m_color});
        }
        return drawScene(m_camera, drawn);
    }
};

int countBelow(const btSoftBody& body, double z)
{
    int count = 0;
    for (int i = 0; i < body.m_nodes.size(); ++i)
    {
        count += double(body.m_nodes[i].m_x.z()) < z ? 1 : 0;
    }
    return count;
}

double meanHeight(const btSoftBody& body)
{
    double sum = 0.0;
    for (int i = 0; i < body.m_nodes.size(); ++i)
    {
        sum += double(body.m_nodes[i].m_x.z());
    }
    return sum / body.m_nodes.size();
}

/// Body, haunches, head, ears, paws and a tail, of spheres that are stretched.
TriangleMesh makeBunny()
{
    TriangleMesh bunny;
    const auto add = [&bunny](const Vector3d& half, const Vector3d& place, double lean = 0.0)
    {
        TriangleMesh part = makeSphere(1.0, 3);
        Eigen::Affine3d X(Eigen::Translation3d(place) * Eigen::AngleAxisd(lean, Vector3d::UnitY()));
        X.scale(half);
        transformMesh(part, X);
        appendMesh(bunny, part);
    };
    add({0.13, 0.09, 0.09}, {0.0, 0.0, 0.10}, -0.25);
    add({0.065, 0.06, 0.065}, {0.13, 0.0, 0.20});
    add({0.035, 0.035, 0.035}, {-0.135, 0.0, 0.09});
    for (const double side : {-1.0, 1.0})
    {
        add({0.075, 0.03, 0.06}, {-0.05, 0.07 * side, 0.065});
        add({0.04, 0.025, 0.02}, {0.10, 0.05 * side, 0.022});
        add({0.022, 0.012, 0.075}, {0.10, 0.032 * side, 0.315}, -0.35);
    }
    return bunny;
}

/// Teeth of a trapezoidal outline, about the axis y.
TriangleMesh makeGear(double root, double tip, double half, int teeth)
{
    constexpr int kOfTooth = 8;
    const auto ring = [&](int station)
    {
        std::vector<Vector3d> points;
        for (int i = 0; i < teeth * kOfTooth; ++i)
        {
            const double part = double(i % kOfTooth) / kOfTooth;
            const double high = std::clamp(2.0 - 8.0 * std::abs(part - 0.5), 0.0, 1.0);
            const double radius = root + (tip - root) * high;
            const double angle = 2.0 * std::numbers::pi * i / (teeth * kOfTooth);
            points.emplace_back(radius * std::sin(angle),
                                (station == 0 ? -1.0 : 1.0) * half,
                                radius * std::cos(angle));
        }
        return points;
    };
    return makeLofted(ring, 2);
}

bool bunny(const std::filesystem::path& folder)
{
    SoftScene scene(700.0, Vector3d(0.0, 0.0, 0.16));
    scene.addSolid(makeBox({0.4, 0.4, 0.01}), at(0, 0, -0.01));
    scene.addSolid(makeBunny(), at(0, 0, 0.005));
    btSoftBody& cloth = scene.addCloth(0.6, 44, 0.42, 0.3, Color(0.80F, 0.30F, 0.32F));
    cloth.setVelocity(vec(0, 0, -5));
    scene.run(1.0);
    const int below = countBelow(cloth, 0.0);
    return scene.finish(
        folder, "bunny", below == 0, std::to_string(below) + " nodes below the table");
}

bool ring(const std::filesystem::path& folder)
{
    SoftScene scene(640.0, Vector3d(0.0, 0.0, -0.15));
    scene.addSolid(makeTorus(0.075, 0.02, 48, 24), at(0, 0, 0));
    btSoftBody& cloth = scene.addCloth(0.5, 40, 0.03, 0.0, Color(0.30F, 0.50F, 0.78F));
    // A hand without mass takes the middle of the cloth, turns it and pulls it down.
    std::vector<int> held;
    for (int i = 0; i < cloth.m_nodes.size(); ++i)
    {
        if (std::hypot(double(cloth.m_nodes[i].m_x.x()), double(cloth.m_nodes[i].m_x.y())) < 0.02)
        {
            cloth.m_nodes[i].m_im = 0;
            held.push_back(i);
        }
    }
    scene.setHand(cloth, held, 4.0, -0.25);
    scene.run(1.5);
    const int through = countBelow(cloth, -0.03);
    return scene.finish(folder,
                        "ring",
                        2 * through > cloth.m_nodes.size(),
                        std::to_string(through) + " nodes are below the ring");
}

bool layers(const std::filesystem::path& folder)
{
    SoftScene scene(900.0, Vector3d(0.0, 0.0, 0.06));
    scene.addSolid(makeBox({0.3, 0.3, 0.01}), at(0, 0, -0.01));
    std::vector<btSoftBody*> cloths;
    for (int i = 0; i < 10; ++i)
    {
        const float shade = 0.35F + 0.06F * float(i);
        cloths.push_back(&scene.addCloth(
            0.4, 20, 0.02 + 0.025 * i, 0.3 * i, Color(shade, 0.75F - 0.5F * shade, 0.35F)));
    }
    scene.run(0.5);
    int below = 0;
    bool isInOrder = true;
    for (std::size_t i = 0; i < cloths.size(); ++i)
    {
        below += countBelow(*cloths[i], 0.0);
        isInOrder = isInOrder && (i == 0 || meanHeight(*cloths[i - 1]) < meanHeight(*cloths[i]));
    }
    return scene.finish(folder,
                        "layers",
                        below == 0 && isInOrder,
                        std::to_string(below) + " nodes below the table, the top at " +
                            std::to_string(int(std::lround(1e4 * meanHeight(*cloths.back())))) +
                            " tenths of a millimetre");
}

bool gears(const std::filesystem::path& folder)
{
    SoftScene scene(1000.0, Vector3d(0.0, 0.0, -0.03), Vector3d(0.3, -0.9, 0.35));
    scene.addSolid(makeBox({0.2, 0.15, 0.01}), at(0, 0, -0.21));
    for (const double side : {-1.0, 1.0})
    {
        scene.addSolid(makeGear(0.085, 0.105, 0.05, 10), at(0.12 * side, 0, 0), -1.5 * side);
    }
    btSoftBody& ball = scene.addBall(0.045, 0.1, at(0, 0, 0.08), Color(0.95F, 0.75F, 0.30F));
    scene.run(1.6);
    const double height = meanHeight(ball);
    const int below = countBelow(ball, -0.2);
    return scene.finish(
        folder,
        "gears",
        height < -0.1 && below == 0,
        "the ball is " + std::to_string(int(std::lround(-1e3 * height))) + " mm below the axes");
}
}  // namespace

int main(int count, char** words)
{
    return runScenes("soft_scenes",
                     {{"bunny", bunny}, {"ring", ring}, {"layers", layers}, {"gears", gears}},
                     count,
                     words);
}
