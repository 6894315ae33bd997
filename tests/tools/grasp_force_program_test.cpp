// `grasp force`, `grasp quality` and `grasp trial` as a user runs them.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/run_program.h"

#include <Eigen/Core>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class GraspForceProgram : public ::testing::Test
{
protected:
    static void SetUpTestSuite()
    {
        s_folder = new tests::TempFolder;
        const fs::path ball = s_folder->path() / "ball.obj";
        writeObj(makeSphere(0.03, 3), ball);
        const Outcome planned = runProgram(
            std::string(BULLET_CCD_GRASP_PROGRAM) + " plan --hand three_finger_gripper --object '" +
            ball.string() + "' -n 4 --pictures 0 -q -o '" + s_folder->path().string() + "'");
        ASSERT_EQ(planned.exitCode, 0) << planned.err;
    }
    static void TearDownTestSuite() { delete s_folder; }

    static Outcome run(const std::string& verb, const std::string& options)
    {
        return runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " " + verb + " '" +
                          (s_folder->path() / "grasps.jsonl").string() + "' " + options);
    }

    static std::vector<nlohmann::json> records(const std::string& options)
    {
        std::istringstream lines(run("force", "--json " + options).out);
        std::vector<nlohmann::json> result;
        for (std::string line; std::getline(lines, line);)
        {
            result.push_back(nlohmann::json::parse(line));
        }
        return result;
    }

    static tests::TempFolder* s_folder;
};
tests::TempFolder* GraspForceProgram::s_folder = nullptr;

TEST_F(GraspForceProgram, ForcesCarryTheWeight)
{
    const std::vector<nlohmann::json> all = records("--mass 0.5");
    ASSERT_FALSE(all.empty());
    for (const nlohmann::json& record : all)
    {
        ASSERT_EQ(record["status"], "balanced");
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double normals = 0.0;
        for (const nlohmann::json& contact : record["contacts"])
        {
            const auto force = contact["force_on_object_n"].get<std::vector<double>>();
            sum += Eigen::Vector3d(force[0], force[1], force[2]);
            normals += contact["normal_n"].get<double>();
        }
        EXPECT_LT((sum - Eigen::Vector3d(0.0, 0.0, 0.5 * 9.80665)).norm(), 1e-6);
        EXPECT_NEAR(normals, record["value_n"].get<double>(), 1e-6);
        EXPECT_FALSE(record["joints"].empty());
    }
}

TEST_F(GraspForceProgram, OptionsReachTheProblem)
{
    // The ball weighs what its volume says.
    const double mass = 1000.0 * massProperties(makeSphere(0.03, 3)).volume;
    const double value = records("--rank 1")[0]["value_n"];
    EXPECT_NEAR(
        records("--rank 1 --mass 1")[0]["value_n"].get<double>(), value / mass, 1e-5 * value);
    EXPECT_GT(records("--rank 1 --friction 0.3")[0]["value_n"].get<double>(), value);
    EXPECT_GE(records("--rank 1 --solver lp --cone-edges 6")[0]["value_n"].get<double>(),
              value * (1.0 - 1e-7));
    EXPECT_LE(records("--rank 1 --model soft")[0]["value_n"].get<double>(), value * (1.0 + 1e-7));
    EXPECT_LE(records("--rank 1 --objective max")[0]["value_n"].get<double>(), value);
    const nlohmann::json side = records("--rank 1 --gravity 2 0 0 --wrench 0 1 0 0 0 0")[0];
    EXPECT_NEAR(side["load"][0].get<double>(), mass * 9.80665, 1e-9);
    EXPECT_NEAR(side["load"][1].get<double>(), 1.0, 1e-12);
    EXPECT_NEAR(side["load"][2].get<double>(), 0.0, 1e-12);
    const nlohmann::json any = records("--rank 1 --any-wrench 0.5")[0];
    const double necessary = any["any_wrench"]["necessary_n"].get<double>();
    EXPECT_GE(any["any_wrench"]["guaranteed_n"].get<double>(), necessary);
    EXPECT_GT(necessary, value);
    const nlohmann::json firm = records("--rank 1 --objective firm --max-force 20")[0];
    EXPECT_GT(firm["value_n"].get<double>(), 0.0);
    EXPECT_LE(firm["value_n"].get<double>(), 0.5 * 20.0);
}

TEST_F(GraspForceProgram, TheMassFollowsFromTheVolumeForEveryVerb)
{
    const double mass = 1000.0 * massProperties(makeSphere(0.03, 3)).volume;
    std::istringstream lines(contentOf(s_folder->path() / "grasps.jsonl"));
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    const nlohmann::json best = nlohmann::json::parse(line);
    EXPECT_EQ(best["plan"]["mass_from"], "volume");
    EXPECT_NEAR(best["plan"]["mass_kg"].get<double>(), mass, 1e-9);
    EXPECT_NEAR(best["quality"]["weight"]["mass_kg"].get<double>(), mass, 1e-9);
    EXPECT_NEAR(best["squeeze"]["mass_kg"].get<double>(), mass, 1e-9);
    std::array<char, 16> digits{};
    std::snprintf(digits.data(), digits.size(), "%.3g", mass);
    const std::string said = "the object's mass is " + std::string(digits.data()) +
                             " kg (volume of the closed mesh at 1000 kg/m3)";
    EXPECT_THAT(run("force", "--rank 1").err, HasSubstr(said));
    EXPECT_THAT(run("force", "--rank 1 --mass 0.2").err, HasSubstr("mass is 0.2 kg (given)"));
    EXPECT_THAT(run("trial", "--rank 1 --protocol hover --time-limit 0.001").err, HasSubstr(said));
}

TEST_F(GraspForceProgram, ExportsModelsForMuJoCo)
{
    const fs::path folder = s_folder->path() / "mjcf";
    const Outcome done =
        run("export", "--rank 1 --mass 0.2 --pieces 4 -o '" + folder.string() + "'");
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr("convex pieces of the hand bulge by up to"));
    EXPECT_THAT(contentOf(folder / "grasp_01.xml"), HasSubstr("<key name=\"squeeze\""));
    EXPECT_TRUE(fs::exists(folder / "meshes" / "object_0.obj"));
    EXPECT_EQ(run("export", "--rank 99 -o '" + folder.string() + "'").exitCode, 3);
    EXPECT_EQ(run("export", "--rank 1").exitCode, 2);
    const Outcome blocked =
        run("export", "--rank 1 -o '" + (s_folder->path() / "ball.obj").string() + "'");
    EXPECT_EQ(blocked.exitCode, 3);
    EXPECT_THAT(blocked.err, HasSubstr("give a folder"));
}

TEST_F(GraspForceProgram, ImpossibleLoadsExitWith1AndTheReason)
{
    const Outcome weak = run("force", "--effort 1e-4");
    EXPECT_EQ(weak.exitCode, 1);
    EXPECT_THAT(weak.out, HasSubstr("infeasible: joint torque limits: joint "));
    EXPECT_THAT(weak.out, HasSubstr("0 of "));
    const Outcome slippery = run("force", "--model frictionless --wrench 0 0 0 0 0 1");
    EXPECT_EQ(slippery.exitCode, 1);
    EXPECT_THAT(slippery.out, HasSubstr("friction cones alone"));
    const Outcome endless = run("force", "--rank 1 --objective firm --effort 0");
    EXPECT_EQ(endless.exitCode, 1);
    EXPECT_THAT(endless.out, HasSubstr("unbounded"));
    EXPECT_THAT(endless.err, HasSubstr("taken as unlimited"));
}

TEST_F(GraspForceProgram, EffortsOfSingleJointsCount)
{
    const std::string joint = records("--rank 1")[0]["joints"][0]["joint"];
    const Outcome set = run("force", "--rank 1 --effort 3 --effort " + joint + "=2.5");
    EXPECT_EQ(set.exitCode, 0) << set.err;
    EXPECT_THAT(set.out, HasSubstr(" 2.5 "));
    EXPECT_THAT(set.err, Not(HasSubstr("unlimited")));
    const Outcome unknown = run("force", "--effort elbow=2");
    EXPECT_EQ(unknown.exitCode, 3);
    EXPECT_THAT(unknown.err, HasSubstr("elbow"));
    EXPECT_THAT(unknown.err, HasSubstr(joint));
    EXPECT_EQ(run("force", "--effort much").exitCode, 2);
    EXPECT_EQ(run("force", "--effort a=-1").exitCode, 2);
    for (const std::string none : {"0", "-1", "finger=0", "finger=-1", "inf", "much"})
    {
        const Outcome zero = run("trial", "--effort " + none);
        EXPECT_EQ(zero.exitCode, 2);
        EXPECT_THAT(zero.err,
                    HasSubstr("--effort: " + none +
                              " is no effort to squeeze with: give a number above 0"));
    }
}

TEST_F(GraspForceProgram, ChoicesThatTheFileDoesNotHaveExitWith3)
{
    EXPECT_EQ(run("force", "--rank 99").exitCode, 3);
    EXPECT_THAT(run("force", "--candidate 99").err, HasSubstr("no grasp of candidate 99"));
    EXPECT_EQ(run("force", "--mass nan").exitCode, 2);
    EXPECT_EQ(run("force", "--gravity 0 0 0").exitCode, 2);
    EXPECT_EQ(run("force", "--objective hard").exitCode, 2);
}

TEST_F(GraspForceProgram, RanksAreThoseOfTheRecords)
{
    std::istringstream lines(contentOf(s_folder->path() / "grasps.jsonl"));
    std::vector<std::string> records;
    for (std::string line; std::getline(lines, line);)
    {
        records.push_back(line);
    }
    ASSERT_GE(records.size(), 3U);
    const fs::path file = s_folder->path() / "some.jsonl";
    const auto ranks = [&](const std::string& options)
    {
        const Outcome solved = runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " force '" +
                                          file.string() + "' --json " + options);
        std::istringstream out(solved.out);
        std::vector<int> found;
        for (std::string line; std::getline(out, line);)
        {
            found.push_back(nlohmann::json::parse(line)["rank"].get<int>());
        }
        return std::pair(found, solved);
    };
    // The first line is cut off; the third rank comes before the second.
    std::ofstream(file) << records[0].substr(0, 200) << '\n' << records[2] << '\n' << records[1];
    EXPECT_EQ(ranks("").first, (std::vector{3, 2}));
    EXPECT_EQ(ranks("--rank 2").first, std::vector{2});
    EXPECT_THAT(ranks("--rank 1").second.err, HasSubstr("no grasp of rank 1: it has 2, 3"));
    std::ofstream(file) << records[1] << '\n' << records[1];
    const auto [once, twice] = ranks("");
    EXPECT_EQ(once, std::vector{2});
    EXPECT_EQ(twice.exitCode, 3);
    EXPECT_THAT(twice.err, HasSubstr("some.jsonl:2: key \"rank\": 2 is that of line 1, too"));
    EXPECT_THAT(runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " trial '" + file.string() +
                           "' --brief --json --protocol hover --mass 0.05")
                    .out,
                HasSubstr("\"rank\":2"));
}

TEST_F(GraspForceProgram, RecordsThatMakeNoSenseAreNamed)
{
    const std::string records = contentOf(s_folder->path() / "grasps.jsonl");
    const std::string first = records.substr(0, records.find('\n'));
    const fs::path file = s_folder->path() / "odd.jsonl";
    const auto errorOf = [&](const std::string& pointer, const nlohmann::ordered_json& value)
    {
        nlohmann::ordered_json record = nlohmann::ordered_json::parse(first);
        record[nlohmann::ordered_json::json_pointer(pointer)] = value;
        std::ofstream(file) << record.dump() << '\n';
        const Outcome refused = runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " trial '" +
                                           file.string() + "' --brief --protocol hover");
        EXPECT_EQ(refused.exitCode, 3) << pointer;
        return refused.err;
    };
    EXPECT_THAT(errorOf("/quality/friction", 0.0),
                HasSubstr("odd.jsonl:1: key \"friction\": 0.0 is not above 0"));
    EXPECT_THAT(errorOf("/object/scale", -1.0),
                HasSubstr("odd.jsonl:1: key \"scale\": -1.0 is not above 0"));
    EXPECT_THAT(errorOf("/rank", 0), HasSubstr("odd.jsonl:1: key \"rank\": 0"));
    EXPECT_THAT(errorOf("/object/file", "/nowhere/x.obj"),
                HasSubstr("/nowhere/x.obj is not there any more: say where it is with --object"));
    EXPECT_THAT(errorOf("/hand/urdf", "/nowhere/x.urdf"), HasSubstr("with --hand"));
    const Outcome folder = runProgram(std::string(BULLET_CCD_GRASP_PROGRAM) + " trial '" +
                                      s_folder->path().string() + "'");
    EXPECT_EQ(folder.exitCode, 3);
    EXPECT_THAT(folder.err, HasSubstr("cannot be opened: give a file that grasp plan wrote"));
}

TEST_F(GraspForceProgram, RowsOfTrialsSayWhatWasAsked)
{
    const nlohmann::json row = nlohmann::json::parse(
        run("trial",
            "--rank 1 --json --protocol hover --brief --mass 0.05 --friction 0.4 "
            "--surface-friction 0.6 --rate 120 --seed 18446744073709551615")
            .out);
    EXPECT_EQ(row["hand"], "three_finger_gripper");
    EXPECT_EQ(row["object"], "ball");
    EXPECT_EQ(row["mass_kg"], 0.05);
    EXPECT_EQ(row["friction"], 0.4);
    EXPECT_EQ(row["surface_friction"], 0.6);
    EXPECT_EQ(row["rate_hz"], 120.0);
    EXPECT_EQ(row["seed"], 18446744073709551615U);
    EXPECT_EQ(row["brief"], true);
}

TEST_F(GraspForceProgram, OutputThatIsLostExitsWith3)
{
    if (!fs::exists("/dev/full"))
    {
        GTEST_SKIP() << "no device that is always full";
    }
    const std::string hover = "--rank 1 --brief --mass 0.05 --protocol hover ";
    for (const auto& [verb, options] : {std::pair<std::string, std::string>{"trial", hover},
                                        {"trial", hover + "--json"},
                                        {"quality", ""}})
    {
        const Outcome lost = run(verb, options + " > /dev/full");
        EXPECT_EQ(lost.exitCode, 3) << verb;
        EXPECT_THAT(lost.err, HasSubstr("cannot be written")) << verb;
    }
}

TEST_F(GraspForceProgram, FilmsThatFailCostNoResults)
{
    const std::string hover = "--rank 1 --brief --mass 0.05 --protocol hover --json --films '";
    const Outcome blocked =
        run("trial", hover + (s_folder->path() / "ball.obj" / "films").string() + "'");
    EXPECT_EQ(blocked.exitCode, 3);
    EXPECT_EQ(blocked.out, "");
    EXPECT_THAT(blocked.err, HasSubstr("--films"));
    EXPECT_THAT(blocked.err, HasSubstr("Not a directory"));
    const fs::path films = s_folder->path() / "films";
    fs::create_directories(films / "hover_01.png" / "in the way");
    const Outcome tried = run("trial", hover + films.string() + "'");
    EXPECT_EQ(tried.exitCode, 3);
    EXPECT_THAT(tried.out, HasSubstr("\"rank\":1"));
    EXPECT_THAT(tried.err, HasSubstr("hover_01.png"));
}

// The row of rank 1 with the plan's own options: the recorded epsilon again, within the cones'
// bounds.
TEST_F(GraspForceProgram, QualityRecomputesWhatWasRecorded)
{
    const Outcome out = run("quality", "--rank 1 --tolerance 1e-4");
    ASSERT_EQ(out.exitCode, 0) << out.err;
    std::istringstream text(out.out.substr(out.out.find('\n') + 1));
    double rank = 0, candidate = 0, contacts = 0, recorded = 0, pyramids = 0, volume = 0, lower = 0,
           upper = 0;
    text >> rank >> candidate >> contacts >> recorded >> pyramids >> volume >> lower >> upper;
    EXPECT_LE(recorded, upper + 2e-6);  // plans take exact cones, to a hundredth
    EXPECT_GE(recorded, 0.99 * lower - 2e-6);
    EXPECT_LE(pyramids, upper + 2e-6);
    EXPECT_LE(upper - lower, 1.1e-4);
    EXPECT_THAT(out.out, HasSubstr("yes"));
    EXPECT_EQ(run("quality", "--rank 1 --model frictionless").exitCode, 1);
    EXPECT_EQ(run("quality", "--rank 1 --norm l7").exitCode, 2);
}
std::vector<nlohmann::json> jsonLines(const std::string& text)
{
    std::istringstream lines(text);
    std::vector<nlohmann::json> result;
    for (std::string line; std::getline(lines, line);)
    {
        result.push_back(nlohmann::json::parse(line));
    }
    return result;
}

TEST(GraspTrialProgram, PlansRankByWhatHeldAndSayHowToSqueeze)
{
    const tests::TempFolder folder;
    const fs::path ball = folder.path() / "ball.obj";
    writeObj(makeSphere(0.03, 3), ball);
    const fs::path protocol = folder.path() / "brief.yaml";
    std::ofstream(protocol) << "phases:\n  - load: {seconds: 0.1}\n";
    const std::string program(BULLET_CCD_GRASP_PROGRAM);
    const Outcome planned =
        runProgram(program + " plan --hand three_finger_gripper --object '" + ball.string() +
                   "' -n 4 --pictures 0 -q --mass 0.1 --tried 2 --trial '" + protocol.string() +
                   "' -o '" + folder.path().string() + "'");
    ASSERT_EQ(planned.exitCode, 0) << planned.err;
    EXPECT_THAT(planned.out, HasSubstr("trials"));
    EXPECT_THAT(planned.out, HasSubstr("brief held"));
    const std::vector<nlohmann::json> records =
        jsonLines(contentOf(folder.path() / "grasps.jsonl"));
    ASSERT_EQ(records.size(), 4U);
    const nlohmann::json& best = records[0];
    EXPECT_TRUE(best["trials"][0]["held"].get<bool>());
    EXPECT_EQ(best["trials"][0]["protocol"], "brief");
    EXPECT_TRUE(best["squeeze"]["reason"].is_null());
    EXPECT_GE(best["squeeze"]["normal_forces_n"].get<double>(), 12.0 * 0.98067 / 0.5 - 0.01);
    EXPECT_GT(best["squeeze"]["weights_held"].get<double>(), 1.0);
    EXPECT_LT(best["squeeze"]["weights_held"].get<double>(), 6.0 + 1e-6);
    for (const auto& [name, joint] : best["squeeze"]["joints"].items())
    {
        const double error = joint["target"].get<double>() - best["joints"][name].get<double>();
        EXPECT_NEAR(joint["stiffness"].get<double>() * error, joint["torque"].get<double>(), 1e-9);
        EXPECT_LE(std::abs(joint["torque"].get<double>()), joint["effort"].get<double>() + 1e-9);
    }
    EXPECT_TRUE(records[3]["trials"].is_null());
    const std::string again = program + " plan --hand three_finger_gripper --object '" +
                              ball.string() + "' -n 8 --pictures 0 -q --mass 0.1 -o '" +
                              (folder.path() / "scored").string() + "' --rank ";
    ASSERT_EQ(runProgram(again + "score").exitCode, 0);
    EXPECT_EQ(runProgram(again + "volume").exitCode, 2);
    double before = 1.0;
    for (const nlohmann::json& record : jsonLines(contentOf(folder.path() / "scored/grasps.jsonl")))
    {
        if (!record["reject"].is_null())
        {
            break;
        }
        const double score = record["quality"]["hold_score"].get<double>();
        EXPECT_LE(score, before);
        before = score;
    }
    EXPECT_LT(before, 1.0);
    EXPECT_EQ(best["plan"]["mass_kg"], 0.1);
    EXPECT_EQ(best["plan"]["mass_from"], "given");

    const std::string file = (folder.path() / "grasps.jsonl").string();
    // The mass is that of the plan.
    const std::string trial = program + " trial '" + file + "' --json -j 1 --protocol '";
    const Outcome tried = runProgram(trial + protocol.string() + "' --rank 1");
    EXPECT_EQ(tried.exitCode, 0) << tried.err;
    const std::vector<nlohmann::json> trials = jsonLines(tried.out);
    ASSERT_EQ(trials.size(), 1U);
    EXPECT_EQ(trials[0]["outcome"], "held");
    EXPECT_LT(trials[0]["slip_m"].get<double>(), 1e-3);
    // Bit for bit, although the record has turned the rotation into a quaternion.
    EXPECT_EQ(trials[0]["slip_m"], best["trials"][0]["slip_m"]);
    EXPECT_EQ(trials[0]["turn_rad"], best["trials"][0]["turn_rad"]);

    // With an accuracy the models are smaller, and what held still holds.
    const Outcome coarse = runProgram(trial + protocol.string() + "' --rank 1 --accuracy 2e-3");
    EXPECT_EQ(coarse.exitCode, 0) << coarse.err;
    EXPECT_EQ(jsonLines(coarse.out).at(0)["outcome"], "held");
    std::size_t triangles = 0;
    std::size_t ofTriangles = 0;
    const std::size_t at = coarse.err.find("models: ");
    ASSERT_NE(at, std::string::npos) << coarse.err;
    const std::string numbers = coarse.err.substr(coarse.err.find("; ", at) + 2);
    ASSERT_EQ(std::sscanf(numbers.c_str(), "%zu of %zu triangles", &triangles, &ofTriangles), 2)
        << coarse.err;
    EXPECT_GT(ofTriangles, makeSphere(0.03, 3).triangles.size());
    EXPECT_LT(triangles, ofTriangles / 2);
    // Surfaces rest on each other at the gap that they have anyway, so the full meshes keep apart.
    EXPECT_THAT(coarse.err, HasSubstr("full meshes were inside each other by 0.000 mm at most"));
    EXPECT_EQ(jsonLines(coarse.out).at(0)["penetration_m"], 0.0);
    const Outcome fine = runProgram(trial + protocol.string() + "' --accuracy 1e-6");
    EXPECT_EQ(fine.exitCode, 2);
    EXPECT_THAT(fine.err, HasSubstr("1e-05"));

    // A stop ends what runs and keeps what is done.
    const fs::path endless = folder.path() / "endless.yaml";
    std::ofstream(endless) << "phases:\n  - load: {seconds: 600}\n";
    const std::string out = (folder.path() / "out.jsonl").string();
    const Outcome stopped = runProgram("{ " + trial + protocol.string() + "," + endless.string() +
                                       "' > '" + out + "' & pid=$!; turn=0; until test -s '" + out +
                                       "' || ! kill -0 $pid || test $turn = 600; do sleep 0.05; " +
                                       "turn=$((turn + 1)); done; kill -TERM $pid; wait $pid; }");
    EXPECT_EQ(stopped.exitCode, 128 + 15);
    EXPECT_THAT(stopped.err, HasSubstr("stopped after 0 of 4 grasps"));
    ASSERT_EQ(jsonLines(contentOf(out)).size(), 1U);
    EXPECT_EQ(jsonLines(contentOf(out))[0], trials[0]);

    // What it looked like.
    const fs::path films = folder.path() / "films";
    const Outcome filmed =
        runProgram(trial + protocol.string() + "' --rank 1 --films '" + films.string() + "'");
    EXPECT_EQ(filmed.out, tried.out);
    EXPECT_EQ(contentOf(films / "brief_01.glb").substr(0, 4), "glTF");
    EXPECT_THAT(contentOf(films / "brief_01.glb"), HasSubstr("\"animations\""));
    EXPECT_EQ(contentOf(films / "brief_01.png").substr(1, 3), "PNG");

    // What a heavy load pulls off is moved and tried again; the records are of what was tried
    // last.
    const fs::path heavy = folder.path() / "heavy.yaml";
    std::ofstream(heavy) << "phases:\n  - load: {weights: 6, seconds: 0.3}\n";
    const fs::path refined = folder.path() / "refined";
    const Outcome replanned =
        runProgram(program + " plan --hand parallel_gripper --object '" + ball.string() +
                   "' -n 8 --pictures 0 -q --mass 0.1 --tried 3 --refine 1 --trial '" +
                   heavy.string() + "' -o '" + refined.string() + "'");
    ASSERT_EQ(replanned.exitCode, 0) << replanned.err;
    EXPECT_THAT(replanned.out, HasSubstr(" grasps hold in more trials than before"));
    const std::string lines = (refined / "grasps.jsonl").string();
    const std::vector<nlohmann::json> last = jsonLines(
        runProgram(program + " trial '" + lines + "' --json --protocol '" + heavy.string() + "'")
            .out);
    const std::vector<nlohmann::json> noted = jsonLines(contentOf(lines));
    ASSERT_GE(last.size(), 3U);
    for (std::size_t k = 0; k < 3; ++k)
    {
        const nlohmann::json& note = noted[k]["trials"][0];
        EXPECT_EQ(last[k]["slip_m"], note["slip_m"]);
        EXPECT_EQ(last[k]["reason"], note["reason"]);
        EXPECT_EQ(note["reason"].is_null(), note["held"].get<bool>());
    }

    // A damaged record does not take the others with it.
    std::string damaged = contentOf(file);
    damaged.insert(0, "{\"schema\": \"bullet_ccd.grasp/1\"\n");
    std::ofstream(file) << damaged;
    const Outcome others = runProgram(trial + protocol.string() + "' --rank 1");
    EXPECT_EQ(others.exitCode, 3);
    EXPECT_THAT(others.err, HasSubstr("left out: " + file + ":1: not a JSON record"));
    ASSERT_EQ(jsonLines(others.out).size(), 1U);
    EXPECT_EQ(jsonLines(others.out)[0], trials[0]);

    const Outcome empty = runProgram(trial + "lift,,six'");
    EXPECT_EQ(empty.exitCode, 3);
    EXPECT_THAT(empty.err, HasSubstr("--protocol lift,,six: a name is missing"));

    const Outcome unknown = runProgram(program + " trial '" + file + "' --protocol lfit");
    EXPECT_EQ(unknown.exitCode, 3);
    EXPECT_THAT(unknown.err, HasSubstr("six, hover, shake, lift, pull, disturb"));
}
}  // namespace
}  // namespace bullet_ccd::tools
