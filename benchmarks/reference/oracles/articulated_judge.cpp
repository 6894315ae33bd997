#include "benchmarks/reference/oracles/articulated_judge.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
namespace
{
/// A pair of bodies that is to be tested.
struct MovingPair
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;
    std::int32_t otherLink = kNone;
    OracleBody a;
    OracleBody b;

    [[nodiscard]] std::string text() const
    {
        return "link " + std::to_string(link) +
               (obstacle != kNone ? " and obstacle " + std::to_string(obstacle)
                                  : " and link " + std::to_string(otherLink));
    }
};

const TriangleMesh& meshOf(const ArticulatedScene& scene, std::int32_t link)
{
    return scene.linkMeshes[static_cast<std::size_t>(link)];
}

/// Whether the pair moves relative to each other, by looking at its poses.
bool movesRelatively(const OracleBody& a, const OracleBody& b)
{
    const Eigen::Matrix4d start = (b.poseAt(0.0).inverse() * a.poseAt(0.0)).matrix();
    for (const double t : {0.31, 0.77, 1.0})
    {
        if (((b.poseAt(t).inverse() * a.poseAt(t)).matrix() - start).norm() > 1e-9)
        {
            return true;
        }
    }
    return false;
}

std::vector<MovingPair> movingPairs(const ArticulatedScene& scene)
{
    std::vector<MovingPair> all;
    const auto linkBody = [&](std::int32_t link, std::int32_t base)
    { return oracleLink(meshOf(scene, link), scene.tree, scene.motion, link, base); };
    const auto add = [&](MovingPair pair)
    {
        if (!pair.a.mesh->triangles.empty() && !pair.b.mesh->triangles.empty() &&
            movesRelatively(pair.a, pair.b))
        {
            all.push_back(std::move(pair));
        }
    };
    for (std::int32_t link = 0; link < static_cast<std::int32_t>(scene.tree.size()); ++link)
    {
        for (std::size_t k = 0; k < scene.obstacles.size(); ++k)
        {
            add({.link = link,
                 .obstacle = static_cast<std::int32_t>(k),
                 .a = linkBody(link, kNone),
                 .b = oracleBody(scene.obstacles[k], scene.obstacleMotions[k])});
        }
    }
    for (const auto& [first, second] : scene.selfPairs)
    {
        std::int32_t base = first;  // that both hang from; parents come first
        for (std::int32_t other = second; base != other;)
        {
            std::int32_t& deeper = base > other ? base : other;
            deeper = scene.tree.links[static_cast<std::size_t>(deeper)].parent;
        }
        add({.link = first,
             .otherLink = second,
             .a = linkBody(first, base),
             .b = linkBody(second, base)});
    }
    return all;
}

bool names(const LinkContact& contact, const MovingPair& pair)
{
    const bool straight = pair.link == contact.link && pair.otherLink == contact.otherLink;
    const bool crossed = pair.otherLink == contact.link && pair.link == contact.otherLink;
    return pair.obstacle == contact.obstacle && (straight || crossed);
}

Judgement wrong(Verdict verdict, double time, double distance, const std::string& pair)
{
    return {.verdict = verdict, .time = time, .distance = distance, .pair = pair};
}

/// One answer; the first complaint stands.
class ArticulatedJudge
{
public:
    ArticulatedJudge(const ArticulatedScene& scene,
                     const ToiOptions& options,
                     const ArticulatedToiResult& result)
        : m_scene(scene),
          m_options(options),
          m_result(result),
          m_rounding(distanceRounding(scene)),
          m_pairs(movingPairs(scene))
    {
    }

    Judgement run()
    {
        if (m_result.status == ToiStatus::IterationLimit)
        {
            return wrong(Verdict::GaveUp, m_result.time, 0.0, "");
        }
        judgeStatus();
        if (isRight() && m_result.status != ToiStatus::Overlapping)
        {
            judgeTime();
        }
        if (m_result.status == ToiStatus::Hit)
        {
            for (const LinkContact& contact : m_result.contacts)
            {
                judgeContact(contact);
            }
            judgeUnnamed();
        }
        return m_judgement;
    }

private:
    [[nodiscard]] bool isRight() const { return m_judgement.verdict == Verdict::Right; }

    void complain(Verdict verdict, double time, double distance, const std::string& pair)
    {
        if (isRight())
        {
            m_judgement = wrong(verdict, time, distance, pair);
        }
    }

    void judgeStatus()
    {
        const double time = m_result.time;
        const bool isFree = m_result.status == ToiStatus::Separated;
        const bool isOverlap = m_result.status == ToiStatus::Overlapping;
        const bool fits = isFree      ? time == 1.0 && m_result.contacts.empty()
                          : isOverlap ? time == 0.0 && m_result.contacts.size() == 1
                                      : m_result.status == ToiStatus::Hit && time >= 0.0 &&
                                            time <= 1.0 && !m_result.contacts.empty();
        if (!fits)
        {
            complain(Verdict::WrongStatus, time, 0.0, "");
            return;
        }
        if (isOverlap)
        {
            const MovingPair* pair = find(m_result.contacts.front());
            const double start = pair != nullptr ? oracleDistanceAt(pair->a, pair->b, 0.0) : 1.0;
            if (start > m_rounding)
            {
                complain(Verdict::WrongStatus, 0.0, start, pair != nullptr ? pair->text() : "");
            }
        }
    }

    void judgeTime()
    {
        for (const MovingPair& pair : m_pairs)
        {
            const OracleToi toi = bruteForceToi(pair.a, pair.b, m_result.time);
            if (toi.contact)
            {
                const bool isFree = m_result.status == ToiStatus::Separated;
                complain(isFree ? Verdict::Missed : Verdict::Late, *toi.contact, 0.0, pair.text());
            }
        }
    }

    [[nodiscard]] const MovingPair* find(const LinkContact& contact) const
    {
        const auto found =
            std::find_if(m_pairs.begin(),
                         m_pairs.end(),
                         [&](const MovingPair& pair) { return names(contact, pair); });
        return found != m_pairs.end() ? &*found : nullptr;
    }

    void judgeContact(const LinkContact& contact)
    {
        const MovingPair* pair = find(contact);
        if (pair == nullptr)
        {
            complain(Verdict::False, m_result.time, 0.0, "a pair that was not asked about");
            return;
        }
        const double distance = oracleDistanceAt(pair->a, pair->b, m_result.time);
        if (distance > m_options.tolerance + m_rounding)
        {
            complain(Verdict::False, m_result.time, distance, pair->text());
        }
        // The named triangles need not be the closest, but others are closer by the aim at most.
        const double most = std::max(
            distance, (m_options.anyWithin ? 1.0 : 2.0 * m_options.aim) * m_options.tolerance);
        const bool isHonest = contact.gap > 0.0 && contact.gap <= m_options.tolerance &&
                              contact.gap >= distance - m_rounding &&
                              contact.gap <= most + m_rounding && hasHonestWitnesses(contact);
        if (!isHonest || contact.time != m_result.time)
        {
            complain(Verdict::WrongGap, m_result.time, distance, pair->text());
        }
    }

    /// Points on the named triangles, apart by the gap along the normal.
    [[nodiscard]] bool hasHonestWitnesses(const LinkContact& contact) const
    {
        const Eigen::Vector3d across = contact.pointOther - contact.pointLink;
        const double offLink =
            distanceFrom(contact.triangleLink,
                         contact.pointLink,
                         meshOf(m_scene, contact.link),
                         oracleLinkPose(m_scene.tree, m_scene.motion, contact.link, m_result.time));
        const double offOther =
            contact.obstacle != kNone
                ? distanceFromObstacle(contact)
                : distanceFrom(contact.triangleOther,
                               contact.pointOther,
                               meshOf(m_scene, contact.otherLink),
                               oracleLinkPose(
                                   m_scene.tree, m_scene.motion, contact.otherLink, m_result.time));
        return std::abs(across.norm() - contact.gap) <= m_rounding &&
               std::abs(contact.normal.norm() - 1.0) <= 1e-12 &&
               contact.normal.dot(across) >= contact.gap - m_rounding && offLink <= m_rounding &&
               offOther <= m_rounding;
    }

    [[nodiscard]] double distanceFromObstacle(const LinkContact& contact) const
    {
        const auto index = static_cast<std::size_t>(contact.obstacle);
        return distanceFrom(contact.triangleOther,
                            contact.pointOther,
                            m_scene.obstacles[index],
                            oraclePose(m_scene.obstacleMotions[index], m_result.time));
    }

    static double distanceFrom(std::int32_t triangle,
                               const Eigen::Vector3d& point,
                               const TriangleMesh& mesh,
                               const Eigen::Isometry3d& X_WM)
    {
        const bool isThere =
            triangle >= 0 && static_cast<std::size_t>(triangle) < mesh.triangles.size();
        return isThere ? distanceToTriangle(X_WM.inverse() * point,
                                            cornersOf(mesh, static_cast<std::size_t>(triangle)))
                       : std::numeric_limits<double>::infinity();
    }

    /// All pairs within the tolerance at that time are contacts, but for those that began there.
    void judgeUnnamed()
    {
        for (const MovingPair& pair : m_pairs)
        {
            const bool isNamed =
                std::any_of(m_result.contacts.begin(),
                            m_result.contacts.end(),
                            [&](const LinkContact& contact) { return names(contact, pair); });
            const double distance = isNamed ? 0.0 : oracleDistanceAt(pair.a, pair.b, m_result.time);
            if (!isNamed && distance < m_options.tolerance - m_rounding &&
                oracleDistanceAt(pair.a, pair.b, 0.0) > m_options.tolerance + m_rounding)
            {
                complain(Verdict::Missed, m_result.time, distance, pair.text());
            }
        }
    }

    const ArticulatedScene& m_scene;
    const ToiOptions& m_options;
    const ArticulatedToiResult& m_result;
    double m_rounding;
    std::vector<MovingPair> m_pairs;
    Judgement m_judgement;
};
}  // namespace

double distanceRounding(const ArticulatedScene& scene)
{
    double reach = scene.motion.root.X_W0.translation().norm() + scene.motion.root.v_W.norm() +
                   2.0 * scene.motion.root.reference_B.norm();
    double widest = 0.0;
    const JointMotion& joints = scene.motion;
    for (std::size_t i = 0; i < scene.tree.size(); ++i)
    {
        const Link& link = scene.tree.links[i];
        const bool slides = link.joint.type == JointType::Prismatic;
        double way = std::abs(joints.positions[i]) + std::abs(joints.rates[i]);
        for (std::size_t k = 0; !joints.curves.empty() && k < 4; ++k)
        {
            way += std::abs(joints.curves[i][k]);
        }
        reach += link.X_PL0.translation().norm() + (slides ? way : 0.0);
        widest = std::max(widest, radiusOf(scene.linkMeshes[i]));
    }
    double farthest = 0.0;
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    {
        const RigidMotion& motion = scene.obstacleMotions[i];
        farthest = std::max(farthest,
                            radiusOf(scene.obstacles[i]) + motion.X_W0.translation().norm() +
                                motion.v_W.norm() + 2.0 * motion.reference_B.norm());
    }
    return 512.0 * 1.2e-16 * (reach + widest + farthest);
}

double leastDistanceAt(const ArticulatedScene& scene,
                       std::span<const double> times,
                       const LinkContact* named)
{
    double least = std::numeric_limits<double>::infinity();
    for (const MovingPair& pair : movingPairs(scene))
    {
        const double reach = radiusOf(*pair.a.mesh) + radiusOf(*pair.b.mesh);
        for (const double t : times)
        {
            const Eigen::Isometry3d X_BA = pair.b.poseAt(t).inverse() * pair.a.poseAt(t);
            if ((named == nullptr || names(*named, pair)) &&
                X_BA.translation().norm() - reach < least)
            {
                least = std::min(least,
                                 bruteForceMeshDistance(*pair.a.mesh, *pair.b.mesh, X_BA).distance);
            }
        }
    }
    return least;
}

Judgement judgeArticulated(const ArticulatedScene& scene,
                           const ToiOptions& options,
                           const ArticulatedToiResult& result)
{
    return ArticulatedJudge(scene, options, result).run();
}
}  // namespace bullet_ccd::reference
