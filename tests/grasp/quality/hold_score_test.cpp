#include "grasp/quality/hold_score.h"

#include "grasp/quality/hold_score_coefficients.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace bullet_ccd::grasp
{
namespace
{
TEST(HoldScore, IsTheLogisticFunctionOfItsFeatures)
{
    Grasp grasp;
    grasp.quality.epsilon = 0.1;
    EXPECT_EQ(holdScore(grasp, 0.5), 0.0);
    grasp.quality.largestMass = 1.0;
    const double sum = kHoldScore[0] + kHoldScore[1] * std::log(2.1) + kHoldScore[2] * 0.1;
    EXPECT_NEAR(holdScore(grasp, 0.5), 1.0 / (1.0 + std::exp(-sum)), 1e-12);
    // What holds more holds better, up to four times; so does what has a larger epsilon.
    const double score = holdScore(grasp, 0.5);
    EXPECT_GT(holdScore(grasp, 0.3), score);
    EXPECT_EQ(holdScore(grasp, 0.2), holdScore(grasp, 0.1));
    Grasp better = grasp;
    better.quality.epsilon = 0.15;
    EXPECT_GT(holdScore(better, 0.5), score);
    grasp.quality.largestMass = std::numeric_limits<double>::infinity();
    EXPECT_GT(holdScore(grasp, 0.5), score);
    EXPECT_LT(holdScore(grasp, 0.5), 1.0);
}
}  // namespace
}  // namespace bullet_ccd::grasp
