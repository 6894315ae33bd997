#include "grasp/quality/object_mass.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/reduce/qhull_state.h"

#include <array>
#include <cstdio>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// 0 if the vertices are in a plane, or so nearly that Qhull sees no solid.
double hullVolume(const TriangleMesh& mesh)
{
    std::vector<double> coordinates;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        coordinates.insert(coordinates.end(), vertex.data(), vertex.data() + 3);
    }
    QhullState hull;
    char options[] = "qhull FA Pp";  // FA: with the volume. Pp: no reports of precision.
    const auto count = static_cast<int>(mesh.vertices.size());
    return hull.build(options, coordinates.data(), 3, count) ? hull.state().totvol : 0.0;
}

double area(const TriangleMesh& mesh)
{
    double sum = 0.0;
    for (const Triangle& t : mesh.triangles)
    {
        const auto corner = [&](std::size_t k) -> const Eigen::Vector3d&
        { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
        sum += 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
    }
    return sum;
}
}  // namespace

const char* toString(MassSource source)
{
    switch (source)
    {
        case MassSource::Given:
            return "given";
        case MassSource::Volume:
            return "volume";
        case MassSource::ConvexHull:
            return "convex hull";
        case MassSource::Surface:
            return "surface";
    }
    BULLET_CCD_ASSERT(false);
    return "unknown";
}

ObjectMass massOf(const GraspObject& object, std::optional<double> given)
{
    if (given)
    {
        return {.mass = *given, .source = MassSource::Given};
    }
    const TriangleMesh& mesh = object.tree.mesh();
    const double hull = hullVolume(mesh);
    if (!(hull > 0.0))
    {
        return {.mass = kUsualDensity * kUsualThickness * area(mesh),
                .source = MassSource::Surface};
    }
    // What is closed inside out gets the volume of its bounding box from massProperties().
    constexpr double kRounding = 1e-6;
    const double volume = massProperties(mesh).volume;
    return object.watertight && volume <= (1.0 + kRounding) * hull
               ? ObjectMass{.mass = kUsualDensity * volume, .source = MassSource::Volume}
               : ObjectMass{.mass = kUsualDensity * hull, .source = MassSource::ConvexHull};
}

std::string massText(const ObjectMass& mass)
{
    const auto formatted = [](const char* format, double value)
    {
        std::array<char, 96> text{};
        std::snprintf(text.data(), text.size(), format, value);
        return std::string(text.data());
    };
    const std::string amount = formatted("%.3g kg", mass.mass);
    const std::string density = formatted(" at %g kg/m3)", kUsualDensity);
    switch (mass.source)
    {
        case MassSource::Given:
            return amount + " (given)";
        case MassSource::Volume:
            return amount + " (volume of the closed mesh" + density;
        case MassSource::ConvexHull:
            return amount + " (convex hull of a mesh that is not closed" + density;
        case MassSource::Surface:
            return amount + " (surface without volume, " +
                   formatted("%g mm thick", 1e3 * kUsualThickness) + density;
    }
    BULLET_CCD_ASSERT(false);
    return amount;
}
}  // namespace bullet_ccd::grasp
