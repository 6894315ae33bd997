#include "bullet_ccd/bullet/soft/btCcdSoftStep.h"

#include "bullet_ccd/bullet/shapes/btCcdDebugDraw.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <utility>

using bullet_ccd::DeformableContact;
using bullet_ccd::DeformableResult;
using bullet_ccd::ElementaryKind;
using bullet_ccd::ToiStatus;
using Eigen::Vector3d;

namespace
{
/// Rounds that bend paths, that shorten them, and that shorten them to nothing; and those in which
/// nothing moves but what is taken along.
constexpr int kBendings = 10;
constexpr int kShortenings = 8;
constexpr int kHolds = 40;
constexpr int kCarries = 40;
/// How often in a step a rigid body comes along with others before it is held back.
constexpr int kComings = 12;
/// Contacts of a rigid body count as one event if it goes on by less than this many times the
/// distance that is kept.
constexpr double kWindow = 0.5;
/// What counts as no deeper, as a part of the distance that is kept; and as no turn.
constexpr double kSlack = 0.1;
constexpr btScalar kNoTurn = btScalar(1e-6);
/// Cosine of the angle between a normal and a feature that counts as right.
constexpr double kMostLean = 1e-3;
/// Sine of the angle between two edges below which their normal says little about the surfaces.
constexpr double kLeastCross = 0.1;
/// Pairs of features in a step; more than that is no simulation any more.
constexpr std::int64_t kMostPairs = 20'000'000;
/// Evaluations for a pair of features; what needs more counts as contact.
constexpr std::int64_t kMostEvaluations = 60;

std::size_t verticesOfA(const DeformableContact& contact)
{
    return contact.kind == ElementaryKind::VertexFace ? 1 : 2;
}

constexpr double kNoWeight = 1e-9;

/// Two edges that are nearest at an end of each: then a node is as near to a face.
bool isOfTwoNodes(const DeformableContact& contact)
{
    const auto isEnd = [&](Eigen::Index k) {
        return std::min(std::abs(contact.weights[k]), std::abs(contact.weights[k + 1])) < kNoWeight;
    };
    return contact.kind == ElementaryKind::EdgeEdge && isEnd(0) && isEnd(2);
}

/// A rigid body whose pose the step may take back.
btRigidBody* yieldingBody(const btCcdSoftPart& part)
{
    btRigidBody* body = part.m_soft == nullptr ? btRigidBody::upcast(part.m_object) : nullptr;
    return body != nullptr && body->getInvMass() > btScalar(0) && !body->isStaticOrKinematicObject()
               ? body
               : nullptr;
}

/// A multibody of which the collider is a link: the step may take back its motion, too.
btMultiBody* yieldingMultiBody(const btCcdSoftPart& part)
{
    btMultiBodyLinkCollider* link =
        part.m_soft == nullptr ? btMultiBodyLinkCollider::upcast(part.m_object) : nullptr;
    return link != nullptr && !link->isStaticOrKinematicObject() ? link->m_multiBody : nullptr;
}

bool yields(const btCcdSoftPart& part)
{
    return yieldingBody(part) != nullptr || yieldingMultiBody(part) != nullptr;
}

/// What moves as one with the part.
const void* bodyOf(const btCcdSoftPart& part)
{
    const btMultiBody* multiBody = yieldingMultiBody(part);
    return multiBody != nullptr ? static_cast<const void*>(multiBody) : part.m_object;
}

/// True if what happened to the one part happens to the other.
bool moveTogether(const btCcdSoftPart& a, const btCcdSoftPart& b)
{
    return bodyOf(a) == bodyOf(b);
}

btTransform between(const btTransform& start, const btTransform& end, double part)
{
    if (part <= 0.0)
    {
        return start;
    }
    return btTransform(start.getRotation().slerp(end.getRotation(), btScalar(part)),
                       start.getOrigin().lerp(end.getOrigin(), btScalar(part)));
}

/// Where something at the pose gets that goes along with what goes from one pose to another.
btTransform carried(const btTransform& pose, const btTransform& from, const btTransform& to)
{
    return to * (from.inverse() * pose);
}

btTransform carried(const btTransform& pose, const btCcdSoftPart& carrier)
{
    return carried(pose, carrier.m_startPose, carrier.m_endPose);
}

/// True if more than rounding is between the two.
bool isTurned(const btTransform& from, const btTransform& to)
{
    btScalar most = 0;
    for (int i = 0; i < 3; ++i)
    {
        most = std::max(most, (from.getBasis()[i] - to.getBasis()[i]).length());
    }
    return most > kNoTurn;
}

/// True if nothing forbids the rigid body to be put from one pose to another.
bool canBePut(const btCcdSoftPart& part, const btTransform& from, const btTransform& to)
{
    const btRigidBody* body = yieldingBody(part);
    if (body == nullptr)
    {
        return false;
    }
    const btVector3 way = to.getOrigin() - from.getOrigin();
    return (way * body->getLinearFactor() - way).length() <= btScalar(1e-3) * way.length() &&
           (!isTurned(from, to) || body->getAngularFactor() == btVector3(1, 1, 1));
}

/// True if nothing forbids the rigid body to go where the carrier takes it.
bool canBeCarried(const btCcdSoftPart& part, const btCcdSoftPart& carrier)
{
    return canBePut(part, part.m_startPose, carried(part.m_startPose, carrier));
}

/// Tells contacts between the same two points apart from others: a node above an inner node of
/// another cloth touches all faces around it, and each edge of one all edges of the other.
class SamePoints
{
public:
    explicit SamePoints(std::size_t contacts) : m_table(std::bit_ceil(2 * contacts + 1), 0) {}

    /// False if a contact of the same vertices with weights was there before. (Another one may be
    /// taken for the same with a probability of 2^-64 a pair; then the next round finds it.)
    bool isNew(const DeformableContact& contact)
    {
        const std::uint64_t key = std::max<std::uint64_t>(keyOf(contact), 1);
        for (std::size_t i = key;; ++i)
        {
            std::uint64_t& entry = m_table[i & (m_table.size() - 1)];
            if (entry == key)
            {
                return false;
            }
            if (entry == 0)
            {
                entry = key;
                return true;
            }
        }
    }

private:
    std::vector<std::uint64_t> m_table;

    static std::uint64_t mixed(std::uint64_t x)
    {
        x = (x ^ (x >> 31U)) * 0x9E3779B97F4A7C15U;
        return x ^ (x >> 29U);
    }
    /// Sums do not depend on the order of vertices, nor of the two sides.
    static std::uint64_t keyOf(const DeformableContact& contact)
    {
        std::array<std::uint64_t, 2> side{};
        for (std::size_t k = 0; k < 4; ++k)
        {
            if (std::abs(contact.weights[Eigen::Index(k)]) > kNoWeight)
            {
                const bool isOfA = k < verticesOfA(contact);
                const auto body = std::uint64_t(isOfA ? contact.bodyA : contact.bodyB);
                side[isOfA ? 0 : 1] += mixed(mixed(body + 1) + std::uint64_t(contact.vertices[k]));
            }
        }
        return mixed(side[0]) + mixed(side[1]);
    }
};

void round(btCcdSoftPart& part)
{
    for (std::size_t i = 0; i < part.m_end.size() && part.m_soft != nullptr; ++i)
    {
        part.m_end[i] = btCcdToEigen(btCcdToBullet(part.m_end[i]));
        if (!bullet_ccd::isPlace(part.m_end[i]))
        {
            part.m_end[i] = part.m_start[i];
        }
    }
    part.m_hasChanged = part.m_hasChanged || part.m_soft != nullptr;
}
}  // namespace

void btCcdSoftStep::begin(btBroadphaseInterface& broadphase, btScalar timeStep)
{
    m_obstacles.begin(broadphase);
    m_response.support([this](const btCollisionObject* object)
                       { return m_obstacles.isThere(*object); },
                       double(timeStep));
}

void btCcdSoftStep::run(const btAlignedObjectArray<btSoftBody*>& bodies, btScalar timeStep)
{
    m_moved.clear();
    m_seenContacts.clear();
    m_bentPaths.clear();
    m_carriers.clear();
    m_held.clear();
    if (!(timeStep > btScalar(0)))
    {
        return;
    }
    const bool isAnySoft = gather(bodies, timeStep);
    const double rest = 2.0 * m_keep;
    btCcdSoftResponse& response = m_response;
    response.begin(rest, double(timeStep));
    if (!isAnySoft)
    {
        response.solveVelocities();
        return;
    }
    giveWay(response.takeShifts());
    const auto given =
        std::exchange(m_held, {});  // rigid bodies are not asked about each other yet
    // As a rule what is left out here has a neighbour with a plain normal. Where it has none (a
    // node against a rim, or all in one plane), the paths have to be checked nevertheless.
    std::atomic<bool> isAnyLeftOut = false;
    const auto isOfNoUse = [&](const DeformableContact& contact)
    {
        if (isAnchored(contact))
        {
            return true;
        }
        const bool isLeftOut = isOfTwoNodes(contact) || !hasPlainNormal(contact);
        if (isLeftOut)
        {
            isAnyLeftOut = true;
        }
        return isLeftOut;
    };
    const DeformableResult& near = contacts(1.125 * rest, 0.125 * rest, false, isOfNoUse);
    m_held = given;
    if (near.status == ToiStatus::IterationLimit && near.contacts.empty())
    {
        ++m_counters.m_unchecked;
        holdAll();
        commit(timeStep);
        return;
    }
    keepForDrawing(near.contacts);
    answerFirst(near.contacts, false, response);
    m_counters.m_contacts += std::int64_t(near.contacts.size());
    if (near.contacts.empty() && !isAnyLeftOut && response.isEmpty())
    {
        return;
    }
    bendPaths(response);
    response.solveVelocities();
    commit(timeStep);
}

bool btCcdSoftStep::gather(const btAlignedObjectArray<btSoftBody*>& bodies, btScalar timeStep)
{
    m_parts.clear();
    double separation = m_separation;
    for (int i = 0; i < bodies.size(); ++i)
    {
        if (btCcdSoftPart* part = m_surfaces.find(*bodies[i], timeStep))
        {
            m_parts.push_back(part);
            separation = std::min(separation, 0.2 * part->m_shortestEdge);
        }
    }
    m_surfaces.endRound();
    m_softParts = m_parts.size();
    if (m_parts.empty())
    {
        return false;
    }
    m_keep = 0.5 * separation;
    m_broadphase = bodies[0]->m_worldInfo->m_broadphase;
    m_dispatcher = bodies[0]->m_worldInfo->m_dispatcher;
    m_box.setEmpty();
    gatherObstacles();
    return true;
}

bool btCcdSoftStep::gatherObstacles()
{
    Eigen::AlignedBox3d box;
    for (const btCcdSoftPart* part : m_parts)
    {
        for (std::size_t v = 0;
             v < part->m_end.size() && (part->m_soft != nullptr || isHeld(*part));
             ++v)
        {
            const Vector3d radius = Vector3d::Constant(part->m_radius);
            for (const Vector3d& x : {part->m_start[v], part->m_end[v]})
            {
                box.extend(Vector3d(x - radius));
                box.extend(Vector3d(x + radius));
            }
        }
    }
    if (m_broadphase == nullptr || m_box.contains(box))
    {
        return false;
    }
    // With some room, because what is met may bend the paths.
    const double room = 4.0 * m_keep + 0.05 * box.diagonal().norm();
    m_box.extend(box.min() - Vector3d::Constant(room));
    m_box.extend(box.max() + Vector3d::Constant(room));
    m_parts.resize(m_softParts);
    const std::vector<btCcdSoftPart*>& obstacles = m_obstacles.collect(*m_broadphase, m_box);
    m_parts.insert(m_parts.end(), obstacles.begin(), obstacles.end());
    m_counters.m_uncovered = m_obstacles.uncovered();
    return true;
}

void btCcdSoftStep::answer(const DeformableContact& contact,
                           bool isForced,
                           btCcdSoftResponse& response)
{
    response.add(contact,
                 *m_parts[std::size_t(contact.bodyA)],
                 *m_parts[std::size_t(contact.bodyB)],
                 isForced);
}

void btCcdSoftStep::answerFirst(const std::vector<DeformableContact>& contacts,
                                bool isForced,
                                btCcdSoftResponse& response)
{
    std::vector<double> last(m_parts.size(), 1.0);  // time of what counts as first, by part
    const auto partsOf = [](const DeformableContact& contact) {
        return std::array{std::size_t(contact.bodyA), std::size_t(contact.bodyB)};
    };
    std::unordered_map<const void*, double> earliest;  // by body; its parts go on as one
    for (const DeformableContact& contact : contacts)
    {
        for (const std::size_t part : partsOf(contact))
        {
            last[part] = std::min(last[part], contact.time);
        }
    }
    for (std::size_t i = 0; i < m_parts.size(); ++i)
    {
        if (yieldingBody(*m_parts[i]) != nullptr)
        {
            double& time = earliest.try_emplace(bodyOf(*m_parts[i]), 1.0).first->second;
            time = std::min(time, last[i]);
        }
    }
    for (std::size_t i = 0; i < m_parts.size(); ++i)
    {
        const btCcdSoftPart& part = *m_parts[i];
        const auto known = earliest.find(bodyOf(part));
        last[i] = 1.0;
        if (known != earliest.end())
        {
            const double way =
                double(part.m_startPose.getOrigin().distance(part.m_endPose.getOrigin()));
            last[i] = known->second + kWindow * m_keep / std::max(way, m_keep);
        }
    }
    SamePoints points(contacts.size());
    for (const DeformableContact& contact : contacts)
    {
        const auto isFirst = [&](std::size_t part) { return contact.time <= last[part]; };
        if (std::ranges::all_of(partsOf(contact), isFirst) && points.isNew(contact))
        {
            answer(contact, isForced, response);
        }
    }
}

bool btCcdSoftStep::isTested(const btCcdSoftPart& a, const btCcdSoftPart& b) const
{
    if (&a == &b)
    {
        return a.m_soft != nullptr && a.m_soft->useSelfCollision();
    }
    if (a.m_soft == nullptr && b.m_soft == nullptr && !isTestedAgain(a, b))
    {
        return false;
    }
    const btBroadphaseProxy* proxyA = a.m_object->getBroadphaseHandle();
    const btBroadphaseProxy* proxyB = b.m_object->getBroadphaseHandle();
    if (proxyA != nullptr && proxyB != nullptr &&
        ((proxyA->m_collisionFilterGroup & proxyB->m_collisionFilterMask) == 0 ||
         (proxyB->m_collisionFilterGroup & proxyA->m_collisionFilterMask) == 0))
    {
        return false;
    }
    const auto excludes = [](const btCcdSoftPart& part, const btCollisionObject* other)
    {
        const int size =
            part.m_soft != nullptr ? part.m_soft->m_collisionDisabledObjects.size() : 0;
        return size > 0 && part.m_soft->m_collisionDisabledObjects.findLinearSearch(other) != size;
    };
    return a.m_object->hasContactResponse() && a.m_object->checkCollideWith(b.m_object) &&
           b.m_object->checkCollideWith(a.m_object) && !excludes(a, b.m_object) &&
           !excludes(b, a.m_object);
}

bool btCcdSoftStep::isHeld(const btCcdSoftPart& part) const
{
    return part.m_soft == nullptr && m_held.contains(bodyOf(part));
}

bool btCcdSoftStep::isTestedAgain(const btCcdSoftPart& a, const btCcdSoftPart& b) const
{
    return (isHeld(a) || isHeld(b)) && !moveTogether(a, b) &&
           m_broadphase->getOverlappingPairCache()->needsBroadphaseCollision(
               a.m_object->getBroadphaseHandle(), b.m_object->getBroadphaseHandle()) &&
           (m_dispatcher == nullptr || m_dispatcher->needsResponse(a.m_object, b.m_object));
}

const DeformableResult& btCcdSoftStep::contacts(
    double separation,
    double tolerance,
    bool isUpdate,
    const std::function<bool(const DeformableContact&)>& isExempt)
{
    ++m_counters.m_queries;
    std::vector<bullet_ccd::DeformableBody> bodies;
    for (btCcdSoftPart* part : m_parts)
    {
        part->refit();
        bodies.push_back({.surface = part->m_surface.get(), .deviation = part->m_radius});
    }
    const auto isPairExempt = [this](std::int32_t a, std::int32_t b)
    { return !isTested(*m_parts[std::size_t(a)], *m_parts[std::size_t(b)]); };
    const bullet_ccd::DeformableOptions options{.tolerance = tolerance,
                                                .minimumSeparation = separation,
                                                .maxIterations = kMostPairs,
                                                .maxIterationsOfPair = kMostEvaluations,
                                                .threads = m_threads,
                                                .isPairExempt = isPairExempt,
                                                .isExempt = isExempt};
    if (!isUpdate)
    {
        m_found.status = ToiStatus::IterationLimit;  // is found anew, in the same memory
        m_found.contacts.clear();
    }
    bullet_ccd::updateContacts(bodies, options, m_work, m_found);
    return m_found;
}

bool btCcdSoftStep::isAnchored(const DeformableContact& contact) const
{
    const btCcdSoftPart& a = *m_parts[std::size_t(contact.bodyA)];
    const btCcdSoftPart& b = *m_parts[std::size_t(contact.bodyB)];
    for (std::size_t k = 0; k < 4; ++k)
    {
        const bool isOfA = k < verticesOfA(contact);
        const btCcdSoftPart& own = isOfA ? a : b;
        const btCcdSoftPart& other = isOfA ? b : a;
        if (own.m_soft != nullptr &&
            own.m_anchor[std::size_t(contact.vertices[k])] == other.m_object)
        {
            return true;
        }
    }
    return false;
}

bool btCcdSoftStep::hasPlainNormal(const DeformableContact& contact) const
{
    const btCcdSoftPart& a = *m_parts[std::size_t(contact.bodyA)];
    const btCcdSoftPart& b = *m_parts[std::size_t(contact.bodyB)];
    if (a.m_radius + b.m_radius > 4.0 * m_keep)
    {
        return true;
    }
    std::array<Vector3d, 4> x;
    for (std::size_t k = 0; k < 4; ++k)
    {
        const btCcdSoftPart& part = k < verticesOfA(contact) ? a : b;
        const auto v = std::size_t(contact.vertices[k]);
        x[k] = part.m_start[v] + contact.time * (part.m_end[v] - part.m_start[v]);
    }
    const auto leans = [&](const Vector3d& along)
    { return std::abs(contact.normal.dot(along)) > kMostLean * along.norm(); };
    if (contact.kind == ElementaryKind::VertexFace)
    {
        return !leans(x[2] - x[1]) && !leans(x[3] - x[1]);
    }
    // What is normal to two edges that are nearly parallel may be any direction about them.
    const Vector3d edgeA = x[1] - x[0];
    const Vector3d edgeB = x[3] - x[2];
    return !leans(edgeA) && !leans(edgeB) &&
           edgeA.cross(edgeB).norm() > kLeastCross * edgeA.norm() * edgeB.norm();
}

bool btCcdSoftStep::isBlocking(const DeformableContact& contact)
{
    const btCcdSoftPart& a = *m_parts[std::size_t(contact.bodyA)];
    const btCcdSoftPart& b = *m_parts[std::size_t(contact.bodyB)];
    if (isAnchored(contact))
    {
        return false;
    }
    if (a.m_soft == nullptr && b.m_soft == nullptr &&
        (contact.status == ToiStatus::Overlapping || !areClosedIn(contact)))
    {
        return false;  // see addPressed()
    }
    if (contact.status != ToiStatus::Overlapping)
    {
        return true;
    }
    // Nearer than they should be from the start: they may lose half of what they have.
    const double gap = contact.gap - a.m_radius - b.m_radius;
    if (!(gap > 1e-3 * m_keep))
    {
        ++m_counters.m_overlaps;
        return false;
    }
    bullet_ccd::ElementaryPair pair{.kind = contact.kind};
    for (std::size_t k = 0; k < 4; ++k)
    {
        const btCcdSoftPart& part = k < verticesOfA(contact) ? a : b;
        pair.start[k] = part.m_start[std::size_t(contact.vertices[k])];
        pair.end[k] = part.m_end[std::size_t(contact.vertices[k])];
    }
    const bullet_ccd::ElementaryResult result =
        bullet_ccd::elementaryToi(pair,
                                  {.tolerance = 0.1 * gap,
                                   .minimumSeparation = a.m_radius + b.m_radius + 0.5 * gap,
                                   .maxIterations = kMostEvaluations});
    return isContact(result.status) || result.status == ToiStatus::IterationLimit;
}

std::vector<DeformableContact> btCcdSoftStep::violations(bool isFirst)
{
    const bool isUpdate = !gatherObstacles() && !isFirst;
    const DeformableResult* result = &contacts(m_keep, 0.25 * m_keep, isUpdate);
    if (result->status == ToiStatus::IterationLimit && result->contacts.empty())
    {
        ++m_counters.m_unchecked;
        holdAll();
        result = &contacts(m_keep, 0.25 * m_keep, false);
    }
    std::vector<DeformableContact> left;
    std::ranges::copy_if(result->contacts,
                         std::back_inserter(left),
                         [this](const DeformableContact& contact) { return isBlocking(contact); });
    addPressed(left);
    return left;
}

bool btCcdSoftStep::areClosedIn(const DeformableContact& contact) const
{
    Vector3d change = Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k)
    {
        const btCcdSoftPart& part =
            *m_parts[std::size_t(k < verticesOfA(contact) ? contact.bodyA : contact.bodyB)];
        const Vector3d& end = part.m_end[std::size_t(contact.vertices[k])];
        const btTransform back = part.m_freePose * part.m_endPose.inverse();
        change +=
            contact.weights[Eigen::Index(k)] * (end - btCcdToEigen(back * btCcdToBullet(end)));
    }
    return !(contact.normal.squaredNorm() > 0.5 && contact.normal.dot(change) > -kSlack * m_keep);
}

void btCcdSoftStep::addPressed(std::vector<DeformableContact>& left)
{
    m_pressed.clear();
    std::unordered_map<const btCollisionObject*, std::size_t> parts;
    for (std::size_t i = m_softParts; i < m_parts.size() && !m_held.empty(); ++i)
    {
        parts.emplace(m_parts[i]->m_object, i);
    }
    const int manifolds =
        m_dispatcher != nullptr && !parts.empty() ? m_dispatcher->getNumManifolds() : 0;
    for (int i = 0; i < manifolds; ++i)
    {
        const btPersistentManifold& manifold = *m_dispatcher->getManifoldByIndexInternal(i);
        const auto knownA = parts.find(manifold.getBody0());
        const auto knownB = parts.find(manifold.getBody1());
        if (knownA == parts.end() || knownB == parts.end())
        {
            continue;
        }
        btCcdSoftPart& a = *m_parts[knownA->second];
        btCcdSoftPart& b = *m_parts[knownB->second];
        double time = 1.0;  // before which no point comes deeper
        for (int k = 0; k < manifold.getNumContacts() && isTested(a, b); ++k)
        {
            const btManifoldPoint& point = manifold.getContactPoint(k);
            const auto gap = [&](btTransform btCcdSoftPart::*pose)
            {
                return double(point.m_normalWorldOnB.dot(a.*pose * point.m_localPointA -
                                                         b.*pose * point.m_localPointB));
            };
            const double after = gap(&btCcdSoftPart::m_endPose) + kSlack * m_keep;
            const double before = gap(&btCcdSoftPart::m_startPose);
            if (after < std::min(before, 0.0))
            {
                time = std::min(time, std::max(before, 0.0) / (std::max(before, 0.0) - after));
            }
            const double free = gap(&btCcdSoftPart::m_freePose);
            const double best = std::min(std::max(before, free), 0.0);
            if (after < best)
            {
                m_pressed.push_back({&a,
                                     &b,
                                     btCcdToEigen(a.m_endPose * point.m_localPointA),
                                     btCcdToEigen(b.m_endPose * point.m_localPointB),
                                     -btCcdToEigen(point.m_normalWorldOnB),
                                     (1.0 - btCcdSoftResponse::kRecovery) * best - free});
            }
        }
        if (time < 1.0)
        {
            left.push_back({.bodyA = std::int32_t(knownA->second),
                            .bodyB = std::int32_t(knownB->second),
                            .time = time});
        }
    }
}

void btCcdSoftStep::bendPaths(btCcdSoftResponse& response)
{
    for (int i = 0; i <= kBendings; ++i)
    {
        response.solvePaths(i == 0);
        giveWay(response.takeShifts());
        std::ranges::for_each(m_parts, [](btCcdSoftPart* part) { round(*part); });
        const std::vector<DeformableContact> left = violations(i == 0);
        if (left.empty() && m_pressed.empty())
        {
            return;
        }
        const auto isSoft = [this](const DeformableContact& contact)
        {
            return m_parts[std::size_t(contact.bodyA)]->m_soft != nullptr ||
                   m_parts[std::size_t(contact.bodyB)]->m_soft != nullptr;
        };
        if (std::ranges::none_of(left, isSoft))
        {
            break;
        }
        ++m_counters.m_rounds;
        answerFirst(left, i == kBendings, response);
    }
    shortenPaths(response);
}

void btCcdSoftStep::giveWay(const std::vector<btCcdSoftResponse::Shift>& shifts)
{
    std::unordered_map<const btCollisionObject*, btTransform> poses;
    for (const btCcdSoftResponse::Shift& shift : shifts)
    {
        const auto part = std::ranges::find(m_parts, shift.m_body, &btCcdSoftPart::m_object);
        if (part == m_parts.end())
        {
            continue;  // far from everything soft
        }
        btTransform pose = (*part)->m_endPose;
        pose.getOrigin() += btCcdToBullet(shift.m_way);
        const double angle = shift.m_turn.norm();
        if (angle > 0.0)
        {
            const btQuaternion turn(btCcdToBullet(Vector3d(shift.m_turn / angle)), btScalar(angle));
            pose.setRotation((turn * pose.getRotation()).normalized());
        }
        poses.emplace(shift.m_body, pose);
        m_held.try_emplace(bodyOf(**part));
    }
    place(poses);
}

void btCcdSoftStep::shortenPaths(btCcdSoftResponse& response)
{
    bool isToNothing = false;
    for (int i = 0; i < kHolds + kCarries; ++i)
    {
        const std::vector<DeformableContact> left = violations(false);
        m_hasComeAlong.clear();
        for (const Pressed& p : m_pressed)
        {
            response.addPressed(*p.m_partA, *p.m_partB, p.m_pointA, p.m_pointB, p.m_normal);
            comeAlong(*p.m_partA, *p.m_partB, std::max(p.m_apart, 0.0) * p.m_normal);
        }
        if (left.empty() && m_hasComeAlong.empty())
        {
            return;
        }
        ++m_counters.m_rounds;
        isToNothing = isToNothing || i >= kShortenings;
        if (i == kHolds)
        {
            holdAll();
        }
        bool hasMoved = !m_hasComeAlong.empty();
        for (const DeformableContact& contact : left)
        {
            answer(contact, true, response);
            btCcdSoftPart& a = *m_parts[std::size_t(contact.bodyA)];
            btCcdSoftPart& b = *m_parts[std::size_t(contact.bodyB)];
            const bool isRigid = a.m_soft == nullptr && b.m_soft == nullptr;
            if (isRigid && comeAlong(a, b))
            {
                hasMoved = true;
                continue;
            }
            hold(contact, isToNothing ? 0.0 : 0.8 * contact.time, hasMoved);
            for (const btCcdSoftPart* part : {&a, &b})
            {
                if (isRigid && yields(*part))  // The earliest contact of the two was the first.
                {
                    m_hasComeAlong.insert(bodyOf(*part));
                    m_held[bodyOf(*part)].m_isSlowed = true;
                }
            }
        }
        std::ranges::for_each(m_parts, [](btCcdSoftPart* part) { round(*part); });
        if (!hasMoved && isToNothing)
        {
            m_counters.m_squeezed += std::int64_t(left.size());
            return;
        }
        isToNothing = isToNothing || !hasMoved;
    }
    holdAll();
    m_counters.m_squeezed += std::int64_t(violations(false).size());
}

void btCcdSoftStep::hold(const DeformableContact& contact, double part, bool& hasMoved)
{
    btCcdSoftPart& a = *m_parts[std::size_t(contact.bodyA)];
    btCcdSoftPart& b = *m_parts[std::size_t(contact.bodyB)];
    const btCcdSoftPart* carrier = carrierOf(contact);
    std::vector<btCcdSoftPart*> obstacles{&a, &b};
    forAnchors(contact, [&](btCcdSoftPart& body) { obstacles.push_back(&body); });
    for (btCcdSoftPart* obstacle : obstacles)
    {
        if (part <= 0.0 && carrier != nullptr && canBeCarried(*obstacle, *carrier))
        {
            m_carriers.try_emplace({obstacle->m_object, bullet_ccd::kNone}, carrier);
        }
        if (yields(*obstacle) && !(obstacle->m_endPose == baseOf(*obstacle)))
        {
            holdBody(*obstacle, part);
            hasMoved = true;
        }
    }
    for (std::size_t k = 0; k < 4; ++k)
    {
        btCcdSoftPart& own = k < verticesOfA(contact) ? a : b;
        const std::int32_t v = contact.vertices[k];
        if (!own.isMovable(v))
        {
            continue;
        }
        if (carrier != nullptr)
        {
            m_carriers.try_emplace({own.m_object, v}, carrier);
        }
        const Vector3d base = baseOf(own, v);
        Vector3d& end = own.m_end[std::size_t(v)];
        const Vector3d shorter = btCcdToEigen(btCcdToBullet(Vector3d(base + part * (end - base))));
        if ((shorter - end).norm() > 1e-9 * m_keep)
        {
            end = shorter;
            hasMoved = true;
            ++m_counters.m_held;
        }
    }
}

void btCcdSoftStep::forAnchors(const DeformableContact& contact,
                               const std::function<void(btCcdSoftPart&)>& visit) const
{
    for (std::size_t k = 0; k < 4; ++k)
    {
        const btCcdSoftPart& own =
            *m_parts[std::size_t(k < verticesOfA(contact) ? contact.bodyA : contact.bodyB)];
        const btCollisionObject* body =
            own.m_soft != nullptr ? own.m_anchor[std::size_t(contact.vertices[k])] : nullptr;
        const auto known = body != nullptr
                               ? std::ranges::find(m_parts, body, &btCcdSoftPart::m_object)
                               : m_parts.end();
        if (known != m_parts.end())
        {
            visit(**known);
        }
    }
}

const btCcdSoftPart* btCcdSoftStep::carrierOf(const btCollisionObject* object,
                                              std::int32_t node) const
{
    const auto known = m_carriers.find({object, node});
    return known != m_carriers.end() ? known->second : nullptr;
}

const btCcdSoftPart* btCcdSoftStep::carrierOf(const DeformableContact& contact) const
{
    const btCcdSoftPart& a = *m_parts[std::size_t(contact.bodyA)];
    const btCcdSoftPart& b = *m_parts[std::size_t(contact.bodyB)];
    std::vector<const btCcdSoftPart*> obstacles{&a, &b};
    forAnchors(contact, [&](const btCcdSoftPart& body) { obstacles.push_back(&body); });
    for (const btCcdSoftPart* obstacle : obstacles)
    {
        if (obstacle->m_soft == nullptr && !yields(*obstacle) &&
            !(obstacle->m_endPose == obstacle->m_startPose))
        {
            return obstacle;
        }
    }
    for (const btCcdSoftPart* obstacle : {&a, &b})
    {
        if (const btCcdSoftPart* known = carrierOf(obstacle->m_object, bullet_ccd::kNone))
        {
            return known;
        }
    }
    for (std::size_t k = 0; k < 4; ++k)
    {
        const btCcdSoftPart& own = k < verticesOfA(contact) ? a : b;
        if (const btCcdSoftPart* known = carrierOf(own.m_object, contact.vertices[k]))
        {
            return known;
        }
    }
    return nullptr;
}

btTransform btCcdSoftStep::baseOf(const btCcdSoftPart& obstacle) const
{
    const btCcdSoftPart* carrier = carrierOf(obstacle.m_object, bullet_ccd::kNone);
    return carrier != nullptr ? carried(obstacle.m_startPose, *carrier) : obstacle.m_startPose;
}

Vector3d btCcdSoftStep::baseOf(const btCcdSoftPart& soft, std::int32_t node) const
{
    const Vector3d& start = soft.m_start[std::size_t(node)];
    const btCcdSoftPart* carrier = carrierOf(soft.m_object, node);
    return carrier != nullptr ? Vector3d(btCcdToEigen(carrier->m_endPose) *
                                         (btCcdToEigen(carrier->m_startPose).inverse() * start))
                              : start;
}

void btCcdSoftStep::holdBody(const btCcdSoftPart& obstacle, double part)
{
    ++m_counters.m_heldBodies;
    Held& held = m_held[bodyOf(obstacle)];
    held.m_rank = 0;
    held.m_isSlowed = true;
    if (btMultiBody* multiBody = yieldingMultiBody(obstacle))
    {
        m_obstacles.takeBack(*multiBody, part);
    }
    std::unordered_map<const btCollisionObject*, btTransform> poses;
    for (btCcdSoftPart* other : m_parts)
    {
        if (other->m_soft != nullptr || !moveTogether(*other, obstacle))
        {
            continue;
        }
        const btTransform pose = part > 0.0 && yieldingMultiBody(*other) != nullptr
                                     ? other->m_object->getWorldTransform()
                                     : between(baseOf(*other), other->m_endPose, part);
        poses.emplace(other->m_object, pose);
    }
    place(poses);
}

bool btCcdSoftStep::comeAlong(const btCcdSoftPart& a, const btCcdSoftPart& b, const Vector3d& apart)
{
    for (const auto& [leader, follower] : {std::pair(&a, &b), std::pair(&b, &a)})
    {
        if (m_hasComeAlong.contains(bodyOf(*follower)))
        {
            return true;
        }
        const auto rankOfLeader = m_held.find(bodyOf(*leader));
        const auto rank = m_held.find(bodyOf(*follower));
        if (rankOfLeader == m_held.end() ||
            (rank != m_held.end() && (rank->second.m_rank <= rankOfLeader->second.m_rank ||
                                      rank->second.m_times == kComings)))
        {
            continue;
        }
        btTransform pose = carried(follower->m_freePose, leader->m_freePose, leader->m_endPose);
        if (!isTurned(leader->m_freePose, leader->m_endPose))
        {
            pose.setBasis(follower->m_freePose.getBasis());
        }
        pose.getOrigin() += btCcdToBullet(Vector3d(follower == &b ? apart : -apart));
        const bool isNew =
            isTurned(pose, follower->m_endPose) ||
            double(pose.getOrigin().distance(follower->m_endPose.getOrigin())) > kSlack * m_keep;
        if (isNew && canBePut(*follower, follower->m_freePose, pose))
        {
            ++m_counters.m_heldBodies;
            Held& held =
                m_held.try_emplace(bodyOf(*follower), Held{rankOfLeader->second.m_rank + 1})
                    .first->second;
            ++held.m_times;
            held.m_isSlowed = true;
            m_hasComeAlong.insert(bodyOf(*follower));
            place({{follower->m_object, pose}});
            return true;
        }
    }
    return false;
}

void btCcdSoftStep::place(const std::unordered_map<const btCollisionObject*, btTransform>& poses)
{
    for (btCcdSoftPart* other : m_parts)
    {
        const auto placed = other->m_soft == nullptr ? poses.find(other->m_object) : poses.end();
        if (placed != poses.end())
        {
            other->setEndPose(placed->second);
        }
        const int anchors =
            other->m_soft != nullptr ? other->m_soft->m_deformableAnchors.size() : 0;
        for (int i = 0; i < anchors; ++i)
        {
            const btSoftBody::DeformableNodeRigidAnchor& anchor =
                other->m_soft->m_deformableAnchors[i];
            const auto held = poses.find(anchor.m_cti.m_colObj);
            if (held != poses.end())
            {
                other->m_end[std::size_t(anchor.m_node - &other->m_soft->m_nodes[0])] =
                    btCcdToEigen(held->second * anchor.m_local);
            }
        }
    }
}

void btCcdSoftStep::holdAll()
{
    for (btCcdSoftPart* part : m_parts)
    {
        if (yields(*part) && !(part->m_endPose == baseOf(*part)))
        {
            holdBody(*part, 0.0);
        }
    }
    for (btCcdSoftPart* part : m_parts)
    {
        for (std::size_t v = 0; v < part->m_end.size() && part->m_soft != nullptr; ++v)
        {
            if (part->m_inverseMass[v] > 0.0)
            {
                part->m_end[v] = baseOf(*part, std::int32_t(v));
                ++m_counters.m_held;
            }
        }
        round(*part);
    }
}

void btCcdSoftStep::commit(btScalar timeStep)
{
    const auto isSlowed = [](const auto& held) { return held.second.m_isSlowed; };
    const std::unordered_set<const btCollisionObject*> supported =
        std::ranges::any_of(m_held, isSlowed) ? m_response.supportedObjects()
                                              : std::unordered_set<const btCollisionObject*>{};
    for (btCcdSoftPart* part : m_parts)
    {
        if (btRigidBody* body = yieldingBody(*part))
        {
            const auto held = m_held.find(bodyOf(*part));
            if (held != m_held.end() && std::exchange(held->second.m_isSlowed, false) &&
                supported.contains(body))
            {
                // The weight on what holds it may be more than a few sweeps can pass on: it must
                // not gather speed. In free flight it keeps what the impulses have left it, so that
                // no momentum is lost.
                btVector3 linear;
                btVector3 angular;
                btTransformUtil::calculateVelocity(
                    part->m_startPose, part->m_endPose, timeStep, linear, angular);
                body->setLinearVelocity((body->getLinearVelocity() + linear) / btScalar(2));
                body->setAngularVelocity((body->getAngularVelocity() + angular) / btScalar(2));
            }
            if (!(part->m_endPose == body->getWorldTransform()))
            {
                body->setCenterOfMassTransform(part->m_endPose);
            }
            continue;
        }
        if (part->m_soft == nullptr)
        {
            continue;
        }
        Moved moved{part, {}};
        for (std::size_t v = 0; v < part->m_end.size(); ++v)
        {
            btSoftBody::Node& node = part->m_soft->m_nodes[int(v)];
            if (!part->isMovable(std::int32_t(v)) ||
                (part->m_end[v] == btCcdToEigen(btCcdNextPlace(*part->m_soft, node, timeStep)) &&
                 part->m_velocity[v] == btCcdToEigen(node.m_v)))
            {
                continue;
            }
            node.m_v = btCcdToBullet(part->m_velocity[v]);
            node.m_splitv = (btCcdToBullet(part->m_end[v]) - node.m_x) / timeStep - node.m_v;
            moved.m_nodes.push_back(v);
            if (m_isDrawn)
            {
                m_bentPaths.emplace_back(node.m_x, btCcdToBullet(part->m_end[v]));
            }
        }
        if (!moved.m_nodes.empty())
        {
            part->m_soft->activate();
            m_moved.push_back(std::move(moved));
        }
    }
}

void btCcdSoftStep::finish()
{
    for (const Moved& moved : m_moved)
    {
        for (const std::size_t v : moved.m_nodes)
        {
            btSoftBody::Node& node = moved.m_part->m_soft->m_nodes[int(v)];
            node.m_x = node.m_q = btCcdToBullet(moved.m_part->m_end[v]);
            node.m_splitv.setZero();
        }
    }
}

void btCcdSoftStep::keepForDrawing(const std::vector<DeformableContact>& contacts)
{
    for (std::size_t i = 0; i < contacts.size() && m_isDrawn; ++i)
    {
        const DeformableContact& contact = contacts[i];
        Vector3d pointA = Vector3d::Zero();
        Vector3d pointB = Vector3d::Zero();
        for (std::size_t k = 0; k < 4; ++k)
        {
            const bool isOfA = k < verticesOfA(contact);
            const btCcdSoftPart& part =
                *m_parts[std::size_t(isOfA ? contact.bodyA : contact.bodyB)];
            const auto v = std::size_t(contact.vertices[k]);
            const Vector3d x = part.m_start[v] + contact.time * (part.m_end[v] - part.m_start[v]);
            (isOfA ? pointA : pointB) += std::abs(contact.weights[Eigen::Index(k)]) * x;
        }
        m_seenContacts.push_back(
            {btCcdToBullet(pointA), btCcdToBullet(pointB), btCcdToBullet(contact.normal)});
    }
}

void btCcdSoftStep::draw(btIDebugDraw& drawer)
{
    m_isDrawn = true;
    for (const SeenContact& seen : m_seenContacts)
    {
        btCcdDrawSoftContact(
            seen.m_pointA, seen.m_pointB, seen.m_normal, btScalar(20.0 * m_keep), drawer);
    }
    for (const auto& [from, to] : m_bentPaths)
    {
        btCcdDrawPath(from, to, drawer);
    }
}
