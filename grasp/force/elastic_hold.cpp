#include "grasp/force/elastic_hold.h"

#include "bullet_ccd/math/check.h"
#include "grasp/force/cone_program.h"
#include "grasp/force/force_problem.h"

#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace bullet_ccd::grasp
{
namespace
{
/// What normal forces of one weight cost, where a weight that is held gains 1: it decides between
/// preloads that hold the same.
constexpr double kPriceOfForce = 1e-4;
/// Part of the load that the springs may leave unbalanced.
constexpr double kUnbalanced = 1e-6;

/// All numbers in units of the weight and of the distance of the contacts.
struct SpringHand
{
    Eigen::Index d = 0;        ///< coordinates of a contact
    Eigen::MatrixXd graspMap;  ///< 6 x n
    Eigen::MatrixXd torques;   ///< q x n: over the limits
    Eigen::MatrixXd response;  ///< n x 3: forces that answer a load of one weight along x, y, z
    bool balances = false;
};

SpringHand springHand(const ForceProblem& problem,
                      std::span<const double> stiffness,
                      double compliance,
                      double weight)
{
    const ContactLaw law = simplified(problem.law);
    SpringHand hand;
    hand.d = coordinateCount(law);
    const auto count = static_cast<Eigen::Index>(problem.contacts.size());
    const auto joints = static_cast<Eigen::Index>(problem.torqueLimits.size());
    double size = 0.0;
    for (const GraspContact& contact : problem.contacts)
    {
        size = std::max(size, (contact.point - problem.reference).norm());
    }
    hand.graspMap.resize(6, count * hand.d);
    Eigen::MatrixXd moves(count * hand.d, joints);  // of the contacts, in their coordinates
    for (Eigen::Index i = 0; i < count; ++i)
    {
        const GraspContact& contact = problem.contacts[static_cast<std::size_t>(i)];
        hand.graspMap.middleCols(i * hand.d, hand.d) =
            contactBasis(contact, law, problem.reference, std::max(size, 1e-6));
        moves.middleRows(i * hand.d, hand.d) =
            contactBasis(contact, law, contact.point, 1.0).transpose() *
            jacobianOf(problem).middleRows(6 * i, 6);
    }
    Eigen::MatrixXd gives = compliance * Eigen::MatrixXd::Identity(moves.rows(), moves.rows());
    hand.torques = moves.transpose();
    for (Eigen::Index j = 0; j < joints; ++j)
    {
        gives += moves.col(j) * moves.col(j).transpose() / stiffness[static_cast<std::size_t>(j)];
        hand.torques.row(j) *= weight / problem.torqueLimits[static_cast<std::size_t>(j)];
    }
    const Eigen::MatrixXd pull = gives.ldlt().solve(hand.graspMap.transpose());
    const Eigen::Matrix<double, 6, 6> object = hand.graspMap * pull;
    const Eigen::Matrix<double, 6, 3> loads = Eigen::Matrix<double, 6, 3>::Identity();
    hand.response = -pull * object.completeOrthogonalDecomposition().solve(loads);
    hand.balances = (hand.graspMap * hand.response + loads).norm() <= kUnbalanced;
    return hand;
}
}  // namespace

ElasticHold holdElastically(const ForceProblem& problem,
                            std::span<const double> stiffness,
                            double compliance,
                            double weight,
                            double asked)
{
    requireValid(problem);
    require(stiffness.size() == problem.torqueLimits.size(),
            "elastic hold: " + std::to_string(stiffness.size()) + " stiffnesses for " +
                std::to_string(problem.torqueLimits.size()) + " joints: give one each");
    require(std::ranges::all_of(stiffness, [](double k) { return k > 0.0; }) && compliance > 0.0 &&
                weight > 0.0 && asked > 0.0,
            "elastic hold: stiffness, compliance, weight and what is asked must be positive");
    const auto count = static_cast<Eigen::Index>(problem.contacts.size());
    ElasticHold hold{
        .forces = std::vector<Eigen::Vector3d>(problem.contacts.size(), Eigen::Vector3d::Zero()),
        .torques = std::vector<double>(stiffness.size(), 0.0)};
    if (count == 0)
    {
        return hold;
    }
    const SpringHand hand = springHand(problem, stiffness, compliance, weight);
    if (!hand.balances)
    {
        return hold;
    }
    const Eigen::Index d = hand.d;
    const Eigen::Index n = count * d;
    const Eigen::Index joints = hand.torques.rows();
    // Unknowns: the preload in weights, and how many weights are held, t.
    ConeProgram program;
    program.c = Eigen::VectorXd::Zero(n + 1);
    program.c[n] = -1.0;
    program.A = Eigen::MatrixXd::Zero(6, n + 1);
    program.A.leftCols(n) = hand.graspMap;
    program.b = Eigen::VectorXd::Zero(6);
    program.G = Eigen::MatrixXd::Zero(2 * joints + 2 + n, n + 1);
    program.h = Eigen::VectorXd::Zero(program.G.rows());
    // |torque| + t |torque of the response| <= limit
    const Eigen::MatrixXd answered = hand.torques * hand.response;
    for (Eigen::Index j = 0; j < joints; ++j)
    {
        for (const Eigen::Index row : {2 * j, 2 * j + 1})
        {
            program.G.row(row).head(n) = (row % 2 == 0 ? 1.0 : -1.0) * hand.torques.row(j);
            program.G(row, n) = answered.row(j).norm();
            program.h[row] = 1.0;
        }
    }
    Eigen::Index row = 2 * joints;
    program.G(row++, n) = -1.0;  // 0 <= t <= asked
    program.G(row, n) = 1.0;
    program.h[row++] = asked;
    // |tangential part| + t (mu |normal response| + |tangential response|) <= mu f_n
    const ContactLaw law = simplified(problem.law);
    program.cones.nonnegative = d == 1 ? program.G.rows() : row;
    for (Eigen::Index i = 0; i < count; ++i)
    {
        const double mu = d == 1 ? 1.0 : law.friction;
        const auto answer = hand.response.middleRows(i * d, d);
        double most = mu * answer.row(0).norm();
        program.G(row, i * d) = -mu;
        if (d > 1)
        {
            Eigen::MatrixXd tangential = answer.bottomRows(d - 1);
            for (Eigen::Index k = 1; k < d; ++k)
            {
                const double scale = k == 3 ? 1.0 / law.torsion : 1.0;
                program.G(row + k, i * d + k) = -scale;
                tangential.row(k - 1) *= scale;
            }
            most += Eigen::JacobiSVD<Eigen::MatrixXd>(tangential).singularValues()[0];
            program.cones.sizes.push_back(d);
        }
        program.G(row, n) = most;
        program.c[i * d] = kPriceOfForce;
        row += d;
    }
    const ConeSolution solution = solve(program);
    if (solution.status != ConeStatus::Optimal)
    {
        return hold;
    }
    hold.weights = std::max(0.0, solution.x[n]);
    const Eigen::VectorXd torques = hand.torques * solution.x.head(n);
    for (Eigen::Index i = 0; i < count; ++i)
    {
        const auto k = static_cast<std::size_t>(i);
        hold.forces[k] =
            weight * contactBasis(problem.contacts[k], law, problem.reference, 1.0).topRows<3>() *
            solution.x.segment(i * d, d);
    }
    for (std::size_t j = 0; j < hold.torques.size(); ++j)
    {
        hold.torques[j] = problem.torqueLimits[j] * torques[static_cast<Eigen::Index>(j)];
    }
    return hold;
}
}  // namespace bullet_ccd::grasp
