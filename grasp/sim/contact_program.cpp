#include "grasp/sim/contact_program.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kFirstWeight = 0.03;  // relative to the diagonal
constexpr int kFirstPatience = 10;     // iterations before the weight may change ..
constexpr double kUnbalanced = 5.0;    // .. where one residual is that much above the other
constexpr double kWeightFactor = 3.0;
constexpr int kMostRounds = 8;  // in which bounded rows may change sides
constexpr int kPatience = 5;    // times more iterations, for contacts alone

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
/// Rows that move each other, directly or through others, in ascending order; a contact as a whole.
/// Bullet groups bodies by boxes that overlap, so a program may be of many things that do not
/// touch.
std::vector<std::vector<Eigen::Index>> partsOf(const ContactProgram& program)
{
    const Eigen::Index n = program.A.rows();
    const Eigen::Index bounded = program.lower.size();
    std::vector<Eigen::Index> first(static_cast<std::size_t>(n));  // row of the same part
    std::iota(first.begin(), first.end(), Eigen::Index{0});
    const auto find = [&](Eigen::Index i)
    {
        while (first[static_cast<std::size_t>(i)] != i)
        {
            i = first[static_cast<std::size_t>(i)];
        }
        return i;
    };
    for (Eigen::Index j = 0; j < n; ++j)
    {
        for (Eigen::Index i = 0; i < j; ++i)
        {
            const bool isOneContact = i >= bounded && (i - bounded) / 3 == (j - bounded) / 3;
            if (program.A(i, j) != 0.0 || isOneContact)
            {
                const Eigen::Index a = find(i);
                const Eigen::Index b = find(j);
                first[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
            }
        }
    }
    std::vector<std::vector<Eigen::Index>> parts;
    std::vector<std::size_t> number(static_cast<std::size_t>(n));
    for (Eigen::Index i = 0; i < n; ++i)
    {
        const Eigen::Index root = find(i);
        if (root == i)
        {
            number[static_cast<std::size_t>(i)] = parts.size();
            parts.emplace_back();
        }
        parts[number[static_cast<std::size_t>(root)]].push_back(i);
    }
    return parts;
}
}  // namespace

ContactProgramSolver::ContactProgramSolver()
    : m_weight(kFirstWeight), m_contactsWeight(kFirstWeight)
{
}

int ContactProgramSolver::solve(const ContactProgram& program,
                                Eigen::VectorXd& x,
                                const ContactProgramOptions& options)
{
    const std::vector<std::vector<Eigen::Index>> parts = partsOf(program);
    if (parts.size() == 1)
    {
        return solvePart(program, x, options);
    }
    const Eigen::Index bounded = program.lower.size();
    int iterations = 0;
    for (const std::vector<Eigen::Index>& rows : parts)
    {
        const auto own = std::ranges::count_if(rows, [&](Eigen::Index i) { return i < bounded; });
        const std::vector<Eigen::Index> limited(rows.begin(), rows.begin() + own);
        ContactProgram part{.A = program.A(rows, rows),
                            .b = program.b(rows),
                            .lower = program.lower(limited),
                            .upper = program.upper(limited),
                            .friction = {}};
        for (std::size_t k = limited.size(); k < rows.size(); k += 3)
        {
            part.friction.push_back(
                program.friction[static_cast<std::size_t>((rows[k] - bounded) / 3)]);
        }
        Eigen::VectorXd y = x(rows);
        iterations += solvePart(part, y, options);
        x(rows) = y;
    }
    return iterations;
}

int ContactProgramSolver::solvePart(const ContactProgram& program,
                                    Eigen::VectorXd& x,
                                    const ContactProgramOptions& options)
{
    ContactProgramOptions patient = options;
    patient.maxIterations *= kPatience;
    if (program.lower.size() == 0)
    {
        int iterations = 0;
        if (!alternate(program, x, patient, m_contactsWeight, iterations))
        {
            giveUp(program, x, options);
        }
        return iterations;
    }
    // What bodies need changes slowly: what the last one needed is tried first.
    int total = 0;
    const Eigen::VectorXd start = x;
    for (const bool eliminates : {m_eliminates, !m_eliminates})
    {
        int iterations = 0;
        x = start;
        const bool isDone = eliminates ? eliminate(program, x, patient, iterations)
                                       : alternate(program, x, options, m_weight, iterations);
        total += iterations;
        if (isDone)
        {
            m_eliminates = eliminates;
            return total;
        }
    }
    giveUp(program, x, options);
    return total;
}

void ContactProgramSolver::giveUp(const ContactProgram& program,
                                  Eigen::VectorXd& x,
                                  const ContactProgramOptions& options)
{
    // What was come to is no solution, and what was learned is wrong.
    m_weight = m_contactsWeight = kFirstWeight;
    ++m_failures;
    sweep(program, x, options);
}

bool ContactProgramSolver::eliminate(const ContactProgram& program,
                                     Eigen::VectorXd& x,
                                     const ContactProgramOptions& options,
                                     int& iterations)
{
    const Eigen::Index bounded = program.lower.size();
    const Eigen::Index contacts = program.A.rows() - bounded;
    const auto ofContacts = Eigen::seqN(bounded, contacts);
    x.head(bounded) = x.head(bounded).cwiseMax(program.lower).cwiseMin(program.upper);
    std::vector<bool> isFree;
    for (Eigen::Index i = 0; i < bounded; ++i)
    {
        isFree.push_back(x[i] > program.lower[i] && x[i] < program.upper[i]);
    }
    ContactProgram reduced{
        .A = {}, .b = {}, .lower = {}, .upper = {}, .friction = program.friction};
    for (int round = 0; round < kMostRounds; ++round)
    {
        std::vector<Eigen::Index> free;
        Eigen::VectorXd fixed = Eigen::VectorXd::Zero(x.size());
        for (Eigen::Index i = 0; i < bounded; ++i)
        {
            if (isFree[static_cast<std::size_t>(i)])
            {
                free.push_back(i);
            }
            else
            {
                fixed[i] = x[i];
            }
        }
        const Eigen::VectorXd b = program.b - program.A * fixed;
        const Eigen::LLT<Eigen::MatrixXd> own(program.A(free, free));
        const Eigen::MatrixXd across = program.A(free, ofContacts);
        const Eigen::MatrixXd answer = own.solve(across);
        reduced.A = program.A(ofContacts, ofContacts) - across.transpose() * answer;
        reduced.A.diagonal() = reduced.A.diagonal().cwiseMax(1e-12);
        const Eigen::VectorXd ownB = b(free);
        reduced.b = b(ofContacts) - answer.transpose() * ownB;
        Eigen::VectorXd y = x(ofContacts);
        int more = 0;
        if (contacts > 0 && !alternate(reduced, y, options, m_contactsWeight, more))
        {
            iterations += more;
            return false;
        }
        iterations += more;
        x(ofContacts) = y;
        const Eigen::VectorXd answers = own.solve(Eigen::VectorXd(ownB - across * y));
        x(free) = answers;
        const Eigen::VectorXd lacking = program.b - program.A * x;
        bool isDone = x.allFinite();
        for (Eigen::Index i = 0; i < bounded; ++i)
        {
            const double within = std::clamp(x[i], program.lower[i], program.upper[i]);
            const bool wasFree = isFree[static_cast<std::size_t>(i)];
            const bool leaves =
                !wasFree && ((x[i] <= program.lower[i] && lacking[i] > options.accuracy) ||
                             (x[i] >= program.upper[i] && lacking[i] < -options.accuracy));
            if (wasFree ? within != x[i] : leaves)
            {
                isFree[static_cast<std::size_t>(i)] = !wasFree;
                isDone = false;
            }
            x[i] = within;
        }
        if (isDone)
        {
            return true;
        }
    }
    return false;
}

bool ContactProgramSolver::alternate(const ContactProgram& program,
                                     Eigen::VectorXd& x,
                                     const ContactProgramOptions& options,
                                     double& weight,
                                     int& iterations) const
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
        weights = weight * scale;
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
            weight *= primal > dual ? kWeightFactor : 1.0 / kWeightFactor;
            weight = std::clamp(weight, 1e-6, 1e3);
            factorise();
            sinceChange = 0;
            patience += kFirstPatience;
        }
    }
    return false;
}
}  // namespace bullet_ccd::grasp
