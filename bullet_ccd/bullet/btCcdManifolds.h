/// The contact manifolds of one pair of colliders, from exact distances.
#ifndef BT_CCD_MANIFOLDS_H
#define BT_CCD_MANIFOLDS_H

#include "bullet_ccd/bullet/btCcdShapeCache.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

struct btCollisionObjectWrapper;

/// Owns one manifold for every patch of contact (points of like normals).
///
/// Depth is counted from the shell: a point at distance d of the surfaces has depth d - m, m the
/// sum of both margins, so that the solver, which lets a pair close to depth 0, leaves room that
/// the time of impact guards. Points are given for d <= 2 m (or m + the tolerance of the world if
/// the margins are smaller).
///
/// Points persist: one that is near an old one (in the frames of both bodies) inherits its
/// impulses; what is no longer found is dropped at once.
class btCcdManifolds
{
public:
    explicit btCcdManifolds(btDispatcher& dispatcher) : m_dispatcher(&dispatcher) {}
    ~btCcdManifolds();
    btCcdManifolds(const btCcdManifolds&) = delete;
    btCcdManifolds& operator=(const btCcdManifolds&) = delete;

    /// Brings all manifolds up to date with the poses of the wrappers (a compound child's are not
    /// those of its collision object).
    /// @param shared if not null, the manifold of a parent: all points go there
    void update(const btCollisionObjectWrapper& a,
                const btCcdShapeModel& modelA,
                const btCollisionObjectWrapper& b,
                const btCcdShapeModel& modelB,
                btPersistentManifold* shared,
                btManifoldResult& result);
    /// Appends the manifolds that this owns.
    void appendTo(btManifoldArray& manifolds) const;

private:
    btDispatcher* m_dispatcher;
    btManifoldArray m_manifolds;
};

#endif  // BT_CCD_MANIFOLDS_H
