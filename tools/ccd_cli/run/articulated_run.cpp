#include "tools/ccd_cli/run/articulated_run.h"

#include "bullet_ccd/toi/articulated/body_boxes.h"
#include "tools/ccd_cli/run/query_run.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace bullet_ccd::tools
{
namespace
{
template <typename Function>
double microsecondsOf(const Function& function)
{
    const auto start = std::chrono::steady_clock::now();
    function();
    const std::chrono::duration<double, std::micro> elapsed =
        std::chrono::steady_clock::now() - start;
    return elapsed.count();
}
}  // namespace

void addSweptBoxes(const RobotLinks& links,
                   const JointMotion& motion,
                   double reach,
                   std::vector<Eigen::AlignedBox3d>& boxes)
{
    constexpr int kParts = 4;  // a box over a long way is wide
    MovingFrames frames;
    frames.reset(links.robot.tree, motion);
    FrameSweep sweep;
    for (int part = 0; part < kParts; ++part)
    {
        sweep.reset(frames, 0, static_cast<double>(part) / kParts, (part + 1.0) / kParts);
        for (std::size_t link = 0; link < links.linkTrees.size(); ++link)
        {
            if (links.linkTrees[link] == nullptr)
            {
                continue;
            }
            const LinkPlace& place = frames.place(static_cast<std::int32_t>(link));
            OrientedBox box = rootBox(*links.linkTrees[link]);
            box.center = place.X_FL * box.center;
            box.axes = place.X_FL.linear() * box.axes;
            const Eigen::AlignedBox3d swept = sweep.boxOver(place.frame, box).box;
            const Eigen::Vector3d wider = Eigen::Vector3d::Constant(reach);
            boxes.emplace_back(swept.min() - wider, swept.max() + wider);
        }
    }
}

std::vector<ArticulatedAnswer> runArticulated(const RobotLinks& links,
                                              std::span<const RigidBody> obstacles,
                                              std::span<const ArticulatedQuery> queries,
                                              const ToiOptions& options,
                                              int repeat,
                                              const std::function<bool(std::size_t)>& goOn)
{
    const Environment environment(obstacles);
    ToiWorkspace work;
    std::vector<ArticulatedAnswer> answers(queries.size());
    std::vector<std::vector<double>> times(queries.size());
    ArticulatedToiResult result;
    const auto answer = [&](std::size_t k) {
        result = articulatedToi(links.body(queries[k].motion), environment, {.toi = options}, work);
    };
    if (!queries.empty())
    {
        answer(0);
    }
    const std::size_t total = queries.size() * static_cast<std::size_t>(repeat);
    std::size_t done = 0;
    std::size_t known = 0;
    for (bool isWanted = true; isWanted && done < total;)
    {
        const std::size_t k = done % queries.size();
        const double microseconds = microsecondsOf([&] { answer(k); });
        isWanted = result.status != ToiStatus::Stopped;
        if (done < queries.size())
        {
            known = done + 1;
            answers[k].result = std::move(result);
        }
        if (isWanted)
        {
            times[k].push_back(microseconds);
            isWanted = goOn(++done);
        }
    }
    answers.resize(known);
    for (std::size_t k = 0; k < answers.size(); ++k)
    {
        answers[k].microseconds = quantile(times[k], 0.5);
    }
    return answers;
}

SequenceAnswer runSequence(const RobotLinks& links,
                           std::span<const RigidBody> obstacles,
                           const JointMotion& motion,
                           const ContactSequenceOptions& options)
{
    ToiWorkspace work;
    SequenceAnswer answer;
    for (int pass = 0; pass < 2; ++pass)  // the first warms the workspace
    {
        answer.microseconds = microsecondsOf(
            [&] {
                answer.sequence = articulatedContacts(links.body(motion), obstacles, options, work);
            });
    }
    return answer;
}
}  // namespace bullet_ccd::tools
