// What all benchmarks rest on: calls in processes of their own, choosing by name.
#include "benchmarks/support/chart.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/sandbox.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <gmock/gmock.h>
#include <stdexcept>
#include <thread>

namespace bullet_ccd::benchmarks
{
namespace
{
std::string sleepForEver()
{
    std::this_thread::sleep_for(std::chrono::seconds(600));
    return "";
}

std::string computeForEver()
{
    double sum = 0.0;
    while (sum >= 0.0)
    {
        sum += static_cast<double>(std::clock() >= 0);
    }
    return std::to_string(sum);
}

TEST(Sandbox, BringsBackTextOfAnyLength)
{
    const std::string text(1'000'000, 'x');
    const Sandboxed<std::string> one = runSandboxed(20.0, [&] { return text; });
    EXPECT_EQ(one.end, SandboxEnd::Answered);
    EXPECT_EQ(one.answer, text);
}

TEST(Sandbox, OutlivesCrashesExceptionsAndCallsThatNeverReturn)
{
    const auto call = [](int i) -> std::string
    {
        switch (i)
        {
            case 1:
                std::raise(SIGKILL);
                break;
            case 2:
                throw std::runtime_error("on purpose");
            case 4:
                return sleepForEver();
            case 5:
                return computeForEver();
            case 6:
                std::exit(0);
            default:
                break;
        }
        return std::to_string(i);
    };
    std::vector<SandboxEnd> ends;
    for (int i = 0; i < 8; ++i)
    {
        const Sandboxed<std::string> one = runSandboxed(0.1, [&] { return call(i); });
        EXPECT_TRUE(one.end != SandboxEnd::Answered || one.answer == std::to_string(ends.size()));
        ends.push_back(one.end);
    }
    EXPECT_THAT(ends,
                testing::ElementsAre(SandboxEnd::Answered,
                                     SandboxEnd::Crashed,
                                     SandboxEnd::Crashed,
                                     SandboxEnd::Answered,
                                     SandboxEnd::TimedOut,
                                     SandboxEnd::TimedOut,
                                     SandboxEnd::Crashed,
                                     SandboxEnd::Answered));
}

TEST(RunWithLimit, EndsACallThatTakesTooLongAndGoesOn)
{
    const auto ask = [](std::size_t i) -> ChartAnswer
    {
        if (i == 1)
        {
            sleepForEver();
        }
        return {.hit = true, .time = 0.1 * static_cast<double>(i)};
    };
    const std::vector<ChartAnswer> answers = runWithLimit(4, 0.1, ask);
    ASSERT_EQ(answers.size(), 4u);
    EXPECT_FALSE(answers[0].timedOut);
    EXPECT_TRUE(answers[1].timedOut);
    EXPECT_FALSE(answers[2].timedOut);
    EXPECT_DOUBLE_EQ(answers[3].time, 0.1 * 3.0);
}

TEST(Only, ChoosesByPartsOfNamesAndSaysWhatThereIs)
{
    const std::vector<ChartScene> all{{.name = "rods at sheets", .title = "", .methods = {}},
                                      {.name = "balls at sheets", .title = "", .methods = {}}};
    EXPECT_EQ(only(all, "").size(), 2u);
    EXPECT_EQ(only(all, "ball").at(0).name, "balls at sheets");
    EXPECT_THAT([&] { static_cast<void>(only(all, "thin")); },
                testing::ThrowsMessage<std::invalid_argument>(
                    testing::AllOf(testing::HasSubstr("--only thin"),
                                   testing::HasSubstr("rods at sheets\n  balls at sheets"))));
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
