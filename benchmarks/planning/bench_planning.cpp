/// Motions and plans of an arm in clutter: certified, and by OMPL's discrete validator on FCL at
/// 1 % (its default) and 0.1 % of the extent of the space.
#include "benchmarks/planning/planning_scene.h"
#include "benchmarks/support/program.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fmt/format.h>
#include <ompl/base/DiscreteMotionValidator.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

namespace bullet_ccd::benchmarks
{
namespace
{
namespace ob = ::ompl::base;
namespace og = ::ompl::geometric;

struct Options
{
    int scenes = 20;
    int edges = 300;
    int problems = 10;
    double limit = 5.0;
};

class FclStateChecker : public ob::StateValidityChecker
{
public:
    FclStateChecker(const ob::SpaceInformationPtr& information, const ClutteredArm& arm)
        : ob::StateValidityChecker(information), m_arm(arm)
    {
    }
    bool isValid(const ob::State* state) const override
    {
        const double* q = state->as<ob::RealVectorStateSpace::StateType>()->values;
        return si_->satisfiesBounds(state) && m_arm.isFreeByFcl({q, kArmJoints});
    }

private:
    const ClutteredArm& m_arm;
};

/// The three that are compared; 0 stands for ours.
constexpr std::array<double, 3> kResolutions{0.0, 0.01, 0.001};

ob::SpaceInformationPtr spaceOf(const ClutteredArm& arm, double resolution)
{
    if (resolution == 0.0)
    {
        return certifiedSpace(arm.robot());
    }
    auto information = std::make_shared<ob::SpaceInformation>(
        jointSpace(*arm.robot()->scene().body.tree, arm.robot()->scene().joints));
    information->setStateValidityChecker(std::make_shared<FclStateChecker>(information, arm));
    information->setStateValidityCheckingResolution(resolution);
    information->setup();
    return information;
}

/// Of this thread's processor time, which does not depend on what else the machine does.
double secondsOf(const auto& function)
{
    const auto now = []
    {
        timespec time{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
    };
    const double start = now();
    function();
    return now() - start;
}

ob::ScopedState<> stateOf(const ob::SpaceInformationPtr& information, const Configuration& q)
{
    ob::ScopedState<> state(information);
    state = std::vector<double>(q.begin(), q.end());
    return state;
}

Configuration between(const Configuration& from, const Configuration& to, double t)
{
    Configuration q{};
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        q[k] = std::lerp(from[k], to[k], t);
    }
    return q;
}

/// What is known of one edge.
enum class Truth
{
    Free,      ///< certified
    Collides,  ///< FCL finds an overlap at one of many samples
    NearMiss,  ///< within the tolerance, and no sample overlaps
};

Truth truthOf(const ClutteredArm& arm, const Configuration& from, const Configuration& to)
{
    const ArticulatedToiResult toi = arm.robot()->motionToi(from, to);
    if (toi.status == ToiStatus::Separated)
    {
        return Truth::Free;
    }
    // From the contact on, first in steps that double, then evenly.
    for (double ahead = 1e-6; toi.time + ahead < 1.0; ahead *= 2.0)
    {
        if (!arm.isFreeByFcl(between(from, to, toi.time + ahead)))
        {
            return Truth::Collides;
        }
    }
    constexpr int kSamples = 20000;
    for (int k = 0; k <= kSamples; ++k)
    {
        if (!arm.isFreeByFcl(between(from, to, std::lerp(toi.time, 1.0, double(k) / kSamples))))
        {
            return Truth::Collides;
        }
    }
    return Truth::NearMiss;
}

struct EdgeCounts
{
    int valid = 0;
    int collide = 0;
    int nearMisses = 0;
    int missed = 0;  ///< certified free, but in collision by what it is compared with
    double freeSeconds = 0.0;
    double blockedSeconds = 0.0;
    int blocked = 0;
};

struct PlanCounts
{
    int solved = 0;
    int collide = 0;
    std::vector<double> seconds;
};

double medianOf(std::vector<double> values)
{
    if (values.empty())
    {
        return NAN;
    }
    std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
    return values[values.size() / 2];
}

void askEdges(const ClutteredArm& arm,
              const Options& options,
              std::uint64_t seed,
              std::array<EdgeCounts, 3>& counts)
{
    std::array<ob::SpaceInformationPtr, 3> spaces;
    std::ranges::transform(kResolutions, spaces.begin(), [&](double r) { return spaceOf(arm, r); });
    reference::Random random(seed);
    for (int i = 0; i < options.edges; ++i)
    {
        const Configuration from = arm.freeConfiguration(random);
        Configuration to{};
        do
        {
            // About as long as the extensions of RRT-Connect: a fifth of the extent.
            to = between(from, arm.freeConfiguration(random), 0.4);
        } while (!arm.robot()->isFree(to));
        const Truth truth = truthOf(arm, from, to);
        for (std::size_t m = 0; m < spaces.size(); ++m)
        {
            const ob::ScopedState<> start = stateOf(spaces[m], from);
            const ob::ScopedState<> end = stateOf(spaces[m], to);
            bool isValid = false;
            const double seconds =
                secondsOf([&] { isValid = spaces[m]->checkMotion(start.get(), end.get()); });
            EdgeCounts& count = counts[m];
            (isValid ? count.freeSeconds : count.blockedSeconds) += seconds;
            ++(isValid ? count.valid : count.blocked);
            count.collide += isValid && truth == Truth::Collides ? 1 : 0;
            count.nearMisses += !isValid && truth == Truth::NearMiss ? 1 : 0;
            count.missed += m > 0 && !isValid && truth == Truth::Free ? 1 : 0;
        }
    }
}

void plan(const ClutteredArm& arm,
          const Options& options,
          std::uint64_t seed,
          std::array<PlanCounts, 3>& counts)
{
    reference::Random random(seed);
    for (int i = 0; i < options.problems; ++i)
    {
        const Configuration from = arm.freeConfiguration(random);
        const Configuration to = arm.freeConfiguration(random);
        for (std::size_t m = 0; m < kResolutions.size(); ++m)
        {
            // The same draws for all, so that they differ by their answers only.
            ::ompl::RNG::setSeed(
                static_cast<std::uint_fast32_t>(seed * 1000 + 1 + std::uint64_t(i)));
            og::SimpleSetup setup(spaceOf(arm, kResolutions[m]));
            const ob::SpaceInformationPtr information = setup.getSpaceInformation();
            setup.setStartAndGoalStates(stateOf(information, from), stateOf(information, to));
            setup.setPlanner(std::make_shared<og::RRTConnect>(information));
            setup.setup();
            ob::PlannerStatus status;
            // A limit as a number would start a thread, whose end takes ten milliseconds.
            const double seconds = secondsOf(
                [&] { status = setup.solve(ob::timedPlannerTerminationCondition(options.limit)); });
            counts[m].seconds.push_back(seconds);
            if (status != ob::PlannerStatus::EXACT_SOLUTION)
            {
                continue;
            }
            ++counts[m].solved;
            const std::vector<ob::State*>& states = setup.getSolutionPath().getStates();
            const auto configuration = [&](std::size_t k)
            {
                const double* q = states[k]->as<ob::RealVectorStateSpace::StateType>()->values;
                Configuration result{};
                std::copy_n(q, kArmJoints, result.begin());
                return result;
            };
            bool collides = false;
            for (std::size_t k = 0; k + 1 < states.size() && !collides; ++k)
            {
                collides = truthOf(arm, configuration(k), configuration(k + 1)) == Truth::Collides;
            }
            counts[m].collide += collides ? 1 : 0;
        }
    }
}

bool run(const Options& options)
{
    ::ompl::msg::noOutputHandler();
    std::array<EdgeCounts, 3> edges{};
    std::array<PlanCounts, 3> plans{};
    for (int scene = 0; scene < options.scenes; ++scene)
    {
        const auto seed = static_cast<std::uint64_t>(scene);
        const ClutteredArm arm(seed);
        askEdges(arm, options, seed + 1000, edges);
        plan(arm, options, seed + 2000, plans);
    }
    const std::array<std::string, 3> names{"certified", "FCL at 1 %", "FCL at 0.1 %"};
    fmt::print("{} scenes, {} edges and {} problems each\n\n",
               options.scenes,
               options.edges,
               options.problems);
    fmt::print("{:<14}{:>8}{:>10}{:>12}{:>14}{:>9}{:>9}{:>13}{:>11}\n",
               "validator",
               "valid",
               "collide",
               "us, free",
               "us, blocked",
               "solved",
               "collide",
               "median ms",
               "mean ms");
    bool isRight = true;
    for (std::size_t m = 0; m < 3; ++m)
    {
        const EdgeCounts& e = edges[m];
        const PlanCounts& p = plans[m];
        double total = 0.0;
        for (const double seconds : p.seconds)
        {
            total += seconds;
        }
        fmt::print("{:<14}{:>8}{:>10}{:>12.1f}{:>14.1f}{:>9}{:>9}{:>13.2f}{:>11.2f}\n",
                   names[m],
                   e.valid,
                   e.collide,
                   1e6 * e.freeSeconds / std::max(1, e.valid),
                   1e6 * e.blockedSeconds / std::max(1, e.blocked),
                   p.solved,
                   p.collide,
                   1e3 * medianOf(p.seconds),
                   1e3 * total / double(std::max<std::size_t>(1, p.seconds.size())));
        isRight = isRight && e.missed == 0 && (m > 0 || (e.collide == 0 && p.collide == 0));
    }
    fmt::print(
        "\nMotions that only come within the tolerance, which the certified validator "
        "refuses: {}\n",
        edges[0].nearMisses);
    return isRight;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    Options options;
    const Program program{
        .name = "bench_planning",
        .about = "Motions and plans of an arm in clutter: certified, and at samples by FCL.",
        .options = {{"--scenes", &options.scenes, "How many arms in clutter."},
                    {"--edges", &options.edges, "How many motions to test in each."},
                    {"--problems", &options.problems, "How many plans to make in each.", 0},
                    {"--limit", &options.limit, "How long a planner may try [s]."}},
        .run = [&] { return run(options); }};
    return runProgram(argc, argv, program);
}
