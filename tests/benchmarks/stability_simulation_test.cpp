// What the stability of simulations rests on: runs and their verdicts.
#include "benchmarks/stability/stability_run.h"

#include <gmock/gmock.h>
#include <set>
#include <stdexcept>

namespace bullet_ccd::benchmarks
{
namespace
{
using reference::Kind;

const StabilityWorld& worldNamed(const std::string& name)
{
    for (const StabilityWorld& world : stabilityWorlds())
    {
        if (world.name == name)
        {
            return world;
        }
    }
    throw std::invalid_argument(name);
}

StabilityOutcome run(const std::string& name, const StabilitySetting& setting)
{
    return runStability(worldNamed(name), setting);
}

TEST(StabilityWorlds, HaveNamesOfTheirOwn)
{
    std::set<std::string> names;
    for (const StabilityWorld& world : stabilityWorlds())
    {
        names.insert(world.name);
    }
    EXPECT_EQ(names.size(), stabilityWorlds().size());
}

TEST(StabilityRun, OfShapesOfBulletIsTheSameInBothWorldsWhereNothingIsFast)
{
    const StabilitySetting setting{.rate = 240, .iterations = 50, .seconds = 2.0};
    StabilitySetting ours = setting;
    ours.kind = Kind::World;
    const StabilityOutcome a = run("hold_jaws", setting);
    const StabilityOutcome b = run("hold_jaws", ours);
    EXPECT_GT(a.drift, 0.0) << "nothing moves: the test is vacuous";
    EXPECT_EQ(a.drift, b.drift);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.maxKinetic, b.maxKinetic);
}

TEST(StabilityRun, LightLinksGoThroughAWallInStockBulletAndStopAtItInOurs)
{
    StabilitySetting setting{.rate = 60, .iterations = 10, .seconds = 0.5};
    EXPECT_EQ(run("light_hit_mesh", setting).verdict, StabilityVerdict::Through);
    for (const Kind kind : reference::kOurKinds)
    {
        setting.kind = kind;
        const StabilityOutcome outcome = run("light_hit_mesh", setting);
        EXPECT_EQ(outcome.verdict, StabilityVerdict::Held);
        EXPECT_EQ(outcome.depth, 0.0);
        EXPECT_LT(outcome.energyGain, 1e-9);
        EXPECT_GT(outcome.counters.m_impacts, 0);
    }
}

TEST(StabilityRun, MeshesInTheHandStayApartWhereStockBulletLosesThem)
{
    StabilitySetting setting{.rate = 240, .iterations = 200, .seconds = 2.0};
    const StabilityOutcome stock = run("squeeze_mesh", setting);
    setting.kind = Kind::World;
    const StabilityOutcome ours = run("squeeze_mesh", setting);
    EXPECT_GT(stock.depth, 0.0);
    EXPECT_EQ(ours.depth, 0.0);
    EXPECT_EQ(ours.verdict, StabilityVerdict::Held);
}

TEST(StabilityRun, FingersThatBeginWithAnImpactHoldAtLargeSteps)
{
    // The ball spins after it by more than a tenth of a radian in a step.
    const StabilityOutcome outcome = run("hold_fingers",
                                         {.kind = Kind::World,
                                          .rate = 60,
                                          .iterations = 50,
                                          .seconds = 4.0,
                                          .solver = StabilitySolver::Holding});
    EXPECT_EQ(outcome.verdict, StabilityVerdict::Held);
}
}  // namespace
}  // namespace bullet_ccd::benchmarks
