#include "bullet_ccd/io/robot/mjcf_geometry.h"

#include "bullet_ccd/io/nearest_name.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <cmath>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <utility>

namespace bullet_ccd
{
namespace
{
std::string withoutSpaces(const std::string& name)
{
    const std::size_t begin = name.find_first_not_of(" \t\r\n");
    return begin == std::string::npos
               ? ""
               : name.substr(begin, name.find_last_not_of(" \t\r\n") - begin + 1);
}

std::filesystem::path assetPath(const MjcfDocument& document, const std::string& file)
{
    std::filesystem::path path = withoutSpaces(file);
    if (document.compiler("strippath") == "true")
    {
        path = path.filename();
    }
    const std::string& meshFolder = document.compiler("meshdir");
    const std::string& folder = meshFolder.empty() ? document.compiler("assetdir") : meshFolder;
    // An absolute path on the right replaces what is on the left.
    return document.path().parent_path() / folder / path;
}

/// Vertices and faces that stand in the file itself.
TriangleMesh inlineMesh(const MjcfElement& element, const Eigen::Vector3d& scale)
{
    const std::vector<double> coordinates = *element.numbers("vertex", 9, kManyNumbers);
    const std::optional<std::vector<double>> faces = element.numbers("face", 3, kManyNumbers);
    if (!faces || coordinates.size() % 3 != 0 || faces->size() % 3 != 0)
    {
        element.fail("vertex without face, or not by threes",
                     "give x y z of each vertex and three vertices of each face");
    }
    TriangleMesh mesh;
    for (std::size_t i = 0; i < coordinates.size(); i += 3)
    {
        mesh.vertices.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
    }
    for (std::size_t i = 0; i < faces->size(); i += 3)
    {
        Triangle triangle;
        for (std::size_t k = 0; k < 3; ++k)
        {
            const double index = (*faces)[i + k];
            if (!(index >= 0.0 && index < static_cast<double>(mesh.vertices.size())))
            {
                element.fail("face names vertex " + std::to_string(index),
                             "use 0 to " + std::to_string(mesh.vertices.size() - 1));
            }
            triangle[k] = static_cast<std::int32_t>(index);
        }
        mesh.triangles.push_back(triangle);
    }
    transformMesh(mesh, Eigen::Affine3d(Eigen::Scaling(scale)));
    return mesh;
}
}  // namespace

MjcfGeometry::MjcfGeometry(MjcfDocument& document) : m_document(document)
{
    for (const tinyxml2::XMLElement* e : document.entries("asset"))
    {
        const std::string_view tag = e->Name();
        if (tag == "mesh")
        {
            const MjcfElement element(document, *e, "main");
            const std::string name =
                element.name().empty()
                    ? std::filesystem::path(element.text("file").value_or("")).stem().string()
                    : element.name();
            m_assets.emplace(name, element);
        }
        else if (tag == "model")
        {
            document.leftOut(*e, "<model> of <asset>");
        }
    }
}

TriangleMesh MjcfGeometry::asset(const MjcfElement& element)
{
    const std::string name = element.text("mesh").value_or("");
    const auto found = m_assets.find(name);
    if (found == m_assets.end())
    {
        std::vector<std::string> names;
        for (const auto& [known, unused] : m_assets)
        {
            names.push_back(known);
        }
        const std::string nearest = nearestName(name, names);
        element.fail(
            "mesh '" + name + "' is no asset",
            nearest.empty() ? "add a <mesh> to <asset>" : "did you mean '" + nearest + "'?");
    }
    const MjcfElement& asset = found->second;
    const Eigen::Vector3d scale = asset.vector("scale").value_or(Eigen::Vector3d::Ones());
    TriangleMesh mesh;
    if (asset.text("vertex"))
    {
        mesh = inlineMesh(asset, scale);
    }
    else if (const std::optional<std::string> file = asset.text("file"))
    {
        const std::filesystem::path path = assetPath(m_document, *file);
        std::error_code error;
        if (!std::filesystem::is_regular_file(path, error))
        {
            asset.fail("file '" + *file + "' is missing (looked for " + path.string() + ")",
                       "check file, and meshdir of <compiler>");
        }
        mesh = m_files.load(path, *file, scale, asset.where());
    }
    else
    {
        asset.fail("no file and no vertices", "give one of them");
    }
    // The reference is in the file's own coordinates, before they are scaled: a point p of the
    // file becomes S R' (p - r), and it is there as S p.
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    if (const auto q = asset.numbers("refquat", 4))
    {
        rotation = Eigen::Quaterniond((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
        // As in MuJoCo, none is no rotation.
        rotation = rotation.norm() > 0.0 ? rotation.normalized() : Eigen::Quaterniond::Identity();
    }
    const Eigen::Vector3d r = asset.vector("refpos").value_or(Eigen::Vector3d::Zero());
    Eigen::Affine3d X = Eigen::Affine3d::Identity();
    X.linear() = scale.asDiagonal() * rotation.conjugate().toRotationMatrix() *
                 scale.cwiseInverse().asDiagonal();
    X.translation() = -(X.linear() * scale.cwiseProduct(r));
    transformMesh(mesh, X);
    return mesh;
}

TriangleMesh MjcfGeometry::primitive(const MjcfElement& element, const std::string& type) const
{
    const bool isLong = type != "sphere";
    const auto ends = isLong ? element.numbers("fromto", 6) : std::nullopt;
    const std::size_t needed = type == "sphere" || ends                  ? 1
                               : type == "capsule" || type == "cylinder" ? 2
                                                                         : 3;
    std::optional<std::vector<double>> size = element.numbers("size", needed, 3);
    if (!size)
    {
        element.fail("a " + type + " has no size", "give its size");
    }
    for (std::size_t k = 0; k < needed; ++k)
    {
        requirePositive((*size)[k], element.where() + ": size");
    }
    Eigen::Isometry3d X_BG = Eigen::Isometry3d::Identity();
    if (ends)
    {
        const Eigen::Vector3d from((*ends)[0], (*ends)[1], (*ends)[2]);
        const Eigen::Vector3d to((*ends)[3], (*ends)[4], (*ends)[5]);
        const double length = (from - to).norm();
        requirePositive(length, element.where() + ": length of fromto");
        X_BG.linear() = rotationToZ((from - to) / length);
        X_BG.translation() = 0.5 * (from + to);
        const double radius = size->front();
        *size = type == "capsule" || type == "cylinder" ? std::vector{radius, 0.5 * length}
                                                        : std::vector{radius, radius, 0.5 * length};
    }
    else
    {
        X_BG = element.pose();
    }
    const std::vector<double>& s = *size;
    TriangleMesh mesh = type == "sphere"     ? sphereMesh(s[0])
                        : type == "capsule"  ? capsuleMesh(s[0], 2.0 * s[1])
                        : type == "cylinder" ? cylinderMesh(s[0], 2.0 * s[1])
                        : type == "box"      ? makeBox({s[0], s[1], s[2]})
                                             : ellipsoidMesh({s[0], s[1], s[2]});
    transformMesh(mesh, Eigen::Affine3d(X_BG));
    return mesh;
}

std::optional<MjcfGeom> MjcfGeometry::geom(const MjcfElement& element)
{
    static const std::set<std::string> kPrimitives = {
        "sphere", "capsule", "cylinder", "box", "ellipsoid"};
    MjcfGeom geom;
    geom.collides = element.number("contype").value_or(1.0) != 0.0 ||
                    element.number("conaffinity").value_or(1.0) != 0.0;
    const std::string type = element.text("type").value_or("sphere");
    const bool hasMesh = element.text("mesh").has_value();
    if (hasMesh && kPrimitives.contains(type))
    {
        m_document.leftOut(element.xml(),
                           "fitting of a " + type + " to a mesh (the mesh itself is taken)");
    }
    if (hasMesh || type == "mesh")
    {
        try
        {
            geom.mesh = asset(element);
        }
        catch (const std::runtime_error&)
        {
            if (geom.collides)
            {
                throw;
            }
            return std::nullopt;
        }
        transformMesh(geom.mesh, Eigen::Affine3d(element.pose()));
    }
    else if (kPrimitives.contains(type))
    {
        geom.mesh = primitive(element, type);
    }
    else if (type != "plane" && type != "hfield" && type != "sdf")
    {
        throw std::runtime_error(element.where() + ": type=\"" + type +
                                 "\" is no type of a geom: write sphere, capsule, cylinder, box, "
                                 "ellipsoid or mesh");
    }
    else
    {
        m_document.leftOut(element.xml(), "geom of type " + type);
        return std::nullopt;
    }
    requireFiniteMesh(geom.mesh, element.where());
    constexpr double kDensity = 1000.0;
    geom.mass = element.number("mass").value_or(element.number("density").value_or(kDensity) *
                                                massProperties(geom.mesh).volume);
    return geom;
}
}  // namespace bullet_ccd
