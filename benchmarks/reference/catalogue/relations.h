/// Metamorphic relations: what has to stay the same, on top of every case.
///
/// A relation makes variants of a case whose exact answer follows from that of the case. A variant
/// is one query, or a few that are asked one after the other until one finds a contact.
///
/// Reversed: a case without contact has none backwards either. Up to a contact at T the bodies are
/// apart, so the motion from just before it (where ten times the finest tolerance is left) back to
/// the start has none; that is the variant, and it is defined if that time is after the start and
/// the start is not within the tolerance itself. (Backwards from a reported time the bodies start
/// within the tolerance: that is left to tests of this library, whose statuses say what follows.)
///
/// Split: at half the time of contact, and where three times and where half the finest tolerance is
/// left, and beyond the contact; without contact at two times. The second query starts from the end
/// pose of the first.
#pragma once

#include "benchmarks/reference/catalogue/cases.h"

#include <array>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
enum class Relation : std::uint8_t
{
    Moved,       ///< the whole scene in three other frames
    Swapped,     ///< A is B
    Rescaled,    ///< all lengths in units of 1e-3 and 1e3, the tolerance with them
    Permuted,    ///< triangles in other orders, from other corners
    Subdivided,  ///< every triangle in four, at its exact midpoints
    Reversed,    ///< backwards
    Split,       ///< [0, s], then [s, 1]
};
inline constexpr std::array<Relation, 7> kRelations{Relation::Moved,
                                                    Relation::Swapped,
                                                    Relation::Rescaled,
                                                    Relation::Permuted,
                                                    Relation::Subdivided,
                                                    Relation::Reversed,
                                                    Relation::Split};

[[nodiscard]] const char* nameOf(Relation relation);

/// A query over the part [begin, end] of the whole motion. Its own answer holds the tolerances; the
/// exact time is in the variant.
template <typename Case>
struct Leg
{
    Case tested;
    double begin = 0.0;
    double end = 1.0;
};

template <typename Case>
struct Variant
{
    std::string name;
    std::vector<Leg<Case>> legs;
    CaseAnswer answer;
    /// The relation keeps the times of a method that follows the geometry alone.
    double unit = 1.0;
};

/// None where the relation is not defined: a case whose first distance is 0 hangs on the last bit
/// of a pose, and a chain without pairs of its own links has nothing to swap.
[[nodiscard]] std::vector<Variant<RigidCase>> variantsOf(const RigidCase& tested,
                                                         Relation relation);
[[nodiscard]] std::vector<Variant<ArticulatedCase>> variantsOf(const ArticulatedCase& tested,
                                                               Relation relation);

/// The part of the case's motion from `begin` to `end`, which may be before `begin`.
[[nodiscard]] RigidCase partOf(const RigidCase& tested, double begin, double end);
[[nodiscard]] ArticulatedCase partOf(const ArticulatedCase& tested, double begin, double end);

/// Every triangle as four.
[[nodiscard]] TriangleMesh subdivided(const TriangleMesh& mesh);
}  // namespace bullet_ccd::reference
