#include "bullet_ccd/bullet/btCcdControl.h"

#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"
#include "bullet_ccd/bullet/shapes/btCcdDebugDraw.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdStep.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/NarrowPhaseCollision/btManifoldPoint.h>
#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace
{
btDiscreteDynamicsWorld& registered(btDiscreteDynamicsWorld& world)
{
    auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(world.getDispatcher());
    if (dispatcher == nullptr)
    {
        throw std::invalid_argument(
            "btCcdControl: the dispatcher of the world is no btCollisionDispatcher (nor a "
            "btCollisionDispatcherMt), so that no algorithm can be registered with it: take one of "
            "the two, or a class that is derived from them");
    }
    btCcdCollisionAlgorithm::registerAlgorithm(dispatcher);
    return world;
}

/// All worlds and actions that there are.
struct Controls
{
    std::mutex m_mutex;
    std::vector<const btCcdControl*> m_all;
};

Controls& controls()
{
    static Controls all;
    return all;
}

/// Throws std::invalid_argument.
void requireValue(bool isGood, const char* name, double value, const char* remedy)
{
    if (!isGood)
    {
        std::ostringstream text;
        text << "setCcdSettings: " << name << " is " << value << ": " << remedy;
        throw std::invalid_argument(text.str());
    }
}

/// The two largest margins of meshes.
struct LargestMargins
{
    double m_first = 0.0;
    double m_second = 0.0;

    void add(const btCollisionShape& shape)
    {
        if (shape.isCompound())
        {
            const auto& compound = static_cast<const btCompoundShape&>(shape);
            for (int i = 0; i < compound.getNumChildShapes(); ++i)
            {
                add(*compound.getChildShape(i));
            }
        }
        else if (shape.isConcave() && !shape.isInfinite())
        {
            const double margin = double(shape.getMargin());
            m_second = std::max(m_second, std::min(m_first, margin));
            m_first = std::max(m_first, margin);
        }
    }
    [[nodiscard]] double sum() const { return m_first + m_second; }
};

void check(const btCcdObjectSettings& settings)
{
    requireValue(settings.m_mode == btCcdMode::Off ||
                     settings.m_mode == btCcdMode::TranslationOnly ||
                     settings.m_mode == btCcdMode::Full,
                 "m_mode",
                 double(int(settings.m_mode)),
                 "it must be Off, TranslationOnly or Full");
    requireValue(settings.m_tolerance > 0.0,
                 "the m_tolerance of an object",
                 settings.m_tolerance,
                 "it must be positive; infinity leaves the choice to the world");
    requireValue(settings.m_priority >= 0.0 && std::isfinite(settings.m_priority),
                 "m_priority",
                 settings.m_priority,
                 "it must be finite and not negative; 1 is that of most objects");
}

void check(const btCcdSettings& settings)
{
    requireValue(settings.m_tolerance > 0.0 && std::isfinite(settings.m_tolerance),
                 "m_tolerance",
                 settings.m_tolerance,
                 "it must be positive and finite; a thousandth of the smallest object is a good "
                 "choice");
    const btCcdBudget& budget = settings.m_budget;
    const auto requireLimit = [](const char* name, double limit)
    { requireValue(limit >= 0.0, name, limit, "no limit may be negative"); };
    requireLimit("m_impactsPerInstant", budget.m_impactsPerInstant);
    requireLimit("m_impactsPerBody", budget.m_impactsPerBody);
    requireLimit("m_impactsPerStep", budget.m_impactsPerStep);
    requireLimit("m_seconds", budget.m_seconds);
    check(settings.m_objects);
    requireValue(settings.m_drawLevel >= 0,
                 "m_drawLevel",
                 settings.m_drawLevel,
                 "it must not be negative; 0 is the root of the hierarchies");
}
}  // namespace

btCcdControl::btCcdControl(btDiscreteDynamicsWorld& world)
    : m_world(world),
      m_step(std::make_unique<btCcdStep>(registered(world))),
      m_context(btCcdContext::of(*world.getDispatcher()))
{
    m_settings.m_tolerance = m_context.m_tolerance;
    const std::lock_guard lock(controls().m_mutex);
    controls().m_all.push_back(this);
}

btCcdControl::~btCcdControl()
{
    const std::lock_guard lock(controls().m_mutex);
    std::erase(controls().m_all, this);
}

void btCcdControl::setCcdSettings(const btCcdSettings& settings)
{
    check(settings);
    m_settings = settings;
    m_context.m_tolerance = settings.m_tolerance;
    m_context.m_anyWithin = settings.m_anyWithin;
    m_context.m_objects.m_default = settings.m_objects;
    m_context.m_shapes.keepIn(settings.m_hierarchyFolder);
    m_step->setBudget(settings.m_budget);
    m_step->stepper().forgetShapes();
}

void btCcdControl::setCcdSettings(const btCollisionObject* object,
                                  const btCcdObjectSettings& settings)
{
    check(settings);
    m_context.m_objects.m_own.insert_or_assign(object, settings);
    m_step->stepper().forgetShapes();
}

const btCcdObjectSettings& btCcdControl::getCcdSettings(const btCollisionObject* object) const
{
    return m_context.m_objects.of(object);
}

void btCcdControl::resetCcdSettings(const btCollisionObject* object)
{
    m_context.m_objects.m_own.erase(object);
    m_step->stepper().forgetShapes();
}

void btCcdControl::setCcdTolerance(double tolerance)
{
    btCcdSettings settings = m_settings;
    settings.m_tolerance = tolerance;
    setCcdSettings(settings);
}

void btCcdControl::setCcdAccuracy(double accuracy)
{
    const double smallest = smallestCcdAccuracy();
    if (!(accuracy >= smallest && accuracy > 0.0 && std::isfinite(accuracy)))
    {
        std::ostringstream text;
        text << "setCcdAccuracy: " << accuracy << ": the smallest in this world is " << smallest
             << ": less is lost in the margins of its meshes or the rounding of its coordinates";
        throw std::invalid_argument(text.str());
    }
    btCcdSettings settings = m_settings;
    settings.m_tolerance = accuracy;
    settings.m_anyWithin = true;
    setCcdSettings(settings);
}

double btCcdControl::smallestCcdAccuracy() const
{
    LargestMargins margins;
    double reach = 0.0;
    const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
    {
        const btCollisionShape* shape = objects[i]->getCollisionShape();
        if (shape == nullptr)
        {
            continue;
        }
        margins.add(*shape);
        btVector3 low;
        btVector3 high;
        shape->getAabb(objects[i]->getWorldTransform(), low, high);
        for (const btVector3& corner : {low, high})
        {
            const double farthest = double(corner.absolute()[corner.absolute().maxAxis()]);
            if (farthest < 0.5 * double(BT_LARGE_FLOAT))  // planes have no end
            {
                reach = std::max(reach, farthest);
            }
        }
    }
    constexpr double kRoundings = 1000.0;
    return std::max(margins.sum(), kRoundings * double(SIMD_EPSILON) * reach);
}

double btCcdControl::getCcdTolerance() const
{
    return m_context.m_tolerance;
}

void btCcdControl::setCcdBudget(const btCcdBudget& budget)
{
    btCcdSettings settings = m_settings;
    settings.m_budget = budget;
    setCcdSettings(settings);
}

const btCcdBudget& btCcdControl::getCcdBudget() const
{
    return m_settings.m_budget;
}

void btCcdControl::setCcdEnabled(const btCollisionObject* object, bool enabled)
{
    const btCcdMode others = m_settings.m_objects.m_mode;
    btCcdObjectSettings settings = getCcdSettings(object);
    settings.m_mode = !enabled                   ? btCcdMode::Off
                      : others == btCcdMode::Off ? btCcdMode::Full
                                                 : others;
    if (settings == m_settings.m_objects)
    {
        resetCcdSettings(object);
        return;
    }
    setCcdSettings(object, settings);
}

bool btCcdControl::isCcdEnabled(const btCollisionObject* object) const
{
    return getCcdSettings(object).m_mode != btCcdMode::Off;
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

std::optional<btCcdImpact> btCcdImpactOf(const btManifoldPoint& point,
                                         const btCollisionObject* a,
                                         const btCollisionObject* b)
{
    const std::lock_guard lock(controls().m_mutex);
    const btVector3 place =
        btScalar(0.5) * (point.getPositionWorldOnA() + point.getPositionWorldOnB());
    const btCcdImpact* nearest = nullptr;
    btScalar least = BT_INFINITY;
    for (const btCcdControl* control : controls().m_all)
    {
        for (const btCcdStep::SeenImpact& seen : control->m_step->impacts())
        {
            const btCcdImpact& impact = seen.m_impact;
            const bool isTheirs = std::minmax<const btCollisionObject*>(
                                      impact.m_objectA, impact.m_objectB) == std::minmax(a, b);
            const btScalar distance = place.distance2(impact.m_pointA);
            if (isTheirs && (nearest == nullptr || distance < least))
            {
                nearest = &impact;
                least = distance;
            }
        }
    }
    if (nearest == nullptr || nearest->m_objectA == a)
    {
        return nearest != nullptr ? std::optional(*nearest) : std::nullopt;
    }
    return btCcdImpact{nearest->m_objectB,
                       nearest->m_objectA,
                       nearest->m_linkB,
                       nearest->m_linkA,
                       nearest->m_time,
                       nearest->m_pointB,
                       nearest->m_pointA,
                       -nearest->m_normal};
}

const std::vector<btCcdPassage>& btCcdControl::getCcdPassages() const
{
    return m_step->passages();
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
    btCcdSettings settings = m_settings;
    settings.m_drawLevel = level;
    setCcdSettings(settings);
}

bool btCcdControl::prepareCcdShape(const btCollisionShape* shape)
{
    return m_context.prepare(shape);
}

void btCcdControl::forgetCcdShape(const btCollisionShape* shape)
{
    m_context.m_shapes.forget(shape);
    m_step->stepper().forgetShapes();
}

void btCcdControl::noteBeforeSolving()
{
    m_step->noteBeforeSolving();
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
        btCcdDrawHierarchy(
            {*model, objects[i]->getWorldTransform()}, m_settings.m_drawLevel, *drawer);
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
