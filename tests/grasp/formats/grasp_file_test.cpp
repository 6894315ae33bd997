#include "grasp/formats/grasp_file.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/closing.h"
#include "grasp/formats/content_hash.h"
#include "grasp/formats/grasp_recorder.h"
#include "tests/grasp/planner/test_hands.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <gmock/gmock.h>
#include <limits>
#include <random>
#include <set>
#include <sstream>

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::HasSubstr;
using tests::makeGripper;
using tests::makeThreeFingers;

class GraspFile : public ::testing::Test
{
protected:
    void SetUp() override
    {
        m_run.handFile = "hands/three \"fingers\".urdf";
        m_run.objectFile = "objects/ball.obj";
        m_run.objectScale = 0.001;
        m_run.options.seed = 18446744073709551615U;
        m_run.options.friction = 0.1 + 0.2;
    }

    [[nodiscard]] Eigen::Vector3d anyVector()
    {
        return {m_normal(m_random), m_normal(m_random), m_normal(m_random)};
    }

    [[nodiscard]] Eigen::Isometry3d anyPose()
    {
        return Eigen::Translation3d(anyVector()) *
               Eigen::AngleAxisd(m_normal(m_random), anyVector().normalized());
    }

    [[nodiscard]] std::vector<double> anyPositions()
    {
        std::vector<double> positions(m_hand.robot.tree.size(), 0.0);
        for (std::size_t k = 1; k < positions.size(); ++k)
        {
            positions[k] = m_normal(m_random) / 3.0;
        }
        return positions;
    }

    [[nodiscard]] Grasp anyGrasp(std::int64_t candidate)
    {
        Grasp grasp;
        grasp.candidate = candidate;
        grasp.preshape = "open";
        grasp.X_WStart = anyPose();
        grasp.X_WH = anyPose();
        grasp.approach_W = anyVector().normalized();
        grasp.approachDistance = std::abs(m_normal(m_random));
        grasp.obstaclesInReach = 3 + candidate;
        grasp.positions = anyPositions();
        for (std::int32_t link = 0; link < 4; ++link)
        {
            grasp.contacts.push_back({link, anyVector(), anyVector().normalized(), 1.0 / 3e5});
            grasp.stops.push_back({link, m_normal(m_random), link % 2 == 0});
        }
        grasp.quality = {std::abs(m_normal(m_random)), 1e-17 / 3.0, true};
        grasp.quality.largestMass =
            candidate % 2 == 0 ? 1.0 / 3.0 : std::numeric_limits<double>::infinity();
        grasp.source = "surface";
        return grasp;
    }

    void write(const std::vector<Grasp>& grasps) const
    {
        std::ofstream out(m_path);
        writeGrasps(out, m_run, m_hand, m_object, grasps);
    }

    /// What reading the text as a file complains about; empty if it does not.
    [[nodiscard]] std::string complaint(const std::string& text)
    {
        std::ofstream(m_path) << text;
        try
        {
            static_cast<void>(readGrasps(m_path, m_hand));
        }
        catch (const std::runtime_error& error)
        {
            return error.what();
        }
        return {};
    }

    [[nodiscard]] std::string text() const
    {
        std::stringstream content;
        content << std::ifstream(m_path).rdbuf();
        return content.str();
    }

    tests::TempFolder m_temp;
    std::filesystem::path m_path = m_temp.path() / "grasps.jsonl";
    GraspRun m_run;
    HandModel m_hand = makeThreeFingers();
    GraspObject m_object = makeGraspObject("ball", makeSphere(0.03, 2));
    std::mt19937_64 m_random{42};
    std::normal_distribution<double> m_normal;
};

TEST_F(GraspFile, RoundTripIsExact)
{
    const std::vector<Grasp> grasps{anyGrasp(3), anyGrasp(0), anyGrasp(12)};
    write(grasps);
    const std::vector<Grasp> read = readGrasps(m_path, m_hand);
    ASSERT_EQ(read.size(), grasps.size());
    for (std::size_t k = 0; k < read.size(); ++k)
    {
        const Grasp& a = grasps[k];
        const Grasp& b = read[k];
        EXPECT_EQ(a.candidate, b.candidate);
        EXPECT_EQ(a.preshape, b.preshape);
        EXPECT_EQ(a.positions, b.positions);
        EXPECT_EQ(a.X_WH.translation(), b.X_WH.translation());
        EXPECT_EQ(a.X_WStart.translation(), b.X_WStart.translation());
        // A matrix and its quaternion carry the same rotation up to rounding.
        EXPECT_LT((a.X_WH.linear() - b.X_WH.linear()).cwiseAbs().maxCoeff(), 1e-15);
        EXPECT_EQ(a.approach_W, b.approach_W);
        EXPECT_EQ(a.approachDistance, b.approachDistance);
        EXPECT_EQ(a.obstaclesInReach, b.obstaclesInReach);
        EXPECT_EQ(a.quality.epsilon, b.quality.epsilon);
        EXPECT_EQ(a.quality.volume, b.quality.volume);
        EXPECT_EQ(a.quality.forceClosure, b.quality.forceClosure);
        EXPECT_EQ(a.quality.largestMass, b.quality.largestMass);
        EXPECT_EQ(a.source, b.source);
        ASSERT_EQ(a.contacts.size(), b.contacts.size());
        ASSERT_EQ(a.stops.size(), b.stops.size());
        for (std::size_t c = 0; c < a.contacts.size(); ++c)
        {
            EXPECT_EQ(a.contacts[c].link, b.contacts[c].link);
            EXPECT_EQ(a.contacts[c].point, b.contacts[c].point);
            EXPECT_EQ(a.contacts[c].normal, b.contacts[c].normal);
            EXPECT_EQ(a.contacts[c].gap, b.contacts[c].gap);
            EXPECT_EQ(a.stops[c].link, b.stops[c].link);
            EXPECT_EQ(a.stops[c].time, b.stops[c].time);
            EXPECT_EQ(a.stops[c].byObject, b.stops[c].byObject);
        }
    }
}

/// All that is kept, to the bit; X_WH of a hand that was never closed means nothing.
void expectSameBits(const Grasp& a, const Grasp& b)
{
    EXPECT_EQ(a.candidate, b.candidate);
    EXPECT_EQ(a.reject, b.reject);
    EXPECT_EQ(a.preshape, b.preshape);
    EXPECT_EQ(a.X_WStart.matrix(), b.X_WStart.matrix());
    EXPECT_EQ(a.approach_W, b.approach_W);
    EXPECT_EQ(a.approachDistance, b.approachDistance);
    EXPECT_EQ(a.obstaclesInReach, b.obstaclesInReach);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_TRUE(a.positions.empty() || a.X_WH.matrix() == b.X_WH.matrix());
    EXPECT_EQ(a.quality.epsilon, b.quality.epsilon);
    EXPECT_EQ(a.quality.volume, b.quality.volume);
    EXPECT_EQ(a.quality.forceClosure, b.quality.forceClosure);
    EXPECT_EQ(a.quality.largestMass, b.quality.largestMass);
    EXPECT_EQ(a.source, b.source);
    ASSERT_EQ(a.contacts.size(), b.contacts.size());
    ASSERT_EQ(a.stops.size(), b.stops.size());
    for (std::size_t c = 0; c < a.contacts.size(); ++c)
    {
        EXPECT_EQ(a.contacts[c].link, b.contacts[c].link);
        EXPECT_EQ(a.contacts[c].point, b.contacts[c].point);
        EXPECT_EQ(a.contacts[c].normal, b.contacts[c].normal);
        EXPECT_EQ(a.contacts[c].gap, b.contacts[c].gap);
    }
    for (std::size_t s = 0; s < a.stops.size(); ++s)
    {
        EXPECT_EQ(a.stops[s].link, b.stops[s].link);
        EXPECT_EQ(a.stops[s].time, b.stops[s].time);
        EXPECT_EQ(a.stops[s].byObject, b.stops[s].byObject);
    }
}

TEST_F(GraspFile, ExactRecordsOfARealPlanReadBackToTheBit)
{
    m_hand = makeThreeFingers();
    m_run.obstaclesHash = "0123456789abcdef";
    const std::vector<Grasp> grasps =
        planGrasps(m_hand, m_object, {.candidates = 30}, [] { return kinematicClosing(); });
    const GraspRecorder recorder(m_run, m_hand, m_object);
    std::ofstream out(m_path);
    for (const Grasp& grasp : grasps)
    {
        out << recorder.exact(grasp) << '\n';
    }
    out.close();
    const std::vector<Grasp> read = readGrasps(m_path, m_hand);
    ASSERT_EQ(read.size(), grasps.size());
    int moved = 0;  // matrices that a round trip through the quaternion alone would change
    for (std::size_t k = 0; k < grasps.size(); ++k)
    {
        expectSameBits(read[k], grasps[k]);
        EXPECT_EQ(recorder.ranked(read[k], 1), recorder.ranked(grasps[k], 1));
        const Eigen::Quaterniond q(grasps[k].X_WStart.linear());
        moved += q.normalized().toRotationMatrix() == grasps[k].X_WStart.linear() ? 0 : 1;
    }
    EXPECT_GT(moved, 10);
    EXPECT_EQ(readGraspSource(m_path).run.obstaclesHash, m_run.obstaclesHash);
    EXPECT_EQ(readGraspSource(m_path).version, recorderVersion());
}

TEST_F(GraspFile, AMatrixThatIsNotThatOfItsQuaternionIsAnError)
{
    std::string record = GraspRecorder(m_run, m_hand, m_object).exact(anyGrasp(0));
    EXPECT_EQ(complaint(record), "");
    const std::string key = "\"rotation_rows\":[";
    record.insert(record.find(key) + key.size(), "9.0,");
    EXPECT_THAT(complaint(record), HasSubstr("10 numbers where 9 are needed"));
    std::string turned = GraspRecorder(m_run, m_hand, m_object).exact(anyGrasp(0));
    const std::size_t first = turned.find(key) + key.size();
    turned.replace(first, turned.find(',', first) - first, "2.5");
    EXPECT_THAT(complaint(turned), HasSubstr("its matrix and its quaternion differ"));
}

TEST_F(GraspFile, SourceRoundTripIsExact)
{
    write({anyGrasp(1)});
    const GraspFileSource source = readGraspSource(m_path);
    EXPECT_EQ(source.run.handFile, m_run.handFile);
    EXPECT_TRUE(source.run.srdfFile.empty());
    EXPECT_EQ(source.run.objectFile, m_run.objectFile);
    EXPECT_EQ(source.run.objectScale, m_run.objectScale);
    EXPECT_EQ(source.run.options.seed, m_run.options.seed);
    EXPECT_EQ(source.run.options.friction, m_run.options.friction);
    EXPECT_EQ(source.handHash, contentHash(m_hand));
    EXPECT_EQ(source.objectHash, contentHash(m_object));
}

TEST_F(GraspFile, KeepsTheOptionsOfTheApproach)
{
    for (const ApproachSource source : {ApproachSource::Sphere,
                                        ApproachSource::Surface,
                                        ApproachSource::Boxes,
                                        ApproachSource::Mixed})
    {
        const ApproachOptions asked{.source = source,
                                    .tableTop = true,
                                    .up = anyVector(),
                                    .maxTilt = 1.0 / 3.0,
                                    .standoff = 0.1 + 0.2,
                                    .reach = 1.0 / 7.0,
                                    .roll = RollLimits{-1.0 / 3.0, 0.7}};
        m_run.options.approach = asked;
        write({anyGrasp(1)});
        const ApproachOptions read = readGraspSource(m_path).run.options.approach;
        EXPECT_EQ(read.source, asked.source);
        EXPECT_EQ(read.tableTop, asked.tableTop);
        EXPECT_EQ(read.up, asked.up);
        EXPECT_EQ(read.maxTilt, asked.maxTilt);
        EXPECT_EQ(read.standoff, asked.standoff);
        EXPECT_EQ(read.reach, asked.reach);
        ASSERT_TRUE(read.roll.has_value());
        EXPECT_EQ(read.roll->from, asked.roll->from);
        EXPECT_EQ(read.roll->to, asked.roll->to);
    }
    m_run.options.approach.roll.reset();
    write({anyGrasp(1)});
    EXPECT_FALSE(readGraspSource(m_path).run.options.approach.roll.has_value());
}

TEST_F(GraspFile, RecordsWithoutOptionsOfTheApproachCanBeRead)
{
    write({anyGrasp(0)});
    std::string record = text();
    const std::string key = "\"approach\":{\"from\"";
    const std::size_t begin = record.find(key);
    ASSERT_NE(begin, std::string::npos);
    record.erase(begin, record.find("},", begin) + 2 - begin);
    EXPECT_EQ(complaint(record), "");
    const ApproachOptions read = readGraspSource(m_path).run.options.approach;
    EXPECT_EQ(read.source, ApproachSource::Sphere);
    EXPECT_FALSE(read.tableTop);
    EXPECT_EQ(read.up, ApproachOptions{}.up);
}

TEST_F(GraspFile, KeepsTheSrdfAndThePreshapes)
{
    m_run.srdfFile = "hands/three fingers.srdf";
    m_hand.preshapes = {{.name = "open", .positions = anyPositions()},
                        {.name = "unused", .positions = anyPositions()},
                        {.name = "pinch", .positions = anyPositions()}};
    std::vector<Grasp> grasps{anyGrasp(0), anyGrasp(1), anyGrasp(2)};
    grasps[0].preshape = "pinch";
    write(grasps);
    EXPECT_EQ(readGraspSource(m_path).run.srdfFile, m_run.srdfFile);
    const std::vector<Preshape> read = readPreshapes(m_path, m_hand);
    ASSERT_EQ(read.size(), 2U);
    EXPECT_EQ(read[0].name, "pinch");
    EXPECT_EQ(read[0].positions, m_hand.preshapes[2].positions);
    EXPECT_EQ(read[1].name, "open");
    EXPECT_EQ(read[1].positions, m_hand.preshapes[0].positions);
}

TEST_F(GraspFile, RecordsWithoutThePositionsOfPreshapesCanBeRead)
{
    m_hand.preshapes.clear();
    write({anyGrasp(0)});
    EXPECT_THAT(text(), HasSubstr("\"preshape_joints\":null"));
    EXPECT_TRUE(readPreshapes(m_path, m_hand).empty());
    EXPECT_EQ(readGrasps(m_path, m_hand).size(), 1U);
}

TEST_F(GraspFile, KeepsEveryReasonOfRejection)
{
    std::vector<Grasp> grasps;
    for (int k = 0; k <= static_cast<int>(RejectReason::IterationLimit); ++k)
    {
        Grasp grasp = anyGrasp(k);
        grasp.reject = static_cast<RejectReason>(k);
        grasps.push_back(grasp);
    }
    write(grasps);
    const std::vector<Grasp> read = readGrasps(m_path, m_hand);
    ASSERT_EQ(read.size(), grasps.size());
    for (std::size_t k = 0; k < read.size(); ++k)
    {
        EXPECT_EQ(read[k].reject, grasps[k].reject);
    }
}

TEST_F(GraspFile, KeepsACandidateWithoutAPosture)
{
    Grasp grasp;
    grasp.reject = RejectReason::NoApproachHit;
    grasp.preshape = "open";
    write({grasp});
    const std::vector<Grasp> read = readGrasps(m_path, m_hand);
    ASSERT_EQ(read.size(), 1U);
    EXPECT_TRUE(read[0].positions.empty());
}

TEST_F(GraspFile, SaysFramesAndUnitsInItsKeys)
{
    write({anyGrasp(0)});
    for (const char* key : {"\"schema\":\"bullet_ccd.grasp/1\"",
                            "\"hand_pose_in_object\":{\"position_m\":[",
                            "\"quaternion_wxyz\":[",
                            "\"normal_into_object\":[",
                            "\"torque_scale_m\":",
                            "\"joints\":{\"finger0_proximal_joint\":"})
    {
        EXPECT_THAT(text(), HasSubstr(key));
    }
}

TEST_F(GraspFile, ErrorsNameFileAndLine)
{
    write({anyGrasp(0), anyGrasp(1)});
    const std::string good = text();
    const std::string at = m_path.string();
    EXPECT_EQ(complaint("\n" + good + "\n  \n"), "");
    EXPECT_THAT(complaint(good.substr(0, good.size() - 40)), HasSubstr(at + ":2: not a JSON"));
    EXPECT_THAT(complaint(good + "{}\n"), HasSubstr(at + ":3: key \"schema\" is missing"));
    EXPECT_THAT(complaint("\n[1]\n"), HasSubstr(at + ":2: key \"schema\" is missing"));
    const auto changed = [&](const std::string& from, const std::string& to)
    {
        std::string copy = good;
        const std::size_t place = copy.rfind(from);
        EXPECT_NE(place, std::string::npos) << from;
        return complaint(copy.replace(place, from.size(), to));
    };
    EXPECT_THAT(changed("bullet_ccd.grasp/1", "other/9"), HasSubstr(at + ":2: schema \"other/9\""));
    EXPECT_THAT(changed("\"candidate\":1", "\"candidate\":\"x\""),
                HasSubstr(at + ":2: key \"candidate\": unexpected value \"x\""));
    // Python's writer puts words where JSON has none.
    for (const std::string word : {"NaN", "Infinity", "-Infinity", "nan", "inf"})
    {
        EXPECT_THAT(changed("\"candidate\":1", "\"candidate\":" + word),
                    HasSubstr(at + ":2: key \"candidate\": unexpected value " + word + ": "));
        EXPECT_THAT(changed("\"position_m\":[", "\"position_m\":[0.5, " + word + ","),
                    HasSubstr(at + ":2: key \"position_m\": unexpected value " + word + ": "));
    }
    EXPECT_THAT(changed("\"candidate\":1", "\"candidate\":1e999"),
                HasSubstr(at + ":2: a number is too large"));
    EXPECT_THAT(changed("\"link\":\"palm\"", "\"link\":\"elbow\""),
                HasSubstr(at + ":2: link \"elbow\" is not a link of three_fingers"));
    EXPECT_THAT(changed(contentHash(m_object), "0123456789abcdef"),
                HasSubstr(at + ":2: another hand or object"));
}

TEST_F(GraspFile, MissingAndEmptyFilesAreErrors)
{
    EXPECT_THROW(static_cast<void>(readGraspSource("/no/such/file.jsonl")), std::runtime_error);
    std::ofstream(m_path).close();
    EXPECT_THROW(static_cast<void>(readGraspSource(m_path)), std::runtime_error);
}

TEST(ContentHash, ChangesWithTheHandAndTheObject)
{
    HandModel hand = makeThreeFingers();
    const std::string before = contentHash(hand);
    EXPECT_EQ(before, contentHash(makeThreeFingers()));
    EXPECT_NE(before, contentHash(makeGripper(true)));
    EXPECT_NE(contentHash(makeGripper(false)), contentHash(makeGripper(true)));
    hand.robot.tree.links[2].joint.upper += 1e-12;
    EXPECT_NE(before, contentHash(hand));
    EXPECT_NE(contentHash(makeGraspObject("a", makeSphere(0.03, 2))),
              contentHash(makeGraspObject("a", makeSphere(0.03, 3))));
}

TEST(ContentHash, ChangesWithMeshesAndPosesOfObstacles)
{
    const SsvTree ball = buildSsvTree(makeSphere(0.03, 2));
    const SsvTree box = buildSsvTree(makeBox({0.1, 0.1, 0.1}));
    std::vector<RigidBody> obstacles;
    EXPECT_EQ(contentHash(obstacles), "");
    std::set<std::string> hashes{""};
    for (const SsvTree* tree : {&ball, &box})
    {
        for (const double x : {0.0, 1e-12})
        {
            obstacles = {
                {.tree = tree, .motion = restAt(Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)))}};
            hashes.insert(contentHash(obstacles));
        }
    }
    obstacles.push_back({.tree = &ball});
    hashes.insert(contentHash(obstacles));
    EXPECT_EQ(hashes.size(), 6U);
}
}  // namespace
}  // namespace bullet_ccd::grasp
