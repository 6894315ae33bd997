#include "bullet_ccd/toi/articulated_toi.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <string>
#include <tuple>

namespace bullet_ccd
{
namespace
{
/// The query as bodies and pairs: links first, then obstacles.
struct Query
{
    std::vector<MovingBody> bodies;
    std::vector<BodyPair> pairs;
};

bool isAtRest(const RigidBody& body)
{
    return body.userMotion == nullptr && body.motion.v_W.isZero(0.0) && body.motion.w_W.isZero(0.0);
}

Query makeQuery(const ArticulatedBody& body, std::span<const RigidBody> obstacles)
{
    const std::size_t links = body.tree->size();
    Query query;
    query.bodies.reserve(links + obstacles.size());
    for (std::size_t i = 0; i < links; ++i)
    {
        query.bodies.push_back(
            {.tree = body.linkTrees[i],
             .motion = LinkMotion{
                 .tree = body.tree, .motion = body.motion, .link = static_cast<std::int32_t>(i)}});
    }
    for (const RigidBody& obstacle : obstacles)
    {
        query.bodies.push_back(movingBody(obstacle));
    }
    for (std::size_t i = 0; i < links; ++i)
    {
        if (body.linkTrees[i] == nullptr)
        {
            continue;
        }
        const auto link = static_cast<std::int32_t>(i);
        const bool linkMoves = moves(*body.tree, *body.motion, kNone, link);
        for (std::size_t k = 0; k < obstacles.size(); ++k)
        {
            if (linkMoves || !isAtRest(obstacles[k]))
            {
                query.pairs.push_back(
                    {.bodyA = link, .bodyB = static_cast<std::int32_t>(links + k)});
            }
        }
    }
    for (const auto& [linkA, linkB] : body.selfPairs)
    {
        const std::int32_t base = commonAncestor(*body.tree, linkA, linkB);
        if (moves(*body.tree, *body.motion, base, linkA) ||
            moves(*body.tree, *body.motion, base, linkB))
        {
            query.pairs.push_back({.bodyA = linkA, .bodyB = linkB});
        }
    }
    return query;
}

/// Names the two sides of a pair.
LinkContact nameContact(const BodyPair& pair, std::int32_t links)
{
    LinkContact contact{.link = pair.bodyA};
    (pair.bodyB < links ? contact.otherLink : contact.obstacle) =
        pair.bodyB < links ? pair.bodyB : pair.bodyB - links;
    return contact;
}

/// Distance of a pair at time t if it is at most `threshold`, as a contact in W.
bool findContact(
    const Query& query, const BodyPair& pair, double t, double threshold, LinkContact& contact)
{
    const MovingBody& a = query.bodies[static_cast<std::size_t>(pair.bodyA)];
    const MovingBody& b = query.bodies[static_cast<std::size_t>(pair.bodyB)];
    const Eigen::Isometry3d X_WB = geometryPoseAt(b, t);
    const Eigen::Isometry3d X_BA = X_WB.inverse() * geometryPoseAt(a, t);
    const TrianglePair closest = treeDistance(*a.tree, *b.tree, X_BA, threshold);
    if (closest.triangleA == kNone || closest.distance <= 0.0)
    {
        return false;
    }
    contact.gap = closest.distance;
    contact.pointLink = X_WB * closest.pointA;
    contact.pointOther = X_WB * closest.pointB;
    // Not divided by the distance: the witnesses are rounded where the tree's origin is added.
    contact.normal = X_WB.linear() * (closest.pointB - closest.pointA).normalized();
    return true;
}

void checkSizes(const ArticulatedBody& body)
{
    const std::size_t links = body.tree->size();
    require(body.linkTrees.size() == links && body.motion->positions.size() == links &&
                body.motion->rates.size() == links,
            "articulatedToi: " + std::to_string(links) + " links, but " +
                std::to_string(body.linkTrees.size()) + " hierarchies, " +
                std::to_string(body.motion->positions.size()) + " positions and " +
                std::to_string(body.motion->rates.size()) + " rates: give one of each a link");
    const auto count = static_cast<std::int32_t>(links);
    for (const auto& [linkA, linkB] : body.selfPairs)
    {
        require(linkA >= 0 && linkB >= 0 && linkA < count && linkB < count && linkA != linkB &&
                    body.linkTrees[static_cast<std::size_t>(linkA)] != nullptr &&
                    body.linkTrees[static_cast<std::size_t>(linkB)] != nullptr,
                "articulatedToi: the pair of links (" + std::to_string(linkA) + ", " +
                    std::to_string(linkB) + ") does not name two links with geometry");
    }
}
}  // namespace

ArticulatedToiResult articulatedToi(const ArticulatedBody& body,
                                    std::span<const RigidBody> obstacles,
                                    const ToiOptions& options,
                                    ToiWorkspace& work)
{
    checkSizes(body);
    const auto links = static_cast<std::int32_t>(body.tree->size());
    const Query query = makeQuery(body, obstacles);
    const FirstContactResult first = firstContact(query.bodies, query.pairs, options, work);

    ArticulatedToiResult result{
        .status = first.status, .time = first.time, .contacts = {}, .counters = first.counters};
    if (first.pair == kNone || first.status == ToiStatus::IterationLimit)
    {
        return result;
    }
    LinkContact contact = nameContact(query.pairs[static_cast<std::size_t>(first.pair)], links);
    contact.gap = first.gap;
    contact.pointLink = first.pointA;
    contact.pointOther = first.pointB;
    contact.normal = first.normal;
    result.contacts.push_back(contact);
    if (first.status != ToiStatus::Hit)
    {
        return result;
    }

    for (std::size_t i = 0; i < query.pairs.size(); ++i)
    {
        // A pair that was within the tolerance at the start counts only if it closed in further:
        // the same rule as in firstContact.
        const BodyPair& pair = query.pairs[i];
        LinkContact start;
        LinkContact other = nameContact(pair, links);
        if (static_cast<std::int32_t>(i) != first.pair &&
            findContact(query, pair, first.time, options.tolerance, other) &&
            (!findContact(query, pair, 0.0, options.tolerance, start) ||
             other.gap <= 0.75 * start.gap))
        {
            result.contacts.push_back(other);
        }
    }
    std::sort(result.contacts.begin() + 1,
              result.contacts.end(),
              [](const LinkContact& a, const LinkContact& b) {
                  return std::tie(a.link, a.obstacle, a.otherLink) <
                         std::tie(b.link, b.obstacle, b.otherLink);
              });
    return result;
}
}  // namespace bullet_ccd
