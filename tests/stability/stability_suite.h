/// What the suites over all rigid and all articulated cases share: every case with every strategy,
/// as it is and under every relation.
#pragma once

#include "benchmarks/reference/catalogue/relations.h"
#include "tests/support/test_parameters.h"

#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <tuple>
#include <vector>

namespace bullet_ccd::reference
{
inline void PrintTo(const RigidCase& tested, std::ostream* out)
{
    *out << tested.id;
}

inline void PrintTo(const ArticulatedCase& tested, std::ostream* out)
{
    *out << tested.id;
}
}  // namespace bullet_ccd::reference

namespace bullet_ccd::tests
{
template <typename Case>
class StabilitySuite : public testing::TestWithParam<std::tuple<Case, ToiStrategy>>
{
public:
    [[nodiscard]] static auto everyWay(const std::vector<Case>& cases)
    {
        return testing::Combine(testing::ValuesIn(cases), kAllStrategies);
    }
    [[nodiscard]] static std::string nameOfWay(
        const testing::TestParamInfo<std::tuple<Case, ToiStrategy>>& way)
    {
        return std::get<0>(way.param).id + "_" + codeOf(std::get<1>(way.param));
    }

protected:
    [[nodiscard]] const Case& tested() const { return std::get<0>(this->GetParam()); }
    [[nodiscard]] ToiStrategy strategy() const { return std::get<1>(this->GetParam()); }
};

/// `time` in the whole motion of the case.
inline void expectTime(double time,
                       const reference::CaseAnswer& answer,
                       double tolerance,
                       double rounding)
{
    const reference::RightTimes right = rightTimes(answer, tolerance, rounding);
    EXPECT_LE(time, right.latest) << "late";
    EXPECT_GE(time, right.earliest) << "early";
}

/// The legs one after the other, until one has a contact.
/// @param ask answers a case at a tolerance and checks what an answer has to be in any case
template <typename Case, typename Ask>
void expectVariant(const reference::Variant<Case>& variant, const Ask& ask)
{
    const reference::CaseAnswer& answer = variant.answer;
    const double tolerance = answer.finest();
    for (const reference::Leg<Case>& leg : variant.legs)
    {
        const double rounding = roundingOf(leg.tested);
        const auto result = ask(leg.tested, tolerance);
        if (isContact(result.status))
        {
            ASSERT_TRUE(answer.time || answer.clearance <= tolerance + rounding) << "false contact";
            if (answer.time)
            {
                const double time = leg.begin + (leg.end - leg.begin) * result.time;
                expectTime(time, answer, tolerance, rounding);
            }
            return;
        }
    }
    EXPECT_FALSE(answer.time) << "contact missed";
}

template <typename Case, typename Ask>
void expectRelations(const Case& tested, const Ask& ask)
{
    for (const reference::Relation relation : reference::kRelations)
    {
        SCOPED_TRACE(nameOf(relation));
        for (const reference::Variant<Case>& variant : variantsOf(tested, relation))
        {
            SCOPED_TRACE(variant.name);
            expectVariant(variant, ask);
        }
    }
}
}  // namespace bullet_ccd::tests
