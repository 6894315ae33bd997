#include "benchmarks/bullet/bench_bullet_queries.h"
#include "benchmarks/reference/bullet/scene.h"
#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btSubSimplexConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

namespace bullet_ccd::benchmarks
{
namespace
{
constexpr double kTolerance = 2e-4;  // of ours, as the worlds have it
constexpr int kGImpactSamples = 64;
constexpr double kCastTimeStep = 1.0 / 240.0;

struct Way
{
    btTransform fromA;
    btTransform toA;
    btTransform atB;
};

Way wayOf(const BulletQuery& query)
{
    return {btCcdToBullet(query.motionA.X_W0),
            btCcdToBullet(query.motionA.at(1.0).X_W),
            btCcdToBullet(query.X_WB)};
}

template <typename Cast, typename... Solver>
CastMethod convexCast(const char* name, const QueryFamily& family)
{
    struct State
    {
        std::unique_ptr<btCollisionShape> a;
        std::unique_ptr<btCollisionShape> b;
        Way way;
    };
    auto state = std::make_shared<State>(State{family.a.shape(), family.b.shape(), {}});
    return {.name = name,
            .prepare = [state](const BulletQuery& query) { state->way = wayOf(query); },
            .ask =
                [state]
            {
                btVoronoiSimplexSolver simplex;
                std::tuple<Solver...> solvers;
                Cast cast = std::apply(
                    [&](auto&... solver)
                    {
                        return Cast(static_cast<btConvexShape*>(state->a.get()),
                                    static_cast<btConvexShape*>(state->b.get()),
                                    &simplex,
                                    &solver...);
                    },
                    solvers);
                btConvexCast::CastResult result;
                const bool hit = cast.calcTimeOfImpact(
                    state->way.fromA, state->way.toA, state->way.atB, state->way.atB, result);
                return CastAnswer{hit, hit ? double(result.m_fraction) : 1.0};
            }};
}

/// btCollisionWorld::convexSweepTest of A in a world with B.
CastMethod sweepTest(const QueryFamily& family)
{
    struct State
    {
        reference::Scene scene{reference::Kind::Stock};
        btConvexShape* a = nullptr;
        btRigidBody* b = nullptr;
        Way way;
    };
    auto state = std::make_shared<State>();
    state->a = static_cast<btConvexShape*>(state->scene.keep(family.a.shape()));
    state->b =
        state->scene.body(state->scene.keep(family.b.shape()), 0.0, btTransform::getIdentity());
    return {.name = "convexSweepTest",
            .prepare =
                [state](const BulletQuery& query)
            {
                state->way = wayOf(query);
                state->b->setWorldTransform(state->way.atB);
                state->scene.world().updateSingleAabb(state->b);
            },
            .ask =
                [state]
            {
                btCollisionWorld::ClosestConvexResultCallback closest(state->way.fromA.getOrigin(),
                                                                      state->way.toA.getOrigin());
                state->scene.world().convexSweepTest(
                    state->a, state->way.fromA, state->way.toA, closest);
                return CastAnswer{closest.hasHit(), double(closest.m_closestHitFraction)};
            }};
}

/// One step of a world, the answer is where the body is stopped.
CastMethod motionThreshold(const QueryFamily& family)
{
    struct State
    {
        reference::Scene scene{reference::Kind::StockCcd};
        btRigidBody* a = nullptr;
        btRigidBody* b = nullptr;
        btVector3 from;
        btVector3 velocity;
    };
    auto state = std::make_shared<State>();
    reference::Scene& scene = state->scene;
    state->b = scene.body(scene.keep(family.b.shape()), 0.0, btTransform::getIdentity());
    state->a =
        scene.body(scene.keep(family.a.shape()), 1.0, reference::poseAt(reference::vec(9, 0, 0)));
    return {
        .name = "motion threshold",
        .prepare =
            [state](const BulletQuery& query)
        {
            const Way way = wayOf(query);
            state->b->setWorldTransform(way.atB);
            state->scene.world().updateSingleAabb(state->b);
            btRigidBody& a = *state->a;
            a.setCenterOfMassTransform(way.fromA);
            a.setInterpolationWorldTransform(way.fromA);
            state->from = way.fromA.getOrigin();
            state->velocity = btCcdToBullet(Eigen::Vector3d(query.motionA.v_W / kCastTimeStep));
            a.setLinearVelocity(state->velocity);
            a.setAngularVelocity(btCcdToBullet(Eigen::Vector3d(query.motionA.w_W / kCastTimeStep)));
            a.clearForces();
        },
        .ask =
            [state]
        {
            state->scene.step(kCastTimeStep);
            const double way =
                double((state->a->getWorldTransform().getOrigin() - state->from).length());
            const double time = way / (double(state->velocity.length()) * kCastTimeStep);
            return CastAnswer{time < 1.0 - 1e-5, time};
        }};
}

/// Two bodies and the algorithm that the dispatcher of their world has for them.
class AlgorithmPair
{
public:
    AlgorithmPair(reference::Kind kind,
                  std::unique_ptr<btCollisionShape> shapeA,
                  std::unique_ptr<btCollisionShape> shapeB)
        : m_scene(kind),
          a(*m_scene.body(m_scene.keep(std::move(shapeA)), 0.0, btTransform::getIdentity())),
          b(*m_scene.body(m_scene.keep(std::move(shapeB)), 0.0, btTransform::getIdentity()))
    {
        const btCollisionObjectWrapper wrapA = wrap(a);
        const btCollisionObjectWrapper wrapB = wrap(b);
        algorithm =
            dispatcher().findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    }
    ~AlgorithmPair()
    {
        algorithm->~btCollisionAlgorithm();
        dispatcher().freeCollisionAlgorithm(algorithm);
    }
    AlgorithmPair(const AlgorithmPair&) = delete;
    AlgorithmPair& operator=(const AlgorithmPair&) = delete;

    [[nodiscard]] static btCollisionObjectWrapper wrap(const btCollisionObject& object)
    {
        return {nullptr, object.getCollisionShape(), &object, object.getWorldTransform(), -1, -1};
    }
    [[nodiscard]] bool overlapsWithAAt(const btTransform& pose)
    {
        a.setWorldTransform(pose);
        const btCollisionObjectWrapper wrapA = wrap(a);
        const btCollisionObjectWrapper wrapB = wrap(b);
        btManifoldResult result(&wrapA, &wrapB);
        algorithm->processCollision(&wrapA, &wrapB, btDispatcherInfo(), &result);
        bool found = false;
        if (btPersistentManifold* manifold = result.getPersistentManifold())
        {
            found = manifold->getNumContacts() > 0;
            manifold->clearManifold();
        }
        return found;
    }

private:
    reference::Scene m_scene;

    [[nodiscard]] btDispatcher& dispatcher() { return *m_scene.world().getDispatcher(); }

public:
    btRigidBody& a;
    btRigidBody& b;
    btCollisionAlgorithm* algorithm = nullptr;
};

/// Overlap tests of GImpact along the way; the answer is the last free sample.
CastMethod gimpactSamples(const QueryFamily& family)
{
    const auto pair = std::make_shared<AlgorithmPair>(
        reference::Kind::Stock, family.a.gimpact(), family.b.gimpact());
    const auto samples = std::make_shared<std::vector<btTransform>>();
    return {.name = "GImpact, 64 samples",
            .prepare =
                [=](const BulletQuery& query)
            {
                samples->clear();
                for (int i = 0; i <= kGImpactSamples; ++i)
                {
                    samples->push_back(
                        btCcdToBullet(query.motionA.at(double(i) / kGImpactSamples).X_W));
                }
                pair->b.setWorldTransform(btCcdToBullet(query.X_WB));
            },
            .ask =
                [=]
            {
                for (int i = 0; i <= kGImpactSamples; ++i)
                {
                    if (pair->overlapsWithAAt((*samples)[std::size_t(i)]))
                    {
                        return CastAnswer{true, double(std::max(i - 1, 0)) / kGImpactSamples};
                    }
                }
                return CastAnswer{};
            }};
}

CastMethod ownToi(const QueryFamily& family)
{
    struct State
    {
        explicit State(const QueryFamily& asked)
            : a(buildSsvTree(asked.a.mesh)),
              b(buildSsvTree(asked.b.mesh)),
              options{.tolerance = kTolerance, .minimumSeparation = asked.a.radius + asked.b.radius}
        {
        }

        SsvTree a;
        SsvTree b;
        ToiOptions options;
        ToiWorkspace work;
        RigidMotion motionA;
        RigidMotion motionB;
    };
    auto state = std::make_shared<State>(family);
    return {.name = "ours, rigidToi",
            .prepare =
                [state](const BulletQuery& query)
            {
                state->motionA = query.motionA;
                state->motionB = restAt(query.X_WB);
            },
            .ask =
                [state]
            {
                const ToiResult result = rigidToi({.tree = &state->a, .motion = state->motionA},
                                                  {.tree = &state->b, .motion = state->motionB},
                                                  state->options,
                                                  state->work);
                return CastAnswer{isContact(result.status), result.time};
            }};
}

CastMethod ownAlgorithm(const QueryFamily& family)
{
    const auto pair =
        std::make_shared<AlgorithmPair>(reference::Kind::World, family.a.shape(), family.b.shape());
    return {.name = "ours, calculateTimeOfImpact",
            .prepare =
                [=](const BulletQuery& query)
            {
                const Way way = wayOf(query);
                pair->a.setWorldTransform(way.fromA);
                pair->a.setInterpolationWorldTransform(way.toA);
                pair->b.setWorldTransform(way.atB);
                pair->b.setInterpolationWorldTransform(way.atB);
            },
            .ask =
                [=]
            {
                btManifoldResult result;
                const double time = double(pair->algorithm->calculateTimeOfImpact(
                    &pair->a, &pair->b, btDispatcherInfo(), &result));
                return CastAnswer{time < 1.0, time};
            }};
}
}  // namespace

std::vector<CastMethod> castMethods(const QueryFamily& family)
{
    std::vector<CastMethod> methods;
    if (family.convex)
    {
        methods.push_back(convexCast<btContinuousConvexCollision, btGjkEpaPenetrationDepthSolver>(
            "btContinuousConvexCollision", family));
        methods.push_back(convexCast<btGjkConvexCast>("btGjkConvexCast", family));
        methods.push_back(convexCast<btSubsimplexConvexCast>("btSubsimplexConvexCast", family));
        methods.push_back(sweepTest(family));
        methods.push_back(motionThreshold(family));
    }
    if (family.a.gimpact && family.b.gimpact)
    {
        methods.push_back(gimpactSamples(family));
    }
    methods.push_back(ownToi(family));
    methods.push_back(ownAlgorithm(family));
    return methods;
}
}  // namespace bullet_ccd::benchmarks
