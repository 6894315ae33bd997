/// What programs use of Bullet: joints, characters, ghosts, callbacks, terrain that comes and goes.
#include "benchmarks/reference/bullet/day_parts.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpringConstraint.h>
#include <BulletDynamics/ConstraintSolver/btSliderConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyGearConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <array>

namespace bullet_ccd::reference::day
{
namespace
{
/// Something light beats on a block that a spring or a motor drives along x.
enum class Drive
{
    Spring2,
    Spring,
    SliderMotor,
    Motor2,
};
template <typename Joint>
std::unique_ptr<Joint> alongX(std::unique_ptr<Joint> joint)
{
    joint->setLinearLowerLimit(vec(-1, 0, 0));
    joint->setLinearUpperLimit(vec(1, 0, 0));
    joint->setAngularLowerLimit(vec(0, 0, 0));
    joint->setAngularUpperLimit(vec(0, 0, 0));
    return joint;
}
std::unique_ptr<btTypedConstraint> driveOf(Drive drive, btRigidBody& base, btRigidBody& block)
{
    const btTransform inBase = poseAt(vec(0, 0, 0));
    const btTransform inBlock = poseAt(vec(-1, 0, 0));
    if (drive == Drive::SliderMotor)
    {
        auto slider = std::make_unique<btSliderConstraint>(base, block, inBase, inBlock, true);
        slider->setLowerLinLimit(-1);
        slider->setUpperLinLimit(1);
        slider->setLowerAngLimit(0);
        slider->setUpperAngLimit(0);
        slider->setPoweredLinMotor(true);
        slider->setTargetLinMotorVelocity(5);
        slider->setMaxLinMotorForce(5);
        return slider;
    }
    if (drive == Drive::Spring)
    {
        auto spring = alongX(
            std::make_unique<btGeneric6DofSpringConstraint>(base, block, inBase, inBlock, true));
        spring->enableSpring(0, true);
        spring->setStiffness(0, 100);
        spring->setDamping(0, 1);
        spring->setEquilibriumPoint(0, 0);
        return spring;
    }
    auto joint =
        alongX(std::make_unique<btGeneric6DofSpring2Constraint>(base, block, inBase, inBlock));
    if (drive == Drive::Spring2)
    {
        joint->enableSpring(0, true);
        joint->setStiffness(0, 100, false);
        joint->setDamping(0, 0, false);
        joint->setEquilibriumPoint(0, 0);
    }
    else
    {
        joint->enableMotor(0, true);
        joint->setTargetVelocity(0, 5);
        joint->setMaxMotorForce(0, 5);
    }
    return joint;
}
DayUnderWay beatenDrive(Scene& scene, bool /*ours*/, Drive drive)
{
    btRigidBody* base = put(scene, scene.box(cubic(0.1)), 0, vec(0, 0, 0));
    btRigidBody* block = put(scene, scene.box(cubic(0.2)), 1, vec(1, 0, 0));
    block->setRestitution(1);
    scene.addConstraint(driveOf(drive, *base, *block));
    put(scene, scene.box(vec(0.1, 1, 1)), 0, vec(1.65, 0, 0))->setRestitution(1);
    put(scene, ball(scene, 0.02), 1e-4, vec(1.25, 0, 0), vec(60, 0, 0))->setRestitution(1);
    const bool isSpring = drive == Drive::Spring || drive == Drive::Spring2;
    block->setLinearVelocity(vec(isSpring ? 0.3 : 0, 0, 0));
    const auto fastest = std::make_shared<double>(0.0);
    // Of a motor of 5 N in a fifth of a second, and of a spring that swings.
    return {[=](int) { *fastest = std::max(*fastest, speedOf(*block)); },
            [=] { return isSpring ? (*fastest > 0.45 ? 1 : 0) : (*fastest < 0.7 ? 1 : 0); }};
}

/// Bodies on joints that let them go along x, while others collide beside them.
DayUnderWay bystanders(Scene& scene, bool /*ours*/)
{
    Bodies bodies;
    for (int kind = 0; kind < 4; ++kind)
    {
        btRigidBody* base = put(scene, scene.box(cubic(0.1)), 0, vec(-9, 3 * kind, 0));
        btRigidBody* body =
            put(scene, scene.box(cubic(0.2)), 1, vec(-8, 3 * kind, 0), vec(0.3, 0, 0));
        bodies.push_back(body);
        const btTransform inBase = poseAt(vec(0, 0, 0));
        const btTransform inBody = poseAt(vec(-1, 0, 0));
        if (kind == 1)
        {
            scene.addConstraint(alongX(
                std::make_unique<btGeneric6DofSpring2Constraint>(*base, *body, inBase, inBody)));
        }
        else if (kind == 2)
        {
            scene.addConstraint(alongX(
                std::make_unique<btGeneric6DofConstraint>(*base, *body, inBase, inBody, true)));
        }
        else if (kind == 3)
        {
            auto slider = std::make_unique<btSliderConstraint>(*base, *body, inBase, inBody, true);
            slider->setLowerLinLimit(-1);
            slider->setUpperLinLimit(1);
            scene.addConstraint(std::move(slider));
        }
        put(scene, scene.box(vec(0.1, 1, 1)), 0, vec(0.5, 3 * kind, 0))->setRestitution(1);
        put(scene, scene.box(vec(0.1, 1, 1)), 0, vec(2, 3 * kind, 0))->setRestitution(1);
        put(scene, ball(scene, 0.1), 1, vec(1, 3 * kind, 0), vec(200, 0, 0))->setRestitution(1);
    }
    return watched(bodies,
                   [](btRigidBody& body)
                   { return std::abs(double(body.getLinearVelocity().x()) - 0.3) > 1e-4; });
}

/// A ghost that leaves the world when the day is over.
std::shared_ptr<btPairCachingGhostObject> addGhost(
    Scene& scene, btCollisionShape* shape, const btVector3& place, int flags, int group, int mask)
{
    const auto callback = std::make_shared<btGhostPairCallback>();
    scene.world().getPairCache()->setInternalGhostPairCallback(callback.get());
    std::shared_ptr<btPairCachingGhostObject> ghost(
        new btPairCachingGhostObject,
        [&scene, callback](btPairCachingGhostObject* gone)
        {
            scene.world().removeCollisionObject(gone);
            scene.world().getPairCache()->setInternalGhostPairCallback(nullptr);
            delete gone;
        });
    ghost->setCollisionShape(shape);
    ghost->setWorldTransform(poseAt(place));
    ghost->setCollisionFlags(flags);
    scene.world().addCollisionObject(ghost.get(), group, mask);
    return ghost;
}

/// Bullet's character walks over a mesh to a wall while a body flies through the scene.
DayUnderWay character(Scene& scene, bool ours)
{
    scene.world().setGravity(vec(0, 0, -10));
    put(scene, solid(scene, vec(50, 50, 0.5), ours), 0, vec(0, 0, -0.5));
    put(scene, scene.box(vec(0.2, 5, 2)), 0, vec(5, 0, 2));
    put(scene, ball(scene, 0.05), 1, vec(-20, 3, 1), vec(600, 0, 0));
    auto* capsule = scene.keep(std::make_unique<btCapsuleShapeZ>(btScalar(0.4), btScalar(1)));
    const auto ghost = addGhost(scene,
                                capsule,
                                vec(0, 0, 2),
                                btCollisionObject::CF_CHARACTER_OBJECT,
                                btBroadphaseProxy::CharacterFilter,
                                btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
    const std::shared_ptr<btKinematicCharacterController> walker(
        new btKinematicCharacterController(ghost.get(), capsule, btScalar(0.35), vec(0, 0, 1)),
        [&scene, ghost](btKinematicCharacterController* gone)
        {
            scene.world().removeAction(gone);
            delete gone;
        });
    scene.world().addAction(walker.get());
    return {[=](int) { walker->setWalkDirection(vec(0.03, 0, 0)); },
            [=]
            {
                const btVector3& p = ghost->getWorldTransform().getOrigin();
                const bool isThere = p.x() > btScalar(4) && p.x() < btScalar(4.5) &&
                                     std::abs(double(p.z()) - 0.9) < 0.1;
                return isThere ? 0 : 1;
            }};
}

/// A slow and two fast balls fall through a ghost of 2 m.
DayUnderWay trigger(Scene& scene, bool ours)
{
    scene.world().setGravity(vec(0, 0, -10));
    const auto ghost = addGhost(scene,
                                scene.box(cubic(1)),
                                vec(0, 0, 5),
                                btCollisionObject::CF_NO_CONTACT_RESPONSE,
                                btBroadphaseProxy::DefaultFilter,
                                btBroadphaseProxy::AllFilter);
    Bodies balls;
    for (const double speed : {1.0, 300.0, 900.0})
    {
        const double x = 0.5 * double(balls.size()) - 0.5;
        balls.push_back(put(scene, ball(scene, 0.1), 1, vec(x, 0, 8), vec(0, 0, -speed)));
    }
    const auto seen = std::make_shared<std::set<const btCollisionObject*>>();
    const auto look = [=, &scene]
    {
        for (int i = 0; i < ghost->getNumOverlappingObjects(); ++i)
        {
            seen->insert(ghost->getOverlappingObject(i));
        }
        if (ours)
        {
            for (const btCcdPassage& passage : scene.ccd().getCcdPassages())
            {
                seen->insert(passage.m_object);
            }
        }
    };
    return {[=](int) { look(); },
            [=]
            {
                look();
                return int(std::ranges::count_if(
                    balls, [&](btRigidBody* body) { return seen->count(body) == 0; }));
            }};
}

/// A program adds a fast body in every step, from a tick callback, and removes the oldest.
DayUnderWay spawnInTicks(Scene& scene, bool ours, bool before)
{
    struct Spawner
    {
        Scene* scene;
        btCollisionShape* shape;
        Bodies bodies;
        std::size_t removed = 0;
    };
    put(scene, scene.box(vec(50, 50, 0.05)), 0, vec(0, 0, 0));
    const auto spawner =
        std::make_shared<Spawner>(Spawner{&scene, solid(scene, cubic(0.1), ours), {}});
    const auto tick = [](btDynamicsWorld* world, btScalar)
    {
        Spawner& all = *static_cast<Spawner*>(world->getWorldUserInfo());
        const auto n = double(all.bodies.size());
        all.bodies.push_back(put(*all.scene,
                                 all.shape,
                                 1,
                                 vec(0.3 * std::fmod(n, 7), 0.3 * std::fmod(n, 5), 5),
                                 vec(0, 0, -200)));
        if (all.bodies.size() > 15 + all.removed)
        {
            // The scene owns it.
            world->removeRigidBody(all.bodies[all.removed++]);
        }
    };
    scene.world().setInternalTickCallback(tick, spawner.get(), before);
    return {.wrong = [=]
            {
                return int(std::ranges::count_if(
                    spawner->bodies, [](btRigidBody* b) { return !(heightOf(*b) > 0); }));
            }};
}

/// Started and ended contacts of ten that land.
DayUnderWay callbacks(Scene& scene, bool ours, bool mesh)
{
    static int started;
    static int ended;
    started = ended = 0;
    gContactStartedCallback = [](btPersistentManifold* const&) { ++started; };
    gContactEndedCallback = [](btPersistentManifold* const&) { ++ended; };
    scene.world().setGravity(vec(0, 0, -10));
    put(scene, scene.box(vec(50, 50, 0.5)), 0, vec(0, 0, -0.5));
    for (int i = 0; i < 10; ++i)
    {
        put(scene, solid(scene, cubic(0.1), ours && mesh), 1, vec(0.5 * i, 0, 3), vec(0, 0, -100));
    }
    return {.wrong = []
            {
                gContactStartedCallback = nullptr;
                gContactEndedCallback = nullptr;
                return std::abs(started - ended - 10) + ended;
            }};
}

/// Rays at a ring, against the same ring of stock Bullet beside it.
DayUnderWay rays(Scene& scene, bool ours)
{
    const TriangleMesh ring = makeTorus(0.5, 0.15, 48, 24);
    const btVector3 aside = vec(0, 0, 100);
    const btTransform X(btQuaternion(vec(1, 2, 3).normalized(), btScalar(0.7)), vec(0.1, 0.2, 0.3));
    scene.body(
        ours ? static_cast<btCollisionShape*>(scene.mesh(ring)) : scene.staticMesh(ring), 0, X);
    scene.body(scene.staticMesh(ring), 0, btTransform(X.getRotation(), X.getOrigin() + aside));
    return {.wrong = [=, &scene]
            {
                const auto hit = [&](const btVector3& from, const btVector3& to)
                {
                    btCollisionWorld::ClosestRayResultCallback found(from, to);
                    scene.world().rayTest(from, to, found);
                    return double(found.m_closestHitFraction);
                };
                int wrong = 0;
                for (int i = 0; i < 2000; ++i)
                {
                    const double angle = 3.883 * i;
                    const btVector3 from =
                        vec(2 * std::cos(angle), 2 * std::sin(angle), (i % 40 - 20) / 25.0);
                    const double off = hit(from, -from) - hit(from + aside, -from + aside);
                    wrong += std::abs(off) > 1e-4 ? 1 : 0;
                }
                return wrong / 20;  // rays that graze an edge
            }};
}

/// Ground that is freed and made anew at another height, as worlds stream it.
DayUnderWay streaming(Scene& scene, bool /*ours*/)
{
    struct Chunk
    {
        std::vector<btScalar> heights = std::vector<btScalar>(65 * 65);
        std::unique_ptr<btHeightfieldTerrainShape> shape;
        btRigidBody* ground = nullptr;
        double level = 0.0;
        double lowest = 0.0;  // of the cube, above the level
        int wrong = 0;
    };
    const auto chunk = std::make_shared<Chunk>();
    btRigidBody* cube = put(scene, scene.box(cubic(0.1)), 1, vec(0.3, 0.2, 0));
    const auto renew = [=, &scene](int number)
    {
        if (chunk->ground != nullptr)
        {
            chunk->wrong += chunk->lowest > 0 && chunk->lowest < 1 ? 0 : 1;
            scene.world().removeRigidBody(chunk->ground);
        }
        chunk->level = number % 2 * 20 - number;
        chunk->lowest = 20.0;
        std::ranges::fill(chunk->heights, btScalar(chunk->level));
        chunk->shape.reset();
        chunk->shape = std::make_unique<btHeightfieldTerrainShape>(65,
                                                                   65,
                                                                   chunk->heights.data(),
                                                                   btScalar(1),
                                                                   btScalar(-50),
                                                                   btScalar(50),
                                                                   2,
                                                                   kDouble ? PHY_DOUBLE : PHY_FLOAT,
                                                                   false);
        if (chunk->ground == nullptr)
        {
            chunk->ground = put(scene, chunk->shape.get(), 0, vec(0, 0, 0));
        }
        else
        {
            chunk->ground->setCollisionShape(chunk->shape.get());
            scene.world().addRigidBody(chunk->ground);
        }
        cube->setWorldTransform(poseAt(vec(0.3, 0.2, chunk->level + 20)));
        cube->setLinearVelocity(vec(0, 0, -300));
        cube->setAngularVelocity(vec(0, 0, 0));
    };
    scene.world().setGravity(vec(0, 0, -10));
    return {[=](int step)
            {
                chunk->lowest = std::min(chunk->lowest, heightOf(*cube) - chunk->level);
                if (step % 20 == 0)
                {
                    renew(step / 20);
                }
            },
            [=, &scene]
            {
                scene.keep(std::move(chunk->shape));
                return chunk->wrong;
            }};
}

/// Put into the floor while it lives, this deep.
DayUnderWay putInto(Scene& scene, bool ours, bool mesh, bool meshFloor)
{
    scene.world().setGravity(vec(0, 0, -10));
    put(scene, solid(scene, vec(20, 20, 0.5), ours && meshFloor), 0, vec(0, 0, -0.5));
    Bodies bodies;
    for (int i = 0; i < 4; ++i)
    {
        bodies.push_back(
            put(scene, solid(scene, cubic(0.2), ours && mesh), 1, vec(2 * i, 0, 0.21)));
    }
    const auto before = [=](int step)
    {
        constexpr std::array kDepths{0.01, 0.05, 0.15, 0.3};
        for (std::size_t i = 0; step == 30 && i < bodies.size(); ++i)
        {
            bodies[i]->setWorldTransform(poseAt(vec(2.0 * double(i), 0, 0.2 - kDepths[i])));
            bodies[i]->setLinearVelocity(vec(0, 0, 0));
        }
    };
    return {before, count(bodies, [](btRigidBody& b) { return !(heightOf(b) > 0.19); })};
}

/// Colliders of a pool whose multibody is replaced, as environments reset.
DayUnderWay pool(Scene& scene, bool ours)
{
    put(scene, solid(scene, vec(3, 3, 0.01), ours), 0, vec(0, 0, 0));
    const std::vector<btCollisionShape*> links(4, solid(scene, vec(0.18, 0.02, 0.02), ours));
    const auto make = []
    {
        auto arm = std::make_unique<btMultiBody>(4, btScalar(0), vec(1, 1, 1), true, false);
        arm->setBasePos(vec(0, 0, 1));
        for (int i = 0; i < 4; ++i)
        {
            arm->setupRevolute(i,
                               btScalar(0.1),
                               vec(0.01, 0.01, 0.01),
                               i - 1,
                               btQuaternion::getIdentity(),
                               vec(0, 1, 0),
                               i == 0 ? vec(0, 0, 0) : vec(0.2, 0, 0),
                               vec(0.2, 0, 0),
                               true);
        }
        arm->finalizeMultiDof();
        return arm;
    };
    const auto wrong = std::make_shared<int>(0);
    const auto arm = std::make_shared<std::unique_ptr<btMultiBody>>();
    // The scene owns the first one; it goes back behind its colliders when the day is over.
    btMultiBody* first = scene.addMultiBody(make(), nullptr, links);
    auto& world = dynamic_cast<btMultiBodyDynamicsWorld&>(scene.world());
    const auto current = [=] { return *arm != nullptr ? arm->get() : first; };
    const auto replace = [=, &world](btMultiBody* by)
    {
        btMultiBody* old = current();
        world.removeMultiBody(old);
        for (int i = 0; i < 4; ++i)
        {
            btMultiBodyLinkCollider* collider = old->getLink(i).m_collider;
            collider->m_multiBody = by;
            by->getLink(i).m_collider = collider;
        }
        world.addMultiBody(by);
        Scene::placeColliders(*by);
    };
    return {[=](int step)
            {
                for (int i = 0; i < 4; ++i)
                {
                    *wrong +=
                        current()->getLink(i).m_collider->getWorldTransform().getOrigin().z() <
                                btScalar(-0.05)
                            ? 1
                            : 0;
                }
                if (step % 20 == 0)
                {
                    if (step > 0)
                    {
                        auto next = make();
                        replace(next.get());
                        *arm = std::move(next);
                    }
                    for (int i = 0; i < 4; ++i)
                    {
                        current()->setJointVel(i, btScalar(30 - 7 * i));
                    }
                }
            },
            [=]
            {
                replace(first);
                arm->reset();
                return *wrong;
            }};
}

/// Two pointers that a gear joins; one has a motor and a limit, and meets a ball.
DayUnderWay gears(Scene& scene, bool /*ours*/, bool fixedBase)
{
    auto made = std::make_unique<btMultiBody>(2, btScalar(1), vec(1, 1, 1), fixedBase, false);
    made->setHasSelfCollision(false);
    for (int i = 0; i < 2; ++i)
    {
        made->setupRevolute(i,
                            btScalar(1),
                            vec(0.1, 0.1, 0.1),
                            -1,
                            btQuaternion::getIdentity(),
                            vec(0, 0, 1),
                            vec(i == 0 ? -0.6 : 0.6, 0, 0),
                            vec(0.25, 0, 0),
                            true);
    }
    made->finalizeMultiDof();
    btCollisionShape* link = scene.box(vec(0.2, 0.02, 0.02));
    btMultiBody* both = scene.addMultiBody(std::move(made), nullptr, {link, link});
    scene.addConstraint(
        std::make_unique<btMultiBodyJointMotor>(both, 0, btScalar(4), btScalar(0.2)));
    scene.addConstraint(
        std::make_unique<btMultiBodyJointLimitConstraint>(both, 0, btScalar(-1), btScalar(2)));
    auto gear = std::make_unique<btMultiBodyGearConstraint>(both,
                                                            0,
                                                            both,
                                                            1,
                                                            vec(0, 0, 0),
                                                            vec(0, 0, 0),
                                                            btMatrix3x3::getIdentity(),
                                                            btMatrix3x3::getIdentity());
    gear->setGearRatio(-1);
    gear->setMaxAppliedImpulse(btScalar(1e4));
    scene.addConstraint(std::move(gear));
    put(scene, ball(scene, 0.05), 0.2, vec(-0.6, 0.4, 0))->setRestitution(btScalar(0.5));
    return {.wrong = [=]
            {
                const double pointer = double(both->getJointPos(0));
                const double other = double(both->getJointPos(1));
                return (pointer > 1.9 && pointer < 2.1 ? 0 : 1) +
                       (std::abs(std::abs(other) - pointer) < 0.1 ? 0 : 1);
            }};
}

/// What its filters let through has to go through.
DayUnderWay filtered(Scene& scene, bool ours, bool byObject)
{
    btRigidBody* plate = put(scene, solid(scene, vec(5, 5, 0.001), ours), 0, vec(0, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 5; ++i)
    {
        btCollisionShape* cube = solid(scene, cubic(0.1), ours && i % 2 == 0);
        bodies.push_back(put(scene, cube, 1, vec(i - 2, 0, 2), vec(0, 0, -50 - 50 * i)));
        if (byObject)
        {
            bodies.back()->setIgnoreCollisionCheck(plate, true);
        }
        else
        {
            scene.world().removeRigidBody(bodies.back());
            scene.world().addRigidBody(bodies.back(), 64, 64);
        }
    }
    return {.wrong = count(bodies, [](btRigidBody& body) { return heightOf(body) > -1; })};
}

/// Bodies that use Bullet's own motion clamping already.
DayUnderWay clamped(Scene& scene, bool ours)
{
    put(scene, solid(scene, vec(9, 9, 0.001), ours), 0, vec(0, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 10; ++i)
    {
        btCollisionShape* rod = i % 2 == 0 ? solid(scene, vec(0.3, 0.02, 0.02), ours)
                                           : static_cast<btCollisionShape*>(ball(scene, 0.05));
        bodies.push_back(put(scene, rod, 1, vec(i - 5, 0, 2), vec(0, 0, -30 - 30 * i)));
        bodies.back()->setAngularVelocity(vec(0, 20 + 9 * i, 5));
        bodies.back()->setCcdMotionThreshold(btScalar(0.01));
        bodies.back()->setCcdSweptSphereRadius(btScalar(0.02));
    }
    return watched(bodies, [](btRigidBody& body) { return !(heightOf(body) > -0.05); });
}

/// Bodies that may move in a plane only.
DayUnderWay inPlane(Scene& scene, bool ours)
{
    put(scene, solid(scene, vec(0.001, 5, 5), ours), 0, vec(2, 0, 0));
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
    {
        bodies.push_back(put(scene,
                             solid(scene, vec(0.2, 0.02, 0.1), ours && i % 2 == 0),
                             1,
                             vec(0, i - 4, 0.1 * i),
                             vec(60 + 40 * i, 0, 0)));
        bodies.back()->setLinearFactor(vec(1, 0, 1));
        bodies.back()->setAngularFactor(vec(0, 1, 0));
        bodies.back()->setAngularVelocity(vec(0, 30 + i, 0));
    }
    return watched(bodies,
                   [=](btRigidBody& body)
                   {
                       const auto i = std::ranges::find(bodies, &body) - bodies.begin();
                       return !(at(body).x() < 2.05) ||
                              std::abs(double(at(body).y()) - double(i) + 4) > 0.01;
                   });
}

enum class Turn
{
    Removed,
    Added,
    Freed,
    Swapped,
};
/// What the ground or the bodies become on the way.
DayUnderWay turned(Scene& scene, bool ours, Turn turn)
{
    btRigidBody* plate = put(scene, solid(scene, vec(9, 9, 0.001), ours), 0, vec(0, 0, 0));
    scene.world().setGravity(vec(0, 0, -10));
    if (turn == Turn::Added)
    {
        scene.world().removeRigidBody(plate);
    }
    btCollisionShape* cube = solid(scene, cubic(0.1), ours);
    btCollisionShape* globe = ball(scene, 0.1);
    Bodies bodies;
    for (int i = 0; i < 8; ++i)
    {
        bodies.push_back(put(scene,
                             i % 2 == 0 ? cube : globe,
                             turn == Turn::Freed ? 0 : 1,
                             vec(i - 4, 0, turn == Turn::Removed ? 0.1 : 20),
                             vec(0, 0, turn == Turn::Removed ? 0 : -60 - 30 * i)));
        if (turn == Turn::Freed)
        {
            bodies.back()->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        }
    }
    const auto act = [=, &scene](int step)
    {
        if (step == 5 && turn == Turn::Removed)
        {
            scene.world().removeRigidBody(plate);
            scene.world().addRigidBody(plate, 0, 0);
        }
        if (step == 3 && turn == Turn::Added)
        {
            scene.world().addRigidBody(plate);
        }
        for (std::size_t i = 0; i < bodies.size(); ++i)
        {
            btRigidBody& body = *bodies[i];
            if (step == 2 && turn == Turn::Freed)
            {
                scene.world().removeRigidBody(&body);
                body.setCollisionFlags(0);
                body.setMassProps(1, vec(0.01, 0.01, 0.01));
                body.setLinearVelocity(vec(0, 0, -100 - 100 * double(i)));
                scene.world().addRigidBody(&body);
            }
            if (turn == Turn::Swapped)
            {
                body.setCollisionShape((step + int(i)) % 2 == 0 ? cube : globe);
            }
        }
    };
    if (turn == Turn::Removed)
    {
        return {act, count(bodies, [](btRigidBody& body) { return heightOf(body) > -1; })};
    }
    return watched(
        bodies, [](btRigidBody& b) { return !(heightOf(b) > 0); }, act);
}
}  // namespace

std::vector<Day> daysOfFeatures()
{
    constexpr WorldClass kLinks = WorldClass::MultiBody;
    constexpr double kFrame = 1.0 / 60.0;
    return {
        {"beaten spring", "driven", 30, with(beatenDrive, Drive::Spring2)},
        {"beaten older spring", "driven", 30, with(beatenDrive, Drive::Spring)},
        {"beaten slider motor", "stopped", 14, with(beatenDrive, Drive::SliderMotor)},
        {"beaten motor", "stopped", 14, with(beatenDrive, Drive::Motor2)},
        {"bystanders on joints", "disturbed", 60, with(bystanders)},
        {"character", "astray", 300, with(character)},
        {"trigger", "not seen", 60, with(trigger)},
        {"bodies from ticks", "through", 90, with(spawnInTicks, false)},
        {"from ticks before", "through", 90, with(spawnInTicks, true)},
        {"callbacks of boxes", "too many", 90, with(callbacks, false)},
        {"callbacks of meshes", "too many", 90, with(callbacks, true)},
        {"rays at a ring", "wrong", 1, with(rays)},
        {"streamed terrain", "wrong", 200, with(streaming)},
        {"box put into a box", "not out", 180, with(putInto, false, false)},
        {"mesh put into a box", "not out", 180, with(putInto, true, false)},
        {"mesh put into a mesh", "not out", 180, with(putInto, true, true)},
        {"pool of colliders", "through", 200, with(pool), kFrame, kLinks},
        {"gears on a fixed base", "wrong", 120, with(gears, true), kFrame, kLinks},
        {"gears that float", "wrong", 120, with(gears, false), kFrame, kLinks},
        {"filtered by group", "stopped", 60, with(filtered, false)},
        {"filtered by object", "stopped", 60, with(filtered, true)},
        {"Bullet's own clamping", "through", 60, with(clamped)},
        {"in a plane", "through", 60, with(inPlane)},
        {"floor removed", "not fallen", 90, with(turned, Turn::Removed)},
        {"floor added", "through", 60, with(turned, Turn::Added)},
        {"freed bodies", "through", 60, with(turned, Turn::Freed)},
        {"shapes swapped", "through", 60, with(turned, Turn::Swapped)},
    };
}
}  // namespace bullet_ccd::reference::day
