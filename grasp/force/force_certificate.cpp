#include "grasp/force/force_certificate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace bullet_ccd::grasp
{
namespace
{
/// In units of the scaled problem's force.
constexpr double kLeastProof = 1e5;
/// What contributes less than this part to the sum of a certificate is not named.
constexpr double kNamed = 1e-6;

/// Support of the cone of contact i, or of the pyramid inscribed in it.
double support(const ContactLaw& law, const LocalForce& direction, int edges)
{
    return edges == 0 ? coneSupport(law, direction)
                      : (direction.transpose() * coneEdges(law, edges)).maxCoeff();
}

std::string number(const char* format, double value)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

std::string directionText(const Wrench& direction)
{
    std::string text = "(";
    for (Eigen::Index k = 0; k < 6; ++k)
    {
        const double rounded = std::abs(direction[k]) < 5e-4 ? 0.0 : direction[k];
        text += (k == 0 ? "" : k == 3 ? "; " : " ") + number("%.3f", rounded);
    }
    return text + ")";
}

/// What the limits allow along the certificate's direction, with the names of those that take part.
struct Limits
{
    double sum = 0.0;
    std::string names;
};

Limits limitsOf(const ForceProblem& problem, const ForceCertificate& certificate)
{
    std::vector<std::pair<double, std::string>> parts;
    for (std::size_t j = 0; j < certificate.jointRates.size(); ++j)
    {
        const double rate = std::abs(certificate.jointRates[j]);
        if (rate > 0.0)
        {
            const std::string name =
                problem.jointNames.empty() ? std::to_string(j) : problem.jointNames[j];
            const double limit = problem.torqueLimits[j];
            parts.emplace_back(rate * limit, "joint " + name + " (" + number("%.4g", limit) + ")");
        }
    }
    Limits limits;
    for (const auto& [share, name] : parts)
    {
        limits.sum += share;
    }
    const double cap = vectorOf(certificate.normalRates).sum();
    limits.sum += cap > 0.0 ? cap * problem.maxNormalForce : 0.0;
    std::stable_sort(
        parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [share, name] : parts)
    {
        if (share > kNamed * limits.sum)
        {
            limits.names += (limits.names.empty() ? "joint torque limits: " : ", ") + name;
        }
    }
    if (cap * problem.maxNormalForce > kNamed * limits.sum)
    {
        limits.names += (limits.names.empty() ? "" : ", and ") +
                        std::string("largest normal force (") +
                        number("%.4g", problem.maxNormalForce) + " N)";
    }
    return limits;
}
}  // namespace

bool ForceCertificate::coneOnly() const
{
    const auto isZero = [](double rate) { return rate == 0.0; };
    return std::all_of(jointRates.begin(), jointRates.end(), isZero) &&
           std::all_of(normalRates.begin(), normalRates.end(), isZero);
}

std::optional<ForceCertificate> verified(const ForceProblem& problem,
                                         const ScaledProblem& scaledProblem,
                                         const ForceMultipliers& multipliers,
                                         int edges)
{
    const double size = multipliers.equilibrium.norm();
    if (!(size > 0.0))
    {
        return std::nullopt;
    }
    const Wrench u = multipliers.equilibrium / size;
    const Eigen::VectorXd v = multipliers.torques / size;
    const Eigen::VectorXd l = multipliers.normals.cwiseMax(0.0) / size;
    const Eigen::VectorXd directions =
        scaledProblem.graspMap.transpose() * u - scaledProblem.torqueMap.transpose() * v;
    double excess = 0.0;
    for (Eigen::Index i = 0; i < l.size(); ++i)
    {
        LocalForce direction =
            directions.segment(i * scaledProblem.coordinates, scaledProblem.coordinates);
        direction[0] -= l[i];
        excess = std::max(excess, support(scaledProblem.law, direction, edges));
    }
    double strength = u.dot(scaledProblem.target) - v.cwiseAbs().dot(scaledProblem.torqueLimits);
    if (l.size() > 0 && l.maxCoeff() > 0.0)
    {
        strength -= l.sum() * scaledProblem.maxNormalForce;
    }
    // Also false for nan.
    if (!(strength > kLeastProof * excess) || !(strength > 0.0))
    {
        return std::nullopt;
    }

    ForceCertificate certificate;
    certificate.direction = u;
    certificate.length = scaledProblem.length;
    certificate.jointRates.resize(problem.torqueLimits.size());
    for (Eigen::Index k = 0; k < v.size(); ++k)
    {
        const Eigen::Index joint = scaledProblem.limitedJoints[static_cast<std::size_t>(k)];
        certificate.jointRates[static_cast<std::size_t>(joint)] =
            v[k] * scaledProblem.force / scaledProblem.torqueScales[k];
    }
    certificate.normalRates.assign(l.begin(), l.end());
    certificate.provenUpTo = scaledProblem.force * strength / excess;
    return certificate;
}

std::string describe(const ForceProblem& problem, const ForceCertificate& certificate)
{
    Wrench target = -problem.load;
    target.tail<3>() /= certificate.length;
    const std::string needed = number("%.4g", certificate.direction.dot(target)) + " N along " +
                               directionText(certificate.direction);
    if (problem.contacts.empty())
    {
        return "there are no contacts, and balance needs " + needed;
    }
    const std::string unit = " (force; moment / " + number("%.3g", certificate.length) + " m)";
    if (certificate.coneOnly())
    {
        return "the friction cones alone cannot balance the load: balance needs " + needed + unit +
               ", where no contact can push";
    }
    const Limits limits = limitsOf(problem, certificate);
    return limits.names + ": balance needs " + needed + unit + ", they allow " +
           number("%.4g", limits.sum) + " N";
}
}  // namespace bullet_ccd::grasp
