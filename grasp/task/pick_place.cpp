#include "grasp/task/pick_place.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"
#include "grasp/check/closed_surface.h"
#include "grasp/quality/stable_poses.h"
#include "grasp/task/firm_grasps.h"
#include "grasp/task/task_legs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using Path = std::vector<JointPositions>;
/// Poses of the object, put down: 0 in the middle of the target, else 1.
using Places = std::vector<std::pair<int, Isometry3d>>;

/// Postures of the arm that are tried for a pose of the hand.
constexpr int kPostures = 3;
/// Places of the object that are tried for a grasp.
constexpr std::size_t kPlaces = 8;
constexpr int kPlaceRestarts = 20;
/// Grasps that are tried again with the object put down on other faces, and places asked for then.
constexpr std::size_t kTriedOnOtherFaces = 10;
constexpr std::size_t kOtherPlacesAsked = 48;
/// An object that touches what it stands on is raised by no more than this [m].
constexpr double kLargestRaise = 3e-3;
/// So many times more grasps are planned if none of the first can be carried out.
constexpr std::int64_t kMoreGrasps = 3;
constexpr int kRounds = 4;
/// Times the margin that ways of the arm keep where there is room: arms do not follow exactly.
constexpr std::array kMargins{5.0, 2.5, 1.0};
/// Of the straight ways to and from the object, where there is no room for all of them.
constexpr std::array kShares{1.0, 0.5, 0.25};
/// What holds little far from its centre of mass may hold what is light: the squeeze decides.
constexpr double kLeastEpsilon = 1e-3;
/// Where candidates come from, as many of each.
constexpr std::array kSources{ApproachSource::Mixed, ApproachSource::Pinch};
/// The lowest point of an object that is put down is as near as this to the target's height [m].
constexpr double kSameHeight = 2e-3;

Isometry3d shifted(Isometry3d X, const Vector3d& by)
{
    X.translation() += by;
    return X;
}

double lowestOf(const GraspObject& object, const Isometry3d& X_WO)
{
    return lowestHeight(object.tree, X_WO, Vector3d::UnitZ());
}

/// True if a vertex of one body is inside the other, of which that is known for watertight ones.
bool isInside(const SsvTree& inner,
              const Isometry3d& X_W,
              const SsvTree& outer,
              const Isometry3d& X_WO)
{
    return isWatertight(outer.mesh()) &&
           ClosedSurface(outer.mesh())
               .contains(X_WO.inverse() * (X_W * inner.mesh().vertices.front()));
}

/// No point of a hand is farther from the origin of its root in any posture [m].
double sizeOf(const HandModel& hand)
{
    std::vector<double> farthest;  // origins of the links
    double size = 0.0;
    for (std::size_t i = 0; i < hand.robot.tree.size(); ++i)
    {
        const Link& link = hand.robot.tree.links[i];
        const bool slides = link.joint.type == JointType::Prismatic;
        farthest.push_back(link.parent == kNone ? 0.0
                                                : farthest[static_cast<std::size_t>(link.parent)] +
                                                      link.X_PL0.translation().norm() +
                                                      (slides ? std::max(std::abs(link.joint.lower),
                                                                         std::abs(link.joint.upper))
                                                              : 0.0));
        if (const SsvTree* tree = hand.linkTrees[i]; tree != nullptr)
        {
            size = std::max(size, farthest.back() + tree->origin().norm() + tree->radius());
        }
    }
    return size;
}

/// The same of an object and its centre of mass.
double sizeOf(const GraspObject& object)
{
    double size = 0.0;
    for (const Vector3d& vertex : object.tree.mesh().vertices)
    {
        size = std::max(size, (vertex - object.centerOfMass).norm());
    }
    return size;
}

std::string millimetres(double metres)
{
    return std::to_string(std::lround(1e3 * metres)) + " mm";
}

/// A leg cannot be: its name and why.
struct Obstruction
{
    std::string leg;
    std::string reason;
};

class PickPlacePlanner
{
public:
    PickPlacePlanner(const PickPlaceTask& task, PickPlaceOptions options)
        : m_task(task),
          m_options(std::move(options)),
          m_kinematics(task.robot.tree, task.robot.handRoot, task.X_WR),
          m_robot(task.robot)
    {
        for (std::size_t i = 0; i < task.obstacles.size(); ++i)
        {
            m_scene.add(
                *task.obstacles[i].tree, task.obstacles[i].motion.X_W0, task.obstacleNames[i]);
        }
        m_scene.finish();
    }

    PickPlacePlan run()
    {
        m_plan.X_WOStart = raised();
        constexpr double kDeep = 10.0;
        const FirstContactResult fall = fallOf(m_plan.X_WOStart, kDeep);
        m_plan.startHeight = fall.status == ToiStatus::Separated
                                 ? std::numeric_limits<double>::infinity()
                                 : kDeep * fall.time;
        m_before = m_scene;
        m_before.add(m_task.object.tree, m_plan.X_WOStart, m_task.object.name);
        m_before.finish();
        m_places = &m_asItStood;
        findPlaces({Eigen::Matrix3d::Identity()}, m_asItStood);
        if (m_asItStood.empty())
        {
            findOtherPlaces();
            m_places = &m_onOtherFaces;
        }
        if (m_places->empty())
        {
            m_plan.failure = m_isAboveSomething
                                 ? "there is no room for " + m_task.object.name +
                                       " in the target region at any turn that was tried"
                                 : "there is nothing below the target region that " +
                                       m_task.object.name + " could stand on";
            return std::move(m_plan);
        }
        requireFreeStart();
        m_plan.failure = outOfReach();
        if (!m_plan.failure.empty())
        {
            return std::move(m_plan);
        }
        int tried = 0;
        std::array<std::vector<Grasp>, kSources.size()> known;
        std::int64_t candidates = m_options.grasps.candidates;
        for (int round = 0; round < kRounds && tried < m_options.graspsTried && !isStopped();
             ++round, candidates *= kMoreGrasps)
        {
            std::vector<Grasp> fresh;
            for (std::size_t i = 0; i < kSources.size(); ++i)
            {
                const std::int64_t before = std::ssize(known[i]);
                known[i] = graspsOfObject(kSources[i], candidates, known[i]);
                for (const Grasp& grasp : known[i])
                {
                    if (grasp.candidate >= before)
                    {
                        fresh.push_back(grasp);
                        fresh.back().candidate = numberOf(grasp, i);
                    }
                }
            }
            m_plan.forceClosures = 0;
            for (const std::vector<Grasp>& grasps : known)
            {
                m_plan.forceClosures += std::ranges::count_if(
                    grasps, [](const Grasp& grasp) { return grasp.quality.forceClosure; });
            }
            std::vector<Grasp> lifted;  // but not put down
            for (const Grasp& grasp :
                 firmGrasps(m_task.hand,
                            m_task.object,
                            m_inObject,
                            fresh,
                            m_options,
                            [this](const Grasp& grasp) { return arrives(grasp); }))
            {
                if (tried == m_options.graspsTried || isStopped())
                {
                    break;
                }
                ++tried;
                if (tryGrasp(grasp))
                {
                    m_plan.solved = true;
                    return std::move(m_plan);
                }
                if (isAfterLift(m_plan.attempts.back().leg))
                {
                    lifted.push_back(grasp);
                }
            }
            if (tryOnOtherFaces(lifted))
            {
                m_plan.solved = true;
                return std::move(m_plan);
            }
        }
        m_plan.stopped = isStopped();
        m_plan.failure =
            m_plan.stopped ? "stopped after " + std::to_string(tried) + " grasps"
            : tried > 0    ? "none of the grasps that were tried (" + std::to_string(tried) +
                              ") can be carried out"
            : m_plan.forceClosures == 0
                ? "no grasp of " + m_task.object.name +
                      " is a force closure that is clear of its surroundings"
                : "no grasp of " + m_task.object.name +
                      " to which the arm comes holds it firmly and keeps the margin to all else";
        return std::move(m_plan);
    }

private:
    [[nodiscard]] bool isStopped() const { return m_options.stop.isDue(); }

    /// Clear of all obstacles by the gap, or refused.
    Isometry3d raised()
    {
        const SsvTree& tree = m_task.object.tree;
        Isometry3d X_WO = m_task.X_WO;
        for (;;)
        {
            double missing = 0.0;
            std::string near;
            for (std::size_t i = 0; i < m_scene.bodies.size(); ++i)
            {
                const double distance = treeDistance(tree,
                                                     *m_scene.bodies[i].tree,
                                                     m_scene.bodies[i].motion.X_W0.inverse() * X_WO,
                                                     m_options.gap)
                                            .distance;
                if (m_options.gap - distance > missing)
                {
                    missing = m_options.gap - distance;
                    near = m_scene.names[i];
                }
            }
            if (missing <= 0.0)
            {
                requireOutside(X_WO);
                return X_WO;
            }
            X_WO.translation().z() += std::max(missing, 1e-6);
            require(X_WO.translation().z() - m_task.X_WO.translation().z() < kLargestRaise,
                    "pick and place: " + m_task.object.name + " intersects " + near +
                        " where it starts, deeper than can be mended by raising it by 3 mm: "
                        "correct its pose");
        }
    }

    void requireOutside(const Isometry3d& X_WO) const
    {
        const std::size_t i = whatItIsInside(X_WO);
        require(i == m_scene.bodies.size(),
                "pick and place: " + m_task.object.name + " is inside " +
                    (i < m_scene.names.size() ? m_scene.names[i] : std::string()) +
                    " where it starts: correct its pose");
    }

    /// The obstacle that the object is inside of, or that is inside of it; their number if none is.
    [[nodiscard]] std::size_t whatItIsInside(const Isometry3d& X_WO) const
    {
        const SsvTree& tree = m_task.object.tree;
        const auto found = std::ranges::find_if(m_scene.bodies,
                                                [&](const RigidBody& body)
                                                {
                                                    const Isometry3d& X_WB = body.motion.X_W0;
                                                    return isInside(tree, X_WO, *body.tree, X_WB) ||
                                                           isInside(*body.tree, X_WB, tree, X_WO);
                                                });
        return static_cast<std::size_t>(found - m_scene.bodies.begin());
    }

    static bool isAfterLift(const std::string& leg)
    {
        constexpr std::array<const char*, 5> kAfter{"carry", "place", "open", "retreat", "return"};
        return std::ranges::find(kAfter, leg) != kAfter.end();
    }

    /// Those of `lifted` that hold most, put down on other faces.
    bool tryOnOtherFaces(const std::vector<Grasp>& lifted)
    {
        if (m_places == &m_onOtherFaces || lifted.empty())
        {
            return false;
        }
        findOtherPlaces();
        if (m_onOtherFaces.empty())
        {
            return false;
        }
        m_places = &m_onOtherFaces;
        const std::size_t count = std::min(lifted.size(), kTriedOnOtherFaces);
        bool isSolved = false;
        for (std::size_t i = 0; i < count && !isSolved && !isStopped(); ++i)
        {
            isSolved = tryGrasp(lifted[i]);
        }
        m_places = &m_asItStood;
        return isSolved;
    }

    /// Once: places on all faces but the one on which the object stands.
    void findOtherPlaces()
    {
        if (!m_options.placesOnOtherFaces || m_hasOtherPlaces)
        {
            return;
        }
        m_hasOtherPlaces = true;
        constexpr double kSameFace = 0.9986;  // cosine of 3 degrees
        std::vector<Eigen::Matrix3d> turns;
        for (const StablePose& pose : stablePoses(m_task.object))
        {
            const Vector3d down = m_plan.X_WOStart.linear() * pose.down;
            if (-down.z() < kSameFace)
            {
                turns.push_back(Eigen::Quaterniond::FromTwoVectors(down, -Vector3d::UnitZ())
                                    .toRotationMatrix());
            }
        }
        findPlaces(turns, m_onOtherFaces);
    }

    /// Poses in the target, turned from how it stands by one of `faces` and about the vertical, put
    /// down until the gap.
    void findPlaces(const std::vector<Eigen::Matrix3d>& faces, Places& places)
    {
        constexpr std::array kAside{0.0, -0.7, 0.7};
        constexpr int kTurns = 8;
        const Vector3d& center = m_task.target.center;
        for (const double x : kAside)
        {
            for (const double y : kAside)
            {
                for (int turn = 0; turn < kTurns; ++turn)
                {
                    for (const Eigen::Matrix3d& face : faces)
                    {
                        Isometry3d X_WO = m_plan.X_WOStart;
                        const Eigen::AngleAxisd yaw(turn * 2.0 * std::numbers::pi / kTurns,
                                                    Vector3d::UnitZ());
                        X_WO.linear() = yaw.toRotationMatrix() * face * X_WO.linear();
                        const Vector3d aside(0.5 * x * m_task.target.size.x(),
                                             0.5 * y * m_task.target.size.y(),
                                             0.0);
                        X_WO.translation() += center + aside - X_WO * m_task.object.centerOfMass;
                        X_WO.translation().z() +=
                            center.z() + kPutDown - lowestOf(m_task.object, X_WO);
                        addPlace(X_WO, places);
                    }
                }
            }
        }
        // The middle first with all of its turns, then the others turn by turn.
        std::ranges::stable_sort(places, {}, &Places::value_type::first);
    }

    /// First contact of the object, kept off by the gap, with the scene on its way straight down.
    FirstContactResult fallOf(const Isometry3d& X_WO, double depth)
    {
        std::vector<MovingBody> bodies{movingBody(
            RigidBody{.tree = &m_task.object.tree,
                      .motion = motionBetween(X_WO, shifted(X_WO, {0.0, 0.0, -depth}))})};
        std::vector<BodyPair> pairs;
        for (const RigidBody& body : m_scene.bodies)
        {
            pairs.push_back({.bodyA = 0, .bodyB = static_cast<std::int32_t>(bodies.size())});
            bodies.push_back(movingBody(body));
        }
        return pairs.empty() ? FirstContactResult()
                             : firstContact(bodies,
                                            pairs,
                                            {.tolerance = 0.1 * m_options.gap,
                                             .minimumSeparation = m_options.gap},
                                            m_work);
    }

    /// Why no posture of the arm brings the hand to the object, or to the target; or nothing.
    [[nodiscard]] std::string outOfReach() const
    {
        const double size = sizeOf(m_task.object);
        const double reach = m_kinematics.reach() + sizeOf(m_task.hand);
        const auto missing = [&](const std::string& what, const Vector3d& where, double extent)
        {
            const double distance = (where - m_kinematics.shoulder()).norm();
            return distance <= reach + extent
                       ? std::string()
                       : what + " is out of reach: it is " + millimetres(distance) +
                             " from the first joint of the arm, which comes to " +
                             millimetres(reach) + " with its hand: move it or the robot";
        };
        std::string why =
            missing(m_task.object.name, m_task.X_WO * m_task.object.centerOfMass, size);
        return !why.empty() ? why
                            : missing("the target region",
                                      m_task.target.center,
                                      0.5 * m_task.target.size.norm() + 2.0 * size);
    }

    void addPlace(Isometry3d X_WO, Places& places)
    {
        const FirstContactResult toi = fallOf(X_WO, 2.0 * kPutDown);
        X_WO.translation().z() -= 2.0 * kPutDown * toi.time;
        m_isAboveSomething = m_isAboveSomething || toi.status != ToiStatus::Separated;
        if (toi.status == ToiStatus::Hit &&
            std::abs(lowestOf(m_task.object, X_WO) - m_task.target.center.z()) < kSameHeight &&
            whatItIsInside(X_WO) == m_scene.bodies.size())
        {
            const double off =
                (X_WO * m_task.object.centerOfMass - m_task.target.center).head<2>().norm();
            places.emplace_back(off > 1e-9 ? 1 : 0, X_WO);
        }
    }

    /// Candidates of the sources take turns.
    static std::int64_t numberOf(const Grasp& grasp, std::size_t source)
    {
        return grasp.candidate * std::ssize(kSources) + static_cast<std::int64_t>(source);
    }

    /// Best first, in the frame of the object and clear of the obstacles.
    std::vector<Grasp> graspsOfObject(ApproachSource source,
                                      std::int64_t candidates,
                                      const std::vector<Grasp>& known)
    {
        const Isometry3d X_OW = m_plan.X_WOStart.inverse();
        m_inObject.clear();
        for (const RigidBody& body : m_scene.bodies)
        {
            m_inObject.push_back({.tree = body.tree, .motion = restAt(X_OW * body.motion.X_W0)});
        }
        PlannerOptions options = m_options.grasps;
        options.candidates = candidates;
        options.approach.source = source;
        if (source == ApproachSource::Pinch)
        {
            ++options.seed;  // others than the pinches of Mixed
        }
        options.approach.tableTop = true;
        options.approach.up = X_OW.linear().col(2);
        std::vector<Grasp> grasps = planGrasps(
            m_task.hand,
            m_task.object,
            options,
            [this] { return kinematicClosing(m_inObject); },
            {.obstacles = m_inObject, .known = known, .stop = [this] { return isStopped(); }});
        return grasps;
    }

    void requireFreeStart()
    {
        const std::vector<double>& open = m_task.hand.preshapes.front().positions;
        // A leg that goes nowhere far: what overlaps at its start is named.
        JointPositions moved = m_task.start;
        for (double& q : moved)
        {
            q += 1e-6;
        }
        TaskLeg leg = legOf("start", {whole(m_task.start, open), whole(moved, open)}, 0.0, false);
        const std::string touched = certifyLeg(m_robot, m_task.X_WR, m_before, leg, 0.0, m_work);
        require(touched.empty(),
                "pick and place: the robot is in collision where it starts: " + touched +
                    ": correct the start of the robot, or the scene");
    }

    /// Positions of all links.
    [[nodiscard]] std::vector<double> whole(const JointPositions& arm,
                                            const std::vector<double>& hand) const
    {
        std::vector<double> q(m_task.robot.tree.size(), 0.0);
        std::copy(hand.begin(), hand.end(), q.begin() + m_task.robot.handRoot);
        for (std::size_t k = 0; k < arm.size(); ++k)
        {
            q[static_cast<std::size_t>(m_task.robot.joints[k])] = arm[k];
        }
        applyMimics(m_task.robot.tree, q);
        return q;
    }

    [[nodiscard]] std::vector<std::vector<double>> wholes(const Path& path,
                                                          const std::vector<double>& hand) const
    {
        std::vector<std::vector<double>> positions;
        for (const JointPositions& q : path)
        {
            positions.push_back(whole(q, hand));
        }
        return positions;
    }

    [[nodiscard]] TaskLeg legOf(const std::string& name,
                                const std::vector<std::vector<double>>& positions,
                                double begin,
                                bool carries) const
    {
        return {.name = name,
                .carries = carries,
                .waypoints = timedWaypoints(m_task.robot.tree, positions, begin, m_options)};
    }

    [[nodiscard]] Path straight(const JointPositions& start, const Vector3d& shift) const
    {
        return straightPath(m_kinematics, start, shift);
    }

    /// A straight way of the hand from or, reversed, to a posture of the arm.
    struct StraightLeg
    {
        std::string name;
        const RobotBody& body;
        const NamedSurroundings& around;
        const JointPositions& posture;
        Vector3d shift;  // W, where there is room [m]
        bool isReversed = false;
        const std::vector<double>& hand;
        double margin = 0.0;
        Path path{};  // in the order of the motion
        TaskLeg leg{};
    };

    [[nodiscard]] StraightLeg approachOf(const Grasp& grasp,
                                         const JointPositions& posture,
                                         const std::vector<double>& open) const
    {
        return {.name = "approach",
                .body = m_robot,
                .around = m_before,
                .posture = posture,
                .shift = -m_options.approach * (m_plan.X_WOStart.linear() * grasp.approach_W),
                .isReversed = true,
                .hand = open,
                .margin = m_options.margin};
    }

    /// Finds the path and certifies the leg; where there is no room for all of the way, for a part
    /// of it. Else says what is in the way of the shortest.
    std::optional<Obstruction> goStraight(StraightLeg& way, ToiWorkspace& work) const
    {
        std::string reason;
        for (const double share : kShares)
        {
            way.path = straight(way.posture, share * way.shift);
            if (way.path.empty())
            {
                reason = "the arm cannot follow the straight way";
                continue;
            }
            if (way.isReversed)
            {
                std::ranges::reverse(way.path);
            }
            way.leg = legOf(way.name, wholes(way.path, way.hand), 0.0, &way.body == &m_carrying);
            reason = touchedOnLeg(way.body, m_task.X_WR, way.around, way.leg, way.margin, work);
            if (reason.empty())
            {
                return std::nullopt;
            }
        }
        return Obstruction{way.name, reason};
    }

    /// Certifies the leg, or says what is in its way.
    std::optional<Obstruction> check(const RobotBody& body,
                                     const NamedSurroundings& around,
                                     TaskLeg& leg,
                                     double margin)
    {
        const std::string touched = touchedOnLeg(body, m_task.X_WR, around, leg, margin, m_work);
        return touched.empty() ? std::nullopt : std::optional(Obstruction{leg.name, touched});
    }

    std::optional<Obstruction> planBetween(const RobotBody& body,
                                           const NamedSurroundings& around,
                                           const std::string& name,
                                           const std::vector<double>& hand,
                                           const JointPositions& from,
                                           const JointPositions& to,
                                           TaskLeg& leg)
    {
        std::vector<double> rest = whole(from, hand);
        rest.resize(body.tree.size(), 0.0);
        std::optional<Obstruction> failed;
        for (const double share : kMargins)
        {
            const double margin = share * m_options.margin;
            const JointPathResult found = planJointPath(
                {.body = body.body(),
                 .environment = &around.environment,
                 .joints = m_task.robot.joints,
                 .positions = rest,
                 .X_WR = m_task.X_WR,
                 .toi = {.tolerance = kDefaultTolerance, .minimumSeparation = margin}},
                from,
                to,
                {.seed = m_options.seed, .stop = m_options.stop});
            leg = legOf(name, wholes(found.waypoints, hand), 0.0, &body == &m_carrying);
            failed = found.failure.empty() ? check(body, around, leg, margin)
                                           : Obstruction{name, found.failure};
            if (!failed || isStopped())
            {
                break;
            }
        }
        return failed;
    }

    bool tryGrasp(const Grasp& grasp)
    {
        const Isometry3d X_WH = m_plan.X_WOStart * grasp.X_WH;
        const auto postures =
            m_kinematics.solve(X_WH, m_task.start, {.wanted = kPostures, .seed = m_options.seed});
        if (postures.empty())
        {
            note(grasp, {"reach", "the arm does not reach the hand's pose"});
            return false;
        }
        m_isRehearsed = false;
        std::optional<Obstruction> last;
        for (const JointPositions& posture : postures)
        {
            last = isStopped() ? Obstruction{"", "stopped"} : tryPosture(grasp, posture);
            if (!last)
            {
                note(grasp, {});
                return true;
            }
            if (last->leg == "rehearsal")
            {
                break;
            }
        }
        note(grasp, *last);
        return false;
    }

    /// True if the arm brings the open hand straight to the grasp; thread-safe.
    [[nodiscard]] bool arrives(const Grasp& grasp) const
    {
        const Isometry3d X_WH = m_plan.X_WOStart * grasp.X_WH;
        const std::vector<double>& open = findPreshape(m_task.hand, grasp.preshape)->positions;
        if (!isClear(whole(m_task.start, open)))
        {
            return false;
        }
        ToiWorkspace work;
        return std::ranges::any_of(
            m_kinematics.solve(
                X_WH,
                m_task.start,
                {.wanted = kPostures, .restarts = kPlaceRestarts, .seed = m_options.seed}),
            [&](const JointPositions& posture)
            {
                StraightLeg approach = approachOf(grasp, posture, open);
                return isClear(whole(posture, open)) && !goStraight(approach, work);
            });
    }

    /// True if no link is nearer than the margin to what stands around before the object is taken.
    [[nodiscard]] bool isClear(const std::vector<double>& positions) const
    {
        const std::vector<Isometry3d> X_W = linkPoses(m_robot.tree, m_task.X_WR, positions);
        for (std::size_t link = 0; link < X_W.size(); ++link)
        {
            for (const RigidBody& body : m_before.bodies)
            {
                if (m_robot.linkTrees[link] != nullptr &&
                    treeDistance(*m_robot.linkTrees[link],
                                 *body.tree,
                                 body.motion.X_W0.inverse() * X_W[link],
                                 m_options.margin)
                            .distance < m_options.margin)
                {
                    return false;
                }
            }
        }
        return true;
    }

    void note(const Grasp& grasp, const Obstruction& obstruction)
    {
        m_plan.attempts.push_back({grasp.candidate, obstruction.leg, obstruction.reason});
    }

    /// Closes the hand anew where the arm holds it, which is not quite where it was planned.
    std::optional<Obstruction> closeAt(const Grasp& grasp, const JointPositions& posture)
    {
        const Preshape& preshape = *findPreshape(m_task.hand, grasp.preshape);
        m_open = preshape.positions;
        const Grasp closed = closeAtPose(m_task.hand,
                                         m_task.object,
                                         m_plan.X_WOStart.inverse() * m_kinematics.poseAt(posture),
                                         Eigen::Vector3d::Zero(),
                                         preshape,
                                         m_options.grasps,
                                         kinematicClosing(m_inObject),
                                         m_inObject);
        if (closed.reject != RejectReason::None)
        {
            return Obstruction{"close",
                               std::string("the hand does not grasp the object from there: ") +
                                   toString(closed.reject)};
        }
        m_plan.grasp = grasp;
        m_plan.grasp.X_WH = closed.X_WH;
        m_plan.grasp.positions = closed.positions;
        m_plan.grasp.stops = closed.stops;
        m_plan.grasp.contacts = closed.contacts;
        m_plan.X_HO = closed.X_WH.inverse();
        return std::nullopt;
    }

    /// Positions of the hand from the preshape to the grasp, a row whenever a joint begins or ends.
    [[nodiscard]] std::vector<std::vector<double>> closingRows() const
    {
        const ClosingSpans spans =
            closingSpans(m_task.hand, m_plan.grasp, m_options.grasps.closing);
        std::vector<std::vector<double>> rows;
        for (const double time : closingTimes(spans))
        {
            rows.push_back(closingAt(spans, m_plan.grasp.positions, time));
        }
        return rows;
    }

    /// The lift with the object where it was given, which is lower by what it was raised by.
    std::optional<Obstruction> liftFromWhereItStands(const TaskLeg& lift)
    {
        const Isometry3d X_HW = m_plan.X_HO * m_plan.X_WOStart.inverse();
        RobotBody standing(m_task.robot);
        standing.carry(m_task.robot, m_task.object, X_HW * m_task.X_WO);
        const double raise = m_plan.X_WOStart.translation().z() - m_task.X_WO.translation().z();
        Parting parting = certifyParting(
            standing, m_task.X_WR, m_scene, lift, m_options.gap, raise + m_options.gap, m_work);
        m_plan.partsFrom = std::move(parting.from);
        return parting.objection.empty()
                   ? std::nullopt
                   : std::optional(Obstruction{"lift", std::move(parting.objection)});
    }

    std::optional<Obstruction> tryPosture(const Grasp& grasp, const JointPositions& posture)
    {
        m_plan.legs.assign(9, {});
        if (const auto failed = closeAt(grasp, posture))
        {
            return failed;
        }
        StraightLeg approach = approachOf(grasp, posture, m_open);
        if (const auto failed = goStraight(approach, m_work))
        {
            return failed;
        }
        m_plan.legs[1] = approach.leg;
        m_closing.clear();
        for (const std::vector<double>& hand : closingRows())
        {
            m_closing.push_back(hand);
        }
        if (const auto failed = fingers("close", posture, m_closing, m_before, m_plan.legs[2]))
        {
            return failed;
        }
        m_carrying = RobotBody(m_task.robot);
        m_carrying.carry(m_task.robot, m_task.object, m_plan.X_HO);
        StraightLeg lift{.name = "lift",
                         .body = m_carrying,
                         .around = m_scene,
                         .posture = posture,
                         .shift = {0.0, 0.0, m_options.lift},
                         .hand = m_plan.grasp.positions};
        if (const auto failed = goStraight(lift, m_work))
        {
            return failed;
        }
        m_plan.legs[3] = lift.leg;
        if (const auto failed = liftFromWhereItStands(lift.leg))
        {
            return failed;
        }
        const std::vector<Placement> placements = placementsFrom(lift.path.back());
        if (placements.empty())
        {
            return Obstruction{"place", "the arm does not reach the target with this grasp"};
        }
        if (!m_isRehearsed)
        {
            m_isRehearsed = true;
            const std::string& objection = objectionTo(grasp);
            if (!objection.empty())
            {
                return Obstruction{"rehearsal", objection};
            }
        }
        if (const auto failed = planBetween(m_robot,
                                            m_before,
                                            "transit",
                                            m_open,
                                            m_task.start,
                                            approach.path.front(),
                                            m_plan.legs[0]))
        {
            return failed;
        }
        std::optional<Obstruction> last;
        for (const Placement& placement : placements)
        {
            last = isStopped() ? Obstruction{"place", "stopped"}
                               : tryPlace(placement, lift.path.back(), grasp);
            if (!last)
            {
                break;
            }
        }
        return last;
    }

    /// What is said against a grasp; it is asked for once.
    const std::string& objectionTo(const Grasp& grasp)
    {
        const auto known = m_objections.find(grasp.candidate);
        return known != m_objections.end()
                   ? known->second
                   : m_objections
                         .emplace(grasp.candidate,
                                  m_options.objection ? m_options.objection(grasp) : "")
                         .first->second;
    }

    /// The fingers alone.
    std::optional<Obstruction> fingers(const std::string& name,
                                       const JointPositions& posture,
                                       const std::vector<std::vector<double>>& rows,
                                       const NamedSurroundings& around,
                                       TaskLeg& leg)
    {
        std::vector<std::vector<double>> positions;
        for (const std::vector<double>& hand : rows)
        {
            positions.push_back(whole(posture, hand));
        }
        leg = legOf(name, positions, 0.0, false);
        return check(m_robot, around, leg, 0.0);
    }

    /// Where the object is put down, and the arm's posture then.
    struct Placement
    {
        Isometry3d X_WO;
        JointPositions posture;
    };

    [[nodiscard]] std::vector<Placement> placementsFrom(const JointPositions& lifted) const
    {
        std::vector<Placement> placements;
        std::size_t reached = 0;
        std::size_t asked = 0;
        for (const auto& [order, X_WO] : *m_places)
        {
            if (m_places == &m_onOtherFaces && ++asked > kOtherPlacesAsked)
            {
                break;
            }
            const auto postures = m_kinematics.solve(
                X_WO * m_plan.grasp.X_WH,
                lifted,
                {.wanted = kPostures, .restarts = kPlaceRestarts, .seed = m_options.seed});
            for (const JointPositions& posture : postures)
            {
                placements.push_back({X_WO, posture});
            }
            reached += postures.empty() ? 0 : 1;
            if (reached == kPlaces || isStopped())
            {
                break;
            }
        }
        return placements;
    }

    std::optional<Obstruction> tryPlace(const Placement& placement,
                                        const JointPositions& lifted,
                                        const Grasp& grasp)
    {
        const auto& [X_WO, posture] = placement;
        m_plan.X_WOEnd = m_kinematics.poseAt(posture) * m_plan.X_HO;
        NamedSurroundings after = m_scene;
        after.add(m_task.object.tree, m_plan.X_WOEnd, m_task.object.name);
        after.finish();
        std::vector<std::vector<double>> opening(m_closing.rbegin(), m_closing.rend());
        std::vector<TaskLeg>& legs = m_plan.legs;
        StraightLeg down{.name = "place",
                         .body = m_carrying,
                         .around = m_scene,
                         .posture = posture,
                         .shift = {0.0, 0.0, m_options.lift},
                         .isReversed = true,
                         .hand = m_plan.grasp.positions};
        StraightLeg back{.name = "retreat",
                         .body = m_robot,
                         .around = after,
                         .posture = posture,
                         .shift = -m_options.approach * (X_WO.linear() * grasp.approach_W),
                         .hand = m_open,
                         .margin = m_options.margin};
        std::optional<Obstruction> failed = goStraight(down, m_work);
        failed = failed ? failed : fingers("open", posture, opening, after, legs[6]);
        failed = failed ? failed : goStraight(back, m_work);
        legs[5] = down.leg;
        legs[7] = back.leg;
        failed = failed ? failed
                        : planBetween(m_carrying,
                                      m_scene,
                                      "carry",
                                      m_plan.grasp.positions,
                                      lifted,
                                      down.path.front(),
                                      legs[4]);
        failed =
            failed ? failed
                   : planBetween(
                         m_robot, after, "return", m_open, back.path.back(), m_task.start, legs[8]);
        if (!failed)
        {
            for (TaskLeg& leg : legs)
            {
                const bool isBefore = &leg < &legs[3];
                leg.clearance = clearanceOf(leg.carries ? m_carrying : m_robot,
                                            m_task.X_WR,
                                            leg.carries ? m_scene
                                            : isBefore  ? m_before
                                                        : after,
                                            leg,
                                            m_work);
            }
            followOn(m_plan.legs);
        }
        return failed;
    }

    static constexpr double kPutDown = 0.03;  // above the target, where putting down begins [m]

    const PickPlaceTask& m_task;
    const PickPlaceOptions m_options;
    ArmKinematics m_kinematics;
    RobotBody m_robot;
    RobotBody m_carrying{m_task.robot};
    NamedSurroundings m_scene;   // without the object
    NamedSurroundings m_before;  // with the object where it starts
    std::vector<RigidBody> m_inObject;
    Places m_asItStood;
    Places m_onOtherFaces;
    bool m_hasOtherPlaces = false;
    std::map<std::int64_t, std::string> m_objections;  // by candidate
    const Places* m_places = nullptr;                  // one of the two
    bool m_isAboveSomething = false;                   // in one of the places that were looked at
    std::vector<double> m_open;                        // positions of the hand
    std::vector<std::vector<double>> m_closing;
    bool m_isRehearsed = false;  // the grasp that is tried
    ToiWorkspace m_work;
    PickPlacePlan m_plan;
};
}  // namespace

PickPlacePlan planPickPlace(const PickPlaceTask& task, const PickPlaceOptions& options)
{
    require(task.start.size() == task.robot.joints.size(),
            "pick and place: give one start position for each joint of the arm");
    require(task.obstacles.size() == task.obstacleNames.size(),
            "pick and place: give one name for each obstacle");
    require(
        task.target.center.allFinite() && task.target.size.allFinite() &&
            task.target.size.minCoeff() >= 0.0 && task.X_WO.matrix().allFinite() &&
            task.X_WR.matrix().allFinite() &&
            std::ranges::all_of(task.start, [](double q) { return std::isfinite(q); }),
        "pick and place: the target region, a pose, or the start of the arm is not finite, or a "
        "size is negative");
    require(
        options.gap > 1e-5 && options.gap <= 1e-3 && options.approach > 0.0 && options.lift > 0.0 &&
            options.acceleration > 0.0 && options.freeSpeed > 0.0,
        "pick and place: the gap must be in (0.01 mm, 1 mm], and the ways of approach and lift, "
        "the acceleration and the speed positive");
    const ObjectMass mass = massOf(task.object, options.grasps.mass);
    PickPlaceOptions withMass = options;
    withMass.grasps.mass = mass.mass;
    withMass.grasps.forceClosureThreshold =
        std::min(withMass.grasps.forceClosureThreshold, kLeastEpsilon);
    PickPlacePlan plan = PickPlacePlanner(task, std::move(withMass)).run();
    plan.mass = mass;
    return plan;
}

const Isometry3d& restingPose(const PickPlacePlan& plan, std::size_t leg)
{
    // Legs before the object is carried, and after.
    const auto carried = std::ranges::find_if(plan.legs, &TaskLeg::carries) - plan.legs.begin();
    return std::ptrdiff_t(leg) < carried ? plan.X_WOStart : plan.X_WOEnd;
}
}  // namespace bullet_ccd::grasp
