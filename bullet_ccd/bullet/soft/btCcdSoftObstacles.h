/// Rigid bodies, links and static colliders as surfaces that soft bodies meet.
#ifndef BT_CCD_SOFT_OBSTACLES_H
#define BT_CCD_SOFT_OBSTACLES_H

#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"
#include "bullet_ccd/bullet/soft/btCcdSoftPart.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <vector>

class btBroadphaseInterface;
class btMultiBody;
struct btCcdPosedModel;

/// Every part of a collider is a mesh whose vertices go straight from the pose at the start of the
/// step to that at its end. (Bullet turns a body by at most a quarter of pi in a step, so that its
/// surface stays one in between, and nothing passes it that is on one side of it at both ends.)
class btCcdSoftObstacles
{
public:
    /// The step begins: the poses are kept. A kinematic object begins where it ended, unless it has
    /// jumped (farther than four times its size).
    void begin(btBroadphaseInterface& broadphase);
    /// True if the object was in the world when the step began. It may be gone since it was known.
    [[nodiscard]] bool isThere(const btCollisionObject& object) const
    {
        return m_poses.contains(&object);
    }
    /// The step ends: all parts of colliders that meet the box [m], on their way. In the same step
    /// it may be asked again for another box: parts are the same, and where they were put
    /// meanwhile.
    const std::vector<btCcdSoftPart*>& collect(btBroadphaseInterface& broadphase,
                                               const Eigen::AlignedBox3d& box);
    /// True if the shape, or some of its parts, is covered.
    [[nodiscard]] bool isCovered(const btCollisionShape* shape)
    {
        return m_cache.find(shape) != nullptr;
    }
    void forget(const btCollisionShape* shape) { m_cache.forget(shape); }
    /// Takes a multibody back to this part of its way since begin(): its joints, and the poses of
    /// its colliders. Its velocities stay.
    /// @param part  0 (the start of the step, bit for bit the joints that it had) to 1
    void takeBack(btMultiBody& body, double part) const;
    /// Colliders in the box of the last step whose shape is not covered.
    [[nodiscard]] int uncovered() const { return m_uncovered; }

private:
    struct Pose
    {
        btTransform m_start;
        btTransform m_end;
        int m_proxy;  ///< of the object, see btCcdProxyId()
    };
    /// Base and joints of a multibody when the step began.
    struct Posture
    {
        btVector3 m_place;
        btQuaternion m_turn;
        std::vector<std::vector<btScalar>> m_joints;
    };
    struct Entry
    {
        btCcdSoftPart m_part;
        std::int64_t m_round = 0;
        bool m_isFar = false;  ///< beyond kLargestCoordinate in this step
    };
    using Key = std::tuple<const btCollisionObject*, std::size_t, const void*>;

    btCcdShapeCache m_cache;
    std::unordered_map<const btCollisionObject*, Pose> m_poses;
    std::unordered_map<const btMultiBody*, Posture> m_postures;
    std::map<Key, Entry> m_entries;
    std::vector<btCcdSoftPart*> m_parts;
    std::int64_t m_round = 0;
    int m_uncovered = 0;

    void keepPosture(const btMultiBody& body);
    void addObject(btCollisionObject& object, const Eigen::AlignedBox3d& box);
    void addPart(btCollisionObject& object,
                 std::size_t index,
                 const btCcdShapePart& part,
                 const Eigen::Isometry3d& X_SG);
    /// Sets where the part is at both ends of the step, unless it still is there.
    void placePart(btCollisionObject& object,
                   const btCcdShapePart& part,
                   const Eigen::Isometry3d& X_SG,
                   btCcdSoftPart& soft);
};

#endif  // BT_CCD_SOFT_OBSTACLES_H
