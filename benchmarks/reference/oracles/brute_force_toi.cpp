#include "benchmarks/reference/oracles/brute_force_toi.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

namespace bullet_ccd::reference
{
namespace
{
constexpr double kFloorStep = 1e-9;
constexpr double kBracket = 1e-15;

/// A triangle at rest in its mesh and a ball about it.
struct TriangleInBall
{
    Corners corners;
    Eigen::Vector3d center;
    double radius = 0.0;
};

std::vector<TriangleInBall> piecesOf(const TriangleMesh& mesh)
{
    std::vector<TriangleInBall> pieces(mesh.triangles.size());
    for (std::size_t i = 0; i < pieces.size(); ++i)
    {
        TriangleInBall& piece = pieces[i];
        piece.corners = cornersOf(mesh, i);
        piece.center = (piece.corners[0] + piece.corners[1] + piece.corners[2]) / 3.0;
        for (const Eigen::Vector3d& corner : piece.corners)
        {
            piece.radius = std::max(piece.radius, (corner - piece.center).norm());
        }
        piece.radius += 1e-14 * (piece.radius + piece.center.norm());
    }
    return pieces;
}

/// One pair of triangles on its way.
struct Pair
{
    std::size_t a = 0;
    std::size_t b = 0;
    double safeUntil = 0.0;  ///< no contact of this pair before, or not looked at before (floor)
    double lastApart = 0.0;
    double floorStep = kFloorStep;
    Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< separates them, in the axes of B

    /// The queue serves the earliest.
    bool operator<(const Pair& other) const { return safeUntil > other.safeUntil; }
};

class March
{
public:
    March(const OracleBody& a, const OracleBody& b, double until)
        : m_a(a), m_b(b), m_until(until), m_piecesA(piecesOf(*a.mesh)), m_piecesB(piecesOf(*b.mesh))
    {
        m_result.low = until;
        for (std::size_t i = 0; i < m_piecesA.size(); ++i)
        {
            for (std::size_t j = 0; j < m_piecesB.size(); ++j)
            {
                m_pairs.push({.a = i, .b = j});
            }
        }
    }

    OracleToi run()
    {
        while (!m_pairs.empty() && m_pairs.top().safeUntil <= m_until && !m_result.contact)
        {
            Pair pair = m_pairs.top();
            m_pairs.pop();
            if (pair.safeUntil != m_time)
            {
                m_time = pair.safeUntil;
                m_pose = relativePose(m_time);
            }
            advance(pair, m_time, m_pose);
            // A pose costs more than a look at what is due soon.
            const double soon = 0.5 * (m_time + pair.safeUntil);
            m_looked.assign(1, pair);
            while (!m_pairs.empty() && m_pairs.top().safeUntil < soon)
            {
                m_looked.push_back(m_pairs.top());
                m_pairs.pop();
                advance(m_looked.back(), m_time, m_pose);
            }
            std::ranges::for_each(m_looked, [this](const Pair& each) { m_pairs.push(each); });
        }
        m_result.low = std::min(m_result.low, m_result.contact.value_or(m_until));
        return m_result;
    }

private:
    [[nodiscard]] Eigen::Isometry3d relativePose(double t) const
    {
        return m_b.poseAt(t).inverse() * m_a.poseAt(t);
    }

    [[nodiscard]] Corners moved(const Pair& pair, const Eigen::Isometry3d& X) const
    {
        const Corners& corners = m_piecesA[pair.a].corners;
        return {X * corners[0], X * corners[1], X * corners[2]};
    }

    [[nodiscard]] double distance(const Pair& pair, const Eigen::Isometry3d& X) const
    {
        return bruteForceTriangleDistance(moved(pair, X), m_piecesB[pair.b].corners).distance;
    }

    /// A gap along a direction, the last one that separated them or that of their closest points,
    /// as long as it is no matter of rounding; else their distance.
    [[nodiscard]] double gapOf(Pair& pair, const Eigen::Isometry3d& X, double size) const
    {
        constexpr double kMuch = 0.2;
        constexpr double kLittle = 1e-6;
        const Corners a = moved(pair, X);
        const Corners& b = m_piecesB[pair.b].corners;
        double gap = gapAlong(pair.across, a, b);
        if (gap < kMuch * size)
        {
            pair.across = directionBetween(a, b);
            gap = gapAlong(pair.across, a, b);
        }
        return gap < kLittle * (size + m_a.speed + m_b.speed) ? distance(pair, X) : gap;
    }

    void advance(Pair& pair, double t, const Eigen::Isometry3d& X)
    {
        const double speed = m_a.speed + m_b.speed;
        const TriangleInBall& a = m_piecesA[pair.a];
        const TriangleInBall& b = m_piecesB[pair.b];
        double gap = (X * a.center - b.center).norm() - a.radius - b.radius;
        // Balls are good enough while they are well apart.
        if (gap < a.radius + b.radius)
        {
            gap = gapOf(pair, X, a.radius + b.radius);
        }
        if (gap == 0.0)
        {
            const double crossing = bisect(pair, t);
            m_result.contact = std::min(m_result.contact.value_or(crossing), crossing);
            return;
        }
        pair.lastApart = t;
        if (speed == 0.0)
        {
            pair.safeUntil = std::numeric_limits<double>::infinity();
        }
        else if (gap / speed >= pair.floorStep)
        {
            pair.safeUntil = std::max(pair.safeUntil, t + gap / speed);
            pair.floorStep = kFloorStep;
        }
        else if (t >= pair.safeUntil)
        {
            m_result.low = std::min(m_result.low, t);
            pair.safeUntil = t < m_until ? std::min(m_until, t + pair.floorStep) : 2.0;
            pair.floorStep *= 2.0;
        }
    }

    /// Crossing in (lastApart, crossed], as narrow as doubles allow.
    [[nodiscard]] double bisect(const Pair& pair, double crossed) const
    {
        double apart = pair.lastApart;
        while (crossed - apart > kBracket)
        {
            const double middle = 0.5 * (apart + crossed);
            if (middle <= apart || middle >= crossed)
            {
                break;
            }
            (distance(pair, relativePose(middle)) > 0.0 ? apart : crossed) = middle;
        }
        return crossed;
    }

    const OracleBody& m_a;
    const OracleBody& m_b;
    double m_until;
    std::vector<TriangleInBall> m_piecesA;
    std::vector<TriangleInBall> m_piecesB;
    std::priority_queue<Pair> m_pairs;
    std::vector<Pair> m_looked;  ///< at one time
    double m_time = -1.0;
    Eigen::Isometry3d m_pose;  ///< at that time
    OracleToi m_result{.low = 1.0, .contact = std::nullopt};
};
}  // namespace

Eigen::Isometry3d oraclePose(const RigidMotion& motion, double t)
{
    Eigen::Isometry3d X = motion.X_W0;
    const double turn = motion.w_W.norm();
    if (turn > 0.0)
    {
        X.linear() = Eigen::AngleAxisd(t * turn, motion.w_W / turn).toRotationMatrix() *
                     motion.X_W0.linear();
    }
    // The reference moves on a straight line, the origin keeps its place relative to it.
    X.translation() = motion.X_W0.translation() + t * motion.v_W +
                      (motion.X_W0.linear() - X.linear()) * motion.reference_B;
    return X;
}

Eigen::Isometry3d oracleLinkPose(const KinematicTree& tree,
                                 const JointMotion& motion,
                                 std::int32_t link,
                                 double t,
                                 std::int32_t base)
{
    if (link == base)
    {
        return Eigen::Isometry3d::Identity();
    }
    const auto index = static_cast<std::size_t>(link);
    const Link& here = tree.links[index];
    if (here.parent == kNone)
    {
        return oraclePose(motion.root, t);
    }
    Eigen::Isometry3d X = oracleLinkPose(tree, motion, here.parent, t, base) * here.X_PL0;
    double q = motion.positions[index] + t * motion.rates[index];
    double power = t;
    for (std::size_t k = 0; !motion.curves.empty() && k < 4; ++k)
    {
        q += motion.curves[index][k] * (power *= t);
    }
    if (here.joint.type == JointType::Revolute)
    {
        X.rotate(Eigen::AngleAxisd(q, here.joint.axis));
    }
    else if (here.joint.type == JointType::Prismatic)
    {
        X.translate(q * here.joint.axis);
    }
    else if (here.joint.type == JointType::Spherical)
    {
        const BallMotion& ball = motion.balls[index];
        if (!ball.rate.isZero(0.0))
        {
            X.rotate(Eigen::AngleAxisd(t * ball.rate.norm(), ball.rate.normalized()));
        }
        X.rotate(ball.start);
    }
    return X;
}

OracleBody oracleBody(const TriangleMesh& mesh, const RigidMotion& motion)
{
    return {.mesh = &mesh,
            .poseAt = [motion](double t) { return oraclePose(motion, t); },
            .speed = motion.v_W.norm() +
                     motion.w_W.norm() * (radiusOf(mesh) + motion.reference_B.norm())};
}

OracleBody oracleLink(const TriangleMesh& mesh,
                      const KinematicTree& tree,
                      const JointMotion& motion,
                      std::int32_t link,
                      std::int32_t base)
{
    double speed = 0.0;
    double reach = radiusOf(mesh);
    for (std::int32_t at = link;
         at != base && tree.links[static_cast<std::size_t>(at)].parent != kNone;
         at = tree.links[static_cast<std::size_t>(at)].parent)
    {
        const auto index = static_cast<std::size_t>(at);
        const Link& here = tree.links[index];
        double rate = std::abs(motion.rates[index]);
        double way = std::abs(motion.positions[index]) + rate;
        for (std::size_t k = 0; !motion.curves.empty() && k < 4; ++k)
        {
            rate += double(k + 2) * std::abs(motion.curves[index][k]);
            way += std::abs(motion.curves[index][k]);
        }
        if (here.joint.type == JointType::Revolute)
        {
            speed += rate * reach;
        }
        else if (here.joint.type == JointType::Spherical)
        {
            speed += motion.balls[index].rate.norm() * reach;
        }
        else if (here.joint.type == JointType::Prismatic)
        {
            speed += rate;
            reach += way;
        }
        reach += here.X_PL0.translation().norm();
    }
    speed += base == kNone ? motion.root.v_W.norm() + motion.root.w_W.norm() * reach : 0.0;
    return {.mesh = &mesh,
            .poseAt = [&tree, &motion, link, base](double t)
            { return oracleLinkPose(tree, motion, link, t, base); },
            .speed = speed};
}

double oracleDistanceAt(const OracleBody& a, const OracleBody& b, double t)
{
    const Eigen::Isometry3d X_BA = b.poseAt(t).inverse() * a.poseAt(t);
    return bruteForceMeshDistance(*a.mesh, *b.mesh, X_BA).distance;
}

OracleToi bruteForceToi(const OracleBody& a, const OracleBody& b, double until)
{
    return March(a, b, until).run();
}
}  // namespace bullet_ccd::reference
