#include "benchmarks/reference/oracles/toi_certificate.h"

#include "benchmarks/reference/oracles/brute_force_distance.h"
#include "benchmarks/reference/oracles/closest_features.h"
#include "benchmarks/reference/oracles/wide_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

namespace bullet_ccd::reference
{
namespace
{
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t kEvaluations = 400'000;
constexpr double kShortest = 1e-14;
/// Halvings after which it is worth asking whether a pair touches.
constexpr std::size_t kShort = 10;
/// Relative rounding of gaps computed in long double, generously.
constexpr Real kWideRounding = 1e-17L;

std::array<Vector3d, 3> narrowed(const WideCorners& wide)
{
    return {wide[0].cast<double>(), wide[1].cast<double>(), wide[2].cast<double>()};
}

using PairOfPieces = std::pair<std::int32_t, std::int32_t>;

class Certifier
{
public:
    Certifier(const RigidScene& scene, double separation)
        : m_a(scene.meshA, scene.motionA),
          m_b(scene.meshB, scene.motionB),
          m_separation(separation),
          m_slide((scene.motionA.v_W - scene.motionB.v_W).norm() * (1.0 + 1e-14))
    {
    }

    /// Exact, crossings included.
    [[nodiscard]] InstantDistance exactAt(double t)
    {
        return closestAt(t,
                         [&](std::size_t i, std::size_t j)
                         {
                             const OracleDistance exact =
                                 bruteForceTriangleDistance(m_a.corners(i), m_b.corners(j));
                             return InstantDistance{exact.distance, exact.pointA, exact.pointB};
                         });
    }

    /// The same where it is known that nothing crosses, faster.
    [[nodiscard]] InstantDistance apartAt(double t)
    {
        return closestAt(
            t,
            [&](std::size_t i, std::size_t j)
            { return closestFeatures(narrowed(m_a.corners(i)), narrowed(m_b.corners(j))); });
    }

    /// Right if the bodies are proved to be farther apart than the separation in all of [0, end];
    /// Late with a counterexample; else undecided.
    [[nodiscard]] Judgement prove(double end)
    {
        std::vector<PairOfPieces> all;
        for (std::size_t i = 0; i < m_a.size(); ++i)
        {
            for (std::size_t j = 0; j < m_b.size(); ++j)
            {
                all.emplace_back(i, j);
            }
        }
        Judgement judgement;
        m_levels.resize(64);
        m_levels[0] = std::move(all);
        proveInterval(0.0, end, 0, judgement);
        return judgement;
    }

    /// Smallest distance met on the way: an upper bound of the distance over the motion.
    [[nodiscard]] double smallest() const { return m_smallest; }
    [[nodiscard]] std::int64_t evaluations() const { return m_evaluations; }

private:
    template <typename OfPair>
    [[nodiscard]] InstantDistance closestAt(double t, const OfPair& ofPair)
    {
        moveTo(t);
        InstantDistance best{.distance = kInfinity};
        for (std::size_t i = 0; i < m_a.size() && best.distance > 0.0; ++i)
        {
            for (std::size_t j = 0; j < m_b.size() && best.distance > 0.0; ++j)
            {
                const double apart = (m_a.center(i) - m_b.center(j)).norm() * (1.0 - 1e-14);
                if (apart - m_a.piece(i).ball.radius - m_b.piece(j).ball.radius > best.distance)
                {
                    continue;
                }
                ++m_evaluations;
                const InstantDistance here = ofPair(i, j);
                best = here.distance < best.distance ? here : best;
            }
        }
        m_smallest = std::min(m_smallest, best.distance);
        best.pointA += m_origin.cast<double>();
        best.pointB += m_origin.cast<double>();
        return best;
    }

    void moveTo(double t)
    {
        m_a.moveTo(t);
        m_b.moveTo(t);
        m_origin = m_b.at(m_b.ball().center);
        m_a.setOrigin(m_origin);
        m_b.setOrigin(m_origin);
    }

    /// Largest fall of the distance of two ball centres within h of the instant: their relative
    /// velocity now and what rotation does to it; no point leaves its circle.
    [[nodiscard]] double fallOfBalls(const Ball& a,
                                     const Ball& b,
                                     const Vector3d& rate,
                                     const Vector3d& across,
                                     double apart,
                                     double h) const
    {
        const double spinA = m_a.spin();
        const double spinB = m_b.spin();
        const double bend = spinA * spinA * a.center.reach + spinB * spinB * b.center.reach;
        const double second = std::abs(rate.dot(across)) / apart * h + 0.5 * bend * h * h;
        const double circles = 2.0 * (a.center.reach + b.center.reach);
        return std::min(second, m_slide * h + circles);
    }

    [[nodiscard]] bool ballsApart(const Ball& a,
                                  const Ball& b,
                                  const Vector3d& centerA,
                                  const Vector3d& centerB,
                                  const Vector3d& rate,
                                  double h) const
    {
        const Vector3d across = centerB - centerA;
        const double apart = across.norm();
        const double gap = apart * (1.0 - 1e-14) - a.radius - b.radius - m_separation -
                           1e-15 * (centerA.norm() + centerB.norm());
        return gap > 0.0 && gap > fallOfBalls(a, b, rate, across, apart, h) * (1.0 + 1e-12);
    }

    /// The proof for one pair of triangles, in long double, along a direction that is only a guess.
    [[nodiscard]] bool apartAlong(const Wide& guess,
                                  const WideCorners& a,
                                  const WideCorners& b,
                                  const PairOfPieces& pair,
                                  double h) const
    {
        const Wide n = guess.normalized();
        const Piece& pieceA = m_a.piece(static_cast<std::size_t>(pair.first));
        const Piece& pieceB = m_b.piece(static_cast<std::size_t>(pair.second));
        const double spinA = m_a.spin() * m_a.spin();
        const double spinB = m_b.spin() * m_b.spin();
        std::array<Real, 3> rateB;
        for (std::size_t j = 0; j < 3; ++j)
        {
            rateB[j] = n.dot(m_b.rate(pieceB.corners[j]));
        }
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Real rateA = n.dot(m_a.rate(pieceA.corners[i]));
            for (std::size_t j = 0; j < 3; ++j)
            {
                const Real gap = n.dot(b[j] - a[i]) - m_separation -
                                 kWideRounding * (a[i].cwiseAbs().sum() + b[j].cwiseAbs().sum());
                const Real bend = spinA * pieceA.corners[i].reach + spinB * pieceB.corners[j].reach;
                const Real fall = std::abs(rateB[j] - rateA) * h + bend * h * h / 2;
                if (!(gap > fall * (1 + 1e-15L)))
                {
                    return false;
                }
            }
        }
        return true;
    }

    enum class PairState : std::uint8_t
    {
        Proved,
        Open,
        Touching
    };

    [[nodiscard]] PairState examine(const PairOfPieces& pair, double h, bool isShort)
    {
        const auto i = static_cast<std::size_t>(pair.first);
        const auto j = static_cast<std::size_t>(pair.second);
        if (ballsApart(m_a.piece(i).ball,
                       m_b.piece(j).ball,
                       m_a.center(i),
                       m_b.center(j),
                       m_a.centerRate(i) - m_b.centerRate(j),
                       h))
        {
            return PairState::Proved;
        }
        const double bend = m_a.spin() * m_a.spin() * m_a.piece(i).ball.center.reach +
                            m_b.spin() * m_b.spin() * m_b.piece(j).ball.center.reach;
        if (0.5 * bend * h * h > (m_a.center(i) - m_b.center(j)).norm())
        {
            return PairState::Open;  // centroids are in the triangles: no proof can succeed
        }
        ++m_evaluations;
        const WideCorners a = m_a.corners(i);
        const WideCorners b = m_b.corners(j);
        const InstantDistance near = closestFeatures(narrowed(a), narrowed(b));
        m_smallest = std::min(m_smallest, near.distance);
        const double size = m_a.piece(i).ball.radius + m_b.piece(j).ball.radius;
        const Wide across = (near.pointB - near.pointA).cast<Real>();
        if (near.distance > 1e-13 * size && apartAlong(across, a, b, pair, h))
        {
            return PairState::Proved;
        }
        // The direction of a gap is only known to rounding / gap.
        if ((isShort || near.distance < 1e-5 * size) && apartAlongFeatures(across, a, b, pair, h))
        {
            return PairState::Proved;
        }
        return isShort || near.distance <= 1e-13 * size ? confirm(pair, a, b, near, h)
                                                        : PairState::Open;
    }

    /// The directions that features determine, exact however small the gap: normals of faces,
    /// common normals of edges, and the guess made perpendicular to an edge.
    [[nodiscard]] bool apartAlongFeatures(const Wide& guess,
                                          const WideCorners& a,
                                          const WideCorners& b,
                                          const PairOfPieces& pair,
                                          double h) const
    {
        const std::array<Wide, 3> edgesA{a[1] - a[0], a[2] - a[1], a[0] - a[2]};
        const std::array<Wide, 3> edgesB{b[1] - b[0], b[2] - b[1], b[0] - b[2]};
        const auto proves = [&](const Wide& n) {
            return n.squaredNorm() > 0 &&
                   (apartAlong(n, a, b, pair, h) || apartAlong(-n, a, b, pair, h));
        };
        const auto perpendicular = [&](const Wide& edge)
        {
            const Real length = edge.squaredNorm();
            return length > 0 ? Wide(guess - guess.dot(edge) / length * edge) : guess;
        };
        bool done = proves(edgesA[0].cross(edgesA[1])) || proves(edgesB[0].cross(edgesB[1]));
        for (std::size_t i = 0; i < 3 && !done; ++i)
        {
            done = proves(perpendicular(edgesA[i])) || proves(perpendicular(edgesB[i]));
            for (std::size_t j = 0; j < 3 && !done; ++j)
            {
                done = proves(edgesA[i].cross(edgesB[j]));
            }
        }
        return done;
    }

    /// A pair that could not be proved apart: does it touch right now?
    [[nodiscard]] PairState confirm(const PairOfPieces& pair,
                                    const WideCorners& a,
                                    const WideCorners& b,
                                    const InstantDistance& near,
                                    double h)
    {
        const OracleDistance exact = bruteForceTriangleDistance(a, b);
        m_smallest = std::min(m_smallest, exact.distance);
        if (exact.distance <= m_separation)
        {
            return PairState::Touching;
        }
        const Wide across = (exact.pointB - exact.pointA).cast<Real>();
        const bool other = across.norm() > 0.0 && exact.distance < 0.999 * near.distance;
        return other && apartAlong(across, a, b, pair, h) ? PairState::Proved : PairState::Open;
    }

    /// Returns false to stop.
    bool proveInterval(double from, double to, std::size_t level, Judgement& judgement)
    {
        const double m = 0.5 * (from + to);
        const double h = std::max(to - m, m - from);
        moveTo(m);
        const Vector3d bodyRate =
            (m_a.rate(m_a.ball().center) - m_b.rate(m_b.ball().center)).cast<double>();
        const Vector3d centerA = (m_a.at(m_a.ball().center) - m_origin).cast<double>();
        if (ballsApart(m_a.ball(), m_b.ball(), centerA, Vector3d::Zero(), bodyRate, h))
        {
            return true;
        }
        std::vector<PairOfPieces>& open = m_levels[level + 1];
        open.clear();
        for (const PairOfPieces& pair : m_levels[level])
        {
            const PairState state = examine(pair, h, level >= kShort);
            if (state == PairState::Touching)
            {
                judgement = {.verdict = Verdict::Late, .time = m, .distance = 0.0};
                return false;
            }
            if (state == PairState::Open)
            {
                open.push_back(pair);
            }
        }
        if (open.empty())
        {
            return true;
        }
        if (m_evaluations > kEvaluations || h < kShortest || level + 2 >= m_levels.size())
        {
            judgement = {.verdict = Verdict::Undecided, .time = m, .distance = m_smallest};
            return false;
        }
        return proveInterval(from, m, level + 1, judgement) &&
               proveInterval(m, to, level + 1, judgement);
    }

    Body m_a;
    Body m_b;
    double m_separation;
    double m_slide;
    Wide m_origin = Wide::Zero();
    double m_smallest = kInfinity;
    std::int64_t m_evaluations = 0;
    std::vector<std::vector<PairOfPieces>> m_levels;
};

bool isFree(ToiStatus status)
{
    return status == ToiStatus::Separated || status == ToiStatus::TouchingLeaving;
}

Judgement wrong(Verdict verdict, double time, double distance)
{
    return {.verdict = verdict, .time = time, .distance = distance};
}

/// What is left to say once the bodies are known to be apart up to the reported time, with their
/// distances there and at the start.
Judgement judgeApart(const ToiOptions& options,
                     const ToiResult& result,
                     double rounding,
                     double start,
                     double smallest,
                     double distance)
{
    const double contact = options.minimumSeparation + options.tolerance;
    const bool touching =
        result.status == ToiStatus::TouchingLeaving || result.status == ToiStatus::TouchingPressing;
    // Whoever starts within the tolerance, leaves and comes back may be said to hit.
    if ((touching && start > contact + rounding) ||
        (result.status == ToiStatus::Separated && start < contact - rounding))
    {
        return wrong(Verdict::WrongStatus, 0.0, start);
    }
    if (isFree(result.status))
    {
        return result.time != 1.0 || result.gap > smallest + rounding
                   ? wrong(Verdict::WrongGap, result.time, smallest)
                   : Judgement{};
    }
    if (distance > contact + rounding)
    {
        return wrong(Verdict::False, result.time, distance);
    }
    // The named triangles need not be the closest, but others are closer by the aim at most.
    const double nearest = options.minimumSeparation +
                           (options.anyWithin ? 1.0 : 2.0 * options.aim) * options.tolerance;
    const bool honest = result.gap > 0.0 && result.gap <= contact &&
                        result.gap >= distance - rounding &&
                        result.gap <= std::max(distance, nearest) + rounding;
    return honest ? Judgement{} : wrong(Verdict::WrongGap, result.time, distance);
}

/// Giving up is right where a limit below the usual one asked for it.
Judgement giveUp(const ToiOptions& options, const ToiResult& result)
{
    const bool wasAsked = options.maxIterations < ToiOptions{}.maxIterations;
    return wasAsked ? Judgement{} : wrong(Verdict::GaveUp, result.time, 0.0);
}

Judgement judge(Certifier& certifier,
                const ToiOptions& options,
                const ToiResult& result,
                double rounding)
{
    const double separation = options.minimumSeparation;
    if (result.status == ToiStatus::Overlapping)
    {
        const double start = certifier.exactAt(0.0).distance;
        const bool right = result.time == 0.0 && start <= separation + rounding;
        return right ? Judgement{} : wrong(Verdict::WrongStatus, 0.0, start);
    }
    const bool free = isFree(result.status);
    if (!(result.time >= 0.0 && result.time <= 1.0))
    {
        return wrong(Verdict::WrongStatus, result.time, 0.0);
    }
    if (result.status == ToiStatus::IterationLimit && result.time == 0.0)
    {
        return giveUp(options, result);  // nothing is claimed
    }
    const double end = free ? 1.0 : result.time;
    Judgement proof = certifier.prove(end);
    if (proof.verdict == Verdict::Undecided)
    {
        for (const double t : {0.0, end})
        {
            const double distance = certifier.exactAt(t).distance;
            if (distance <= separation)
            {
                proof = wrong(Verdict::Late, t, distance);
                break;
            }
        }
    }
    if (proof.verdict != Verdict::Right)
    {
        proof.verdict = free && proof.verdict == Verdict::Late ? Verdict::Missed : proof.verdict;
        return proof;
    }
    if (result.status == ToiStatus::IterationLimit)
    {
        return giveUp(options, result);
    }
    const double start = certifier.apartAt(0.0).distance;
    const double last = certifier.apartAt(end).distance;
    const Judgement judgement =
        judgeApart(options, result, rounding, start, certifier.smallest(), last);
    if (judgement.verdict == Verdict::Right)
    {
        return judgement;
    }
    // Double precision is good enough to acquit, not to convict.
    const double exactStart = certifier.exactAt(0.0).distance;
    const double exactLast = certifier.exactAt(end).distance;
    return judgeApart(options, result, rounding, exactStart, certifier.smallest(), exactLast);
}
}  // namespace

const char* nameOf(Verdict verdict)
{
    switch (verdict)
    {
        case Verdict::Right:
            return "right";
        case Verdict::Late:
            return "late";
        case Verdict::Missed:
            return "missed";
        case Verdict::False:
            return "false contact";
        case Verdict::WrongGap:
            return "wrong gap";
        case Verdict::WrongStatus:
            return "wrong status";
        case Verdict::GaveUp:
            return "gave up";
        case Verdict::Undecided:
            return "undecided";
    }
    return "unknown";
}

std::string Judgement::text() const
{
    std::ostringstream text;
    text.precision(17);
    text << nameOf(verdict) << " (" << pair << (pair.empty() ? "" : ": ") << "distance " << distance
         << " at time " << time << ", " << evaluations << " evaluations)";
    return text.str();
}

InstantDistance instantDistance(const RigidScene& scene, double t)
{
    return Certifier(scene, 0.0).exactAt(t);
}

InstantDistance featureDistance(const RigidScene& scene, double t)
{
    return Certifier(scene, 0.0).apartAt(t);
}

double distanceRounding(const RigidScene& scene)
{
    const auto extent = [](const TriangleMesh& mesh, const RigidMotion& motion)
    {
        double radius = 0.0;
        for (const Vector3d& v : mesh.vertices)
        {
            radius = std::max(radius, v.norm());
        }
        const double reference = motion.reference_B.norm();
        return radius + 2.0 * reference + motion.X_W0.translation().norm() + motion.v_W.norm() +
               std::min(1.0, motion.w_W.norm()) * (radius + reference);
    };
    return 512.0 * 1.2e-16 *
           (extent(scene.meshA, scene.motionA) + extent(scene.meshB, scene.motionB));
}

Judgement judgeToi(const RigidScene& scene, const ToiOptions& options, const ToiResult& result)
{
    Certifier certifier(scene, options.minimumSeparation);
    Judgement judgement = judge(certifier, options, result, distanceRounding(scene));
    judgement.evaluations = certifier.evaluations();
    return judgement;
}
}  // namespace bullet_ccd::reference
