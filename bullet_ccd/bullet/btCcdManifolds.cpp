#include "bullet_ccd/bullet/btCcdManifolds.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/contact/contact_patches.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

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
        bullet_ccd::appendContacts(m_scratch.surfaceOf(a.m_tree),
                                   m_a * a.X_SG,
                                   m_scratch.surfaceOf(b.m_tree),
                                   m_b * b.X_SG,
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

/// Through the result, which combines the materials and tells the callbacks.
void addPoint(const Contact& contact, bool swapped, btManifoldResult& result)
{
    const Eigen::Vector3d normalOnB = swapped ? contact.normal : Eigen::Vector3d(-contact.normal);
    result.addContactPoint(btCcdToBullet(normalOnB),
                           btCcdToBullet(swapped ? contact.pointA : contact.pointB),
                           btScalar(contact.gap));
}

using Points = std::array<btManifoldPoint, MANIFOLD_CACHE_SIZE>;

/// A point that the friction holds keeps its place: its friction pulls back to there.
bool holds(const btManifoldPoint& old, const btManifoldPoint& fresh)
{
    const btScalar limit = old.m_combinedFriction * old.m_appliedImpulse;
    const btScalar lateralSquared = old.m_appliedImpulseLateral1 * old.m_appliedImpulseLateral1 +
                                    old.m_appliedImpulseLateral2 * old.m_appliedImpulseLateral2;
    return (fresh.m_contactPointFlags & BT_CONTACT_FLAG_FRICTION_ANCHOR) != 0 &&
           lateralSquared <= limit * limit;
}

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
void inheritAll(Points& old,
                int oldCount,
                double range,
                btPersistentManifold& manifold,
                Points& fresh,
                int count)
{
    std::array<bool, MANIFOLD_CACHE_SIZE> isOldUsed{};
    std::array<bool, MANIFOLD_CACHE_SIZE> isFreshDone{};
    for (int round = 0; round < std::min(count, oldCount); ++round)
    {
        auto least = btScalar(range * range);
        std::size_t bestOld = MANIFOLD_CACHE_SIZE;
        std::size_t bestFresh = MANIFOLD_CACHE_SIZE;
        for (std::size_t i = 0; i < std::size_t(oldCount); ++i)
        {
            for (std::size_t j = 0; j < std::size_t(count) && !isOldUsed[i]; ++j)
            {
                const btScalar squared =
                    std::min(old[i].m_localPointA.distance2(fresh[j].m_localPointA),
                             old[i].m_localPointB.distance2(fresh[j].m_localPointB));
                if (!isFreshDone[j] && squared <= least)
                {
                    least = squared;
                    bestOld = i;
                    bestFresh = j;
                }
            }
        }
        if (bestOld == MANIFOLD_CACHE_SIZE)
        {
            break;
        }
        isOldUsed[bestOld] = true;
        isFreshDone[bestFresh] = true;
        inherit(old[bestOld], manifold, fresh[bestFresh]);
    }
    for (std::size_t i = 0; i < std::size_t(oldCount); ++i)
    {
        if (!isOldUsed[i])
        {
            manifold.clearUserCache(old[i]);
        }
    }
}

/// Replaces the points of a manifold. Bullet would merge a new point with an old one by a distance
/// that also decides how far apart bodies may be; so each is added beside a single point far away,
/// which also says that this contact is not new, and all are put together afterwards.
void refill(btPersistentManifold& manifold,
            std::span<const Contact> contacts,
            bool swapped,
            double reach,
            btManifoldResult& result)
{
    Points old;
    Points fresh;
    const int oldCount = manifold.getNumContacts();
    for (int i = 0; i < oldCount; ++i)
    {
        old[std::size_t(i)] = manifold.getContactPoint(i);
    }
    manifold.setContactBreakingThreshold(btScalar(1.001 * reach));
    result.setPersistentManifold(&manifold);
    int count = 0;
    for (const Contact& contact : contacts)
    {
        const int before = oldCount + count > 0 ? 1 : 0;
        manifold.setNumContacts(before);
        if (before > 0)
        {
            constexpr btScalar kFarAway = 1e15F;
            manifold.getContactPoint(0).m_localPointA.setValue(kFarAway, kFarAway, kFarAway);
        }
        addPoint(contact, swapped, result);
        // A result that only reports adds nothing.
        if (manifold.getNumContacts() > before)
        {
            fresh[std::size_t(count++)] = manifold.getContactPoint(before);
        }
    }
    inheritAll(old, oldCount, kSamePoint * reach, manifold, fresh, count);
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
    Scratch& mine = scratch();
    recall(a, b, mine.m_work);
    Collector collector(a, b, double(result.m_closestPointDistanceThreshold), mine);
    for (const btCcdShapePart& partA : modelA.m_parts)
    {
        for (const btCcdShapePart& partB : modelB.m_parts)
        {
            collector.add(partA, partB);
        }
    }
    bullet_ccd::reducePatches({.threshold = collector.reach(), .maxPatches = kMaxManifolds},
                              mine.m_work);
    if (shared == nullptr)
    {
        assign(a, b, mine.m_work, collector.reach(), result);
        return;
    }
    result.setPersistentManifold(shared);
    for (const Contact& contact : mine.m_work.contacts)
    {
        addPoint(contact, isSwapped(*shared, a), result);
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

void btCcdManifolds::assign(const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b,
                            const bullet_ccd::PatchWorkspace& found,
                            double reach,
                            btManifoldResult& result)
{
    const std::vector<ContactPatch>& patches = found.patches;
    std::array<int, kMaxManifolds> manifoldOf{};
    std::array<bool, kMaxManifolds> isTaken{};
    manifoldOf.fill(-1);
    // The manifold that held this patch before, then any other.
    for (std::size_t p = 0; p < patches.size(); ++p)
    {
        double best = kSamePatch;
        for (int i = 0; i < m_manifolds.size(); ++i)
        {
            if (isTaken[std::size_t(i)] || m_manifolds[i]->getNumContacts() == 0)
            {
                continue;
            }
            const double sign = isSwapped(*m_manifolds[i], a) ? 1.0 : -1.0;
            const double like = sign * patches[p].normal.dot(btCcdToEigen(
                                           m_manifolds[i]->getContactPoint(0).m_normalWorldOnB));
            if (like > best)
            {
                best = like;
                manifoldOf[p] = i;
            }
        }
        if (manifoldOf[p] >= 0)
        {
            isTaken[std::size_t(manifoldOf[p])] = true;
        }
    }
    for (std::size_t p = 0; p < patches.size(); ++p)
    {
        for (int i = 0; i < m_manifolds.size() && manifoldOf[p] < 0; ++i)
        {
            manifoldOf[p] = isTaken[std::size_t(i)] ? -1 : i;
        }
        if (manifoldOf[p] < 0)
        {
            manifoldOf[p] = m_manifolds.size();
            m_manifolds.push_back(
                m_dispatcher->getNewManifold(a.getCollisionObject(), b.getCollisionObject()));
        }
        isTaken[std::size_t(manifoldOf[p])] = true;
    }
    for (int i = 0; i < m_manifolds.size(); ++i)
    {
        if (!isTaken[std::size_t(i)])
        {
            m_manifolds[i]->clearManifold();
        }
    }
    for (std::size_t p = 0; p < patches.size(); ++p)
    {
        btPersistentManifold& manifold = *m_manifolds[manifoldOf[p]];
        refill(manifold,
               std::span(found.contacts)
                   .subspan(std::size_t(patches[p].first), std::size_t(patches[p].count)),
               isSwapped(manifold, a),
               reach,
               result);
    }
    dropEmpty();
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
