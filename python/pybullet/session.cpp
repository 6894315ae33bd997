#include "python/pybullet/session.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace
{
/// Stays with a client whose plugin was unloaded; the library stays in memory for it. Remembers the
/// world that it was told.
class Bystander : public HostGraphics
{
public:
    btDiscreteDynamicsWorld* m_world = nullptr;

private:
    void onWorld(btDiscreteDynamicsWorld* world) override { m_world = world; }
    void onReset() override { m_world = nullptr; }
};

Bystander& bystander()
{
    static auto* const one = new Bystander;  // never destroyed: clients may outlive the statics
    return *one;
}

constexpr const char* kSwitchedOff = "it was switched off";

/// PyBullet keeps the ids of its bodies there.
int bodyId(const btCollisionObject& object)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    return collider != nullptr ? collider->m_multiBody->getUserIndex2() : object.getUserIndex2();
}

int linkIndex(const btCollisionObject& object)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    return collider != nullptr ? collider->m_link : -1;
}
}  // namespace

Session::Session(HostProcessor& processor) : m_processor(processor)
{
    m_processor.setGraphics(this);
}

Session::~Session()
{
    // The processor knows whether the world is still there.
    m_processor.setGraphics(&bystander());
    detach(m_world != nullptr && m_world == std::exchange(bystander().m_world, nullptr));
}

void Session::onWorld(btDiscreteDynamicsWorld* world)
{
    detach(false);
    m_world = world;
    m_time = 0.0;
    attach();
}

void Session::onReset()
{
    detach(true);
    m_world = nullptr;
}

void Session::switchOn(bool on)
{
    m_on = on;
    if (!on && m_action != nullptr)
    {
        detach(true);
        m_problem = kSwitchedOff;
    }
    else if (on && m_problem == kSwitchedOff)
    {
        attach();
    }
}

void Session::attach()
{
    if (!m_on)
    {
        m_problem = kSwitchedOff;
        return;
    }
    m_objectFit = {};
    m_problem = misfitOfWorld(m_world);
    if (!m_problem.empty())
    {
        return giveUp(m_problem);
    }
    m_dispatcher = static_cast<btCollisionDispatcher*>(m_world->getDispatcher());
    m_action = std::make_unique<btCcdAction>(m_world);
    m_action->setCcdImpactListener(this);
    if (m_tolerance)
    {
        m_action->setCcdTolerance(*m_tolerance);
    }
    m_world->addAction(m_action.get());
    forgetPairs();
}

void Session::detach(bool worldIsThere)
{
    if (m_action != nullptr && worldIsThere)
    {
        m_world->removeAction(m_action.get());
        forgetPairs();
    }
    if (m_action != nullptr)
    {
        m_action.reset();
        if (worldIsThere)
        {
            btCcdCollisionAlgorithm::unregisterAlgorithm(m_dispatcher);
        }
        else
        {
            btCcdCollisionAlgorithm::forgetDispatcher(m_dispatcher);
        }
    }
    m_excluded.clear();
}

void Session::giveUp(const std::string& problem)
{
    detach(true);
    m_problem = problem;
    std::fprintf(stderr,
                 "bullet_ccd: this world has no continuous collision detection: %s\n",
                 problem.c_str());
}

/// Pairs keep the algorithm that they have, so those of before and ours must go.
void Session::forgetPairs()
{
    btOverlappingPairCache& cache = *m_world->getPairCache();
    btBroadphasePairArray& pairs = cache.getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); ++i)
    {
        cache.cleanOverlappingPair(pairs[i], m_world->getDispatcher());
    }
}

void Session::beforeStep()
{
    if (m_action == nullptr)
    {
        return;
    }
    const std::string problem = m_objectFit.misfit(*m_world);
    if (!problem.empty())
    {
        return giveUp(problem);
    }
    const btCollisionObjectArray& objects = m_world->getCollisionObjectArray();
    std::erase_if(m_excluded,
                  [&](const Excluded& excluded)
                  {
                      const bool isThere =
                          objects.findLinearSearch(excluded.m_object) < objects.size() &&
                          excluded.m_object->getBroadphaseHandle()->m_uniqueId == excluded.m_proxy;
                      if (!isThere)
                      {
                          m_action->setCcdEnabled(excluded.m_object, true);
                      }
                      return !isThere;
                  });
}

void Session::afterStep()
{
    if (m_action != nullptr)
    {
        m_time += double(m_world->getSolverInfo().m_timeStep);
    }
}

btCcdAction& Session::action()
{
    if (m_action == nullptr)
    {
        throw std::runtime_error("this world has no continuous collision detection: " + m_problem);
    }
    return *m_action;
}

void Session::setTolerance(double tolerance)
{
    action().setCcdTolerance(tolerance);
    m_tolerance = tolerance;
}

std::vector<btCollisionObject*> Session::objectsOf(int body)
{
    action();
    std::vector<btCollisionObject*> found;
    const btCollisionObjectArray& objects = m_world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        if (bodyId(*objects[i]) == body)
        {
            found.push_back(objects[i]);
        }
    }
    if (found.empty())
    {
        throw std::invalid_argument("there is no body " + std::to_string(body) +
                                    " with a collision shape");
    }
    return found;
}

void Session::setEnabled(int body, int link, bool enabled)
{
    for (btCollisionObject* object : objectsOf(body))
    {
        if (linkIndex(*object) != link)
        {
            continue;
        }
        m_action->setCcdEnabled(object, enabled);
        std::erase_if(m_excluded,
                      [&](const Excluded& excluded) { return excluded.m_object == object; });
        if (!enabled)
        {
            m_excluded.push_back({object, object->getBroadphaseHandle()->m_uniqueId});
        }
        return;
    }
    throw std::invalid_argument("body " + std::to_string(body) + " has no link " +
                                std::to_string(link) + " with a collision shape");
}

void Session::teleported(int body)
{
    for (const btCollisionObject* object : objectsOf(body))
    {
        m_action->teleported(object);
    }
}

std::vector<Impact> Session::takeImpacts(std::size_t most)
{
    const auto end = m_impacts.begin() + std::ptrdiff_t(std::min(most, m_impacts.size()));
    std::vector<Impact> taken(m_impacts.begin(), end);
    m_impacts.erase(m_impacts.begin(), end);
    return taken;
}

btCcdAfterImpact Session::onImpact(const btCcdImpact& impact)
{
    if (m_impacts.size() >= m_impactCapacity)
    {
        ++m_lostImpacts;
        return btCcdAfterImpact::Solve;
    }
    m_impacts.push_back({m_time + double(impact.m_time),
                         bodyId(*impact.m_objectA),
                         linkIndex(*impact.m_objectA),
                         bodyId(*impact.m_objectB),
                         linkIndex(*impact.m_objectB),
                         impact.m_pointA,
                         impact.m_pointB,
                         impact.m_normal});
    return btCcdAfterImpact::Solve;
}
