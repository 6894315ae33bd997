#include "python/pybullet/fit.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <Python.h>
#include <cstring>
#include <typeinfo>

namespace
{
/// pybullet.getAPIVersion(); -1 if there is no such module or function.
long apiVersion()
{
    PyObject* module = PyDict_GetItemString(PyImport_GetModuleDict(), "pybullet");  // borrowed
    PyObject* number =
        module != nullptr ? PyObject_CallMethod(module, "getAPIVersion", nullptr) : nullptr;
    const long version = number != nullptr ? PyLong_AsLong(number) : -1;
    PyErr_Clear();
    Py_DecRef(number);
    return version;
}

/// The dispatcher's tables are open to derived classes only.
struct Tables : btCollisionDispatcher
{
    /// Bullet's own configuration has one function for all pairs of unlike convex shapes, and one
    /// for all pairs of a convex shape and a mesh.
    static bool areFilled(btCollisionDispatcher& dispatcher)
    {
        const auto& table = dispatcher.*(&Tables::m_doubleDispatchContactPoints);
        const auto same = [&](int shape0, int shape1, int shape2, int shape3) {
            return table[shape0][shape1] != nullptr &&
                   table[shape0][shape1] == table[shape2][shape3];
        };
        return same(CONVEX_HULL_SHAPE_PROXYTYPE,
                    CAPSULE_SHAPE_PROXYTYPE,
                    CYLINDER_SHAPE_PROXYTYPE,
                    CONE_SHAPE_PROXYTYPE) &&
               same(BOX_SHAPE_PROXYTYPE,
                    TRIANGLE_MESH_SHAPE_PROXYTYPE,
                    CONVEX_HULL_SHAPE_PROXYTYPE,
                    TERRAIN_SHAPE_PROXYTYPE) &&
               same(COMPOUND_SHAPE_PROXYTYPE,
                    BOX_SHAPE_PROXYTYPE,
                    COMPOUND_SHAPE_PROXYTYPE,
                    CAPSULE_SHAPE_PROXYTYPE);
    }
};

/// A link leads to its multibody and back.
bool isInItsMultiBody(const btMultiBodyLinkCollider& collider)
{
    const btMultiBody* body = collider.m_multiBody;
    if (body == nullptr || collider.m_link < -1 || collider.m_link >= body->getNumLinks())
    {
        return false;
    }
    return collider.m_link < 0 ? body->getBaseCollider() == &collider
                               : body->getLink(collider.m_link).m_collider == &collider;
}
}  // namespace

std::string misfitOfHost(const HostContext& context)
{
    if (PyGILState_Check() == 0)
    {
        return "this is no p.DIRECT client. Windows and servers run the simulation in a thread or "
               "a "
               "process of their own, where the plugin cannot be; use p.connect(p.DIRECT)";
    }
    const long version = apiVersion();
    if (version != kHostApi)
    {
        return "pybullet.getAPIVersion() is " + std::to_string(version) + ", and only " +
               std::to_string(kHostApi) + " (PyBullet 3.0.7 to 3.2.7) is known";
    }
    if (context.m_processor == nullptr ||
        std::strcmp(typeid(*context.m_processor).name(), "29PhysicsServerCommandProcessor") != 0)
    {
        return "this client does not own its simulation; use p.connect(p.DIRECT)";
    }
    return {};
}

std::string misfitOfWorld(btDiscreteDynamicsWorld* world)
{
    if (world == nullptr)
    {
        return "there is no world";
    }
    // By name, so it works across two copies of Bullet.
    if (dynamic_cast<btMultiBodyDynamicsWorld*>(world) == nullptr)
    {
        return std::string("the world is a ") + typeid(*world).name() +
               ", not a btMultiBodyDynamicsWorld";
    }
    // What Bullet sets and PyBullet never changes.
    const btContactSolverInfo& info = world->getSolverInfo();
    if (info.m_maxGyroscopicForce != btScalar(100) ||
        info.m_singleAxisRollingFrictionThreshold != btScalar(1e30F))
    {
        return "the world has another precision or other members than those of Bullet 3.24 in "
               "double precision";
    }
    auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(world->getDispatcher());
    if (dispatcher == nullptr || !Tables::areFilled(*dispatcher))
    {
        return "the collision dispatcher is not Bullet's, or somebody has registered algorithms";
    }
    return ObjectFit().misfit(*world);
}

std::string ObjectFit::misfit(btDiscreteDynamicsWorld& world)
{
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size() && !(m_objectSeen && m_linkSeen); ++i)
    {
        const btBroadphaseProxy* proxy = objects[i]->getBroadphaseHandle();
        if (!m_objectSeen && (proxy == nullptr || proxy->m_clientObject != objects[i]))
        {
            return "collision objects have other members than those of Bullet 3.24";
        }
        m_objectSeen = true;
        const auto* collider = btMultiBodyLinkCollider::upcast(objects[i]);
        if (collider != nullptr && !isInItsMultiBody(*collider))
        {
            return "multibodies have other members than those of Bullet 3.24";
        }
        // The base stands before the array of links, so only a link says how that is laid out.
        m_linkSeen = m_linkSeen || (collider != nullptr && collider->m_link > 0);
    }
    return {};
}
