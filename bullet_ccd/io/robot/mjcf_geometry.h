/// Geoms and mesh assets of MJCF.
#pragma once

#include "bullet_ccd/io/robot/mjcf_document.h"
#include "bullet_ccd/io/robot/robot_parts.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace bullet_ccd
{
/// What one geom is.
struct MjcfGeom
{
    TriangleMesh mesh;  ///< frame of the body
    bool collides = true;
    double mass = 0.0;  ///< by its mass or density [kg]
};

/// Turns geoms into meshes.
class MjcfGeometry
{
public:
    explicit MjcfGeometry(MjcfDocument& document);

    /// The geom, or nothing if it is of a kind that is left out, which is named.
    /// A geom that does not collide may lack its mesh file; then it has no mesh.
    [[nodiscard]] std::optional<MjcfGeom> geom(const MjcfElement& element);

    [[nodiscard]] const std::vector<std::string>& notes() const { return m_files.notes(); }

private:
    /// Of a primitive whose sizes are given; z along the way from `fromto`'s second point to its
    /// first.
    [[nodiscard]] TriangleMesh primitive(const MjcfElement& element, const std::string& type) const;
    [[nodiscard]] TriangleMesh asset(const MjcfElement& element);

    MjcfDocument& m_document;
    std::map<std::string, MjcfElement> m_assets;
    MeshFiles m_files;
};
}  // namespace bullet_ccd
