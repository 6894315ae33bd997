#include "bullet_ccd/bullet/step/btCcdManifolds.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/contact/contact_patches.h"
#include "bullet_ccd/math/check.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace
{
using bullet_ccd::Contact;
using bullet_ccd::ContactPatch;
using bullet_ccd::ContactSurface;

/// Cosine of the angle by which the normal of a patch may turn from one update to the next.
constexpr double kSamePatch = 0.8;
/// Points farther from each other than that many reaches are never the same.
constexpr double kSamePoint = 10.0;

/// What all pairs of a thread share, so that nothing is allocated once it is warm.
struct Scratch
{
    struct Entry
    {
        std::weak_ptr<const bullet_ccd::SsvTree> m_tree;
        std::unique_ptr<const ContactSurface> m_surface;
    };

    std::unordered_map<const bullet_ccd::SsvTree*, Entry> m_surfaces;
    bullet_ccd::PatchWorkspace m_work;
    std::vector<btManifoldPoint> m_old;

    const ContactSurface& surfaceOf(const std::shared_ptr<const bullet_ccd::SsvTree>& tree)
    {
        const auto known = m_surfaces.find(tree.get());
        // Another tree may have lived at this address before.
        if (known != m_surfaces.end() && !known->second.m_tree.expired())
        {
            return *known->second.m_surface;
        }
        std::erase_if(m_surfaces, [](const auto& item) { return item.second.m_tree.expired(); });
        Entry& entry = m_surfaces[tree.get()];
        entry = {tree, std::make_unique<const ContactSurface>(*tree)};
        return *entry.m_surface;
    }
};

Scratch& scratch()
{
    thread_local Scratch mine;
    return mine;
}

double shellOf(const btCcdShapePart& a, const btCcdShapePart& b)
{
    const double sum = a.m_margin + b.m_margin;
    return sum > 0.0 ? sum : btCcdManifolds::kLeastShell;
}

/// Contacts of all parts of two shapes, moved out to the surfaces of the shells: the gap becomes
/// the depth, negative inside.
class Collector
{
public:
    Collector(const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b,
              double asked,
              Scratch& scratch)
        : m_a(btCcdToEigen(a.getWorldTransform())),
          m_b(btCcdToEigen(b.getWorldTransform())),
          m_asked(asked),
          m_scratch(scratch)
    {
        m_scratch.m_work.raw.clear();
    }

    void add(const btCcdShapePart& a, const btCcdShapePart& b)
    {
        std::vector<Contact>& raw = m_scratch.m_work.raw;
        const double shell = shellOf(a, b);
        const double reach = std::max(shell, btCcdManifolds::kLeastReach) + m_asked;
        const std::size_t first = raw.size();
        const Eigen::Vector3d middleA = m_a * (a.X_SG * a.m_tree->origin());
        const Eigen::Vector3d middleB = m_b * (b.X_SG * b.m_tree->origin());
        bullet_ccd::appendContacts(m_scratch.surfaceOf(a.m_tree),
                                   m_a * btCcdMeshPose(a, m_a.inverse() * middleB),
                                   m_scratch.surfaceOf(b.m_tree),
                                   m_b * btCcdMeshPose(b, m_b.inverse() * middleA),
                                   reach + shell + a.m_radius + b.m_radius,
                                   m_scratch.m_work.search,
                                   raw);
        const double outA = a.m_radius + 0.5 * (shell + a.m_margin - b.m_margin);
        const double outB = b.m_radius + 0.5 * (shell + b.m_margin - a.m_margin);
        for (std::size_t i = first; i < raw.size(); ++i)
        {
            raw[i].pointA += outA * raw[i].normal;
            raw[i].pointB -= outB * raw[i].normal;
            raw[i].gap -= outA + outB;
        }
        m_reach = std::max(m_reach, reach);
    }

    /// The largest depth of a point.
    [[nodiscard]] double reach() const { return m_reach; }

private:
    Eigen::Isometry3d m_a;
    Eigen::Isometry3d m_b;
    double m_asked;
    Scratch& m_scratch;
    double m_reach = 0.0;
};

/// The manifold's own order of the bodies, which is not always that of the question.
bool isSwapped(const btPersistentManifold& manifold, const btCollisionObjectWrapper& a)
{
    return manifold.getBody0() != a.getCollisionObject();
}

/// The triangle of a mesh as Bullet counts them; else what the parent of the shape says, which is
/// the child of a compound.
btCcdTriangleId idOf(const btCollisionObjectWrapper& wrapper,
                     const btCcdShapePart& part,
                     std::int32_t triangle)
{
    const int type = wrapper.getCollisionShape()->getShapeType();
    if (!btBroadphaseProxy::isConcave(type) || type == STATIC_PLANE_PROXYTYPE)
    {
        return {wrapper.m_partId, wrapper.m_index};
    }
    return part.m_triangleIds != nullptr ? (*part.m_triangleIds)[std::size_t(triangle)]
                                         : btCcdTriangleId{0, triangle};
}

/// Through the result, which combines the materials and tells the callbacks.
void addPoint(const Contact& contact,
              const btCcdManifolds::Sides& sides,
              bool swapped,
              btManifoldResult& result)
{
    const btCcdTriangleId ofA = idOf(sides.m_a, sides.m_partA, contact.triangleA);
    const btCcdTriangleId ofB = idOf(sides.m_b, sides.m_partB, contact.triangleB);
    const bool isFirst = result.getBody0Internal() == sides.m_a.getCollisionObject();
    const btCcdTriangleId& of0 = isFirst ? ofA : ofB;
    const btCcdTriangleId& of1 = isFirst ? ofB : ofA;
    result.setShapeIdentifiersA(of0.m_part, of0.m_index);
    result.setShapeIdentifiersB(of1.m_part, of1.m_index);
    const Eigen::Vector3d normalOnB = swapped ? contact.normal : Eigen::Vector3d(-contact.normal);
    result.addContactPoint(btCcdToBullet(normalOnB),
                           btCcdToBullet(swapped ? contact.pointA : contact.pointB),
                           btScalar(contact.gap));
}

/// A point that the friction holds keeps its place: its friction pulls back to there.
bool holds(const btManifoldPoint& old, const btManifoldPoint& fresh)
{
    const btScalar limit = old.m_combinedFriction * old.m_appliedImpulse;
    const btScalar lateralSquared = old.m_appliedImpulseLateral1 * old.m_appliedImpulseLateral1 +
                                    old.m_appliedImpulseLateral2 * old.m_appliedImpulseLateral2;
    return (fresh.m_contactPointFlags & BT_CONTACT_FLAG_FRICTION_ANCHOR) != 0 &&
           lateralSquared <= limit * limit;
}

/// @pre both points have the bodies in the order of the manifold
void inherit(const btManifoldPoint& old,
             const btPersistentManifold& manifold,
             btManifoldPoint& point)
{
    point.m_appliedImpulse = old.m_appliedImpulse;
    point.m_prevRHS = old.m_prevRHS;
    point.m_appliedImpulseLateral1 = old.m_appliedImpulseLateral1;
    point.m_appliedImpulseLateral2 = old.m_appliedImpulseLateral2;
    point.m_userPersistentData = old.m_userPersistentData;
    point.m_lifeTime = old.m_lifeTime + 1;
    if (holds(old, point))
    {
        point.m_localPointA = old.m_localPointA;
        point.m_localPointB = old.m_localPointB;
        point.m_positionWorldOnA = manifold.getBody0()->getWorldTransform() * old.m_localPointA;
        point.m_positionWorldOnB = manifold.getBody1()->getWorldTransform() * old.m_localPointB;
    }
}

/// Gives every new point the impulses of the old one that it continues, the nearest pairs first.
/// What is left of the old ones ends.
void inheritAll(std::vector<btManifoldPoint>& old, btManifoldArray& manifolds, double range)
{
    struct Pair
    {
        btScalar squared = 0;
        std::size_t old = 0;
        btPersistentManifold* manifold = nullptr;
        int point = 0;
    };
    // Points that are done are marked by the age that they get.
    for (;;)
    {
        Pair best{.squared = btScalar(range * range)};
        for (int m = 0; m < manifolds.size(); ++m)
        {
            for (int k = 0; k < manifolds[m]->getNumContacts(); ++k)
            {
                const btManifoldPoint& fresh = manifolds[m]->getContactPoint(k);
                for (std::size_t i = 0; i < old.size() && fresh.m_lifeTime == 0; ++i)
                {
                    const btScalar squared =
                        std::min(old[i].m_localPointA.distance2(fresh.m_localPointA),
                                 old[i].m_localPointB.distance2(fresh.m_localPointB));
                    if (squared <= best.squared)
                    {
                        best = {squared, i, manifolds[m], k};
                    }
                }
            }
        }
        if (best.manifold == nullptr)
        {
            break;
        }
        inherit(old[best.old], *best.manifold, best.manifold->getContactPoint(best.point));
        std::swap(old[best.old], old.back());
        old.pop_back();
    }
    for (btManifoldPoint& point : old)
    {
        manifolds[0]->clearUserCache(point);
    }
    old.clear();
}

/// Of points that were there before, as Bullet does when it brings them up to date.
void tellProcessed(btManifoldArray& manifolds)
{
    for (int m = 0; gContactProcessedCallback != nullptr && m < manifolds.size(); ++m)
    {
        btPersistentManifold& manifold = *manifolds[m];
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            if (manifold.getContactPoint(k).m_lifeTime > 0)
            {
                gContactProcessedCallback(manifold.getContactPoint(k),
                                          const_cast<btCollisionObject*>(manifold.getBody0()),
                                          const_cast<btCollisionObject*>(manifold.getBody1()));
            }
        }
    }
}

/// Replaces the points of a manifold. Bullet would merge a new point with an old one by a distance
/// that also decides how far apart bodies may be; so each is added beside a single point far away,
/// which also says that this contact is not new, and all are put together afterwards.
void refill(btPersistentManifold& manifold,
            std::span<const Contact> contacts,
            const btCcdManifolds::Sides& sides,
            double reach,
            btManifoldResult& result)
{
    std::array<btManifoldPoint, MANIFOLD_CACHE_SIZE> fresh;
    const bool isNew = manifold.getNumContacts() == 0;
    manifold.setContactBreakingThreshold(btScalar(1.001 * reach));
    result.setPersistentManifold(&manifold);
    int count = 0;
    for (const Contact& contact : contacts)
    {
        const int before = isNew && count == 0 ? 0 : 1;
        manifold.setNumContacts(before);
        if (before > 0)
        {
            constexpr btScalar kFarAway = 1e15F;
            manifold.getContactPoint(0).m_localPointA.setValue(kFarAway, kFarAway, kFarAway);
        }
        addPoint(contact, sides, isSwapped(manifold, sides.m_a), result);
        // A result that only reports adds nothing.
        if (manifold.getNumContacts() > before)
        {
            fresh[std::size_t(count++)] = manifold.getContactPoint(before);
        }
    }
    manifold.setNumContacts(0);
    for (int i = 0; i < count; ++i)
    {
        manifold.addManifoldPoint(fresh[std::size_t(i)]);
    }
}
}  // namespace

btCcdManifolds::~btCcdManifolds()
{
    for (int i = 0; i < m_manifolds.size(); ++i)
    {
        m_dispatcher->releaseManifold(m_manifolds[i]);
    }
}

void btCcdManifolds::update(const btCollisionObjectWrapper& a,
                            const btCcdShapeModel& modelA,
                            const btCollisionObjectWrapper& b,
                            const btCcdShapeModel& modelB,
                            btPersistentManifold* shared,
                            btManifoldResult& result)
{
    BULLET_CCD_ASSERT(modelA.m_parts.size() == 1 && modelB.m_parts.size() == 1);
    const Sides sides{a, modelA.m_parts.front(), b, modelB.m_parts.front()};
    Scratch& mine = scratch();
    recall(a, b, mine.m_work);
    Collector collector(a, b, double(result.m_closestPointDistanceThreshold), mine);
    collector.add(sides.m_partA, sides.m_partB);
    bullet_ccd::reducePatches({.threshold = collector.reach(), .maxPatches = kMaxManifolds},
                              mine.m_work);
    if (shared == nullptr)
    {
        assign(sides, mine.m_work, collector.reach(), result);
        return;
    }
    result.setPersistentManifold(shared);
    for (const Contact& contact : mine.m_work.contacts)
    {
        addPoint(contact, sides, isSwapped(*shared, a), result);
    }
}

/// Where the points would be now, if they went along with one body or the other.
void btCcdManifolds::recall(const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b,
                            bullet_ccd::PatchWorkspace& work) const
{
    work.former.clear();
    for (int i = 0; i < m_manifolds.size(); ++i)
    {
        const bool swapped = isSwapped(*m_manifolds[i], a);
        for (int k = 0; k < m_manifolds[i]->getNumContacts(); ++k)
        {
            const btManifoldPoint& point = m_manifolds[i]->getContactPoint(k);
            const btVector3& inA = swapped ? point.m_localPointB : point.m_localPointA;
            const btVector3& inB = swapped ? point.m_localPointA : point.m_localPointB;
            work.former.push_back(
                {.onA = btCcdToEigen(a.getCollisionObject()->getWorldTransform() * inA),
                 .onB = btCcdToEigen(b.getCollisionObject()->getWorldTransform() * inB)});
        }
    }
}

void btCcdManifolds::assign(const Sides& sides,
                            const bullet_ccd::PatchWorkspace& found,
                            double reach,
                            btManifoldResult& result)
{
    const btCollisionObjectWrapper& a = sides.m_a;
    // A patch of more points than a manifold has room for takes several.
    static_assert(MANIFOLD_CACHE_SIZE == 4);
    std::array<Share, kMaxManifolds> shares{};
    std::size_t count = 0;
    for (const ContactPatch& patch : found.patches)
    {
        for (std::int32_t i = 0; i < patch.count && count < shares.size(); i += MANIFOLD_CACHE_SIZE)
        {
            const std::int32_t points = std::min(patch.count - i, MANIFOLD_CACHE_SIZE);
            shares[count++] = {
                .normal = patch.normal,
                .contacts = std::span(found.contacts)
                                .subspan(std::size_t(patch.first + i), std::size_t(points))};
        }
    }
    chooseManifolds(a, sides.m_b, std::span(shares).first(count));
    std::vector<btManifoldPoint>& old = scratch().m_old;
    old.clear();
    for (int i = 0; i < m_manifolds.size(); ++i)
    {
        const auto isMine = [&](const Share& share) { return share.manifold == m_manifolds[i]; };
        const bool isTaken =
            std::any_of(shares.begin(), shares.begin() + std::ptrdiff_t(count), isMine);
        const bool isFirstWay = isSwapped(*m_manifolds[i], a) == isSwapped(*m_manifolds[0], a);
        for (int k = 0; k < m_manifolds[i]->getNumContacts() && isFirstWay; ++k)
        {
            // The owner of the user data is now the copy.
            old.push_back(m_manifolds[i]->getContactPoint(k));
            m_manifolds[i]->getContactPoint(k).m_userPersistentData = nullptr;
        }
        if (!isTaken)
        {
            m_manifolds[i]->clearManifold();
        }
    }
    for (const Share& share : std::span(shares).first(count))
    {
        refill(*share.manifold, share.contacts, sides, reach, result);
    }
    inheritAll(old, m_manifolds, kSamePoint * reach);
    tellProcessed(m_manifolds);
    dropEmpty();
}

/// For each share the manifold that held this patch before, else any other.
void btCcdManifolds::chooseManifolds(const btCollisionObjectWrapper& a,
                                     const btCollisionObjectWrapper& b,
                                     std::span<Share> shares)
{
    std::array<bool, kMaxManifolds> isTaken{};
    for (Share& share : shares)
    {
        double best = kSamePatch;
        int chosen = -1;
        for (int i = 0; i < m_manifolds.size(); ++i)
        {
            if (isTaken[std::size_t(i)] || m_manifolds[i]->getNumContacts() == 0)
            {
                continue;
            }
            const double sign = isSwapped(*m_manifolds[i], a) ? 1.0 : -1.0;
            const btVector3& normalOnB = m_manifolds[i]->getContactPoint(0).m_normalWorldOnB;
            const double like = sign * share.normal.dot(btCcdToEigen(normalOnB));
            if (like > best)
            {
                best = like;
                chosen = i;
            }
        }
        if (chosen >= 0)
        {
            isTaken[std::size_t(chosen)] = true;
            share.manifold = m_manifolds[chosen];
        }
    }
    for (Share& share : shares)
    {
        for (int i = 0; i < kMaxManifolds && share.manifold == nullptr; ++i)
        {
            if (i == m_manifolds.size())
            {
                m_manifolds.push_back(
                    m_dispatcher->getNewManifold(a.getCollisionObject(), b.getCollisionObject()));
            }
            if (!isTaken[std::size_t(i)])
            {
                isTaken[std::size_t(i)] = true;
                share.manifold = m_manifolds[i];
            }
        }
    }
}

/// The first stays: a pair that comes apart for a moment needs it again.
void btCcdManifolds::dropEmpty()
{
    for (int i = m_manifolds.size() - 1; i > 0; --i)
    {
        if (m_manifolds[i]->getNumContacts() == 0)
        {
            m_dispatcher->releaseManifold(m_manifolds[i]);
            m_manifolds.removeAtIndex(i);
        }
    }
}

void btCcdManifolds::appendTo(btManifoldArray& manifolds) const
{
    for (int i = 0; i < m_manifolds.size(); ++i)
    {
        manifolds.push_back(m_manifolds[i]);
    }
}
