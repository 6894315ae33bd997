#include "benchmarks/reference/audit/room_judge.h"
#include "benchmarks/reference/bullet/scene.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/soak/bullet_soaks.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>
#include <BulletDynamics/ConstraintSolver/btSliderConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace reference;
using Eigen::Vector3d;

/// A closed room with all that a program may do in it, at random.
class RandomRoom : public btCcdImpactListener
{
public:
    static constexpr double kHalf = Room{}.half;
    static constexpr double kLongestStep = 60.0;  // by the clock [s]

    /// @param stock  the same room in stock Bullet, about which nothing is said
    RandomRoom(std::uint64_t seed, int bodies, bool stock)
        : m_random(seed),
          m_kind(pick(2) == 0 ? Kind::Action : Kind::World),
          m_scene(stock ? Kind::Stock : m_kind,
                  pick(2) == 0 ? WorldClass::MultiBody : WorldClass::Rigid),
          m_speed(m_random.logUniform(1.0, 100.0)),
          m_timeStep(std::vector{1.0 / 240, 1.0 / 60, 1.0 / 30}[pick(3)]),
          m_room(makeWalls()),
          m_judge(m_room, m_timeStep)
    {
        m_kind = stock ? Kind::Stock : m_kind;
        m_scene.world().setGravity(vec(0, 0, pick(4) == 0 ? 0 : -10));
        const int count = 5 + pick(pick(4) == 0 ? 3 * bodies : bodies);
        for (int i = 0; i < count; ++i)
        {
            spawn();
        }
        for (int i = pick(4); i > 0; --i)
        {
            btRigidBody* mover = m_scene.body(shape(), 0.0, pose(0.6 * kHalf));
            mover->setCollisionFlags(mover->getCollisionFlags() |
                                     btCollisionObject::CF_KINEMATIC_OBJECT);
            mover->setActivationState(DISABLE_DEACTIVATION);
            m_movers.push_back({mover, mover->getWorldTransform(), m_random.uniform(0.5, 20.0)});
        }
        for (int i = pick(6); i > 0; --i)
        {
            join();
        }
        if (isOurs(m_kind))
        {
            m_scene.ccd().setCcdImpactListener(this);
        }
    }

    /// "" or what is wrong.
    std::string run(double seconds)
    {
        const int steps = int(seconds / m_timeStep);
        for (m_step = 0; m_step < steps; ++m_step)
        {
            act();
            const auto begin = std::chrono::steady_clock::now();
            m_scene.step(m_timeStep);
            const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
            m_slowest = std::max(m_slowest, passed.count());
            if (std::string wrong = judge(); !wrong.empty())
            {
                return wrong;
            }
        }
        return "";
    }
    [[nodiscard]] std::map<std::string, std::int64_t> counts() const
    {
        std::map<std::string, std::int64_t> counts = namedCounts(m_scene.counters());
        counts["bodies"] = std::int64_t(m_bodies.size());
        counts["bodies that began in walls"] = m_judge.begunInWalls();
        counts["not out of them in a second"] = m_judge.notComeOut();
        return counts;
    }
    [[nodiscard]] int notComeOut() const { return m_judge.notComeOut(); }
    btCcdAfterImpact onImpact(const btCcdImpact&) override { return btCcdAfterImpact::Solve; }
    void onYield(const btCollisionObject& object, btCcdYield how, const btCcdImpact&) override
    {
        if (how == btCcdYield::Squeezed)
        {
            m_squeezed.insert(&object);
        }
    }

private:
    struct Mover
    {
        btRigidBody* body;
        btTransform middle;
        double rate;
    };
    Random m_random;
    Kind m_kind;
    Scene m_scene;
    double m_speed;
    double m_timeStep;
    Room m_room;
    RoomJudge m_judge;
    int m_step = 0;
    double m_slowest = 0.0;
    std::vector<btRigidBody*> m_bodies;
    std::vector<Mover> m_movers;
    std::set<const btCollisionObject*> m_joined;
    std::set<const btCollisionObject*> m_squeezed;

    int pick(int count)
    {
        return std::min(static_cast<int>(m_random.uniform(0, count)), count - 1);
    }
    Room makeWalls()
    {
        Room room;
        for (int axis = 0; axis < 3; ++axis)
        {
            for (const int side : {0, 1})
            {
                const double half = pick(2) == 0 ? 0.0005 : 0.05;
                Vector3d size = Vector3d::Constant(kHalf + 0.1);
                size[axis] = half;
                const Vector3d at = (side == 0 ? -1 : 1) * (kHalf + half) * Vector3d::Unit(axis);
                btCollisionShape* wall =
                    pick(2) == 0 ? static_cast<btCollisionShape*>(m_scene.box(btCcdToBullet(size)))
                                 : m_scene.boxMesh(btCcdToBullet(size));
                room.walls[std::size_t(axis)][std::size_t(side)] = half;
                m_scene.body(wall, 0.0, poseAt(btCcdToBullet(at)));
            }
        }
        return room;
    }
    btTransform pose(double reach)
    {
        Eigen::Isometry3d X = m_random.pose(1.0);
        X.translation() = m_random.inBox(reach);
        return btCcdToBullet(X);
    }
    btCollisionShape* shape()
    {
        const double a = m_random.logUniform(0.03, 0.25);
        const double b = m_random.uniform(0.2, 1.0) * a;
        const double c = m_random.uniform(0.1, 1.0) * a;
        const auto keep = [this](auto made)
        { return static_cast<btCollisionShape*>(m_scene.keep(std::move(made))); };
        switch (pick(11))
        {
            case 0:
                return m_scene.box(vec(a, b, c));
            case 1:
                return keep(std::make_unique<btSphereShape>(btScalar(a)));
            case 2:
                return keep(std::make_unique<btCapsuleShape>(btScalar(c), btScalar(a)));
            case 3:
                return keep(std::make_unique<btCylinderShape>(vec(b, a, b)));
            case 4:
                return keep(std::make_unique<btConeShape>(btScalar(b), btScalar(a)));
            case 5:
            {
                // Its origin may be far from its middle, or outside.
                auto hull = std::make_unique<btConvexHullShape>();
                for (int i = 4 + pick(12); i > 0; --i)
                {
                    hull->addPoint(btCcdToBullet(Vector3d(a * m_random.direction())));
                }
                return keep(std::move(hull));
            }
            case 6:
            {
                auto both = std::make_unique<btCompoundShape>();
                both->addChildShape(poseAt(vec(a, 0, 0)), m_scene.box(vec(a, b, c)));
                both->addChildShape(
                    poseAt(vec(-a, 0, 0)),
                    pick(2) == 0 ? static_cast<btCollisionShape*>(m_scene.boxMesh(vec(c, b, a)))
                                 : m_scene.box(vec(c, b, a)));
                return keep(std::move(both));
            }
            case 7:
                return m_scene.mesh(makeSphere(a, 1));
            case 8:
                return m_scene.mesh(makeTorus(a, 0.3 * a, 12, 6));
            default:
                return m_scene.boxMesh(vec(a, b, c));
        }
    }
    void spawn()
    {
        btRigidBody* body =
            m_scene.body(shape(), m_random.logUniform(0.1, 10.0), pose(0.8 * kHalf));
        body->setLinearVelocity(btCcdToBullet(m_random.inBox(m_speed)));
        body->setAngularVelocity(btCcdToBullet(m_random.inBox(30.0)));
        body->setRestitution(btScalar(m_random.uniform(0, 1)));
        body->setFriction(btScalar(m_random.uniform(0, 1)));
        m_bodies.push_back(body);
        freeFromWalls(body);
        if (pick(5) == 0)
        {
            putIntoWall(body);
        }
    }
    /// At rest, 3 to 30 mm deep in a thick wall, but to less than half of itself.
    void putIntoWall(btRigidBody* body)
    {
        const int axis = pick(3);
        const int side = pick(2);
        const double deep = m_random.logUniform(0.003, 0.03);
        if (m_room.walls[std::size_t(axis)][std::size_t(side)] < 0.01)
        {
            return;
        }
        btVector3 out(0, 0, 0);
        out[axis] = btScalar(side == 0 ? -1 : 1);
        const double reach = reachOf(*body, out);
        const double depth = std::min(deep, 0.4 * (reach + reachOf(*body, -out)));
        body->translate(btScalar(kHalf + depth - reach) * out);
        body->setLinearVelocity(vec(0, 0, 0));
        body->setAngularVelocity(vec(0, 0, 0));
        noteJump(body);
        m_judge.beginsInWall(*body, axis, side);
    }
    void noteJump(btRigidBody* body)
    {
        m_judge.forget(*body);
        m_squeezed.erase(body);
        if (isOurs(m_kind))
        {
            m_scene.ccd().teleported(body);
        }
    }
    /// A long thing may reach out of the room.
    void freeFromWalls(btRigidBody* body)
    {
        btVector3 low;
        btVector3 high;
        body->getCollisionShape()->getAabb(body->getWorldTransform(), low, high);
        btTransform X = body->getWorldTransform();
        for (int k = 0; k < 3; ++k)
        {
            const btScalar limit = btScalar(kHalf - 0.02);
            X.getOrigin()[k] +=
                std::max(-limit - low[k], btScalar(0)) - std::max(high[k] - limit, btScalar(0));
        }
        body->setWorldTransform(X);
        noteJump(body);
    }
    void join()
    {
        if (m_bodies.size() < 2)
        {
            return;
        }
        btRigidBody* a = m_bodies[std::size_t(pick(int(m_bodies.size())))];
        btRigidBody* b = m_bodies[std::size_t(pick(int(m_bodies.size())))];
        if (a == b || m_joined.count(a) || m_joined.count(b) || m_judge.isComingOut(*a) ||
            m_judge.isComingOut(*b))
        {
            return;
        }
        m_joined.insert(a);
        m_joined.insert(b);
        b->setWorldTransform(a->getWorldTransform() * poseAt(vec(0.3, 0, 0)));
        freeFromWalls(b);
        const btTransform inA = poseAt(vec(0.15, 0, 0));
        const btTransform inB = poseAt(vec(-0.15, 0, 0));
        const bool collide = pick(2) == 0;
        switch (pick(4))
        {
            case 0:
                m_scene.addConstraint(std::make_unique<btPoint2PointConstraint>(
                                          *a, *b, inA.getOrigin(), inB.getOrigin()),
                                      collide);
                break;
            case 1:
            {
                auto hinge = std::make_unique<btHingeConstraint>(*a, *b, inA, inB);
                hinge->enableAngularMotor(true, btScalar(m_random.uniform(-20, 20)), btScalar(0.5));
                m_scene.addConstraint(std::move(hinge), collide);
                break;
            }
            case 2:
            {
                auto slider = std::make_unique<btSliderConstraint>(*a, *b, inA, inB, true);
                slider->setLowerLinLimit(btScalar(-0.2));
                slider->setUpperLinLimit(btScalar(0.2));
                slider->setPoweredLinMotor(true);
                slider->setTargetLinMotorVelocity(btScalar(5));
                slider->setMaxLinMotorForce(btScalar(50));
                m_scene.addConstraint(std::move(slider), collide);
                break;
            }
            default:
            {
                auto spring = std::make_unique<btGeneric6DofSpring2Constraint>(*a, *b, inA, inB);
                spring->setLinearLowerLimit(vec(-0.1, -0.1, -0.1));
                spring->setLinearUpperLimit(vec(0.1, 0.1, 0.1));
                spring->enableSpring(0, true);
                spring->setStiffness(0, btScalar(200));
                m_scene.addConstraint(std::move(spring), collide);
            }
        }
    }
    void act()
    {
        const double time = m_step * m_timeStep;
        for (Mover& mover : m_movers)
        {
            btTransform X = mover.middle;
            X.setOrigin(X.getOrigin() + vec(0.5, 0.2, 0.3) * btScalar(std::sin(mover.rate * time)));
            X.setRotation(X.getRotation() *
                          btQuaternion(vec(0, 0, 1), btScalar(0.3 * mover.rate * time)));
            mover.body->setWorldTransform(X);
        }
        if (m_bodies.empty() || pick(4) != 0)
        {
            return;
        }
        const auto index = std::size_t(pick(int(m_bodies.size())));
        btRigidBody* body = m_bodies[index];
        if (m_judge.isComingOut(*body))
        {
            return;
        }
        m_judge.forget(*body);
        const bool joined = m_joined.count(body) != 0;
        switch (pick(6))
        {
            case 0:
                if (m_bodies.size() < 200)
                {
                    spawn();
                }
                break;
            case 1:
                if (!joined)
                {
                    m_scene.world().removeRigidBody(body);
                    m_bodies.erase(m_bodies.begin() + std::ptrdiff_t(index));
                }
                break;
            case 2:
                if (!joined)
                {
                    body->setWorldTransform(pose(0.8 * kHalf));
                    freeFromWalls(body);
                }
                break;
            case 3:
                if (!joined)
                {
                    m_scene.world().removeRigidBody(body);
                    body->setCollisionShape(shape());
                    freeFromWalls(body);
                    m_scene.world().addRigidBody(body);
                }
                break;
            case 4:
                body->setLinearVelocity(btCcdToBullet(m_random.inBox(m_speed)));
                body->activate();
                break;
            default:
                body->applyCentralImpulse(btCcdToBullet(m_random.inBox(m_speed)));
                body->activate();
        }
    }
    std::string judge()
    {
        for (std::size_t i = 0; i < m_bodies.size(); ++i)
        {
            btRigidBody* body = m_bodies[i];
            const RoomFinding found = m_judge.look(*body);
            if (found == RoomFinding::OutFromAWall ||
                (found == RoomFinding::Out && (m_squeezed.count(body) || m_kind == Kind::Stock)))
            {
                body->setWorldTransform(pose(0.8 * kHalf));
                body->setLinearVelocity(vec(0, 0, 0));
                freeFromWalls(body);
            }
            else if (found != RoomFinding::Nothing && m_kind != Kind::Stock)
            {
                constexpr std::array kWhat{"", "not finite", "out", "out", "held"};
                return fmt::format("step {}: {} {} ({}) is {}",
                                   m_step,
                                   body->getCollisionShape()->getName(),
                                   i,
                                   m_joined.count(body) != 0 ? "joined" : "free",
                                   kWhat[std::size_t(found)]);
            }
        }
        return m_slowest > kLongestStep ? "a step that did not end in time" : "";
    }
};

SoakAnswer runRoom(const RandomSoak& soak, std::uint64_t seed)
{
    RandomRoom room(seed, soak.bodies, false);
    std::string wrong = room.run(soak.seconds);
    if (wrong.empty() && room.notComeOut() > 0)
    {
        // Stock Bullet does not get everything out of walls either.
        RandomRoom stock(seed, soak.bodies, true);
        if (stock.run(soak.seconds); stock.notComeOut() < room.notComeOut())
        {
            wrong = fmt::format("{} bodies did not come out of walls, in stock Bullet {}",
                                room.notComeOut(),
                                stock.notComeOut());
        }
    }
    SoakAnswer answer{.counts = room.counts()};
    if (!wrong.empty())
    {
        answer.judgement = {.verdict = Verdict::Missed, .pair = wrong};
    }
    return answer;
}
}  // namespace

SoakSubject randomSoak(const RandomSoak& soak)
{
    return {.program = fmt::format("benchmarks/run soak bullet random --bodies {} --seconds {}",
                                   soak.bodies,
                                   soak.seconds),
            .families = {"room"},
            .shares = {.leastHits = 0},
            .ask = [soak](std::uint64_t seed) { return runRoom(soak, seed); }};
}
}  // namespace bullet_ccd::benchmarks
