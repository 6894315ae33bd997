// Where approaches come from, and the limits that a user sets them.
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/approach/approach_sampler.h"
#include "tests/grasp/planner/test_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
using tests::makeGripper;

constexpr std::array kSources{
    ApproachSource::Sphere, ApproachSource::Surface, ApproachSource::Boxes};
constexpr double kSigmas = 5.0;  // of a count or a mean of independent draws

const Eigen::Vector3d kHalf(0.02, 0.05, 0.03);  // [m]
const Eigen::Vector3d kAt(0.3, -0.1, 0.2);

GraspObject makeObject(TriangleMesh mesh, const Eigen::Isometry3d& X_W)
{
    transformMesh(mesh, Eigen::Affine3d(X_W));
    return makeGraspObject("object", std::move(mesh));
}

GraspObject boxAtPlace()
{
    return makeObject(makeBox(kHalf), Eigen::Isometry3d(Eigen::Translation3d(kAt)));
}

/// Splits the triangles of the face at the largest x into four, twice.
TriangleMesh withFineFace(TriangleMesh mesh)
{
    double face = 0.0;
    for (const Eigen::Vector3d& vertex : mesh.vertices)
    {
        face = std::max(face, vertex.x());
    }
    for (int round = 0; round < 2; ++round)
    {
        std::vector<Triangle> triangles;
        for (const Triangle& t : mesh.triangles)
        {
            const auto vertex = [&](int k)
            { return mesh.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
            if (std::min({vertex(0).x(), vertex(1).x(), vertex(2).x()}) < face)
            {
                triangles.push_back(t);
                continue;
            }
            const auto n = static_cast<std::int32_t>(mesh.vertices.size());
            const std::array middles{Eigen::Vector3d(0.5 * (vertex(0) + vertex(1))),
                                     Eigen::Vector3d(0.5 * (vertex(1) + vertex(2))),
                                     Eigen::Vector3d(0.5 * (vertex(2) + vertex(0)))};
            mesh.vertices.insert(mesh.vertices.end(), middles.begin(), middles.end());
            triangles.push_back({t[0], n, n + 2});
            triangles.push_back({n, t[1], n + 1});
            triangles.push_back({n + 2, n + 1, t[2]});
            triangles.push_back({n, n + 1, n + 2});
        }
        mesh.triangles = std::move(triangles);
    }
    return mesh;
}

/// All candidates of one plan.
std::vector<ApproachCandidate> sample(const GraspObject& object,
                                      const ApproachOptions& options,
                                      std::int64_t count,
                                      std::uint64_t seed = 3)
{
    const HandModel hand = makeGripper(true);
    const ApproachShapes shapes = approachShapes(hand, object);
    std::vector<ApproachCandidate> candidates;
    for (std::int64_t number = 0; number < count; ++number)
    {
        candidates.push_back(sampleApproach(hand, object, shapes, seed, number, count, options));
    }
    return candidates;
}

Eigen::Isometry3d graspFrame(const ApproachCandidate& candidate)
{
    return candidate.X_WStart * makeGripper(true).X_RG;
}

/// Where a line comes into the box at kAt.
struct Entry
{
    int axis = 0;
    bool upper = false;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< from the middle of the box
    bool hits = false;
};

Entry entryOf(const ApproachCandidate& candidate)
{
    const Eigen::Vector3d start = graspFrame(candidate).translation() - kAt;
    const Eigen::Vector3d& d = candidate.direction_W;
    double in = -1e9;
    double out = 1e9;
    Entry entry;
    for (int k = 0; k < 3; ++k)
    {
        if (d[k] == 0.0)
        {
            continue;
        }
        const double side = d[k] < 0.0 ? 1.0 : -1.0;
        const double t = (side * kHalf[k] - start[k]) / d[k];
        out = std::min(out, (-side * kHalf[k] - start[k]) / d[k]);
        if (t > in)
        {
            in = t;
            entry.axis = k;
            entry.upper = side > 0.0;
        }
    }
    entry.point = start + in * d;
    entry.hits = in <= out;
    return entry;
}

double tiltOf(const Eigen::Vector3d& direction, const Eigen::Vector3d& up)
{
    return std::acos(std::clamp(-direction.dot(up.normalized()), -1.0, 1.0));
}

TEST(ApproachFromSurface, LinesMeetAConvexSurfaceNearlySquarely)
{
    const std::vector<ApproachCandidate> candidates =
        sample(boxAtPlace(), {.source = ApproachSource::Surface}, 500);
    double sum = 0.0;
    for (const ApproachCandidate& candidate : candidates)
    {
        const Entry entry = entryOf(candidate);
        ASSERT_TRUE(entry.hits) << candidate.number;
        const double square = (entry.upper ? -1.0 : 1.0) * candidate.direction_W[entry.axis];
        const double turned = std::acos(std::min(1.0, square));
        EXPECT_LE(turned, kLargestTurn + 1e-9);
        sum += turned;
    }
    EXPECT_GT(sum, 0.1 * kLargestTurn * 500.0);
}

TEST(ApproachFromSurface, FacesGetTheirShareByAreaHoweverTheyAreMeshed)
{
    constexpr int kCount = 3000;
    const GraspObject object =
        makeObject(withFineFace(makeBox(kHalf)), Eigen::Isometry3d(Eigen::Translation3d(kAt)));
    ASSERT_GT(object.tree.mesh().triangles.size(), 40U);
    std::map<std::pair<int, bool>, std::vector<Eigen::Vector3d>> points;
    for (const ApproachCandidate& candidate :
         sample(object, {.source = ApproachSource::Surface}, kCount))
    {
        const Entry entry = entryOf(candidate);
        points[{entry.axis, entry.upper}].push_back(entry.point);
    }
    const Eigen::Vector3d areas(
        kHalf.y() * kHalf.z(), kHalf.z() * kHalf.x(), kHalf.x() * kHalf.y());
    for (int axis = 0; axis < 3; ++axis)
    {
        for (const bool upper : {false, true})
        {
            const std::vector<Eigen::Vector3d>& found = points[{axis, upper}];
            const double share = areas[axis] / (2.0 * areas.sum());
            EXPECT_NEAR(static_cast<double>(found.size()),
                        kCount * share,
                        kSigmas * std::sqrt(kCount * share * (1.0 - share)));
            Eigen::Vector3d mean = Eigen::Vector3d::Zero();
            Eigen::Vector3d square = Eigen::Vector3d::Zero();
            for (const Eigen::Vector3d& point : found)
            {
                mean += point / static_cast<double>(found.size());
                square += point.cwiseAbs2() / static_cast<double>(found.size());
            }
            // Evenly over [-h, h]: mean 0, variance h^2 / 3; its square has the variance 4 h^4
            // / 45.
            for (const int k : {(axis + 1) % 3, (axis + 2) % 3})
            {
                const double root = std::sqrt(static_cast<double>(found.size()));
                const double h = kHalf[k];
                EXPECT_NEAR(mean[k], 0.0, kSigmas * h / std::sqrt(3.0) / root);
                EXPECT_NEAR(square[k], h * h / 3.0, kSigmas * h * h * std::sqrt(4.0 / 45.0) / root);
            }
        }
    }
}

TEST(ApproachFromSurface, ATableLeavesTheFacesThatLookUp)
{
    const ApproachOptions options{
        .source = ApproachSource::Surface, .tableTop = true, .maxTilt = 0.5};
    for (const ApproachCandidate& candidate : sample(boxAtPlace(), options, 100))
    {
        const Entry entry = entryOf(candidate);
        EXPECT_EQ(entry.axis, 2);
        EXPECT_TRUE(entry.upper);
    }
}

TEST(ApproachFromBoxes, FacesTakeTurnsWithTheFingersAcrossTheShorterSide)
{
    constexpr int kPerFace = 100;
    const Eigen::Isometry3d X_W =
        Eigen::Translation3d(kAt) * Eigen::AngleAxisd(0.9, Eigen::Vector3d(0.6, 0.0, 0.8));
    const GraspObject object = makeObject(makeBox(kHalf), X_W);
    std::map<std::pair<int, bool>, std::array<int, 4>> quadrants;
    for (const ApproachCandidate& candidate :
         sample(object, {.source = ApproachSource::Boxes}, 6 * kPerFace))
    {
        const Eigen::Isometry3d X_BG = X_W.inverse() * graspFrame(candidate);
        Eigen::Index axis = 0;
        const double square = X_BG.linear().col(2).cwiseAbs().maxCoeff(&axis);
        EXPECT_NEAR(square, 1.0, 1e-12);
        const auto i = static_cast<int>((axis + 1) % 3);
        const auto j = static_cast<int>((axis + 2) % 3);
        const int shorter = kHalf[i] < kHalf[j] ? i : j;
        EXPECT_NEAR(std::abs(X_BG.linear()(shorter, 0)), 1.0, 1e-9);
        // The line stays where it meets the face, and ends in the middle between both faces.
        const Eigen::Vector3d target =
            X_BG.translation() + candidate.centerDistance * X_BG.linear().col(2);
        EXPECT_LE(std::abs(target[i]), kHalf[i]);
        EXPECT_LE(std::abs(target[j]), kHalf[j]);
        EXPECT_NEAR(target[axis], 0.0, 1e-9);
        const std::size_t quadrant = (target[i] > 0.0 ? 1U : 0U) + (target[j] > 0.0 ? 2U : 0U);
        ++quadrants[{static_cast<int>(axis), X_BG.linear()(axis, 2) > 0.0}][quadrant];
    }
    ASSERT_EQ(quadrants.size(), 6U);
    for (const auto& [face, counts] : quadrants)
    {
        for (const int count : counts)
        {
            EXPECT_NEAR(count, kPerFace / 4, kPerFace / 20);
        }
    }
}

/// A tray of 20 x 20 cm whose walls are 4 mm thick: wider than the hand opens, so that only what is
/// thin can be taken.
TEST(ApproachFromPinches, GoesAcrossWhatIsThin)
{
    TriangleMesh mesh = makeBox({0.1, 0.1, 0.002});
    for (const double side : {-0.098, 0.098})
    {
        TriangleMesh wall = makeBox({0.002, 0.1, 0.02});
        transformMesh(wall, Eigen::Affine3d(Eigen::Translation3d(side, 0.0, 0.022)));
        appendMesh(mesh, wall);
    }
    const GraspObject tray = makeObject(mesh, Eigen::Isometry3d::Identity());
    int walls = 0;
    for (const ApproachCandidate& candidate :
         sample(tray, {.source = ApproachSource::Pinch, .tableTop = true, .maxTilt = 1.2}, 100))
    {
        const Eigen::Isometry3d X_WG = graspFrame(candidate);
        const Eigen::Vector3d target =
            X_WG.translation() + candidate.centerDistance * X_WG.linear().col(2);
        EXPECT_LE(X_WG.linear()(2, 2), -std::cos(1.2) + 1e-9);
        const bool isAtAWall = std::abs(std::abs(target.x()) - 0.098) < 1e-9;
        EXPECT_TRUE(isAtAWall || std::abs(target.z()) < 1e-9) << target.transpose();
        if (isAtAWall)
        {
            EXPECT_NEAR(std::abs(X_WG.linear()(0, 0)), 1.0, 1e-9);  // the fingers face it
            ++walls;
        }
    }
    // The floor cannot be come at from above with a finger on either side of it.
    EXPECT_GT(walls, 90);
}

TEST(ApproachFromBoxes, ATableTakesAwayTheFaceBelow)
{
    const auto facesOf = [](double maxTilt)
    {
        std::map<std::pair<int, bool>, int> faces;
        const ApproachOptions options{
            .source = ApproachSource::Boxes, .tableTop = true, .maxTilt = maxTilt};
        for (const ApproachCandidate& candidate : sample(boxAtPlace(), options, 60))
        {
            const Entry entry = entryOf(candidate);
            ++faces[{entry.axis, entry.upper}];
        }
        return faces;
    };
    const auto five = facesOf(0.5 * std::numbers::pi);
    EXPECT_EQ(five.size(), 5U);
    EXPECT_FALSE(five.contains({2, false}));
    const auto one = facesOf(0.3);
    EXPECT_EQ(one.size(), 1U);
    EXPECT_TRUE(one.contains({2, true}));
}

TEST(ApproachFromBoxes, EveryFaceIsMetInEveryPreshape)
{
    HandModel hand = makeGripper(true);
    hand.preshapes.push_back({"narrower", {0.0, 0.005, 0.005}});
    const GraspObject object = boxAtPlace();
    const ApproachShapes shapes = approachShapes(hand, object);
    std::map<std::array<std::int64_t, 4>, int> seen;
    for (std::int64_t number = 0; number < 24; ++number)
    {
        const ApproachCandidate candidate =
            sampleApproach(hand, object, shapes, 1, number, 24, {.source = ApproachSource::Boxes});
        const Eigen::Vector3d& d = candidate.direction_W;
        ++seen[{static_cast<std::int64_t>(candidate.preshape),
                std::lround(d.x()),
                std::lround(d.y()),
                std::lround(d.z())}];
    }
    EXPECT_EQ(seen.size(), 12U);
}

TEST(ApproachOptions, NoneOfTheDefaultsChangesACandidate)
{
    const GraspObject object = boxAtPlace();
    const HandModel hand = makeGripper(true);
    // Limits that leave everything free.
    const ApproachOptions wide{.up = {0.1, 0.2, -0.3},
                               .maxTilt = 0.1,
                               .roll = RollLimits{-std::numbers::pi, std::numbers::pi}};
    const std::vector<ApproachCandidate> candidates = sample(object, wide, 40);
    for (const ApproachCandidate& candidate : candidates)
    {
        const ApproachCandidate plain = sampleApproach(hand, object, 3, candidate.number, 40);
        EXPECT_EQ(plain.X_WStart.matrix(), candidate.X_WStart.matrix());
        EXPECT_EQ(plain.distance, candidate.distance);
    }
}

TEST(ApproachOptions, NothingComesFromBelowATable)
{
    const GraspObject object = boxAtPlace();
    const Eigen::Vector3d up(0.3, -1.0, 2.0);
    for (const ApproachSource source : kSources)
    {
        for (const double maxTilt : {0.5 * std::numbers::pi, 0.6, 0.0})
        {
            const ApproachOptions options{
                .source = source, .tableTop = true, .up = up, .maxTilt = maxTilt};
            ApproachOptions anywhere = options;
            anywhere.tableTop = false;
            const std::vector<ApproachCandidate> free = sample(object, anywhere, 60);
            const auto beyond = std::count_if(free.begin(),
                                              free.end(),
                                              [&](const ApproachCandidate& c)
                                              { return tiltOf(c.direction_W, up) > maxTilt; });
            EXPECT_GE(beyond, 20);
            for (const ApproachCandidate& candidate : sample(object, options, 60))
            {
                EXPECT_GE(-candidate.direction_W.dot(up.normalized()), std::cos(maxTilt) - 1e-8);
                EXPECT_NEAR((graspFrame(candidate).linear().col(2) - candidate.direction_W).norm(),
                            0.0,
                            1e-12);
                EXPECT_NEAR(graspFrame(candidate).linear().determinant(), 1.0, 1e-12);
            }
        }
    }
}

TEST(ApproachOptions, DirectionsCoverTheCapAboveATable)
{
    constexpr int kCount = 100;
    constexpr double kTilt = 1.0;
    const GraspObject ball = makeObject(makeSphere(0.03, 3), Eigen::Isometry3d::Identity());
    const Eigen::Vector3d up = Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0;
    const std::vector<ApproachCandidate> candidates =
        sample(ball, {.tableTop = true, .up = up, .maxTilt = kTilt}, kCount);
    // As over the whole sphere: the share of a candidate is a cap of this radius.
    const double cap = std::sqrt(2.0 * (1.0 - std::cos(kTilt)) / kCount);
    std::mt19937_64 random(11);
    std::normal_distribution<double> normal;
    int inside = 0;
    for (int trial = 0; trial < 1000; ++trial)
    {
        const Eigen::Vector3d anywhere =
            Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
        if (tiltOf(anywhere, up) > kTilt)
        {
            continue;
        }
        ++inside;
        double nearest = 10.0;
        for (const ApproachCandidate& candidate : candidates)
        {
            nearest = std::min(
                nearest, std::acos(std::clamp(anywhere.dot(candidate.direction_W), -1.0, 1.0)));
        }
        EXPECT_LT(nearest, 2.5 * cap);
    }
    EXPECT_GT(inside, 150);
}

TEST(ApproachOptions, TheStandoffMovesTheStartBack)
{
    const GraspObject object = boxAtPlace();
    for (const ApproachSource source : kSources)
    {
        const auto near = sample(object, {.source = source}, 20);
        const auto far = sample(object, {.source = source, .standoff = 0.25}, 20);
        for (std::size_t k = 0; k < near.size(); ++k)
        {
            const Eigen::Vector3d back =
                near[k].X_WStart.translation() - far[k].X_WStart.translation();
            EXPECT_NEAR((back - 0.25 * near[k].direction_W).norm(), 0.0, 1e-12);
            EXPECT_EQ(near[k].X_WStart.linear(), far[k].X_WStart.linear());
            EXPECT_NEAR(far[k].distance - near[k].distance, 0.25, 1e-12);
            EXPECT_NEAR(far[k].centerDistance - near[k].centerDistance, 0.25, 1e-12);
        }
    }
}

TEST(ApproachOptions, TheReachLimitsTheTravel)
{
    const GraspObject object = boxAtPlace();
    const auto free = sample(object, {}, 20);
    const auto short_ = sample(object, {.reach = 0.1}, 20);
    const auto long_ = sample(object, {.reach = 100.0}, 20);
    for (std::size_t k = 0; k < free.size(); ++k)
    {
        EXPECT_GT(free[k].distance, 0.1);
        EXPECT_EQ(short_[k].distance, 0.1);
        EXPECT_EQ(long_[k].distance, free[k].distance);
        EXPECT_EQ(short_[k].X_WStart.matrix(), free[k].X_WStart.matrix());
    }
}

/// By the definition of ApproachOptions::roll, for up = z.
double rollOf(const ApproachCandidate& candidate)
{
    const Eigen::Matrix3d frame = graspFrame(candidate).linear();
    const Eigen::Vector3d z = frame.col(2);
    const bool isSteep = std::acos(std::min(1.0, std::abs(z.z()))) < kSteep;
    const Eigen::Vector3d zero = isSteep ? Eigen::Vector3d(Eigen::Vector3d::UnitX() - z.x() * z)
                                         : Eigen::Vector3d(Eigen::Vector3d::UnitZ().cross(z));
    return std::atan2(z.dot(zero.cross(frame.col(0))), zero.dot(frame.col(0)));
}

TEST(ApproachOptions, TheRollKeepsToItsLimits)
{
    const GraspObject object = boxAtPlace();
    for (const ApproachSource source : kSources)
    {
        int outside = 0;
        for (const ApproachCandidate& candidate : sample(object, {.source = source}, 60))
        {
            const double roll = rollOf(candidate);
            outside += roll < 0.2 || roll > 0.5 ? 1 : 0;
        }
        EXPECT_GE(outside, 40);
        const ApproachOptions options{.source = source, .roll = RollLimits{0.2, 0.5}};
        for (const ApproachCandidate& candidate : sample(object, options, 60))
        {
            EXPECT_GE(rollOf(candidate), 0.2 - 1e-9);
            EXPECT_LE(rollOf(candidate), 0.5 + 1e-9);
        }
        // Across the half turn at which angles begin anew, and one angle alone.
        for (const ApproachCandidate& candidate :
             sample(object, {.source = source, .roll = RollLimits{3.0, 3.4}}, 30))
        {
            const double roll = rollOf(candidate);
            EXPECT_TRUE(roll >= 3.0 - 1e-9 || roll <= 3.4 - 2.0 * std::numbers::pi + 1e-9) << roll;
        }
        for (const ApproachCandidate& candidate :
             sample(object, {.source = source, .roll = RollLimits{0.7, 0.7}}, 30))
        {
            EXPECT_NEAR(rollOf(candidate), 0.7, 1e-9);
        }
    }
}

TEST(ApproachOptions, CandidatesOfAllSourcesArePureFunctions)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = boxAtPlace();
    for (const ApproachSource source : {ApproachSource::Surface, ApproachSource::Boxes})
    {
        const ApproachOptions options{
            .source = source, .tableTop = true, .roll = RollLimits{0.0, 1.0}};
        int different = 0;
        for (std::int64_t number = 19; number >= 0; --number)
        {
            const ApproachCandidate first = sampleApproach(hand, object, 5, number, 20, options);
            static_cast<void>(sampleApproach(hand, object, 5, 19 - number, 20, options));
            const ApproachCandidate again = sampleApproach(hand, object, 5, number, 20, options);
            EXPECT_EQ(first.X_WStart.matrix(), again.X_WStart.matrix());
            const ApproachCandidate other = sampleApproach(hand, object, 6, number, 20, options);
            different += first.X_WStart.matrix() != other.X_WStart.matrix() ? 1 : 0;
        }
        EXPECT_EQ(different, 20);
    }
}

TEST(ApproachOptions, WhatCannotBeIsRefused)
{
    const HandModel hand = makeGripper(true);
    const GraspObject object = boxAtPlace();
    for (const ApproachOptions& options : {ApproachOptions{.up = Eigen::Vector3d::Zero()},
                                           ApproachOptions{.maxTilt = -0.1},
                                           ApproachOptions{.maxTilt = std::nan("")},
                                           ApproachOptions{.standoff = -1.0},
                                           ApproachOptions{.reach = -1.0},
                                           ApproachOptions{.roll = RollLimits{1.0, 0.0}}})
    {
        EXPECT_THROW(static_cast<void>(sampleApproach(hand, object, 1, 0, 5, options)),
                     std::invalid_argument);
    }
}
}  // namespace
}  // namespace bullet_ccd::grasp
