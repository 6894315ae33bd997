#include "bullet_ccd/bullet/soft/btCcdSoftResponse.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btSoftBody.h>

#include <algorithm>
#include <cmath>
#include <iterator>

using Eigen::Vector3d;

namespace
{
/// Sweeps of Gauss-Seidel, at most. They end when none changes a distance by more than this part of
/// the rest distance, or a velocity by more than this part of the largest change of the first one.
constexpr int kPathSweeps = 12;
constexpr int kPathSweepsOfBodies = 24;  // with rigid bodies
constexpr int kVelocitySweeps = 20;
constexpr double kSmallChange = 1e-3;
/// When more contacts come in, what they would move by less than this part of the rest distance
/// stays as it is.
constexpr double kNoChange = 1e-2;
/// Slower contacts do not bounce [m/s], as in Bullet's solver.
constexpr double kBounceSpeed = 0.2;
/// Of the two sides of a touch in its relative velocity, that of B to A.
constexpr std::array<double, 2> kSigns{-1.0, 1.0};
/// A node between a rigid body and what cannot move takes part with this many times its share of
/// the body's mass, if that is more than its own: along the normal, so that a sweep passes on what
/// the body weighs, and across it, so that friction is passed on, but a cloth can still be pulled
/// out. And the cosine of what is between.
constexpr double kClampedMass = 10.0;
constexpr double kClampedSlip = 0.1;
constexpr double kOpposite = 0.7;
/// Layers that pass it on, at most, and how much heavier (1 / this) each counts than the one above.
constexpr int kLayers = 16;
constexpr double kLayerShare = 0.1;
/// Part of a side that has to give way, at least, so that its touch is answered. Where nearly all
/// is pinned, the little that is left would have to go many times as far.
constexpr double kLeastShare = 0.1;
/// What is asleep wakes up if its velocity changes by more [m/s, rad/s].
constexpr double kWakingSpeed = 0.05;

double frictionOf(const btCcdSoftPart& part)
{
    return part.m_soft != nullptr ? double(part.m_soft->m_cfg.kDF)
                                  : double(part.m_object->getFriction());
}

/// The body, if it is one that moves by forces.
btRigidBody* dynamicBody(btCollisionObject* object)
{
    btRigidBody* body = object != nullptr ? btRigidBody::upcast(object) : nullptr;
    return body != nullptr && body->getInvMass() > btScalar(0) && !body->isStaticOrKinematicObject()
               ? body
               : nullptr;
}

btMultiBody* multiBody(btCollisionObject* object)
{
    btMultiBodyLinkCollider* link =
        object != nullptr ? btMultiBodyLinkCollider::upcast(object) : nullptr;
    return link != nullptr ? link->m_multiBody : nullptr;
}

/// True if momentum ends in the object, or in what holds nodes of it.
bool cannotMove(btCollisionObject& object)
{
    if (const btMultiBody* body = multiBody(&object))
    {
        return body->hasFixedBase();
    }
    const btSoftBody* soft = btSoftBody::upcast(&object);
    bool isPinned = false;
    for (int i = 0; i < (soft != nullptr ? soft->m_nodes.size() : 0); ++i)
    {
        isPinned = isPinned || !(soft->m_nodes[i].m_im > btScalar(0));
    }
    return soft != nullptr ? isPinned : dynamicBody(&object) == nullptr;
}

/// Tells what is soft of a contact, and whose contact it is, apart from others. Which feature of a
/// rigid body it is may change as it slides.
std::uint64_t keyOf(const bullet_ccd::DeformableContact& contact,
                    const btCcdSoftPart& partA,
                    const btCcdSoftPart& partB)
{
    const auto mixed = [](std::uint64_t x)
    {
        x = (x ^ (x >> 31U)) * 0x9E3779B97F4A7C15U;
        return x ^ (x >> 29U);
    };
    const std::size_t ofA = contact.kind == bullet_ccd::ElementaryKind::VertexFace ? 1 : 2;
    std::uint64_t key = 0;
    for (std::size_t k = 0; k < 4; ++k)
    {
        const btCcdSoftPart& part = k < ofA ? partA : partB;
        const auto object = std::uint64_t(btCcdProxyId(*part.m_object)) << 32U;
        key += mixed(object) * std::uint64_t(k == 0 || k == ofA ? 1 : 0);
        if (part.m_soft != nullptr)
        {
            key += mixed(mixed(object + 1) + std::uint64_t(contact.vertices[k]));
        }
    }
    return std::max<std::uint64_t>(mixed(key), 1);
}

Eigen::Matrix3d axesOf(const Vector3d& normal)
{
    Eigen::Matrix3d axes;
    axes.row(0) = normal.transpose();
    axes.row(1) = normal.unitOrthogonal().transpose();
    axes.row(2) = normal.cross(Vector3d(axes.row(1).transpose())).transpose();
    return axes;
}

/// Impulses that friction allows: tangential at most mu times normal.
Vector3d limited(Vector3d impulse, double friction)
{
    impulse[0] = std::max(impulse[0], 0.0);
    const double most = friction * impulse[0];
    const double tangential = impulse.tail<2>().norm();
    if (tangential > most)
    {
        impulse.tail<2>() *= most / tangential;
    }
    return impulse;
}
}  // namespace

struct btCcdSoftResponse::Mover
{
    btRigidBody* m_rigid = nullptr;
    btMultiBody* m_multi = nullptr;
    Eigen::VectorXd m_before;
    Eigen::VectorXd m_velocity;
    Eigen::VectorXd m_shift;  ///< of the end of its path, if it is rigid [m, rad]
    std::int64_t m_bent = 0;  ///< when the end was last moved
    int m_touches = 0;        ///< that know of it

    explicit Mover(btRigidBody& body) : m_rigid(&body), m_before(6)
    {
        m_before << btCcdToEigen(body.getLinearVelocity()), btCcdToEigen(body.getAngularVelocity());
        m_velocity = m_before;
        m_shift = Eigen::VectorXd::Zero(6);
    }
    explicit Mover(btMultiBody& body) : m_multi(&body), m_before(body.getNumDofs() + 6)
    {
        for (Eigen::Index i = 0; i < m_before.size(); ++i)
        {
            m_before[i] = double(body.getVelocityVector()[i]);
        }
        m_velocity = m_before;
    }

    /// Velocity of the point along the axis.
    [[nodiscard]] Row row(const btCollisionObject& object,
                          const Vector3d& point,
                          const Vector3d& axis) const
    {
        return m_rigid != nullptr ? rigidRow(point, axis) : linkRow(object, point, axis);
    }

    void writeBack()
    {
        const double change = (m_velocity - m_before).norm();
        if (change == 0.0)
        {
            return;
        }
        if (m_rigid != nullptr)
        {
            m_rigid->setLinearVelocity(btCcdToBullet(Vector3d(m_velocity.head<3>())));
            m_rigid->setAngularVelocity(btCcdToBullet(Vector3d(m_velocity.tail<3>())));
            if (change > kWakingSpeed)
            {
                m_rigid->activate();
            }
            return;
        }
        std::vector<btScalar> delta;
        for (Eigen::Index i = 0; i < m_velocity.size(); ++i)
        {
            delta.push_back(btScalar(m_velocity[i] - m_before[i]));
        }
        m_multi->applyDeltaVeeMultiDof(delta.data(), btScalar(1));
        if (change > kWakingSpeed)
        {
            m_multi->wakeUp();
        }
    }

private:
    [[nodiscard]] Row rigidRow(const Vector3d& point, const Vector3d& axis) const
    {
        const Vector3d turn =
            (point - btCcdToEigen(m_rigid->getCenterOfMassPosition())).cross(axis);
        const btVector3 turned = m_rigid->getInvInertiaTensorWorld() *
                                 (btCcdToBullet(turn) * m_rigid->getAngularFactor());
        const Vector3d pushed = btCcdToEigen(btCcdToBullet(axis) * m_rigid->getLinearFactor()) *
                                double(m_rigid->getInvMass());
        Row row;
        row.m_jacobian.resize(6);
        row.m_response.resize(6);
        row.m_jacobian << axis, turn;
        row.m_response << pushed, btCcdToEigen(turned * m_rigid->getAngularFactor());
        return row;
    }
    [[nodiscard]] Row linkRow(const btCollisionObject& object,
                              const Vector3d& point,
                              const Vector3d& axis) const
    {
        const int size = int(m_before.size());
        btAlignedObjectArray<btScalar> jacobian;
        btAlignedObjectArray<btScalar> response;
        btAlignedObjectArray<btScalar> scalars;
        btAlignedObjectArray<btVector3> vectors;
        btAlignedObjectArray<btMatrix3x3> matrices;
        jacobian.resize(size);
        response.resize(size);
        scalars.resize(size);
        vectors.resize(size);
        matrices.resize(size);
        m_multi->fillContactJacobianMultiDof(
            static_cast<const btMultiBodyLinkCollider&>(object).m_link,
            btCcdToBullet(point),
            btCcdToBullet(axis),
            &jacobian[0],
            scalars,
            vectors,
            matrices);
        m_multi->calcAccelerationDeltasMultiDof(&jacobian[0], &response[0], scalars, vectors);
        Row row;
        row.m_jacobian.resize(size);
        row.m_response.resize(size);
        for (int i = 0; i < size; ++i)
        {
            row.m_jacobian[i] = double(jacobian[i]);
            row.m_response[i] = double(response[i]);
        }
        return row;
    }
};

btCcdSoftResponse::btCcdSoftResponse() = default;
btCcdSoftResponse::~btCcdSoftResponse() = default;

void btCcdSoftResponse::support(const std::function<bool(const btCollisionObject*)>& isThere,
                                double timeStep)
{
    m_given.clear();
    for (const auto& [proxy, support] : m_bodySupports)
    {
        btRigidBody* body = support.m_body;
        const auto before = m_bodySupportsBefore.find(proxy);
        if (before == m_bodySupportsBefore.end() || before->second.m_body != body ||
            !isThere(body) || btCcdProxyId(*body) != proxy || !body->isActive())
        {
            continue;
        }
        const double part = timeStep / m_timeStep;
        const Vector6d& last = support.m_change;
        const Vector6d& lastButOne = before->second.m_change;
        const Vector6d given = part * (lastButOne.norm() < last.norm() ? lastButOne : last);
        body->setLinearVelocity(body->getLinearVelocity() +
                                btCcdToBullet(Vector3d(given.head<3>())));
        body->setAngularVelocity(body->getAngularVelocity() +
                                 btCcdToBullet(Vector3d(given.tail<3>())));
        m_given.push_back({body, given});
    }
}

void btCcdSoftResponse::begin(double rest, double timeStep)
{
    m_rest = rest;
    m_part = m_timeStep > 0.0 ? timeStep / m_timeStep : 1.0;
    m_timeStep = timeStep;
    m_touches.clear();
    m_paths.clear();
    m_rows.clear();
    m_movers.clear();
    m_moverOf.clear();
    m_clock = 0;
    m_clamps.clear();
    m_solvedPaths = 0;
    m_before.swap(m_supports);
    m_supports.clear();
    m_bodySupportsBefore.swap(m_bodySupports);
    m_bodySupports.clear();
    for (const auto& [body, given] : m_given)
    {
        Mover& mover = moverOf(*body);
        mover.m_velocity -= given;
        mover.m_shift = -timeStep * given;
    }
    m_given.clear();
}

void btCcdSoftResponse::add(const bullet_ccd::DeformableContact& contact,
                            btCcdSoftPart& partA,
                            btCcdSoftPart& partB,
                            bool isForced)
{
    const std::size_t ofA = contact.kind == bullet_ccd::ElementaryKind::VertexFace ? 1 : 2;
    if (partA.m_soft == nullptr && partB.m_soft == nullptr)
    {
        if (!(contact.normal.squaredNorm() > 0.5))
        {
            return;  // of which nothing is known but the time
        }
        std::array<Vector3d, 2> points{Vector3d::Zero(), Vector3d::Zero()};
        for (std::size_t k = 0; k < 4; ++k)
        {
            const btCcdSoftPart& part = k < ofA ? partA : partB;
            points[k < ofA ? 0 : 1] += std::abs(contact.weights[Eigen::Index(k)]) *
                                       part.m_end[std::size_t(contact.vertices[k])];
        }
        addPressed(partA, partB, points[0], points[1], contact.normal);
        return;
    }
    Touch touch;
    Path path;
    touch.m_isForced = isForced;
    Vector3d motion = Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k)
    {
        btCcdSoftPart& part = k < ofA ? partA : partB;
        const auto vertex = std::size_t(contact.vertices[k]);
        touch.m_part[k] = &part;
        touch.m_vertex[k] = vertex;
        const double w = contact.weights[Eigen::Index(k)];
        path.m_weight[k] = w;
        path.m_end[k] = &part.m_end[vertex];
        path.m_start += w * part.m_start[vertex];
        motion += w * (part.m_end[vertex] - part.m_start[vertex]);
        if (part.m_soft != nullptr)
        {
            path.m_bent[k] = &part.m_bent[vertex];
            path.m_give[k] = w * part.m_inverseMass[vertex];
        }
        else
        {
            Side& side = touch.m_sides[k < ofA ? 0 : 1];
            const double share = k < ofA ? -w : w;
            side.m_obstacle = &part;
            side.m_point += share * part.m_end[vertex];
            side.m_pathVelocity += share * (part.m_end[vertex] - part.m_start[vertex]) / m_timeStep;
        }
    }
    Vector3d normal = contact.normal;
    if (!(normal.squaredNorm() > 0.5))
    {
        // They touch exactly: against the way they come.
        normal = -motion.stableNormalized();
    }
    if (!(normal.squaredNorm() > 0.5))
    {
        return;
    }
    path.m_axes = axesOf(normal);
    path.m_response = path.ofNodes();
    const std::array<const btCcdSoftPart*, 2> parts{&partA, &partB};
    bool isLinked = false;
    double mostShare = 0.0;
    for (std::size_t i = 0; i < 2; ++i)
    {
        double share = takeAnchored(i, ofA, touch, path);
        const Side& side = touch.m_sides[i];
        btCollisionObject* object = side.m_anchor != nullptr ? side.m_anchor : parts[i]->m_object;
        btRigidBody* body = dynamicBody(object);
        if (body != nullptr && body->isActive())
        {
            addLever(i, moverOf(*body), *body, touch, path);
            touch.m_key = keyOf(contact, partA, partB);
            share += side.m_share;
        }
        mostShare = std::max(mostShare, share);
        isLinked = isLinked || multiBody(object) != nullptr;
    }
    if (mostShare < kLeastShare)
    {
        path.m_give = {};
        path.m_response.setZero();
    }
    if (!(path.m_response[0] > 0.0) && !isLinked)
    {
        return;
    }
    const double rest = m_rest + partA.m_radius + partB.m_radius;
    const double gap = normal.dot(path.m_start);
    path.m_goal = gap < rest ? gap + btCcdSoftResponse::kRecovery * (rest - gap) : rest;
    path.m_friction = frictionOf(partA) * frictionOf(partB);
    touch.m_restitution =
        double(partA.m_object->getRestitution()) * double(partB.m_object->getRestitution());
    const auto known = touch.m_key != 0 ? m_before.find(touch.m_key) : m_before.end();
    if (known != m_before.end())
    {
        path.m_push =
            limited(m_part * m_part * (path.m_axes * known->second.m_push_W), path.m_friction);
        touch.m_impulse =
            limited(m_part * (path.m_axes * known->second.m_impulse_W), path.m_friction);
        m_before.erase(known);
    }
    m_touches.push_back(std::move(touch));
    m_paths.push_back(path);
}

double btCcdSoftResponse::takeAnchored(std::size_t side,
                                       std::size_t ofA,
                                       Touch& touch,
                                       const Path& path)
{
    Side& own = touch.m_sides[side];
    double free = 0.0;
    for (std::size_t k = side == 0 ? 0 : ofA; k < (side == 0 ? ofA : 4); ++k)
    {
        const btCcdSoftPart& part = *touch.m_part[k];
        if (part.m_soft == nullptr)
        {
            return 0.0;
        }
        const double w = std::abs(path.m_weight[k]);
        btCollisionObject* anchor = part.m_anchor[touch.m_vertex[k]];
        free += path.m_give[k] != 0.0 ? w : 0.0;
        if ((dynamicBody(anchor) == nullptr && multiBody(anchor) == nullptr) || w == 0.0 ||
            (own.m_anchor != nullptr && own.m_anchor != anchor))
        {
            continue;
        }
        own.m_share = own.m_anchor == nullptr ? w : own.m_share + w;
        own.m_anchor = anchor;
        own.m_point += w * *path.m_end[k];
        touch.m_part[k] = nullptr;  // the body has its velocity
    }
    own.m_point /= own.m_share;
    return free;
}

void btCcdSoftResponse::addPressed(btCcdSoftPart& partA,
                                   btCcdSoftPart& partB,
                                   const Vector3d& pointA,
                                   const Vector3d& pointB,
                                   const Vector3d& normal)
{
    Touch touch;
    touch.m_isForced = true;
    const auto sideOf = [this](btCcdSoftPart& part, const Vector3d& point)
    {
        const btTransform back = part.m_startPose * part.m_endPose.inverse();
        return Side{.m_obstacle = &part,
                    .m_point = point,
                    .m_pathVelocity = (point - btCcdToEigen(back) * point) / m_timeStep};
    };
    touch.m_sides = {sideOf(partA, pointA), sideOf(partB, pointB)};
    Path path;
    path.m_axes = axesOf(normal);
    m_touches.push_back(std::move(touch));
    m_paths.push_back(path);
}

void btCcdSoftResponse::applyPush(Path& path, const Vector3d& push)
{
    const Vector3d push_W = path.m_axes.transpose() * push;
    path.m_solved = ++m_clock;
    for (std::size_t k = 0; k < 4; ++k)
    {
        if (path.m_give[k] != 0.0)
        {
            *path.m_end[k] += path.given(k, push_W);
            *path.m_bent[k] = m_clock;
        }
    }
    for (std::size_t i = 0; i < 2; ++i)
    {
        const Lever& lever = path.m_levers[i];
        for (std::size_t k = 0; k < 3 && path.m_bent[4 + i] != nullptr; ++k)
        {
            lever.m_mover->m_shift +=
                kSigns[i] * push[Eigen::Index(k)] * m_rows[lever.m_rows][k].m_response;
            lever.m_mover->m_bent = m_clock;
        }
    }
}

double btCcdSoftResponse::solvePath(Path& path, double least)
{
    if (!(path.m_response[0] > 0.0))
    {
        return 0.0;  // nothing that gives way
    }
    const auto isSettled = [&path](const std::int64_t* bent)
    { return bent == nullptr || *bent <= path.m_solved; };
    if (std::ranges::all_of(path.m_bent, isSettled))
    {
        return 0.0;
    }
    path.m_solved = m_clock;
    const Vector3d end = path.m_weight[0] * *path.m_end[0] + path.m_weight[1] * *path.m_end[1] +
                         path.m_weight[2] * *path.m_end[2] + path.m_weight[3] * *path.m_end[3];
    Vector3d shifted = Vector3d::Zero();
    for (std::size_t i = 0; i < 2; ++i)
    {
        const Lever& lever = path.m_levers[i];
        for (std::size_t k = 0; k < 3 && path.m_bent[4 + i] != nullptr; ++k)
        {
            shifted[Eigen::Index(k)] +=
                kSigns[i] * m_rows[lever.m_rows][k].m_jacobian.dot(lever.m_mover->m_shift);
        }
    }
    const double beyond = path.m_axes.row(0).dot(end) + shifted[0] - path.m_goal;
    if (beyond >= 0.0 && path.m_push[0] == 0.0)
    {
        return 0.0;  // far enough, and nothing to take back
    }
    Vector3d excess = path.m_axes * (end - path.m_start) + shifted;
    excess[0] = beyond;
    for (Eigen::Index k = 1; k < 3; ++k)
    {
        excess[k] = path.m_response[k] > 0.0 ? excess[k] / path.m_response[k] : 0.0;
    }
    excess[0] /= path.m_response[0];
    const Vector3d wanted = limited(path.m_push - excess, path.m_friction);
    const Vector3d change = wanted - path.m_push;
    if (!(std::abs(change[0]) * path.m_response[0] > least) && (least > 0.0 || change.isZero(0.0)))
    {
        return 0.0;
    }
    applyPush(path, change);
    path.m_push = wanted;
    return change.cwiseProduct(path.m_response).norm();
}

Vector3d btCcdSoftResponse::Path::ofNodes() const
{
    Vector3d response = Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k)
    {
        const double full = m_weight[k] * m_give[k];
        if (m_clamp[k] == nullptr)
        {
            response.array() += full;
        }
        else if (full > 0.0)
        {
            const Eigen::Matrix3d left = m_axes * *m_clamp[k] * m_axes.transpose();
            response += full * left.cwiseAbs().rowwise().sum();
        }
    }
    return response;
}

void btCcdSoftResponse::findClamped()
{
    if (m_movers.empty() || m_solvedPaths == m_paths.size())
    {
        return;
    }
    const auto isFixed = [](const btCcdSoftPart* part)
    { return part != nullptr && part->m_soft == nullptr && multiBody(part->m_object) == nullptr; };
    const auto wayOf = [](const Path& path, std::size_t k)
    { return Vector3d((path.m_weight[k] > 0.0 ? 1.0 : -1.0) * path.m_axes.row(0).transpose()); };
    const auto isOfBody = [](const Path& path)
    { return path.m_bent[4] != nullptr || path.m_bent[5] != nullptr; };
    for (std::size_t i = m_solvedPaths; i < m_paths.size(); ++i)
    {
        const Path& path = m_paths[i];
        const std::array<Side, 2>& sides = m_touches[i].m_sides;
        for (std::size_t k = 0;
             k < 4 && !isOfBody(path) && std::ranges::any_of(m_touches[i].m_part, isFixed);
             ++k)
        {
            if (path.m_give[k] != 0.0)
            {
                m_clamps.try_emplace(
                    path.m_bent[k],
                    Clamp{.m_out = wayOf(path, k),
                          .m_velocity = sides[0].m_pathVelocity + sides[1].m_pathVelocity});
            }
        }
    }
    if (m_clamps.empty())
    {
        return;
    }
    spread(&btCcdSoftResponse::carry);
    const auto forNodes = [this](const auto& visit)
    {
        for (std::size_t i = 0; i < m_paths.size(); ++i)
        {
            for (std::size_t k = 0; k < 4; ++k)
            {
                const Path& path = m_paths[i];
                const auto known =
                    path.m_give[k] != 0.0 ? m_clamps.find(path.m_bent[k]) : m_clamps.end();
                if (known != m_clamps.end())
                {
                    visit(i, k, known->second);
                }
            }
        }
    };
    forNodes(
        [&](std::size_t i, std::size_t k, Clamp& known)
        {
            const Path& path = m_paths[i];
            double response = 0.0;
            for (std::size_t side = 0; side < 2; ++side)
            {
                response += path.m_bent[4 + side] != nullptr
                                ? path.m_ofLevers[0] * path.m_levers[side].m_mover->m_touches
                                : 0.0;
            }
            if (response > 0.0 && known.m_out.dot(wayOf(path, k)) < -kOpposite)
            {
                known.m_share = known.m_share > 0.0 ? std::min(known.m_share, response) : response;
            }
        });
    spread(&btCcdSoftResponse::press);
    forNodes(
        [&](std::size_t i, std::size_t k, Clamp& known)
        {
            if (known.m_share > 0.0)
            {
                clamp(i, k, known);
            }
        });
}

void btCcdSoftResponse::spread(bool (btCcdSoftResponse::*pass)(const Path&, double))
{
    bool hasSpread = true;
    for (int layer = 0; layer < kLayers && hasSpread; ++layer)
    {
        hasSpread = false;
        for (std::size_t i = 0; i < m_paths.size(); ++i)
        {
            const auto isRigid = [](const btCcdSoftPart* part)
            { return part != nullptr && part->m_soft == nullptr; };
            if (std::ranges::none_of(m_touches[i].m_part, isRigid))
            {
                hasSpread = (this->*pass)(m_paths[i], -1.0) || hasSpread;
                hasSpread = (this->*pass)(m_paths[i], 1.0) || hasSpread;
            }
        }
    }
}

bool btCcdSoftResponse::carry(const Path& path, double side)
{
    const Vector3d out = -side * path.m_axes.row(0).transpose();
    Vector3d velocity = Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k)
    {
        if (side * path.m_weight[k] > 0.0 && path.m_give[k] != 0.0)
        {
            const auto known = m_clamps.find(path.m_bent[k]);
            if (known == m_clamps.end() || known->second.m_out.dot(out) < kOpposite)
            {
                return false;
            }
            velocity = known->second.m_velocity;
        }
    }
    bool isNew = false;
    for (std::size_t k = 0; k < 4; ++k)
    {
        if (side * path.m_weight[k] < 0.0 && path.m_give[k] != 0.0)
        {
            const Clamp clamp{.m_out = out, .m_velocity = velocity};
            isNew = m_clamps.try_emplace(path.m_bent[k], clamp).second || isNew;
        }
    }
    return isNew;
}

bool btCcdSoftResponse::press(const Path& path, double side)
{
    const Vector3d down = -side * path.m_axes.row(0).transpose();
    double share = 0.0;
    for (std::size_t k = 0; k < 4; ++k)
    {
        const auto known =
            side * path.m_weight[k] > 0.0 ? m_clamps.find(path.m_bent[k]) : m_clamps.end();
        if (known != m_clamps.end() && known->second.m_out.dot(down) < -kOpposite)
        {
            share = std::max(share, known->second.m_share);
        }
    }
    bool isNew = false;
    for (std::size_t k = 0; k < 4 && share > 0.0; ++k)
    {
        const auto known =
            side * path.m_weight[k] < 0.0 ? m_clamps.find(path.m_bent[k]) : m_clamps.end();
        if (known != m_clamps.end() && known->second.m_share == 0.0)
        {
            known->second.m_share = kLayerShare * share;
            isNew = true;
        }
    }
    return isNew;
}

void btCcdSoftResponse::clamp(std::size_t touch, std::size_t k, Clamp& clamp)
{
    Path& path = m_paths[touch];
    if (!clamp.m_isClamped)
    {
        clamp.m_isClamped = true;
        const double share = clamp.m_share * path.m_weight[k] / path.m_give[k];
        const double along = std::min(1.0, share / kClampedMass);
        const double across = std::min(1.0, share / kClampedSlip);
        clamp.m_mobility = across * Eigen::Matrix3d::Identity() +
                           (along - across) * clamp.m_out * clamp.m_out.transpose();
        // With more mass it has less speed: its momentum is what it was.
        const auto slowed = [&](const Vector3d& velocity)
        { return Vector3d(clamp.m_velocity + clamp.m_mobility * (velocity - clamp.m_velocity)); };
        btCcdSoftPart& part = *m_touches[touch].m_part[k];
        const std::size_t v = m_touches[touch].m_vertex[k];
        part.m_velocity[v] = slowed(part.m_velocity[v]);
        part.m_end[v] =
            part.m_start[v] + m_timeStep * slowed((part.m_end[v] - part.m_start[v]) / m_timeStep);
        part.m_bent[v] = ++m_clock;
    }
    path.m_clamp[k] = &clamp.m_mobility;
    path.m_response = path.ofNodes() + path.m_ofLevers;
}

void btCcdSoftResponse::keepFromBefore(Touch& touch, Path& path)
{
    if (path.m_push.isZero(0.0) && touch.m_impulse.isZero(0.0))
    {
        return;
    }
    // What a body weighs would throw about light nodes that are not clamped any more.
    int touches = 1;
    for (const Lever& lever : path.m_levers)
    {
        touches = lever.m_mover != nullptr ? std::max(touches, lever.m_mover->m_touches) : touches;
    }
    const Vector3d ofNodes = path.ofNodes();
    for (Eigen::Index axis = 0; axis < 3; ++axis)
    {
        const double most = (axis == 0 ? 1.0 : 2.0 / kClampedSlip) * touches;
        if (!(ofNodes[axis] < most * path.m_ofLevers[axis]))
        {
            path.m_push[axis] = 0.0;
            touch.m_impulse[axis] = 0.0;
        }
    }
    path.m_push = limited(path.m_push, path.m_friction);
    touch.m_impulse = limited(touch.m_impulse, path.m_friction);
    applyPush(path, path.m_push);
}

void btCcdSoftResponse::solvePaths(bool isFirst)
{
    const double least = isFirst ? 0.0 : kNoChange * m_rest;
    findClamped();
    for (; m_solvedPaths < m_paths.size(); ++m_solvedPaths)
    {
        keepFromBefore(m_touches[m_solvedPaths], m_paths[m_solvedPaths]);
    }
    const int sweeps = m_movers.empty() ? kPathSweeps : kPathSweepsOfBodies;
    for (int sweep = 0; sweep < sweeps; ++sweep)
    {
        double largest = 0.0;
        for (Path& path : m_paths)
        {
            largest = std::max(largest, solvePath(path, least));
        }
        if (largest < kSmallChange * m_rest)
        {
            return;
        }
    }
}

std::vector<btCcdSoftResponse::Shift> btCcdSoftResponse::takeShifts()
{
    std::vector<Shift> shifts;
    for (const std::unique_ptr<Mover>& mover : m_movers)
    {
        if (mover->m_rigid != nullptr && !mover->m_shift.isZero(0.0))
        {
            shifts.push_back({mover->m_rigid, mover->m_shift.head<3>(), mover->m_shift.tail<3>()});
            mover->m_shift.setZero();
        }
    }
    return shifts;
}

template <typename Body>
btCcdSoftResponse::Mover& btCcdSoftResponse::moverOf(Body& body)
{
    Mover*& mover = m_moverOf[&body];
    if (mover == nullptr)
    {
        mover = m_movers.emplace_back(std::make_unique<Mover>(body)).get();
    }
    return *mover;
}

void btCcdSoftResponse::addLever(
    std::size_t side, Mover& mover, const btCollisionObject& object, const Touch& touch, Path& path)
{
    path.m_levers[side] = {.m_mover = &mover, .m_rows = m_rows.size()};
    ++mover.m_touches;
    std::array<Row, 3>& rows = m_rows.emplace_back();
    for (Eigen::Index k = 0; k < 3; ++k)
    {
        Row& row = rows[std::size_t(k)];
        row = mover.row(object, touch.m_sides[side].m_point, path.m_axes.row(k).transpose());
        row.m_jacobian *= touch.m_sides[side].m_share;
        row.m_response *= touch.m_sides[side].m_share;
    }
    // Axes are answered at once, though turning couples them: with sums of magnitudes it converges.
    for (std::size_t k = 0; k < 3; ++k)
    {
        for (const Row& other : rows)
        {
            path.m_ofLevers[Eigen::Index(k)] += std::abs(rows[k].m_jacobian.dot(other.m_response));
        }
    }
    path.m_response = path.ofNodes() + path.m_ofLevers;
    if (mover.m_rigid != nullptr)
    {
        path.m_bent[4 + side] = &mover.m_bent;
    }
}

Vector3d btCcdSoftResponse::relativeVelocity(const Touch& touch, const Path& path) const
{
    Vector3d v = Vector3d::Zero();
    for (std::size_t k = 0; k < 4; ++k)
    {
        const btCcdSoftPart* part = touch.m_part[k];
        if (part != nullptr && part->m_soft != nullptr)
        {
            v += path.m_weight[k] * part->m_velocity[touch.m_vertex[k]];
        }
    }
    v = path.m_axes * v;
    for (std::size_t i = 0; i < 2; ++i)
    {
        const Lever& lever = path.m_levers[i];
        if (lever.m_mover == nullptr)
        {
            v += kSigns[i] * (path.m_axes * touch.m_sides[i].m_pathVelocity);
            continue;
        }
        for (std::size_t k = 0; k < 3; ++k)
        {
            v[Eigen::Index(k)] +=
                kSigns[i] * m_rows[lever.m_rows][k].m_jacobian.dot(lever.m_mover->m_velocity);
        }
    }
    return v;
}

void btCcdSoftResponse::applyImpulse(Touch& touch, const Path& path, const Vector3d& impulse)
{
    const Vector3d J_W = path.m_axes.transpose() * impulse;
    for (std::size_t k = 0; k < 4; ++k)
    {
        btCcdSoftPart* part = touch.m_part[k];
        if (part != nullptr && part->m_soft != nullptr)
        {
            part->m_velocity[touch.m_vertex[k]] += path.given(k, J_W);
        }
    }
    for (std::size_t i = 0; i < 2; ++i)
    {
        const Lever& lever = path.m_levers[i];
        for (std::size_t k = 0; k < 3 && lever.m_mover != nullptr; ++k)
        {
            lever.m_mover->m_velocity +=
                kSigns[i] * impulse[Eigen::Index(k)] * m_rows[lever.m_rows][k].m_response;
        }
    }
}

double btCcdSoftResponse::solveVelocity(Touch& touch, const Path& path)
{
    Vector3d response = path.m_response;
    Vector3d excess = relativeVelocity(touch, path);
    excess[0] -= touch.m_goalSpeed;
    for (int k = 0; k < 3; ++k)
    {
        if (!(response[k] > 0.0))  // nothing gives way
        {
            excess[k] = 0.0;
            response[k] = 1.0;
        }
    }
    const Vector3d wanted =
        limited(touch.m_impulse - excess.cwiseQuotient(response), path.m_friction);
    const Vector3d change = wanted - touch.m_impulse;
    if (change.isZero(0.0))
    {
        return 0.0;
    }
    applyImpulse(touch, path, change);
    touch.m_impulse = wanted;
    return change.cwiseProduct(response).norm();
}

void btCcdSoftResponse::solveVelocities()
{
    // What came in when paths were shortened: a node has one mass in all touches.
    for (std::size_t i = m_solvedPaths; i < m_paths.size(); ++i)
    {
        for (std::size_t k = 0; k < 4; ++k)
        {
            const auto known = m_clamps.find(m_paths[i].m_bent[k]);
            if (known != m_clamps.end() && known->second.m_isClamped)
            {
                clamp(i, k, known->second);
            }
        }
    }
    std::vector<std::size_t> pushing;
    for (std::size_t i = 0; i < m_touches.size(); ++i)
    {
        Touch& touch = m_touches[i];
        Path& path = m_paths[i];
        if (!(path.m_push[0] > 0.0 || touch.m_isForced))
        {
            touch.m_impulse.setZero();
            continue;
        }
        pushing.push_back(i);
        for (std::size_t side = 0; side < 2; ++side)
        {
            const Side& own = touch.m_sides[side];
            btCollisionObject* object =
                own.m_obstacle != nullptr ? own.m_obstacle->m_object : own.m_anchor;
            if (path.m_levers[side].m_mover != nullptr)
            {
                continue;
            }
            if (btMultiBody* body = multiBody(object))
            {
                addLever(side, moverOf(*body), *object, touch, path);
            }
            else if (btRigidBody* rigid = dynamicBody(object))
            {
                addLever(side, moverOf(*rigid), *object, touch, path);
            }
        }
        const double speed = -relativeVelocity(touch, path)[0];
        touch.m_goalSpeed = speed > kBounceSpeed ? touch.m_restitution * speed : 0.0;
    }
    for (const std::size_t i : pushing)
    {
        applyImpulse(m_touches[i], m_paths[i], m_touches[i].m_impulse);
    }
    double first = 0.0;
    for (int sweep = 0; sweep < kVelocitySweeps; ++sweep)
    {
        double largest = 0.0;
        for (const std::size_t i : pushing)
        {
            largest = std::max(largest, solveVelocity(m_touches[i], m_paths[i]));
        }
        first = std::max(first, largest);
        if (largest <= kSmallChange * first)
        {
            break;
        }
    }
    for (const std::unique_ptr<Mover>& mover : m_movers)
    {
        mover->writeBack();
    }
    keepSupports();
}

std::unordered_set<const btCollisionObject*> btCcdSoftResponse::supportedObjects() const
{
    std::unordered_set<btCollisionObject*> objects;
    std::vector<std::vector<btCollisionObject*>> groups;  // what pushes each other
    for (std::size_t i = 0; i < m_touches.size(); ++i)
    {
        const Touch& touch = m_touches[i];
        if (!touch.m_isForced && touch.m_impulse.isZero(0.0) && m_paths[i].m_push.isZero(0.0))
        {
            continue;
        }
        std::vector<btCollisionObject*>& group = groups.emplace_back();
        for (const btCcdSoftPart* part : touch.m_part)
        {
            group.push_back(part != nullptr ? part->m_object : nullptr);
        }
        for (const Side& side : touch.m_sides)
        {
            group.push_back(side.m_anchor);
            group.push_back(side.m_obstacle != nullptr ? side.m_obstacle->m_object : nullptr);
        }
        std::erase(group, nullptr);
        objects.insert(group.begin(), group.end());
    }
    std::unordered_set<const btCollisionObject*> supported;
    for (btCollisionObject* object : std::vector(objects.begin(), objects.end()))
    {
        btSoftBody* soft = btSoftBody::upcast(object);
        for (int i = 0; i < (soft != nullptr ? soft->m_deformableAnchors.size() : 0); ++i)
        {
            auto* anchor =
                const_cast<btCollisionObject*>(soft->m_deformableAnchors[i].m_cti.m_colObj);
            groups.push_back({object, anchor});
            objects.insert(anchor);
        }
    }
    std::ranges::copy_if(objects,
                         std::inserter(supported, supported.end()),
                         [](btCollisionObject* object) { return cannotMove(*object); });
    const auto isSupported = [&](const btCollisionObject* object)
    { return supported.contains(object); };
    bool hasSpread = true;
    while (hasSpread)
    {
        const std::size_t before = supported.size();
        for (const std::vector<btCollisionObject*>& group : groups)
        {
            if (std::ranges::any_of(group, isSupported))
            {
                supported.insert(group.begin(), group.end());
            }
        }
        hasSpread = supported.size() > before;
    }
    return supported;
}

void btCcdSoftResponse::keepSupports()
{
    for (std::size_t i = 0; i < m_touches.size(); ++i)
    {
        const Touch& touch = m_touches[i];
        const Path& path = m_paths[i];
        if (touch.m_key == 0 || (path.m_push.isZero(0.0) && touch.m_impulse.isZero(0.0)))
        {
            continue;
        }
        Support& support = m_supports[touch.m_key];
        support.m_push_W += path.m_axes.transpose() * path.m_push;
        support.m_impulse_W += path.m_axes.transpose() * touch.m_impulse;
        for (std::size_t side = 0; side < 2; ++side)
        {
            const Lever& lever = path.m_levers[side];
            if (lever.m_mover == nullptr || lever.m_mover->m_rigid == nullptr)
            {
                continue;
            }
            btRigidBody* body = lever.m_mover->m_rigid;
            Vector6d& ofBody =
                m_bodySupports.try_emplace(btCcdProxyId(*body), BodySupport{body, Vector6d::Zero()})
                    .first->second.m_change;
            for (std::size_t k = 0; k < 3; ++k)
            {
                ofBody += kSigns[side] * path.m_push[Eigen::Index(k)] / m_timeStep *
                          m_rows[lever.m_rows][k].m_response;
            }
        }
    }
}
