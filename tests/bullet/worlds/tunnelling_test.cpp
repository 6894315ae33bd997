#include "benchmarks/reference/bullet/tunnelling.h"

#include "benchmarks/reference/scenes/shapes.h"

#include <LinearMath/btTransformUtil.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
/// Phases of a row that run here, of 50 in the whole table (benchmarks/run bullet-table).
constexpr int kPhases[] = {3, 28};

struct Count
{
    int runs = 0;
    int through = 0;
};

/// Half of the settings, others for each phase.
template <typename Judge>
Count runSlice(const TunnellingRow& row, Kind kind, const Judge& judge)
{
    Count count;
    for (std::size_t i = 0; i < row.settings.size(); ++i)
    {
        const int phase = kPhases[i % std::size(kPhases)];
        const RunOutcome outcome = row.run(kind, row.settings[i], phase / 50.0);
        ++count.runs;
        count.through += outcome.through ? 1 : 0;
        judge(outcome,
              row.name + ", speed " + std::to_string(row.settings[i].speed) + ", phase " +
                  std::to_string(phase));
    }
    return count;
}
}  // namespace

TEST(Tunnelling, StockWorldsLoseWhatIsFast)
{
    Count stock;
    Count stockCcd;
    for (const TunnellingRow& row : tunnellingRows())
    {
        const auto ignore = [](const RunOutcome&, const std::string&) {};
        const Count plain = runSlice(row, Kind::Stock, ignore);
        const Count ccd = runSlice(row, Kind::StockCcd, ignore);
        stock.runs += plain.runs;
        stock.through += plain.through;
        stockCcd.through += ccd.through;
    }
    // The control: without these losses the test below would prove nothing.
    EXPECT_GT(stock.through, stock.runs / 2);
    EXPECT_GT(stockCcd.through, stock.runs / 4);
}

class EveryRow : public testing::TestWithParam<Kind>
{
};

TEST_P(EveryRow, LetsNothingThroughAndStopsNothingInTheAir)
{
    for (const TunnellingRow& row : tunnellingRows())
    {
        runSlice(row,
                 GetParam(),
                 [](const RunOutcome& outcome, const std::string& where)
                 {
                     EXPECT_FALSE(outcome.through) << where;
                     EXPECT_FALSE(isGhostStop(outcome)) << where << ": " << outcome.closest;
                 });
    }
}

// Friction at the first plate leaves a spin of 1e4 to 4e4 rad/s: hundreds of radians up to the
// next.
TEST(FastSpins, DoNotLeadThroughTheNextWall)
{
    double fastest = 0.0;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int run = 0; run < 60; ++run)
    {
        Scene scene(Kind::World, run % 2 == 0 ? WorldClass::Rigid : WorldClass::MultiBody);
        TriangleMesh plates = floorAt(-0.5, 50.0);
        appendMesh(plates, floorAt(0.5, 50.0));
        btRigidBody* walls = scene.body(scene.mesh(plates), 0.0, poseAt(vec(0, 0, 0)));
        walls->setRestitution(1);
        btTransform pose = poseAt(vec(0, 0, std::uniform_real_distribution(-0.3, 0.3)(random)));
        pose.setRotation(
            btQuaternion(vec(normal(random), normal(random), normal(random)).normalized(),
                         btScalar(std::uniform_real_distribution(0.0, std::numbers::pi)(random))));
        btRigidBody* body = scene.body(scene.boxMesh(vec(0.006, 0.003, 0.005)), 1.0, pose);
        body->setRestitution(btScalar(0.9));
        body->setLinearVelocity(vec(40, 0, -200));
        scene.step(1.0 / 60.0);
        fastest = std::max(fastest, double(body->getAngularVelocity().length()));
        EXPECT_LT(std::abs(double(body->getWorldTransform().getOrigin().z())), 0.5) << run;
        EXPECT_EQ(scene.counters().m_overlaps, 0) << run;
    }
    EXPECT_GT(fastest, 1e4);
}

namespace
{
struct TimeOfImpact : btCcdImpactListener
{
    btCcdAfterImpact onImpact(const btCcdImpact& impact) override
    {
        m_times.push_back(double(impact.m_time));
        return btCcdAfterImpact::Solve;
    }
    std::vector<double> m_times;
};
}  // namespace

// Up to the first impact of a step as far as in stock Bullet, from then on as far as they say, but
// by 12.5 turns at most.
TEST(FastSpins, TurnEverythingByTheAngleThatTheySay)
{
    const double step = double(btScalar(1.0 / 60.0));
    for (const double spin : {100.0, 3'000.0, 12'345.0, 300'007.0})  // [rad/s]
    {
        Scene scene(Kind::World);
        scene.body(scene.box(vec(1, 1, 0.1)), 0.0, poseAt(vec(0, 0, -0.1)));
        scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(0, 0, 1.1)))
            ->setLinearVelocity(vec(0, 0, -90));
        btRigidBody* rigid = scene.body(scene.box(vec(0.1, 0.1, 0.1)), 1.0, poseAt(vec(10, 0, 0)));
        auto floating = std::make_unique<btMultiBody>(0, btScalar(1), vec(1, 1, 1), false, false);
        floating->finalizeMultiDof();
        btMultiBody* links =
            scene.addMultiBody(std::move(floating), scene.box(vec(0.1, 0.1, 0.1)), {});
        links->setMaxCoordinateVelocity(btScalar(1e6));
        links->setBaseWorldTransform(poseAt(vec(20, 0, 0)));
        Scene::placeColliders(*links);
        rigid->setAngularVelocity(vec(0, 0, spin));
        links->setBaseOmega(vec(0, 0, spin));
        TimeOfImpact impact;
        scene.ccd().setCcdImpactListener(&impact);
        scene.step(step);

        ASSERT_EQ(impact.m_times.size(), 1);
        const double first = impact.m_times.front();
        const double before =
            std::min(spin * step, double(ANGULAR_MOTION_THRESHOLD)) * first / step;
        const double after = std::min(spin * (step - first), 25.0 * std::numbers::pi);
        const double angle = before + after;
        const auto offBy = [angle](const btTransform& pose)
        {
            const double turned = double(btAtan2(pose.getBasis()[1][0], pose.getBasis()[0][0]));
            return std::abs(std::remainder(turned - angle, 2.0 * std::numbers::pi));
        };
        constexpr double kWithin = 1e-4;  // rounding in single precision
        EXPECT_LT(offBy(rigid->getWorldTransform()), kWithin) << spin;
        EXPECT_LT(offBy(links->getBaseWorldTransform()), kWithin) << spin;
        EXPECT_EQ(double(rigid->getAngularVelocity().z()), double(btScalar(spin)));
        EXPECT_EQ(double(rigid->getInterpolationAngularVelocity().z()), double(btScalar(spin)));
        EXPECT_EQ(double(links->getBaseOmega().z()), double(btScalar(spin)));
    }
}

INSTANTIATE_TEST_SUITE_P(Tunnelling,
                         EveryRow,
                         testing::ValuesIn(kOurKinds),
                         [](const testing::TestParamInfo<Kind>& test)
                         { return std::string(codeOf(test.param)); });
}  // namespace bullet_ccd::tests
