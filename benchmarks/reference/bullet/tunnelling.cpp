#include "benchmarks/reference/bullet/tunnelling.h"

#include <iterator>
#include <utility>

namespace bullet_ccd::reference
{
namespace
{
/// The path has a corner at every impact.
class CornerRecorder : public btCcdImpactListener
{
public:
    explicit CornerRecorder(PathJudge& judge) : m_judge(&judge) {}

    btCcdAfterImpact onImpact(const btCcdImpact& impact) override
    {
        m_judge->record(double(impact.m_time), false);
        return btCcdAfterImpact::Solve;
    }

private:
    PathJudge* m_judge;
};
}  // namespace

RunOutcome watchRun(Scene& scene, Kind kind, Watched watched, const Run& run)
{
    PathJudge judge(std::move(watched));
    judge.measureDistance(isOurs(kind));
    judge.expectWholeTurns(kind == Kind::World);  // its steps are integrated in pieces
    CornerRecorder recorder(judge);
    // An action tells of impacts after it has answered: the path has no corners then.
    if (kind == Kind::World)
    {
        scene.ccd().setCcdImpactListener(&recorder);
    }
    const double start = run.uniform ? run.uniform->read() : 0.0;
    RunOutcome outcome;
    for (int i = 0; i < run.steps && !judge.isThrough(); ++i)
    {
        if (run.beforeStep)
        {
            run.beforeStep();
            judge.recordContacts(run.timeStep);
        }
        scene.step(run.timeStep);
        judge.record(run.timeStep, true);
        outcome.simulated += run.timeStep;
    }
    outcome.through = judge.isThrough();
    outcome.closest = isOurs(kind) ? judge.closest() : 0.0;
    outcome.lost = scene.lostTime();
    if (run.uniform)
    {
        outcome.lag = outcome.simulated - (run.uniform->read() - start) / run.uniform->speed;
    }
    if (kind == Kind::World)
    {
        scene.ccd().setCcdImpactListener(nullptr);
    }
    return outcome;
}

std::vector<TunnellingRow> tunnellingRows()
{
    std::vector<TunnellingRow> rows = linkRows();
    std::vector<TunnellingRow> bodies = bodyRows();
    rows.insert(
        rows.end(), std::make_move_iterator(bodies.begin()), std::make_move_iterator(bodies.end()));
    return rows;
}
}  // namespace bullet_ccd::reference
