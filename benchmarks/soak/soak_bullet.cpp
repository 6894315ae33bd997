/// Long runs of Bullet worlds with continuous collision detection under checks of their own.
#include "benchmarks/soak/bullet_soaks.h"

#include <algorithm>

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    BinSoak bin;
    const auto makeBin = [&](bool quick)
    {
        if (quick)
        {
            // Twenty objects rest after some two seconds.
            bin.objects = std::min(bin.objects, 20);
            bin.seconds = std::min(bin.seconds, 4.0);
        }
        return binSoak(bin);
    };
    RandomSoak random;
    const auto makeRandom = [&](bool quick)
    {
        random.seconds = quick ? std::min(random.seconds, 1.0) : random.seconds;
        return randomSoak(random);
    };
    SoftSoak soft;
    return runProgram(
        argc,
        argv,
        {.name = "soak_bullet",
         .about = "Long runs of Bullet worlds of ours under checks of their own.",
         .options = {},
         .verbs = {
             soakProgram(
                 "bin",
                 "Household objects fall into a bin; at the end all rest in it and none intersect.",
                 {.checkpoint = "soak_bullet_bin.checkpoint"},
                 makeBin,
                 {{"--objects", &bin.objects, "number of objects in each bin"},
                  {"--seconds", &bin.seconds, "simulated time [s]"},
                  {"--rest-speed", &bin.restSpeed, "largest mean speed at the end [m/s]"},
                  {"--dt", &bin.timeStep, "time step [s]"},
                  {"--accuracy", &bin.accuracy, "models in place of full meshes [m]"},
                  {"--samples", &bin.mostSamples, "poses to look at in a step, at most"}}),
             soakProgram(
                 "random",
                 "Random things happen to random objects in a closed room; nothing gets "
                 "out of it.",
                 {.count = 1000, .quickCount = 3, .checkpoint = "soak_bullet_random.checkpoint"},
                 makeRandom,
                 {{"--bodies", &random.bodies, "number of objects in most rooms, at most"},
                  {"--seconds", &random.seconds, "simulated time [s]"}}),
             soakProgram(
                 "soft",
                 "Random drops of cloth, ropes and volumes onto thin, round and hollow things and "
                 "onto each other; no node goes through anything, and no edge crosses a face.",
                 {.count = 100, .quickCount = 10, .checkpoint = "soak_bullet_soft.checkpoint"},
                 [&](bool) { return softSoak(soft); },
                 {{"--seconds", &soft.seconds, "simulated time of a drop [s]"},
                  {"--stock",
                   &soft.withStock,
                   "run every drop in stock Bullet, too, and add up the processor times (take "
                   "--jobs 1; the table then depends on the machine)"}})}});
}
