#include "grasp/sim/contact_program.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kFirstWeight = 0.03;  // relative to the diagonal
constexpr int kFirstPatience = 10;     // iterations before the weight may change ..
constexpr double kUnbalanced = 5.0;    // .. where one residual is that much above the other
constexpr double kWeightFactor = 3.0;

/// The point of the cone |(y, z)| <= mu x that is nearest to the contact's impulse.
void projectOnCone(Eigen::Ref<Eigen::Vector3d> impulse, double mu)
{
    const double sideways = std::hypot(impulse[1], impulse[2]);
    if (sideways <= mu * impulse[0])
    {
        return;
    }
    if (mu * sideways <= -impulse[0])
    {
        impulse.setZero();
        return;
    }
    const double normal = (impulse[0] + mu * sideways) / (1.0 + mu * mu);
    impulse.tail<2>() *= mu * normal / sideways;
    impulse[0] = normal;
}

void project(const ContactProgram& program, Eigen::VectorXd& x)
{
    const Eigen::Index bounded = program.lower.size();
    x.head(bounded) = x.head(bounded).cwiseMax(program.lower).cwiseMin(program.upper);
    for (std::size_t k = 0; k < program.friction.size(); ++k)
    {
        const Eigen::Index row = bounded + 3 * static_cast<Eigen::Index>(k);
        projectOnCone(x.segment<3>(row), program.friction[k]);
    }
}

/// Gauss-Seidel: what Bullet's own sweeps do, on the matrix, from nothing.
void sweep(const ContactProgram& program, Eigen::VectorXd& x, const ContactProgramOptions& options)
{
    const Eigen::MatrixXd& A = program.A;
    const Eigen::Index bounded = program.lower.size();
    x.setZero();
    Eigen::VectorXd lacking = program.b;
    double moved = 0.0;
    const auto set = [&](Eigen::Index row, double value)
    {
        const double change = value - x[row];
        x[row] = value;
        lacking -= change * A.col(row);
        moved = std::max(moved, std::abs(change) * A(row, row));
    };
    for (int round = 0; round < options.maxIterations; ++round)
    {
        moved = 0.0;
        for (Eigen::Index i = 0; i < bounded; ++i)
        {
            set(i, std::clamp(x[i] + lacking[i] / A(i, i), program.lower[i], program.upper[i]));
        }
        for (std::size_t k = 0; k < program.friction.size(); ++k)
        {
            const Eigen::Index i = bounded + 3 * static_cast<Eigen::Index>(k);
            set(i, std::max(0.0, x[i] + lacking[i] / A(i, i)));
            const double step = 1.0 / std::max(A(i + 1, i + 1), A(i + 2, i + 2));
            const Eigen::Vector2d tangent = x.segment<2>(i + 1) + step * lacking.segment<2>(i + 1);
            const double limit = program.friction[k] * x[i];
            const double scale = tangent.norm() > limit ? limit / tangent.norm() : 1.0;
            set(i + 1, scale * tangent[0]);
            set(i + 2, scale * tangent[1]);
        }
        if (moved < options.accuracy)
        {
            return;
        }
    }
}
}  // namespace

ContactProgramSolver::ContactProgramSolver() : m_weight(kFirstWeight) {}

int ContactProgramSolver::solve(const ContactProgram& program,
                                Eigen::VectorXd& x,
                                const ContactProgramOptions& options)
{
    int iterations = 0;
    if (!alternate(program, x, options, iterations))
    {
        // What it has come to is no solution, and what it has learned is wrong.
        m_weight = kFirstWeight;
        ++m_failures;
        sweep(program, x, options);
    }
    return iterations;
}

bool ContactProgramSolver::alternate(const ContactProgram& program,
                                     Eigen::VectorXd& x,
                                     const ContactProgramOptions& options,
                                     int& iterations)
{
    const Eigen::MatrixXd& A = program.A;
    const Eigen::Index bounded = program.lower.size();
    const Eigen::Index n = A.rows();
    // One scale for the rows of a contact, so that its cone stays round.
    Eigen::VectorXd scale = A.diagonal();
    for (Eigen::Index i = bounded; i < n; i += 3)
    {
        scale.segment<3>(i).setConstant(scale.segment<3>(i).mean());
    }
    Eigen::VectorXd weights;
    Eigen::LLT<Eigen::MatrixXd> factor;
    const auto factorise = [&]
    {
        weights = m_weight * scale;
        Eigen::MatrixXd K = A;
        K.diagonal() += weights;
        factor.compute(K);
    };
    factorise();

    Eigen::VectorXd z = x;                  // within bounds and cones
    Eigen::VectorXd v = A * x - program.b;  // the velocities that the constraints leave
    Eigen::VectorXd shift = Eigen::VectorXd::Zero(n);
    int patience = kFirstPatience;  // grows, so that the weight settles
    int sinceChange = 0;
    for (iterations = 0; iterations < options.maxIterations; ++iterations)
    {
        for (std::size_t k = 0; k < program.friction.size(); ++k)
        {
            const Eigen::Index i = bounded + 3 * static_cast<Eigen::Index>(k);
            shift[i] = program.friction[k] * std::hypot(v[i + 1], v[i + 2]);
        }
        x = factor.solve(Eigen::VectorXd(program.b - shift + weights.cwiseProduct(z) + v));
        const Eigen::VectorXd before = z;
        z = x - v.cwiseQuotient(weights);
        project(program, z);
        v -= weights.cwiseProduct(x - z);
        const double primal = scale.cwiseProduct(x - z).cwiseAbs().maxCoeff();
        const double dual = weights.cwiseProduct(z - before).cwiseAbs().maxCoeff();
        if (!std::isfinite(primal) || !std::isfinite(dual))
        {
            return false;
        }
        if (primal < options.accuracy && dual < options.accuracy)
        {
            x = z;
            return true;
        }
        if (++sinceChange >= patience &&
            (primal > kUnbalanced * dual || dual > kUnbalanced * primal))
        {
            m_weight *= primal > dual ? kWeightFactor : 1.0 / kWeightFactor;
            m_weight = std::clamp(m_weight, 1e-6, 1e3);
            factorise();
            sinceChange = 0;
            patience += kFirstPatience;
        }
    }
    return false;
}
}  // namespace bullet_ccd::grasp
