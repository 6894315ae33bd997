#include "grasp/approach/approach_aim.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// On cosines: faces at exactly the largest tilt count as within it.
constexpr double kSlack = 1e-9;

/// Draws of a pinch, of which the best is taken.
constexpr int kPinchTries = 16;
/// Cosine of the angle between the faces of a pinch: 20 degrees.
constexpr double kSquareEnough = 0.94;
constexpr double kOffSurface = 1e-6;  // where rays begin behind it [m]
constexpr double kFinger = 6e-3;      // from the surface, where a finger has its middle [m]

struct RayHit
{
    double way = std::numeric_limits<double>::infinity();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // by which the triangle is wound
};

/// The first triangle on a ray (Moeller and Trumbore 1997).
RayHit nearestHit(const SsvTree& tree, const Eigen::Vector3d& from, const Eigen::Vector3d& along)
{
    RayHit hit;
    const TriangleMesh& mesh = tree.mesh();
    for (const std::int32_t index : trianglesNearLine(tree, from, along))
    {
        const Triangle& triangle = mesh.triangles[static_cast<std::size_t>(index)];
        const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(triangle[0])];
        const Eigen::Vector3d u = mesh.vertices[static_cast<std::size_t>(triangle[1])] - a;
        const Eigen::Vector3d v = mesh.vertices[static_cast<std::size_t>(triangle[2])] - a;
        const Eigen::Vector3d p = along.cross(v);
        const double volume = u.dot(p);
        if (volume == 0.0)
        {
            continue;
        }
        const Eigen::Vector3d s = from - a;
        const double x = s.dot(p) / volume;
        const Eigen::Vector3d q = s.cross(u);
        const double y = along.dot(q) / volume;
        const double way = v.dot(q) / volume;
        if (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && way > 0.0 && way < hit.way)
        {
            hit = {.way = way, .normal = u.cross(v).normalized()};
        }
    }
    return hit;
}

/// True if an approach against `normal` keeps to the tilt.
bool isWithinTilt(const Eigen::Vector3d& normal, const ApproachOptions& options)
{
    return !options.tableTop ||
           normal.dot(options.up.normalized()) >= std::cos(options.maxTilt) - kSlack;
}

/// Twice the area times the unit normal.
Eigen::Vector3d doubleArea(const TriangleMesh& mesh, std::size_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    const auto vertex = [&](int k) -> const Eigen::Vector3d&
    { return mesh.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
    return (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0));
}

/// Twice the areas of the triangles that may be approached; of all if there are none.
std::vector<double> approachableAreas(const TriangleMesh& mesh, const ApproachOptions& options)
{
    std::vector<double> all;
    std::vector<double> within;
    double sum = 0.0;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
    {
        const Eigen::Vector3d normal = doubleArea(mesh, k);
        const double area = normal.norm();
        all.push_back(area);
        within.push_back(area > 0.0 && isWithinTilt(normal / area, options) ? area : 0.0);
        sum += within.back();
    }
    return sum > 0.0 ? within : all;
}

/// Index with probability by weight.
std::size_t drawIndex(const std::vector<double>& weights, Draws& draws)
{
    double sum = 0.0;
    for (const double weight : weights)
    {
        sum += weight;
    }
    require(sum > 0.0, "sampleApproach: the object's surface has no area");
    double left = draws.unit() * sum;
    std::size_t last = 0;
    for (std::size_t k = 0; k < weights.size(); ++k)
    {
        if (weights[k] > 0.0)
        {
            last = k;
            left -= weights[k];
            if (left < 0.0)
            {
                break;
            }
        }
    }
    return last;
}

/// A point of a triangle that is drawn with probability by weight, and the direction against its
/// normal.
ApproachAim surfaceAim(const TriangleMesh& mesh, const std::vector<double>& weights, Draws& draws)
{
    const std::size_t index = drawIndex(weights, draws);
    const Triangle& triangle = mesh.triangles[index];
    // The square root makes the share of each strip along the side opposite to a its area.
    const double fromA = std::sqrt(draws.unit());
    const double toC = draws.unit();
    const std::array shares{1.0 - fromA, fromA * (1.0 - toC), fromA * toC};
    ApproachAim aim{.direction = -doubleArea(mesh, index).normalized()};
    for (std::size_t k = 0; k < 3; ++k)
    {
        aim.point += shares[k] * mesh.vertices[static_cast<std::size_t>(triangle[k])];
    }
    return aim;
}

double fraction(double x)
{
    return x - std::floor(x);
}

/// A side of the box: its principal axis, and whether at its upper end.
struct Face
{
    int axis = 0;
    bool upper = false;

    [[nodiscard]] Eigen::Vector3d normal(const ObjectShape& shape) const
    {
        return upper ? Eigen::Vector3d(shape.axes.col(axis))
                     : Eigen::Vector3d(-shape.axes.col(axis));
    }
};

std::vector<Face> approachableFaces(const ObjectShape& shape, const ApproachOptions& options)
{
    std::vector<Face> faces;
    Face uppermost;
    for (int k = 0; k < 6; ++k)
    {
        const Face face{.axis = k / 2, .upper = k % 2 == 0};
        if (isWithinTilt(face.normal(shape), options))
        {
            faces.push_back(face);
        }
        uppermost = face.normal(shape).dot(options.up) > uppermost.normal(shape).dot(options.up)
                        ? face
                        : uppermost;
    }
    return faces.empty() ? std::vector<Face>{uppermost} : faces;
}

/// Where the roll of frames with this z axis is zero.
Eigen::Matrix3d withoutRoll(const Eigen::Vector3d& z, const ApproachOptions& options)
{
    const Eigen::Vector3d up = options.up.normalized();
    const Eigen::Vector3d level = up.cross(z);
    const bool isSteep = level.norm() < std::sin(kSteep);
    // So that steep directions keep away from the axis that roll is measured from.
    const bool xIsUp = std::abs(up.x()) > std::cos(2.0 * kSteep);
    const Eigen::Vector3d across = xIsUp ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
    return frameFrom(z, isSteep ? across : level);
}
}  // namespace

const char* toString(ApproachSource source)
{
    switch (source)
    {
        case ApproachSource::Sphere:
            return "sphere";
        case ApproachSource::Surface:
            return "surface";
        case ApproachSource::Boxes:
            return "boxes";
        case ApproachSource::Pinch:
            return "pinch";
        case ApproachSource::Mixed:
            return "mixed";
    }
    BULLET_CCD_ASSERT(false);
    return "unknown";
}

void checkApproachOptions(const ApproachOptions& options)
{
    require(options.up.allFinite() && options.up.norm() > 1e-9,
            "approach: up must be finite and not zero");
    require(options.maxTilt >= 0.0 && options.maxTilt <= std::numbers::pi,
            "approach: the largest tilt must be from 0 to pi");
    require(options.standoff >= 0.0 && std::isfinite(options.standoff),
            "approach: the standoff must not be negative");
    require(options.reach >= 0.0 && std::isfinite(options.reach),
            "approach: the reach must not be negative");
    require(!options.roll || options.roll->from <= options.roll->to,
            "approach: the roll must begin at the smaller angle");
}

ApproachAim surfaceAim(const GraspObject& object, const ApproachOptions& options, Draws& draws)
{
    const TriangleMesh& mesh = object.tree.mesh();
    return surfaceAim(mesh, approachableAreas(mesh, options), draws);
}

ApproachAim boxAim(const GraspObject& object,
                   const ObjectShape& shape,
                   const ApproachOptions& options,
                   std::int64_t number,
                   Draws& sequence)
{
    const std::vector<Face> faces = approachableFaces(shape, options);
    const auto count = static_cast<std::int64_t>(faces.size());
    const Face face = faces[static_cast<std::size_t>(number % count)];
    // Additive recurrence with the powers of the plastic number, the root of x^3 = x + 1: any first
    // n points are spread evenly (Roberts 2018).
    constexpr double kPlastic = 1.3247179572447460;
    const auto place = static_cast<double>(number / count);
    const double first = fraction(sequence.unit() + place / kPlastic);
    const double second = fraction(sequence.unit() + place / (kPlastic * kPlastic));
    const int longer = face.axis == 0 ? 1 : 0;  // axes are sorted, the longest first
    const int shorter = face.axis == 2 ? 1 : 2;
    Eigen::Vector3d along;
    along[face.axis] = face.upper ? shape.upper[face.axis] : shape.lower[face.axis];
    along[longer] = shape.lower[longer] + first * shape.extents()[longer];
    along[shorter] = shape.lower[shorter] + second * shape.extents()[shorter];
    return {.point = object.centerOfMass + shape.axes * along,
            .direction = -face.normal(shape),
            .opposition = shape.axes.col(shorter)};
}

ApproachAim pinchAim(const GraspObject& object,
                     double opening,
                     const ApproachOptions& options,
                     Draws& draws)
{
    ApproachOptions anywhere = options;
    anywhere.tableTop = false;
    const std::vector<double> areas = approachableAreas(object.tree.mesh(), anywhere);
    ApproachAim best;
    double bestCost = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < kPinchTries; ++attempt)
    {
        ApproachAim aim = surfaceAim(object.tree.mesh(), areas, draws);
        const Eigen::Vector3d first = aim.point;
        const Eigen::Vector3d inwards = aim.direction;
        const double turn = 2.0 * std::numbers::pi * draws.unit();
        const RayHit exit = nearestHit(object.tree, first + kOffSurface * inwards, inwards);
        const double width = exit.way + kOffSurface;
        const bool isSquare = exit.normal.dot(inwards) >= kSquareEnough;
        aim.opposition = isSquare ? (inwards + exit.normal).normalized() : inwards;
        const Eigen::Vector3d across = aim.opposition.unitOrthogonal();
        aim.direction = std::cos(turn) * across + std::sin(turn) * aim.opposition.cross(across);
        if (options.tableTop && aim.direction.dot(options.up) > 0.0)
        {
            aim.direction = -aim.direction;
        }
        double itsCost = 0.0;
        if (!isSquare || width > opening || !isWithinTilt(-aim.direction, options))
        {
            itsCost = 10.0;
        }
        else
        {
            const Eigen::Vector3d second = first + width * inwards;
            aim.point = 0.5 * (first + second);
            for (const Eigen::Vector3d& beside : {Eigen::Vector3d(first - kFinger * inwards),
                                                  Eigen::Vector3d(second + kFinger * inwards)})
            {
                itsCost +=
                    std::isfinite(nearestHit(object.tree, beside, -aim.direction).way) ? 1.0 : 0.0;
            }
            itsCost += 0.5 * (aim.point - object.centerOfMass).norm() / object.radius;
        }
        if (itsCost < bestCost || attempt == 0)
        {
            best = aim;
            bestCost = itsCost;
        }
    }
    return best;
}

Eigen::Vector3d middleOnLine(const GraspObject& object,
                             const Eigen::Vector3d& point,
                             const Eigen::Vector3d& direction)
{
    // localWidth() measures along x.
    const Eigen::Vector3d across = direction.unitOrthogonal();
    Eigen::Isometry3d X_WRay = Eigen::Isometry3d::Identity();
    X_WRay.linear() << direction, across, direction.cross(across);
    X_WRay.translation() = point;
    const LocalWidth local = localWidth(object, X_WRay, 0.0);
    const double depth = local.hits > 0 ? 0.5 * (local.lower + local.upper)
                                        : (object.centerOfMass - point).dot(direction);
    return point + depth * direction;
}

Eigen::Matrix3d frameFrom(const Eigen::Vector3d& z, const Eigen::Vector3d& x)
{
    Eigen::Vector3d across = x - x.dot(z) * z;
    across = across.norm() > 1e-6 ? across.normalized() : z.unitOrthogonal();
    Eigen::Matrix3d rotation;
    rotation << across, z.cross(across), z;
    return rotation;
}

Eigen::Vector3d withinTilt(const Eigen::Vector3d& direction, const ApproachOptions& options)
{
    if (isWithinTilt(-direction, options))
    {
        return direction;
    }
    const Eigen::Vector3d down = -options.up.normalized();
    Eigen::Vector3d across = direction - direction.dot(down) * down;
    across = across.norm() > 1e-6 ? across.normalized() : down.unitOrthogonal();
    return std::cos(options.maxTilt) * down + std::sin(options.maxTilt) * across;
}

Eigen::Matrix3d withinLimits(const Eigen::Matrix3d& frame,
                             const ApproachOptions& options,
                             Draws& draws)
{
    Eigen::Matrix3d limited = frame;
    if (const Eigen::Vector3d z = frame.col(2); !isWithinTilt(-z, options))
    {
        limited = frameFrom(withinTilt(z, options), frame.col(0));
    }
    if (!options.roll)
    {
        return limited;
    }
    const Eigen::Matrix3d level = withoutRoll(limited.col(2), options);
    const double roll =
        std::atan2(level.col(1).dot(limited.col(0)), level.col(0).dot(limited.col(0)));
    const double width = options.roll->to - options.roll->from;
    constexpr double kTurn = 2.0 * std::numbers::pi;
    if (kTurn * fraction((roll - options.roll->from) / kTurn) <= width)
    {
        return limited;
    }
    const double drawn = options.roll->from + width * draws.unit();
    return level * Eigen::AngleAxisd(drawn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}
}  // namespace bullet_ccd::grasp
