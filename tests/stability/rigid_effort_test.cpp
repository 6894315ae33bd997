/// How much work the hard cases may cost: counted in poses and pairs, not in time.
#include "benchmarks/reference/queries/soak_queries.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
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

INSTANTIATE_TEST_SUITE_P(Strategies,
                         RigidEffort,
                         testing::Values(ToiStrategy::BestFirst,
                                         ToiStrategy::Interval,
                                         ToiStrategy::C2A),
                         [](const auto& tested)
                         {
                             std::string name = nameOf(tested.param);
                             std::erase(name, '-');
                             return name;
                         });

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
    return {.meshA = sphereWithPole(1.0, -Vector3d::UnitY()),
            .meshB = sphereWithPole(1.0, Vector3d::UnitY()),
            .motionA = {.X_W0 = poseOf({3, offset, 0}), .v_W = {-6, 0, 0}}};
}

RigidScene rodPassing(double length)
{
    return {.meshA = segment({0, 0, 0}, {length, 0, 0}),
            .meshB = wallAtY(1.0, 4.0),
            .motionA = {.w_W = {0, 0, kPi}}};
}

/// The tip of a spike on a wheel that rolls on the plane comes down in a cusp.
RigidScene cusp(double gap)
{
    const Vector3d tip(0, 0, 1.0 - gap);
    return {
        .meshA = triangle(tip, tip, tip),
        .meshB = floorAt(0.0, 10.0),
        .motionA = {.X_W0 = poseOf({0, 0, 1}), .v_W = {2.0 * kPi, 0, 0}, .w_W = {0, 2.0 * kPi, 0}}};
}

TEST_P(RigidEffort, TangentialPassesGrowLikeTheLogarithmOfTheTolerance)
{
    expectLogarithmic(workOf([](double) { return spheresPassing(2.0); }, ToiStatus::Hit));
}

TEST_P(RigidEffort, TangentialRotationsGrowLikeTheLogarithmOfTheTolerance)
{
    expectLogarithmic(workOf([](double) { return rodPassing(1.0); }, ToiStatus::Hit));
}

TEST_P(RigidEffort, CuspsGrowLikeTheLogarithmOfTheTolerance)
{
    expectLogarithmic(workOf([](double) { return cusp(0.0); }, ToiStatus::Hit));
}

TEST_P(RigidEffort, NearMissesGrowLikeTheLogarithmOfTheirGap)
{
    expectLogarithmic(workOf([](double tolerance) { return spheresPassing(2.0 + 2.0 * tolerance); },
                             ToiStatus::Separated));
    expectLogarithmic(workOf([](double tolerance) { return rodPassing(1.0 - 2.0 * tolerance); },
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
