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
    return {.id = "N23",
            .tree = planarChain(std::vector<double>(kLinks, kLength)),
            .linkMeshes = rods(std::vector<double>(kLinks, kLength)),
            .motion = {.root = {},
                       .positions = std::vector<double>(kLinks + 1, 0.0),
                       .rates = std::vector<double>(kLinks + 1, kRate)},
            .obstacles = {wallAtY(height, 10.0)},
            .answer = {.time = time, .closingSpeed = speed, .tolerances = {1e-4, 1e-6}},
            .links = {kLinks}};
}

/// I08 on a base that flies at 1e4 times the fingers' speed and turns once. In the frame of the
/// base nothing of this is left; bounds in the world have to pay for it.
ArticulatedCase flyingHand()
{
    ArticulatedCase result = fingersMeet("N26");
    result.motion.root = {.v_W = {1000, -500, 200}, .w_W = {0, 2.0 * kPi, 0}};
    result.obstacles.clear();
    return result;
}
}  // namespace

std::vector<ArticulatedCase> foundChainCases()
{
    // B05 as a joint, at tolerances down to 1e-11: the order of rounding.
    ArticulatedCase tinyTurn = asJoint("N25", rodToWall("B05", 1.0, 5e-7, 1e-6));
    tinyTurn.answer.tolerances = {1e-9, 1e-11};
    return {longChain(),
            // A pin is in the way in every turn. Angles that are wrapped, and intervals that are
            // halved down to a part of a turn before anything is found.
            asJoint("N24", barToPin("B02", 100.0 * kPi)),
            tinyTurn,
            flyingHand()};
}
}  // namespace bullet_ccd::reference
