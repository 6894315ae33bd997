#include "benchmarks/rigid/rigid_check.h"

#include "bullet_ccd/distance/tree_distance.h"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

namespace bullet_ccd::benchmarks
{
namespace
{
/// Times in the references have 12 digits.
constexpr double kTimeRounding = 1e-11;
/// Of distances, relative to the size of coordinates (about 300).
constexpr double kDistanceRounding = 1e-11 * 300.0;
constexpr double kNever = std::numeric_limits<double>::infinity();

/// One query and all that is known of it.
struct Case
{
    const RigidSet& set;
    std::size_t index;
    const ToiResult& answer;
    double tolerance;
    const Judges& judges;

    [[nodiscard]] const RigidQuery& query() const { return set.queries[index]; }
    [[nodiscard]] const RigidReference* reference() const
    {
        return set.references.empty() ? nullptr : &set.references[index];
    }
    [[nodiscard]] bool hasPeer() const { return judges.modelA != nullptr; }
    [[nodiscard]] FclBody bodyA() const { return {*judges.modelA, query().motionA}; }
    [[nodiscard]] FclBody bodyB() const { return {*judges.modelB, query().motionB}; }
    [[nodiscard]] double distance(double t) const
    {
        if (hasPeer())
        {
            return fclDistance(bodyA(), bodyB(), t);
        }
        const Eigen::Isometry3d X_BA =
            query().motionB.at(t).X_W.inverse() * query().motionA.at(t).X_W;
        return treeDistance(judges.treeA, judges.treeB, X_BA, kNever).distance;
    }
    [[nodiscard]] double slack() const
    {
        const RigidReference* known = reference();
        return known == nullptr || set.vertexRounding == 0.0
                   ? kTimeRounding
                   : kTimeRounding + set.vertexRounding / known->speedBound;
    }
};

void complain(CheckResult& result, int& count, const Case& c, const std::string& what)
{
    ++count;
    result.complaints.push_back(fmt::format("{} query {}: {}", c.set.name, c.query().id, what));
}

void checkAgainstReference(const Case& c, bool contact, CheckResult& result)
{
    const RigidReference& known = *c.reference();
    if (!known.hit)
    {
        return;  // the distance at a contact says whether it is one
    }
    ++result.hits;
    if (!contact)
    {
        complain(
            result, result.missed, c, fmt::format("missed the contact at {:.12g}", known.time));
        return;
    }
    const double error = known.time - c.answer.time;
    result.errors.push_back(error);
    if (error < -c.slack())
    {
        complain(result, result.late, c, fmt::format("late by {:.3g} of the motion", -error));
    }
    // The reference's own step within 1e-4: only comparable at that tolerance or a smaller one.
    if (c.tolerance <= 1e-4 && known.timeAtTolerance >= 0.0 &&
        c.answer.time < known.timeAtTolerance - c.slack())
    {
        complain(result,
                 result.early,
                 c,
                 fmt::format("{:.3g} of the motion before the reference was within 1e-4 (error "
                             "{:.3g}, gap {:.4g})",
                             known.timeAtTolerance - c.answer.time,
                             error,
                             c.answer.gap));
    }
}

void checkAgainstSampling(const Case& c, bool contact, CheckResult& result)
{
    const FclAnswer& sampled = c.judges.naive[c.index];
    if (!contact)
    {
        result.hits += sampled.hit ? 1 : 0;
        if (sampled.hit)
        {
            complain(result,
                     result.missed,
                     c,
                     fmt::format("missed: surfaces intersect at {:.6g}", sampled.time));
        }
        return;
    }
    if (sampled.hit && c.answer.time > sampled.time)
    {
        ++result.hits;
        complain(result,
                 result.late,
                 c,
                 fmt::format("late: surfaces intersect at {:.6g}", sampled.time));
        return;
    }
    const std::optional<double> first =
        firstOverlap(c.bodyA(), c.bodyB(), c.answer.time, sampled.hit ? sampled.time : 1.0);
    if (first)
    {
        ++result.hits;
        result.errors.push_back(*first - c.answer.time);
    }
}

/// The gap of a contact by the exact distance: more than 0, at most the tolerance.
void checkContactGap(const Case& c, CheckResult& result)
{
    const double gap = c.distance(c.answer.time);
    if (gap <= 0.0)
    {
        complain(result,
                 result.late,
                 c,
                 fmt::format("intersects at the reported time {}", c.answer.time));
    }
    else if (gap > c.tolerance + kDistanceRounding)
    {
        complain(result, result.falseHits, c, fmt::format("hit at a distance of {:.6g}", gap));
    }
    else if (std::abs(gap - c.answer.gap) > kDistanceRounding ||
             std::abs((c.answer.pointB - c.answer.pointA).norm() - c.answer.gap) >
                 kDistanceRounding)
    {
        complain(result,
                 result.badGaps,
                 c,
                 fmt::format("distance {:.9g}, reported gap {:.9g}, witnesses {:.9g} apart",
                             gap,
                             c.answer.gap,
                             (c.answer.pointB - c.answer.pointA).norm()));
    }
}

/// The certified clearance of a separated answer may not exceed the distance at any time.
void checkClearance(const Case& c, CheckResult& result)
{
    for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0})
    {
        const double distance = c.distance(t);
        if (c.answer.gap > distance + kDistanceRounding)
        {
            complain(
                result,
                result.badGaps,
                c,
                fmt::format("clearance {:.6g} promised, {:.6g} at {}", c.answer.gap, distance, t));
            return;
        }
    }
}
}  // namespace

CheckResult checkAnswers(const RigidSet& set,
                         std::span<const ToiResult> answers,
                         double tolerance,
                         const Judges& judges)
{
    CheckResult result;
    for (std::size_t i = 0; i < answers.size(); ++i)
    {
        const Case c{set, i, answers[i], tolerance, judges};
        const bool contact = isContact(c.answer.status);
        if (c.answer.status == ToiStatus::IterationLimit)
        {
            complain(result, result.gaveUp, c, "gave up");
            continue;
        }
        if (c.reference() != nullptr)
        {
            checkAgainstReference(c, contact, result);
        }
        else if (c.hasPeer())
        {
            checkAgainstSampling(c, contact, result);
        }
        contact ? checkContactGap(c, result) : checkClearance(c, result);
    }
    return result;
}
}  // namespace bullet_ccd::benchmarks
