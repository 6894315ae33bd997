#include "grasp/hand/trial_grasps.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "grasp/hand/self_pairs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <tuple>

namespace bullet_ccd::grasp
{
namespace
{
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kPoints = 1000;        // of all links
constexpr double kStep = 0.05;       // [s] of closing at 1 rad/s and 0.1 m/s of the fastest joint
constexpr double kSlideSpeed = 0.1;  // [m/s]
constexpr int kMaxSteps = 160;
constexpr int kSelfSteps = 4;    // between looks at links that can touch each other
constexpr double kTouch = 4e-4;  // [m] distance that counts as a contact
constexpr double kApart = 4e-3;  // [m] between two contacts of one link
constexpr int kContactsPerLink = 3;
constexpr double kFriction = 0.5;
constexpr int kConeEdges = 6;
constexpr int kDirections = 90;
constexpr double kFirm = 0.25;                  // quality of a firm grasp
constexpr double kRetreats[] = {0.001, 0.015};  // [m] from the first contact

/// Evenly over the surface, by area; the same points for the same mesh.
std::vector<Eigen::Vector3d> drawPoints(const TriangleMesh& mesh, int count)
{
    std::vector<double> sums;
    double sum = 0.0;
    const auto corner = [&](const Triangle& t, std::size_t k) -> const Eigen::Vector3d&
    { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    for (const Triangle& t : mesh.triangles)
    {
        sum += (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm();
        sums.push_back(sum);
    }
    std::vector<Eigen::Vector3d> points;
    // Additive recurrence of the plastic number: even over the unit square.
    constexpr double kPlastic = 1.32471795724474602596;
    for (int k = 0; k < count && sum > 0.0; ++k)
    {
        const double at = sum * (k + 0.5) / count;
        const auto index =
            static_cast<std::size_t>(std::lower_bound(sums.begin(), sums.end(), at) - sums.begin());
        const Triangle& t = mesh.triangles[std::min(index, sums.size() - 1)];
        double u = std::fmod(0.5 + k / kPlastic, 1.0);
        double v = std::fmod(0.5 + k / (kPlastic * kPlastic), 1.0);
        if (u + v > 1.0)
        {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        points.push_back((1.0 - u - v) * corner(t, 0) + u * corner(t, 1) + v * corner(t, 2));
    }
    return points;
}

/// Unit; the same in every program.
std::vector<Vector6> drawDirections()
{
    std::mt19937_64 random(6);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
    std::vector<Vector6> directions;
    while (directions.size() < kDirections)
    {
        Vector6 d;
        for (int k = 0; k < 6; ++k)
        {
            // Box and Muller.
            d[k] = std::sqrt(-2.0 * std::log(1.0 - unit())) *
                   std::cos(2.0 * std::numbers::pi * unit());
        }
        directions.push_back(d.normalized());
    }
    return directions;
}

/// Least support of the wrenches over the directions, and over directions nearby: positive only if
/// the wrenches surround the origin, as far as these directions tell.
double leastSupport(const std::vector<Vector6>& wrenches, const std::vector<Vector6>& directions)
{
    const auto farthest = [&](const Vector6& direction)
    {
        return *std::max_element(wrenches.begin(),
                                 wrenches.end(),
                                 [&](const Vector6& a, const Vector6& b)
                                 { return a.dot(direction) < b.dot(direction); });
    };
    double least = std::numeric_limits<double>::infinity();
    Vector6 worst = Vector6::Zero();
    for (const Vector6& direction : directions)
    {
        const double support = farthest(direction).dot(direction);
        if (support < least)
        {
            least = support;
            worst = direction;
        }
    }
    for (double rate = 0.4; rate > 0.02; rate *= 0.75)
    {
        const Vector6 next = (worst - rate * farthest(worst)).normalized();
        const double support = farthest(next).dot(next);
        if (support < least)
        {
            least = support;
            worst = next;
        }
    }
    return least;
}
}  // namespace

double TrialBody::distance(const Eigen::Vector3d& point) const
{
    const Eigen::Vector3d out = point.cwiseAbs() - half;
    return out.cwiseMax(0.0).norm() + std::min(0.0, out.maxCoeff()) - round;
}

Eigen::Vector3d TrialBody::normal(const Eigen::Vector3d& point) const
{
    const Eigen::Vector3d out = point.cwiseAbs() - half;
    const Eigen::Vector3d beyond = out.cwiseMax(0.0);
    const auto signed_ = [&](int k, double value) { return point[k] < 0.0 ? -value : value; };
    if (beyond.norm() > 1e-9)
    {
        return Eigen::Vector3d(signed_(0, beyond[0]), signed_(1, beyond[1]), signed_(2, beyond[2]))
            .normalized();
    }
    Eigen::Index axis = 0;
    out.maxCoeff(&axis);
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    normal[axis] = signed_(static_cast<int>(axis), 1.0);
    return normal;
}

TrialGrasps::TrialGrasps(const HandModel& hand) : m_hand(hand), m_directions(drawDirections())
{
    const KinematicTree& tree = hand.robot.tree;
    m_links.resize(tree.size());
    const int points = std::clamp(
        kPoints / static_cast<int>(std::max<std::size_t>(1, hand.trees.size())), 40, 240);
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        LinkPoints& link = m_links[i];
        if (hand.linkTrees[i] != nullptr)
        {
            const std::vector<Eigen::Vector3d> drawn = drawPoints(hand.robot.linkMeshes[i], points);
            link.points.fill(Row(static_cast<Eigen::Index>(drawn.size())));
            Eigen::AlignedBox3d box;
            for (std::size_t k = 0; k < drawn.size(); ++k)
            {
                box.extend(drawn[k]);
                for (std::size_t axis = 0; axis < 3; ++axis)
                {
                    link.points[axis][static_cast<Eigen::Index>(k)] =
                        static_cast<float>(drawn[k][static_cast<Eigen::Index>(axis)]);
                }
            }
            link.middle = drawn.empty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.center());
            for (const Eigen::Vector3d& point : drawn)
            {
                link.radius = std::max(link.radius, (point - link.middle).norm());
            }
        }
        for (auto above = static_cast<std::int32_t>(i); above > 0;
             above = tree.links[static_cast<std::size_t>(above)].parent)
        {
            const auto index = static_cast<std::size_t>(above);
            const std::int32_t leader = tree.links[index].joint.mimicOf;
            if (hand.closingDirections[index] != 0)
            {
                link.drivers.push_back(leader == kNone ? index : static_cast<std::size_t>(leader));
            }
        }
        std::ranges::sort(link.drivers);
    }
    for (std::size_t a = 0; a < tree.size(); ++a)
    {
        for (std::size_t b = a + 1; b < tree.size(); ++b)
        {
            LinkPair pair{.first = a, .second = b, .drivers = {}};
            std::ranges::set_symmetric_difference(
                m_links[a].drivers, m_links[b].drivers, std::back_inserter(pair.drivers));
            if (!pair.drivers.empty() &&
                canTouch(hand, static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)))
            {
                m_pairs.push_back(std::move(pair));
            }
        }
    }
}

Eigen::Vector3d TrialGrasps::LinkPoints::point(Eigen::Index k) const
{
    return {points[0][k], points[1][k], points[2][k]};
}

/// TrialBody::distance() of all points at once.
TrialGrasps::Row TrialGrasps::distances(const LinkPoints& link,
                                        const Eigen::Isometry3d& X_BL,
                                        const TrialBody& body)
{
    const Eigen::Matrix3f R = X_BL.linear().cast<float>();
    const Eigen::Vector3f t = X_BL.translation().cast<float>();
    const auto [x, y, z] = std::tie(link.points[0], link.points[1], link.points[2]);
    std::array<Row, 3> out;
    for (int k = 0; k < 3; ++k)
    {
        out[static_cast<std::size_t>(k)] = (R(k, 0) * x + R(k, 1) * y + R(k, 2) * z + t[k]).abs() -
                                           static_cast<float>(body.half[k]);
    }
    return (out[0].max(0.0F).square() + out[1].max(0.0F).square() + out[2].max(0.0F).square())
               .sqrt() +
           out[0].max(out[1]).max(out[2]).min(0.0F) - static_cast<float>(body.round);
}

TrialGrasps::Nearest TrialGrasps::nearest(const LinkPoints& link,
                                          const Eigen::Isometry3d& X_BL,
                                          const TrialBody& body)
{
    Nearest best{.distance = body.distance(X_BL * link.middle) - link.radius};
    if (best.distance > 0.02)
    {
        return best;  // a lower bound is enough
    }
    best.distance = distances(link, X_BL, body).minCoeff(&best.point);
    return best;
}

double TrialGrasps::freeTravel(const std::vector<Eigen::Isometry3d>& X_GL,
                               const TrialBody& body,
                               Eigen::Isometry3d X_GB) const
{
    // From where nothing can touch, in steps of the distance.
    double z = 0.0;
    for (std::size_t i = 0; i < m_links.size(); ++i)
    {
        if (!m_links[i].empty())
        {
            z = std::max(z, (X_GL[i] * m_links[i].middle).z() + m_links[i].radius);
        }
    }
    z += body.radius();
    constexpr int kMaxAdvances = 60;
    for (int advance = 0; advance < kMaxAdvances && z > 0.0; ++advance)
    {
        X_GB.translation().z() = z;
        const Eigen::Isometry3d X_BG = X_GB.inverse();
        double gap = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < m_links.size(); ++i)
        {
            if (!m_links[i].empty())
            {
                gap = std::min(gap, nearest(m_links[i], X_BG * X_GL[i], body).distance);
            }
        }
        if (gap < 1e-3)
        {
            break;
        }
        z -= gap;
    }
    return std::max(0.0, z);
}

bool TrialGrasps::overlap(const LinkPair& pair, const std::vector<Eigen::Isometry3d>& X_BL) const
{
    const auto& [a, b, drivers] = pair;
    const double reach = m_links[a].radius + m_links[b].radius + kPreshapeOverlap;
    if ((X_BL[a] * m_links[a].middle - X_BL[b] * m_links[b].middle).squaredNorm() > reach * reach)
    {
        return false;
    }
    return treeDistance(*m_hand.linkTrees[a],
                        *m_hand.linkTrees[b],
                        X_BL[b].inverse() * X_BL[a],
                        kPreshapeOverlap)
               .distance < kPreshapeOverlap;
}

std::vector<Eigen::Isometry3d> TrialGrasps::close(std::vector<double> positions,
                                                  const Eigen::Isometry3d& X_BR,
                                                  const TrialBody& body,
                                                  const std::vector<double>& speeds) const
{
    const KinematicTree& tree = m_hand.robot.tree;
    const auto ratio = [&](std::size_t link) { return speeds.empty() ? 1.0 : speeds[link]; };
    const std::vector<double> closed = closedPositions(m_hand, positions);
    std::vector<bool> runs(tree.size(), false);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        runs[i] = m_hand.closingDirections[i] != 0 && tree.links[i].joint.mimicOf == kNone;
    }
    std::vector<double> before(tree.size(), std::numeric_limits<double>::infinity());
    std::vector<double> moved(tree.size(), 0.0);
    std::vector<Eigen::Isometry3d> X_BL = linkPoses(tree, X_BR, positions);
    const std::vector<Eigen::Isometry3d> X_BLStart = X_BL;
    std::vector<std::optional<bool>> overlapsAtStart(m_pairs.size());  // of those that were asked
    const auto place = [&]
    {
        applyMimics(tree, positions);
        X_BL = linkPoses(tree, X_BR, positions);
    };
    // Joints stop, at this part of their last step.
    const auto stop = [&](const std::vector<std::size_t>& drivers, double part)
    {
        for (const std::size_t driver : drivers)
        {
            positions[driver] -= (1.0 - part) * moved[driver];
            moved[driver] = 0.0;
            runs[driver] = false;
        }
    };
    const auto anyMoves = [&](const std::vector<std::size_t>& drivers) {
        return std::ranges::any_of(drivers,
                                   [&](std::size_t driver) { return moved[driver] != 0.0; });
    };
    for (int step = 0; step < kMaxSteps; ++step)
    {
        double fastest = 0.0;
        for (std::size_t i = 1; i < tree.size(); ++i)
        {
            fastest = runs[i] ? std::max(fastest, ratio(i)) : fastest;
        }
        if (fastest == 0.0)
        {
            break;
        }
        for (std::size_t i = 1; i < tree.size(); ++i)
        {
            moved[i] = 0.0;
            if (runs[i])
            {
                const double most =
                    (tree.links[i].joint.type == JointType::Prismatic ? kSlideSpeed : 1.0) * kStep *
                    ratio(i) / fastest;
                const double left = closed[i] - positions[i];
                moved[i] = std::clamp(left, -most, most);
                positions[i] += moved[i];
                runs[i] = std::abs(left) > most;
            }
        }
        place();
        bool hasStopped = false;
        for (std::size_t i = 0; i < tree.size(); ++i)
        {
            if (m_links[i].empty() || !anyMoves(m_links[i].drivers))
            {
                continue;
            }
            const double distance = nearest(m_links[i], X_BL[i], body).distance;
            if (distance > 0.0)
            {
                before[i] = distance;
                continue;
            }
            // Back to where it touched, if it came from outside in this step.
            const double part = std::isfinite(before[i]) ? before[i] / (before[i] - distance) : 0.0;
            stop(m_links[i].drivers, part);
            hasStopped = true;
        }
        if (hasStopped)
        {
            place();
        }
        if (step % kSelfSteps != 0)
        {
            continue;
        }
        hasStopped = false;
        for (std::size_t k = 0; k < m_pairs.size(); ++k)
        {
            if (!anyMoves(m_pairs[k].drivers) || !overlap(m_pairs[k], X_BL))
            {
                continue;
            }
            // What overlaps from the start is left alone, as it is by the planner.
            std::optional<bool>& atStart = overlapsAtStart[k];
            atStart = atStart ? *atStart : overlap(m_pairs[k], X_BLStart);
            if (!*atStart)
            {
                stop(m_pairs[k].drivers, 0.0);
                hasStopped = true;
            }
        }
        if (hasStopped)
        {
            place();
        }
    }
    return X_BL;
}

double TrialGrasps::quality(const std::vector<Eigen::Isometry3d>& X_BL, const TrialBody& body) const
{
    std::vector<Vector6> wrenches;
    const double scale = body.radius();
    for (std::size_t i = 0; i < m_links.size(); ++i)
    {
        const LinkPoints& link = m_links[i];
        if (link.empty())
        {
            continue;
        }
        const Nearest deepest = nearest(link, X_BL[i], body);
        if (deepest.distance > 2.0 * kTouch)
        {
            continue;
        }
        const Row gaps = distances(link, X_BL[i], body);
        std::vector<Eigen::Vector3d> contacts{X_BL[i] * link.point(deepest.point)};
        while (contacts.size() < kContactsPerLink)
        {
            double apart = kApart;
            std::optional<Eigen::Vector3d> next;
            for (Eigen::Index k = 0; k < gaps.size(); ++k)
            {
                if (gaps[k] > deepest.distance + kTouch)
                {
                    continue;
                }
                const Eigen::Vector3d p = X_BL[i] * link.point(k);
                double nearestContact = std::numeric_limits<double>::infinity();
                for (const Eigen::Vector3d& contact : contacts)
                {
                    nearestContact = std::min(nearestContact, (contact - p).norm());
                }
                if (nearestContact > apart)
                {
                    apart = nearestContact;
                    next = p;
                }
            }
            if (!next)
            {
                break;
            }
            contacts.push_back(*next);
        }
        for (const Eigen::Vector3d& contact : contacts)
        {
            const Eigen::Vector3d n = -body.normal(contact);
            const Eigen::Vector3d u = n.unitOrthogonal();
            const Eigen::Vector3d v = n.cross(u);
            for (int edge = 0; edge < kConeEdges; ++edge)
            {
                const double angle = 2.0 * std::numbers::pi * edge / kConeEdges;
                const Eigen::Vector3d f =
                    n + kFriction * (std::cos(angle) * u + std::sin(angle) * v);
                Vector6 wrench;
                wrench << f, contact.cross(f) / scale;
                wrenches.push_back(wrench);
            }
        }
    }
    return wrenches.empty() ? -1.0 : leastSupport(wrenches, m_directions);
}

double TrialGrasps::operator()(const std::vector<double>& positions,
                               const Eigen::Isometry3d& X_RG,
                               const TrialBody& body,
                               const Eigen::Isometry3d& X_GB,
                               const std::vector<double>& speeds) const
{
    const std::vector<Eigen::Isometry3d> X_GL =
        linkPoses(m_hand.robot.tree, X_RG.inverse(), positions);
    const double first = freeTravel(X_GL, body, X_GB);
    double best = 0.0;
    for (const double retreat : kRetreats)
    {
        Eigen::Isometry3d X_GAt = X_GB;
        X_GAt.translation().z() = first + retreat;
        const double reached = quality(close(positions,
                                             (X_RG * X_GAt).inverse(),
                                             body,
                                             speeds.empty() ? m_hand.closingSpeeds : speeds),
                                       body);
        const double score = reached <= 0.0 ? 0.3 * std::max(0.0, 1.0 + reached / 0.3)
                                            : 0.5 + 0.5 * std::min(1.0, reached / kFirm);
        best = std::max(best, score);
        if (best >= 1.0)
        {
            break;
        }
    }
    return best;
}
}  // namespace bullet_ccd::grasp
