#include "benchmarks/closing/discrete_closing.h"

#include "tests/grasp/closing/closing_engine.h"

#include <gtest/gtest.h>

namespace bullet_ccd::tests
{
namespace
{
/// The baseline, with the tolerance as its gap.
grasp::CloseHand discreteEngine()
{
    return [](const grasp::HandModel& hand,
              const grasp::GraspObject& object,
              const Eigen::Isometry3d& X_WH,
              const std::vector<double>& positions,
              const grasp::ClosingOptions& options)
    {
        const auto proximity = benchmarks::treeProximity(hand, object);
        return benchmarks::discreteClosing(
            *proximity,
            hand,
            X_WH,
            positions,
            {.contactGap = options.tolerance, .contactLayer = 2.0 * options.tolerance});
    };
}
}  // namespace

INSTANTIATE_TEST_SUITE_P(Engines,
                         ClosingEngine,
                         testing::Values(Engine{"Discrete", discreteEngine}),
                         nameOf);
}  // namespace bullet_ccd::tests
