#include "tests/toi/articulated_scene.h"

#include "tests/oracles/brute_force_toi.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

namespace bullet_ccd::tests
{
BuiltScene::BuiltScene(const ArticulatedScene& scene) : m_scene(scene)
{
    m_hierarchies.reserve(scene.linkMeshes.size() + scene.obstacles.size());
    for (const TriangleMesh& mesh : scene.linkMeshes)
    {
        if (!mesh.triangles.empty())
        {
            m_hierarchies.push_back(buildSsvTree(mesh));
        }
        m_links.push_back(mesh.triangles.empty() ? nullptr : &m_hierarchies.back());
    }
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    {
        m_hierarchies.push_back(buildSsvTree(scene.obstacles[i]));
        m_obstacles.push_back({&m_hierarchies.back(), scene.obstacleMotions[i]});
    }
}

ArticulatedBody BuiltScene::body() const
{
    return {.tree = &m_scene.tree,
            .linkTrees = m_links,
            .motion = &m_scene.motion,
            .selfPairs = m_scene.selfPairs};
}

ArticulatedToiResult query(const ArticulatedScene& scene, const ArticulatedToiOptions& options)
{
    const BuiltScene built(scene);
    ToiWorkspace work;
    return articulatedToi(built.body(), Environment(built.obstacles()), options, work);
}

ArticulatedToiResult query(const ArticulatedScene& scene, double tolerance)
{
    const BuiltScene built(scene);
    ToiWorkspace work;
    return articulatedToi(built.body(), built.obstacles(), {.tolerance = tolerance}, work);
}

namespace
{
/// One pair of bodies that is to be tested, with its brute-force answer.
struct Reference
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;
    std::int32_t otherLink = kNone;
    OracleBody a;
    OracleBody b;
    OracleToi toi;
};

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

std::vector<Reference> references(const ArticulatedScene& scene)
{
    std::vector<Reference> all;
    const auto linkBody = [&](std::int32_t link)
    {
        return oracleLink(
            scene.linkMeshes[static_cast<std::size_t>(link)], scene.tree, scene.motion, link);
    };
    const auto add = [&](Reference reference)
    {
        if (!reference.a.mesh->triangles.empty() && !reference.b.mesh->triangles.empty() &&
            movesRelatively(reference.a, reference.b))
        {
            reference.toi = bruteForceToi(reference.a, reference.b);
            all.push_back(reference);
        }
    };
    for (std::int32_t link = 0; link < static_cast<std::int32_t>(scene.tree.size()); ++link)
    {
        for (std::size_t k = 0; k < scene.obstacles.size(); ++k)
        {
            add({.link = link,
                 .obstacle = static_cast<std::int32_t>(k),
                 .a = linkBody(link),
                 .b = oracleBody(scene.obstacles[k], scene.obstacleMotions[k]),
                 .toi = {}});
        }
    }
    for (const auto& [first, second] : scene.selfPairs)
    {
        add({.link = first,
             .otherLink = second,
             .a = linkBody(first),
             .b = linkBody(second),
             .toi = {}});
    }
    return all;
}

const Reference* findReference(const std::vector<Reference>& all, const LinkContact& contact)
{
    for (const Reference& reference : all)
    {
        const bool straight =
            reference.link == contact.link && reference.otherLink == contact.otherLink;
        const bool crossed =
            reference.otherLink == contact.link && reference.link == contact.otherLink;
        if (reference.obstacle == contact.obstacle && (straight || crossed))
        {
            return &reference;
        }
    }
    return nullptr;
}
}  // namespace

void checkScene(const ArticulatedScene& scene, const ArticulatedToiOptions& options, Tally& tally)
{
    const double tolerance = options.toi.tolerance;
    constexpr double kRounding = 2e-13;
    const ArticulatedToiResult result = query(scene, options);
    const std::vector<Reference> all = references(scene);
    std::optional<double> contactTime;
    for (const Reference& reference : all)
    {
        if (reference.toi.contact)
        {
            contactTime = std::min(contactTime.value_or(2.0), *reference.toi.contact);
        }
    }
    ASSERT_NE(result.status, ToiStatus::IterationLimit);
    if (contactTime)
    {
        EXPECT_NE(result.status, ToiStatus::Separated) << "missed " << *contactTime;
        EXPECT_LE(result.time, *contactTime + 1e-12) << "late";
    }
    if (result.status == ToiStatus::Separated)
    {
        EXPECT_EQ(result.time, 1.0);
        EXPECT_TRUE(result.contacts.empty());
        return;
    }
    ASSERT_FALSE(result.contacts.empty());
    tally.hits += result.status == ToiStatus::Hit ? 1 : 0;
    tally.overlapping += result.status == ToiStatus::Overlapping ? 1 : 0;
    for (const LinkContact& contact : result.contacts)
    {
        const Reference* reference = findReference(all, contact);
        ASSERT_NE(reference, nullptr) << "contact of a pair that was not asked for";
        const double distance = oracleDistanceAt(reference->a, reference->b, result.time);
        EXPECT_LE(distance, contact.gap + kRounding);
        EXPECT_LE(contact.gap, tolerance);
        if (result.status == ToiStatus::Hit)
        {
            EXPECT_GT(distance, 0.0);
            EXPECT_NEAR((contact.pointLink - contact.pointOther).norm(), contact.gap, kRounding);
            const Eigen::Vector3d across = contact.pointOther - contact.pointLink;
            EXPECT_GE(contact.normal.dot(across), contact.gap - kRounding);
        }
        tally.selfHits += contact.otherLink != kNone ? 1 : 0;
    }
}

void checkScene(const ArticulatedScene& scene, double tolerance, Tally& tally)
{
    checkScene(scene, {.toi = {.tolerance = tolerance}}, tally);
}
}  // namespace bullet_ccd::tests
