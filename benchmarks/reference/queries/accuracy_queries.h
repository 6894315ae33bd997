/// Random queries that any gap within an accuracy will do for, on meshes of 12 to 100,000
/// triangles, judged on the full meshes.
#pragma once

#include "benchmarks/reference/oracles/toi_certificate.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/motion/rigid_motion.h"
#include "bullet_ccd/toi/toi.h"

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
/// A closed surface with waves, of about 2 n^2 triangles, near the ball of that radius.
[[nodiscard]] TriangleMesh wavyBall(int n, double radius, double phase);

/// Two wavy balls of 20 cm. B rests.
struct AccuracyQuery
{
    std::size_t sizeA = 0;  ///< index into accuracySizes()
    std::size_t sizeB = 0;
    RigidMotion motion = {};
    ToiOptions options = {};  ///< the tolerance, 1 um to 1 cm, is the accuracy
};

/// Names of the sizes of the meshes.
[[nodiscard]] std::vector<std::string> accuracySizes();

/// The query of a seed: the sizes rotate with it, then the strategy.
[[nodiscard]] AccuracyQuery accuracyQuery(std::uint64_t seed);

void print(std::ostream& out, const AccuracyQuery& query);

struct AccuracyOutcome
{
    ToiResult result = {};
    Judgement judgement = {};
};

/// Answers the query and judges the answer: False if the full meshes are farther apart than the
/// accuracy, Late if they cross there or if a query of a billionth of that tolerance, by another
/// strategy, meets something before, Missed if only that one does.
[[nodiscard]] AccuracyOutcome runAccuracyQuery(const AccuracyQuery& query);
}  // namespace bullet_ccd::reference
