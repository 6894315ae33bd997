#include "benchmarks/reference/catalogue/catalogue.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
// clang-format off
constexpr CatalogueRow kRows[] = {
    {"A01", "a cube falls face on: a whole face of witnesses"},
    {"A02", "a cube falls on its corner"},
    {"A03", "a cube falls on its edge: a segment of witnesses"},
    {"A04", "crossed rods: edge against edge"},
    {"A05", "rods at an angle of 1e-6: cross product of edges without digits"},
    {"A06", "parallel rods: cross product of edges is 0"},
    {"A07", "octahedra tip to tip: the normal is not unique"},
    {"A08", "two spheres, a quadratic"},
    {"A09", "two spheres in a common drift 400 times their relative speed"},
    {"A10", "a cube through a sheet of no thickness in 1/1000 of the motion"},
    {"A11", "straight through a slot with a clearance of 1e-3"},
    {"A12", "through the slot with a sideways drift of 1/1000 of the speed"},
    {"A13", "parallel cylinders: a line of witnesses"},
    {"A14", "two cubes edge to edge: the separating direction jumps"},
    {"B01", "a rod turns to a wall"},
    {"B02", "a bar's side turns into a pin"},
    {"B03", "the same in three turns: end poses show no rotation"},
    {"B04", "half a turn: end poses leave the sense of rotation open"},
    {"B05", "a millionth of a radian: acos of a quaternion has lost it"},
    {"B06", "a box tips onto a plane"},
    {"B07", "tiny angle on a lever of 100"},
    {"B08a", "a rod turns about its pivot"},
    {"B08b", "same end poses, but the tip moves on the straight line"},
    {"B09", "two doors close: both turn, tip to tip"},
    {"B10", "scissors: the contact slides along the blade"},
    {"B11", "a square peg turns in a square hole: four contacts at once, volumes overlap"},
    {"B12", "a 256-gon turns in a bearing with a clearance of 1e-3"},
    {"B13", "a wheel of 1024 corners turns 1e-3 over a plane"},
    {"B14", "a hollow cube tumbles about a sphere inside it"},
    {"B15", "a cone spins 50 turns about its axis: speed that does not matter"},
    {"B16", "a flywheel of 100 turns, 1e-3 from a wall"},
    {"B18", "cogs: a pin meets a flank while both wheels turn"},
    {"C01", "a screw passes the side of a block and lands on top"},
    {"C02", "a screw's arm becomes coplanar with the face that it hits"},
    {"C03", "a tumbling rod falls flat"},
    {"C05a", "the cusp of a cycloid: no velocity at the contact"},
    {"C05b", "almost the cusp"},
    {"D01", "spheres touch in passing: a double root"},
    {"D02a", "spheres pass with an overlap of 1e-3"},
    {"D02b", "spheres pass with an overlap of 1e-6"},
    {"D02c", "spheres pass with an overlap of 1e-9"},
    {"D03", "spheres pass with a gap of 1e-6"},
    {"D04", "a rod's tip reaches 1e-6 beyond the wall"},
    {"D05", "a rod's tip just reaches the wall"},
    {"D06", "a rod's tip stays 1e-6 short of the wall"},
    {"D07", "slides 1000 times its size at a gap of 1e-3"},
    {"D09a", "cubes pass face along face at distance 0"},
    {"D09b", "cubes pass at 1e-12"},
    {"D09c", "cubes overlap by 1e-12 in passing"},
    {"D10", "onto the apex of 32 triangles: a crack between them lets nothing through"},
    {"D11", "a double root with a moving plane (H04)", kDeformable},
    {"E01", "overlapping at the start"},
    {"E02", "touches at distance 0 and leaves"},
    {"E02b", "leaves a contact at half the tolerance"},
    {"E03", "touches at distance 0 and slides"},
    {"E03b", "slides on a contact at half the tolerance"},
    {"E04", "slides off a contact at half the tolerance, leaving slowly"},
    {"E05", "nothing moves"},
    {"E06", "two cubes at a gap of 1e-3 turn and fly as one"},
    {"E07", "inside a hollow box: no solid is assumed"},
    {"E08", "contact at the very end"},
    {"E09", "contact 1e-9 after the end"},
    {"E10", "contact after 1e-9"},
    {"E11", "touches at distance 0 and spins on the spot"},
    {"E11b", "spins on a contact at half the tolerance"},
    {"E12", "back from a reported contact",
     "tests/toi/rigid_toi_state_test.cpp: RigidToiState.ARestartFromTheReportedContactCanGoBack"},
    {"E13", "1000 restarts leave one tolerance, not 1000",
     "tests/stability/articulated_stability_test.cpp: GraspSequence.AThousandSubQueriesLeaveOneTolerance"},
    {"E14", "input that is not finite is refused",
     "tests/toi/rigid_toi_state_test.cpp: RigidToiState.RejectsMotionsAndTolerancesThatAreNotFinite"},
    {"F01", "a triangle that is a segment"},
    {"F02", "a triangle that is a point"},
    {"F03", "a plate of slivers of aspect 1e8"},
    {"F04", "everything a thousandth in size: absolute tolerances are a fifth of the body"},
    {"F05", "everything 1e6 off the origin"},
    {"F06a", "spheres in units of 1e-6"},
    {"F06b", "spheres in units of 1e6"},
    {"F06c", "bar and pin in units of 1e-6"},
    {"F06d", "bar and pin in units of 1e6"},
    {"F07", "a soup: duplicates, T-junctions, flipped and unused"},
    {"F08", "a cube through a window 1e-3 wider: its hull is solid"},
    {"F09", "1000 triangles with one centroid"},
    {"F10", "two flat triangles, parallel"},
    {"F11", "a needle of 1e-6 through a ring of 1e-3"},
    {"F12", "a bar swings to a plate; start orientation rotated in the relations"},
    {"F13", "order of triangles does not change a bit",
     "tests/toi/rigid_toi_invariance_test.cpp: RigidToiInvariance.OrderOfTrianglesDoesNotChangeABit"},
    {"F14", "a slow pair that is nearer hides the fast pair that hits first"},
    {"F15", "two boxes driven at each other"},
    {"F16", "swept boxes contain their links",
     "tests/motion/frame_sweep_test.cpp: FrameSweep.BoxesContainMillionsOfPointsOfRandomTrees"},
    {"F17", "lengths whose squares over- or underflow",
     "tests/stability/rigid_stability_test.cpp: RigidExtremes.LengthsThatCannotBeSquaredAreRefusedOrAnsweredRightly"},
    {"F17a", "a cube of 1e-8"},
    {"F17b", "a cube of 1e10"},
    {"G01", "a pendulum on a wall: B01 as a joint"},
    {"G02", "two joints turn and the tip moves on a straight line"},
    {"G03", "a parallelogram: the distal link only shifts"},
    {"G04", "a finger curls into itself"},
    {"G05", "four pendulums: the earliest counts"},
    {"G06", "four pendulums at the same time: all are reported"},
    {"G09", "a finger of coupled joints on a plane"},
    {"G10", "a joint of one and a half turns: its angle is not wrapped"},
    {"G12a", "a finger's side wraps a cylinder"},
    {"G12b", "a fingertip on a cylinder"},
    {"G13", "the second phalanx, while the first is in contact all the time"},
    {"G14", "joints that cancel: fast, but nothing moves"},
    {"G15", "mirrored fingers: a tie"},
    {"G16", "a hand closes on nothing",
     "tests/grasp/closing/closing_engines_test.cpp: ClosingEngine.ClosingOnNothingEndsAtTheLimitsExactly"},
    {"G17", "a six-link chain closes around a pole at a clearance of 1e-3"},
    {"H01", "vertex and face", kDeformable},
    {"H02", "a tilting face", kDeformable},
    {"H03", "edge and edge", kDeformable},
    {"H04", "a double root", kDeformable},
    {"H05", "coplanar for all time", kDeformable},
    {"H06", "collinear, end to end", kDeformable},
    {"H07", "parallel edges", kDeformable},
    {"H08", "chord against arc", kDeformable},
    {"H09", "the second root counts", kDeformable},
    {"H10", "self-contact of a flap", kDeformable},
    {"H11", "an inflating sphere", kDeformable},
    {"H12", "a common velocity of 1e6", kDeformable},
    {"H13", "two cloth layers", kDeformable},
    {"H14", "a strip collapses", kDeformable},
    {"H15", "the topology changes", kDeformable},
    {"I01", "a palm approaches a sphere"},
    {"I02", "parallel jaws on a centred block: a tie"},
    {"I03a", "off centre: the first jaw"},
    {"I03b", "off centre: the second jaw, the first in contact"},
    {"I04", "out of reach costs no triangle tests",
     "tests/stability/articulated_stability_test.cpp: GraspSequence.AnObjectOutOfReachCostsNoTriangleTests"},
    {"I05", "swept boxes overlap, the finger misses"},
    {"I06a", "the joint stops 3e-5 before the contact"},
    {"I06b", "the joint stops just after the contact"},
    {"I07", "fingers close although the palm touches",
     "tests/grasp/closing/closing_engines_test.cpp: ClosingEngine.FingersCloseAlthoughThePalmTouches"},
    {"I08", "finger meets finger before the object"},
    {"I09", "a finger wraps link by link",
     "tests/stability/articulated_stability_test.cpp: GraspSequence.TheFingerWrapsTheCylinderLinkByLink"},
    {"I10", "a fingertip below the palm touches first"},
    {"I11", "the order of fingers that cannot meet does not matter",
     "tests/stability/articulated_stability_test.cpp: GraspSequence.TheOrderOfFingersThatCannotMeetDoesNotMatter"},
    {"I12", "a palm on a face: contacts span the overlap",
     "tests/contact/find_contacts_test.cpp: FindContacts.AFlatPalmOnACubeFaceSpansTheOverlap"},
    {"I13", "a finger sweeps over a plate of 1e-4"},
    {"I14", "opening from the final grasp is free",
     "tests/stability/articulated_stability_test.cpp: GraspSequence.OpeningFromAContactIsFree"},
    {"J01", "a near miss of 1e-6, then a wall"},
    {"J03", "100 plates at once"},
    {"J04", "a peg in a blind hole: side walls near all the time"},
    {"J05", "combs slide into each other at a clearance of 1e-3"},
    {"J06", "the pin is in the way in both of two turns"},
    {"J07", "onto the floor of a cavity: convex pieces report its rim"},
    {"J09", "a million unit queries in a row",
     "tests/stability/rigid_stability_test.cpp: RigidExtremes.ALongFlightMeetsTheGroundInItsLastQuery"},
    {"K01", "swapped bodies: within the window of the tolerance",
     "tests/stability/rigid_stability_test.cpp: RigidStability.KeepsItsAnswerUnderEveryRelation"},
    {"K02", "moved as a whole: within the window of the tolerance",
     "tests/stability/rigid_stability_test.cpp: RigidStability.KeepsItsAnswerUnderEveryRelation"},
    {"K03", "split in two queries: within the window",
     "tests/stability/rigid_stability_test.cpp: RigidStability.KeepsItsAnswerUnderEveryRelation"},
    {"K04", "a common velocity",
     "tests/toi/rigid_toi_invariance_test.cpp: RigidToiInvariance.CommonVelocityKeepsTheTime"},
    {"K05", "quaternions of either sign (poses are matrices here: nothing to test)",
     "tests/motion/rigid_motion_test.cpp: MotionBetween.TakesThePositiveAxisAtAHalfTurn"},
    {"K06", "other units",
     "tests/stability/rigid_stability_test.cpp: RigidStability.KeepsItsAnswerUnderEveryRelation"},
    {"K07", "single precision: hierarchies are in it, and keep their margin",
     "tests/toi/node_batch_test.cpp: NodeBatch.StepsKeepTheirMarginAndAreAsLongAsInDoublePrecision"},
    {"K08", "a smaller tolerance is not reached earlier",
     "tests/toi/rigid_toi_invariance_test.cpp: RigidToi.SmallerTolerancesAreReachedLater"},
    {"K09", "a longer horizon keeps the contact",
     "tests/toi/rigid_toi_invariance_test.cpp: RigidToi.ALongerHorizonKeepsTheContact"},
    {"K10", "more obstacles never delay a contact",
     "tests/stability/relations_test.cpp: Supersets.NeverDelayAContact"},
    {"K11", "a thicker body never touches later",
     "tests/toi/rigid_toi_separation_test.cpp: RigidToiSeparation.ALargerMinimumSeparationNeverStopsLater"},
    {"K12", "a volume pair's time is not after that of the triangles below",
     "tests/distance/tree_distance_test.cpp: Separation.NeverExceedsTheDistanceOfTheTrianglesBelow"},
    {"K13", "all strategies find the same contact",
     "tests/toi/rigid_toi_invariance_test.cpp: RigidToi.AllStrategiesFindTheSameContact"},
    {"K14", "one link moves like a rigid body",
     "tests/toi/articulated_toi_test.cpp: ArticulatedToi.OneLinkMovesLikeARigidBody"},
    {"K15", "the same bits on repetition, for any number of threads",
     "tests/toi/rigid_toi_workspace_test.cpp: RigidToiWorkspace.ThreadsAnswerAsQueriesOneByOne"},
    {"N01", "bars with parallel edges, one turns: a step that stalls was called a hit"},
    {"N02", "crossing slivers of aspect 1e9: hits with a gap of 0 that were none"},
    {"N03", "turns by 1e-5 about an axis 1e5 away: the start pose was off"},
    {"N04", "a mesh 1000 off its frame turns about itself: a thousand times too many steps"},
    {"N05", "spins 64 turns on the spot over a plane: a pose for every bit of a turn"},
    {"N06", "30 turns as one body, closing slowly along the axis"},
    {"N07", "leaves a contact and comes back after a turn"},
    {"N08", "everything 1e8 off the origin"},
    {"N09", "needles of 1e-3 tip to tip"},
    {"N10", "sizes that differ by a million"},
    {"N11", "contact 1e-9 before the end"},
    {"N12", "two contacts 1e-9 apart: the first counts"},
    {"N13", "6000 turns: whole ones between samples at 1/60, 1/240 and 1/1000"},
    {"N14", "a blade of no thickness spins 50 turns into a wall"},
    {"N15", "through a sheet between the last two of 1000 samples"},
    {"N16", "seven fins on one edge: no surface at all"},
    {"N17", "links of a chain pulled apart: hulls overlap"},
    {"N18", "a floor doubled one unit in the last place below"},
    {"N19", "a 64-gon in a bearing: one strategy gave up"},
    {"N20", "a pinned rod hits a blade: worlds of Bullet let it through"},
    {"N21", "touches, at rest for an instant, and curves in: the corner that came back for ever"},
    {"N22", "a needle on a ribbon of aspect 1e8"},
    {"N23", "a chain of 40 links curls into a wall"},
    {"N24", "a joint of fifty turns"},
    {"N25", "a joint of a millionth of a radian"},
    {"N26", "fingers meet on a hand that flies at 1000 and turns"},
};

constexpr std::pair<char, std::string_view> kGroups[] = {
    {'A', "Pure translation"},
    {'B', "Rotation"},
    {'C', "Screws and combined motion"},
    {'D', "Grazing and near miss"},
    {'E', "Initial and final states"},
    {'F', "Degeneracy, scale, representation"},
    {'G', "Chains of joints"},
    {'H', "Deformable bodies"},
    {'I', "Grasping"},
    {'J', "Order, culling, concavity"},
    {'K', "Relations"},
    {'N', "Found here"},
};
// clang-format on
}  // namespace

std::span<const CatalogueRow> catalogueRows()
{
    return kRows;
}

const CatalogueRow& catalogueRow(std::string_view id)
{
    const auto found = std::find_if(
        std::begin(kRows), std::end(kRows), [&](const CatalogueRow& row) { return row.id == id; });
    if (found == std::end(kRows))
    {
        throw std::invalid_argument("catalogue.cpp: no row " + std::string(id) + ": add it");
    }
    return *found;
}

std::string catalogueTable()
{
    std::string table = "| id | set-up, and what is hard about it | where |\n|---|---|---|\n";
    for (const CatalogueRow& row : catalogueRows())
    {
        std::string where = "case, all methods";
        if (!row.tested.empty())
        {
            const std::size_t colon = row.tested.find(": ");
            where = colon == std::string_view::npos
                        ? std::string(row.tested)
                        : std::string("`").append(row.tested.substr(colon + 2)).append("`");
        }
        for (const std::string_view cell : {row.id, row.title, std::string_view(where)})
        {
            table.append("| ").append(cell).append(" ");
        }
        table.append("|\n");
    }
    return table;
}

std::string_view groupTitle(std::string_view id)
{
    const auto found =
        std::find_if(std::begin(kGroups),
                     std::end(kGroups),
                     [&](const auto& group) { return !id.empty() && group.first == id[0]; });
    if (found == std::end(kGroups))
    {
        throw std::invalid_argument("catalogue.cpp: no group of " + std::string(id) + ": add it");
    }
    return found->second;
}
}  // namespace bullet_ccd::reference
