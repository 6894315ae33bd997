/// Joint paths through waypoints and along splines, against their definitions.
#include "bullet_ccd/trajectory/trajectory.h"

#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/random_trees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
const Eigen::Isometry3d kHere = Eigen::Isometry3d::Identity();

/// Value, first and second derivative of a polynomial.
std::array<double, 3> derivatives(const std::array<double, 6>& c, double t)
{
    std::array<double, 3> value{};
    for (std::size_t k = 0; k < 6; ++k)
    {
        const double n = double(k);
        value[0] += c[k] * std::pow(t, n);
        value[1] += k < 1 ? 0.0 : n * c[k] * std::pow(t, n - 1.0);
        value[2] += k < 2 ? 0.0 : n * (n - 1.0) * c[k] * std::pow(t, n - 2.0);
    }
    return value;
}

/// Through values of a polynomial there is only one: it is found again.
TEST(TrajectoryThrough, WaypointsOfAPolynomialIsThatPolynomial)
{
    Random random(11);
    const KinematicTree tree = planarChain({1.0, 1.0});
    for (const int degree : {1, 3, 5})
    {
        for (int round = 0; round < 50; ++round)
        {
            std::array<std::array<double, 6>, 3> polynomials{};
            for (auto& polynomial : polynomials)
            {
                for (int k = 0; k <= degree; ++k)
                {
                    polynomial[static_cast<std::size_t>(k)] = random.uniform(-1.0, 1.0);
                }
            }
            std::vector<Waypoint> waypoints;
            for (double time = random.uniform(-1.0, 0.0); waypoints.size() < 4;
                 time += random.uniform(0.1, 1.0))
            {
                Waypoint& waypoint = waypoints.emplace_back();
                waypoint.time = time;
                for (const auto& polynomial : polynomials)
                {
                    const auto [q, v, a] = derivatives(polynomial, time);
                    waypoint.positions.push_back(q);
                    if (degree >= 3)
                    {
                        waypoint.velocities.push_back(v);
                    }
                    if (degree >= 5)
                    {
                        waypoint.accelerations.push_back(a);
                    }
                }
            }
            const Trajectory trajectory = trajectoryThrough(tree, kHere, waypoints);
            ASSERT_EQ(trajectory.segments.size(), 3U);
            for (int k = 0; k <= 30; ++k)
            {
                const double time = std::lerp(waypoints[0].time, waypoints[3].time, k / 30.0);
                const std::vector<double> positions = positionsAt(trajectory, time);
                for (std::size_t joint = 0; joint < 3; ++joint)
                {
                    EXPECT_NEAR(positions[joint], derivatives(polynomials[joint], time)[0], 1e-11);
                }
            }
        }
    }
}

TEST(TrajectoryThrough, JointsThatFollowOthersDo)
{
    KinematicTree tree = planarChain({1.0, 1.0});
    tree.links[2].joint.mimicOf = 1;
    tree.links[2].joint.mimicMultiplier = -2.0;
    tree.links[2].joint.mimicOffset = 0.5;
    const std::vector<Waypoint> waypoints{
        {.time = 0.0, .positions = {0, 0.1, 7}, .velocities = {0, 1, 7}},
        {.time = 2.0, .positions = {0, 0.7, 7}, .velocities = {0, 0, 7}}};
    const Trajectory trajectory = trajectoryThrough(tree, kHere, waypoints);
    for (const double time : {0.0, 0.3, 1.1, 2.0})
    {
        const std::vector<double> positions = positionsAt(trajectory, time);
        EXPECT_NEAR(positions[2], 0.5 - 2.0 * positions[1], 1e-14);
    }
    EXPECT_NEAR(positionsAt(trajectory, 5.0)[1], 0.7, 1e-14);
}

/// The definition by Cox and de Boor.
double basis(const std::vector<double>& knots, std::size_t i, int degree, double t)
{
    if (degree == 0)
    {
        return knots[i] <= t && t < knots[i + 1] ? 1.0 : 0.0;
    }
    const auto p = static_cast<std::size_t>(degree);
    const double left = knots[i + p] - knots[i];
    const double right = knots[i + p + 1] - knots[i + 1];
    return (left > 0.0 ? (t - knots[i]) / left * basis(knots, i, degree - 1, t) : 0.0) +
           (right > 0.0 ? (knots[i + p + 1] - t) / right * basis(knots, i + 1, degree - 1, t)
                        : 0.0);
}

TEST(SplineTrajectory, IsTheSumOfItsBasisFunctions)
{
    Random random(12);
    const KinematicTree tree = planarChain({1.0});
    int repeated = 0;
    for (int round = 0; round < 200; ++round)
    {
        JointSpline spline{.degree = random.integer(1, 5), .knots = {}, .controlPoints = {}};
        const auto degree = static_cast<std::size_t>(spline.degree);
        const std::size_t points = degree + 1 + static_cast<std::size_t>(random.integer(0, 5));
        double knot = random.uniform(-1.0, 1.0);
        const bool isClamped = random.chance(0.5);
        std::size_t times = 0;  // that this knot is there
        for (std::size_t k = 0; k < points + degree + 1; ++k)
        {
            times = k > 0 && spline.knots.back() == knot ? times + 1 : 1;
            spline.knots.push_back(knot);
            const bool isInside = k >= degree && k < points;
            const bool isRepeated = random.chance(0.2) && times < degree;
            knot += (isClamped && !isInside) || (isRepeated && k != degree)
                        ? 0.0
                        : random.uniform(0.1, 1.0);
        }
        for (std::size_t k = 0; k < points; ++k)
        {
            spline.controlPoints.push_back({0.0, random.uniform(-2.0, 2.0)});
        }
        const Trajectory trajectory = splineTrajectory(tree, kHere, spline);
        repeated += trajectory.segments.size() < points - degree ? 1 : 0;
        EXPECT_EQ(trajectory.times.front(), spline.knots[degree]);
        EXPECT_EQ(trajectory.times.back(), spline.knots[points]);
        for (int sample = 0; sample < 20; ++sample)
        {
            const double time = random.uniform(trajectory.times.front(), trajectory.times.back());
            double expected = 0.0;
            for (std::size_t k = 0; k < points; ++k)
            {
                expected +=
                    basis(spline.knots, k, spline.degree, time) * spline.controlPoints[k][1];
            }
            EXPECT_NEAR(positionsAt(trajectory, time)[1], expected, 1e-11) << round;
        }
    }
    EXPECT_GT(repeated, 20);
}

/// Pairs that do not move relative to each other are not tested, so that joined links may touch:
/// rounding must not set them in motion.
TEST(SplineTrajectory, AJointWhosePointsAreEqualRests)
{
    Random random(13);
    const KinematicTree tree = planarChain({1.0, 1.0});
    for (int degree = 1; degree <= 5; ++degree)
    {
        for (int round = 0; round < 50; ++round)
        {
            JointSpline spline{.degree = degree, .knots = {0.0}, .controlPoints = {}};
            const int points = degree + random.integer(1, 4);
            for (int k = 0; k < points + degree; ++k)
            {
                spline.knots.push_back(spline.knots.back() + random.uniform(0.1, 1.0));
            }
            const double resting = random.uniform(-2.0, 2.0);
            for (int k = 0; k < points; ++k)
            {
                spline.controlPoints.push_back({0.0, random.uniform(-2.0, 2.0), resting});
            }
            for (const JointMotion& segment : splineTrajectory(tree, kHere, spline).segments)
            {
                EXPECT_FALSE(segment.path(1).isConstant());
                EXPECT_TRUE(segment.path(2).isConstant()) << degree;
                EXPECT_EQ(segment.positions[2], resting);
            }
        }
    }
}

TEST(Trajectory, RefusesWhatIsNone)
{
    const KinematicTree tree = planarChain({1.0});
    const auto through = [&](std::vector<Waypoint> waypoints)
    { (void)trajectoryThrough(tree, kHere, waypoints); };
    const Waypoint start{.time = 0.0, .positions = {0, 0}};
    EXPECT_THROW(through({start}), std::invalid_argument);
    EXPECT_THROW(through({start, {.time = 0.0, .positions = {0, 1}}}), std::invalid_argument);
    EXPECT_THROW(through({start, {.time = 1.0, .positions = {0}}}), std::invalid_argument);
    EXPECT_THROW(through({start, {.time = 1.0, .positions = {0, std::nan("")}}}),
                 std::invalid_argument);
    EXPECT_NO_THROW(through({start, {.time = 1.0, .positions = {0, 1}}}));
    const auto spline = [&](int degree, std::vector<double> knots)
    {
        (void)splineTrajectory(tree,
                               kHere,
                               {.degree = degree,
                                .knots = std::move(knots),
                                .controlPoints = {{0, 0}, {0, 1}, {0, 2}}});
    };
    EXPECT_THROW(spline(6, {0, 0, 0, 1, 1, 1}), std::invalid_argument);
    EXPECT_THROW(spline(2, {0, 0, 0, 1, 1}), std::invalid_argument);
    EXPECT_THROW(spline(2, {0, 0, 0, 1, 0.5, 1}), std::invalid_argument);
    EXPECT_THROW(spline(2, {0, 0, 0, 0, 0, 0}), std::invalid_argument);
    EXPECT_NO_THROW(spline(2, {0, 0, 0, 1, 1, 1}));
    EXPECT_THROW((void)positionsAt({}, 0.0), std::invalid_argument);
    // At a knot inside that is there more often than the degree says, the spline may jump.
    const auto ofAnyLength = [&](int degree, const std::vector<double>& knots)
    {
        const std::vector<std::vector<double>> points(knots.size() - std::size_t(degree) - 1,
                                                      {0, 1});
        (void)splineTrajectory(
            tree, kHere, {.degree = degree, .knots = knots, .controlPoints = points});
    };
    EXPECT_THROW(ofAnyLength(1, {0, 0, 1, 1, 2, 2}), std::invalid_argument);
    EXPECT_THROW(ofAnyLength(2, {0, 0, 0, 1, 1, 1, 2, 2, 2}), std::invalid_argument);
    EXPECT_NO_THROW(ofAnyLength(1, {0, 0, 1, 2, 2}));
    EXPECT_NO_THROW(ofAnyLength(2, {0, 0, 0, 1, 1, 2, 2, 2}));
}

TEST(CheckTrajectory, RefusesJointsThatJump)
{
    const KinematicTree tree = planarChain({1.0});
    const std::vector<Waypoint> waypoints{{.time = 0.0, .positions = {0, 0}},
                                          {.time = 1.0, .positions = {0, 1}},
                                          {.time = 2.0, .positions = {0, 3}}};
    Trajectory trajectory = trajectoryThrough(tree, kHere, waypoints);
    EXPECT_NO_THROW(checkTrajectory(trajectory));
    trajectory.segments[1].positions[1] += 1e-6;
    try
    {
        checkTrajectory(trajectory);
        FAIL() << "a jump was accepted";
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_NE(std::string(error.what()).find("link 1 jumps at 1.0"), std::string::npos)
            << error.what();
    }
}
}  // namespace
}  // namespace bullet_ccd::tests
