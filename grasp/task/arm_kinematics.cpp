#include "grasp/task/arm_kinematics.h"

#include "bullet_ccd/math/check.h"
#include "grasp/approach/draws.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <numbers>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kPrecision = 1e-9;  // [m], and [rad] as far as KDL sees turns
constexpr int kIterations = 100;

KDL::Vector toKdl(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

KDL::Frame toKdl(const Eigen::Isometry3d& X)
{
    const auto& R = X.linear();
    return {KDL::Rotation(toKdl(R.col(0)), toKdl(R.col(1)), toKdl(R.col(2))),
            toKdl(X.translation())};
}

KDL::JntArray toKdl(const std::vector<double>& q)
{
    KDL::JntArray array(static_cast<unsigned>(q.size()));
    std::ranges::copy(q, array.data.begin());
    return array;
}

/// The largest difference of a joint's positions.
double farthest(const std::vector<double>& q, const std::vector<double>& other)
{
    double most = 0.0;
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        most = std::max(most, std::abs(q[k] - other[k]));
    }
    return most;
}

/// Within the limits, by whole turns if need be; nothing if that cannot be.
std::optional<std::vector<double>> withinLimits(const KDL::JntArray& array,
                                                const std::vector<Joint>& limits)
{
    std::vector<double> q(array.data.begin(), array.data.end());
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        const auto& [lower, upper] = std::pair(limits[k].lower, limits[k].upper);
        if (limits[k].type != JointType::Prismatic)
        {
            constexpr double kTurn = 2.0 * std::numbers::pi;
            q[k] -= kTurn * std::ceil(std::max(0.0, q[k] - upper) / kTurn);
            q[k] += kTurn * std::ceil(std::max(0.0, lower - q[k]) / kTurn);
        }
        if (!(q[k] >= lower && q[k] <= upper))
        {
            return std::nullopt;
        }
    }
    return q;
}

/// Low-discrepancy points of the unit cube: multiples of the powers of the root of x^(n+1) = x + 1,
/// as golden sections are for n = 1 (Roberts 2018, "The unreasonable effectiveness of quasirandom
/// sequences").
class SpreadPoints
{
public:
    SpreadPoints(std::size_t dimension, std::uint64_t seed) : m_steps(dimension), m_point(dimension)
    {
        double root = 1.5;
        for (int i = 0; i < 60; ++i)
        {
            root = std::pow(1.0 + root, 1.0 / double(dimension + 1));
        }
        Draws draws(seed, 0);
        for (std::size_t k = 0; k < dimension; ++k)
        {
            m_steps[k] = std::pow(root, -double(k + 1));
            m_point[k] = draws.unit();
        }
    }

    const std::vector<double>& next()
    {
        for (std::size_t k = 0; k < m_point.size(); ++k)
        {
            m_point[k] += m_steps[k];
            m_point[k] -= std::floor(m_point[k]);
        }
        return m_point;
    }

private:
    std::vector<double> m_steps;
    std::vector<double> m_point;
};
}  // namespace

struct ArmKinematics::Chain
{
    KDL::Chain kdl;
    KDL::JntArray lower;
    KDL::JntArray upper;
};

ArmKinematics::ArmKinematics(const KinematicTree& tree,
                             std::int32_t link,
                             const Eigen::Isometry3d& X_WR)
    : m_X_WR(X_WR)
{
    require(link > 0 && static_cast<std::size_t>(link) < tree.size(),
            "inverse kinematics: there is no such link below the root");
    std::vector<std::int32_t> path;
    for (std::int32_t i = link; i > 0; i = tree.links[static_cast<std::size_t>(i)].parent)
    {
        path.push_back(i);
    }
    std::ranges::reverse(path);
    const auto chain = std::make_shared<Chain>();
    Eigen::Isometry3d X_WL = X_WR;
    for (const std::int32_t i : path)
    {
        const Link& each = tree.links[static_cast<std::size_t>(i)];
        m_reach += m_joints.empty() ? 0.0 : each.X_PL0.translation().norm();
        X_WL = X_WL * each.X_PL0;
        chain->kdl.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::Fixed), toKdl(each.X_PL0)));
        if (each.joint.isMovable())
        {
            require(each.joint.mimicOf == kNone && each.joint.type != JointType::Spherical,
                    "inverse kinematics: joint " + each.joint.name +
                        " follows another or is spherical, which is not supported");
            const bool slides = each.joint.type == JointType::Prismatic;
            chain->kdl.addSegment(
                KDL::Segment(KDL::Joint(KDL::Vector::Zero(),
                                        toKdl(each.joint.axis),
                                        slides ? KDL::Joint::TransAxis : KDL::Joint::RotAxis)));
            m_shoulder = m_joints.empty() ? X_WL.translation() : m_shoulder;
            m_joints.push_back(i);
            m_limits.push_back(each.joint);
            m_reach +=
                slides ? std::max(std::abs(each.joint.lower), std::abs(each.joint.upper)) : 0.0;
        }
    }
    require(!m_joints.empty(), "inverse kinematics: no joint moves the link");
    const auto limits = [&](double Joint::*limit)
    {
        std::vector<double> all;
        std::ranges::transform(m_limits, std::back_inserter(all), limit);
        return toKdl(all);
    };
    chain->lower = limits(&Joint::lower);
    chain->upper = limits(&Joint::upper);
    m_chain = chain;
}

Eigen::Isometry3d ArmKinematics::poseAt(const std::vector<double>& q) const
{
    require(q.size() == m_joints.size(),
            "inverse kinematics: give one position for each joint of the chain");
    KDL::Frame tip;
    KDL::ChainFkSolverPos_recursive(m_chain->kdl).JntToCart(toKdl(q), tip);
    Eigen::Isometry3d X_RL = Eigen::Isometry3d::Identity();
    X_RL.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(tip.M.data);
    X_RL.translation() = Eigen::Map<const Eigen::Vector3d>(tip.p.data);
    return m_X_WR * X_RL;
}

bool ArmKinematics::isTooFar(const Eigen::Isometry3d& X_WL) const
{
    return (X_WL.translation() - m_shoulder).norm() > m_reach + kPrecision;
}

std::vector<std::vector<double>> ArmKinematics::solve(const Eigen::Isometry3d& X_WL,
                                                      const std::vector<double>& near,
                                                      const IkOptions& options) const
{
    require(near.size() == m_joints.size() && X_WL.matrix().allFinite(),
            "inverse kinematics: give a finite pose, and one position for each joint of the chain");
    std::vector<std::vector<double>> solutions;
    if (isTooFar(X_WL))
    {
        return solutions;
    }
    const KDL::Frame wanted = toKdl(m_X_WR.inverse() * X_WL);
    KDL::ChainIkSolverPos_LMA solver(
        m_chain->kdl, Eigen::Matrix<double, 6, 1>::Ones(), kPrecision, kIterations);
    SpreadPoints points(near.size(), options.seed);
    KDL::JntArray start = toKdl(near);
    KDL::JntArray end(start.rows());
    for (int i = 0; i <= options.restarts && std::ssize(solutions) < options.wanted; ++i)
    {
        if (i > 0)
        {
            const std::vector<double>& point = points.next();
            for (std::size_t k = 0; k < point.size(); ++k)
            {
                const Joint& joint = m_limits[k];
                start(static_cast<unsigned>(k)) =
                    std::lerp(std::max(joint.lower, -std::numbers::pi),
                              std::min(joint.upper, std::numbers::pi),
                              point[k]);
            }
        }
        if (solver.CartToJnt(start, wanted, end) < KDL::SolverI::E_NOERROR)
        {
            continue;
        }
        const auto q = withinLimits(end, m_limits);
        if (q && std::ranges::none_of(solutions,
                                      [&](const std::vector<double>& known)
                                      { return farthest(*q, known) < options.apart; }))
        {
            solutions.push_back(*q);
        }
    }
    return solutions;
}

std::optional<std::vector<double>> ArmKinematics::follow(const Eigen::Isometry3d& X_WL,
                                                         const std::vector<double>& near,
                                                         double step) const
{
    require(near.size() == m_joints.size(),
            "inverse kinematics: give one position for each joint of the chain");
    const KDL::Chain& chain = m_chain->kdl;
    KDL::ChainFkSolverPos_recursive forward(chain);
    KDL::ChainIkSolverVel_pinv velocities(chain);
    KDL::ChainIkSolverPos_NR_JL solver(
        chain, m_chain->lower, m_chain->upper, forward, velocities, kIterations, kPrecision);
    KDL::JntArray end(static_cast<unsigned>(near.size()));
    if (solver.CartToJnt(toKdl(near), toKdl(m_X_WR.inverse() * X_WL), end) <
        KDL::SolverI::E_NOERROR)
    {
        return std::nullopt;
    }
    const std::vector<double> q(end.data.begin(), end.data.end());
    return farthest(q, near) <= step ? std::optional(q) : std::nullopt;
}
}  // namespace bullet_ccd::grasp
