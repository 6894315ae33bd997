#include "grasp/report/raster.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
/// Faces that meet at less than this angle are shaded as one smooth surface.
constexpr float kCreaseCosine = 0.8F;

const Eigen::Vector3f kKeyLight = Eigen::Vector3f(-0.42F, 0.62F, 0.66F).normalized();
const Eigen::Vector3f kFillLight = Eigen::Vector3f(0.75F, 0.05F, 0.45F).normalized();
const Eigen::Vector3f kSheenNormal = (kKeyLight + Eigen::Vector3f::UnitZ()).normalized();

float squared(float x)
{
    return x * x;
}

/// Light from the upper left, a fill from the right, and a sheen; the normal is in camera axes.
Color shade(const Color& color, Eigen::Vector3f normal)
{
    const float length = normal.norm();
    normal = length > 0.0F ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
    const float diffuse = 0.36F + 0.08F * normal.y() +
                          0.56F * std::max(0.0F, normal.dot(kKeyLight)) +
                          0.16F * std::max(0.0F, normal.dot(kFillLight));
    const float gloss = std::max(0.0F, normal.dot(kSheenNormal));
    const float sheen = 0.10F * squared(squared(squared(squared(squared(gloss)))));
    return (diffuse * color + Color::Constant(sheen)).cwiseMin(1.0F);
}

double edgeFunction(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double x, double y)
{
    return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

/// Pixel centres in [low, high], cut to [0, size).
std::array<int, 2> pixelRange(double low, double high, int size)
{
    return {static_cast<int>(std::ceil(std::clamp(low - 0.5, 0.0, 1.0 * size))),
            static_cast<int>(std::floor(std::clamp(high - 0.5, -1.0, size - 1.0)))};
}

void drawTriangle(Layer& layer,
                  const std::array<Eigen::Vector3d, 3>& p,
                  const std::array<Eigen::Vector3f, 3>& normals,
                  const Shape& shape)
{
    const double area = edgeFunction(p[0], p[1], p[2].x(), p[2].y());
    if (area == 0.0)
    {
        return;
    }
    const auto [xLow, xHigh] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
    const auto [yLow, yHigh] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
    const auto [xFirst, xLast] = pixelRange(xLow, xHigh, layer.width);
    const auto [yFirst, yLast] = pixelRange(yLow, yHigh, layer.height);
    // Barycentric coordinates are linear along a row.
    const double aStep = (p[1].y() - p[2].y()) / area;
    const double bStep = (p[2].y() - p[0].y()) / area;
    for (int y = yFirst; y <= yLast; ++y)
    {
        const double aStart = edgeFunction(p[1], p[2], 0.5, y + 0.5) / area;
        const double bStart = edgeFunction(p[2], p[0], 0.5, y + 0.5) / area;
        for (int x = xFirst; x <= xLast; ++x)
        {
            const double a = aStart + x * aStep;
            const double b = bStart + x * bStep;
            const double c = 1.0 - a - b;
            if (a < 0.0 || b < 0.0 || c < 0.0)
            {
                continue;
            }
            const auto depth = static_cast<float>(a * p[0].z() + b * p[1].z() + c * p[2].z());
            const std::size_t pixel = layer.at(x, y);
            if (depth < layer.depth[pixel])
            {
                layer.depth[pixel] = depth;
                layer.id[pixel] = shape.id;
                layer.color[pixel] =
                    shade(shape.color,
                          static_cast<float>(a) * normals[0] + static_cast<float>(b) * normals[1] +
                              static_cast<float>(c) * normals[2]);
            }
        }
    }
}
/// Corner by corner the mean, weighted by area, of the faces around it that meet smoothly.
std::vector<std::array<Eigen::Vector3f, 3>> cornerNormals(const Shape& shape)
{
    std::vector<Eigen::Vector3f> faces;  // length: twice the area
    std::vector<std::vector<std::size_t>> facesAround(shape.vertices.size());
    for (const Triangle& t : shape.triangles)
    {
        const Eigen::Vector3d& a = shape.vertices[static_cast<std::size_t>(t[0])];
        const Eigen::Vector3d& b = shape.vertices[static_cast<std::size_t>(t[1])];
        const Eigen::Vector3d& c = shape.vertices[static_cast<std::size_t>(t[2])];
        for (const std::int32_t corner : t)
        {
            facesAround[static_cast<std::size_t>(corner)].push_back(faces.size());
        }
        faces.push_back((b - a).cross(c - a).cast<float>());
    }
    std::vector<std::array<Eigen::Vector3f, 3>> normals(faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i)
    {
        for (std::size_t k = 0; k < 3; ++k)
        {
            Eigen::Vector3f sum = Eigen::Vector3f::Zero();
            for (const std::size_t j : facesAround[static_cast<std::size_t>(shape.triangles[i][k])])
            {
                const bool smooth =
                    faces[i].dot(faces[j]) > kCreaseCosine * faces[i].norm() * faces[j].norm();
                sum += smooth || i == j ? faces[j] : Eigen::Vector3f(Eigen::Vector3f::Zero());
            }
            normals[i][k] = sum.normalized();
        }
    }
    return normals;
}
}  // namespace

Eigen::Matrix3d lookFrom(const Eigen::Vector3d& direction, const Eigen::Vector3d& up)
{
    Eigen::Vector3d right = up.cross(direction);
    right = right.norm() > 1e-6 ? right.normalized() : direction.unitOrthogonal();
    Eigen::Matrix3d rows;
    rows << right.transpose(), direction.cross(right).transpose(), direction.transpose();
    return rows;
}

Shape makeShape(const TriangleMesh& mesh, const Eigen::Isometry3d& pose)
{
    Shape shape;
    shape.triangles = mesh.triangles;
    shape.vertices.reserve(mesh.vertices.size());
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        shape.vertices.emplace_back(pose * vertex);
    }
    shape.normals = cornerNormals(shape);
    return shape;
}

void drawShape(Layer& layer, const Camera& camera, const Shape& shape)
{
    const Eigen::Matrix3f R_CW = camera.R_CW.cast<float>();
    std::vector<Eigen::Vector3d> projected;
    projected.reserve(shape.vertices.size());
    for (const Eigen::Vector3d& vertex : shape.vertices)
    {
        projected.push_back(camera.project(vertex));
    }
    for (std::size_t i = 0; i < shape.triangles.size(); ++i)
    {
        const Triangle& t = shape.triangles[i];
        const std::array<Eigen::Vector3f, 3>& normals = shape.normals[i];
        const Eigen::Vector3f mean = R_CW * (normals[0] + normals[1] + normals[2]);
        // Seen from behind: open surfaces have two sides.
        const float side = mean.z() < 0.0F ? -1.0F : 1.0F;
        drawTriangle(
            layer,
            {projected[static_cast<std::size_t>(t[0])],
             projected[static_cast<std::size_t>(t[1])],
             projected[static_cast<std::size_t>(t[2])]},
            {side * (R_CW * normals[0]), side * (R_CW * normals[1]), side * (R_CW * normals[2])},
            shape);
    }
}
}  // namespace bullet_ccd::grasp
