#include "grasp/quality/hold_score.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
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
    const GraspObject cube = makeGraspObject("cube", makeBox(Eigen::Vector3d::Constant(0.02)));
    Grasp grasp;
    for (const double side : {-0.03, 0.03})
    {
        grasp.contacts.push_back({.link = 1, .point = {side, 0.5, 0.5}, .normal = {}, .gap = 0.0});
    }
    EXPECT_EQ(holdScore(grasp, cube, 0.5), 0.0);
    grasp.quality.largestMass = 2.0;
    // Contacts are 0.03 from their mean, half the cube's diagonal is sqrt(3) 0.02, and it holds 4
    // times its mass.
    const double sum = kHoldScore[0] + kHoldScore[1] * std::log(4.1) +
                       kHoldScore[2] * 0.03 / (std::sqrt(3.0) * 0.02);
    EXPECT_NEAR(holdScore(grasp, cube, 0.5), 1.0 / (1.0 + std::exp(-sum)), 1e-9);
    // What holds more, and farther apart, holds better.
    const double score = holdScore(grasp, cube, 0.5);
    EXPECT_GT(holdScore(grasp, cube, 0.25), score);
    Grasp wide = grasp;
    wide.contacts[0].point.x() -= 0.01;
    EXPECT_GT(holdScore(wide, cube, 0.5), score);
    grasp.quality.largestMass = std::numeric_limits<double>::infinity();
    EXPECT_LT(holdScore(grasp, cube, 0.5), 1.0);
    EXPECT_GT(holdScore(grasp, cube, 0.5), score);
}
}  // namespace
}  // namespace bullet_ccd::grasp
