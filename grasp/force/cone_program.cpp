#include "grasp/force/cone_program.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/singular_values.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace bullet_ccd::grasp
{
namespace
{
constexpr int kMaxIterations = 100;
/// Rows of A that others give up to this, relative to the largest singular value, are left out.
constexpr double kRankTolerance = 1e-10;
/// Part of the way to the nearest wall that a step may go.
constexpr double kStepFraction = 0.99;

/// The equations A x = b in orthogonal combinations that do not depend on each other.
struct ReducedEquations
{
    Eigen::MatrixXd combinations;  ///< p x r, orthonormal columns
    Eigen::MatrixXd A;
    Eigen::VectorXd b;
    Eigen::VectorXd rest;  ///< part of b that no x attains
};

ReducedEquations reduce(const ConeProgram& program)
{
    ReducedEquations result;
    const auto [sigma, U] = singularValues(program.A);
    const auto rank =
        sigma.size() > 0 ? (sigma.array() > kRankTolerance * sigma[0]).count() : Eigen::Index{0};
    result.combinations = U.leftCols(rank);
    result.A = result.combinations.transpose() * program.A;
    result.b = result.combinations.transpose() * program.b;
    result.rest = program.b - result.combinations * result.b;
    return result;
}

struct Direction
{
    Eigen::VectorXd x, y, z;
};

double largest(const Eigen::VectorXd& v)
{
    return v.size() > 0 ? v.lpNorm<Eigen::Infinity>() : 0.0;
}

/// The R of A = Q R; R^T R is A^T A without the loss of half the digits that forming it costs.
Eigen::MatrixXd triangle(const Eigen::MatrixXd& A)
{
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(A);
    return qr.matrixQR().topRows(A.cols()).triangularView<Eigen::Upper>();
}

/// R^-1 R^-T right.
Eigen::VectorXd solveSquared(const Eigen::MatrixXd& R, const Eigen::VectorXd& right)
{
    const auto upper = R.triangularView<Eigen::Upper>();
    return upper.solve(upper.transpose().solve(right));
}

/// [0 A^T G^T; A 0 0; G 0 -W^2], factored: H = G^T W^-2 G and A H^-1 A^T have full rank, as G and
/// the reduced equations do. Near the optimum H is far worse conditioned than W^-1 G is.
class KktSystem
{
public:
    KktSystem(const ReducedEquations& equations,
              const Eigen::MatrixXd& G,
              const NesterovToddScaling& scaling)
        : m_A(equations.A), m_G(G), m_scaling(scaling), m_scaledG(scaling.inverseTimes(G))
    {
        m_hessian = triangle(m_scaledG);
        m_ok = m_hessian.allFinite() && m_hessian.diagonal().cwiseAbs().minCoeff() > 0.0;
        if (m_ok && m_A.rows() > 0)
        {
            m_schur = triangle(
                m_hessian.triangularView<Eigen::Upper>().transpose().solve(m_A.transpose()));
            m_ok = m_schur.allFinite() && m_schur.diagonal().cwiseAbs().minCoeff() > 0.0;
        }
    }

    [[nodiscard]] bool ok() const { return m_ok; }

    /// With one step of iterative refinement.
    [[nodiscard]] Direction solve(const Eigen::VectorXd& x,
                                  const Eigen::VectorXd& y,
                                  const Eigen::VectorXd& z) const
    {
        Direction d = solveOnce(x, y, z);
        const Eigen::VectorXd restX = x - m_A.transpose() * d.y - m_G.transpose() * d.z;
        const Eigen::VectorXd restY = y - m_A * d.x;
        const Eigen::VectorXd restZ = z - m_G * d.x + m_scaling.times(m_scaling.times(d.z));
        const Direction correction = solveOnce(restX, restY, restZ);
        d.x += correction.x;
        d.y += correction.y;
        d.z += correction.z;
        return d;
    }

private:
    [[nodiscard]] Direction solveOnce(const Eigen::VectorXd& x,
                                      const Eigen::VectorXd& y,
                                      const Eigen::VectorXd& z) const
    {
        const Eigen::VectorXd scaledZ = m_scaling.inverseTimes(z);
        const Eigen::VectorXd right = x + m_scaledG.transpose() * scaledZ;
        Direction d;
        d.y = Eigen::VectorXd::Zero(m_A.rows());
        if (m_A.rows() > 0)
        {
            d.y = solveSquared(m_schur, m_A * solveSquared(m_hessian, right) - y);
        }
        d.x = solveSquared(m_hessian, right - m_A.transpose() * d.y);
        d.z = m_scaling.inverseTimes(m_scaledG * d.x - scaledZ);
        return d;
    }

    const Eigen::MatrixXd& m_A;
    const Eigen::MatrixXd& m_G;
    const NesterovToddScaling& m_scaling;
    Eigen::MatrixXd m_scaledG;
    Eigen::MatrixXd m_hessian;  ///< R, H = R^T R
    Eigen::MatrixXd m_schur;    ///< R, A H^-1 A^T = R^T R
    bool m_ok = false;
};

/// The embedding: finds (x, y, z, s, tau, kappa) with
///     A^T y + G^T z + c tau = 0,  A x = b tau,  G x + s = h tau,  c.x + b.y + h.z + kappa = 0.
class Embedding
{
public:
    Embedding(const ConeProgram& program, const ReducedEquations& equations)
        : m_program(program),
          m_equations(equations),
          m_x(Eigen::VectorXd::Zero(program.c.size())),
          m_y(Eigen::VectorXd::Zero(equations.b.size())),
          m_z(program.cones.identity()),
          m_s(m_z)
    {
        measure();
    }

    ConeSolution run()
    {
        ConeSolution best;
        double bestError = std::numeric_limits<double>::infinity();
        for (int iteration = 0; iteration <= kMaxIterations; ++iteration)
        {
            const Verdict verdict = judge();
            // Rounding lets the error grow again after it has been least.
            if (verdict.error < bestError)
            {
                best = solutionFor(verdict.status);
                best.residual = verdict.residual;
                best.iterations = iteration;
                bestError = verdict.error;
            }
            if (bestError <= kConeAccuracy || !step())
            {
                break;
            }
        }
        if (bestError > kConeAccuracyAtLeast)
        {
            best.status = ConeStatus::Undecided;
        }
        return best;
    }

private:
    /// The claim that the iterate comes closest to proving, and what it lacks: the largest relative
    /// error, that of the equations alone in `residual`.
    struct Verdict
    {
        ConeStatus status = ConeStatus::Undecided;
        double error = std::numeric_limits<double>::infinity();
        double residual = 0.0;
    };

    void measure()
    {
        m_restX = m_equations.A.transpose() * m_y + m_program.G.transpose() * m_z;
        m_restY = m_equations.A * m_x;
        m_restZ = m_s + m_program.G * m_x;
        m_cx = m_program.c.dot(m_x);
        m_byhz = m_equations.b.dot(m_y) + m_program.h.dot(m_z);
    }

    [[nodiscard]] Verdict judge() const
    {
        const double sizeB = std::max({1.0, largest(m_equations.b), largest(m_program.h)});
        const double sizeC = std::max(1.0, largest(m_program.c));
        const double primal = std::max(largest(m_restY - m_equations.b * m_tau),
                                       largest(m_restZ - m_program.h * m_tau)) /
                              (m_tau * sizeB);
        const double dual = largest(m_restX + m_program.c * m_tau) / (m_tau * sizeC);
        const double gap =
            std::abs(m_cx + m_byhz) / std::max({m_tau, std::abs(m_cx), std::abs(m_byhz)});
        Verdict verdict{.status = ConeStatus::Optimal,
                        .error = std::max({primal, dual, gap}),
                        .residual = std::max(primal, dual)};
        consider(ConeStatus::Infeasible, largest(m_restX), -m_byhz, verdict);
        consider(
            ConeStatus::Unbounded, std::max(largest(m_restY), largest(m_restZ)), -m_cx, verdict);
        return verdict;
    }

    /// A ray proves by `strength` > 0 where its equations hold up to `rest`.
    static void consider(ConeStatus status, double rest, double strength, Verdict& verdict)
    {
        if (strength > 0.0 && rest / strength < verdict.error)
        {
            verdict = {.status = status, .error = rest / strength, .residual = rest / strength};
        }
    }

    [[nodiscard]] ConeSolution solutionFor(ConeStatus status) const
    {
        const double scale = status == ConeStatus::Infeasible  ? -m_byhz
                             : status == ConeStatus::Unbounded ? -m_cx
                                                               : m_tau;
        return {.status = status,
                .x = m_x / scale,
                .y = m_equations.combinations * m_y / scale,
                .z = m_z / scale,
                .value = m_cx / scale,
                .bound = -m_byhz / scale};
    }

    /// What one right-hand side of the Newton system leads to.
    struct Move
    {
        Direction d;
        Eigen::VectorXd scaledS, scaledZ;  ///< W^-1 ds, W dz
        double tau = 0.0;
        double kappa = 0.0;
    };

    /// Newton's direction for residuals times -(1 - centring) and complementarity rights ds, dk.
    [[nodiscard]] Move newton(const KktSystem& kkt,
                              const NesterovToddScaling& scaling,
                              const Direction& constant,
                              double centring,
                              const Eigen::VectorXd& lambda,
                              const Eigen::VectorXd& ds,
                              double dk) const
    {
        const double part = 1.0 - centring;
        const Eigen::VectorXd quotient = m_program.cones.divide(lambda, ds);
        Move move;
        move.d = kkt.solve(-part * (m_restX + m_program.c * m_tau),
                           -part * (m_restY - m_equations.b * m_tau),
                           -part * (m_restZ - m_program.h * m_tau) - scaling.times(quotient));
        const double right = -part * (m_cx + m_byhz + m_kappa) - dk / m_tau;
        move.tau = (right - product(move.d)) / (product(constant) - m_kappa / m_tau);
        move.d.x += move.tau * constant.x;
        move.d.y += move.tau * constant.y;
        move.d.z += move.tau * constant.z;
        move.kappa = (dk - m_kappa * move.tau) / m_tau;
        move.scaledZ = scaling.times(move.d.z);
        move.scaledS = quotient - move.scaledZ;
        return move;
    }

    [[nodiscard]] double product(const Direction& d) const
    {
        return m_program.c.dot(d.x) + m_equations.b.dot(d.y) + m_program.h.dot(d.z);
    }

    [[nodiscard]] double longestStep(const Eigen::VectorXd& lambda, const Move& move) const
    {
        return std::min({m_program.cones.longestStep(lambda, move.scaledS),
                         m_program.cones.longestStep(lambda, move.scaledZ),
                         move.tau < 0.0 ? -m_tau / move.tau : 1e9,
                         move.kappa < 0.0 ? -m_kappa / move.kappa : 1e9});
    }

    /// Predictor and corrector; false where rounding leaves no step.
    bool step()
    {
        const ConeProduct& cones = m_program.cones;
        if (!(cones.depth(m_s) > 0.0) || !(cones.depth(m_z) > 0.0))
        {
            return false;
        }
        const NesterovToddScaling scaling(cones, m_s, m_z);
        const KktSystem kkt(m_equations, m_program.G, scaling);
        if (!kkt.ok())
        {
            return false;
        }
        const Eigen::VectorXd lambda = scaling.times(m_z);
        const Eigen::VectorXd squared = cones.jordan(lambda, lambda);
        const double mu =
            (lambda.squaredNorm() + m_tau * m_kappa) / static_cast<double>(cones.degree() + 1);
        const Direction constant = kkt.solve(-m_program.c, m_equations.b, m_program.h);

        const Move predicted =
            newton(kkt, scaling, constant, 0.0, lambda, -squared, -m_kappa * m_tau);
        const double reach = std::min(1.0, longestStep(lambda, predicted));
        const double centring = std::pow(1.0 - reach, 3);
        const Eigen::VectorXd ds = -squared - cones.jordan(predicted.scaledS, predicted.scaledZ) +
                                   centring * mu * cones.identity();
        const double dk = -m_kappa * m_tau - predicted.kappa * predicted.tau + centring * mu;
        const Move move = newton(kkt, scaling, constant, centring, lambda, ds, dk);
        return advance(scaling, move, std::min(1.0, kStepFraction * longestStep(lambda, move)));
    }

    bool advance(const NesterovToddScaling& scaling, const Move& move, double length)
    {
        constexpr double kShortestStep = 1e-8;
        if (!(length > kShortestStep) || !move.d.x.allFinite())
        {
            return false;
        }
        m_x += length * move.d.x;
        m_y += length * move.d.y;
        m_z += length * move.d.z;
        m_s += length * scaling.times(move.scaledS);
        m_tau += length * move.tau;
        m_kappa += length * move.kappa;
        // The embedding is homogeneous: keep its numbers about 1 in size.
        const double shrink = 1.0 / std::max(m_tau, m_kappa);
        for (Eigen::VectorXd* v : {&m_x, &m_y, &m_z, &m_s})
        {
            *v *= shrink;
        }
        m_tau *= shrink;
        m_kappa *= shrink;
        measure();
        return true;
    }

    const ConeProgram& m_program;
    const ReducedEquations& m_equations;
    Eigen::VectorXd m_x, m_y, m_z, m_s;
    double m_tau = 1.0;
    double m_kappa = 1.0;
    Eigen::VectorXd m_restX, m_restY, m_restZ;  ///< A^T y + G^T z, A x, G x + s
    double m_cx = 0.0;
    double m_byhz = 0.0;
};

/// Equations that contradict each other: y along the part of b that no x attains.
std::optional<ConeSolution> contradiction(const ConeProgram& program,
                                          const ReducedEquations& equations)
{
    if (equations.rest.norm() <= kConeAccuracy * std::max(1.0, program.b.norm()))
    {
        return std::nullopt;
    }
    ConeSolution solution;
    solution.status = ConeStatus::Infeasible;
    solution.y = -equations.rest / equations.rest.squaredNorm();
    solution.z = Eigen::VectorXd::Zero(program.h.size());
    solution.residual = largest(program.A.transpose() * solution.y);
    return solution;
}
}  // namespace

ConeSolution solve(const ConeProgram& program)
{
    BULLET_CCD_ASSERT(program.A.cols() == program.c.size() && program.G.cols() == program.c.size());
    BULLET_CCD_ASSERT(program.A.rows() == program.b.size() && program.G.rows() == program.h.size());
    BULLET_CCD_ASSERT(program.cones.dimension() == program.h.size());
    const ReducedEquations equations = reduce(program);
    if (const std::optional<ConeSolution> answer = contradiction(program, equations))
    {
        return *answer;
    }
    return Embedding(program, equations).run();
}
}  // namespace bullet_ccd::grasp
