#include "tools/ccd_cli/text/result_text.h"

#include "tools/support/csv_text.h"

#include <gtest/gtest.h>

#include <gmock/gmock.h>
#include <string>
#include <vector>

namespace bullet_ccd::tools
{
namespace
{
using ::testing::HasSubstr;
using ::testing::Not;

TimedAnswer answerOf(ToiStatus status)
{
    TimedAnswer answer;
    answer.microseconds = 12.5;
    answer.warmMicroseconds = 2.5;
    answer.result = {.status = status,
                     .time = 0.25,
                     .gap = 0.0625,
                     .triangleA = 3,
                     .triangleB = 4,
                     .pointA = {1.0, 2.0, 3.0},
                     .pointB = {1.0, 2.0, 5.0},
                     .normal = {0.0, 0.0, 1.0},
                     .counters = {.nodePairs = 20, .trianglePairs = 3, .states = 2}};
    return answer;
}

TEST(ResultText, AContactHasTheMiddleOfItsPointsAndTheNormal)
{
    for (const ToiStatus status : {ToiStatus::Hit, ToiStatus::TouchingPressing})
    {
        EXPECT_EQ(resultRow("a,b", answerOf(status), false),
                  "\"a,b\"," + statusWord(status) + ",0.25,0.0625,1,2,4,0,0,1,23,12.5");
    }
    TimedAnswer overlapping = answerOf(ToiStatus::Overlapping);
    overlapping.result.normal.setZero();
    EXPECT_EQ(resultRow("x", overlapping, true), "x,overlapping,0.25,0.0625,1,2,4,,,,23,12.5,2.5");
}

TEST(ResultText, WithoutContactTheCellsOfItAreEmpty)
{
    for (const ToiStatus status : {ToiStatus::Separated, ToiStatus::TouchingLeaving})
    {
        EXPECT_EQ(resultRow("x", answerOf(status), false),
                  "x," + statusWord(status) + ",0.25,0.0625,,,,,,,23,12.5");
        EXPECT_THAT(jsonText(answerOf(status), {}), HasSubstr("\"normal\": null"));
        EXPECT_THAT(jsonText(answerOf(status), {}), HasSubstr("\"contacts\": null"));
    }
    EXPECT_EQ(resultRow("x", answerOf(ToiStatus::IterationLimit), false),
              "x,iteration_limit,0.25,,,,,,,,23,12.5");
    EXPECT_EQ(resultRow("x", answerOf(ToiStatus::Stopped), false), "x,stopped,0.25,,,,,,,,23,12.5");
}

TEST(ResultText, EveryRowHasAsManyCellsAsTheHeader)
{
    for (const bool warm : {false, true})
    {
        const std::size_t columns = csvCells(resultHeader(warm))->size();
        EXPECT_EQ(csvCells(badResultRow("x", warm))->size(), columns);
        for (const ToiStatus status : {ToiStatus::Hit,
                                       ToiStatus::Separated,
                                       ToiStatus::Overlapping,
                                       ToiStatus::TouchingLeaving,
                                       ToiStatus::TouchingPressing,
                                       ToiStatus::IterationLimit,
                                       ToiStatus::Stopped})
        {
            EXPECT_EQ(csvCells(resultRow("x", answerOf(status), warm))->size(), columns);
        }
    }
}

TEST(ResultText, NumbersComeBackExactly)
{
    TimedAnswer answer = answerOf(ToiStatus::Hit);
    answer.result.time = 0.1 + 0.2;
    answer.result.gap = 1.0 / 3e9;
    const std::vector<std::string> cells = *csvCells(resultRow("x", answer, false));
    EXPECT_EQ(std::stod(cells[2]), answer.result.time);
    EXPECT_EQ(std::stod(cells[3]), answer.result.gap);
}

TEST(ResultText, TheReadableFormSaysWhatIsCertain)
{
    EXPECT_THAT(readableText(answerOf(ToiStatus::Hit), {}, {}),
                HasSubstr("not reached before t = 0.25"));
    EXPECT_THAT(readableText(answerOf(ToiStatus::Separated), {}, {}),
                HasSubstr("contact is never reached; the distance is always at least 0.0625"));
    EXPECT_THAT(readableText(answerOf(ToiStatus::Separated), {.minimumSeparation = 0.5}, {}),
                HasSubstr("a distance of 0.5 is never reached"));
    EXPECT_THAT(readableText(answerOf(ToiStatus::IterationLimit), {}, {}),
                HasSubstr("raise --max-iterations"));
    EXPECT_THAT(readableText(answerOf(ToiStatus::Stopped), {}, {}),
                HasSubstr("not reached before t = 0.25, what follows is unknown: raise --time"));
}

FeatureContact someContact(std::int32_t vertex)
{
    return {.featureA = {.kind = FeatureKind::Vertex, .vertices = {vertex, kNone, kNone}},
            .featureB = {.kind = FeatureKind::Face, .vertices = {1, 2, 3}},
            .triangleA = 7,
            .triangleB = 8,
            .pointA = {1.0, 2.0, 3.0},
            .pointB = {1.0, 2.0, 3.0625},
            .normal = {0.0, 0.0, 1.0},
            .gap = 0.0625};
}

TEST(ResultText, ContactsAreNamedByTheirFeatures)
{
    const TimedAnswer hit = answerOf(ToiStatus::Hit);
    std::vector<FeatureContact> contacts{someContact(5)};
    contacts.push_back(someContact(6));
    contacts[1].featureA = {.kind = FeatureKind::Edge, .vertices = {6, 11, kNone}};
    contacts[1].featureB = {.kind = FeatureKind::Edge, .vertices = {2, 3, kNone}};
    const std::string shown = readableText(hit, {.tolerance = 0.125}, contacts);
    EXPECT_THAT(shown, HasSubstr("contacts    2 within 0.125"));
    EXPECT_THAT(shown, HasSubstr("vertex 5 - face 1 2 3  0.0625     1 2 3.03125  0.0000 0.0000 1"));
    EXPECT_THAT(shown, HasSubstr("edge 6 11 - edge 2 3   0.0625"));
    EXPECT_THAT(shown, Not(HasSubstr("more")));
    const std::string json = jsonText(hit, contacts);
    EXPECT_THAT(json,
                HasSubstr(R"("contacts": [
    {"a": {"kind": "vertex", "vertices": [5], "triangle": 7}, )"
                          R"("b": {"kind": "face", "vertices": [1, 2, 3], "triangle": 8}, )"
                          R"("gap": 0.0625, "point_a": [1, 2, 3], "point_b": [1, 2, 3.0625], )"
                          R"("normal": [0, 0, 1]},)"));
    EXPECT_THAT(json, HasSubstr(R"("vertices": [6, 11])"));
}

TEST(ResultText, OfManyContactsTheFirstTwentyAreShownAndAllAreInTheJson)
{
    std::vector<FeatureContact> contacts;
    for (std::int32_t k = 100; k < 123; ++k)
    {
        contacts.push_back(someContact(k));
    }
    const TimedAnswer hit = answerOf(ToiStatus::Hit);
    const std::string shown = readableText(hit, {}, contacts);
    EXPECT_THAT(shown, HasSubstr("vertex 119 "));
    EXPECT_THAT(shown, Not(HasSubstr("vertex 120 ")));
    EXPECT_THAT(shown, HasSubstr("and 3 more"));
    EXPECT_THAT(jsonText(hit, contacts), HasSubstr("[122]"));
    contacts.resize(20);
    EXPECT_THAT(readableText(hit, {}, contacts), Not(HasSubstr("more")));
}
}  // namespace
}  // namespace bullet_ccd::tools
