// Microseconds to find contact forces, by exact cones and by linear program, over the number of
// contacts; answers are checked before they are timed.
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/support/program.h"
#include "benchmarks/support/table.h"
#include "benchmarks/support/timing.h"
#include "grasp/force/grasp_forces.h"

#include <nlohmann/json.hpp>

namespace bullet_ccd::benchmarks
{
namespace
{
using namespace bullet_ccd::grasp;
using reference::Random;

/// Contacts all over a lumpy ball of 5 cm, a weight, twelve joints of 2 N m.
ForceProblem problemOf(int contacts, Random& random)
{
    ForceProblem problem;
    for (int i = 0; i < contacts; ++i)
    {
        const Eigen::Vector3d out = random.direction();
        problem.contacts.push_back(
            {.link = i, .point = 0.05 * out, .normal = (random.inBox(0.35) - out).normalized()});
    }
    problem.load << 0.0, 0.0, -5.0, 0.0, 0.0, 0.0;
    problem.jacobian.resize(12 * problem.contacts.size());
    for (Twist& twist : problem.jacobian)
    {
        for (double& entry : twist)
        {
            entry = random.uniform(-0.05, 0.05);
        }
    }
    problem.torqueLimits.assign(12, 2.0);
    return problem;
}

/// Problems that have an answer, by either solver; the cone's is no worse than the pyramid's.
std::vector<ForceProblem> solvableProblems(int contacts, std::size_t count, std::uint64_t seed)
{
    Random random(seed);
    std::vector<ForceProblem> problems;
    for (std::size_t attempt = 0; attempt < 100 * count && problems.size() < count; ++attempt)
    {
        ForceProblem problem = problemOf(contacts, random);
        const GraspForces cone = solveGraspForces(problem);
        const GraspForces pyramid =
            solveGraspForces(problem, {.solver = ForceSolver::LinearProgram, .coneEdges = 8});
        if (pyramid.status == ForceStatus::Balanced && cone.status == ForceStatus::Balanced &&
            cone.value <= pyramid.value * (1.0 + 1e-7))
        {
            problems.push_back(std::move(problem));
        }
    }
    return problems;
}

struct Method
{
    const char* name;
    ForceSolver solver;
    ForceObjective objective;
};
constexpr std::array<Method, 4> kMethods{
    {{"cone_total", ForceSolver::Cone, ForceObjective::Total},
     {"cone_firm", ForceSolver::Cone, ForceObjective::Firm},
     {"lp_total", ForceSolver::LinearProgram, ForceObjective::Total},
     {"lp_firm", ForceSolver::LinearProgram, ForceObjective::Firm}}};

/// False if there is no problem to time.
bool run(const std::vector<int>& contacts, int problemCount, std::uint64_t seed, int repeats)
{
    const Table table("contacts:>8|method:<12|us:>9.1f|iterations:>10.1f|problems:>8");
    for (const int count : contacts)
    {
        const std::vector<ForceProblem> problems =
            solvableProblems(count, static_cast<std::size_t>(problemCount), seed);
        std::vector<TimedMethod> timed;
        std::array<double, kMethods.size()> iterations{};
        for (std::size_t m = 0; m < kMethods.size(); ++m)
        {
            const ForceOptions options{
                .objective = kMethods[m].objective, .solver = kMethods[m].solver, .coneEdges = 8};
            const auto ask = [&, options, m](std::size_t i)
            { iterations[m] += solveGraspForces(problems[i], options).iterations; };
            timed.push_back({.queries = problems.size(), .passes = repeats, .ask = ask});
        }
        const std::vector<std::vector<double>> micros = timeInTurns(timed);
        for (std::size_t m = 0; m < kMethods.size() && !problems.empty(); ++m)
        {
            const double asked = repeats * static_cast<double>(problems.size());
            table.print({{"contacts", count},
                         {"method", kMethods[m].name},
                         {"us", meanOf(micros[m])},
                         {"iterations", iterations[m] / asked},
                         {"problems", problems.size()}});
        }
        if (problems.empty())
        {
            return false;
        }
    }
    return true;
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    using namespace bullet_ccd::benchmarks;
    std::vector<int> contacts{4, 6, 8, 12, 16};
    int problems = 50;
    int repeats = 11;
    std::uint64_t seed = 1;
    return runProgram(argc,
                      argv,
                      {.name = "bench_forces",
                       .about = "Contact forces by exact cones and by linear program",
                       .options = {{"--contacts", &contacts, "numbers of contacts"},
                                   {"-n,--problems", &problems, "of each number of contacts"},
                                   {"--repeats", &repeats, "the median counts"},
                                   {"--seed", &seed, "of the problems"}},
                       .run = [&] { return run(contacts, problems, seed, repeats); }});
}
