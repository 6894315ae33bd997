#include "bullet_ccd/bullet/soft/btCcdSoftObstacles.h"

#include "bullet_ccd/bullet/shapes/btCcdShapeParts.h"
#include "bullet_ccd/bullet/shapes/btCcdTiles.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <utility>

namespace
{
/// Models and surfaces that nothing has come near for so many steps are dropped.
constexpr std::int64_t kStepsKept = 300;

/// In the order in which they came into the world: that of the broadphase's tree may depend on
/// addresses.
template <typename Visit>
void forObjects(btBroadphaseInterface& broadphase, const Visit& visit)
{
    struct Callback : btBroadphaseAabbCallback
    {
        std::vector<const btBroadphaseProxy*> m_found;
        bool process(const btBroadphaseProxy* proxy) override
        {
            m_found.push_back(proxy);
            return true;
        }
    } callback;
    const btScalar far = BT_LARGE_FLOAT;
    broadphase.aabbTest(btVector3(-far, -far, -far), btVector3(far, far, far), callback);
    std::ranges::sort(callback.m_found, {}, &btBroadphaseProxy::m_uniqueId);
    for (const btBroadphaseProxy* proxy : callback.m_found)
    {
        auto* object = static_cast<btCollisionObject*>(proxy->m_clientObject);
        if (object->getInternalType() != btCollisionObject::CO_SOFT_BODY)
        {
            visit(*object);
        }
    }
}

Eigen::AlignedBox3d boxOf(const btCollisionShape& shape, const btTransform& pose)
{
    btVector3 low;
    btVector3 high;
    shape.getAabb(pose, low, high);
    return {btCcdToEigen(low), btCcdToEigen(high)};
}

/// True if a kinematic object has been put elsewhere rather than moved.
bool hasJumped(const btCollisionObject& object, const btTransform& from, const btTransform& to)
{
    const Eigen::AlignedBox3d box = boxOf(*object.getCollisionShape(), to);
    return double(from.getOrigin().distance(to.getOrigin())) > 4.0 * box.diagonal().norm();
}
}  // namespace

void btCcdSoftPart::setEndPose(const btTransform& pose)
{
    m_endPose = pose;
    m_hasChanged = true;
    const Eigen::Isometry3d X_WG = btCcdToEigen(pose) * X_SG;
    const std::vector<Eigen::Vector3d>& vertices = m_tree->mesh().vertices;
    m_end.resize(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i)
    {
        m_end[i] = X_WG * vertices[i];
    }
}

void btCcdSoftObstacles::begin(btBroadphaseInterface& broadphase)
{
    ++m_round;
    std::erase_if(m_entries,
                  [this](const auto& entry)
                  { return entry.second.m_round + kStepsKept < m_round; });
    m_cache.endRound();
    std::unordered_map<const btCollisionObject*, Pose> before;
    before.swap(m_poses);
    m_postures.clear();
    forObjects(
        broadphase,
        [&](btCollisionObject& object)
        {
            const int proxy = btCcdProxyId(object);
            Pose pose{object.getWorldTransform(), object.getWorldTransform(), proxy};
            const auto known = before.find(&object);
            if (known == before.end() || known->second.m_proxy != proxy)
            {
                m_cache.check(object.getCollisionShape());
            }
            else if (object.isKinematicObject() &&
                     !hasJumped(object, known->second.m_end, pose.m_start))
            {
                pose.m_start = known->second.m_end;
            }
            m_poses.emplace(&object, pose);
            if (const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(&object))
            {
                keepPosture(*link->m_multiBody);
            }
        });
}

void btCcdSoftObstacles::keepPosture(const btMultiBody& body)
{
    const auto [entry, isNew] = m_postures.try_emplace(&body);
    if (!isNew)
    {
        return;
    }
    Posture& posture = entry->second;
    posture.m_place = body.getBasePos();
    posture.m_turn = body.getWorldToBaseRot();
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        const btMultibodyLink& link = body.getLink(i);
        posture.m_joints.emplace_back(link.m_jointPos, link.m_jointPos + link.m_posVarCount);
    }
}

void btCcdSoftObstacles::takeBack(btMultiBody& body, double part) const
{
    const auto known = m_postures.find(&body);
    if (known == m_postures.end() ||
        known->second.m_joints.size() != std::size_t(body.getNumLinks()))
    {
        return;
    }
    const Posture& posture = known->second;
    const auto turned = [part](const btQuaternion& from, const btQuaternion& to)
    { return part > 0.0 ? from.slerp(to, btScalar(part)) : from; };
    if (!body.hasFixedBase())
    {
        body.setBasePos(posture.m_place.lerp(body.getBasePos(), btScalar(std::max(part, 0.0))));
        body.setWorldToBaseRot(turned(posture.m_turn, body.getWorldToBaseRot()));
    }
    for (int i = 0; i < body.getNumLinks(); ++i)
    {
        std::vector<btScalar> joint = posture.m_joints[std::size_t(i)];
        const btScalar* now = body.getLink(i).m_jointPos;
        if (body.getLink(i).m_jointType == btMultibodyLink::eSpherical)
        {
            const btQuaternion turn =
                turned({joint[0], joint[1], joint[2], joint[3]}, {now[0], now[1], now[2], now[3]});
            joint = {turn.x(), turn.y(), turn.z(), turn.w()};
        }
        else if (part > 0.0)
        {
            for (std::size_t k = 0; k < joint.size(); ++k)
            {
                joint[k] += btScalar(part) * (now[k] - joint[k]);
            }
        }
        if (!joint.empty())
        {
            body.setJointPosMultiDof(i, joint.data());
        }
    }
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> places;
    body.forwardKinematics(turns, places);
    body.updateCollisionObjectWorldTransforms(turns, places);
}

const std::vector<btCcdSoftPart*>& btCcdSoftObstacles::collect(btBroadphaseInterface& broadphase,
                                                               const Eigen::AlignedBox3d& box)
{
    m_parts.clear();
    m_uncovered = 0;
    forObjects(broadphase, [&](btCollisionObject& object) { addObject(object, box); });
    return m_parts;
}

void btCcdSoftObstacles::addObject(btCollisionObject& object, const Eigen::AlignedBox3d& box)
{
    const btTransform& end = object.getWorldTransform();  // even where a part is held back
    Pose& pose = m_poses.try_emplace(&object, Pose{end, end, btCcdProxyId(object)}).first->second;
    pose.m_end = end;
    const btCollisionShape* shape = object.getCollisionShape();
    if (!object.hasContactResponse() ||
        !boxOf(*shape, pose.m_start).merged(boxOf(*shape, end)).intersects(box))
    {
        return;
    }
    const btCcdShapeModel* model = m_cache.find(shape);
    if (model == nullptr)
    {
        m_uncovered += btCcdIsEmpty(*shape) ? 0 : 1;
        return;
    }
    const Eigen::Isometry3d X_S0 = btCcdToEigen(pose.m_start).inverse();
    const Eigen::Isometry3d X_S1 = btCcdToEigen(end).inverse();
    for (std::size_t i = 0; i < model->m_parts.size(); ++i)
    {
        const btCcdShapePart& part = model->m_parts[i];
        if (part.m_tiles != nullptr)
        {
            const Eigen::AlignedBox3d near =
                btCcdBoxIn(part.X_SG.inverse() * X_S0, box)
                    .merged(btCcdBoxIn(part.X_SG.inverse() * X_S1, box));
            for (const btCcdTiles::Piece* piece : part.m_tiles->near(near))
            {
                if (piece->m_tree != nullptr)
                {
                    addPart(object, i, btCcdPieceOf(part, *piece), part.X_SG);
                }
            }
        }
        else if (part.m_isPlane)
        {
            btCcdShapePart piece = part;
            piece.m_tree = btCcdPlanePiece(box.diagonal().norm());
            addPart(object, i, piece, btCcdMeshPose(part, X_S1 * box.center()));
        }
        else
        {
            addPart(object, i, part, part.X_SG);
        }
    }
}

void btCcdSoftObstacles::addPart(btCollisionObject& object,
                                 std::size_t index,
                                 const btCcdShapePart& part,
                                 const Eigen::Isometry3d& X_SG)
{
    Entry& entry = m_entries[{&object, index, part.m_tree.get()}];
    if (std::exchange(entry.m_round, m_round) != m_round)
    {
        placePart(object, part, X_SG, entry.m_part);
        const auto isNear = [](const std::vector<Eigen::Vector3d>& places)
        { return std::ranges::all_of(places, bullet_ccd::isPlace); };
        entry.m_isFar =
            !isNear(entry.m_part.m_start) || !isNear(entry.m_part.m_end) ||
            (entry.m_part.m_surface == nullptr && !isNear(part.m_tree->mesh().vertices));
    }
    if (entry.m_isFar)
    {
        ++m_uncovered;
        return;
    }
    if (entry.m_part.m_surface == nullptr)
    {
        entry.m_part.m_surface = std::make_unique<bullet_ccd::DeformableSurface>(
            part.m_tree->mesh(), bullet_ccd::DeformableSurfaceOptions{.weldDuplicates = true});
    }
    m_parts.push_back(&entry.m_part);
}

void btCcdSoftObstacles::placePart(btCollisionObject& object,
                                   const btCcdShapePart& part,
                                   const Eigen::Isometry3d& X_SG,
                                   btCcdSoftPart& soft)
{
    const Pose& pose = m_poses.at(&object);
    const bool rests = pose.m_start == pose.m_end;
    soft.m_freePose = pose.m_end;
    if (soft.m_surface != nullptr && rests && soft.m_startPose == pose.m_start &&
        soft.m_endPose == pose.m_end && soft.X_SG.matrix() == X_SG.matrix())
    {
        return;
    }
    soft.m_object = &object;
    soft.m_tree = part.m_tree;
    soft.X_SG = X_SG;
    soft.m_radius = part.m_radius;
    soft.m_startPose = pose.m_start;
    soft.setEndPose(pose.m_start);
    soft.m_start = soft.m_end;
    if (!rests)
    {
        soft.setEndPose(pose.m_end);
    }
}
