#include "bullet_ccd/bullet/step/btCcdManifolds.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/shapes/btCcdTiles.h"
#include "bullet_ccd/contact/contact_patches.h"
#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
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
        std::shared_ptr<const ContactSurface> m_surface;
    };

    std::unordered_map<const bullet_ccd::SsvTree*, Entry> m_surfaces;
    bullet_ccd::PatchWorkspace m_work;
    std::vector<btManifoldPoint> m_old;

    std::shared_ptr<const ContactSurface> surfaceOf(
        const std::shared_ptr<const bullet_ccd::SsvTree>& tree)
    {
        const auto known = m_surfaces.find(tree.get());
        // Another tree may have lived at this address before.
        if (known != m_surfaces.end() && !known->second.m_tree.expired())
        {
            return known->second.m_surface;
        }
        std::erase_if(m_surfaces, [](const auto& item) { return item.second.m_tree.expired(); });
        Entry& entry = m_surfaces[tree.get()];
        entry = {tree, std::make_shared<const ContactSurface>(*tree)};
        return entry.m_surface;
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

/// Two hierarchies that intersect, or are so near that their contacts have no direction, are looked
/// at where one of them has been moved out of the other: the shortest way out among some
/// directions.
class WayOut
{
public:
    /// Surfaces nearer than this part of the shell are taken apart, to between so much of it and
    /// all of it.
    static constexpr double kNear = 1.0 / 16.0;
    static constexpr double kApart = 1.0 / 4.0;

    WayOut(const bullet_ccd::SsvTree& a,
           const Eigen::Isometry3d& X_WA,
           const bullet_ccd::SsvTree& b,
           const Eigen::Isometry3d& X_WB,
           double shell)
        : m_treeA(a), m_treeB(b), m_A(X_WA), m_BW(X_WB.inverse()), m_shell(shell)
    {
        // Beyond that, what is caught is no more likely to come out than to go in.
        m_limit = std::min(a.radius(), b.radius());
    }

    /// Tries to move A against the normal.
    void look(const Eigen::Vector3d& normal)
    {
        double way = m_shell;
        double distance = distanceAt(normal, way);
        while (distance < kApart * m_shell && way < m_limit)
        {
            way = std::min(2.0 * way, m_limit);
            distance = distanceAt(normal, way);
        }
        if (distance < kApart * m_shell || way > m_limit || (way == m_limit && isFound()))
        {
            return;
        }
        for (int i = 0; i < kRefinements && distance > m_shell; ++i)
        {
            way -= distance - 0.5 * m_shell;
            distance = distanceAt(normal, way);
        }
        m_way = m_limit = way;
        m_normal = normal;
    }
    /// Others must be this much shorter than what was found.
    void prefer(double factor) { m_limit /= factor; }

    [[nodiscard]] bool isFound() const { return !m_normal.isZero(); }
    [[nodiscard]] double way() const { return m_way; }
    [[nodiscard]] double shell() const { return m_shell; }
    /// Points from A to B, as that of a contact.
    [[nodiscard]] const Eigen::Vector3d& normal() const { return m_normal; }
    [[nodiscard]] Eigen::Isometry3d poseOfA() const { return moved(m_normal, m_way); }

private:
    static constexpr int kRefinements = 12;

    [[nodiscard]] Eigen::Isometry3d moved(const Eigen::Vector3d& normal, double way) const
    {
        Eigen::Isometry3d pose = m_A;
        pose.translation() -= way * normal;
        return pose;
    }
    /// Far away does not matter.
    [[nodiscard]] double distanceAt(const Eigen::Vector3d& normal, double way) const
    {
        return bullet_ccd::treeDistance(
                   m_treeA, m_treeB, m_BW * moved(normal, way), way + 2.0 * m_shell)
            .distance;
    }

    const bullet_ccd::SsvTree& m_treeA;
    const bullet_ccd::SsvTree& m_treeB;
    Eigen::Isometry3d m_A;
    Eigen::Isometry3d m_BW;
    double m_shell;
    double m_limit;
    double m_way = 0.0;
    Eigen::Vector3d m_normal = Eigen::Vector3d::Zero();
};

/// Contacts of all parts of two shapes, moved out to the surfaces of the shells: the gap becomes
/// the depth, negative inside.
class Collector
{
public:
    /// @param former the normal of the last contacts of the two, zero if there were none
    Collector(const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b,
              double asked,
              const Eigen::Vector3d& former,
              Scratch& scratch)
        : m_a(btCcdToEigen(a.getWorldTransform())),
          m_b(btCcdToEigen(b.getWorldTransform())),
          m_asked(asked),
          m_processed(std::min(double(a.getCollisionObject()->getContactProcessingThreshold()),
                               double(b.getCollisionObject()->getContactProcessingThreshold()))),
          m_former(former),
          m_scratch(scratch)
    {
        m_scratch.m_work.raw.clear();
    }

    /// @param kept of the two hierarchies
    void add(const btCcdShapePart& a, const btCcdShapePart& b, bullet_ccd::KeptSlots& kept)
    {
        std::vector<Contact>& raw = m_scratch.m_work.raw;
        const double shell = shellOf(a, b);
        const double reach =
            std::max(std::min(shell, m_processed), btCcdManifolds::kLeastReach) + m_asked;
        const std::size_t first = raw.size();
        const Eigen::Vector3d middleA = m_a * (a.X_SG * a.m_tree->origin());
        const Eigen::Vector3d middleB = m_b * (b.X_SG * b.m_tree->origin());
        const Eigen::Isometry3d X_WA = m_a * btCcdMeshPose(a, m_a.inverse() * middleB);
        const Eigen::Isometry3d X_WB = m_b * btCcdMeshPose(b, m_b.inverse() * middleA);
        const std::shared_ptr<const ContactSurface> surfaceA = m_scratch.surfaceOf(a.m_tree);
        const std::shared_ptr<const ContactSurface> surfaceB = m_scratch.surfaceOf(b.m_tree);
        const double around = reach + shell + a.m_radius + b.m_radius;
        bullet_ccd::appendContacts(
            *surfaceA, X_WA, *surfaceB, X_WB, around, m_scratch.m_work.search, raw, &kept);
        const auto deepest =
            std::min_element(raw.begin() + std::ptrdiff_t(first),
                             raw.end(),
                             [](const Contact& x, const Contact& y) { return x.gap < y.gap; });
        if (deepest != raw.end() && deepest->gap <= WayOut::kNear * shell)
        {
            WayOut out(*a.m_tree, X_WA, *b.m_tree, X_WB, shell);
            findWayOut(out, first);
            if (out.isFound())
            {
                raw.resize(first);
                // Of all that is inside, not of what is deepest alone.
                bullet_ccd::appendContacts(*surfaceA,
                                           out.poseOfA(),
                                           *surfaceB,
                                           X_WB,
                                           around + out.way(),
                                           m_scratch.m_work.search,
                                           raw);
                moveBack(out, first, around);
            }
        }
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

    /// Of the deepest contact; zero without.
    [[nodiscard]] Eigen::Vector3d normal() const
    {
        const std::vector<Contact>& raw = m_scratch.m_work.raw;
        const auto deepest =
            std::min_element(raw.begin(),
                             raw.end(),
                             [](const Contact& x, const Contact& y) { return x.gap < y.gap; });
        return deepest != raw.end() ? deepest->normal : Eigen::Vector3d(Eigen::Vector3d::Zero());
    }
    /// The largest depth of a point.
    [[nodiscard]] double reach() const { return m_reach; }

private:
    /// Cosine of the angle between directions that are worth trying both.
    static constexpr double kOtherDirection = 0.9;
    static constexpr std::size_t kMostDirections = 12;
    /// Out the way that the two came, if that is not far, in shells.
    static constexpr double kSameWay = 8.0;
    static constexpr double kPreferred = 4.0;

    /// The normals of contacts between the first and last are those of faces that intersect.
    void findWayOut(WayOut& out, std::size_t first) const
    {
        const std::vector<Contact>& raw = m_scratch.m_work.raw;
        std::vector<Eigen::Vector3d> tried;
        const auto look = [&](const Eigen::Vector3d& normal)
        {
            const auto isLike = [&](const Eigen::Vector3d& other)
            { return normal.dot(other) > kOtherDirection; };
            if (tried.size() < kMostDirections && !std::any_of(tried.begin(), tried.end(), isLike))
            {
                tried.push_back(normal);
                out.look(normal);
            }
        };
        if (!m_former.isZero())
        {
            look(m_former);
            if (out.isFound() && out.way() <= kSameWay * out.shell())
            {
                return;
            }
            out.prefer(out.isFound() ? kPreferred : 1.0);
        }
        for (std::size_t i = first; i < raw.size(); ++i)
        {
            look(raw[i].normal);
        }
    }

    /// From where A has been moved to where it is. What is farther away than `around` is none.
    void moveBack(const WayOut& out, std::size_t first, double around) const
    {
        std::vector<Contact>& raw = m_scratch.m_work.raw;
        for (std::size_t i = first; i < raw.size(); ++i)
        {
            raw[i].pointA += out.way() * out.normal();
            raw[i].gap -= out.way() * raw[i].normal.dot(out.normal());
        }
        const auto isOther = [&](const Contact& contact)
        { return contact.normal.dot(out.normal()) < 0.0 || contact.gap > around; };
        raw.erase(std::remove_if(raw.begin() + std::ptrdiff_t(first), raw.end(), isOther),
                  raw.end());
    }

    Eigen::Isometry3d m_a;
    Eigen::Isometry3d m_b;
    double m_asked;
    double m_processed;  ///< depths below minus that are of no use to the solver
    Eigen::Vector3d m_former;
    Scratch& m_scratch;
    double m_reach = 0.0;
};

/// Of a large mesh, what is near the other part, which is all that contacts are looked for in.
class Near
{
public:
    Near(const btCollisionObjectWrapper& own,
         const btCcdShapePart& part,
         const btCollisionObjectWrapper& other,
         const btCcdShapePart& otherPart,
         double asked)
        : m_whole(&part)
    {
        if (part.m_tiles == nullptr)
        {
            return;
        }
        const btCcdBall ball = btCcdBallOf(otherPart);
        // With room for the neighbours of the triangles that are met.
        const double around = 1.25 * ball.m_radius + 4.0 * shellOf(part, otherPart) +
                              2.0 * btCcdManifolds::kLeastReach + asked;
        const Eigen::Isometry3d X_GS =
            (btCcdToEigen(own.getWorldTransform()) * part.X_SG).inverse() *
            btCcdToEigen(other.getWorldTransform());
        const Eigen::Vector3d center = X_GS * ball.m_center;
        const Eigen::Vector3d room = Eigen::Vector3d::Constant(around);
        m_piece = btCcdPieceOf(part, part.m_tiles->around({center - room, center + room}));
    }
    /// Without a hierarchy if there is nothing.
    [[nodiscard]] const btCcdShapePart& part() const { return m_piece ? *m_piece : *m_whole; }

private:
    const btCcdShapePart* m_whole;
    std::optional<btCcdShapePart> m_piece;
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
    if (old.m_userPersistentData != nullptr)
    {
        // What gContactAddedCallback has kept with the point that it took for a new one is undone.
        if (point.m_userPersistentData != nullptr &&
            point.m_userPersistentData != old.m_userPersistentData &&
            gContactDestroyedCallback != nullptr)
        {
            gContactDestroyedCallback(point.m_userPersistentData);
        }
        point.m_userPersistentData = old.m_userPersistentData;
    }
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
            manifold.getContactPoint(before).m_userPersistentData = nullptr;
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
    const double asked = double(result.m_closestPointDistanceThreshold);
    const Near nearA(a, modelA.m_parts.front(), b, modelB.m_parts.front(), asked);
    const Near nearB(b, modelB.m_parts.front(), a, modelA.m_parts.front(), asked);
    const Sides sides{a, nearA.part(), b, nearB.part()};
    Scratch& mine = scratch();
    recall(a, b, mine.m_work);
    const double side = m_first == a.getCollisionObject() ? 1.0 : -1.0;
    Collector collector(a, b, asked, side * m_normal, mine);
    if (sides.m_partA.m_tree != nullptr && sides.m_partB.m_tree != nullptr)
    {
        if (m_kept.m_treeA != sides.m_partA.m_tree || m_kept.m_treeB != sides.m_partB.m_tree)
        {
            m_kept = {sides.m_partA.m_tree, sides.m_partB.m_tree, {}};
        }
        collector.add(sides.m_partA, sides.m_partB, m_kept.m_slots);
    }
    m_first = a.getCollisionObject();
    m_normal = collector.normal();
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
