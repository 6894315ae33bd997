#include "benchmarks/reference/bullet/programs.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/ConstraintSolver/btConeTwistConstraint.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
constexpr double kPi = std::numbers::pi;

Program emptyProgram(Kind kind, WorldClass worldClass)
{
    Program program;
    program.scene = std::make_unique<Scene>(kind, worldClass);
    program.scene->world().setGravity(vec(0, -9.81, 0));
    return program;
}

btRigidBody* ground(Scene& scene)
{
    return scene.body(scene.box(vec(50, 50, 50)), 0.0, poseAt(vec(0, -50, 0)));
}

/// Bodies of programs may fall asleep, unlike those of Scene::body.
btRigidBody* sleepy(btRigidBody* body)
{
    body->forceActivationState(ACTIVE_TAG);
    return body;
}

/// A ball dropped from 50 m on the ground.
Program helloWorld(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::Rigid);
    Scene& scene = *program.scene;
    ground(scene);
    sleepy(scene.body(
        scene.keep(std::make_unique<btSphereShape>(btScalar(1))), 1.0, poseAt(vec(2, 50, 0))));
    return program;
}

/// Five by five by five boxes fall a little and settle.
Program stackedBoxes(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::Rigid);
    Scene& scene = *program.scene;
    ground(scene);
    btBoxShape* shape = scene.keep(std::make_unique<btBoxShape>(vec(0.1, 0.1, 0.1)));
    for (int k = 0; k < 5; ++k)
    {
        for (int i = 0; i < 5; ++i)
        {
            for (int j = 0; j < 5; ++j)
            {
                sleepy(scene.body(shape, 1.0, poseAt(vec(0.2 * i, 0.15 + 0.2 * k, 0.2 * j))));
            }
        }
    }
    return program;
}

/// Two arms on hinges, driven by a torque that changes its sign.
Program hingeTorque(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::Rigid);
    Scene& scene = *program.scene;
    ground(scene);
    btRigidBody* parent = scene.body(scene.box(vec(0.05, 0.37, 0.1)), 0.0, poseAt(vec(0, 5, 0)));
    btCollisionShape* shape = scene.box(vec(0.05, 0.37, 0.1));
    std::vector<btRigidBody*> arms;
    for (int i = 0; i < 2; ++i)
    {
        btRigidBody* arm = scene.body(shape, 1.0, poseAt(vec(0, 5 - 0.8 * (i + 1), 0)));
        arm->setDamping(0, 0);
        auto hinge = std::make_unique<btHingeConstraint>(
            *parent, *arm, vec(0, -0.4, 0), vec(0, 0.4, 0), vec(0, 0, 1), vec(0, 0, 1), true);
        hinge->setLimit(btScalar(-1.2), btScalar(1.2));
        scene.addConstraint(std::move(hinge));
        arms.push_back(arm);
        parent = arm;
    }
    program.act = [arms](int step)
    { arms[0]->applyTorque(vec(0, 0, step % 120 < 60 ? 4.0 : -4.0)); };
    return program;
}

struct Bone
{
    double radius;
    double length;
    btVector3 at;
    double turn;  ///< about z
    int parent;
    bool hinge;
    btVector3 joint;
};

/// Capsules held together by cone-twist joints and hinges fall on the ground.
Program ragdoll(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::Rigid);
    Scene& scene = *program.scene;
    ground(scene);
    const Bone bones[] = {
        {0.15, 0.20, vec(0, 1.0, 0), 0, -1, false, vec(0, 0, 0)},
        {0.15, 0.28, vec(0, 1.25, 0), 0, 0, true, vec(0, 1.1, 0)},
        {0.10, 0.05, vec(0, 1.65, 0), 0, 1, false, vec(0, 1.5, 0)},
        {0.07, 0.45, vec(-0.18, 0.65, 0), 0, 0, false, vec(-0.18, 0.9, 0)},
        {0.05, 0.37, vec(-0.18, 0.2, 0), 0, 3, true, vec(-0.18, 0.4, 0)},
        {0.07, 0.45, vec(0.18, 0.65, 0), 0, 0, false, vec(0.18, 0.9, 0)},
        {0.05, 0.37, vec(0.18, 0.2, 0), 0, 5, true, vec(0.18, 0.4, 0)},
        {0.05, 0.33, vec(-0.35, 1.45, 0), kPi / 2, 1, false, vec(-0.2, 1.45, 0)},
        {0.04, 0.25, vec(-0.7, 1.45, 0), kPi / 2, 7, true, vec(-0.55, 1.45, 0)},
        {0.05, 0.33, vec(0.35, 1.45, 0), -kPi / 2, 1, false, vec(0.2, 1.45, 0)},
        {0.04, 0.25, vec(0.7, 1.45, 0), -kPi / 2, 9, true, vec(0.55, 1.45, 0)},
    };
    std::vector<btRigidBody*> bodies;
    for (const Bone& bone : bones)
    {
        btRigidBody* body = sleepy(scene.body(scene.keep(std::make_unique<btCapsuleShape>(
                                                  btScalar(bone.radius), btScalar(bone.length))),
                                              1.0,
                                              poseAt(bone.at + vec(0, 0.5, 0), bone.turn)));
        body->setDamping(btScalar(0.05), btScalar(0.85));
        bodies.push_back(body);
        if (bone.parent < 0)
        {
            continue;
        }
        btRigidBody& parent = *bodies[std::size_t(bone.parent)];
        const btTransform world(btQuaternion::getIdentity(), bone.joint + vec(0, 0.5, 0));
        const btTransform inParent = parent.getWorldTransform().inverse() * world;
        const btTransform inBone = body->getWorldTransform().inverse() * world;
        if (bone.hinge)
        {
            auto hinge = std::make_unique<btHingeConstraint>(parent, *body, inParent, inBone);
            hinge->setLimit(btScalar(-0.2), btScalar(1.5));
            scene.addConstraint(std::move(hinge));
        }
        else
        {
            auto cone = std::make_unique<btConeTwistConstraint>(parent, *body, inParent, inBone);
            cone->setLimit(btScalar(kPi / 4), btScalar(kPi / 4), btScalar(kPi / 2));
            scene.addConstraint(std::move(cone));
        }
    }
    return program;
}

/// Links of a chain that hangs from a fixed base, along -y, with colliders.
btMultiBody* hangingChain(Scene& scene, int links, bool spherical, bool fixedBase)
{
    const btVector3 half = vec(0.05, 0.37, 0.1);
    const double mass = 1.0;
    btBoxShape* shape = scene.box(half);
    btVector3 inertia;
    shape->calculateLocalInertia(btScalar(mass), inertia);
    auto body =
        std::make_unique<btMultiBody>(links, btScalar(fixedBase ? 0 : 1), inertia, fixedBase, true);
    body->setBaseWorldTransform(poseAt(vec(0, 6, 0)));
    for (int i = 0; i < links; ++i)
    {
        const btVector3 toPivot = vec(0, -0.4, 0);
        if (spherical)
        {
            body->setupSpherical(i,
                                 btScalar(mass),
                                 inertia,
                                 i - 1,
                                 btQuaternion::getIdentity(),
                                 toPivot,
                                 toPivot,
                                 true);
        }
        else
        {
            body->setupRevolute(i,
                                btScalar(mass),
                                inertia,
                                i - 1,
                                btQuaternion::getIdentity(),
                                vec(1, 0, 0),
                                toPivot,
                                toPivot,
                                true);
        }
    }
    body->finalizeMultiDof();
    btMultiBody* added = scene.addMultiBody(
        std::move(body), shape, std::vector<btCollisionShape*>(std::size_t(links), shape));
    added->setLinearDamping(btScalar(0.1));
    added->setAngularDamping(btScalar(0.9));
    return added;
}

/// As Bullet's own: one link on a fixed base, a small ball the only collider, a constant torque.
Program pendulum(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::MultiBody);
    Scene& scene = *program.scene;
    btCollisionShape* ball = scene.keep(std::make_unique<btSphereShape>(btScalar(0.05)));
    btVector3 inertia;
    ball->calculateLocalInertia(btScalar(10), inertia);
    auto body = std::make_unique<btMultiBody>(1, btScalar(0), btVector3(0, 0, 0), true, false);
    body->setupRevolute(0,
                        btScalar(10),
                        inertia,
                        -1,
                        btQuaternion::getIdentity(),
                        vec(1, 0, 0),
                        vec(0, 0, 0),
                        vec(0, -0.5, 0),
                        false);
    body->finalizeMultiDof();
    body->setHasSelfCollision(false);
    btMultiBody* added = scene.addMultiBody(std::move(body), nullptr, {ball});
    program.act = [added](int /*step*/) { added->addJointTorque(0, 20); };
    return program;
}

/// Five links on hinges swing freely.
Program swingingChain(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::MultiBody);
    btMultiBody* chain = hangingChain(*program.scene, 5, false, true);
    chain->setLinearDamping(0);
    chain->setAngularDamping(0);
    chain->setJointPos(0, btScalar(0.3));
    chain->setJointPos(1, btScalar(-0.1));
    Scene::placeColliders(*chain);
    return program;
}

/// A motor turns the first joint of a chain.
Program motorChain(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::MultiBody);
    btMultiBody* chain = hangingChain(*program.scene, 3, false, true);
    program.scene->addConstraint(
        std::make_unique<btMultiBodyJointMotor>(chain, 0, btScalar(0.5), btScalar(2)));
    return program;
}

/// A chain of ball joints swings beside boxes that fall and settle.
Program sphericalChain(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::MultiBody);
    Scene& scene = *program.scene;
    ground(scene);
    btMultiBody* chain = hangingChain(scene, 5, true, true);
    const btQuaternion turn(vec(0.6, 0.0, 0.8), btScalar(0.4));
    const btScalar position[] = {turn.x(), turn.y(), turn.z(), turn.w()};
    chain->setJointPosMultiDof(0, position);
    Scene::placeColliders(*chain);
    btBoxShape* shape = scene.box(vec(0.2, 0.2, 0.2));
    for (int i = 0; i < 4; ++i)
    {
        sleepy(scene.body(shape, 1.0, poseAt(vec(0, 0.25 + 0.41 * i, 0))));
    }
    return program;
}

/// A chain without a fixed base falls on a plane.
Program fallingChain(Kind kind)
{
    Program program = emptyProgram(kind, WorldClass::MultiBody);
    Scene& scene = *program.scene;
    scene.body(scene.keep(std::make_unique<btStaticPlaneShape>(vec(0, 1, 0), btScalar(1.5))),
               0.0,
               btTransform::getIdentity());
    btMultiBody* chain = hangingChain(scene, 3, false, false);
    chain->setJointPos(1, btScalar(0.5));
    Scene::placeColliders(*chain);
    return program;
}
}  // namespace

std::vector<ProgramEntry> programs()
{
    using enum WorldClass;
    return {{"pendulum", MultiBody, 300, true, true, pendulum},
            {"chain", MultiBody, 300, true, false, swingingChain},
            {"motor", MultiBody, 300, true, false, motorChain},
            {"spherical", MultiBody, 300, false, false, sphericalChain},
            {"falling_chain", MultiBody, 200, false, false, fallingChain},
            {"hinge_torque", Rigid, 300, true, true, hingeTorque},
            {"ragdoll", Rigid, 200, false, true, ragdoll},
            {"stack", Rigid, 150, true, true, stackedBoxes},
            {"hello", Rigid, 240, false, false, helloWorld}};
}

std::vector<btScalar> stateOf(Scene& scene)
{
    std::vector<btScalar> state;
    const auto append = [&](const btVector3& v) {
        state.insert(state.end(), {v.x(), v.y(), v.z()});
    };
    const btCollisionObjectArray& objects = scene.world().getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        const btTransform& pose = objects[i]->getWorldTransform();
        append(pose.getOrigin());
        for (int row = 0; row < 3; ++row)
        {
            append(pose.getBasis()[row]);
        }
        if (const btRigidBody* body = btRigidBody::upcast(objects[i]))
        {
            append(body->getLinearVelocity());
            append(body->getAngularVelocity());
        }
        else if (const auto* collider = btMultiBodyLinkCollider::upcast(objects[i]);
                 collider != nullptr && collider->m_link < 0)
        {
            const btMultiBody& multiBody = *collider->m_multiBody;
            const btScalar* velocities = multiBody.getVelocityVector();
            state.insert(state.end(), velocities, velocities + 6 + multiBody.getNumDofs());
        }
    }
    return state;
}

Trace runProgram(const ProgramEntry& entry, Kind kind)
{
    Program program = entry.make(kind);
    Trace trace;
    for (int step = 0; step < entry.steps; ++step)
    {
        if (program.act)
        {
            program.act(step);
        }
        program.scene->step(program.timeStep);
        trace.states.push_back(stateOf(*program.scene));
        if (trace.firstEvent < 0 && program.scene->counters().m_impacts > 0)
        {
            trace.firstEvent = step;
        }
    }
    return trace;
}

int firstDifference(const Trace& a, const Trace& b)
{
    const auto [at, other] = std::ranges::mismatch(a.states, b.states);
    return at == a.states.end() && other == b.states.end() ? -1 : int(at - a.states.begin());
}
}  // namespace bullet_ccd::reference
