// What the rigid benchmark rests on: its meshes, its query sets, its checks of answers.
#include "benchmarks/rigid/rigid_check.h"
#include "benchmarks/rigid/rigid_meshes.h"
#include "benchmarks/rigid/rigid_sets.h"
#include "bullet_ccd/toi/rigid_toi.h"

#include <gmock/gmock.h>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Plates need no data folder.
RigidSet plates(std::uint64_t seedShift = 0)
{
    MeshLibrary meshes("");
    return makeRigidSet("tunnel", meshes, seedShift);
}

std::vector<ToiResult> answersOf(const RigidSet& set)
{
    const SsvTree a = buildSsvTree(*set.meshA);
    const SsvTree b = buildSsvTree(*set.meshB);
    ToiWorkspace work;
    std::vector<ToiResult> answers;
    for (const RigidQuery& query : set.queries)
    {
        answers.push_back(rigidToi({.tree = &a, .motion = query.motionA},
                                   {.tree = &b, .motion = query.motionB},
                                   {.tolerance = 1e-4},
                                   work));
    }
    return answers;
}

TEST(RigidMeshes, AreClosedAndHaveTheirNumberOfTriangles)
{
    const std::vector<std::pair<TriangleMesh, std::size_t>> meshes{
        {makeKnotTube(64, 8), 1024},
        {makeBumpySphere(3, 80.0, 0.15), 1280},
        {makeFinger(), 928},
        {makeGridBox({15, 15, 1}, {60.0, 60.0, 0.1}), 1020},
    };
    for (const auto& [mesh, triangles] : meshes)
    {
        EXPECT_EQ(mesh.triangles.size(), triangles);
        EXPECT_TRUE(isWatertight(mesh));
        EXPECT_GT(massProperties(mesh).volume, 0.0);
    }
}

TEST(GeneratedSets, AreTheSameForASeedAndOthersForAnother)
{
    const RigidSet set = plates();
    const RigidSet again = plates();
    const RigidSet other = plates(1);
    ASSERT_EQ(set.queries.size(), 200u);
    for (std::size_t i = 0; i < set.queries.size(); ++i)
    {
        EXPECT_EQ(set.queries[i].motionA.v_W, again.queries[i].motionA.v_W);
        EXPECT_NE(set.queries[i].motionA.v_W, other.queries[i].motionA.v_W);
    }
}

TEST(GeneratedSets, BeginApartAndCollideOften)
{
    int hits = 0;
    for (const ToiResult& answer : answersOf(plates()))
    {
        EXPECT_NE(answer.status, ToiStatus::Overlapping);
        hits += isContact(answer.status) ? 1 : 0;
    }
    EXPECT_GT(hits, 100);
    EXPECT_LT(hits, 190);
}

class RigidCheck : public testing::Test
{
protected:
    void SetUp() override
    {
        m_model.emplace(*m_set.meshA);
        for (const RigidQuery& query : m_set.queries)
        {
            m_naive.push_back(fclNaive({*m_model, query.motionA}, {*m_model, query.motionB}, 1001));
        }
    }

    [[nodiscard]] CheckResult check() const
    {
        return checkAnswers(
            m_set, m_answers, 1e-4, {m_tree, m_tree, &*m_model, &*m_model, m_naive});
    }

    /// Index of a query that collides.
    [[nodiscard]] std::size_t collision() const
    {
        for (std::size_t i = 0; i < m_answers.size(); ++i)
        {
            if (m_answers[i].status == ToiStatus::Hit)
            {
                return i;
            }
        }
        return 0;
    }

    RigidSet m_set = plates();
    std::vector<ToiResult> m_answers = answersOf(m_set);
    SsvTree m_tree = buildSsvTree(*m_set.meshA);
    std::optional<FclModel> m_model;
    std::vector<FclAnswer> m_naive;
};

TEST_F(RigidCheck, AcceptsRightAnswers)
{
    const CheckResult result = check();
    EXPECT_EQ(result.wrong(), 0) << testing::PrintToString(result.complaints);
    EXPECT_GT(result.hits, 100);
    EXPECT_THAT(result.errors, testing::SizeIs(result.hits));
    EXPECT_THAT(result.errors, testing::Each(testing::Ge(0.0)));
}

TEST_F(RigidCheck, SeesAMissedContact)
{
    m_answers[collision()].status = ToiStatus::Separated;
    EXPECT_EQ(check().missed, 1);
}

TEST_F(RigidCheck, SeesALateContact)
{
    m_answers[collision()].time += 1e-5;
    EXPECT_EQ(check().late, 1);
}

TEST_F(RigidCheck, SeesAContactReportedTooEarly)
{
    m_answers[collision()].time -= 1e-4;
    EXPECT_EQ(check().falseHits, 1);
}

TEST_F(RigidCheck, SeesAWrongGap)
{
    m_answers[collision()].gap *= 0.5;
    EXPECT_EQ(check().badGaps, 1);
}

TEST_F(RigidCheck, SeesAWrongGapAndAFalseContactWithoutThePeer)
{
    const auto checkAlone = [&] { return checkAnswers(m_set, m_answers, 1e-4, {m_tree, m_tree}); };
    EXPECT_EQ(checkAlone().wrong(), 0);
    m_answers[collision()].time -= 1e-4;
    EXPECT_EQ(checkAlone().falseHits, 1);
    m_answers[collision()].time += 1e-4 + 1e-5;
    EXPECT_EQ(checkAlone().late, 1);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
