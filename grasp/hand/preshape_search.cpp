#include "grasp/hand/preshape_search.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/motion/kinematic_tree.h"
#include "grasp/hand/hand_inference.h"
#include "grasp/hand/self_pairs.h"
#include "grasp/hand/trial_grasps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <tbb/parallel_for.h>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
/// A body to be taken in a certain way.
struct Task
{
    const char* name;  ///< of a preshape that is best at it
    TrialBody body;
    Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< aside of the grasp frame's z axis [m]
    double turn = 0.0;                             ///< about it [rad]
    double tilt = 0.0;                             ///< about x [rad]

    /// Of the body in the grasp frame.
    [[nodiscard]] Eigen::Isometry3d pose() const
    {
        Eigen::Isometry3d X_GB = Eigen::Isometry3d::Identity();
        X_GB.linear() = (Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix();
        X_GB.translation() = at;
        return X_GB;
    }
};

/// Every body as the hand would have it, then as it comes.
std::vector<Task> makeTasks(bool isCoupled, bool isForChoice)
{
    const std::array<std::pair<const char*, TrialBody>, 7> bodies{{
        {"wrap", {.half = {0.0, 0.06, 0.0}, .round = 0.03}},
        {"precision", {.half = Eigen::Vector3d::Zero(), .round = 0.02}},
        {"spread", {.half = Eigen::Vector3d::Zero(), .round = 0.037}},
        {"spread", {.half = {0.02, 0.04, 0.04}, .round = 0.004}},
        {"lateral", {.half = {0.006, 0.05, 0.03}, .round = 0.004}},
        {"precision", {.half = {0.0, 0.0, 0.05}, .round = 0.027}},
        {"spread", {.half = {0.026, 0.075, 0.05}, .round = 0.004}},
    }};
    struct Change
    {
        double x, y, turn, tilt;
    };
    constexpr std::array<Change, 8> kChanges{{{0.0, 0.0, 0.0, 0.0},
                                              {0.01, -0.012, 0.2, 0.3},
                                              {-0.01, 0.012, -0.2, -0.3},
                                              {0.005, 0.02, 0.35, -0.15},
                                              {0.0, 0.008, -0.1, 0.15},
                                              {-0.006, -0.015, 0.3, -0.2},
                                              {0.012, 0.005, -0.3, 0.1},
                                              {-0.012, -0.004, 0.1, 0.4}}};
    std::vector<Task> tasks;
    for (std::size_t k = isForChoice ? kChanges.size() / 2 : 0;
         k < (isForChoice ? kChanges.size() : kChanges.size() / 2);
         ++k)
    {
        const Change& change = kChanges[k];
        for (const auto& [name, body] : bodies)
        {
            // Coupled jaws get to centre themselves, and are laid flat on what they close on.
            tasks.push_back({.name = name,
                             .body = body,
                             .at = {isCoupled ? 0.0 : change.x, change.y, 0.0},
                             .turn = isCoupled ? 0.0 : change.turn,
                             .tilt = change.tilt});
        }
    }
    return tasks;
}

constexpr std::array<std::size_t, 4> kFewTasks{0, 2, 3, 5};

struct Posture
{
    std::vector<double> free{};       ///< one a searched joint [rad or m]
    double bend = 0.0;                ///< part of the way from open to closed
    std::vector<double> positions{};  ///< in place of both, one a link; empty: they are searched
    Eigen::Isometry3d X_RG = Eigen::Isometry3d::Identity();
    double score = 0.0;
    std::vector<double> scores{};  ///< one a task
};

class PreshapeSearch
{
public:
    PreshapeSearch(const HandModel& hand, const std::optional<Eigen::Isometry3d>& frame)
        : m_hand(hand),
          m_frame(frame),
          m_open(inferPreshape(hand).positions),
          m_closed(closedPositions(hand, m_open)),
          m_trials(hand),
          m_tasks(makeTasks(fingersAreCoupled(hand), false)),
          m_others(makeTasks(fingersAreCoupled(hand), true))
    {
        const KinematicTree& tree = hand.robot.tree;
        for (std::size_t i = 1; i < tree.size(); ++i)
        {
            const auto link = static_cast<std::int32_t>(i);
            const Joint& joint = tree.links[i].joint;
            if (hand.closingDirections[i] == 0 && joint.mimicOf == kNone &&
                (joint.type == JointType::Revolute || joint.type == JointType::Prismatic) &&
                joint.upper > joint.lower && link != hand.palm &&
                isAncestorOrSelf(tree, hand.palm, link))
            {
                m_joints.push_back(i);
            }
        }
    }

    /// Best first.
    [[nodiscard]] std::vector<Posture> run() const
    {
        std::vector<Posture> begun = sample();
        std::stable_sort(begun.begin(),
                         begun.end(),
                         [](const Posture& a, const Posture& b) { return a.score > b.score; });
        begun = distinct(begun, kStarts);
        tbb::parallel_for(std::size_t{0},
                          begun.size(),
                          [&](std::size_t k)
                          {
                              Posture& posture = begun[k];
                              judge(posture, m_tasks);
                              refine(posture);
                              judge(posture, m_others);
                          });
        std::stable_sort(begun.begin(),
                         begun.end(),
                         [](const Posture& a, const Posture& b) { return a.score > b.score; });
        return begun;
    }

    [[nodiscard]] Preshape preshapeOf(const Posture& posture, const std::string& name) const
    {
        return {.name = name,
                .positions = positionsOf(posture),
                .X_RG = m_frame ? std::nullopt : std::optional(posture.X_RG)};
    }

    [[nodiscard]] bool hasJoints() const { return !m_joints.empty(); }
    [[nodiscard]] const std::vector<std::size_t>& joints() const { return m_joints; }
    /// That the scores of the postures of run() are about.
    [[nodiscard]] const std::vector<Task>& tasks() const { return m_others; }
    /// The best frame of a posture that is known.
    [[nodiscard]] Eigen::Isometry3d frameOf(const std::vector<double>& positions) const
    {
        Posture posture{.positions = positions, .X_RG = inferGraspFrame(m_hand, positions)};
        judge(posture, m_tasks);
        refine(posture);
        return posture.X_RG;
    }

private:
    [[nodiscard]] const Joint& joint(std::size_t k) const
    {
        return m_hand.robot.tree.links[m_joints[k]].joint;
    }
    [[nodiscard]] double lower(std::size_t k) const
    {
        return std::isfinite(joint(k).lower) ? joint(k).lower : -std::numbers::pi;
    }
    [[nodiscard]] double upper(std::size_t k) const
    {
        return std::isfinite(joint(k).upper) ? joint(k).upper : std::numbers::pi;
    }

    [[nodiscard]] std::vector<double> positionsOf(const Posture& posture) const
    {
        if (!posture.positions.empty())
        {
            return posture.positions;
        }
        std::vector<double> positions = m_open;
        for (std::size_t i = 0; i < positions.size(); ++i)
        {
            if (m_hand.closingDirections[i] != 0 && std::isfinite(m_closed[i]))
            {
                positions[i] += posture.bend * (m_closed[i] - m_open[i]);
            }
        }
        for (std::size_t k = 0; k < m_joints.size(); ++k)
        {
            positions[m_joints[k]] = posture.free[k];
        }
        applyMimics(m_hand.robot.tree, positions);
        return positions;
    }

    [[nodiscard]] double trial(const std::vector<double>& positions,
                               const Eigen::Isometry3d& X_RG,
                               const Task& task) const
    {
        return m_trials(positions, X_RG, task.body, task.pose());
    }

    void judge(Posture& posture, const std::vector<Task>& tasks) const
    {
        const std::vector<double> positions = positionsOf(posture);
        posture.scores.clear();
        double sum = 0.0;
        for (const Task& task : tasks)
        {
            posture.scores.push_back(trial(positions, posture.X_RG, task));
            sum += posture.scores.back();
        }
        posture.score = sum / static_cast<double>(tasks.size());
    }

    /// Judges `next` if it is better than `best`; what is hardest is tried first, to know soon.
    [[nodiscard]] bool improves(Posture& next, const Posture& best) const
    {
        constexpr double kLeast = 1e-6;
        const std::vector<double> positions = positionsOf(next);
        std::vector<std::size_t> order(m_tasks.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::ranges::stable_sort(
            order, [&](std::size_t a, std::size_t b) { return best.scores[a] < best.scores[b]; });
        double left = static_cast<double>(m_tasks.size()) * (1.0 - best.score) - kLeast;
        next.scores.assign(m_tasks.size(), 0.0);
        for (const std::size_t task : order)
        {
            next.scores[task] = trial(positions, next.X_RG, m_tasks[task]);
            left -= 1.0 - next.scores[task];
            if (left <= 0.0)
            {
                return false;
            }
        }
        next.score = std::accumulate(next.scores.begin(), next.scores.end(), 0.0) /
                     static_cast<double>(next.scores.size());
        return true;
    }

    /// By few tasks and the best of some frames.
    void glance(Posture& posture) const
    {
        const std::vector<double> positions = positionsOf(posture);
        const Eigen::Isometry3d X_RG = m_frame ? *m_frame : inferGraspFrame(m_hand, positions);
        posture.score = -1.0;
        for (const double tilt : {0.0, 0.5, -0.5})
        {
            const Eigen::Isometry3d tilted =
                X_RG * Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY());
            double score = 0.0;
            for (const std::size_t task : kFewTasks)
            {
                score += trial(positions, tilted, m_tasks[task]) / kFewTasks.size();
            }
            if (score > posture.score)
            {
                posture.score = score;
                posture.X_RG = tilted;
            }
            if (m_frame)
            {
                break;
            }
        }
    }

    /// All at rest; the joints of each finger on a grid; all at random.
    [[nodiscard]] std::vector<Posture> sample() const
    {
        Posture rest;
        for (const std::size_t i : m_joints)
        {
            rest.free.push_back(m_open[i]);
        }
        std::vector<Posture> postures{rest};
        for (const std::vector<std::size_t>& group : groups())
        {
            const int values = group.size() == 1   ? 9
                               : group.size() == 2 ? 5
                               : group.size() == 3 ? 4
                                                   : 3;
            const auto count =
                static_cast<int>(std::pow(values, std::min<std::size_t>(group.size(), 4)));
            for (int k = 0; k < count; ++k)
            {
                Posture posture = rest;
                int digits = k;
                for (std::size_t j = 0; j < std::min<std::size_t>(group.size(), 4); ++j)
                {
                    const std::size_t at = group[j];
                    posture.free[at] =
                        lower(at) + (upper(at) - lower(at)) * (digits % values) / (values - 1);
                    digits /= values;
                }
                postures.push_back(std::move(posture));
            }
        }
        std::mt19937_64 random(3);
        const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
        for (int k = 0; k < kRandomPostures; ++k)
        {
            Posture posture = rest;
            for (std::size_t j = 0; j < m_joints.size(); ++j)
            {
                const double u = unit();
                posture.free[j] =
                    unit() < 0.5 ? posture.free[j] : lower(j) + u * (upper(j) - lower(j));
            }
            postures.push_back(std::move(posture));
        }
        tbb::parallel_for(
            std::size_t{0}, postures.size(), [&](std::size_t k) { glance(postures[k]); });
        return postures;
    }

    /// Indices into m_joints of the joints of each finger, and of those of none.
    [[nodiscard]] std::vector<std::vector<std::size_t>> groups() const
    {
        std::vector<std::vector<std::size_t>> groups(m_hand.fingers.size() + 1);
        for (std::size_t k = 0; k < m_joints.size(); ++k)
        {
            std::size_t finger = 0;
            while (finger < m_hand.fingers.size() &&
                   std::ranges::find(m_hand.fingers[finger].links,
                                     static_cast<std::int32_t>(m_joints[k])) ==
                       m_hand.fingers[finger].links.end())
            {
                ++finger;
            }
            groups[finger].push_back(k);
        }
        std::erase_if(groups, [](const auto& group) { return group.empty(); });
        return groups;
    }

    /// Largest difference of a joint, as a part of its range.
    [[nodiscard]] double difference(const Posture& a, const Posture& b) const
    {
        double largest = std::abs(a.bend - b.bend);
        for (std::size_t k = 0; k < m_joints.size(); ++k)
        {
            largest = std::max(largest, std::abs(a.free[k] - b.free[k]) / (upper(k) - lower(k)));
        }
        return largest;
    }

    [[nodiscard]] std::vector<Posture> distinct(const std::vector<Posture>& postures,
                                                std::size_t count) const
    {
        std::vector<Posture> kept;
        for (const Posture& posture : postures)
        {
            const bool isNew = std::ranges::all_of(
                kept, [&](const Posture& other) { return difference(posture, other) > 0.15; });
            if (isNew && kept.size() < count && !overlapsItself(posture))
            {
                kept.push_back(posture);
            }
        }
        return kept;
    }

    /// Moves one coordinate at a time, with steps that shrink.
    void refine(Posture& posture) const
    {
        const std::size_t joints = posture.positions.empty() ? m_joints.size() + 1 : 0;
        const std::size_t frames = m_frame ? 0 : 6;
        double scale = 1.0;
        for (int round = 0; round < kRounds; ++round)
        {
            for (std::size_t k = 0; k < joints + frames; ++k)
            {
                for (const double sign : {1.0, -1.0})
                {
                    Posture next = posture;
                    if (k < joints)
                    {
                        step(next, k, sign * scale);
                    }
                    else
                    {
                        move(next, static_cast<int>(k - joints), sign * scale);
                    }
                    if (improves(next, posture) && (k >= joints || !overlapsItself(next)))
                    {
                        posture = std::move(next);
                        break;
                    }
                }
            }
            scale *= 0.6;
        }
    }

    void step(Posture& posture, std::size_t k, double scale) const
    {
        if (k == m_joints.size())
        {
            posture.bend = std::clamp(posture.bend + 0.12 * scale, 0.0, 0.45);
            return;
        }
        posture.free[k] =
            std::clamp(posture.free[k] + scale * (upper(k) - lower(k)) / 6.0, lower(k), upper(k));
    }

    static void move(Posture& posture, int k, double scale)
    {
        if (k < 3)
        {
            posture.X_RG = posture.X_RG * Eigen::AngleAxisd(0.3 * scale, Eigen::Vector3d::Unit(k));
            return;
        }
        posture.X_RG.translation() += 0.012 * scale * posture.X_RG.linear().col(k - 3);
    }

    [[nodiscard]] bool overlapsItself(const Posture& posture) const
    {
        return selfOverlaps(m_hand, positionsOf(posture), m_open);
    }

    static constexpr int kRandomPostures = 60;
    static constexpr int kRounds = 3;
    static constexpr std::size_t kStarts = 8;

    const HandModel& m_hand;
    std::optional<Eigen::Isometry3d> m_frame;
    std::vector<double> m_open;
    std::vector<double> m_closed;
    TrialGrasps m_trials;
    std::vector<Task> m_tasks;          // that postures are refined by
    std::vector<Task> m_others;         // that they are chosen by
    std::vector<std::size_t> m_joints;  // that are searched, as the links below them
};

/// Of the postures, those that add most to what is held already.
std::vector<std::size_t> choose(const std::vector<Posture>& postures)
{
    constexpr std::size_t kMost = 3;
    constexpr double kLeastGain = 0.015;  // of the mean score
    constexpr double kLeastShare = 0.94;  // of the best score
    std::vector<std::size_t> chosen{0};
    std::vector<double> held = postures[0].scores;
    while (chosen.size() < kMost)
    {
        double best = kLeastGain;
        std::optional<std::size_t> next;
        for (std::size_t k = 1; k < postures.size(); ++k)
        {
            double gain = 0.0;
            for (std::size_t t = 0; t < held.size(); ++t)
            {
                gain += std::max(0.0, postures[k].scores[t] - held[t]) /
                        static_cast<double>(held.size());
            }
            if (gain > best && postures[k].score > kLeastShare * postures[0].score)
            {
                best = gain;
                next = k;
            }
        }
        if (!next)
        {
            break;
        }
        chosen.push_back(*next);
        for (std::size_t t = 0; t < held.size(); ++t)
        {
            held[t] = std::max(held[t], postures[*next].scores[t]);
        }
    }
    return chosen;
}

/// Closing joints above that of the link that move by themselves, on the way to the root.
int leadersOf(const HandModel& hand, std::size_t link)
{
    const KinematicTree& tree = hand.robot.tree;
    int leaders = 0;
    for (std::int32_t above = tree.links[link].parent; above > 0;
         above = tree.links[static_cast<std::size_t>(above)].parent)
    {
        const auto i = static_cast<std::size_t>(above);
        leaders += hand.closingDirections[i] != 0 && tree.links[i].joint.mimicOf == kNone ? 1 : 0;
    }
    return leaders;
}

std::vector<double> speedsOf(const HandModel& hand, double ratio)
{
    std::vector<double> speeds(hand.robot.tree.size(), 1.0);
    for (std::size_t i = 1; i < speeds.size(); ++i)
    {
        if (hand.closingDirections[i] != 0 && hand.robot.tree.links[i].joint.mimicOf == kNone)
        {
            speeds[i] = std::pow(ratio, leadersOf(hand, i));
        }
    }
    return speeds;
}

/// By the tasks at which each is best among them; "open" if there is one only.
std::vector<std::string> nameAll(const std::vector<Posture>& postures,
                                 const std::vector<Task>& tasks)
{
    if (postures.size() == 1)
    {
        return {"open"};
    }
    std::vector<std::string> names;
    for (const Posture& posture : postures)
    {
        std::map<std::string, std::pair<double, int>> lead;  // over the mean, and of how many tasks
        for (std::size_t t = 0; t < tasks.size(); ++t)
        {
            double mean = 0.0;
            for (const Posture& other : postures)
            {
                mean += other.scores[t] / static_cast<double>(postures.size());
            }
            lead[tasks[t].name].first += posture.scores[t] - mean;
            ++lead[tasks[t].name].second;
        }
        std::string best;
        for (const auto& [name, sum] : lead)
        {
            const auto leadOf = [&](const std::string& its)
            { return lead[its].first / lead[its].second; };
            if (std::ranges::find(names, name) == names.end() &&
                (best.empty() || leadOf(name) > leadOf(best)))
            {
                best = name;
            }
        }
        names.push_back(best);
    }
    return names;
}
}  // namespace

std::optional<std::vector<Preshape>> searchPreshapes(const HandModel& hand,
                                                     const std::optional<Eigen::Isometry3d>& frame)
{
    const PreshapeSearch search(hand, frame);
    if (!search.hasJoints())
    {
        return std::nullopt;
    }
    const std::vector<Posture> found = search.run();
    if (found.empty())
    {
        return std::nullopt;
    }
    std::vector<Posture> chosen;
    for (const std::size_t k : choose(found))
    {
        chosen.push_back(found[k]);
    }
    const std::vector<std::string> names = nameAll(chosen, search.tasks());
    std::vector<Preshape> preshapes;
    for (std::size_t k = 0; k < chosen.size(); ++k)
    {
        preshapes.push_back(search.preshapeOf(chosen[k], names[k]));
    }
    return preshapes;
}

Eigen::Isometry3d searchGraspFrame(const HandModel& hand, const std::vector<double>& positions)
{
    const PreshapeSearch search(hand, std::nullopt);
    return search.hasJoints() ? search.frameOf(positions) : inferGraspFrame(hand, positions);
}

std::vector<double> searchClosingSpeeds(const HandModel& hand)
{
    constexpr std::array kRatios{1.0, 0.5, 0.25, 0.1};
    const std::vector<double> slowest = speedsOf(hand, kRatios.back());
    if (std::ranges::min(slowest) == 1.0)
    {
        return {};
    }
    const TrialGrasps trials(hand);
    const std::vector<Task> tasks = makeTasks(fingersAreCoupled(hand), true);
    std::array<double, kRatios.size()> scores{};
    tbb::parallel_for(std::size_t{0},
                      kRatios.size(),
                      [&](std::size_t k)
                      {
                          const std::vector<double> speeds = speedsOf(hand, kRatios[k]);
                          for (const Preshape& preshape : hand.preshapes)
                          {
                              for (const Task& task : tasks)
                              {
                                  scores[k] += trials(preshape.positions,
                                                      graspFrame(hand, preshape),
                                                      task.body,
                                                      task.pose(),
                                                      speeds);
                              }
                          }
                      });
    const auto best = static_cast<std::size_t>(std::ranges::max_element(scores) - scores.begin());
    return kRatios[best] == 1.0 ? std::vector<double>{} : speedsOf(hand, kRatios[best]);
}
}  // namespace bullet_ccd::grasp
