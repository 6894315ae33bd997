/// Chains that were hard here: many links, many turns, hardly any turn, a base that flies.
#include "benchmarks/reference/catalogue/case_parts.h"
#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/random_trees.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <cmath>

namespace bullet_ccd::reference
{
namespace
{
/// N links of length L, all joints turn alike: the tip is at the sum of L sin(k q), and highest.
/// Bounds that add up over the links make every step 1/N^2 as long; Taylor models of boxes were
/// wider than the scene.
ArticulatedCase longChain()
{
    constexpr std::size_t kLinks = 40;
    constexpr double kLength = 0.1;
    constexpr double kRate = 0.05;
    const double time = 0.4;
    double height = 0.0;
    double speed = 0.0;
    for (std::size_t k = 1; k <= kLinks; ++k)
    {
        const auto turns = static_cast<double>(k);
        height += kLength * std::sin(turns * kRate * time);
        speed += kLength * turns * kRate * std::cos(turns * kRate * time);
    }
    ArticulatedCase result{
        .id = "N23",
        .tree = planarChain(std::vector<double>(kLinks, kLength)),
        .linkMeshes = std::vector<TriangleMesh>(1),
        .motion = {.root = {},
                   .positions = std::vector<double>(kLinks + 1, 0.0),
                   .rates = std::vector<double>(kLinks + 1, kRate)},
        .obstacles = {wallAtY(height, 10.0)},
        .answer = {.time = time, .closingSpeed = speed, .tolerances = {1e-4, 1e-6}},
        .links = {kLinks}};
    result.linkMeshes.resize(kLinks + 1, segment({0, 0, 0}, {kLength, 0, 0}));
    return result;
}

/// A bar of half thickness 0.05 turns fifty times; a pin is in its way in every turn. Angles that
/// are wrapped, and intervals that are halved down to a part of a turn before anything is found.
ArticulatedCase fiftyTurns()
{
    return barTurnsIntoPin("N24", 100.0 * kPi);
}

/// B05 as a joint, at tolerances down to 1e-11: the order of rounding.
ArticulatedCase tinyTurn()
{
    const double w = 1e-6;
    return {.id = "N25",
            .tree = planarChain({1.0}),
            .linkMeshes = {{}, segment({0, 0, 0}, {1, 0, 0})},
            .motion = {.root = {}, .positions = {0, 0}, .rates = {0, w}},
            .obstacles = {wallAtY(5e-7, 4.0)},
            .answer = {.time = std::asin(5e-7) / w, .closingSpeed = w, .tolerances = {1e-9, 1e-11}},
            .links = {1}};
}

/// I08 on a base that flies at 1e4 times the fingers' speed and turns once: mirrored fingers with
/// bases 2 L cos(q) apart meet with their tips at the angle q. In the frame of the base nothing of
/// this is left; bounds in the world have to pay for it.
ArticulatedCase flyingHand()
{
    const double L = 0.08;
    const double apart = 0.12;
    const double angle = std::acos(apart / (2.0 * L));
    KinematicTree tree = planarChain({L});
    tree.links.push_back(planarChain({L}, {apart, 0, 0}).links[1]);
    const TriangleMesh finger = segment({0, 0, 0}, {L, 0, 0});
    return {
        .id = "N26",
        .tree = tree,
        .linkMeshes = {{}, finger, finger},
        .motion = {.root = {.v_W = {1000, -500, 200}, .w_W = {0, 2.0 * kPi, 0}},
                   .positions = {0, 1.2, kPi - 1.2},
                   .rates = {0, -1, 1}},
        .selfPairs = {{1, 2}},
        .obstacles = {},
        .answer = {.time = 1.2 - angle, .closingSpeed = 2.0 * L * std::sin(angle), .length = 0.1},
        .links = {1}};
}
}  // namespace

std::vector<ArticulatedCase> foundChainCases()
{
    return {longChain(), fiftyTurns(), tinyTurn(), flyingHand()};
}
}  // namespace bullet_ccd::reference
