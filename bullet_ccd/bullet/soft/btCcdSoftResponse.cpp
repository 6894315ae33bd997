#include "bullet_ccd/bullet/soft/btCcdSoftResponse.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btSoftBody.h>

#include <algorithm>
#include <cmath>

using Eigen::Vector3d;

namespace
{
/// Sweeps of Gauss-Seidel, at most. They end when none changes a distance by more than this part of
/// the rest distance, or a velocity by more than this part of the largest change of the first one.
constexpr int kPathSweeps = 12;
constexpr int kVelocitySweeps = 20;
constexpr double kSmallChange = 1e-3;
/// When more contacts come in, what they would move by less than this part of the rest distance
/// stays as it is.
constexpr double kNoChange = 1e-2;
/// Slower contacts do not bounce [m/s], as in Bullet's solver.
constexpr double kBounceSpeed = 0.2;
/// Of the two sides of a touch in its relative velocity, that of B to A.
constexpr std::array<double, 2> kSigns{-1.0, 1.0};
/// What is asleep wakes up if its velocity changes by more [m/s, rad/s].
constexpr double kWakingSpeed = 0.05;

double frictionOf(const btCcdSoftPart& part)
{
    return part.m_soft != nullptr ? double(part.m_soft->m_cfg.kDF)
                                  : double(part.m_object->getFriction());
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

    explicit Mover(btRigidBody& body) : m_rigid(&body), m_before(6)
    {
        m_before << btCcdToEigen(body.getLinearVelocity()), btCcdToEigen(body.getAngularVelocity());
        m_velocity = m_before;
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

void btCcdSoftResponse::begin(double rest, double timeStep)
{
    m_rest = rest;
    m_timeStep = timeStep;
    m_touches.clear();
    m_paths.clear();
    m_rows.clear();
    m_movers.clear();
    m_clock = 0;
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
            path.m_response += w * path.m_give[k];
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
    if (!(path.m_response > 0.0) || !(normal.squaredNorm() > 0.5))
    {
        return;
    }
    path.m_axes = axesOf(normal);
    const double rest = m_rest + partA.m_radius + partB.m_radius;
    const double gap = normal.dot(path.m_start);
    path.m_goal = gap < rest ? gap + btCcdSoftResponse::kRecovery * (rest - gap) : rest;
    path.m_friction = frictionOf(partA) * frictionOf(partB);
    touch.m_restitution =
        double(partA.m_object->getRestitution()) * double(partB.m_object->getRestitution());
    m_touches.push_back(std::move(touch));
    m_paths.push_back(path);
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

double btCcdSoftResponse::solvePath(Path& path, double least)
{
    if (!(path.m_response > 0.0))
    {
        return 0.0;  // nothing soft
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
    const double beyond = path.m_axes.row(0).dot(end) - path.m_goal;
    if (beyond >= 0.0 && path.m_push[0] == 0.0)
    {
        return 0.0;  // far enough, and nothing to take back
    }
    Vector3d excess = path.m_axes * (end - path.m_start);
    excess[0] = beyond;
    const Vector3d wanted = limited(path.m_push - excess / path.m_response, path.m_friction);
    const Vector3d change = wanted - path.m_push;
    if (!(std::abs(change[0]) * path.m_response > least) && (least > 0.0 || change.isZero(0.0)))
    {
        return 0.0;
    }
    const Vector3d push_W = path.m_axes.transpose() * change;
    path.m_solved = ++m_clock;
    for (std::size_t k = 0; k < 4; ++k)
    {
        if (path.m_give[k] != 0.0)
        {
            *path.m_end[k] += path.m_give[k] * push_W;
            *path.m_bent[k] = m_clock;
        }
    }
    path.m_push = wanted;
    return change.norm() * path.m_response;
}

void btCcdSoftResponse::solvePaths(bool isFirst)
{
    const double least = isFirst ? 0.0 : kNoChange * m_rest;
    for (int sweep = 0; sweep < kPathSweeps; ++sweep)
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

void btCcdSoftResponse::findMover(Side& side, const Path& path)
{
    if (side.m_obstacle == nullptr)
    {
        return;
    }
    btCollisionObject* object = side.m_obstacle->m_object;
    const auto moverOf = [this](auto& body)
    {
        std::unique_ptr<Mover>& mover = m_movers[&body];
        if (mover == nullptr)
        {
            mover = std::make_unique<Mover>(body);
        }
        return mover.get();
    };
    if (btRigidBody* body = btRigidBody::upcast(object))
    {
        if (body->getInvMass() > btScalar(0) && !body->isStaticOrKinematicObject())
        {
            side.m_mover = moverOf(*body);
        }
    }
    else if (btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(object))
    {
        side.m_mover = moverOf(*link->m_multiBody);
    }
    if (side.m_mover == nullptr)
    {
        return;
    }
    side.m_rows = m_rows.size();
    std::array<Row, 3>& rows = m_rows.emplace_back();
    for (int k = 0; k < 3; ++k)
    {
        rows[std::size_t(k)] =
            side.m_mover->row(*object, side.m_point, path.m_axes.row(k).transpose());
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
        const Side& side = touch.m_sides[i];
        if (side.m_mover == nullptr)
        {
            v += kSigns[i] * (path.m_axes * side.m_pathVelocity);
            continue;
        }
        for (std::size_t k = 0; k < 3; ++k)
        {
            v[Eigen::Index(k)] +=
                kSigns[i] * m_rows[side.m_rows][k].m_jacobian.dot(side.m_mover->m_velocity);
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
            part->m_velocity[touch.m_vertex[k]] += path.m_give[k] * J_W;
        }
    }
    for (std::size_t i = 0; i < 2; ++i)
    {
        const Side& side = touch.m_sides[i];
        for (std::size_t k = 0; k < 3 && side.m_mover != nullptr; ++k)
        {
            side.m_mover->m_velocity +=
                kSigns[i] * impulse[Eigen::Index(k)] * m_rows[side.m_rows][k].m_response;
        }
    }
}

double btCcdSoftResponse::solveVelocity(Touch& touch, const Path& path)
{
    Vector3d response = Vector3d::Constant(path.m_response);
    for (const Side& side : touch.m_sides)
    {
        for (std::size_t k = 0; k < 3 && side.m_mover != nullptr; ++k)
        {
            const Row& row = m_rows[side.m_rows][k];
            response[Eigen::Index(k)] += row.m_jacobian.dot(row.m_response);
        }
    }
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
    std::vector<std::size_t> pushing;
    for (std::size_t i = 0; i < m_touches.size(); ++i)
    {
        Touch& touch = m_touches[i];
        const Path& path = m_paths[i];
        if (!(path.m_push[0] > 0.0 || touch.m_isForced))
        {
            continue;
        }
        pushing.push_back(i);
        findMover(touch.m_sides[0], path);
        findMover(touch.m_sides[1], path);
        const double speed = -relativeVelocity(touch, path)[0];
        touch.m_goalSpeed = speed > kBounceSpeed ? touch.m_restitution * speed : 0.0;
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
    for (auto& [body, mover] : m_movers)
    {
        mover->writeBack();
    }
}
