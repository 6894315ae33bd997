#include "bullet_ccd/bullet/btCcdControl.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/shapes/btCcdDebugDraw.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdStep.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace
{
btDiscreteDynamicsWorld& registered(btDiscreteDynamicsWorld& world)
{
    if (auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(world.getDispatcher()))
    {
        btCcdCollisionAlgorithm::registerAlgorithm(dispatcher);
    }
    return world;
}
}  // namespace

btCcdControl::btCcdControl(btDiscreteDynamicsWorld& world)
    : m_world(world),
      m_step(std::make_unique<btCcdStep>(registered(world))),
      m_context(btCcdContext::of(*world.getDispatcher()))
{
}

btCcdControl::~btCcdControl() = default;

void btCcdControl::setCcdTolerance(double tolerance)
{
    if (!(tolerance > 0.0) || !std::isfinite(tolerance))
    {
        throw std::invalid_argument(
            "setCcdTolerance: the tolerance must be positive and finite; "
            "a thousandth of the smallest object is a good choice");
    }
    m_context.m_tolerance = tolerance;
}

double btCcdControl::getCcdTolerance() const
{
    return m_context.m_tolerance;
}

void btCcdControl::setCcdBudget(const btCcdBudget& budget)
{
    const int fewest =
        std::min({budget.m_impactsPerInstant, budget.m_impactsPerBody, budget.m_impactsPerStep});
    if (fewest < 0 || !(budget.m_seconds >= 0.0))
    {
        throw std::invalid_argument("setCcdBudget: no limit may be negative");
    }
    m_step->setBudget(budget);
}

const btCcdBudget& btCcdControl::getCcdBudget() const
{
    return m_step->budget();
}

void btCcdControl::setCcdEnabled(const btCollisionObject* object, bool enabled)
{
    m_step->stepper().setEnabled(object, enabled);
}

bool btCcdControl::isCcdEnabled(const btCollisionObject* object) const
{
    return m_step->stepper().isEnabled(object);
}

void btCcdControl::teleported(const btCollisionObject* object)
{
    m_step->teleported(*object);
}

void btCcdControl::setCcdImpactListener(btCcdImpactListener* listener)
{
    m_step->setListener(listener);
    m_step->stepper().setListener(listener);
}

const btCcdImpact* btCcdControl::findCcdImpact(const btCollisionObject* a,
                                               const btCollisionObject* b) const
{
    const std::vector<btCcdStep::SeenImpact>& all = m_step->impacts();
    const auto found = std::find_if(all.begin(),
                                    all.end(),
                                    [&](const btCcdStep::SeenImpact& seen)
                                    {
                                        return std::minmax<const btCollisionObject*>(
                                                   seen.m_impact.m_objectA,
                                                   seen.m_impact.m_objectB) == std::minmax(a, b);
                                    });
    return found != all.end() ? &found->m_impact : nullptr;
}

void btCcdControl::stopLinkOnFirstContact(btMultiBody* body, int link)
{
    m_step->stopOnFirstContact(body, link);
}

const btCcdCounters& btCcdControl::getCcdCounters() const
{
    return m_step->counters();
}

double btCcdControl::getCcdLostTime(const btCollisionObject* object) const
{
    return m_step->lostTime(object);
}

void btCcdControl::resetCcdCounters()
{
    m_step->resetCounters();
}

void btCcdControl::setCcdDrawLevel(int level)
{
    m_drawLevel = level;
}

void btCcdControl::forgetCcdShape(const btCollisionShape* shape)
{
    m_context.m_shapes.forget(shape);
    m_step->stepper().forgetShapes();
}

bool btCcdControl::beginStep(btScalar timeStep)
{
    return m_step->begin(timeStep);
}

void btCcdControl::integrateFromImpactToImpact(btScalar timeStep, const Integrate& integrate)
{
    m_step->integrate(timeStep, integrate);
}

void btCcdControl::endStep()
{
    m_step->end();
}

void btCcdControl::rollBackToImpacts(btScalar timeStep)
{
    m_step->rollBack(timeStep);
}

void btCcdControl::drawCcd(btIDebugDraw* drawer)
{
    if (drawer == nullptr || (drawer->getDebugMode() & btIDebugDraw::DBG_DrawWireframe) == 0)
    {
        return;
    }
    btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        const btCcdShapeModel* model = m_context.model(objects[i]->getCollisionShape());
        if (model == nullptr || !isCcdEnabled(objects[i]))
        {
            continue;
        }
        btCcdDrawHierarchy({*model, objects[i]->getWorldTransform()}, m_drawLevel, *drawer);
        btVector3 low;
        btVector3 high;
        if (m_step->stepper().sweptBox(*objects[i], low, high))
        {
            btCcdDrawSweptBox(low, high, *drawer);
        }
    }
    const auto isThere = [&](btCollisionObject* object)
    { return objects.findLinearSearch(object) < objects.size(); };
    for (const btCcdStep::SeenImpact& seen : m_step->impacts())
    {
        const btCcdImpact& impact = seen.m_impact;
        if (!isThere(impact.m_objectA) || !isThere(impact.m_objectB))
        {
            continue;  // removed since
        }
        const btCcdShapeModel* a = m_context.model(impact.m_objectA->getCollisionShape());
        const btCcdShapeModel* b = m_context.model(impact.m_objectB->getCollisionShape());
        if (a != nullptr && b != nullptr)
        {
            btCcdDrawImpact({*a, seen.m_poseA},
                            impact.m_pointA,
                            {*b, seen.m_poseB},
                            impact.m_pointB,
                            impact.m_normal,
                            *drawer);
        }
    }
}
