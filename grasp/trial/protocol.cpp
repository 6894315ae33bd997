#include "grasp/trial/protocol.h"

#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace bullet_ccd::grasp
{
namespace
{
using Kind = TrialPhase::Kind;

constexpr double kDegree = std::numbers::pi / 180.0;

/// +x, -x, +y, -y, +z, -z.
Eigen::Vector3d alongAxis(int k)
{
    return (k % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(k / 2);
}

std::vector<TrialPhase> sixLoads()
{
    std::vector<TrialPhase> phases;
    for (int k = 0; k < 6; ++k)
    {
        phases.push_back({.kind = Kind::Load, .time = 1.0, .direction = alongAxis(k)});
    }
    return phases;
}

std::vector<TrialPhase> shakes()
{
    std::vector<TrialPhase> phases;
    for (int k = 0; k < 3; ++k)
    {
        phases.push_back({.kind = Kind::Shake,
                          .time = 2.0,
                          .direction = Eigen::Vector3d::Unit(k),
                          .amount = 0.020,
                          .frequency = 2.0});
    }
    return phases;
}

std::vector<TrialPhase> sixPulls()
{
    std::vector<TrialPhase> phases;
    for (int k = 0; k < 6; ++k)
    {
        TrialPhase phase{.kind = Kind::Pull};
        phase.wrench.head<3>() = alongAxis(k);
        phases.push_back(phase);
    }
    return phases;
}

std::string kindName(Kind kind)
{
    switch (kind)
    {
        case Kind::Load:
            return "load";
        case Kind::Shake:
            return "shake";
        case Kind::Lift:
            return "lift";
        case Kind::Pull:
            break;
    }
    return "pull";
}
}  // namespace

const std::vector<std::string>& shippedProtocols()
{
    static const std::vector<std::string> names{"six", "hover", "shake", "lift", "pull", "disturb"};
    return names;
}

TrialProtocol shippedProtocol(const std::string& name)
{
    if (name == "six")
    {
        return {.name = name, .phases = sixLoads()};
    }
    if (name == "hover")
    {
        return {.name = name, .phases = {{.kind = Kind::Load, .time = 10.0}}};
    }
    if (name == "shake")
    {
        return {.name = name, .phases = shakes()};
    }
    if (name == "lift")
    {
        return {.name = name,
                .start = TrialStart::Table,
                .phases = {{.kind = Kind::Lift, .time = 1.0, .amount = 0.2},
                           {.kind = Kind::Load, .time = 3.0}}};
    }
    if (name == "pull")
    {
        return {.name = name, .phases = sixPulls()};
    }
    require(name == "disturb", "trial: no protocol \"" + name + "\" ships");
    return {.name = name,
            .start = TrialStart::Open,
            .phases = sixLoads(),
            .shift = 0.005,
            .turn = 5.0 * kDegree};
}

std::vector<TrialPhase> randomPulls(int count, std::uint64_t seed)
{
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    std::vector<TrialPhase> phases;
    for (int k = 0; k < count; ++k)
    {
        TrialPhase phase{.kind = Kind::Pull};
        do
        {
            for (double& entry : phase.wrench)
            {
                entry = normal(engine);
            }
        } while (phase.wrench.norm() < 1e-3);
        phase.wrench.normalize();
        phases.push_back(phase);
    }
    return phases;
}

TrialProtocol namedProtocol(const std::string& nameOrFile)
{
    const std::vector<std::string>& names = shippedProtocols();
    return std::find(names.begin(), names.end(), nameOrFile) != names.end()
               ? shippedProtocol(nameOrFile)
               : readProtocol(nameOrFile);
}

void checkProtocol(const TrialProtocol& protocol)
{
    const std::string name = "protocol \"" + protocol.name + "\": ";
    require(!protocol.phases.empty(), name + "no phases: give one or more");
    for (std::size_t k = 0; k < protocol.phases.size(); ++k)
    {
        const TrialPhase& phase = protocol.phases[k];
        const std::string place =
            name + "phase " + std::to_string(k + 1) + " (" + kindName(phase.kind) + "): ";
        if (phase.kind == Kind::Pull)
        {
            require(phase.wrench.allFinite() && phase.wrench.norm() > 0.0,
                    place + "the wrench is 0 or not finite: give a direction");
            continue;
        }
        require(std::isfinite(phase.time) && phase.time > 0.0 && phase.time <= 600.0,
                place + "its time must be above 0 and at most 600 s");
        require(phase.direction.allFinite() && phase.direction.norm() > 0.0,
                place + "the direction is 0 or not finite: give another one");
        require(std::isfinite(phase.amount) && phase.amount >= 0.0,
                place + "its amount must be finite and not negative");
        require(
            phase.kind != Kind::Shake || (std::isfinite(phase.frequency) && phase.frequency > 0.0),
            place + "its frequency must be positive");
    }
    require(protocol.heldWay > 0.0 && protocol.heldTurn > 0.0 &&
                protocol.lostWay >= protocol.heldWay && std::isfinite(protocol.lostWay),
            name +
                "thresholds must be positive, and what is lost has moved at least as far as what "
                "is held may");
    require(protocol.shift >= 0.0 && protocol.turn >= 0.0 && std::isfinite(protocol.shift) &&
                std::isfinite(protocol.turn),
            name + "errors of the pose must be finite and not negative");
    require(protocol.start != TrialStart::Held || (protocol.shift == 0.0 && protocol.turn == 0.0),
            name + "an error of the pose needs a start with the open hand: start: open or table");
}
}  // namespace bullet_ccd::grasp
