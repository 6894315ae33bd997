/// elementaryToi() on contacts that are exact by construction, against dense sampling, and its
/// exact decision against gaps of one rounding unit.
#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/deformable/certain_touch.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "bullet_ccd/deformable/exact_contact.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace bullet_ccd::tests
{
using reference::Random;

namespace
{
Eigen::Vector3d wholePoint(Random& random, int size)
{
    const double x = random.integer(-size, size);
    const double y = random.integer(-size, size);
    const double z = random.integer(-size, size);
    return {x, y, z};
}

ElementaryPair wholePair(Random& random, bool isVertexFace, int size)
{
    ElementaryPair pair{.kind =
                            isVertexFace ? ElementaryKind::VertexFace : ElementaryKind::EdgeEdge};
    for (std::size_t k = 0; k < 4; ++k)
    {
        pair.start[k] = wholePoint(random, size);
        pair.end[k] = wholePoint(random, size);
    }
    return pair;
}

enum class Family
{
    General,
    Tiny,      ///< coordinates -2 to 2: nearly all are degenerate
    Coplanar,  ///< everything stays in one plane
    Common,    ///< all move alike, but for one vertex
    Sliding,   ///< at most in touch along a plane
    Far,       ///< 2^20 from the origin
};
constexpr std::array kFamilies{
    Family::General, Family::Tiny, Family::Coplanar, Family::Common, Family::Sliding, Family::Far};

struct ConstructedContact
{
    ElementaryPair pair;
    double time = 0.0;  ///< they touch then, perhaps before, too
};

/// Vertices at the time of contact are whole numbers, the point of contact has weights in eighths,
/// and velocities are multiples of 8: all coordinates are exact.
ConstructedContact constructContact(Random& random, Family family)
{
    const int size = family == Family::Tiny ? 2 : 64;
    const bool isFlat = family == Family::Coplanar;
    ConstructedContact made;
    made.pair.kind = random.chance(0.5) ? ElementaryKind::VertexFace : ElementaryKind::EdgeEdge;
    made.time = random.integer(1, 7) / 8.0;
    FourPoints x;
    FourPoints w;
    for (std::size_t k = 0; k < 4; ++k)
    {
        x[k] = wholePoint(random, size);
        w[k] = 8.0 * wholePoint(random, size);
        if (isFlat)
        {
            x[k].z() = 0.0;
        }
        if (isFlat || family == Family::Sliding)
        {
            w[k].z() = 0.0;
        }
    }
    if (family == Family::Common)
    {
        w[1] = w[2] = w[3] = w[0];
        w[0].x() += 8.0 * random.integer(-1, 1);
    }
    if (made.pair.kind == ElementaryKind::VertexFace)
    {
        const int a = random.integer(0, 8);
        const int b = random.integer(0, 8 - a);
        x[0] = 0.125 * (a * x[1] + b * x[2] + (8 - a - b) * x[3]);
    }
    else
    {
        const Eigen::Vector3d at = x[0] + random.integer(0, 8) / 8.0 * (x[1] - x[0]);
        x[3] = x[2] + 8.0 / (1 << random.integer(0, 3)) * (at - x[2]);
    }
    for (std::size_t k = 0; k < 4; ++k)
    {
        if (family == Family::Sliding)
        {
            x[k].z() = 3.0;
        }
        const double offset = family == Family::Far ? 1048576.0 : 0.0;
        made.pair.start[k] = (x[k] - made.time * w[k]).array() + offset;
        made.pair.end[k] = (x[k] + (1.0 - made.time) * w[k]).array() + offset;
    }
    return made;
}

/// Not free: a contact, or a pair on which the search gave up.
bool isReported(const ElementaryResult& result)
{
    return isContact(result.status) || result.status == ToiStatus::IterationLimit;
}

TEST(ElementaryToi, ReportsEveryConstructedContactInTime)
{
    constexpr std::array kDepths{
        ElementaryDepth::Tolerance, ElementaryDepth::Decide, ElementaryDepth::Exact};
    Random random(220);
    const int count = longTests() ? 200'000 : 4'000;
    for (const Family family : kFamilies)
    {
        int inTime = 0;
        for (int i = 0; i < count; ++i)
        {
            const ConstructedContact made = constructContact(random, family);
            const bool isExact = i % 20 == 0;
            const ElementaryDepth depth = kDepths[isExact ? 2 : static_cast<std::size_t>(i) % 2];
            const ElementaryResult result =
                elementaryToi(made.pair, {.tolerance = i % 3 == 0 ? 1e-3 : 1e-12, .depth = depth});
            inTime += isReported(result) && result.time <= made.time ? 1 : 0;
        }
        EXPECT_EQ(inTime, count) << "family " << static_cast<int>(family);
    }
}

/// Two ways that share no arithmetic agree on whole numbers so small that a
/// gap which is not 0 is far above the rounding of double precision.
TEST(ElementaryToi, DecidesExactlyAsDoublePrecisionWhereThatSuffices)
{
    Random random(221);
    const int count = longTests() ? 100'000 : 3'000;
    int touching = 0;
    for (int i = 0; i < count; ++i)
    {
        const int size = 1 + i % 4;
        const ElementaryPair pair = wholePair(random, i % 2 == 0, size);
        const ElementaryOptions fine{.tolerance = 1e-9, .depth = ElementaryDepth::Decide};
        const bool expected = isContact(elementaryToi(pair, fine).status);
        ASSERT_EQ(featuresTouch(pair), expected) << "pair " << i;
        touching += expected ? 1 : 0;
    }
    EXPECT_GT(touching, count / 10);
    EXPECT_LT(touching, count * 9 / 10);
}

/// What double precision proves is so; and it proves most of what is not degenerate.
TEST(ElementaryToi, ProvesTouchesOfWhichDoublePrecisionIsCertain)
{
    Random random(225);
    const int count = longTests() ? 40'000 : 2'000;
    for (const double separation : {0.0, 0.01})
    {
        const int pairs = separation > 0.0 ? count / 50 : count;  // exactly, they take 30 ms each
        int touching = 0;
        int proven = 0;
        for (int i = 0; i < pairs; ++i)
        {
            ElementaryPair pair{.kind = i % 2 == 0 ? ElementaryKind::VertexFace
                                                   : ElementaryKind::EdgeEdge};
            for (std::size_t k = 0; k < 4; ++k)
            {
                pair.start[k] = random.inBox(1.0);
                pair.end[k] = random.inBox(1.0);
                if (i % 3 == 0)
                {
                    pair.start[k].y() = -0.3;
                    pair.end[k].y() = 0.7;
                }
            }
            const ElementaryResult near = elementaryToi(
                pair, {.minimumSeparation = separation, .depth = ElementaryDepth::Decide});
            const bool isProven =
                isContact(near.status) && certainlyTouch(pair, separation, near.time);
            const bool touches = featuresTouch(pair, separation);
            ASSERT_TRUE(touches || !isProven) << "pair " << i;
            touching += touches ? 1 : 0;
            proven += isProven ? 1 : 0;
        }
        EXPECT_GT(touching, pairs / 10);
        EXPECT_GT(proven, touching * 95 / 100) << separation;
    }
    // Touches of boundaries, and what is a rounding unit away from them.
    int differ = 0;
    for (int i = 0; i < count; ++i)
    {
        ConstructedContact made =
            constructContact(random, kFamilies[std::size_t(i) % kFamilies.size()]);
        if (made.pair.kind == ElementaryKind::VertexFace && i % 2 == 0)  // onto an edge
        {
            const Eigen::Vector3d a =
                made.pair.start[1] + made.time * (made.pair.end[1] - made.pair.start[1]);
            const Eigen::Vector3d b =
                made.pair.start[2] + made.time * (made.pair.end[2] - made.pair.start[2]);
            const Eigen::Vector3d way = made.pair.end[0] - made.pair.start[0];
            const Eigen::Vector3d x = a + random.integer(0, 8) / 8.0 * (b - a);
            made.pair.start[0] = x - made.time * way;
            made.pair.end[0] = x + (1.0 - made.time) * way;
        }
        double& moved = made.pair.end[std::size_t(random.integer(0, 3))][random.integer(0, 2)];
        moved = i % 3 == 0 ? moved : std::nextafter(moved, i % 3 == 1 ? -1e9 : 1e9);
        const bool touches = featuresTouch(made.pair);
        for (const double time : {made.time, 0.0, 1.0})
        {
            ASSERT_TRUE(touches || !certainlyTouch(made.pair, 0.0, time)) << "pair " << i;
        }
        differ += touches ? 0 : 1;
    }
    EXPECT_GT(differ, count / 20);
}

TEST(ElementaryToi, TellsAGapOfOneRoundingUnitFromATouchExactly)
{
    // A vertex slides over a triangle in the plane z = 1, at z = 1 and one unit above it; two edges
    // cross likewise.
    const double above = std::nextafter(1.0, 2.0);
    for (const ElementaryKind kind : {ElementaryKind::VertexFace, ElementaryKind::EdgeEdge})
    {
        for (const double z : {1.0, above})
        {
            ElementaryPair pair{.kind = kind};
            if (kind == ElementaryKind::VertexFace)
            {
                pair.start = {Eigen::Vector3d{-3.0, 0.1, z},
                              Eigen::Vector3d{-1.0, -1.0, 1.0},
                              Eigen::Vector3d{1.0, -1.0, 1.0},
                              Eigen::Vector3d{0.0, 1.0, 1.0}};
            }
            else
            {
                pair.start = {Eigen::Vector3d{-3.0, -1.0, z},
                              Eigen::Vector3d{-3.0, 1.0, z},
                              Eigen::Vector3d{-1.0, 0.0, 1.0},
                              Eigen::Vector3d{1.0, 0.0, 1.0}};
            }
            pair.end = pair.start;
            pair.end[0].x() += 6.0;
            if (kind == ElementaryKind::EdgeEdge)
            {
                pair.end[1].x() += 6.0;
            }
            const ElementaryResult decided =
                elementaryToi(pair, {.tolerance = 1e-6, .depth = ElementaryDepth::Decide});
            const ElementaryResult exact =
                elementaryToi(pair, {.tolerance = 1e-6, .depth = ElementaryDepth::Exact});
            EXPECT_TRUE(isContact(decided.status)) << "double precision cannot know better";
            EXPECT_EQ(isContact(exact.status), z == 1.0);
        }
    }
}

TEST(ElementaryToi, DecidesExactlyWhoComesWithinTheMinimumSeparation)
{
    // A vertex flies past a face in the plane 3 x + 4 z = 0, at exactly the distance 5.
    const Eigen::Vector3d a(0.0, 0.0, 0.0);
    const Eigen::Vector3d b(40.0, 0.0, -30.0);
    const Eigen::Vector3d c(0.0, 50.0, 0.0);
    const auto passes = [&](const Eigen::Vector3d& middle, const Eigen::Vector3d& way)
    {
        ElementaryPair pair{.kind = ElementaryKind::VertexFace};
        pair.start = {middle - way, a, b, c};
        pair.end = {middle + way, a, b, c};
        return pair;
    };
    const auto isFound = [](const ElementaryPair& pair, double separation)
    {
        return isContact(elementaryToi(pair,
                                       {.tolerance = 1e-3,
                                        .minimumSeparation = separation,
                                        .depth = ElementaryDepth::Exact})
                             .status);
    };
    const double less = std::nextafter(5.0, 0.0);
    const double more = std::nextafter(5.0, 6.0);
    // Inside of the face, along it; across the edge a-c, whose outside is at -(4, 0, -3); past the
    // corner a.
    for (const ElementaryPair& pair : {passes({11.0, 10.0, -2.0}, {16.0, 5.0, -12.0}),
                                       passes({-4.0, 10.0, 3.0}, {3.0, 7.0, 4.0}),
                                       passes({-4.0, 0.0, 3.0}, {3.0, 0.0, 4.0}),
                                       passes({-3.0, -4.0, 0.0}, {8.0, -6.0, 16.0})})
    {
        EXPECT_TRUE(isFound(pair, 5.0));
        EXPECT_TRUE(isFound(pair, more));
        EXPECT_FALSE(isFound(pair, less));
    }
}

TEST(ElementaryToi, DecidesDistancesExactlyAsDoublePrecisionWhereThatSuffices)
{
    Random random(224);
    const int count = longTests() ? 50'000 : 1'500;
    int near = 0;
    int compared = 0;
    for (int i = 0; i < count; ++i)
    {
        const int size = 1 + i % 4;
        const ElementaryPair pair = wholePair(random, i % 2 == 0, size);
        const double separation = 0.25 * random.integer(1, 2 * size);
        // Where a little more and a little less give one answer, that is the right one.
        const auto comesWithin = [&](double distance)
        {
            return isContact(elementaryToi(pair,
                                           {.tolerance = 1e-9,
                                            .minimumSeparation = distance,
                                            .depth = ElementaryDepth::Decide})
                                 .status);
        };
        const bool expected = comesWithin(separation - 1e-6);
        if (expected != comesWithin(separation + 1e-6))
        {
            continue;
        }
        ++compared;
        near += expected ? 1 : 0;
        ASSERT_EQ(featuresTouch(pair, separation), expected) << "pair " << i;
    }
    EXPECT_GT(compared, count * 9 / 10);
    EXPECT_GT(near, count / 10);
    EXPECT_LT(near, count * 9 / 10);
}

/// Smallest distance of the features at one time, by a fine search over their points: slow,
/// obvious, never below the true one.
double sampledDistance(const ElementaryPair& pair, double t)
{
    FourPoints x;
    for (std::size_t k = 0; k < 4; ++k)
    {
        x[k] = (1.0 - t) * pair.start[k] + t * pair.end[k];
    }
    const bool isFace = pair.kind == ElementaryKind::VertexFace;
    const auto difference = [&](double u, double v) -> Eigen::Vector3d
    {
        return isFace ? Eigen::Vector3d(x[1] + u * (x[2] - x[1]) + v * (x[3] - x[1]) - x[0])
                      : Eigen::Vector3d(x[2] + v * (x[3] - x[2]) - x[0] - u * (x[1] - x[0]));
    };
    // Coordinate descent on a convex function, from the middle, with exact line minima.
    double u = 0.3;
    double v = 0.3;
    for (int i = 0; i < 400; ++i)
    {
        const Eigen::Vector3d du = difference(1.0, v) - difference(0.0, v);
        const double mostU = isFace ? 1.0 - v : 1.0;
        u = std::clamp(
            -difference(0.0, v).dot(du) / std::max(du.squaredNorm(), 1e-300), 0.0, mostU);
        const Eigen::Vector3d dv = difference(u, 1.0) - difference(u, 0.0);
        const double mostV = isFace ? 1.0 - u : 1.0;
        v = std::clamp(
            -difference(u, 0.0).dot(dv) / std::max(dv.squaredNorm(), 1e-300), 0.0, mostV);
        if (isFace)  // along the hypotenuse, where u and v stop each other
        {
            const Eigen::Vector3d dw = difference(1.0, 0.0) - difference(0.0, 1.0);
            const double s = u + v;
            const double along = -(difference(u, v)).dot(dw) / std::max(dw.squaredNorm(), 1e-300);
            const double move = std::clamp(along, -u, v);
            u += move;
            v = s - u;
        }
    }
    return difference(u, v).norm();
}

TEST(ElementaryToi, AgreesWithDenseSamplingOnRandomPairs)
{
    Random random(222);
    const int count = longTests() ? 5'000 : 250;
    int hits = 0;
    int separated = 0;
    for (int i = 0; i < count; ++i)
    {
        ElementaryPair pair{.kind =
                                i % 2 == 0 ? ElementaryKind::VertexFace : ElementaryKind::EdgeEdge};
        const double size = random.logUniform(0.01, 100.0);
        const Eigen::Vector3d approach = 1.5 * size * random.direction();
        for (std::size_t k = 0; k < 4; ++k)
        {
            const bool isFirst = k == 0 || (k == 1 && pair.kind == ElementaryKind::EdgeEdge);
            pair.start[k] = random.inBox(size) + (isFirst ? approach : Eigen::Vector3d::Zero());
            pair.end[k] = random.inBox(size) - (isFirst ? approach : Eigen::Vector3d::Zero());
        }
        const double separation = i % 3 == 0 ? 0.05 * size : 0.0;
        const double tolerance = 1e-3 * size;
        const ElementaryResult result =
            elementaryToi(pair, {.tolerance = tolerance, .minimumSeparation = separation});
        const std::string what = "pair " + std::to_string(i);
        for (int k = 0; k <= 100 && result.status != ToiStatus::Overlapping; ++k)
        {
            const double t = result.time * k / 100.0;
            EXPECT_GT(sampledDistance(pair, t), separation * (1.0 - 1e-9)) << what << " at " << t;
        }
        if (result.status != ToiStatus::Hit)
        {
            separated += result.status == ToiStatus::Separated ? 1 : 0;
            continue;
        }
        ++hits;
        EXPECT_LE(sampledDistance(pair, result.time), separation + tolerance * 1.001) << what;
        EXPECT_NEAR(result.normal.norm(), 1.0, 1e-12) << what;
        Eigen::Vector3d gap = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < 4; ++k)
        {
            gap += result.weights[static_cast<Eigen::Index>(k)] *
                   ((1.0 - result.time) * pair.start[k] + result.time * pair.end[k]);
        }
        EXPECT_NEAR((gap - result.gap * result.normal).norm(), 0.0, 1e-9 * size) << what;
    }
    EXPECT_GT(hits, count * 15 / 100);
    EXPECT_GT(separated, count * 2 / 10);
}

TEST(ElementaryToi, HitsAtTheClosedFormTime)
{
    // A vertex falls from z = 1 at speed 4 onto a face that rises at speed 1: they meet at t = 0.2.
    ElementaryPair pair;
    pair.start = {Eigen::Vector3d{0.1, 0.1, 1.0},
                  Eigen::Vector3d{-1.0, -1.0, 0.0},
                  Eigen::Vector3d{2.0, -1.0, 0.0},
                  Eigen::Vector3d{-1.0, 2.0, 0.0}};
    pair.end = pair.start;
    pair.end[0].z() -= 4.0;
    for (std::size_t k = 1; k < 4; ++k)
    {
        pair.end[k].z() += 1.0;
    }
    const ElementaryResult hit = elementaryToi(pair, {.tolerance = 1e-9});
    EXPECT_EQ(hit.status, ToiStatus::Hit);
    EXPECT_NEAR(hit.time, 0.2, 1e-9);
    EXPECT_LE(hit.time, 0.2);
    EXPECT_NEAR((hit.normal - Eigen::Vector3d(0.0, 0.0, -1.0)).norm(), 0.0, 1e-12);

    const ElementaryResult kept =
        elementaryToi(pair, {.tolerance = 1e-9, .minimumSeparation = 0.5});
    EXPECT_NEAR(kept.time, 0.1, 1e-9);

    std::swap(pair.start, pair.end);  // from inside out: both ends are apart, the middle is not
    EXPECT_NEAR(elementaryToi(pair, {.tolerance = 1e-9}).time, 0.8, 1e-9);

    pair.end[0] = pair.start[0];
    for (std::size_t k = 1; k < 4; ++k)
    {
        pair.end[k] = pair.start[k];
        pair.start[k].z() = pair.end[k].z() = -3.0 - 1e-7;
    }
    EXPECT_EQ(elementaryToi(pair, {.tolerance = 1e-6}).status, ToiStatus::TouchingLeaving);
    pair.end[0].z() -= 1.0;
    EXPECT_EQ(elementaryToi(pair, {.tolerance = 1e-6}).status, ToiStatus::TouchingPressing);
    pair.start[0].z() = -3.0 - 1e-7;
    EXPECT_EQ(elementaryToi(pair, {.tolerance = 1e-6}).status, ToiStatus::Overlapping);
}

TEST(ElementaryToi, KeepsItsVerdictUnderScalingAndOtherOrders)
{
    Random random(223);
    int hits = 0;
    for (int i = 0; i < 2000; ++i)
    {
        ElementaryPair pair{.kind =
                                i % 2 == 0 ? ElementaryKind::VertexFace : ElementaryKind::EdgeEdge};
        for (std::size_t k = 0; k < 4; ++k)
        {
            pair.start[k] = random.inBox(1.0);
            pair.end[k] = random.inBox(1.0);
        }
        const ElementaryResult result = elementaryToi(pair, {.tolerance = 1e-3});
        ElementaryPair scaled = pair;
        ElementaryPair turned = pair;
        for (FourPoints ElementaryPair::*points : {&ElementaryPair::start, &ElementaryPair::end})
        {
            for (Eigen::Vector3d& x : scaled.*points)
            {
                x *= 1024.0;
            }
            FourPoints& x = turned.*points;
            if (pair.kind == ElementaryKind::VertexFace)
            {
                x = {x[0], x[2], x[3], x[1]};
            }
            else
            {
                x = {x[3], x[2], x[0], x[1]};
            }
        }
        const ElementaryResult large = elementaryToi(scaled, {.tolerance = 1.024});
        EXPECT_EQ(large.status, result.status);
        EXPECT_EQ(large.time, result.time);
        const ElementaryResult other = elementaryToi(turned, {.tolerance = 1e-3});
        EXPECT_EQ(isContact(other.status), isContact(result.status));
        hits += isContact(result.status) ? 1 : 0;
    }
    EXPECT_GT(hits, 200);
    EXPECT_LT(hits, 1800);
}

TEST(ElementaryToi, RefusesWhatIsNoQuery)
{
    ElementaryPair pair;
    for (std::size_t k = 0; k < 4; ++k)
    {
        pair.start[k] = pair.end[k] = Eigen::Vector3d::Constant(static_cast<double>(k));
    }
    EXPECT_NO_THROW((void)elementaryToi(pair, {}));
    EXPECT_THROW((void)elementaryToi(pair, {.tolerance = 0.0}), std::invalid_argument);
    EXPECT_THROW((void)elementaryToi(pair, {.minimumSeparation = -1.0}), std::invalid_argument);
    pair.end[1].x() = 0.9e12;
    EXPECT_NO_THROW((void)elementaryToi(pair, {}));
    pair.end[1].x() = -1.1e12;
    EXPECT_THROW((void)elementaryToi(pair, {}), std::invalid_argument);
    pair.end[1].x() = 0.0;
    pair.end[2].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)elementaryToi(pair, {}), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::tests
