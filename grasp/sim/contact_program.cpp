#include "grasp/sim/contact_program.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
// The compliance of the method, relative to the mobility of a row. Newton's method finds its way
// the better the larger it is, and the impulses follow the faster the smaller it is: so it shrinks
// from one minimum to the next, and where it has shrunk too fast to find one, it grows again.
constexpr double kFirstGrain = 0.1;
constexpr double kShrinks = 0.2;
constexpr double kGrows = 100.0;
constexpr double kLeastGrain = 1e-4;
constexpr double kLargestGrain = 10.0;
constexpr int kPatience = 8;             // Newton steps to a minimum
constexpr double kSmallestGrain = 1e-9;  // of rows that nothing can move [1/kg]
constexpr double kUnlimited = 1e15;      // bounds that are none
constexpr double kLeastShare = 1e-6;     // of its mobility that a row has for itself
constexpr double kFollow = 0.1;          // error at which impulses follow, of what they follow by
constexpr int kHalvings = 5;             // of a Newton step
constexpr double kDecrease = 0.5;        // of the error, that a step promises at least

/// Rows that move the same bodies, directly or through others, and these bodies' velocities.
struct Part
{
    std::vector<Eigen::Index> rows;
    std::vector<Eigen::Index> columns;
};

/// In ascending order; a contact as a whole. Bullet groups bodies by boxes that overlap, so a
/// program may be of many things that do not touch. Bodies that no impulse moves belong to no part.
std::vector<Part> partsOf(const ContactProgram& program)
{
    const Eigen::Index n = program.J.rows();
    const Eigen::Index bounded = program.lower.size();
    const auto index = [](Eigen::Index i) { return static_cast<std::size_t>(i); };
    std::vector<Eigen::Index> first(index(n));  // row of the same part
    std::iota(first.begin(), first.end(), Eigen::Index{0});
    const auto find = [&](Eigen::Index i)
    {
        while (first[index(i)] != i)
        {
            i = first[index(i)] = first[index(first[index(i)])];
        }
        return i;
    };
    const auto join = [&](Eigen::Index i, Eigen::Index j)
    {
        const auto [low, high] = std::minmax({find(i), find(j)});
        first[index(high)] = low;
    };
    for (Eigen::Index i = bounded; i < n; i += 3)
    {
        join(i, i + 1);
        join(i, i + 2);
    }
    std::vector<Eigen::Index> rowOf(index(program.J.cols()), -1);
    for (Eigen::Index k = 0; k < program.J.cols(); ++k)
    {
        if ((program.W.col(k).array() == 0.0).all())
        {
            continue;
        }
        for (Eigen::Index i = 0; i < n; ++i)
        {
            // Either may be the one that shows it: joints of a chain move each other.
            if (program.J(i, k) != 0.0 || program.W(i, k) != 0.0)
            {
                rowOf[index(k)] = rowOf[index(k)] < 0 ? i : rowOf[index(k)];
                join(rowOf[index(k)], i);
            }
        }
    }
    std::vector<Part> parts;
    std::vector<std::size_t> number(index(n));
    for (Eigen::Index i = 0; i < n; ++i)
    {
        const Eigen::Index root = find(i);
        if (root == i)
        {
            number[index(i)] = parts.size();
            parts.emplace_back();
        }
        parts[number[index(root)]].rows.push_back(i);
    }
    for (std::size_t k = 0; k < rowOf.size(); ++k)
    {
        if (rowOf[k] >= 0)
        {
            parts[number[index(find(rowOf[k]))]].columns.push_back(static_cast<Eigen::Index>(k));
        }
    }
    return parts;
}

/// The matrices of a part without most of their zeros: a row is moved by few of the bodies'
/// velocities (J), moves some of them (W), and the three rows of a contact have the same ones.
class Rows
{
public:
    Rows(const Eigen::MatrixXd& J, const Eigen::MatrixXd& W, Eigen::Index bounded)
        : m_rows(J.rows()), m_columns(J.cols())
    {
        for (Eigen::Index row = 0; row < m_rows;)
        {
            const Eigen::Index size = row < bounded ? 1 : 3;
            m_groups.push_back({row, size, added(J, row, size, m_J), added(W, row, size, m_W)});
            row += size;
        }
    }

    /// J times velocities of bodies: those of the rows.
    [[nodiscard]] Eigen::VectorXd speeds(const Eigen::VectorXd& bodies) const
    {
        Eigen::VectorXd result(m_rows);
        for (const Group& group : m_groups)
        {
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (const Entry& entry : of(group.J, m_J))
            {
                sum += bodies[entry.column] * entry.values;
            }
            result.segment(group.row, group.size) = sum.head(group.size);
        }
        return result;
    }

    /// W^T times impulses: velocities of bodies.
    [[nodiscard]] Eigen::VectorXd bodies(const Eigen::VectorXd& impulses) const
    {
        Eigen::VectorXd result = Eigen::VectorXd::Zero(m_columns);
        for (const Group& group : m_groups)
        {
            Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
            impulse.head(group.size) = impulses.segment(group.row, group.size);
            if (impulse.isZero(0.0))
            {
                continue;
            }
            for (const Entry& entry : of(group.W, m_W))
            {
                result[entry.column] += entry.values.dot(impulse);
            }
        }
        return result;
    }

    /// Identity and W^T slopes J, where the slopes are of each bounded row and each contact.
    [[nodiscard]] Eigen::MatrixXd curvature(const std::vector<Eigen::Matrix3d>& slopes) const
    {
        Eigen::MatrixXd result = Eigen::MatrixXd::Identity(m_columns, m_columns);
        for (std::size_t g = 0; g < m_groups.size(); ++g)
        {
            if (slopes[g].isZero(0.0))
            {
                continue;
            }
            for (const Entry& moved : of(m_groups[g].J, m_J))
            {
                const Eigen::Vector3d along = slopes[g] * moved.values;
                for (const Entry& moving : of(m_groups[g].W, m_W))
                {
                    result(moving.column, moved.column) += moving.values.dot(along);
                }
            }
        }
        return result;
    }

    /// Each bounded row and each contact by its slope.
    [[nodiscard]] Eigen::VectorXd times(const std::vector<Eigen::Matrix3d>& slopes,
                                        const Eigen::VectorXd& speeds) const
    {
        Eigen::VectorXd result(m_rows);
        for (std::size_t g = 0; g < m_groups.size(); ++g)
        {
            const Eigen::Index row = m_groups[g].row;
            const Eigen::Index size = m_groups[g].size;
            result.segment(row, size).noalias() =
                slopes[g].topLeftCorner(size, size) * speeds.segment(row, size);
        }
        return result;
    }

private:
    /// Places of entries.
    struct Range
    {
        std::size_t begin;
        std::size_t size;
    };
    /// A bounded row, or the three of a contact.
    struct Group
    {
        Eigen::Index row;
        Eigen::Index size;
        Range J;
        Range W;
    };
    /// What the rows of a group have in a column.
    struct Entry
    {
        Eigen::Index column;
        Eigen::Vector3d values;
    };

    Eigen::Index m_rows;
    Eigen::Index m_columns;
    std::vector<Group> m_groups;
    std::vector<Entry> m_J;
    std::vector<Entry> m_W;

    static Range added(const Eigen::MatrixXd& matrix,
                       Eigen::Index row,
                       Eigen::Index size,
                       std::vector<Entry>& entries)
    {
        const std::size_t begin = entries.size();
        for (Eigen::Index k = 0; k < matrix.cols(); ++k)
        {
            const auto values = matrix.col(k).segment(row, size);
            if ((values.array() != 0.0).any())
            {
                entries.push_back({k, Eigen::Vector3d::Zero()});
                entries.back().values.head(size) = values;
            }
        }
        return {begin, entries.size() - begin};
    }
    static std::span<const Entry> of(const Range& range, const std::vector<Entry>& entries)
    {
        return std::span(entries).subspan(range.begin, range.size);
    }
};

/// One part and its iterates. Velocities are those of the rows.
class PartSolver
{
public:
    PartSolver(const ContactProgram& program, const Part& part)
        : m_compliance(program.compliance(part.rows)), m_b(program.b(part.rows))
    {
        const Eigen::MatrixXd J = program.J(part.rows, part.columns);
        const Eigen::MatrixXd W = program.W(part.rows, part.columns);
        m_mobility = J.cwiseProduct(W).rowwise().sum();
        const Eigen::Index all = program.lower.size();
        m_bounded = std::ranges::count_if(part.rows, [&](Eigen::Index i) { return i < all; });
        const std::vector<Eigen::Index> limited(part.rows.begin(), part.rows.begin() + m_bounded);
        m_lower = program.lower(limited);
        m_upper = program.upper(limited);
        for (auto k = static_cast<std::size_t>(m_bounded); k < part.rows.size(); k += 3)
        {
            m_friction.push_back(
                program.friction[static_cast<std::size_t>((part.rows[k] - all) / 3)]);
        }
        keepCouplings(J, W);
        for (Eigen::Index i = m_bounded; i < m_mobility.size(); i += 3)
        {
            m_mobility.segment<3>(i).setConstant(m_mobility.segment<3>(i).mean());
        }
        m_rows.emplace(J, W, m_bounded);
    }

    /// Improves x. Returns false if the iterations do not suffice.
    bool solve(Eigen::VectorXd& x, const ContactProgramOptions& options, int& iterations)
    {
        const double accuracy = 0.5 * options.accuracy;
        x = within(x);
        Eigen::VectorXd multipliers = x;  // of the velocities that are tried
        double grain = kFirstGrain;
        double shrinks = kShrinks;
        setGrain(grain, x);
        int steps = 0;  // to this minimum
        for (int k = 0; k <= options.maxIterations;)
        {
            const Eigen::VectorXd velocity = m_rows->speeds(m_rows->bodies(multipliers));
            const Eigen::VectorXd wish = (m_aim - velocity).cwiseQuotient(m_R);
            const Eigen::VectorXd missing = within(wish) - multipliers;
            const Eigen::VectorXd next = within(multipliers);
            const double error = m_R.cwiseProduct(missing).cwiseAbs().maxCoeff();
            const double way = m_grain.cwiseProduct(next - x).cwiseAbs().maxCoeff();
            const auto outside = [&]
            { return m_rows->speeds(m_rows->bodies(next - multipliers)).cwiseAbs().maxCoeff(); };
            if (std::max(error, way) <= accuracy && outside() <= accuracy)
            {
                x = next;
                return true;
            }
            if (error <= std::max(accuracy, kFollow * way) && way > accuracy)
            {
                x = next;
                grain = std::max(grain * shrinks, kLeastGrain);
                setGrain(grain, x);
                steps = 0;
                continue;
            }
            ++k;
            ++iterations;
            if (++steps <= kPatience)
            {
                multipliers += newtonStep(multipliers, wish, missing);
                continue;
            }
            multipliers = x;
            grain = std::min(kGrows * grain, kLargestGrain);
            shrinks = std::sqrt(shrinks);
            setGrain(grain, x);
            steps = 0;
        }
        return false;
    }

private:
    /// How a row moves while couplings, which have no limit, keep their place: links of a chain
    /// that carry each other have much of their mobility in common.
    void keepCouplings(const Eigen::MatrixXd& allJ, const Eigen::MatrixXd& allW)
    {
        std::vector<Eigen::Index> couplings;
        for (Eigen::Index i = 0; i < m_bounded; ++i)
        {
            if (m_lower[i] <= -kUnlimited && m_upper[i] >= kUnlimited)
            {
                couplings.push_back(i);
            }
        }
        if (couplings.empty())
        {
            return;
        }
        const Eigen::MatrixXd J = allJ(couplings, Eigen::all);
        const Eigen::MatrixXd W = allW(couplings, Eigen::all);
        Eigen::MatrixXd A = J * W.transpose();
        const Eigen::VectorXd share = (kLeastShare * A.diagonal()).cwiseMax(kSmallestGrain);
        A.diagonal() += m_compliance(couplings) + share;
        const Eigen::MatrixXd inverse = A.inverse();
        const Eigen::MatrixXd across = allJ * W.transpose();
        const Eigen::VectorXd kept = (across * inverse).cwiseProduct(across).rowwise().sum();
        m_mobility = (m_mobility - kept).cwiseMax(kLeastShare * m_mobility);
        m_mobility(couplings) = inverse.diagonal().cwiseInverse();
    }

    /// What the impulses may be, as near to these as the law of friction has it.
    [[nodiscard]] Eigen::VectorXd within(const Eigen::VectorXd& wish) const
    {
        Eigen::VectorXd result(wish.size());
        result.head(m_bounded) = wish.head(m_bounded).cwiseMax(m_lower).cwiseMin(m_upper);
        for (std::size_t k = 0; k < m_friction.size(); ++k)
        {
            const Eigen::Index i = m_bounded + 3 * static_cast<Eigen::Index>(k);
            const double normal = std::max(0.0, wish[i]);
            const double sideways = wish.segment<2>(i + 1).norm();
            const double most = m_friction[k] * normal;
            result[i] = normal;
            result.segment<2>(i + 1) =
                (sideways > most ? most / sideways : 1.0) * wish.segment<2>(i + 1);
        }
        return result;
    }

    void setGrain(double grain, const Eigen::VectorXd& x)
    {
        m_grain = (grain * m_mobility).cwiseMax(kSmallestGrain);
        m_R = m_compliance + m_grain;
        m_aim = m_b + m_grain.cwiseProduct(x);
    }

    /// How the impulses of each bounded row, then of each contact, follow its velocities, negative.
    [[nodiscard]] std::vector<Eigen::Matrix3d> slopes(const Eigen::VectorXd& wish) const
    {
        const auto bounded = static_cast<std::size_t>(m_bounded);
        std::vector<Eigen::Matrix3d> result(bounded + m_friction.size(), Eigen::Matrix3d::Zero());
        for (Eigen::Index i = 0; i < m_bounded; ++i)
        {
            if (wish[i] > m_lower[i] && wish[i] < m_upper[i])
            {
                result[static_cast<std::size_t>(i)](0, 0) = 1.0 / m_R[i];
            }
        }
        for (std::size_t k = 0; k < m_friction.size(); ++k)
        {
            const Eigen::Index i = m_bounded + 3 * static_cast<Eigen::Index>(k);
            const double most = m_friction[k] * wish[i];
            if (wish[i] <= 0.0)
            {
                continue;
            }
            Eigen::Matrix3d slope = m_R.segment<3>(i).cwiseInverse().asDiagonal();
            const double sideways = wish.segment<2>(i + 1).norm();
            if (sideways > most)
            {
                const Eigen::Vector2d along = wish.segment<2>(i + 1) / sideways;
                const Eigen::Matrix2d across =
                    Eigen::Matrix2d::Identity() - along * along.transpose();
                slope.bottomRightCorner<2, 2>() =
                    (most / sideways) * across * slope.bottomRightCorner<2, 2>();
                slope.bottomLeftCorner<2, 1>() = m_friction[k] * slope(0, 0) * along;
            }
            result[bounded + k] = slope;
        }
        return result;
    }

    /// With a search along it for where the velocities disagree less, by energy.
    [[nodiscard]] Eigen::VectorXd newtonStep(const Eigen::VectorXd& multipliers,
                                             const Eigen::VectorXd& wish,
                                             const Eigen::VectorXd& missing) const
    {
        const std::vector<Eigen::Matrix3d> slope = slopes(wish);
        const Eigen::VectorXd speeds =
            m_rows->speeds(m_rows->curvature(slope).partialPivLu().solve(m_rows->bodies(missing)));
        const Eigen::VectorXd step = missing - m_rows->times(slope, speeds);
        const Eigen::VectorXd rows = speeds.cwiseQuotient(m_R);
        const auto energy = [&](const Eigen::VectorXd& impulses)
        { return impulses.dot(m_rows->speeds(m_rows->bodies(impulses))); };
        const double before = energy(missing);
        double least = std::numeric_limits<double>::infinity();
        double best = 1.0;
        double way = 1.0;
        for (int k = 0; k <= kHalvings; ++k, way *= 0.5)
        {
            const double here = energy(within(wish - way * rows) - multipliers - way * step);
            if (here < least)
            {
                least = here;
                best = way;
            }
            if (here <= (1.0 - kDecrease * way) * before)
            {
                break;
            }
        }
        return best * step;
    }

    std::optional<Rows> m_rows;
    Eigen::VectorXd m_compliance;
    Eigen::VectorXd m_b;
    Eigen::VectorXd m_mobility;
    Eigen::VectorXd m_lower;
    Eigen::VectorXd m_upper;
    std::vector<double> m_friction;
    Eigen::Index m_bounded = 0;

    Eigen::VectorXd m_grain;
    Eigen::VectorXd m_R;    ///< compliance and grain
    Eigen::VectorXd m_aim;  ///< velocity at which no impulse is needed
};
}  // namespace

ContactProgramEffort solveContacts(const ContactProgram& program,
                                   Eigen::VectorXd& x,
                                   const ContactProgramOptions& options)
{
    ContactProgramEffort effort;
    for (const Part& part : partsOf(program))
    {
        Eigen::VectorXd y = x(part.rows);
        effort.unfinished += PartSolver(program, part).solve(y, options, effort.iterations) ? 0 : 1;
        x(part.rows) = y;
    }
    return effort;
}
}  // namespace bullet_ccd::grasp
