/// Long runs of Bullet worlds with continuous collision detection, every pose looked at by an exact
/// check.
#include "benchmarks/soak/bullet_soaks.h"

#include <CLI/CLI.hpp>

namespace
{
using namespace bullet_ccd::benchmarks;

/// What both kinds of worlds have.
template <typename Kind>
CLI::App* addKind(
    CLI::App& app, const char* name, const char* what, Kind& soak, SoakOptions& options)
{
    CLI::App* kind = app.add_subcommand(name, what);
    addSoakOptions(*kind, options);
    kind->add_option("--dt", soak.timeStep, "time step [s]")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    kind->add_option("--samples", soak.mostSamples, "poses to look at in a step, at most")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    return kind;
}
}  // namespace

int main(int argc, char** argv)
{
    CLI::App app{
        "Long runs of Bullet worlds with continuous collision detection, every pose looked at by "
        "an exact check. Exit code 1 if anything went wrong, 2 if the run proves little, 3 if it "
        "could not be run."};
    app.require_subcommand(1);
    BinSoak bin;
    SoakOptions bins{.checkpoint = "soak_bullet_bin.checkpoint"};
    CLI::App* binApp =
        addKind(app,
                "bin",
                "Household objects fall into a bin; at the end all rest in it and none intersect.",
                bin,
                bins);
    const auto* objects =
        binApp->add_option("--objects", bin.objects, "number of objects in each bin")
            ->check(CLI::PositiveNumber)
            ->capture_default_str();
    const auto* seconds = binApp->add_option("--seconds", bin.seconds, "simulated time [s]")
                              ->check(CLI::PositiveNumber)
                              ->capture_default_str();
    binApp
        ->add_option("--rest-speed", bin.restSpeed, "largest mean speed at the end [m/s]; < 0: any")
        ->capture_default_str();
    HandSoak hand{.hand = BULLET_CCD_SHIPPED_HAND};
    SoakOptions hands{.count = 30, .quickCount = 3, .checkpoint = "soak_bullet_hand.checkpoint"};
    CLI::App* handApp = addKind(app,
                                "hand",
                                "A hand closes on objects and opens again; nothing ever "
                                "intersects.",
                                hand,
                                hands);
    handApp->add_option("--hand", hand.hand, "URDF of the hand")
        ->check(CLI::ExistingFile)
        ->capture_default_str();
    handApp->add_option("--objects", hands.count, "the same as --count")
        ->check(CLI::PositiveNumber);
    const auto* closings =
        handApp->add_option("--closings", hand.closings, "closings on each object")
            ->check(CLI::PositiveNumber)
            ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    if (bins.quick && objects->empty() && seconds->empty())
    {
        // Twenty objects rest after some two seconds.
        bin.objects = 20;
        bin.seconds = 4.0;
    }
    if (hands.quick && closings->empty())
    {
        hand.closings = 3;
    }
    return app.got_subcommand(binApp) ? runSoak(binSoak(bin), bins)
                                      : runSoak(handSoak(hand), hands);
}
