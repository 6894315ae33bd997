#include "benchmarks/grasp/pose_errors.h"

#include "benchmarks/closing/discrete_closing.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/support/table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <set>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using grasp::Grasp;
using grasp::RejectReason;
using nlohmann::json;

constexpr std::array kErrors{1e-6, 1e-5, 1e-4, 1e-3};  // [m and rad]
constexpr std::uint64_t kDraws = 5;                    // of each size
constexpr int kGrasps = 2;                             // of a hand and an object

/// The first candidates of a plan that are force closures.
std::vector<Grasp> closuresOf(const grasp::HandModel& hand,
                              const grasp::GraspObject& object,
                              const grasp::PlannerOptions& options)
{
    std::vector<Grasp> planned =
        grasp::planGrasps(hand, object, options, [] { return grasp::kinematicClosing(); });
    std::ranges::sort(planned, {}, &Grasp::candidate);
    int left = kGrasps;
    std::erase_if(planned,
                  [&](const Grasp& grasp)
                  { return grasp.reject != RejectReason::None || left-- <= 0; });
    return planned;
}

std::set<std::int32_t> linksOf(const Grasp& grasp)
{
    std::set<std::int32_t> links;
    for (const grasp::GraspContact& contact : grasp.contacts)
    {
        links.insert(contact.link);
    }
    return links;
}

/// Of several values the one that this share of all is not above.
double quantile(std::vector<double> values, double share)
{
    std::ranges::sort(values);
    return values.at(
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size() - 1) - 1e-9)));
}
}  // namespace

Isometry3d poseError(std::uint64_t seed, double magnitude, const Vector3d& center)
{
    reference::Random random(seed);
    const Vector3d shift = random.direction();
    const Vector3d axis = random.direction();
    return Eigen::Translation3d(center + magnitude * shift) * Eigen::AngleAxisd(magnitude, axis) *
           Eigen::Translation3d(-center);
}

std::vector<GraspMethod> graspMethods(const grasp::HandModel& hand,
                                      const grasp::GraspObject& object,
                                      const grasp::Preshape& preshape)
{
    const auto ours = [&](double tolerance)
    {
        return [&, tolerance](const Isometry3d& X_WStart, const Vector3d& shift)
        {
            return grasp::closeAtPose(hand,
                                      object,
                                      X_WStart,
                                      shift,
                                      preshape,
                                      {.closing = {.tolerance = tolerance}, .volumes = 0},
                                      grasp::kinematicClosing());
        };
    };
    const std::shared_ptr<LinkProximity> trees = treeProximity(hand, object);
    const auto stepping = [&, trees](const DiscreteOptions& steps)
    {
        return [&, trees, steps](const Isometry3d& X_WStart, const Vector3d& shift)
        {
            const double travel =
                discreteApproach(*trees, hand, X_WStart, shift, preshape.positions, steps);
            Isometry3d X_WH = X_WStart;
            X_WH.translation() += std::min(1.0, travel) * shift;
            const double near = std::max(1e-4, steps.contactLayer);
            return grasp::closeAtPose(hand,
                                      object,
                                      X_WH,
                                      Vector3d::Zero(),
                                      preshape,
                                      {.closing = {.contactThreshold = near}, .volumes = 0},
                                      discreteEngine(*trees, steps));
        };
    };
    return {{"ours", ours(2e-5)},
            {"ours, 0.1 um", ours(1e-7)},
            {"stepping", stepping({})},
            {"steps / 10",
             stepping({.closingStep = 1e-3,
                       .approachStep = 1e-3,
                       .contactGap = 2e-5,
                       .contactLayer = 4e-5,
                       .maxSteps = 100'000})}};
}

json judgePoseErrors(const tools::LoadedHand& hand,
                     const tools::LoadedObject& object,
                     const grasp::PlannerOptions& options)
{
    json repeats = json::array();
    for (const Grasp& grasp : closuresOf(hand.hand, object.object, options))
    {
        const Vector3d shift = grasp.X_WH.translation() - grasp.X_WStart.translation();
        const grasp::Preshape& preshape = *findPreshape(hand.hand, grasp.preshape);
        const auto first = (options.seed * 1'000'003 + std::uint64_t(grasp.candidate)) * 1'000;
        for (const GraspMethod& method : graspMethods(hand.hand, object.object, preshape))
        {
            const Grasp before = method.run(grasp.X_WStart, shift);
            if (before.reject != RejectReason::None)
            {
                continue;  // what is none without an error says nothing about errors
            }
            for (const double size : kErrors)
            {
                for (std::uint64_t draw = first; draw < first + kDraws; ++draw)
                {
                    const Isometry3d error = poseError(draw, size, object.object.centerOfMass);
                    const Grasp after = method.run(error * grasp.X_WStart, error.linear() * shift);
                    json repeat{{"method", method.name},
                                {"error", size},
                                {"same links", linksOf(before) == linksOf(after)},
                                {"kept", after.reject == RejectReason::None}};
                    if (!after.positions.empty())
                    {
                        repeat["change"] =
                            postureDifference(hand.hand, before.positions, after.positions);
                    }
                    repeats.push_back(std::move(repeat));
                }
            }
        }
    }
    return {{"repeats", repeats}};
}

bool summarizePoseErrors(const std::vector<json>& rows)
{
    std::vector<std::string> methods;
    std::map<std::pair<std::string, double>, std::vector<json>> groups;
    for (const json& row : rows)
    {
        for (const json& repeat : row["repeats"])
        {
            const auto method = repeat["method"].get<std::string>();
            if (std::ranges::count(methods, method) == 0)
            {
                methods.push_back(method);
            }
            groups[{method, repeat["error"].get<double>()}].push_back(repeat);
        }
    }
    const Table table(
        "method:<14|error [m, rad]=error:>14.0e|draws:>6|change of a joint [rad], "
        "median=median:>33.1e|"
        "95 %=most:>8.1e|rad per m, same links=slope:>21.1f|same links [%]=same:>14.0f|"
        "still closures [%]=kept:>18.0f");
    for (const std::string& method : methods)
    {
        for (const double size : kErrors)
        {
            std::vector<double> changes;
            std::vector<double> quiet;  // while the same links are in contact
            double same = 0.0;
            double kept = 0.0;
            const std::vector<json>& repeats = groups[{method, size}];
            for (const json& repeat : repeats)
            {
                same += repeat["same links"].get<bool>() ? 1.0 : 0.0;
                kept += repeat["kept"].get<bool>() ? 1.0 : 0.0;
                if (repeat.contains("change"))
                {
                    changes.push_back(repeat["change"]);
                    if (repeat["same links"])
                    {
                        quiet.push_back(changes.back() / size);
                    }
                }
            }
            const auto count = static_cast<double>(repeats.size());
            json line{{"method", method},
                      {"error", size},
                      {"draws", repeats.size()},
                      {"same", 100.0 * same / count},
                      {"kept", 100.0 * kept / count}};
            if (!quiet.empty())
            {
                line.update({{"median", quantile(changes, 0.5)},
                             {"most", quantile(changes, 0.95)},
                             {"slope", quantile(quiet, 0.5)}});
            }
            table.print(line);
        }
    }
    return !methods.empty();
}
}  // namespace bullet_ccd::benchmarks
