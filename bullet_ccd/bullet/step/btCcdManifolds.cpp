#include "bullet_ccd/bullet/step/btCcdManifolds.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/shapes/btCcdTiles.h"
#include "bullet_ccd/contact/contact_patches.h"
#include "bullet_ccd/contact/way_out.h"
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
using bullet_ccd::SsvTree;
using bullet_ccd::WayOut;

/// Cosine of the angle by which the normal of a patch may turn from one update to the next.
constexpr double kSamePatch = 0.8;
/// A way out is known only for what is at most so much deeper than it was found for.
constexpr double kCameSo = 1.5;
/// Points farther from each other than that many reaches are never the same.
constexpr double kSamePoint = 10.0;
/// Parts of the shell, where any gap will do: contacts may be so old, and of two that are farther
/// apart there need be none.
constexpr double kOld = 1.0 / 32.0;
constexpr double kMatters = 1.5;

/// What all pairs of a thread share, so that nothing is allocated once it is warm.
struct Scratch
{
    struct Entry
    {
        std::weak_ptr<const bullet_ccd::SsvTree> m_tree;
        std::shared_ptr<const ContactSurface> m_surface;
        bool m_hasInside = false;
    };

    std::unordered_map<const bullet_ccd::SsvTree*, Entry> m_surfaces;
    bullet_ccd::PatchWorkspace m_work;
    std::vector<btManifoldPoint> m_old;

    /// Valid while the tree lives.
    const Entry& entryOf(const std::shared_ptr<const bullet_ccd::SsvTree>& tree)
    {
        const auto known = m_surfaces.find(tree.get());
        // Another tree may have lived at this address before.
        if (known != m_surfaces.end() && !known->second.m_tree.expired())
        {
            return known->second;
        }
        std::erase_if(m_surfaces, [](const auto& item) { return item.second.m_tree.expired(); });
        Entry& entry = m_surfaces[tree.get()];
        entry = {tree,
                 std::make_shared<const ContactSurface>(*tree),
                 bullet_ccd::hasInside(tree->mesh())};
        return entry;
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
    /// @param former    the normal of the last contacts of the two, zero if there were none
    /// @param formerWay how far A was moved against it; 0 if they did not intersect
    /// @param isFirst   nothing is known of the two
    Collector(const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b,
              double asked,
              const Eigen::Vector3d& former,
              double formerWay,
              bool isFirst,
              Scratch& scratch)
        : m_a(btCcdToEigen(a.getWorldTransform())),
          m_b(btCcdToEigen(b.getWorldTransform())),
          m_asked(asked),
          m_processed(std::min(double(a.getCollisionObject()->getContactProcessingThreshold()),
                               double(b.getCollisionObject()->getContactProcessingThreshold()))),
          m_former(former),
          m_formerWay(formerWay),
          m_isFirst(isFirst),
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
        const Scratch::Entry& entryA = m_scratch.entryOf(a.m_tree);
        const Scratch::Entry& entryB = m_scratch.entryOf(b.m_tree);
        const double around = reach + shell + a.m_radius + b.m_radius;
        bullet_ccd::appendContacts(*entryA.m_surface,
                                   X_WA,
                                   *entryB.m_surface,
                                   X_WB,
                                   around,
                                   m_scratch.m_work.search,
                                   raw,
                                   &kept);
        const bool isNear = raw.size() > first && deepestOf(first).gap <= WayOut::kNear * shell;
        if (isNear || m_isFirst || m_formerWay > shell)
        {
            const bool isSolidA = a.m_isPlane || (entryA.m_hasInside && a.m_core != nullptr);
            const bool isSolidB = b.m_isPlane || (entryB.m_hasInside && b.m_core != nullptr);
            const auto way = [&](bool hasInsideA, bool hasInsideB)
            {
                WayOut made(
                    {a.m_tree.get(), X_WA, hasInsideA}, {b.m_tree.get(), X_WB, hasInsideB}, shell);
                // Of what has just come, the way out may be another than the normals of what meets.
                const bool isNew = isNear && !(m_formerWay > shell) && !a.m_isPlane && !b.m_isPlane;
                made.prefer(isNew && made.isKnown() ? 2.0 : 1.0);
                return made;
            };
            // What came out, or passes through a hole, is not.
            const auto isInside = [&]
            {
                return !way(a.m_isPlane || entryA.m_hasInside, b.m_isPlane || entryB.m_hasInside)
                            .nearestOut()
                            .isZero();
            };
            WayOut out = way(isSolidA, isSolidB);
            if (isNear)
            {
                if (a.m_isPlane || b.m_isPlane)
                {
                    const Eigen::Vector3d up = (a.m_isPlane ? X_WA : X_WB).linear().col(2);
                    out.look(a.m_isPlane ? up : Eigen::Vector3d(-up));
                }
                out.lookAlong(std::span(raw).subspan(first), m_former, m_formerWay);
                if (m_former.isZero() && entryA.m_hasInside && entryB.m_hasInside &&
                    !(isSolidA && isSolidB))
                {
                    WayOut outOfMesh = way(true, true);
                    outOfMesh.lookAlong(std::span(raw).subspan(first), m_former, m_formerWay);
                    if (outOfMesh.isFound() &&
                        !(out.isFound() && kPreferredForRooms * out.way() < outOfMesh.way()))
                    {
                        out = outOfMesh;
                    }
                }
                if (!(out.isFound() && out.way() <= WayOut::kShort * shell) &&
                    m_formerWay <= WayOut::kShort * shell)
                {
                    WayOut past =
                        way(a.m_isPlane || entryA.m_hasInside, b.m_isPlane || entryB.m_hasInside);
                    past.lookNear(std::span(raw).subspan(first));
                    out = past.isFound() ? past : out;
                }
                m_isWholly = out.isFound() && out.way() > shell && isInside();
                // Of two that do not intersect yet, the contacts tell how they part.
                if (!m_isWholly && out.way() > WayOut::kShort * shell && deepestOf(first).gap > 0.0)
                {
                    out = way(isSolidA, isSolidB);
                }
            }
            else if (m_formerWay > shell)
            {
                m_isWholly = isInside();
                if (m_isWholly)
                {
                    out.comeBack(m_former, m_formerWay);
                }
            }
            else if (const Eigen::Vector3d normal = out.nearestOut(); !normal.isZero())
            {
                m_isWholly = true;
                out.look(normal);
            }
            if (out.isFound())
            {
                m_way = out.way();
                m_wayOut = (out.way() + a.m_radius + b.m_radius) * out.normal();
                raw.resize(first);
                // Of all that is inside, not of what is deepest alone.
                bullet_ccd::appendContacts(*entryA.m_surface,
                                           out.poseOfA(),
                                           *entryB.m_surface,
                                           X_WB,
                                           around + out.way(),
                                           m_scratch.m_work.search,
                                           raw);
                out.takeBack(raw, first, around);
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
        // Something round whose surface alone is inside.
        const double gap = m_way > 0.0 || raw.size() == first ? 0.0 : deepestOf(first).gap;
        if (gap < -shell)
        {
            m_wayOut = -gap * deepestOf(first).normal;
        }
        m_reach = std::max(m_reach, reach);
    }

    /// Of the deepest contact; zero without.
    [[nodiscard]] Eigen::Vector3d normal() const
    {
        return m_scratch.m_work.raw.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                            : deepestOf(0).normal;
    }
    /// @pre there are contacts from the first on
    [[nodiscard]] const Contact& deepestOf(std::size_t first) const
    {
        const std::vector<Contact>& raw = m_scratch.m_work.raw;
        return *std::min_element(raw.begin() + std::ptrdiff_t(first),
                                 raw.end(),
                                 [](const Contact& x, const Contact& y) { return x.gap < y.gap; });
    }

    /// How far the mesh of A has been moved out of that of B; 0 if they do not intersect.
    [[nodiscard]] double way() const { return m_way; }
    /// See btCcdManifolds.
    [[nodiscard]] const Eigen::Vector3d& wayOut() const { return m_wayOut; }
    /// One is inside the other, and their surfaces are apart.
    [[nodiscard]] bool isWholly() const { return m_isWholly; }
    /// The largest depth of a point.
    [[nodiscard]] double reach() const { return m_reach; }

private:
    /// A closed mesh may be solid or a room: what begins in it goes out of the solid, unless the
    /// way into the room is shorter by this factor.
    static constexpr double kPreferredForRooms = 2.0;

    Eigen::Isometry3d m_a;
    Eigen::Isometry3d m_b;
    double m_asked;
    double m_processed;  ///< depths below minus that are of no use to the solver
    Eigen::Vector3d m_former;
    double m_formerWay;
    bool m_isFirst;
    Scratch& m_scratch;
    double m_way = 0.0;
    Eigen::Vector3d m_wayOut = Eigen::Vector3d::Zero();
    bool m_isWholly = false;
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
    Collector collector(a, b, asked, side * m_normal, m_way, m_first == nullptr, mine);
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
    m_way = collector.way();
    m_inside = {collector.wayOut()};
    m_inside.m_isWholly = collector.isWholly();
    m_nearest = {};
    const bool isWhole =
        modelA.m_parts.front().m_tiles == nullptr && modelB.m_parts.front().m_tiles == nullptr;
    if (isWhole && m_inside.m_way.isZero() && !m_inside.m_isWholly && !nearA.part().m_isPlane &&
        !nearB.part().m_isPlane)
    {
        noteNearest(sides, collector.reach(), mine.m_work.raw);
    }
    if (!m_inside.m_way.isZero() && !mine.m_work.raw.empty())
    {
        const Contact& deepest = collector.deepestOf(0);
        m_inside.m_onA = btCcdToEigen(a.getWorldTransform()).inverse() * deepest.pointA;
        m_inside.m_onB = btCcdToEigen(b.getWorldTransform()).inverse() * deepest.pointB;
        m_inside.m_apart = deepest.pointA - deepest.pointB;
    }
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

void btCcdManifolds::noteNearest(const Sides& sides,
                                 double reach,
                                 const std::vector<Contact>& found)
{
    const Eigen::Isometry3d X_WA = btCcdToEigen(sides.m_a.getWorldTransform());
    const Eigen::Isometry3d X_WB = btCcdToEigen(sides.m_b.getWorldTransform());
    const double shell = shellOf(sides.m_partA, sides.m_partB);
    const SsvTree& treeA = *sides.m_partA.m_tree;
    m_nearest.m_X_BA = X_WB.inverse() * X_WA;
    m_nearest.m_R_WB = X_WB.linear();
    m_nearest.m_shell = shell;
    m_nearest.m_centerA = sides.m_partA.X_SG * treeA.origin();
    m_nearest.m_radiusA = treeA.radius();
    m_nearest.m_distance = reach + shell;
    const auto deepest = std::ranges::min_element(found, {}, &Contact::gap);
    if (deepest != found.end())
    {
        // From the shells back to the surfaces.
        const double shift = 0.5 * (sides.m_partA.m_margin - sides.m_partB.m_margin);
        m_nearest.m_hasPoints = true;
        m_nearest.m_distance = deepest->gap + shell;
        m_nearest.m_onA =
            X_WA.inverse() * (deepest->pointA - (0.5 * shell + shift) * deepest->normal);
        m_nearest.m_onB =
            X_WB.inverse() * (deepest->pointB + (0.5 * shell - shift) * deepest->normal);
    }
}

double btCcdManifolds::Nearest::wayOf(const Eigen::Isometry3d& X_BA) const
{
    const double turn = (X_BA.linear() - m_X_BA.linear()).norm();
    return (X_BA * m_centerA - m_X_BA * m_centerA).norm() + turn * m_radiusA;
}

bool btCcdManifolds::haveMaterialsChanged() const
{
    for (int i = 0; i < m_manifolds.size(); ++i)
    {
        const btCollisionObject* a = m_manifolds[i]->getBody0();
        const btCollisionObject* b = m_manifolds[i]->getBody1();
        if (m_manifolds[i]->getNumContacts() == 0)
        {
            continue;
        }
        const btManifoldPoint& point = m_manifolds[i]->getContactPoint(0);
        if (point.m_combinedFriction != gCalculateCombinedFrictionCallback(a, b) ||
            point.m_combinedRestitution != gCalculateCombinedRestitutionCallback(a, b))
        {
            return true;
        }
    }
    return false;
}

bool btCcdManifolds::follow(const btCollisionObjectWrapper& a,
                            const btCcdShapeModel& modelA,
                            const btCollisionObjectWrapper& b,
                            const btCcdShapeModel& modelB)
{
    const bool isFirst = m_first == a.getCollisionObject();
    const auto& treeA = modelA.m_parts.front().m_tree;
    const auto& treeB = modelB.m_parts.front().m_tree;
    if (!(m_nearest.m_distance > 0.0) || m_kept.m_treeA != (isFirst ? treeA : treeB) ||
        m_kept.m_treeB != (isFirst ? treeB : treeA))
    {
        return false;
    }
    const Eigen::Isometry3d X_WFirst = btCcdToEigen((isFirst ? a : b).getWorldTransform());
    const Eigen::Isometry3d X_WSecond = btCcdToEigen((isFirst ? b : a).getWorldTransform());
    const double way = m_nearest.wayOf(X_WSecond.inverse() * X_WFirst);
    const bool isOld = m_nearest.m_hasPoints
                           ? way > kOld * m_nearest.m_shell
                           : m_nearest.m_distance - way < kMatters * m_nearest.m_shell;
    if (isOld || haveMaterialsChanged())
    {
        return false;
    }
    const Eigen::Matrix3d turn = X_WSecond.linear() * m_nearest.m_R_WB.transpose();
    m_nearest.m_R_WB = X_WSecond.linear();
    for (int i = 0; i < m_manifolds.size(); ++i)
    {
        btPersistentManifold& manifold = *m_manifolds[i];
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            btVector3& normal = manifold.getContactPoint(k).m_normalWorldOnB;
            normal = btCcdToBullet(Eigen::Vector3d(turn * btCcdToEigen(normal)));
        }
        manifold.refreshContactPoints(manifold.getBody0()->getWorldTransform(),
                                      manifold.getBody1()->getWorldTransform());
    }
    return true;
}

btCcdKnownOfPair btCcdManifolds::known(const btCollisionObject& a,
                                       const Eigen::Isometry3d& X_WA,
                                       const Eigen::Isometry3d& X_WB) const
{
    btCcdKnownOfPair known{.m_isWholly = m_inside.m_isWholly};
    const bool isFirst = m_first == &a;
    const Eigen::Isometry3d& X_WFirst = isFirst ? X_WA : X_WB;
    const Eigen::Isometry3d& X_WSecond = isFirst ? X_WB : X_WA;
    if (m_nearest.m_hasPoints)
    {
        known.m_most = (X_WFirst * m_nearest.m_onA - X_WSecond * m_nearest.m_onB).norm();
    }
    if (m_nearest.m_distance > 0.0)
    {
        known.m_least = m_nearest.m_distance - m_nearest.wayOf(X_WSecond.inverse() * X_WFirst);
    }
    if (!m_inside.m_way.isZero())
    {
        const Eigen::Vector3d apart = X_WFirst * m_inside.m_onA - X_WSecond * m_inside.m_onB;
        const double way = m_inside.m_way.norm();
        const Eigen::Vector3d normal = m_inside.m_way / way;
        const double left = way + (apart - m_inside.m_apart).dot(normal);
        // What is much deeper now came another way, as a kinematic object that Bullet sees ahead.
        known.m_wayOut = (isFirst ? 1.0 : -1.0) *
                         (left > kCameSo * way ? 0.0 : std::clamp(left, 0.0, way)) * normal;
    }
    return known;
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
