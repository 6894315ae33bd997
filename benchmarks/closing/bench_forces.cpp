/// Microseconds to find contact forces, by exact cones and by linear program, over the number of
/// contacts; answers are checked before they are timed.
#include "grasp/force/grasp_forces.h"

#include <Eigen/Geometry>
#include <benchmark/benchmark.h>

#include <random>

namespace
{
using namespace bullet_ccd::grasp;

Eigen::Vector3d randomVector(std::mt19937& random)
{
    std::normal_distribution<double> normal;
    return {normal(random), normal(random), normal(random)};
}

/// Contacts all over a lumpy ball of 5 cm, a weight, twelve joints of 2 N m.
ForceProblem problemOf(int contacts, std::mt19937& random)
{
    ForceProblem problem;
    for (int i = 0; i < contacts; ++i)
    {
        const Eigen::Vector3d out = randomVector(random).normalized();
        problem.contacts.push_back({.link = i,
                                    .point = 0.05 * out,
                                    .normal = (0.2 * randomVector(random) - out).normalized()});
    }
    problem.load << 0.0, 0.0, -5.0, 0.0, 0.0, 0.0;
    problem.jacobian.resize(12 * problem.contacts.size());
    for (Twist& twist : problem.jacobian)
    {
        for (double& entry : twist)
        {
            entry = 0.03 * randomVector(random).x();
        }
    }
    problem.torqueLimits.assign(12, 2.0);
    return problem;
}

/// Problems that have an answer, by either solver.
std::vector<ForceProblem> solvableProblems(int contacts)
{
    constexpr int kCount = 50;
    std::mt19937 random(1);
    std::vector<ForceProblem> problems;
    for (int attempt = 0; attempt < 100 * kCount && problems.size() < kCount; ++attempt)
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

void forces(benchmark::State& state, ForceSolver solver, ForceObjective objective)
{
    const std::vector<ForceProblem> problems = solvableProblems(static_cast<int>(state.range(0)));
    if (problems.empty())
    {
        state.SkipWithError("no problem has an answer");
        return;
    }
    std::size_t next = 0;
    double iterations = 0.0;
    for (auto _ : state)
    {
        const GraspForces answer =
            solveGraspForces(problems[next++ % problems.size()],
                             {.objective = objective, .solver = solver, .coneEdges = 8});
        iterations += answer.iterations;
        benchmark::DoNotOptimize(answer.value);
    }
    state.counters["iterations"] =
        benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
    state.counters["problems"] = static_cast<double>(problems.size());
}

void contacts(benchmark::internal::Benchmark* benchmark)
{
    for (const int count : {4, 6, 8, 12, 16})
    {
        benchmark->Arg(count);
    }
    benchmark->Unit(benchmark::kMicrosecond);
}
}  // namespace

BENCHMARK_CAPTURE(forces, cone_total, ForceSolver::Cone, ForceObjective::Total)->Apply(contacts);
BENCHMARK_CAPTURE(forces, cone_firm, ForceSolver::Cone, ForceObjective::Firm)->Apply(contacts);
BENCHMARK_CAPTURE(forces, lp_total, ForceSolver::LinearProgram, ForceObjective::Total)
    ->Apply(contacts);
BENCHMARK_CAPTURE(forces, lp_firm, ForceSolver::LinearProgram, ForceObjective::Firm)
    ->Apply(contacts);
BENCHMARK_MAIN();
