#include "bullet_ccd/bullet/btCcdCollisionAlgorithm.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/motion/btCcdMultiBodyMotion.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdManifolds.h"
#include "bullet_ccd/bullet/step/btCcdPairToi.h"

#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btCompoundCompoundCollisionAlgorithm.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <mutex>
#include <vector>

namespace
{
// Bullet's default pool hands out elements of this size and does not check it in release builds.
constexpr std::size_t kPoolElement = 192;

constexpr std::array kConvexTypes{BOX_SHAPE_PROXYTYPE,
                                  TRIANGLE_SHAPE_PROXYTYPE,
                                  TETRAHEDRAL_SHAPE_PROXYTYPE,
                                  CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE,
                                  CONVEX_HULL_SHAPE_PROXYTYPE,
                                  CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE,
                                  SPHERE_SHAPE_PROXYTYPE,
                                  MULTI_SPHERE_SHAPE_PROXYTYPE,
                                  CAPSULE_SHAPE_PROXYTYPE,
                                  CONE_SHAPE_PROXYTYPE,
                                  CYLINDER_SHAPE_PROXYTYPE};
constexpr std::array kStockMeshTypes{TRIANGLE_MESH_SHAPE_PROXYTYPE,
                                     SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE,
                                     TERRAIN_SHAPE_PROXYTYPE,
                                     MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE};
constexpr std::array kOwnTypes{FAST_CONCAVE_MESH_PROXYTYPE, GIMPACT_SHAPE_PROXYTYPE};

template <std::size_t N>
bool isIn(const std::array<BroadphaseNativeTypes, N>& types, int type)
{
    return std::find(types.begin(), types.end(), type) != types.end();
}

bool isCompound(int type)
{
    return type == COMPOUND_SHAPE_PROXYTYPE;
}

std::vector<int> coveredTypes()
{
    std::vector<int> types{STATIC_PLANE_PROXYTYPE, COMPOUND_SHAPE_PROXYTYPE};
    types.insert(types.end(), kConvexTypes.begin(), kConvexTypes.end());
    types.insert(types.end(), kStockMeshTypes.begin(), kStockMeshTypes.end());
    types.insert(types.end(), kOwnTypes.begin(), kOwnTypes.end());
    return types;
}

/// Compounds take their children apart themselves, whatever these are.
bool contactsAreOurs(int type0, int type1)
{
    if (isCompound(type0) || isCompound(type1))
    {
        return false;
    }
    const auto isMesh = [](int type)
    { return isIn(kStockMeshTypes, type) || isIn(kOwnTypes, type); };
    return isIn(kOwnTypes, type0) || isIn(kOwnTypes, type1) || (isMesh(type0) && isMesh(type1));
}

struct CreateFunc : btCollisionAlgorithmCreateFunc
{
    btCollisionAlgorithmCreateFunc* m_stock = nullptr;     // null: contacts are ours
    btCollisionAlgorithmCreateFunc* m_replaced = nullptr;  // what was registered before

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override
    {
        if (m_stock != nullptr && (body0->m_parent != nullptr || body1->m_parent != nullptr))
        {
            // Children of compounds and triangles of meshes are asked for contacts only.
            return m_stock->CreateCollisionAlgorithm(info, body0, body1);
        }
        static_assert(sizeof(btCcdCollisionAlgorithm) <= kPoolElement);
        void* memory =
            info.m_dispatcher1->allocateCollisionAlgorithm(int(sizeof(btCcdCollisionAlgorithm)));
        return new (memory) btCcdCollisionAlgorithm(info, body0, body1, m_stock);
    }
};

using FuncTable = btCollisionAlgorithmCreateFunc* [MAX_BROADPHASE_COLLISION_TYPES]
    [MAX_BROADPHASE_COLLISION_TYPES];

/// The dispatcher has no way to ask what is registered; its tables are open to derived classes.
struct Tables : btCollisionDispatcher
{
    static FuncTable& contacts(btCollisionDispatcher& dispatcher)
    {
        return dispatcher.*(&Tables::m_doubleDispatchContactPoints);
    }
    static FuncTable& closestPoints(btCollisionDispatcher& dispatcher)
    {
        return dispatcher.*(&Tables::m_doubleDispatchClosestPoints);
    }
};

/// Bullet's algorithm for two compounds leaves those without trees of boxes to its base class, and
/// then does not say what manifolds that has.
struct CompoundPair : btCompoundCompoundCollisionAlgorithm
{
    static void appendOfBase(const btCollisionAlgorithm& algorithm, btManifoldArray& manifolds)
    {
        const auto* pair = dynamic_cast<const btCompoundCompoundCollisionAlgorithm*>(&algorithm);
        if (pair == nullptr)
        {
            return;
        }
        const auto& children = pair->*(&CompoundPair::m_childCollisionAlgorithms);
        for (int i = 0; i < children.size(); ++i)
        {
            if (children[i] != nullptr)
            {
                children[i]->getAllContactManifolds(manifolds);
            }
        }
    }
};

/// Create functions by dispatcher. They do not belong to it, so they live until they are
/// unregistered.
struct Registry
{
    std::mutex m_mutex;
    std::map<const btDispatcher*, std::vector<std::unique_ptr<CreateFunc>>> m_funcs;
};

Registry& registry()
{
    static Registry all;
    return all;
}

void registerIn(FuncTable& table, std::vector<std::unique_ptr<CreateFunc>>& funcs)
{
    const std::vector<int> types = coveredTypes();
    for (const int type0 : types)
    {
        for (const int type1 : types)
        {
            auto func = std::make_unique<CreateFunc>();
            func->m_replaced = table[type0][type1];
            func->m_stock = contactsAreOurs(type0, type1) ? nullptr : func->m_replaced;
            table[type0][type1] = func.get();
            funcs.push_back(std::move(func));
        }
    }
}

/// How an object moves, wherever that is known from.
class Motion
{
public:
    Motion(btCcdContext& context, const btCollisionObject& object, btScalar timeStep)
    {
        if (context.m_motions != nullptr &&
            (m_known = context.m_motions->motionOf(object)) != nullptr)
        {
            return;
        }
        m_known = &m_made;
        const auto* collider = btMultiBodyLinkCollider::upcast(&object);
        if (collider == nullptr)
        {
            m_made.m_motion = btCcdInterpolatedMotion(object);
            return;
        }
        if (!btCcdIsCovered(*collider->m_multiBody))
        {
            m_known = nullptr;
            return;
        }
        btCcdReadMotion(*collider->m_multiBody, timeStep, m_links);
        m_made = btCcdLinkMotion(*collider, m_links);
        std::vector<double> speeds;
        btCcdReadSpeeds(*collider->m_multiBody, double(timeStep), speeds);
        const double* link = &speeds[2 * std::size_t(collider->m_link + 1)];
        m_made.m_way =
            double(timeStep) *
            (link[0] + link[1] * double(object.getCollisionShape()->getAngularMotionDisc()));
    }
    Motion(const Motion&) = delete;
    Motion& operator=(const Motion&) = delete;

    /// Null if it cannot be told.
    [[nodiscard]] const btCcdObjectMotion* get() const
    {
        return m_known != nullptr && m_known->isFinite() ? m_known : nullptr;
    }

private:
    const btCcdObjectMotion* m_known = nullptr;
    btCcdObjectMotion m_made;
    btCcdMultiBodyMotion m_links;
};
}  // namespace

void btCcdCollisionAlgorithm::registerAlgorithm(btCollisionDispatcher* dispatcher)
{
    const std::lock_guard lock(registry().m_mutex);
    std::vector<std::unique_ptr<CreateFunc>>& funcs = registry().m_funcs[dispatcher];
    // Another dispatcher may have lived at this address before; and somebody may have registered
    // something of his own over ours.
    const auto isOwn = [&](const btCollisionAlgorithmCreateFunc* entry)
    {
        return std::any_of(
            funcs.begin(), funcs.end(), [&](const auto& func) { return func.get() == entry; });
    };
    for (const auto& row : Tables::contacts(*dispatcher))
    {
        if (std::any_of(std::begin(row), std::end(row), isOwn))
        {
            return;
        }
    }
    if (!funcs.empty())
    {
        btCcdContext::release(dispatcher);
        funcs.clear();
    }
    registerIn(Tables::contacts(*dispatcher), funcs);
    registerIn(Tables::closestPoints(*dispatcher), funcs);
}

void btCcdCollisionAlgorithm::unregisterAlgorithm(btCollisionDispatcher* dispatcher)
{
    const std::lock_guard lock(registry().m_mutex);
    std::vector<std::unique_ptr<CreateFunc>>& funcs = registry().m_funcs[dispatcher];
    for (FuncTable* table : {&Tables::contacts(*dispatcher), &Tables::closestPoints(*dispatcher)})
    {
        for (auto& row : *table)
        {
            for (btCollisionAlgorithmCreateFunc*& entry : row)
            {
                const auto own =
                    std::find_if(funcs.begin(),
                                 funcs.end(),
                                 [&](const auto& func) { return func.get() == entry; });
                if (own != funcs.end())
                {
                    entry = (*own)->m_replaced;
                }
            }
        }
    }
    registry().m_funcs.erase(dispatcher);
    btCcdContext::release(dispatcher);
}

void btCcdCollisionAlgorithm::forgetDispatcher(const btCollisionDispatcher* dispatcher)
{
    const std::lock_guard lock(registry().m_mutex);
    registry().m_funcs.erase(dispatcher);
    btCcdContext::release(dispatcher);
}

btCcdCollisionAlgorithm::btCcdCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* body0,
                                                 const btCollisionObjectWrapper* body1,
                                                 btCollisionAlgorithmCreateFunc* stock)
    : btActivatingCollisionAlgorithm(info, body0, body1),
      m_context(btCcdContext::of(*info.m_dispatcher1)),
      m_info(info),
      m_stockFunc(stock),
      m_manifolds(stock == nullptr ? std::make_unique<btCcdManifolds>(*info.m_dispatcher1)
                                   : nullptr)
{
}

btCcdCollisionAlgorithm::~btCcdCollisionAlgorithm()
{
    if (m_stock != nullptr)
    {
        m_stock->~btCollisionAlgorithm();
        m_dispatcher->freeCollisionAlgorithm(m_stock);
    }
}

void btCcdCollisionAlgorithm::processCollision(const btCollisionObjectWrapper* body0,
                                               const btCollisionObjectWrapper* body1,
                                               const btDispatcherInfo& dispatchInfo,
                                               btManifoldResult* result)
{
    if (m_stock != nullptr)  // a jump and no more, for the many pairs of stock shapes
    {
        m_stock->processCollision(body0, body1, dispatchInfo, result);
        return;
    }
    processOwn(body0, body1, dispatchInfo, result);
}

void btCcdCollisionAlgorithm::processOwn(const btCollisionObjectWrapper* body0,
                                         const btCollisionObjectWrapper* body1,
                                         const btDispatcherInfo& dispatchInfo,
                                         btManifoldResult* result)
{
    if (m_stockFunc != nullptr)
    {
        m_stock = m_stockFunc->CreateCollisionAlgorithm(m_info, body0, body1);
        m_isOfCompounds = isCompound(body0->getCollisionShape()->getShapeType()) &&
                          isCompound(body1->getCollisionShape()->getShapeType());
        m_stock->processCollision(body0, body1, dispatchInfo, result);
        return;
    }
    // What is nowhere touches nothing.
    if (!btCcdToEigen(body0->getWorldTransform()).matrix().allFinite() ||
        !btCcdToEigen(body1->getWorldTransform()).matrix().allFinite())
    {
        return;
    }
    const btCcdShapeModel* model0 = m_context.model(body0->getCollisionShape());
    const btCcdShapeModel* model1 = m_context.model(body1->getCollisionShape());
    if (model0 == nullptr || model1 == nullptr)
    {
        return;
    }
    const bool mayFollow = m_context.m_anyWithin && m_info.m_manifold == nullptr &&
                           result->m_closestPointDistanceThreshold == btScalar(0);
    if (!(mayFollow && m_manifolds->follow(*body0, *model0, *body1, *model1)))
    {
        m_manifolds->update(*body0, *model0, *body1, *model1, m_info.m_manifold, *result);
    }
}

btScalar btCcdCollisionAlgorithm::calculateTimeOfImpact(btCollisionObject* body0,
                                                        btCollisionObject* body1,
                                                        const btDispatcherInfo& dispatchInfo,
                                                        btManifoldResult* result)
{
    const btCcdShapeModel* model0 = m_context.model(body0->getCollisionShape());
    const btCcdShapeModel* model1 = m_context.model(body1->getCollisionShape());
    if (model0 == nullptr || model1 == nullptr)
    {
        return btScalar(1);
    }
    const Motion motion0(m_context, *body0, dispatchInfo.m_timeStep);
    const Motion motion1(m_context, *body1, dispatchInfo.m_timeStep);
    if (motion0.get() == nullptr || motion1.get() == nullptr)
    {
        return btScalar(1);
    }
    const btCcdPairToi toi = btCcdTimeOfImpact(
        {*model0, *motion0.get()},
        {*model1, *motion1.get()},
        m_context.toleranceOf(*body0, *body1),
        m_context.m_anyWithin,
        m_manifolds != nullptr ? m_manifolds->known(*body0,
                                                    btCcdShapePoseAt(*motion0.get(), 0.0),
                                                    btCcdShapePoseAt(*motion1.get(), 0.0))
                               : btCcdKnownOfPair());
    if (auto* impact = dynamic_cast<btCcdImpactResult*>(result))
    {
        impact->m_toi = toi;
    }
    return btCcdRoundDown(toi.m_fraction);
}

void btCcdCollisionAlgorithm::getAllContactManifolds(btManifoldArray& manifolds)
{
    if (m_stock != nullptr)
    {
        m_stock->getAllContactManifolds(manifolds);
        if (m_isOfCompounds)
        {
            CompoundPair::appendOfBase(*m_stock, manifolds);
        }
    }
    if (m_manifolds != nullptr)
    {
        m_manifolds->appendTo(manifolds);
    }
}
