/// Whether the program, the world and the bodies that the plugin meets are built as it expects.
#ifndef PYTHON_PYBULLET_FIT_H
#define PYTHON_PYBULLET_FIT_H

#include "python/pybullet/host_interface.h"

#include <string>

class btDiscreteDynamicsWorld;

/// Each returns what does not fit, as a sentence, and an empty string if all is well. They look at
/// nothing that they have not found to be there.

/// Whether this is PyBullet of a version that is known, in a client without a window.
std::string misfitOfHost(const HostContext& context);
/// Whether the world has Bullet's double precision and its classes have the members expected.
std::string misfitOfWorld(btDiscreteDynamicsWorld* world);

/// Looks at the first object and the first multibody that comes into a world.
class ObjectFit
{
public:
    /// What does not fit among the objects that are there.
    std::string misfit(btDiscreteDynamicsWorld& world);

private:
    bool m_objectSeen = false;
    bool m_linkSeen = false;
};

#endif  // PYTHON_PYBULLET_FIT_H
