// The verb reduce, as a user runs it.
#include "bullet_ccd/io/mesh_file.h"
#include "tests/tools/bullet_ccd_program.h"

#include <gtest/gtest.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::AllOf;
using ::testing::HasSubstr;

class ReduceProgram : public BulletCcdProgram
{
protected:
    [[nodiscard]] Outcome reduce(const std::string& arguments) const
    {
        return run("reduce '" + m_mesh.string() + "' -o '" + m_output.string() + "' " + arguments);
    }
    void SetUp() override { writeObj(makeTorus(0.06, 0.02, 40, 20), m_mesh); }

    std::filesystem::path m_mesh = m_temp.path() / "torus.obj";
    std::filesystem::path m_output = m_temp.path() / "small.obj";
};

TEST_F(ReduceProgram, WritesAModelAndItsCertificate)
{
    const Outcome outcome = reduce("--accuracy 2e-3 --json");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(report["kind"], "mesh");
    EXPECT_EQ(report["full_triangles"], 1600);
    EXPECT_EQ(report["triangles"], loadMeshFile(m_output).mesh.triangles.size());
    EXPECT_LT(report["triangles"], 1200);
    EXPECT_LE(report["deviation"], 2e-3);

    const Outcome ball = reduce("--accuracy 0.1 --json");
    ASSERT_EQ(ball.exitCode, 0) << ball.err;
    const auto sphere = nlohmann::json::parse(ball.out);
    EXPECT_EQ(sphere["kind"], "sphere");
    EXPECT_NEAR(sphere["radius"], 0.08, 1e-3);
}

TEST_F(ReduceProgram, SaysWhatIsWrong)
{
    const Outcome none = reduce("--accuracy 1e-3 --kind box");
    EXPECT_EQ(none.exitCode, 1);
    EXPECT_THAT(none.err, HasSubstr("no box keeps the accuracy of 0.001"));
    EXPECT_FALSE(std::filesystem::exists(m_output));

    const Outcome zero = reduce("--accuracy 0");
    EXPECT_EQ(zero.exitCode, 3);
    EXPECT_THAT(zero.err,
                HasSubstr("torus.obj: the accuracy is 0: it must be a length of at least"));
    EXPECT_EQ(reduce("").exitCode, 2);
    EXPECT_EQ(reduce("--accuracy 1e-3 --kind ball").exitCode, 2);
    EXPECT_EQ(
        run("reduce '" + m_mesh.string() + "' -o '" + m_mesh.string() + "' --accuracy 1").exitCode,
        3);
}
TEST_F(ReduceProgram, AdviseKeepsItsPromiseAndChooses)
{
    const std::filesystem::path chart = m_output.parent_path() / "chart.svg";
    const Outcome outcome = run("advise '" + m_mesh.string() + "' --accuracy 2e-3 -o '" +
                                m_output.string() + "' --chart '" + chart.string() + "'");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
    // One row per accuracy, and one for the full meshes; contacts that broke the promise are last.
    std::istringstream text(outcome.out);
    int rows = 0;
    for (std::string line; std::getline(text, line) && !line.empty();)
    {
        const std::size_t last = line.find_last_of(' ');
        rows += line.substr(last + 1) == "0" ? 1 : 0;
    }
    EXPECT_EQ(rows, 8);
    EXPECT_THAT(contentOf(chart), AllOf(HasSubstr("<polyline"), HasSubstr("</svg>")));
    EXPECT_THAT(contentOf(m_output),
                AllOf(HasSubstr("accuracy: 0.002"), HasSubstr("tolerance: 0.0004")));

    EXPECT_EQ(run("advise '" + m_mesh.string() + "' --microseconds 1e-9").exitCode, 1);
    EXPECT_EQ(run("advise '" + m_mesh.string() + "' -o '" + m_output.string() + "'").exitCode, 2);
}
}  // namespace
}  // namespace bullet_ccd::tools
