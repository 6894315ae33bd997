/// Long runs of Bullet worlds with continuous collision detection, every pose looked at by the
/// exact check of the tests. Exit code 1 if anything went wrong, 3 if it could not be run.
#include "benchmarks/soak/bullet_bin_soak.h"
#include "benchmarks/soak/bullet_hand_soak.h"

#include <CLI/CLI.hpp>
#include <cstdio>

namespace
{
using namespace bullet_ccd::tests;

void addBin(CLI::App& app, BinSoak& soak)
{
    CLI::App* bin = app.add_subcommand(
        "bin", "Household objects fall into a bin; at the end all rest in it and none intersect.");
    bin->add_option("--objects", soak.objects, "number of objects")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    bin->add_option("--seconds", soak.seconds, "simulated time [s]")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    bin->add_option("--dt", soak.timeStep, "time step [s]")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    bin->add_option("--seed", soak.seed, "of places and sizes")->capture_default_str();
    bin->add_option("--samples", soak.mostSamples, "poses to look at in a step, at most")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    bin->add_option("--rest-speed", soak.restSpeed, "largest mean speed at the end [m/s]; < 0: any")
        ->capture_default_str();
}

void addHand(CLI::App& app, HandSoak& soak)
{
    CLI::App* hand = app.add_subcommand(
        "hand", "A hand closes on objects and opens again; nothing ever intersects.");
    hand->add_option("--hand", soak.hand, "URDF of the hand")
        ->check(CLI::ExistingFile)
        ->capture_default_str();
    hand->add_option("--objects", soak.objects, "number of objects")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    hand->add_option("--closings", soak.closings, "closings on each object")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    hand->add_option("--dt", soak.timeStep, "time step [s]")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    hand->add_option("--seed", soak.seed, "of sizes and poses")->capture_default_str();
    hand->add_option("--samples", soak.mostSamples, "poses to look at in a step, at most")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app{
        "Long runs of Bullet worlds with continuous collision detection, every pose looked at by "
        "an exact check."};
    app.require_subcommand(1);
    BinSoak bin;
    HandSoak hand;
    hand.hand = BULLET_CCD_SHIPPED_HAND;
    addBin(app, bin);
    addHand(app, hand);
    CLI11_PARSE(app, argc, argv);
    try
    {
        const bool good = app.got_subcommand("bin") ? runBinSoak(bin) : runHandSoak(hand);
        std::printf("%s\n", good ? "all is well" : "FAILED");
        return good ? 0 : 1;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "soak_bullet: %s\n", error.what());
        return 3;
    }
}
