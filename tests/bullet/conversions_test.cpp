#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/bullet/btCcdConversions.h"

#include <gtest/gtest.h>

#include <limits>

namespace bullet_ccd::tests
{
using namespace reference;

TEST(Conversions, TimeIsRoundedDown)
{
    Random random(1);
    int inexact = 0;
    for (int i = 0; i < 10000; ++i)
    {
        const double value = i % 2 == 0 ? random.uniform(0.0, 1.0) : random.logUniform(1e-30, 1.0);
        const btScalar rounded = btCcdRoundDown(value);
        EXPECT_LE(double(rounded), value);
        EXPECT_GE(rounded, btScalar(0));
        EXPECT_GE(double(std::nextafter(rounded, btScalar(2))), value);
        inexact += double(rounded) < value ? 1 : 0;
    }
    // In single precision nearly no value is representable, in double precision all are.
    EXPECT_EQ(inexact > 9000, sizeof(btScalar) == 4);
    EXPECT_EQ(btCcdRoundDown(0.0), btScalar(0));
    EXPECT_EQ(btCcdRoundDown(1.0), btScalar(1));
    EXPECT_LT(double(btCcdRoundDown(std::nextafter(1.0, 0.0))), 1.0);
}

TEST(Conversions, PosesSurviveTheRoundTrip)
{
    const double exact = sizeof(btScalar) == 8 ? 1e-15 : 1e-6;
    Random random(2);
    for (int i = 0; i < 100; ++i)
    {
        const Eigen::Isometry3d X = random.pose(1.0);
        const Eigen::Isometry3d back = btCcdToEigen(btCcdToBullet(X));
        EXPECT_LT((X.matrix() - back.matrix()).cwiseAbs().maxCoeff(), 4.0 * exact);
        // Orthonormal to double precision, whatever Bullet's is.
        EXPECT_LT((back.linear().transpose() * back.linear() - Eigen::Matrix3d::Identity())
                      .cwiseAbs()
                      .maxCoeff(),
                  4e-15);
    }
}
}  // namespace bullet_ccd::tests
