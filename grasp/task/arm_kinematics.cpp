#include "grasp/task/arm_kinematics.h"

#include "bullet_ccd/math/check.h"
#include "grasp/approach/draws.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
constexpr double kPrecision = 1e-9;  // [m] and [rad]
constexpr int kIterations = 80;
constexpr double kLargestStep = 0.7;  // of a joint in an iteration [rad or m]
/// Part of the way to the middle of the ranges, where the error is a metre or a radian.
constexpr double kPull = 0.1;
/// Keeps the damped system regular where the error is tiny, far below what changes a step.
constexpr double kLeastDamping = 1e-14;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Columns6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// What is missing from one pose to the other: the way, and the turn about W's axes.
Vector6 errorOf(const Eigen::Isometry3d& X_WL, const Eigen::Isometry3d& wanted)
{
    const Eigen::AngleAxisd turn(
        Eigen::Quaterniond(wanted.linear() * X_WL.linear().transpose()).normalized());
    Vector6 error;
    error << wanted.translation() - X_WL.translation(), turn.angle() * turn.axis();
    return error;
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

struct ArmKinematics::Frames
{
    Eigen::Isometry3d X_WL;
    std::vector<Eigen::Vector3d> axes;
    std::vector<Eigen::Vector3d> origins;
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
    for (const std::int32_t i : path)
    {
        m_chain.push_back(tree.links[static_cast<std::size_t>(i)]);
        const Link& each = m_chain.back();
        m_reach += m_joints.empty() ? 0.0 : each.X_PL0.translation().norm();
        if (each.joint.isMovable())
        {
            require(each.joint.mimicOf == kNone && each.joint.type != JointType::Spherical,
                    "inverse kinematics: joint " + each.joint.name +
                        " follows another or is spherical, which is not supported");
            m_joints.push_back(i);
            m_limits.push_back(each.joint);
            m_reach += each.joint.type == JointType::Prismatic
                           ? std::max(std::abs(each.joint.lower), std::abs(each.joint.upper))
                           : 0.0;
        }
    }
    require(!m_joints.empty(), "inverse kinematics: no joint moves the link");
}

ArmKinematics::Frames ArmKinematics::framesAt(const std::vector<double>& q) const
{
    require(q.size() == m_joints.size(),
            "inverse kinematics: give one position for each joint of the chain");
    Frames frames{.X_WL = m_X_WR, .axes = {}, .origins = {}};
    for (const Link& link : m_chain)
    {
        const std::size_t k = frames.axes.size();
        const bool moves = link.joint.isMovable();
        frames.X_WL = frames.X_WL * linkInParent(link, moves ? q[k] : 0.0);
        if (moves)
        {
            frames.axes.emplace_back(frames.X_WL.linear() * link.joint.axis);
            frames.origins.emplace_back(frames.X_WL.translation());
        }
    }
    return frames;
}

Eigen::Isometry3d ArmKinematics::poseAt(const std::vector<double>& q) const
{
    return framesAt(q).X_WL;
}

bool ArmKinematics::isTooFar(const Eigen::Isometry3d& X_WL) const
{
    // The origin of the first joint rests if that joint turns; if it slides, its way is counted.
    const std::vector<double> zero(m_joints.size(), 0.0);
    const double away = (X_WL.translation() - framesAt(zero).origins.front()).norm();
    return away > m_reach + kPrecision;
}

bool ArmKinematics::descend(const Eigen::Isometry3d& X_WL,
                            std::vector<double>& q,
                            double pull) const
{
    const auto count = static_cast<Eigen::Index>(q.size());
    Columns6 J(6, count);
    Eigen::VectorXd middle(count);
    for (int iteration = 0; iteration < kIterations; ++iteration)
    {
        const Frames frames = framesAt(q);
        const Vector6 error = errorOf(frames.X_WL, X_WL);
        if (error.head<3>().norm() <= kPrecision && error.tail<3>().norm() <= kPrecision)
        {
            return true;
        }
        for (Eigen::Index k = 0; k < count; ++k)
        {
            const auto i = static_cast<std::size_t>(k);
            const Joint& joint = m_limits[i];
            const Eigen::Vector3d& axis = frames.axes[i];
            if (joint.type == JointType::Prismatic)
            {
                J.col(k) << axis, Eigen::Vector3d::Zero();
            }
            else
            {
                J.col(k) << axis.cross(frames.X_WL.translation() - frames.origins[i]), axis;
            }
            const double between = 0.5 * (joint.lower + joint.upper);
            middle[k] = std::isfinite(between) ? between - q[i] : 0.0;
        }
        // A joint at its limit that the step would take out of it is left out, and the step is made
        // anew, until all stay within.
        Eigen::VectorXd step;
        for (Eigen::Index round = 0; round <= count; ++round)
        {
            Eigen::Matrix<double, 6, 6> A = J * J.transpose();
            A.diagonal().array() += 0.5 * error.squaredNorm() + kLeastDamping;
            const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(A);
            const Eigen::VectorXd home = pull * std::min(1.0, error.norm()) * middle;
            const Vector6 missing = error - J * home;
            step = J.transpose() * solver.solve(missing) + home;
            bool stays = true;
            for (Eigen::Index k = 0; k < count; ++k)
            {
                const auto i = static_cast<std::size_t>(k);
                const Joint& joint = m_limits[i];
                if ((q[i] <= joint.lower && step[k] < 0.0) ||
                    (q[i] >= joint.upper && step[k] > 0.0))
                {
                    J.col(k).setZero();
                    middle[k] = 0.0;
                    stays = false;
                }
            }
            if (stays)
            {
                break;
            }
        }
        const double largest = step.cwiseAbs().maxCoeff();
        if (!(largest > 1e-13))
        {
            return false;
        }
        step *= std::min(1.0, kLargestStep / largest);
        for (std::size_t k = 0; k < q.size(); ++k)
        {
            q[k] = std::clamp(
                q[k] + step[static_cast<Eigen::Index>(k)], m_limits[k].lower, m_limits[k].upper);
        }
    }
    return false;
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
    SpreadPoints points(near.size(), options.seed);
    for (int i = 0; i <= options.restarts && std::ssize(solutions) < options.wanted; ++i)
    {
        std::vector<double> q = near;
        if (i > 0)
        {
            const std::vector<double>& point = points.next();
            for (std::size_t k = 0; k < q.size(); ++k)
            {
                const Joint& joint = m_limits[k];
                q[k] = std::lerp(std::max(joint.lower, -std::numbers::pi),
                                 std::min(joint.upper, std::numbers::pi),
                                 point[k]);
            }
        }
        const auto isOld = [&](const std::vector<double>& known)
        {
            double most = 0.0;
            for (std::size_t k = 0; k < q.size(); ++k)
            {
                most = std::max(most, std::abs(q[k] - known[k]));
            }
            return most < options.apart;
        };
        if (descend(X_WL, q, kPull) && std::ranges::none_of(solutions, isOld))
        {
            solutions.push_back(q);
        }
    }
    return solutions;
}

std::optional<std::vector<double>> ArmKinematics::follow(const Eigen::Isometry3d& X_WL,
                                                         const std::vector<double>& near,
                                                         double step) const
{
    std::vector<double> q = near;
    if (!descend(X_WL, q, 0.0))
    {
        return std::nullopt;
    }
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        if (std::abs(q[k] - near[k]) > step)
        {
            return std::nullopt;
        }
    }
    return q;
}
}  // namespace bullet_ccd::grasp
