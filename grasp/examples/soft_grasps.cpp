// Hands close on soft things in Bullet's deformable world and keep them while the table under them
// is taken away: a sponge, a napkin and a plush figure. Joints are driven with limited effort.
// Everything meets continuously in time: soft bodies and links, soft bodies and themselves.
//
//   soft_grasps FOLDER [sponge|napkin|plush ...]
//
// Writes a strip of pictures a scene, FOLDER/<scene>.png. A check of its own looks at edges and
// faces of soft bodies and links: none may cross. The exit code is 0 if nothing crosses and all
// things are lifted and stay where they are in the hand.
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/btCcdDeformableMultiBodyDynamicsWorld.h"
#include "grasp/examples/soft_support.h"
#include "grasp/hand/hand_model.h"
#include "grasp/report/grasp_scene.h"
#include "grasp/sim/hand_multi_body.h"
#include "grasp/sim/hand_pairs.h"
#include "grasp/sim/joint_constraints.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace
{
using namespace bullet_ccd;
using namespace bullet_ccd::grasp;
using namespace bullet_ccd::grasp::examples;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kTimeStep = 4e-4;  // [s]
constexpr double kGravity = 9.81;   // [m/s^2], along -z
constexpr double kCloseUntil = 0.7;
constexpr double kLiftUntil = 1.3;
constexpr double kEnd = 1.5;
constexpr double kLift = 0.2;         // [m]
constexpr double kMostSunk = 0.02;    // since the hand has closed [m]; cloth sags
constexpr double kMostAtRest = 2e-3;  // since it is lifted [m]
constexpr int kPictures = 6;
constexpr double kMass = 0.03;  // of the soft things [kg]

/// What hand takes what, and how.
struct Scene
{
    std::string name;
    std::string hand;
    std::string preshape;
    std::vector<std::pair<std::string, double>> joints{};  ///< in place of the preshape's [rad]
    Vector3d approach;                                     ///< of the hand
    Vector3d across;  ///< the fingers oppose each other along it
    Vector3d place;   ///< of the grasp frame; the table's top is z = 0
    double effort;    ///< of a joint [N m or N]
    double speed;     ///< of a joint [rad/s or m/s]
    Vector3d table;   ///< half extents [m]
    Color color;
};

// --- Soft things.

btSoftBody* makeSponge(btSoftBodyWorldInfo& info)
{
    const Vector3d half(0.025, 0.045, 0.03);
    return makeVolume(info,
                      0.01,
                      16,
                      [half](const Vector3d& x)
                      { return ((x - Vector3d(0, 0, half.z())).cwiseAbs() - half).maxCoeff(); });
}

/// Something with a belly, a head, ears and arms.
btSoftBody* makePlush(btSoftBodyWorldInfo& info)
{
    struct Ball
    {
        Vector3d m_middle;
        double m_radius;
    };
    static const std::array<Ball, 6> kBalls{Ball{{0, 0, 0.027}, 0.027},
                                            Ball{{0, 0, 0.066}, 0.021},
                                            Ball{{0, 0.016, 0.085}, 0.010},
                                            Ball{{0, -0.016, 0.085}, 0.010},
                                            Ball{{0.020, 0.016, 0.035}, 0.010},
                                            Ball{{0.020, -0.016, 0.035}, 0.010}};
    return makeVolume(info,
                      0.006,
                      20,
                      [](const Vector3d& x)
                      {
                          double least = 1.0;
                          for (const Ball& ball : kBalls)
                          {
                              least = std::min(least, (x - ball.m_middle).norm() - ball.m_radius);
                          }
                          return least;
                      });
}

/// Folded once, like a tent along y.
btSoftBody* makeNapkin(btSoftBodyWorldInfo& info)
{
    constexpr int kCells = 24;
    const double side = 0.2;
    btSoftBody* body = btSoftBodyHelpers::CreatePatch(info,
                                                      vec(-0.5 * side, -0.5 * side, 0),
                                                      vec(0.5 * side, -0.5 * side, 0),
                                                      vec(-0.5 * side, 0.5 * side, 0),
                                                      vec(0.5 * side, 0.5 * side, 0),
                                                      kCells + 1,
                                                      kCells + 1,
                                                      0,
                                                      true);
    const double lean = 12.0 * std::numbers::pi / 180.0;  // of both halves from the vertical
    for (int i = 0; i < body->m_nodes.size(); ++i)
    {
        btSoftBody::Node& node = body->m_nodes[i];
        const double off = double(node.m_x.x());
        node.m_x = node.m_q = vec(off * std::sin(lean),
                                  double(node.m_x.y()),
                                  (0.5 * side - std::abs(off)) * std::cos(lean) + 0.002);
    }
    body->generateBendingConstraints(2);
    return body;
}

// --- The world.

class SoftGrasp
{
public:
    explicit SoftGrasp(const Scene& scene)
        : m_scene(scene),
          m_hand(loadHand(std::filesystem::path(BULLET_CCD_SHIPPED_ROBOTS) / scene.hand /
                          (scene.hand + ".urdf"))),
          m_pairs(m_hand),
          m_multiBody(makeHandMultiBody(m_hand)),
          m_tableShape(vec(scene.table.x(), scene.table.y(), scene.table.z()))
    {
        m_constraintSolver.setDeformableSolver(&m_solver);
        m_world = std::make_unique<btCcdDeformableMultiBodyDynamicsWorld>(
            &m_dispatcher, &m_broadphase, &m_constraintSolver, &m_configuration, &m_solver);
        // The weight of the hand is compensated by its controller; soft things have their own.
        m_world->setGravity(vec(0, 0, 0));
        m_world->setUseProjection(true);
        m_broadphase.getOverlappingPairCache()->setOverlapFilterCallback(&m_pairs);
        m_solver.setCcdSeparation(5e-4);
        addHand();
        addTable();
        addThing();
    }
    ~SoftGrasp()
    {
        m_world->removeSoftBodyForce(m_thing.get());
        m_world->removeSoftBody(m_thing.get());
        m_world->removeRigidBody(m_table.get());
        for (const auto& constraint : m_constraints)
        {
            m_world->removeMultiBodyConstraint(constraint.get());
        }
        for (const auto& collider : m_multiBody.colliders)
        {
            if (collider != nullptr)
            {
                m_world->removeCollisionObject(collider.get());
            }
        }
        m_world->removeMultiBody(m_multiBody.body.get());
    }
    SoftGrasp(const SoftGrasp&) = delete;
    SoftGrasp& operator=(const SoftGrasp&) = delete;

    /// Returns whether nothing crosses anything and the thing is lifted.
    bool run(const std::filesystem::path& folder)
    {
        const int steps = int(std::lround(kEnd / kTimeStep));
        int crossing = 0;
        int checks = 0;
        double before = 0.0;
        double lifted = 0.0;
        for (int i = 0; i <= steps; ++i)
        {
            const double time = i * kTimeStep;
            if (i % (steps / (kPictures - 1)) == 0)
            {
                m_pictures.push_back(picture());
            }
            if (i % 10 == 0)
            {
                crossing += countCrossings();
                if (i == 0 && crossing > 0)
                {
                    throw std::invalid_argument(m_scene.name +
                                                ": the hand and the thing cross at the start");
                }
                std::fprintf(stderr, "\r%s: %3.0f %%", m_scene.name.c_str(), 100.0 * i / steps);
                ++checks;
            }
            if (i == int(kCloseUntil / kTimeStep))
            {
                before = middle().z();
                holdJoints();
            }
            if (i == int(kLiftUntil / kTimeStep))
            {
                lifted = middle().z();
            }
            step(time);
        }
        std::fputc('\r', stderr);
        writeStrip(m_pictures, folder / (m_scene.name + ".png"));
        const double sunk = before - middle().z();
        const double clear =
            lowest() - double(m_table->getWorldTransform().getOrigin().z()) - m_scene.table.z();
        const btCcdSoftCounters& counters = m_solver.getCcdSoftCounters();
        const double rested = lifted - middle().z();
        const bool isHeld =
            clear > 0.5 * kLift && std::abs(sunk) < kMostSunk && std::abs(rested) < kMostAtRest;
        std::printf(
            "%-7s %4d nodes %5d faces: %d edges cross faces in %d checks; the table is %.1f "
            "cm below, the thing sank by %.1f mm in the hand, %.1f of them after it was lifted; "
            "%lld contacts, %lld squeezed -> %s\n",
            m_scene.name.c_str(),
            m_thing->m_nodes.size(),
            m_thing->m_faces.size(),
            crossing,
            checks,
            100.0 * clear,
            1000.0 * sunk,
            1000.0 * rested,
            static_cast<long long>(counters.m_contacts),
            static_cast<long long>(counters.m_squeezed),
            crossing == 0 && isHeld ? "held" : "FAILED");
        return crossing == 0 && isHeld;
    }

private:
    const Scene& m_scene;
    HandModel m_hand;
    HandPairs m_pairs;
    HandMultiBody m_multiBody;
    btSoftBodyRigidBodyCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    btDbvtBroadphase m_broadphase;
    btCcdDeformableBodySolver m_solver;
    btDeformableMultiBodyConstraintSolver m_constraintSolver;
    std::unique_ptr<btCcdDeformableMultiBodyDynamicsWorld> m_world;
    std::vector<std::unique_ptr<btMultiBodyConstraint>> m_constraints;
    struct Driven
    {
        JointDrive* drive;
        DriveSettings settings;
        int link;
        int closing;  ///< its direction; 0 if it keeps its place
    };
    std::vector<Driven> m_drives;
    btBoxShape m_tableShape;
    std::unique_ptr<btRigidBody> m_table;
    std::unique_ptr<btSoftBody> m_thing;
    std::unique_ptr<btDeformableLagrangianForce> m_elasticity;
    btDeformableGravityForce m_weight{vec(0, 0, -kGravity)};
    std::vector<Canvas> m_pictures;

    void addHand()
    {
        const Preshape* preshape = findPreshape(m_hand, m_scene.preshape);
        Preshape start = preshape != nullptr ? *preshape : m_hand.preshapes.front();
        for (const auto& [joint, position] : m_scene.joints)
        {
            start.positions[static_cast<std::size_t>(m_hand.robot.tree.findJoint(joint))] =
                position;
        }
        Isometry3d X_WG = Isometry3d::Identity();
        X_WG.linear().col(0) = m_scene.across;
        X_WG.linear().col(1) = m_scene.approach.cross(m_scene.across);
        X_WG.linear().col(2) = m_scene.approach;
        X_WG.translation() = m_scene.place;
        const Isometry3d X_WH = X_WG * m_hand.X_RG.inverse();

        btMultiBody& body = *m_multiBody.body;
        body.setCanSleep(false);
        body.setLinearDamping(0);
        body.setAngularDamping(0);
        body.setBaseWorldTransform(btCcdToBullet(X_WH * m_multiBody.X_LI.front()));
        const std::vector<double> closed = closedPositions(m_hand, start.positions);
        const KinematicTree& tree = m_hand.robot.tree;
        m_world->addMultiBody(&body);
        for (std::size_t i = 1; i < tree.size(); ++i)
        {
            const Joint& joint = tree.links[i].joint;
            const int link = int(i) - 1;
            if (!joint.isMovable())
            {
                continue;
            }
            body.setJointPos(link, btScalar(start.positions[i]));
            if (joint.mimicOf != kNone)
            {
                m_constraints.push_back(std::make_unique<JointCoupling>(
                    &body, link, joint.mimicOf - 1, joint.mimicMultiplier, joint.mimicOffset));
                continue;
            }
            auto drive = std::make_unique<JointDrive>(&body, link);
            const bool closes = m_hand.closingDirections[i] != 0;
            const double scale = closes ? 1.0 : 20.0;
            const DriveSettings settings{.effort = scale * m_scene.effort,
                                         .stiffness = 1e3 * m_scene.effort,
                                         .damping = 1e-2 * m_scene.effort / m_scene.speed,
                                         .maxSpeed = m_scene.speed};
            drive->set(settings, closes ? closed[i] : start.positions[i]);
            m_drives.push_back({drive.get(), settings, link, m_hand.closingDirections[i]});
            m_constraints.push_back(std::move(drive));
        }
        for (const auto& constraint : m_constraints)
        {
            constraint->finalizeMultiDof();
            m_world->addMultiBodyConstraint(constraint.get());
        }
        for (const auto& collider : m_multiBody.colliders)
        {
            if (collider != nullptr)
            {
                collider->setFriction(1);
                m_world->addCollisionObject(collider.get());
            }
        }
        btAlignedObjectArray<btQuaternion> turns;
        btAlignedObjectArray<btVector3> places;
        body.forwardKinematics(turns, places);
        body.updateCollisionObjectWorldTransforms(turns, places);
    }

    void addTable()
    {
        btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, &m_tableShape);
        info.m_startWorldTransform.setOrigin(vec(0, 0, -m_scene.table.z()));
        m_table = std::make_unique<btRigidBody>(info);
        m_table->setCollisionFlags(m_table->getCollisionFlags() |
                                   btCollisionObject::CF_KINEMATIC_OBJECT);
        m_table->setActivationState(DISABLE_DEACTIVATION);
        m_table->setFriction(btScalar(0.5));
        m_world->addRigidBody(m_table.get());
    }

    void addThing()
    {
        btSoftBodyWorldInfo& info = m_world->getWorldInfo();
        info.m_gravity.setZero();
        info.m_maxDisplacement = 1;
        const bool isCloth = m_scene.name == "napkin";
        m_thing.reset(isCloth                    ? makeNapkin(info)
                      : m_scene.name == "sponge" ? makeSponge(info)
                                                 : makePlush(info));
        m_thing->setTotalMass(btScalar(kMass));
        m_thing->getCollisionShape()->setMargin(btScalar(5e-4));
        m_thing->m_cfg.kDF = btScalar(0.8);
        m_thing->m_cfg.collisions = btSoftBody::fCollision::SDF_RD |
                                    btSoftBody::fCollision::SDF_RDN |
                                    btSoftBody::fCollision::SDF_RDF;
        m_world->addSoftBody(m_thing.get());
        m_thing->setSelfCollision(true);
        // Not stiffer than an explicit step allows; cloth gives way more easily.
        const double mass = kMass / m_thing->m_nodes.size();
        m_elasticity = std::make_unique<btDeformableMassSpringForce>(
            btScalar((isCloth ? 0.05 : 0.1) * mass / (kTimeStep * kTimeStep)),
            btScalar(0.02 * mass / kTimeStep),
            true);
        m_world->addForce(m_thing.get(), m_elasticity.get());
        m_world->addForce(m_thing.get(), &m_weight);
    }

    /// Joints press as they do now, and give way or follow by a thousandth of a radian or metre:
    /// fingers that went on closing would push what is soft out of the hand.
    void holdJoints()
    {
        for (const Driven& driven : m_drives)
        {
            if (driven.closing != 0)
            {
                const double press = driven.settings.effort / driven.settings.stiffness;
                driven.drive->set(
                    driven.settings,
                    double(m_multiBody.body->getJointPos(driven.link)) + driven.closing * press);
            }
        }
    }

    void step(double time)
    {
        for (const Driven& driven : m_drives)
        {
            driven.drive->prepare(kTimeStep);
        }
        if (time > kCloseUntil && time < kLiftUntil)
        {
            btTransform pose = m_table->getWorldTransform();
            pose.getOrigin() += vec(0, 0, -kLift / (kLiftUntil - kCloseUntil) * kTimeStep);
            m_table->setWorldTransform(pose);
        }
        m_world->stepSimulation(btScalar(kTimeStep), 0);
    }

    [[nodiscard]] Isometry3d linkPose(std::size_t link) const
    {
        return btCcdToEigen(m_multiBody.colliders[link]->getWorldTransform()) *
               m_multiBody.X_LI[link].inverse();
    }

    [[nodiscard]] Vector3d middle() const
    {
        Vector3d sum = Vector3d::Zero();
        for (int i = 0; i < m_thing->m_nodes.size(); ++i)
        {
            sum += btCcdToEigen(m_thing->m_nodes[i].m_x);
        }
        return sum / m_thing->m_nodes.size();
    }
    [[nodiscard]] double lowest() const
    {
        double z = 1.0;
        for (int i = 0; i < m_thing->m_nodes.size(); ++i)
        {
            z = std::min(z, double(m_thing->m_nodes[i].m_x.z()));
        }
        return z;
    }

    [[nodiscard]] int countCrossings() const
    {
        const TriangleMesh mesh = meshOf(*m_thing);
        const Eigen::AlignedBox3d box = bounds(mesh);
        const std::vector<BoxedFace> soft = facesNear(mesh, Isometry3d::Identity(), box);
        int count = crossings(soft, soft);
        for (std::size_t i = 0; i < m_hand.linkTrees.size(); ++i)
        {
            if (m_multiBody.colliders[i] != nullptr)
            {
                const std::vector<BoxedFace> link =
                    facesNear(m_hand.linkTrees[i]->mesh(), linkPose(i), box);
                count += crossings(soft, link) + crossings(link, soft);
            }
        }
        return count;
    }

    [[nodiscard]] Canvas picture() const
    {
        constexpr int kWidth = 640;
        constexpr int kHeight = 760;
        Camera camera{.R_CW = lookFrom(Vector3d(0.75, -0.55, 0.35).normalized(), Vector3d::UnitZ()),
                      .center_W = Vector3d(0, 0, 0.02),
                      .pixelsPerMetre = 2200.0,
                      .width = kWidth,
                      .height = kHeight};
        std::vector<Drawn> drawn;
        for (std::size_t i = 0; i < m_hand.linkTrees.size(); ++i)
        {
            if (m_multiBody.colliders[i] != nullptr)
            {
                drawn.push_back(
                    {m_hand.linkTrees[i]->mesh(), linkPose(i), colorOf(m_hand, std::int32_t(i))});
            }
        }
        drawn.push_back(
            {makeBox(m_scene.table), btCcdToEigen(m_table->getWorldTransform()), kObstacleColor});
        drawn.push_back({meshOf(*m_thing), Isometry3d::Identity(), m_scene.color});
        return drawScene(camera, drawn);
    }
};

/// Fingers bent a little, so that they reach under what is soft.
const std::vector<std::pair<std::string, double>> kBent{{"fore_proximal_flexion", 0.1},
                                                        {"middle_proximal_flexion", 0.1},
                                                        {"ring_proximal_flexion", 0.1}};

const std::array<Scene, 3>& scenes()
{
    static const std::array<Scene, 3> kScenes{Scene{.name = "sponge",
                                                    .hand = "anthropomorphic_hand",
                                                    .preshape = "open",
                                                    .joints = kBent,
                                                    .approach = -Vector3d::UnitZ(),
                                                    .across = Vector3d::UnitX(),
                                                    .place = Vector3d(0, 0, 0.03),
                                                    .effort = 0.03,
                                                    .speed = 1.5,
                                                    .table = Vector3d(0.02, 0.04, 0.05),
                                                    .color = Color(0.95F, 0.80F, 0.30F)},
                                              Scene{.name = "napkin",
                                                    .hand = "parallel_gripper",
                                                    .preshape = "open",
                                                    .approach = -Vector3d::UnitZ(),
                                                    .across = Vector3d::UnitX(),
                                                    .place = Vector3d(0, 0, 0.055),
                                                    .effort = 10.0,
                                                    .speed = 0.4,
                                                    .table = Vector3d(0.15, 0.15, 0.01),
                                                    .color = Color(0.80F, 0.30F, 0.32F)},
                                              Scene{.name = "plush",
                                                    .hand = "anthropomorphic_hand",
                                                    .preshape = "open",
                                                    .joints = kBent,
                                                    .approach = -Vector3d::UnitZ(),
                                                    .across = Vector3d::UnitX(),
                                                    .place = Vector3d(0, 0, 0.035),
                                                    .effort = 0.03,
                                                    .speed = 1.5,
                                                    .table = Vector3d(0.02, 0.03, 0.05),
                                                    .color = Color(0.62F, 0.44F, 0.30F)}};
    return kScenes;
}
}  // namespace

int main(int count, char** words)
{
    std::vector<NamedScene> named;
    for (const Scene& scene : scenes())
    {
        named.push_back({scene.name, [&scene](const std::filesystem::path& folder) {
                             return SoftGrasp(scene).run(folder);
                         }});
    }
    return runScenes("soft_grasps", named, count, words);
}
