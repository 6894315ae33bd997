#include "bullet_ccd/bullet/step/btCcdPairToi.h"

#include "bullet_ccd/bullet/shapes/btCcdShapeParts.h"
#include "bullet_ccd/bullet/shapes/btCcdTiles.h"
#include "bullet_ccd/bullet/step/btCcdManifolds.h"
#include "bullet_ccd/convex/box_separation.h"
#include "bullet_ccd/convex/closest_points.h"
#include "bullet_ccd/convex/convex_toi.h"
#include "bullet_ccd/convex/support.h"
#include "bullet_ccd/distance/tree_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <variant>

using bullet_ccd::BodyPair;
using bullet_ccd::FirstContactResult;
using bullet_ccd::MovingBody;
using bullet_ccd::SsvTree;
using bullet_ccd::ToiOptions;
using bullet_ccd::ToiStatus;

namespace
{
/// Parts of the shell m: where the solver's zone ends, and the width of the target above each end.
constexpr double kSolverZone = 1.0 / 4.0;
constexpr double kTarget = 1.0 / 16.0;
/// Where any gap will do, a pair is stopped between this and the top of the shell's target.
constexpr double kAnyWithin = 3.0 / 8.0;
static_assert(kAnyWithin > kSolverZone + kTarget);
static_assert(btCcdReserveOfMargin == 1.0 - kSolverZone - kTarget);
/// What a pair that is near already keeps of its distance.
constexpr double kCloser = 3.0 / 4.0 - kTarget;
/// One that has kept less than this part of its distance is deep: where it is stopped now, it may
/// lose no more unseen (btCcdTracker::kUnseen).
constexpr double kDeep = 3.0 / 4.0;
static_assert(kDeep * kCloser > 0.5);
/// It does not move on once it is this near, relative to where it began to count as near: below,
/// single-precision coordinates no longer tell the sides apart, and queries take long in either.
constexpr double kSmallestGap = 1.0 / 32.0;
/// Surfaces that are nearer than this, relative to the same, have no direction in which they could
/// part: they count as intersecting, as they do for contacts.
constexpr double kTouching = 1e-9;

/// A query gives up after so many pairs of nodes and triangles, which takes a second at most: links
/// that turn very often in a step come near something very often, and each of their poses costs.
constexpr std::int64_t kMostIterations = 1'000'000;
constexpr std::int64_t kMostIterationsOfLinks = 50'000;

/// Two parts and how they move.
struct Parts
{
    const btCcdShapePart& m_a;
    const btCcdObjectMotion& m_motionA;
    const btCcdShapePart& m_b;
    const btCcdObjectMotion& m_motionB;
    Eigen::Isometry3d X_AG;  // the mesh of either in its shape's frame
    Eigen::Isometry3d X_BG;
    Eigen::Isometry3d X_WA;  // and where that begins
    Eigen::Isometry3d X_WB;
    bool& m_isDeep;  // see btCcdPairToi
    const Eigen::Vector3d& m_wayOut;
    bool m_isWholly = false;                                  // inside: see btCcdTimeOfImpact()
    bool m_anyWithin = false;                                 // same
    double m_least = 0.0;                                     // same
    double m_most = std::numeric_limits<double>::infinity();  // same
};

/// The surface of a part, or its core.
struct Layer
{
    const SsvTree& m_tree;
    double m_radius;
    const btCcdExactShape* m_exact;  // null: only the hierarchy is known
};

Layer surfaceOf(const btCcdShapePart& part)
{
    return {*part.m_tree, part.m_radius, part.m_exact ? &*part.m_exact : nullptr};
}

/// The surface of what has no core.
Layer coreOf(const btCcdShapePart& part)
{
    return part.m_core == nullptr ? surfaceOf(part)
                                  : Layer{*part.m_core,
                                          part.m_coreRadius,
                                          part.m_exactCore ? &*part.m_exactCore : nullptr};
}

/// Null for links, and where the exact shape is not known.
const bullet_ccd::RigidMotion* exactMotionOf(const btCcdObjectMotion& motion, const Layer& layer)
{
    return layer.m_exact != nullptr ? std::get_if<bullet_ccd::RigidMotion>(&motion.m_motion)
                                    : nullptr;
}

FirstContactResult overlapping()
{
    FirstContactResult overlap;
    overlap.status = ToiStatus::Overlapping;
    overlap.time = 0.0;
    return overlap;
}

/// As firstContact() has it, but solid. The points are those of the hierarchies.
FirstContactResult askExact(const bullet_ccd::ConvexBody& a,
                            const bullet_ccd::ConvexBody& b,
                            const ToiOptions& options)
{
    FirstContactResult first;
    static_cast<bullet_ccd::ToiResult&>(first) = bullet_ccd::convexToi(a, b, options);
    first.startsPressing = first.status == ToiStatus::TouchingPressing;
    first.startsTouching = first.startsPressing || first.status == ToiStatus::TouchingLeaving;
    first.mayStartTouching = first.status != ToiStatus::Separated;
    if (first.startsTouching)
    {
        first.status = first.startsPressing ? ToiStatus::Hit : ToiStatus::Separated;
    }
    first.pointA -= a.shape->radius * first.normal;
    first.pointB += b.shape->radius * first.normal;
    return first;
}

struct Answer : FirstContactResult
{
    bool m_isSolid = false;  // what begins inside the other overlaps
};

/// Queries are asked on several threads.
bullet_ccd::ToiWorkspace& workspace()
{
    thread_local bullet_ccd::ToiWorkspace mine;
    return mine;
}

/// @param separation beyond the radii
Answer ask(const Parts& parts,
           const Layer& a,
           const Layer& b,
           double separation,
           double tolerance,
           bool anyWithin = false)
{
    ToiOptions options{.tolerance = tolerance,
                       .minimumSeparation = separation,
                       .aim = 0.5,
                       .anyWithin = anyWithin};
    const bullet_ccd::RigidMotion* motionA = exactMotionOf(parts.m_motionA, a);
    const bullet_ccd::RigidMotion* motionB = exactMotionOf(parts.m_motionB, b);
    if (motionA != nullptr && motionB != nullptr)
    {
        const FirstContactResult first = askExact(
            {&a.m_exact->m_shape, *motionA, parts.m_motionA.X_BS * parts.X_AG * a.m_exact->X_GE},
            {&b.m_exact->m_shape, *motionB, parts.m_motionB.X_BS * parts.X_BG * b.m_exact->X_GE},
            options);
        if (!gaveUp(first.status))
        {
            return {first, true};
        }
    }
    options.minimumSeparation += a.m_radius + b.m_radius;
    const auto isLink = [](const btCcdObjectMotion& motion)
    { return !std::holds_alternative<bullet_ccd::RigidMotion>(motion.m_motion); };
    options.maxIterations = isLink(parts.m_motionA) || isLink(parts.m_motionB)
                                ? kMostIterationsOfLinks
                                : kMostIterations;
    const std::array<MovingBody, 2> bodies{parts.m_motionA.body(a.m_tree, parts.X_AG),
                                           parts.m_motionB.body(b.m_tree, parts.X_BG)};
    const std::array<BodyPair, 1> pairs{BodyPair{0, 1}};
    return {bullet_ccd::firstContact(bodies, pairs, options, workspace())};
}

/// Two exact shapes where they begin, A's in the frame of B's.
bullet_ccd::Placement exactPlacement(const Parts& parts, const Layer& a, const Layer& b)
{
    const Eigen::Isometry3d X_WA = parts.X_WA * a.m_exact->X_GE;
    const Eigen::Isometry3d X_WB = parts.X_WB * b.m_exact->X_GE;
    const Eigen::Matrix3d R_BW = X_WB.linear().transpose();
    return {R_BW * X_WA.linear(), R_BW * (X_WA.translation() - X_WB.translation())};
}

/// Distance of two exact cores, or something not below `bound` if they are that far apart. Of
/// boxes, features that face each other tell.
double exactDistance(const bullet_ccd::ConvexShape& a,
                     const bullet_ccd::ConvexShape& b,
                     const bullet_ccd::Placement& pose,
                     double bound)
{
    if (a.core == bullet_ccd::ConvexCore::Box && b.core == bullet_ccd::ConvexCore::Box)
    {
        const bullet_ccd::BoxAxis axis = bullet_ccd::bestBoxAxis(a.half, b.half, pose);
        bullet_ccd::ClosestPoints closest;
        if (axis.gap > 0.0 &&
            (axis.gap >= bound || bullet_ccd::facingPoints(a.half, b.half, pose, axis, closest)))
        {
            return axis.gap;
        }
    }
    bullet_ccd::Simplex simplex;
    return bullet_ccd::closestPoints(a, b, pose, bound, false, simplex).distance;
}

/// Distance beyond the radii at the start if it is below `bound`, else `bound`.
double distanceAtStart(const Parts& parts, const Layer& a, const Layer& b, double bound)
{
    const double radii = a.m_radius + b.m_radius;
    if (a.m_exact != nullptr && b.m_exact != nullptr)
    {
        return std::min(exactDistance(a.m_exact->m_shape,
                                      b.m_exact->m_shape,
                                      exactPlacement(parts, a, b),
                                      radii + bound) -
                            radii,
                        bound);
    }
    const Eigen::Isometry3d X_BA = parts.X_WB.inverse() * parts.X_WA;
    const bullet_ccd::TrianglePair nearest =
        bullet_ccd::treeDistance(a.m_tree, b.m_tree, X_BA, radii + bound);
    // Of the bound alone the radii would leave a little less than it.
    return nearest.triangleA == bullet_ccd::kNone ? bound : nearest.distance - radii;
}

/// Whether the normal of a later contact shows that two exact shapes begin farther apart.
bool beginsBeyond(const Parts& parts,
                  const Layer& a,
                  const Layer& b,
                  const Eigen::Vector3d& normal,
                  double distance)
{
    if (a.m_exact == nullptr || b.m_exact == nullptr)
    {
        return false;
    }
    const bullet_ccd::Placement pose = exactPlacement(parts, a, b);
    const Eigen::Vector3d n =
        b.m_exact->X_GE.linear().transpose() * (parts.X_WB.linear().transpose() * normal);
    const double gap = -n.dot(pose.p) -
                       bullet_ccd::supportHeight(a.m_exact->m_shape, pose.R.transpose() * n) -
                       bullet_ccd::supportHeight(b.m_exact->m_shape, -n) - a.m_radius - b.m_radius;
    return gap > distance;
}

/// True if the query began within the distance `reach` beyond the radii that it was to find.
bool startsWithin(const Parts& parts, const FirstContactResult& first, double reach)
{
    if (first.status == ToiStatus::Overlapping || first.startsTouching || !first.mayStartTouching)
    {
        return first.status == ToiStatus::Overlapping || first.startsTouching;
    }
    // The query did not find out.
    if (parts.m_least > reach || parts.m_most < reach)
    {
        return parts.m_most < reach;
    }
    const Layer a = surfaceOf(parts.m_a);
    const Layer b = surfaceOf(parts.m_b);
    return !beginsBeyond(parts, a, b, first.normal, reach) &&
           distanceAtStart(parts, a, b, reach) < reach;
}

/// For a pair that is near already: it may lose a quarter of its distance (of `most` at most). One
/// that has lost nearly all of it does not approach any more.
FirstContactResult askCloser(const Parts& parts, const Layer& a, const Layer& b, double most)
{
    const double distance = distanceAtStart(parts, a, b, most);
    if (!(distance > kTouching * most))
    {
        return overlapping();
    }
    parts.m_isDeep = parts.m_isDeep || distance < kDeep * most;
    FirstContactResult first = ask(parts, a, b, kCloser * distance, kTarget * distance);
    if (first.status == ToiStatus::Hit && distance < kSmallestGap * most)
    {
        first.time = 0.0;
    }
    return first;
}

double marginsOf(const btCcdShapePart& a, const btCcdShapePart& b)
{
    return a.m_margin + b.m_margin;
}

double shellOf(const Parts& parts)
{
    const double margins = marginsOf(parts.m_a, parts.m_b);
    return margins > 0.0 ? margins : btCcdManifolds::kLeastShell;
}

/// The contacts are ours: zones of the shell.
FirstContactResult askShell(const Parts& parts)
{
    const Layer a = surfaceOf(parts.m_a);
    const Layer b = surfaceOf(parts.m_b);
    const double shell = shellOf(parts);
    const auto zone = [&](double floor, double width, bool anyWithin)
    { return ask(parts, a, b, floor * shell, width * shell, anyWithin); };

    const double floor = parts.m_anyWithin ? kAnyWithin : 1.0;
    const double top = 1.0 + kTarget;
    FirstContactResult first;
    if (parts.m_most < top * shell ||
        startsWithin(parts, first = zone(floor, top - floor, parts.m_anyWithin), top * shell))
    {
        first = zone(kSolverZone, kTarget, false);
    }
    if (startsWithin(parts, first, (kSolverZone + kTarget) * shell))
    {
        first = askCloser(parts, a, b, (kSolverZone + kTarget) * shell);
    }
    return first;
}

/// The same; and what is inside comes no deeper: where A is moved out of B, the two meet.
FirstContactResult askDeeper(const Parts& parts)
{
    const FirstContactResult known =
        parts.m_isWholly && !parts.m_wayOut.isZero() ? overlapping() : askShell(parts);
    const bool movesA = std::holds_alternative<bullet_ccd::RigidMotion>(parts.m_motionA.m_motion);
    btCcdObjectMotion moved = movesA ? parts.m_motionA : parts.m_motionB;
    auto* motion = std::get_if<bullet_ccd::RigidMotion>(&moved.m_motion);
    if (known.status != ToiStatus::Overlapping || parts.m_wayOut.isZero() || motion == nullptr)
    {
        return known;
    }
    const Eigen::Vector3d way = movesA ? -parts.m_wayOut : parts.m_wayOut;
    motion->X_W0.translation() += way;
    Eigen::Isometry3d X_WA = parts.X_WA;
    Eigen::Isometry3d X_WB = parts.X_WB;
    (movesA ? X_WA : X_WB).translation() += way;
    FirstContactResult deeper = askShell({parts.m_a,
                                          movesA ? moved : parts.m_motionA,
                                          parts.m_b,
                                          movesA ? parts.m_motionB : moved,
                                          parts.X_AG,
                                          parts.X_BG,
                                          X_WA,
                                          X_WB,
                                          parts.m_isDeep,
                                          parts.m_wayOut});
    (movesA ? deeper.pointA : deeper.pointB) -= way;
    return deeper.status == ToiStatus::Hit ? deeper : overlapping();
}

/// True if a corner of the first is inside the second, a convex polyhedron.
bool isCornerInside(const SsvTree& tree, const Eigen::Isometry3d& X_OT, const SsvTree& outer)
{
    const bullet_ccd::TriangleMesh& mesh = outer.mesh();
    if (mesh.triangles.size() < 4)
    {
        return false;  // a point or a segment
    }
    const Eigen::Vector3d corner = X_OT * tree.mesh().vertices.front();
    bool isBelow = true;
    bool isAbove = true;
    for (std::size_t i = 0; i < mesh.triangles.size() && (isBelow || isAbove); ++i)
    {
        const auto vertex = [&](std::size_t k) -> const Eigen::Vector3d&
        { return mesh.vertices[std::size_t(mesh.triangles[i][k])]; };
        const Eigen::Vector3d normal = (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0));
        const double side = normal.dot(corner - vertex(0));
        isBelow = isBelow && side < 0.0;
        isAbove = isAbove && side > 0.0;
    }
    return isBelow || isAbove;
}

/// True if one is a plane, which is solid below, and the other, or its core, begins there.
bool startsBelowPlane(const Parts& parts)
{
    const auto isBelow = [](const btCcdShapePart& plane,
                            const Eigen::Isometry3d& X_WP,
                            const btCcdShapePart& other,
                            const Eigen::Isometry3d& X_WO)
    {
        const Eigen::Vector3d& vertex = coreOf(other).m_tree.mesh().vertices.front();
        return plane.m_isPlane &&
               X_WP.linear().col(2).dot(X_WO * vertex - X_WP.translation()) < 0.0;
    };
    return isBelow(parts.m_a, parts.X_WA, parts.m_b, parts.X_WB) ||
           isBelow(parts.m_b, parts.X_WB, parts.m_a, parts.X_WA);
}

/// True if one part begins wholly below the surface of the other, or of its core: surfaces are far
/// from each other then.
bool startsInside(const Parts& parts, bool cores)
{
    const auto tree = [cores](const btCcdShapePart& part) -> const SsvTree&
    { return cores ? coreOf(part).m_tree : *part.m_tree; };
    const Eigen::Isometry3d X_BA = parts.X_WB.inverse() * parts.X_WA;
    return (parts.m_b.m_core != nullptr &&
            isCornerInside(tree(parts.m_a), X_BA, tree(parts.m_b))) ||
           (parts.m_a.m_core != nullptr &&
            isCornerInside(tree(parts.m_b), X_BA.inverse(), tree(parts.m_a)));
}

/// The contacts are Bullet's: the surfaces, and below them the cores.
FirstContactResult askStock(const Parts& parts, double tolerance)
{
    const Layer surfaceA = surfaceOf(parts.m_a);
    const Layer surfaceB = surfaceOf(parts.m_b);
    // Bullet counts the margin of a mesh as part of it.
    const double margins = marginsOf(parts.m_a, parts.m_b);
    const Answer first = ask(parts, surfaceA, surfaceB, margins, tolerance);
    if (!startsWithin(parts, first, margins + tolerance))
    {
        if (first.m_isSolid || !(startsInside(parts, false) || startsBelowPlane(parts)))
        {
            return first;
        }
        if (startsInside(parts, true))
        {
            return overlapping();
        }
    }
    else if (first.m_isSolid && first.startsTouching && !first.startsPressing &&
             first.status == ToiStatus::Separated)
    {
        return first;  // what stays apart keeps its cores apart
    }
    if (startsBelowPlane(parts))
    {
        return overlapping();
    }
    return askCloser(parts,
                     coreOf(parts.m_a),
                     coreOf(parts.m_b),
                     parts.m_a.m_depth + parts.m_b.m_depth + 2.0 * tolerance);
}

/// The surfaces alone, wherever they touch at the start.
FirstContactResult askTouch(const Parts& parts, double tolerance)
{
    Answer first = ask(parts, surfaceOf(parts.m_a), surfaceOf(parts.m_b), 0.0, tolerance);
    if (startsWithin(parts, first, tolerance) || (!first.m_isSolid && startsInside(parts, false)))
    {
        first.status = ToiStatus::Overlapping;
        first.time = 0.0;
    }
    return first;
}

void take(const FirstContactResult& first, const Parts& parts, btCcdPairToi& result)
{
    if (first.status == ToiStatus::Overlapping && result.m_status == ToiStatus::Separated)
    {
        result.m_status = ToiStatus::Overlapping;
    }
    if ((first.status != ToiStatus::Hit && !gaveUp(first.status)) ||
        first.time >= result.m_fraction)
    {
        return;
    }
    result.m_status = first.status;
    result.m_fraction = first.time;
    result.m_normal = first.normal;
    result.m_pointA = first.pointA + parts.m_a.m_radius * first.normal;
    result.m_pointB = first.pointB - parts.m_b.m_radius * first.normal;
}

/// Pairs of parts of two shapes, the earliest so far.
struct Pairs
{
    const btCcdObjectMotion& m_motionA;
    const btCcdObjectMotion& m_motionB;
    double m_tolerance;
    Eigen::Vector3d m_wayOut = Eigen::Vector3d::Zero();
    bool m_isWholly = false;
    bool m_anyWithin = false;
    double m_least = 0.0;
    double m_most = std::numeric_limits<double>::infinity();
    bool m_isTouch = false;  // see btCcdTimeOfTouch()
    btCcdPairToi m_result{};

    void ask(const btCcdShapePart& a, const btCcdShapePart& b)
    {
        const Eigen::Isometry3d X_WA = btCcdShapePoseAt(m_motionA, 0.0);
        const Eigen::Isometry3d X_WB = btCcdShapePoseAt(m_motionB, 0.0);
        // In the world; only planes ask for them.
        const auto middle = [](const btCcdShapePart& part,
                               const Eigen::Isometry3d& X_WS) -> Eigen::Vector3d
        { return X_WS * (part.X_SG * part.m_tree->origin()); };
        const auto meshPose =
            [&](const btCcdShapePart& part, const Eigen::Isometry3d& X_WS, const auto& other)
        { return part.m_isPlane ? btCcdMeshPose(part, X_WS.inverse() * other()) : part.X_SG; };
        const Eigen::Isometry3d X_AG = meshPose(a, X_WA, [&] { return middle(b, X_WB); });
        const Eigen::Isometry3d X_BG = meshPose(b, X_WB, [&] { return middle(a, X_WA); });
        const Parts parts{a,
                          m_motionA,
                          b,
                          m_motionB,
                          X_AG,
                          X_BG,
                          X_WA * X_AG,
                          X_WB * X_BG,
                          m_result.m_isDeep,
                          m_wayOut,
                          m_isWholly,
                          m_anyWithin,
                          m_least,
                          m_most};
        const FirstContactResult first = m_isTouch                   ? askTouch(parts, m_tolerance)
                                         : btCcdHasOwnContacts(a, b) ? askDeeper(parts)
                                                                     : askStock(parts, m_tolerance);
        if (m_isTouch && first.status == ToiStatus::Overlapping)
        {
            m_result.m_status = ToiStatus::Overlapping;
            m_result.m_fraction = 0.0;
        }
        take(first, parts, m_result);
    }

    /// Of large meshes the pieces that the other comes near to.
    void askPieces(const btCcdShapePart& a, const btCcdShapePart& b)
    {
        const double near = a.m_radius + b.m_radius +
                            2.0 * std::max(marginsOf(a, b), btCcdManifolds::kLeastShell) +
                            4.0 * m_tolerance + m_wayOut.norm();
        const auto pieces = [near](const btCcdShapePart& part,
                                   const btCcdObjectMotion& motion,
                                   const btCcdShapePart& other,
                                   const btCcdObjectMotion& otherMotion)
        {
            std::vector<btCcdShapePart> found;
            const bool isAll = other.m_tiles != nullptr;
            for (const btCcdTiles::Piece* piece : part.m_tiles->near(
                     isAll ? part.m_tiles->box() : pathIn(part, motion, other, otherMotion, near)))
            {
                found.push_back(btCcdPieceOf(part, *piece));
            }
            return found;
        };
        if (a.m_isPlane || b.m_isPlane)
        {
            ask(a.m_isPlane ? wideEnough(a, m_motionA, b, m_motionB, near) : a,
                b.m_isPlane ? wideEnough(b, m_motionB, a, m_motionA, near) : b);
        }
        else if (a.m_tiles == nullptr && b.m_tiles == nullptr)
        {
            ask(a, b);
        }
        else if (a.m_tiles != nullptr)
        {
            for (const btCcdShapePart& piece : pieces(a, m_motionA, b, m_motionB))
            {
                askPieces(piece, b);
            }
        }
        else
        {
            for (const btCcdShapePart& piece : pieces(b, m_motionB, a, m_motionA))
            {
                ask(a, piece);
            }
        }
    }

    /// How another part comes near.
    struct Path
    {
        Eigen::Isometry3d X_WS;     // of the shape that it comes near, at the start
        Eigen::AlignedBox3d m_box;  // in the world, of all points within `near` of it on its way
        double m_way;  // how far points of the shape move that it can meet; may be infinite
    };
    static Path pathNear(const btCcdObjectMotion& motion,
                         const btCcdShapePart& other,
                         const btCcdObjectMotion& otherMotion,
                         double near)
    {
        const btCcdBall ball = btCcdBallOf(other);
        const Eigen::AlignedBox3d box = otherMotion.boxOf(ball.m_center, ball.m_radius + near);
        const Eigen::Isometry3d X_WS = btCcdShapePoseAt(motion, 0.0);
        const double farthest =
            (box.center() - X_WS.translation()).norm() + 0.5 * box.diagonal().norm();
        return {X_WS, box, motion.wayAt(farthest)};
    }

    /// A plane with a piece that the other part does not leave, from above its middle.
    static btCcdShapePart wideEnough(const btCcdShapePart& plane,
                                     const btCcdObjectMotion& motion,
                                     const btCcdShapePart& other,
                                     const btCcdObjectMotion& otherMotion,
                                     double near)
    {
        const Path path = pathNear(motion, other, otherMotion, near);
        const double half = path.m_box.diagonal().norm() + path.m_way;
        btCcdShapePart part = plane;
        part.m_tree = btCcdPlanePiece(std::isfinite(half) ? half : 0.0);
        return part;
    }

    /// A box in the mesh frame of a part that holds all points within `near` of another part, on
    /// its way.
    static Eigen::AlignedBox3d pathIn(const btCcdShapePart& part,
                                      const btCcdObjectMotion& motion,
                                      const btCcdShapePart& other,
                                      const btCcdObjectMotion& otherMotion,
                                      double near)
    {
        const Path path = pathNear(motion, other, otherMotion, near);
        if (!std::isfinite(path.m_way) || !path.m_box.sizes().allFinite())
        {
            return part.m_tiles->box();
        }
        const Eigen::AlignedBox3d box = btCcdBoxIn((path.X_WS * part.X_SG).inverse(), path.m_box);
        const Eigen::Vector3d room = Eigen::Vector3d::Constant(path.m_way);
        return {box.min() - room, box.max() + room};
    }
};

/// As askShell() and askStock() need it, see btCcdReserve().
double reserve(const btCcdShapePart& a, const btCcdShapePart& b)
{
    return btCcdHasOwnContacts(a, b) ? btCcdReserveOfMargin * marginsOf(a, b)
                                     : a.m_depth + b.m_depth;
}
}  // namespace

bool btCcdHasOwnContacts(const btCcdShapePart& a, const btCcdShapePart& b)
{
    return a.m_ownContacts || b.m_ownContacts || (a.m_core == nullptr && b.m_core == nullptr);
}

double btCcdReserve(const btCcdShapeModel& a, const btCcdShapeModel& b)
{
    double smallest = std::numeric_limits<double>::infinity();
    for (const btCcdShapePart& partA : a.m_parts)
    {
        for (const btCcdShapePart& partB : b.m_parts)
        {
            smallest = std::min(smallest, reserve(partA, partB));
        }
    }
    return smallest;
}

namespace
{
btCcdPairToi askAllParts(Pairs pairs, const btCcdSide& a, const btCcdSide& b)
{
    for (const btCcdShapePart& partA : a.m_model.m_parts)
    {
        for (const btCcdShapePart& partB : b.m_model.m_parts)
        {
            pairs.askPieces(partA, partB);
        }
    }
    return pairs.m_result;
}
}  // namespace

btCcdPairToi btCcdTimeOfImpact(const btCcdSide& a,
                               const btCcdSide& b,
                               double tolerance,
                               bool anyWithin,
                               const btCcdKnownOfPair& known)
{
    return askAllParts({a.m_motion,
                        b.m_motion,
                        tolerance,
                        known.m_wayOut,
                        known.m_isWholly,
                        anyWithin,
                        known.m_least,
                        known.m_most},
                       a,
                       b);
}

btCcdPairToi btCcdTimeOfTouch(const btCcdSide& a, const btCcdSide& b, double tolerance)
{
    return askAllParts({.m_motionA = a.m_motion,
                        .m_motionB = b.m_motion,
                        .m_tolerance = tolerance,
                        .m_isTouch = true},
                       a,
                       b);
}
