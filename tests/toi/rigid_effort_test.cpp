/// How much work the hard cases may cost: counted in poses and pairs, not in time.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "tests/support/test_parameters.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
constexpr std::array<double, 7> kTolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};

class RigidEffort : public testing::TestWithParam<ToiStrategy>
{
protected:
    /// Work of the queries scene(tolerance) for every tolerance.
    template <typename SceneAt>
    [[nodiscard]] std::array<double, 7> workOf(const SceneAt& scene, ToiStatus expected) const
    {
        std::array<double, 7> work{};
        for (std::size_t i = 0; i < kTolerances.size(); ++i)
        {
            const ToiResult result = queryToi(
                scene(kTolerances[i]), {.tolerance = kTolerances[i], .strategy = GetParam()});
            EXPECT_EQ(result.status, expected) << kTolerances[i];
            work[i] =
                static_cast<double>(result.counters.nodePairs + result.counters.trianglePairs);
        }
        return work;
    }
};

INSTANTIATE_TEST_SUITE_P(Strategies, RigidEffort, kAllStrategies, nameOfStrategy);

std::string text(const std::array<double, 7>& work)
{
    std::string result;
    for (const double count : work)
    {
        result += std::to_string(static_cast<long long>(count)) + ' ';
    }
    return result;
}

/// Eight decades against six: a logarithm grows by a third, the inverse square root tenfold. (Large
/// tolerances say nothing: there the facets of a mesh are not told apart.)
void expectLogarithmic(const std::array<double, 7>& work)
{
    EXPECT_LE(work[6], 1.6 * work[4] + 20.0) << text(work);
}

RigidScene spheresPassing(double offset)
{
    return passingSpheres("", offset).scene;
}

/// The tip of a rod of length 1 + excess passes a wall at 1.
RigidScene rodPassing(double excess)
{
    return grazingRod("", excess).scene;
}

/// The tip of a spike on a wheel that rolls on the plane comes down in a cusp.
RigidScene cusp(double gap)
{
    return rollingSpike("", -gap).scene;
}

TEST_P(RigidEffort, TangentialPassesGrowLikeTheLogarithmOfTheTolerance)
{
    expectLogarithmic(workOf([](double) { return spheresPassing(2.0); }, ToiStatus::Hit));
}

TEST_P(RigidEffort, TangentialRotationsGrowLikeTheLogarithmOfTheTolerance)
{
    expectLogarithmic(workOf([](double) { return rodPassing(0.0); }, ToiStatus::Hit));
}

TEST_P(RigidEffort, CuspsGrowLikeTheLogarithmOfTheTolerance)
{
    expectLogarithmic(workOf([](double) { return cusp(0.0); }, ToiStatus::Hit));
}

TEST_P(RigidEffort, NearMissesGrowLikeTheLogarithmOfTheirGap)
{
    expectLogarithmic(workOf([](double tolerance) { return spheresPassing(2.0 + 2.0 * tolerance); },
                             ToiStatus::Separated));
    expectLogarithmic(workOf([](double tolerance) { return rodPassing(-2.0 * tolerance); },
                             ToiStatus::Separated));
    expectLogarithmic(
        workOf([](double tolerance) { return cusp(2.0 * tolerance); }, ToiStatus::Separated));
}

TEST_P(RigidEffort, TransversalContactsGrowLikeTheLogarithmOfTheTolerance)
{
    expectLogarithmic(workOf(
        [](double)
        {
            return RigidScene{.meshA = cube(1.0),
                              .meshB = floorAt(0.0, 10.0),
                              .motionA = {.X_W0 = poseOf({0, 0, 5}, 0.4, {1, 2, 3}),
                                          .v_W = {0, 0, -8},
                                          .w_W = {1, 2, 0.5}}};
        },
        ToiStatus::Hit));
}
}  // namespace
}  // namespace bullet_ccd::tests
