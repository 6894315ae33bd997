#include "benchmarks/soak/bullet_hand_soak.h"

#include "benchmarks/soak/bullet_hand_scene.h"
#include "benchmarks/soak/bullet_soak_report.h"
#include "benchmarks/soak/soak_progress.h"
#include "grasp/hand/hand_file.h"

#include <cstdio>

namespace bullet_ccd::tests
{
namespace
{
struct HandTally
{
    AuditResult seen = {};
    std::string deepest = {};  // sentence about it
    int held = 0;
};

void soakObject(const HandModel& hand,
                const HandSoak& soak,
                int index,
                SoakProgress& progress,
                HandTally& tally)
{
    SoakObject object = makeSoakObject(index, soak.seed);
    const std::string name = object.name + " " + std::to_string(index);
    HandScene scene(hand, std::move(object), soak);
    Random random(soak.seed * 7919 + static_cast<std::uint64_t>(index));
    int held = 0;
    for (int closing = 0; closing < soak.closings; ++closing)
    {
        const double done = index + double(closing) / soak.closings;
        held += scene.close(random, [&] { progress.show(done, name); }) ? 1 : 0;
    }
    std::printf("%s: held %d times in %d closings, %lld poses, %lld intersections\n",
                name.c_str(),
                held,
                soak.closings,
                static_cast<long long>(scene.seen().poses),
                static_cast<long long>(scene.seen().intersecting));
    scene.printBusiest();
    printCounters(scene.control(), soak.closings * (kClosingTime + kHoldingTime + kOpeningTime));
    if (!scene.seen().clean())
    {
        std::printf("%s\n", scene.describe().c_str());
        if (tally.seen.clean() || scene.seen().worst.depth > tally.seen.worst.depth)
        {
            tally.deepest = name + ": " + scene.describe();
        }
    }
    std::fflush(stdout);
    tally.held += held;
    tally.seen.add(scene.seen());
}
}  // namespace

bool runHandSoak(const HandSoak& soak)
{
    const HandModel hand = grasp::loadHand(soak.hand);
    HandTally tally;
    {
        SoakProgress progress(soak.objects);
        for (int index = 0; index < soak.objects; ++index)
        {
            soakObject(hand, soak, index, progress, tally);
        }
    }
    const int closings = soak.objects * soak.closings;
    std::printf("%d closings on %d objects, held %d times\n", closings, soak.objects, tally.held);
    printAudit(tally.seen, tally.deepest);
    // A hand that mostly closes on nothing would prove little.
    return tally.seen.clean() && 2 * tally.held >= closings;
}
}  // namespace bullet_ccd::tests
