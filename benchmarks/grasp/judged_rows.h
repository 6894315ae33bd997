/// What is measured of one hand and one object: rows of the log, and what they add up to.
#pragma once

#include "grasp/planner/grasp_planner.h"
#include "tools/grasp_cli/answers/mjcf_pieces.h"
#include "tools/grasp_cli/inputs/catalogue.h"

#include <nlohmann/json_fwd.hpp>

namespace bullet_ccd::benchmarks
{
enum class ClosingReference : std::uint8_t
{
    Sweep,      ///< the discrete baseline in steps of 0.001 rad
    Simulated,  ///< the engine on Bullet's multibody world
    Full,       ///< the kinematic engine at the default tolerance
};
[[nodiscard]] const char* toString(ClosingReference reference);

/// Samples candidates, closes each where its approach meets the object by the kinematic engine and
/// by the reference, and looks at both: what is inside something, how wide stops gape, and which is
/// right where they differ. Joints may differ by 0.02 rad from the sweep; by 0.01 rad, and not in
/// the links that are stopped, from the simulation. Beside the full models, gaps may be as wide as
/// the tolerance of the options.
/// @return a row of the log
[[nodiscard]] nlohmann::json judgeClosings(const tools::LoadedHand& hand,
                                           const tools::LoadedObject& object,
                                           ClosingReference reference,
                                           const grasp::PlannerOptions& options);

/// Plans grasps: how many of the candidates are force closures, the best epsilon, the time, and the
/// reasons of the rejected ones.
/// @return a row of the log
[[nodiscard]] nlohmann::json judgePlans(const tools::LoadedHand& hand,
                                        const tools::LoadedObject& object,
                                        const grasp::PlannerOptions& options);

struct TrialQuestions
{
    int best = 5;  ///< force closures of each pair
    std::vector<std::string> suites{"six", "dexgraspbench", "lift"};
    double torsion = 0.0;                          ///< in MuJoCo, of six and lift [m]
    double skinStiffness = grasp::kSkinStiffness;  ///< of our trials [N/m]
    ConvexPiecesOptions pieces;                    ///< of MuJoCo's models, as of `grasp export`
    bool alone = false;                            ///< without MuJoCo
};

/// Plans, and tries the best force closures and the first by the score (hold_score.h) by the suites
/// in our simulation and in MuJoCo, with the same squeezes: a row of the log. Needs MuJoCo.
[[nodiscard]] nlohmann::json judgeTrials(const tools::LoadedHand& hand,
                                         const tools::LoadedObject& object,
                                         const grasp::PlannerOptions& options,
                                         const TrialQuestions& questions,
                                         tools::PieceStore& pieces);

// Tables of what was judged, and whether it is good.

/// Prints a line per hand of rows of judgeClosings(), and the closings that nothing explains.
/// @return whether all is good
[[nodiscard]] bool summarizeClosings(const std::vector<nlohmann::json>& rows);
/// Prints a line per hand of rows of judgePlans(), and the objects that no hand holds, with the
/// reasons.
/// @return whether any object is held
[[nodiscard]] bool summarizePlans(const std::vector<nlohmann::json>& rows);

/// What follows the name of a hand in rows of judgePlans() that did not see its SRDF.
inline constexpr const char* kWithoutSrdf = ", inferred";
/// Prints a line per hand that has rows with and without its SRDF: both rates, and their ratio with
/// an interval of 95 %, by drawing the objects anew 2,000 times.
/// @return whether each rate without is at least 0.9 of that with, and each rate with at least 0.97
///         of that without
[[nodiscard]] bool summarizeInference(const std::vector<nlohmann::json>& rows);
/// summarizePlans(), the mean rate of the hands, and how many of their objects are held.
/// @return whether those are at least 60 % and 90 %
[[nodiscard]] bool summarizeThumbed(const std::vector<nlohmann::json>& rows);
}  // namespace bullet_ccd::benchmarks
