#include "bullet_ccd/bullet/btCcdManifolds.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/contact/find_contacts.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

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
    if (shared == nullptr && m_manifolds.size() == 0)
    {
        m_manifolds.push_back(
            m_dispatcher->getNewManifold(a.getCollisionObject(), b.getCollisionObject()));
    }
    btPersistentManifold* manifold = shared != nullptr ? shared : m_manifolds[0];
    result.setPersistentManifold(manifold);
    if (shared == nullptr)
    {
        manifold->clearManifold();
    }
    for (const btCcdShapePart& pa : modelA.m_parts)
    {
        for (const btCcdShapePart& pb : modelB.m_parts)
        {
            const double m = pa.m_margin + pb.m_margin;
            bullet_ccd::ContactOptions options;
            options.threshold = 2 * m + pa.m_radius + pb.m_radius;
            for (const auto& c :
                 bullet_ccd::findContacts(*pa.m_tree,
                                          btCcdToEigen(a.getWorldTransform()) * pa.X_SG,
                                          *pb.m_tree,
                                          btCcdToEigen(b.getWorldTransform()) * pb.X_SG,
                                          options))
            {
                const Eigen::Vector3d onB = c.pointB - c.normal * pb.m_radius;
                result.addContactPoint(btCcdToBullet(Eigen::Vector3d(-c.normal)),
                                       btCcdToBullet(onB),
                                       btScalar(c.gap - pa.m_radius - pb.m_radius - m));
            }
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
