/// The algorithm of a pair of colliders: contacts of meshes, and times of impact of all shapes.
#ifndef BT_CCD_COLLISION_ALGORITHM_H
#define BT_CCD_COLLISION_ALGORITHM_H

#include "bullet_ccd/bullet/btCcdPrecision.h"
#include "bullet_ccd/toi/toi.h"

#include <BulletCollision/CollisionDispatch/btActivatingCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <memory>

class btCcdContext;
class btCcdManifolds;
class btCollisionDispatcher;
struct btCollisionAlgorithmCreateFunc;

/// When two colliders come too near each other, and where.
struct btCcdPairToi
{
    /// Separated, Hit, Overlapping (some parts intersect at the start, which are left to discrete
    /// contacts, and the others do not meet) or IterationLimit.
    bullet_ccd::ToiStatus m_status = bullet_ccd::ToiStatus::Separated;
    double m_fraction = 1.0;  ///< certified: the bodies can go on until then
    Eigen::Vector3d m_pointA = Eigen::Vector3d::Zero();  ///< at that time, in the world [m]
    Eigen::Vector3d m_pointB = Eigen::Vector3d::Zero();
    Eigen::Vector3d m_normal = Eigen::Vector3d::Zero();  ///< unit, from A to B
    /// Some parts began so deep in each other's reserve that slow motion must be asked for, too.
    bool m_isDeep = false;
};

/// What calculateTimeOfImpact() finds beside the fraction. Pass one as its result.
class BULLET_CCD_API btCcdImpactResult : public btManifoldResult
{
public:
    btCcdPairToi m_toi;
};

/// Answers for a pair of colliders where Bullet asks its own pair algorithms.
///
/// Where stock Bullet has discrete contacts for the two shapes, they stay as they are, bit for bit.
/// Where it has none (two meshes), and for every pair with a btCcdMeshShape or a GImpact mesh,
/// contacts come from exact distances.
class BULLET_CCD_API btCcdCollisionAlgorithm : public btActivatingCollisionAlgorithm
{
public:
    /// Registers the algorithm for all pairs of covered shapes, in both orders and both tables
    /// (contacts, and closest points for contactTest and contactPairTest). The algorithms that were
    /// registered before, except GImpact's own, still answer for the contacts of stock shapes. So
    /// call it after other registrations and before objects are added. A second call does nothing.
    ///
    /// The registration lasts until unregisterAlgorithm() (see btCcdRegistration) or the end of the
    /// program.
    static void registerAlgorithm(btCollisionDispatcher* dispatcher);
    /// Frees what belongs to a dispatcher that is about to be destroyed. Its pairs must be gone.
    static void unregisterAlgorithm(btCollisionDispatcher* dispatcher);
    /// Frees what belonged to a dispatcher that has been destroyed already.
    static void forgetDispatcher(const btCollisionDispatcher* dispatcher);

    /// @param stock makes the algorithm that answers for contacts; null: contacts are ours
    btCcdCollisionAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                            const btCollisionObjectWrapper* body0,
                            const btCollisionObjectWrapper* body1,
                            btCollisionAlgorithmCreateFunc* stock);
    ~btCcdCollisionAlgorithm() override;

    void processCollision(const btCollisionObjectWrapper* body0,
                          const btCollisionObjectWrapper* body1,
                          const btDispatcherInfo& dispatchInfo,
                          btManifoldResult* result) override;

    /// The fraction of the motion that is free of contact, rounded down; 1 if all of it is.
    ///
    /// While a btCcd world or action steps, the motion is the one that it is about to commit or has
    /// just committed. Otherwise links move for dispatchInfo.m_timeStep at the velocities of their
    /// joints, by exact forward kinematics, because Bullet's own interpolation transforms are wrong
    /// for chains. Other objects move from the world transform to the interpolation transform.
    /// @param result may be a btCcdImpactResult
    btScalar calculateTimeOfImpact(btCollisionObject* body0,
                                   btCollisionObject* body1,
                                   const btDispatcherInfo& dispatchInfo,
                                   btManifoldResult* result) override;

    void getAllContactManifolds(btManifoldArray& manifolds) override;

private:
    btCcdContext& m_context;
    btCollisionAlgorithmConstructionInfo m_info;
    btCollisionAlgorithmCreateFunc* m_stockFunc;
    btCollisionAlgorithm* m_stock = nullptr;      // made when it is first needed
    bool m_isOfCompounds = false;                 // that one, of two
    std::unique_ptr<btCcdManifolds> m_manifolds;  // null where contacts are Bullet's

    void processOwn(const btCollisionObjectWrapper* body0,
                    const btCollisionObjectWrapper* body1,
                    const btDispatcherInfo& dispatchInfo,
                    btManifoldResult* result);
};

/// Registers the algorithm for as long as it lives. Declare it after the dispatcher and before the
/// world: so it goes after all pairs and before the dispatcher.
class BULLET_CCD_API btCcdRegistration
{
public:
    explicit btCcdRegistration(btCollisionDispatcher& dispatcher) : m_dispatcher(dispatcher)
    {
        btCcdCollisionAlgorithm::registerAlgorithm(&dispatcher);
    }
    ~btCcdRegistration() { btCcdCollisionAlgorithm::unregisterAlgorithm(&m_dispatcher); }
    btCcdRegistration(const btCcdRegistration&) = delete;
    btCcdRegistration& operator=(const btCcdRegistration&) = delete;

private:
    btCollisionDispatcher& m_dispatcher;
};

#endif  // BT_CCD_COLLISION_ALGORITHM_H
