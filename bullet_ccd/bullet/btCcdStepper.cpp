#include "bullet_ccd/bullet/btCcdStepper.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/distance/tree_distance.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <numeric>

using bullet_ccd::AccelerationBound;
using bullet_ccd::BodyPair;
using bullet_ccd::FirstContactResult;
using bullet_ccd::kNone;
using bullet_ccd::LinkMotion;
using bullet_ccd::MotionState;
using bullet_ccd::MovingBody;
using bullet_ccd::RigidMotion;
using bullet_ccd::ToiStatus;

namespace
{
/// A pair that starts within the tolerance may lose a quarter of its distance from step to step,
/// but not come nearer than this part of the tolerance: below, single-precision coordinates no
/// longer tell the sides apart.
constexpr double kSmallestGap = 1.0 / 8.0;

MotionState stateAt(const MovingBody& body, double t)
{
    if (const auto* rigid = std::get_if<RigidMotion>(&body.motion))
    {
        return rigid->at(t);
    }
    const auto& link = std::get<LinkMotion>(body.motion);
    return bullet_ccd::linkStateAt(*link.tree, *link.motion, kNone, link.link, t);
}

AccelerationBound accelerationBound(const MovingBody& body)
{
    if (const auto* rigid = std::get_if<RigidMotion>(&body.motion))
    {
        return rigid->accelerationBound();
    }
    const auto& link = std::get<LinkMotion>(body.motion);
    return bullet_ccd::linkAccelerationBound(*link.tree, *link.motion, kNone, link.link);
}

/// Velocity of the material point at `point_W` [m per step].
Eigen::Vector3d velocityAt(const MotionState& state, const Eigen::Vector3d& point_W)
{
    return state.v_W + state.w_W.cross(point_W - state.X_W.translation());
}

/// Box that contains everything the body passes through in the step.
Eigen::AlignedBox3d sweptBox(const MovingBody& body, bool moves)
{
    const bullet_ccd::SsvNode& root = body.tree->nodes().front();
    const Eigen::Vector3d axis0(root.axis0[0], root.axis0[1], root.axis0[2]);
    const Eigen::Vector3d axis1(root.axis1[0], root.axis1[1], root.axis1[2]);
    const Eigen::Vector3d half(root.half[0], root.half[1], root.half[2]);
    const Eigen::Vector3d center =
        body.tree->origin() + Eigen::Vector3d(root.center[0], root.center[1], root.center[2]);
    const MotionState state = stateAt(body, 0.0);
    const Eigen::Isometry3d X_WG = state.X_W * body.X_BG;
    const Eigen::Vector3d center_W = X_WG * center;
    if (!moves)
    {
        const Eigen::Matrix3d& R = X_WG.linear();
        const Eigen::Vector3d reach =
            ((R * axis0).cwiseAbs() * half.x() + (R * axis1).cwiseAbs() * half.y() +
             (R * axis0.cross(axis1)).cwiseAbs() * half.z())
                .array() +
            double(root.radius);
        return {center_W - reach, center_W + reach};
    }
    // The centre of a bounding sphere: c(t) = c + v t + a(s) t^2 / 2 for some s in [0, 1].
    const Eigen::Vector3d origin_W = X_WG * body.tree->origin();
    const AccelerationBound acceleration = accelerationBound(body);
    const double lever = (origin_W - state.X_W.translation()).norm();
    const double bend = 0.5 * (acceleration.constant + acceleration.perRadius * lever);
    const double reach = body.tree->radius() + bend;
    const Eigen::Vector3d end_W = origin_W + velocityAt(state, origin_W);
    return {(origin_W.cwiseMin(end_W).array() - reach).matrix(),
            (origin_W.cwiseMax(end_W).array() + reach).matrix()};
}

bool isFinite(const bullet_ccd::JointMotion& motion)
{
    const auto finite = [](double value) { return std::isfinite(value); };
    return motion.root.X_W0.matrix().allFinite() && motion.root.v_W.allFinite() &&
           motion.root.w_W.allFinite() &&
           std::all_of(motion.positions.begin(), motion.positions.end(), finite) &&
           std::all_of(motion.rates.begin(), motion.rates.end(), finite);
}

RigidMotion rigidMotion(const btCollisionObject& object, btScalar timeStep)
{
    RigidMotion motion = bullet_ccd::restAt(btCcdToEigen(object.getWorldTransform()));
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (body != nullptr && body->isActive() && !body->isStaticOrKinematicObject())
    {
        motion.v_W = btCcdToEigen(body->getLinearVelocity()) * double(timeStep);
        motion.w_W = btCcdToEigen(body->getAngularVelocity()) * double(timeStep);
    }
    return motion;
}
}  // namespace

btCcdAnswer btCcdStepper::firstImpact(const btCcdQuery& query)
{
    btCcdAnswer answer;
    answer.m_unsupported = collect(query);
    collectSolverPairs(query);
    pairUp(query);

    const bullet_ccd::ToiOptions options{.tolerance = query.m_tolerance, .aim = 0.5};
    FirstContactResult first = bullet_ccd::firstContact(m_moving, m_pairs, options, m_work);
    while (first.status == ToiStatus::Overlapping)
    {
        // Pushing intersecting bodies apart is the work of discrete contacts.
        ++answer.m_overlaps;
        m_pairs.erase(m_pairs.begin() + first.pair);
        first = bullet_ccd::firstContact(m_moving, m_pairs, options, m_work);
    }
    answer.m_status = first.status;
    answer.m_fraction = first.time;
    if (first.status == ToiStatus::Hit)
    {
        const BodyPair& pair = m_pairs[std::size_t(first.pair)];
        if (first.gap < kSmallestGap * query.m_tolerance &&
            gapAt(pair, 0.0, query.m_tolerance) < query.m_tolerance)
        {
            answer.m_fraction = 0.0;
        }
        const double seconds = answer.m_fraction * double(query.m_timeStep);
        answer.m_impacts.push_back(
            makeImpact(pair, seconds, first.pointA, first.pointB, first.normal));
        addSimultaneous(first, query, answer);
    }
    return answer;
}

std::int64_t btCcdStepper::collect(const btCcdQuery& query)
{
    std::int64_t unsupported = 0;
    m_shapes.endRound();
    m_multiBodies.clear();
    m_bodies.clear();
    m_moving.clear();
    for (int i = 0; i < query.m_objects.size(); ++i)
    {
        btCollisionObject& object = *query.m_objects[i];
        if (object.hasContactResponse() && object.getBroadphaseHandle() != nullptr &&
            !collectObject(object, query.m_timeStep))
        {
            ++unsupported;
        }
    }
    for (std::size_t i = 0; i < m_bodies.size(); ++i)
    {
        const Eigen::AlignedBox3d box = sweptBox(m_moving[i], m_bodies[i].m_moves);
        m_bodies[i].m_low = box.min().array() - query.m_tolerance;
        m_bodies[i].m_high = box.max().array() + query.m_tolerance;
    }
    return unsupported;
}

bool btCcdStepper::collectObject(btCollisionObject& object, btScalar timeStep)
{
    const btCcdShapeModel* model = m_shapes.find(object.getCollisionShape());
    if (model == nullptr)
    {
        return false;
    }
    Body body;
    body.m_object = &object;
    MovingBody moving;
    Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
    if (const auto* collider = btMultiBodyLinkCollider::upcast(&object))
    {
        const KnownMultiBody& owner = known(*collider->m_multiBody, timeStep);
        if (!owner.m_covered)
        {
            return false;
        }
        const LinkMotion motion{&owner.m_motion.m_tree,
                                &owner.m_motion.m_motion,
                                owner.m_motion.coreLink(collider->m_link)};
        moving.motion = motion;
        X_BS = owner.m_motion.bulletFrame(*collider->m_multiBody, collider->m_link);
        body.m_multiBodyMotion = &owner.m_motion;
        body.m_link = collider->m_link;
        body.m_moves = bullet_ccd::moves(*motion.tree, *motion.motion, kNone, motion.link);
    }
    else
    {
        const RigidMotion motion = rigidMotion(object, timeStep);
        if (!motion.X_W0.matrix().allFinite() || !motion.v_W.allFinite() || !motion.w_W.allFinite())
        {
            return false;
        }
        body.m_moves = !motion.v_W.isZero(0.0) || !motion.w_W.isZero(0.0);
        moving.motion = motion;
    }
    for (const btCcdShapePart& part : model->m_parts)
    {
        body.m_stock = part.m_margin == 0.0;
        moving.tree = part.m_tree.get();
        moving.X_BG = X_BS * part.X_SG;
        m_bodies.push_back(body);
        m_moving.push_back(moving);
    }
    return true;
}

btCcdStepper::KnownMultiBody& btCcdStepper::known(const btMultiBody& body, btScalar timeStep)
{
    // Colliders of one multibody usually follow each other.
    const auto found = std::find_if(m_multiBodies.rbegin(),
                                    m_multiBodies.rend(),
                                    [&](const auto& entry) { return entry->m_body == &body; });
    if (found != m_multiBodies.rend())
    {
        return **found;
    }
    auto entry = std::make_unique<KnownMultiBody>();
    entry->m_body = &body;
    entry->m_covered = btCcdIsCovered(body);
    if (entry->m_covered)
    {
        btCcdReadMotion(body, timeStep, entry->m_motion);
        entry->m_covered = isFinite(entry->m_motion.m_motion);
    }
    m_multiBodies.push_back(std::move(entry));
    return *m_multiBodies.back();
}

void btCcdStepper::collectSolverPairs(const btCcdQuery& query)
{
    m_solverPairs.clear();
    for (int i = 0; i < query.m_dispatcher.getNumManifolds(); ++i)
    {
        const btPersistentManifold& manifold = *query.m_dispatcher.getManifoldByIndexInternal(i);
        for (int k = 0; k < manifold.getNumContacts(); ++k)
        {
            if (double(manifold.getContactPoint(k).getDistance()) <= query.m_tolerance)
            {
                m_solverPairs.push_back(std::minmax(manifold.getBody0(), manifold.getBody1()));
                break;
            }
        }
    }
    std::sort(m_solverPairs.begin(), m_solverPairs.end());
}

void btCcdStepper::pairUp(const btCcdQuery& query)
{
    m_pairs.clear();
    m_order.resize(m_bodies.size());
    std::iota(m_order.begin(), m_order.end(), 0);
    const auto body = [this](std::int32_t index) -> const Body&
    { return m_bodies[std::size_t(index)]; };
    std::stable_sort(m_order.begin(),
                     m_order.end(),
                     [&](std::int32_t a, std::int32_t b)
                     { return body(a).m_low.x() < body(b).m_low.x(); });
    for (std::size_t i = 0; i < m_order.size(); ++i)
    {
        const Body& a = body(m_order[i]);
        for (std::size_t k = i + 1; k < m_order.size(); ++k)
        {
            const Body& b = body(m_order[k]);
            if (b.m_low.x() > a.m_high.x())
            {
                break;
            }
            if ((a.m_low.array() <= b.m_high.array()).all() &&
                (b.m_low.array() <= a.m_high.array()).all() && wanted(a, b, query))
            {
                m_pairs.push_back(
                    {std::min(m_order[i], m_order[k]), std::max(m_order[i], m_order[k])});
            }
        }
    }
}

bool btCcdStepper::wanted(const Body& a, const Body& b, const btCcdQuery& query) const
{
    if (a.m_object == b.m_object || (!a.m_moves && !b.m_moves))
    {
        return false;
    }
    if (a.m_multiBodyMotion != nullptr && a.m_multiBodyMotion == b.m_multiBodyMotion)
    {
        const bullet_ccd::KinematicTree& tree = a.m_multiBodyMotion->m_tree;
        const bullet_ccd::JointMotion& motion = a.m_multiBodyMotion->m_motion;
        const std::int32_t linkA = a.m_multiBodyMotion->coreLink(a.m_link);
        const std::int32_t linkB = a.m_multiBodyMotion->coreLink(b.m_link);
        const std::int32_t base = bullet_ccd::commonAncestor(tree, linkA, linkB);
        if (!bullet_ccd::moves(tree, motion, base, linkA) &&
            !bullet_ccd::moves(tree, motion, base, linkB))
        {
            return false;
        }
    }
    if (!query.m_pairCache.needsBroadphaseCollision(a.m_object->getBroadphaseHandle(),
                                                    b.m_object->getBroadphaseHandle()) ||
        !query.m_dispatcher.needsCollision(a.m_object, b.m_object) ||
        !query.m_dispatcher.needsResponse(a.m_object, b.m_object))
    {
        return false;
    }
    // Two stock shapes in contact rest on each other at distance 0, where no time of impact is ever
    // positive: they are the solver's until they part.
    const ObjectPair objects = std::minmax<const btCollisionObject*>(a.m_object, b.m_object);
    return !(a.m_stock && b.m_stock &&
             std::binary_search(m_solverPairs.begin(), m_solverPairs.end(), objects));
}

double btCcdStepper::gapAt(const BodyPair& pair, double time, double upperBound) const
{
    const MovingBody& a = m_moving[std::size_t(pair.bodyA)];
    const MovingBody& b = m_moving[std::size_t(pair.bodyB)];
    const Eigen::Isometry3d X_BA =
        bullet_ccd::geometryPoseAt(b, time).inverse() * bullet_ccd::geometryPoseAt(a, time);
    return bullet_ccd::treeDistance(*a.tree, *b.tree, X_BA, upperBound).distance;
}

void btCcdStepper::addSimultaneous(const FirstContactResult& first,
                                   const btCcdQuery& query,
                                   btCcdAnswer& answer) const
{
    // The relative slack makes a tie of symmetric bodies a tie in spite of rounding.
    const double reach = query.m_tolerance * (1.0 + 1e-6);
    const double time = answer.m_fraction;
    for (std::size_t i = 0; i < m_pairs.size(); ++i)
    {
        const BodyPair& pair = m_pairs[i];
        const MovingBody& a = m_moving[std::size_t(pair.bodyA)];
        const MovingBody& b = m_moving[std::size_t(pair.bodyB)];
        const Eigen::Isometry3d X_WB = bullet_ccd::geometryPoseAt(b, time);
        const bullet_ccd::TrianglePair closest = bullet_ccd::treeDistance(
            *a.tree, *b.tree, X_WB.inverse() * bullet_ccd::geometryPoseAt(a, time), reach);
        if (std::int32_t(i) == first.pair || closest.triangleA == kNone ||
            !(closest.distance > 0.0))
        {
            continue;
        }
        const Eigen::Vector3d pointA = X_WB * closest.pointA;
        const Eigen::Vector3d pointB = X_WB * closest.pointB;
        const Eigen::Vector3d normal = (pointB - pointA) / closest.distance;
        const double approach =
            normal.dot(velocityAt(stateAt(a, time), pointA) - velocityAt(stateAt(b, time), pointB));
        // A pair that began the step this close may slide along; its own time will come.
        if (approach > 0.0 && gapAt(pair, 0.0, reach) >= reach)
        {
            answer.m_impacts.push_back(
                makeImpact(pair, time * double(query.m_timeStep), pointA, pointB, normal));
        }
    }
}

btCcdImpact btCcdStepper::makeImpact(const BodyPair& pair,
                                     double seconds,
                                     const Eigen::Vector3d& pointA,
                                     const Eigen::Vector3d& pointB,
                                     const Eigen::Vector3d& normal) const
{
    const Body& a = m_bodies[std::size_t(pair.bodyA)];
    const Body& b = m_bodies[std::size_t(pair.bodyB)];
    return {a.m_object,
            b.m_object,
            a.m_link,
            b.m_link,
            btCcdRoundDown(seconds),
            btCcdToBullet(pointA),
            btCcdToBullet(pointB),
            btCcdToBullet(normal)};
}
