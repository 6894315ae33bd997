// The cone programs again as smooth nonlinear programs, solved by Ipopt.
#include "grasp/force/grasp_forces.h"
#include "tests/grasp/contact_sets.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <IpStdCInterface.h>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
/// Cones are rounded at their tips by this, where they have no gradient.
constexpr double kRounding = 1e-5;

/// Unknowns: forces in W (3 a contact), margin t. Rows: 6 of equilibrium, torques, and
/// mu n.f - t - sqrt(|f_t|^2 + kRounding^2) >= 0 a contact.
struct Model
{
    ForceProblem problem;
    bool firm = false;

    [[nodiscard]] int contacts() const { return static_cast<int>(problem.contacts.size()); }
    [[nodiscard]] int unknowns() const { return 3 * contacts() + 1; }
    [[nodiscard]] int joints() const { return static_cast<int>(problem.torqueLimits.size()); }
    [[nodiscard]] int rows() const { return 6 + joints() + contacts(); }

    [[nodiscard]] Eigen::VectorXd gradient() const
    {
        Eigen::VectorXd g = Eigen::VectorXd::Zero(unknowns());
        for (int i = 0; i < contacts() && !firm; ++i)
        {
            g.segment<3>(3 * i) = problem.contacts[static_cast<std::size_t>(i)].normal;
        }
        g[unknowns() - 1] = firm ? -1.0 : 0.0;
        return g;
    }

    [[nodiscard]] Eigen::MatrixXd linearRows() const
    {
        Eigen::MatrixXd A = Eigen::MatrixXd::Zero(6 + joints(), unknowns());
        for (int i = 0; i < contacts(); ++i)
        {
            const Eigen::Vector3d p = problem.contacts[static_cast<std::size_t>(i)].point;
            A.block<3, 3>(0, 3 * i).setIdentity();
            A.block<3, 3>(3, 3 * i) << 0.0, -p.z(), p.y(), p.z(), 0.0, -p.x(), -p.y(), p.x(), 0.0;
            A.block(6, 3 * i, joints(), 3) = problem.jacobian.middleRows<3>(6 * i).transpose();
        }
        return A;
    }

    [[nodiscard]] double cone(const Eigen::VectorXd& x, int i) const
    {
        const Eigen::Vector3d n = problem.contacts[static_cast<std::size_t>(i)].normal;
        const Eigen::Vector3d f = x.segment<3>(3 * i);
        const Eigen::Vector3d side = f - n * n.dot(f);
        return problem.law.friction * n.dot(f) - x[unknowns() - 1] -
               std::sqrt(side.squaredNorm() + kRounding * kRounding);
    }

    [[nodiscard]] Eigen::VectorXd coneGradient(const Eigen::VectorXd& x, int i) const
    {
        const Eigen::Vector3d n = problem.contacts[static_cast<std::size_t>(i)].normal;
        const Eigen::Vector3d f = x.segment<3>(3 * i);
        const Eigen::Vector3d side = f - n * n.dot(f);
        Eigen::VectorXd g = Eigen::VectorXd::Zero(unknowns());
        g.segment<3>(3 * i) =
            problem.law.friction * n - side / std::sqrt(side.squaredNorm() + kRounding * kRounding);
        g[unknowns() - 1] = -1.0;
        return g;
    }
};

const Model& modelOf(UserDataPtr data)
{
    return *static_cast<const Model*>(data);
}

Eigen::VectorXd vectorOf(Index n, const Number* x)
{
    return Eigen::Map<const Eigen::VectorXd>(x, n);
}

Bool objective(Index n, Number* x, Bool, Number* value, UserDataPtr data)
{
    *value = modelOf(data).gradient().dot(vectorOf(n, x));
    return TRUE;
}

Bool gradient(Index n, Number*, Bool, Number* values, UserDataPtr data)
{
    Eigen::Map<Eigen::VectorXd>(values, n) = modelOf(data).gradient();
    return TRUE;
}

Bool constraints(Index n, Number* x, Bool, Index m, Number* values, UserDataPtr data)
{
    const Model& model = modelOf(data);
    Eigen::Map<Eigen::VectorXd> g(values, m);
    g.head(6 + model.joints()) = model.linearRows() * vectorOf(n, x);
    for (int i = 0; i < model.contacts(); ++i)
    {
        g[6 + model.joints() + i] = model.cone(vectorOf(n, x), i);
    }
    return TRUE;
}

Bool jacobian(Index n,
              Number* x,
              Bool,
              Index m,
              Index,
              Index* rows,
              Index* columns,
              Number* values,
              UserDataPtr data)
{
    const Model& model = modelOf(data);
    if (values == nullptr)
    {
        for (Index k = 0; k < n * m; ++k)
        {
            rows[k] = k % m;
            columns[k] = k / m;
        }
        return TRUE;
    }
    Eigen::Map<Eigen::MatrixXd> dense(values, m, n);
    dense.topRows(6 + model.joints()) = model.linearRows();
    for (int i = 0; i < model.contacts(); ++i)
    {
        dense.row(6 + model.joints() + i) = model.coneGradient(vectorOf(n, x), i).transpose();
    }
    return TRUE;
}

Bool noHessian(
    Index, Number*, Bool, Number, Index, Number*, Bool, Index, Index*, Index*, Number*, UserDataPtr)
{
    return FALSE;
}

/// Value of the objective; nothing unless Ipopt ends with an optimum.
std::optional<double> ipoptForces(Model model)
{
    const int n = model.unknowns();
    const int m = model.rows();
    Eigen::VectorXd lower = Eigen::VectorXd::Constant(n, -2e19);
    Eigen::VectorXd upper = Eigen::VectorXd::Constant(n, 2e19);
    lower[n - 1] = 0.0;
    upper[n - 1] = model.firm ? 2e19 : 0.0;
    Eigen::VectorXd rowLower = Eigen::VectorXd::Zero(m);
    Eigen::VectorXd rowUpper = Eigen::VectorXd::Constant(m, 2e19);
    rowLower.head<6>() = -model.problem.load;
    rowUpper.head<6>() = -model.problem.load;
    rowLower.segment(6, model.joints()) = -model.problem.torqueLimits;
    rowUpper.segment(6, model.joints()) = model.problem.torqueLimits;
    const std::unique_ptr<std::remove_pointer_t<IpoptProblem>, decltype(&FreeIpoptProblem)> ipopt(
        CreateIpoptProblem(n,
                           lower.data(),
                           upper.data(),
                           m,
                           rowLower.data(),
                           rowUpper.data(),
                           n * m,
                           0,
                           0,
                           &objective,
                           &constraints,
                           &gradient,
                           &jacobian,
                           &noHessian),
        &FreeIpoptProblem);
    const auto text = [&](const char* key, const char* value)
    { AddIpoptStrOption(ipopt.get(), const_cast<char*>(key), const_cast<char*>(value)); };
    text("hessian_approximation", "limited-memory");
    text("sb", "yes");
    AddIpoptIntOption(ipopt.get(), const_cast<char*>("print_level"), 0);
    AddIpoptIntOption(ipopt.get(), const_cast<char*>("max_iter"), 400);
    AddIpoptNumOption(ipopt.get(), const_cast<char*>("tol"), 1e-7);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < model.contacts(); ++i)
    {
        x.segment<3>(3 * i) = model.problem.contacts[static_cast<std::size_t>(i)].normal;
    }
    double value = 0.0;
    const ApplicationReturnStatus status =
        IpoptSolve(ipopt.get(), x.data(), nullptr, &value, nullptr, nullptr, nullptr, &model);
    return status == Solve_Succeeded ? std::optional(model.firm ? -value : value) : std::nullopt;
}

TEST(IpoptReference, ExactConesOfRandomGraspsHaveTheSameValue)
{
    std::mt19937 random(1);
    int compared = 0;
    int gaveUp = 0;
    int infeasible = 0;
    constexpr int kTrials = 24;
    for (int trial = 0; trial < kTrials; ++trial)
    {
        const int contacts = 3 + trial % 6;
        Model model{.problem = {.contacts = tests::randomGrasp(random, contacts)},
                    .firm = trial % 2 == 1};
        model.problem.load << tests::randomVector(random), 0.3 * tests::randomVector(random);
        model.problem.jacobian.resize(6 * contacts, 6);
        for (double& entry : model.problem.jacobian.reshaped())
        {
            entry = 0.2 * tests::randomVector(random).x();
        }
        model.problem.torqueLimits = Eigen::VectorXd::Constant(6, 1.0);
        const GraspForces answer = solveGraspForces(
            model.problem,
            {.objective = model.firm ? ForceObjective::Firm : ForceObjective::Total});
        const std::optional<double> expected = ipoptForces(model);
        if (answer.status == ForceStatus::Infeasible)
        {
            ++infeasible;
            EXPECT_FALSE(expected.has_value()) << trial;
        }
        else if (answer.status == ForceStatus::Balanced && expected)
        {
            ++compared;
            EXPECT_NEAR(answer.value, *expected, 2e-4 * (1.0 + *expected)) << trial;
        }
        else
        {
            ++gaveUp;
        }
    }
    EXPECT_GT(compared, kTrials / 4);
    EXPECT_GT(infeasible, kTrials / 10);
    EXPECT_LE(gaveUp, kTrials / 4);
}
}  // namespace
}  // namespace bullet_ccd::grasp
