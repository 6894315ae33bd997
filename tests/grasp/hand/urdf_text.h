/// Elements of URDF texts of hands made of boxes.
#pragma once

#include <string>

namespace bullet_ccd::tests
{
/// A link of one box with edges of `size`; `origin` is its middle ("x y z" [m]).
inline std::string boxLink(const std::string& name,
                           const std::string& size,
                           const std::string& origin)
{
    return "<link name=\"" + name + "\"><collision><origin xyz=\"" + origin +
           "\"/><geometry><box size=\"" + size + "\"/></geometry></collision></link>";
}

/// A revolute joint; `limits` are the attributes lower and upper.
inline std::string hinge(const std::string& name,
                         const std::string& parent,
                         const std::string& child,
                         const std::string& xyz,
                         const std::string& axis,
                         const std::string& limits)
{
    return "<joint name=\"" + name + "\" type=\"revolute\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><origin xyz=\"" + xyz + "\"/><axis xyz=\"" + axis +
           "\"/><limit " + limits + " effort=\"1\" velocity=\"1\"/></joint>";
}
}  // namespace bullet_ccd::tests
