// Twenty household objects, triangle meshes of some thousand triangles each, fall into a bin. Stock
// Bullet has no contacts between meshes at all; here no two objects ever intersect. `soak_bullet
// bin` watches 200 objects for 20 s.
#include "benchmarks/soak/household_bin.h"

#include <cstdio>

int main()
{
    using namespace bullet_ccd::examples;
    using bullet_ccd::reference::AuditResult;
    using bullet_ccd::reference::WorldAudit;

    constexpr double kTimeStep = 1.0 / 240.0;  // [s]
    constexpr int kSteps = 480;
    World world(Engine::Ccd);
    world->setGravity(btVector3(0, 0, btScalar(-9.81)));
    WorldAudit audit(*world, {.longestMove = 5e-3, .mostSamples = 8});
    world.ccd().setCcdImpactListener(&audit);
    const HouseholdBin bin(world, audit, {.objects = 20});

    AuditResult seen = audit.start();
    for (int step = 1; step <= kSteps; ++step)
    {
        seen.add(audit.step(kTimeStep));
        if (step % 60 == 0)
        {
            std::printf("%.2f s: %2d objects inside, mean speed %.3f m/s, %lld impacts\n",
                        step * kTimeStep,
                        bin.countInside(),
                        bin.meanSpeed(),
                        static_cast<long long>(world.ccd().getCcdCounters().m_impacts));
        }
    }
    std::printf("%lld poses looked at, %lld pairs of bodies near each other\n",
                static_cast<long long>(seen.poses),
                static_cast<long long>(seen.pairs));
    if (!seen.clean())
    {
        std::printf("%s\n", bullet_ccd::reference::describe(seen, bin.names()).c_str());
    }
    check(seen.clean(), "no two bodies intersect, at no time");
    check(bin.countInside() == int(bin.size()), "all objects are in the bin");
    return exitCode();
}
