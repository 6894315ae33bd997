#include "bullet_ccd/bullet/btCcdControl.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

bool btCcdStopLink(btMultiBody& body, int link)
{
    if (body.getBaseCollider() == nullptr)
    {
        return false;
    }
    for (int i = link; i >= 0; i = body.getParent(i))
    {
        if (body.getLink(i).m_collider == nullptr)
        {
            return false;
        }
    }
    for (int i = link; i >= 0; i = body.getParent(i))
    {
        body.setLinkDynamicType(i, btCollisionObject::CF_KINEMATIC_OBJECT);
        for (int dof = 0; dof < body.getLink(i).m_dofCount; ++dof)
        {
            body.getJointVelMultiDof(i)[dof] = btScalar(0);
        }
    }
    body.setBaseDynamicType(btCollisionObject::CF_KINEMATIC_OBJECT);
    body.setBaseVel(btVector3(0, 0, 0));
    body.setBaseOmega(btVector3(0, 0, 0));
    return true;
}
