#include "bullet_ccd/ompl/certified_planning.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/ompl/moved_pairs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <optional>
#include <stdexcept>
#include <string>
#include <tbb/enumerable_thread_specific.h>

namespace bullet_ccd
{
namespace ob = ::ompl::base;

namespace
{
/// Between samples of a motion the joints turn by more than half of this together [rad], or there
/// are twice as many samples less one.
constexpr double kSampleStep = 0.6;
constexpr int kMostSamples = 8;

std::span<const double> valuesOf(const ob::State* state, std::size_t count)
{
    return {state->as<ob::RealVectorStateSpace::StateType>()->values, count};
}

/// The last valid state of a motion is looked for with so many tolerances on top of the separation:
/// the motion to it keeps one, so it is free itself, and rounding has room.
constexpr double kRoomOfLastValid = 1.25;

const std::shared_ptr<const CertifiedRobot>& requireRobot(
    const std::shared_ptr<const CertifiedRobot>& robot)
{
    require(robot != nullptr, "certified planning: there is no robot: give a CertifiedRobot");
    return robot;
}

const ob::SpaceInformationPtr& requireSpace(const ob::SpaceInformationPtr& information,
                                            const std::shared_ptr<const CertifiedRobot>& robot)
{
    const std::size_t count = requireRobot(robot)->scene().joints.size();
    require(information != nullptr,
            "certified planning: there is no space information: certifiedSpace() makes one");
    require(information->getStateSpace()->getType() == ob::STATE_SPACE_REAL_VECTOR &&
                information->getStateDimension() == count,
            "certified planning: the space must be a RealVectorStateSpace with a dimension for "
            "each of the " +
                std::to_string(count) + " planned joints: jointSpace() makes one");
    return information;
}
}  // namespace

struct CertifiedRobot::Impl
{
    /// Of one thread. What the queries write is of the size of the robot.
    struct Scratch
    {
        ToiWorkspace work;
        JointMotion motion;
        MovedPairs::Scratch state;
    };

    std::optional<MovedPairs> pairs;
    mutable tbb::enumerable_thread_specific<Scratch> scratches;
};

CertifiedRobot::CertifiedRobot(PlanningScene scene)
    : m_scene(std::move(scene)), m_impl(std::make_unique<Impl>())
{
    require(m_scene.body.tree != nullptr && m_scene.environment != nullptr,
            "certified planning: there is no kinematic tree, or no environment");
    require(m_scene.environment->movingCount() == 0,
            "certified planning: an obstacle moves: all must rest while motions are planned");
    require(!m_scene.joints.empty(),
            "certified planning: no joint is planned: name the links below those that are");
    const KinematicTree& tree = *m_scene.body.tree;
    m_scene.positions.resize(m_scene.positions.empty() ? tree.size() : m_scene.positions.size());
    require(m_scene.positions.size() == tree.size(),
            "certified planning: give one position for each link, or none");
    // A motion of all planned joints shows which pairs they move; the query checks the rest.
    JointMotion motion{.root = restAt(m_scene.X_WR),
                       .positions = m_scene.positions,
                       .rates = std::vector<double>(tree.size(), 0.0)};
    for (const std::int32_t link : m_scene.joints)
    {
        const bool isThere = link > 0 && static_cast<std::size_t>(link) < tree.size();
        const Joint* joint = isThere ? &tree.links[static_cast<std::size_t>(link)].joint : nullptr;
        require(isThere && joint->isMovable() && joint->type != JointType::Spherical &&
                    joint->mimicOf == kNone && motion.rates[static_cast<std::size_t>(link)] == 0.0,
                "certified planning: joint " + std::to_string(link) +
                    " does not turn or slide, follows another, or is there twice");
        motion.rates[static_cast<std::size_t>(link)] = 1.0;
    }
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        if (joint.mimicOf != kNone)
        {
            motion.rates[i] = motion.rates[static_cast<std::size_t>(joint.mimicOf)];
        }
        require(joint.type != JointType::Spherical,
                "certified planning: the robot has a spherical joint, which is not supported");
    }
    applyMimics(tree, motion.positions);
    ArticulatedBody body = m_scene.body;
    body.motion = &motion;
    ToiWorkspace work;
    (void)articulatedToi(body, Environment(), {.toi = m_scene.toi}, work);
    m_impl->pairs.emplace(body, *m_scene.environment, m_scene.X_WR);
}

CertifiedRobot::~CertifiedRobot() = default;

void CertifiedRobot::setPositions(std::span<const double> q, std::vector<double>& positions) const
{
    require(q.size() == m_scene.joints.size(),
            "certified planning: give one position for each planned joint");
    positions = m_scene.positions;
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        if (!std::isfinite(q[k]))  // a message made for every position takes a quarter of a query
        {
            throw std::invalid_argument("certified planning: position " + std::to_string(k) +
                                        " is " + std::to_string(q[k]) + ": give finite ones");
        }
        positions[static_cast<std::size_t>(m_scene.joints[k])] = q[k];
    }
    applyMimics(*m_scene.body.tree, positions);
}

bool CertifiedRobot::isFree(std::span<const double> q) const
{
    // Less than a query leaves at the end of a motion that it stops, more than rounding.
    const double touching = m_scene.toi.minimumSeparation + 1e-3 * m_scene.toi.tolerance;
    constexpr bool kAny = true;
    return leastDistance(q, touching, kAny) == touching;
}

double CertifiedRobot::clearance(std::span<const double> q, double enough) const
{
    constexpr bool kAny = false;
    return leastDistance(q, enough, kAny);
}

double CertifiedRobot::leastDistance(std::span<const double> q, double enough, bool any) const
{
    Impl::Scratch& scratch = m_impl->scratches.local();
    setPositions(q, scratch.motion.positions);
    return m_impl->pairs->leastDistance(scratch.motion.positions, enough, any, scratch.state);
}

bool CertifiedRobot::isFreeMotion(std::span<const double> from, std::span<const double> to) const
{
    require(from.size() == to.size(),
            "certified planning: the motion has a start and an end of different sizes");
    if (!isFree(to))
    {
        return false;
    }
    // A blocked motion is mostly blocked for a good part of the way. Halves, quarters and so on
    // find that sooner than a query, which first certifies all that comes before the contact.
    double change = 0.0;
    for (std::size_t k = 0; k < from.size(); ++k)
    {
        change += std::abs(to[k] - from[k]);
    }
    std::vector<double> between(from.size());
    double part = 0.5;
    for (int count = 1; count <= kMostSamples && change * part > kSampleStep; count *= 2)
    {
        for (int i = 0; i < count; ++i)
        {
            for (std::size_t k = 0; k < between.size(); ++k)
            {
                between[k] = std::lerp(from[k], to[k], (2 * i + 1) * part);
            }
            if (!isFree(between))
            {
                return false;
            }
        }
        part *= 0.5;
    }
    return motionToi(from, to, {.toi = m_scene.toi, .anyContact = true}).status ==
           ToiStatus::Separated;
}

ArticulatedToiResult CertifiedRobot::motionToi(std::span<const double> from,
                                               std::span<const double> to) const
{
    return motionToi(from, to, {.toi = m_scene.toi});
}

double CertifiedRobot::freePart(std::span<const double> from, std::span<const double> to) const
{
    if (!isFree(from))
    {
        return 0.0;  // of pairs that this motion does not move, too
    }
    ToiOptions toi = m_scene.toi;
    toi.minimumSeparation += kRoomOfLastValid * toi.tolerance;
    return motionToi(from, to, {.toi = toi}).time;
}

ArticulatedToiResult CertifiedRobot::motionToi(std::span<const double> from,
                                               std::span<const double> to,
                                               const ArticulatedToiOptions& options) const
{
    Impl::Scratch& scratch = m_impl->scratches.local();
    JointMotion& motion = scratch.motion;
    motion.root = restAt(m_scene.X_WR);
    setPositions(from, motion.positions);
    setPositions(to, motion.rates);
    for (std::size_t i = 0; i < motion.rates.size(); ++i)
    {
        motion.rates[i] -= motion.positions[i];
    }
    ArticulatedBody body = m_scene.body;
    body.motion = &motion;
    return articulatedToi(body, *m_scene.environment, options, scratch.work);
}

CertifiedStateChecker::CertifiedStateChecker(const ob::SpaceInformationPtr& information,
                                             std::shared_ptr<const CertifiedRobot> robot)
    : ob::StateValidityChecker(requireSpace(information, robot)), m_robot(std::move(robot))
{
    specs_.clearanceComputationType = ob::StateValidityCheckerSpecs::EXACT;
}

bool CertifiedStateChecker::isValid(const ob::State* state) const
{
    return si_->satisfiesBounds(state) &&
           m_robot->isFree(valuesOf(state, m_robot->scene().joints.size()));
}

double CertifiedStateChecker::clearance(const ob::State* state) const
{
    const double separation = m_robot->scene().toi.minimumSeparation;
    return m_robot->clearance(valuesOf(state, m_robot->scene().joints.size()), separation + 1.0) -
           separation;
}

CertifiedMotionValidator::CertifiedMotionValidator(const ob::SpaceInformationPtr& information,
                                                   std::shared_ptr<const CertifiedRobot> robot)
    : ob::MotionValidator(requireSpace(information, robot)), m_robot(std::move(robot))
{
}

bool CertifiedMotionValidator::count(bool isFree) const
{
    std::atomic_ref(isFree ? valid_ : invalid_).fetch_add(1, std::memory_order_relaxed);
    return isFree;
}

bool CertifiedMotionValidator::checkMotion(const ob::State* from, const ob::State* to) const
{
    const std::size_t count = m_robot->scene().joints.size();
    return this->count(m_robot->isFreeMotion(valuesOf(from, count), valuesOf(to, count)));
}

bool CertifiedMotionValidator::checkMotion(const ob::State* from,
                                           const ob::State* to,
                                           std::pair<ob::State*, double>& lastValid) const
{
    const std::size_t count = m_robot->scene().joints.size();
    const bool isFree = m_robot->isFreeMotion(valuesOf(from, count), valuesOf(to, count));
    if (!isFree)
    {
        lastValid.second = m_robot->freePart(valuesOf(from, count), valuesOf(to, count));
        if (lastValid.first != nullptr)
        {
            si_->getStateSpace()->interpolate(from, to, lastValid.second, lastValid.first);
        }
    }
    return this->count(isFree);
}

ob::StateSpacePtr jointSpace(const KinematicTree& tree, std::span<const std::int32_t> joints)
{
    ob::RealVectorBounds bounds(static_cast<unsigned>(joints.size()));
    for (std::size_t k = 0; k < joints.size(); ++k)
    {
        const Joint& joint = tree.links[static_cast<std::size_t>(joints[k])].joint;
        const double widest = joint.type == JointType::Prismatic ? 1.0 : std::numbers::pi;
        const bool hasLower = std::isfinite(joint.lower);
        const bool hasUpper = std::isfinite(joint.upper);
        bounds.low[k] = hasLower   ? joint.lower
                        : hasUpper ? std::min(-widest, joint.upper - 2.0 * widest)
                                   : -widest;
        bounds.high[k] = hasUpper   ? joint.upper
                         : hasLower ? std::max(widest, joint.lower + 2.0 * widest)
                                    : widest;
    }
    auto space = std::make_shared<ob::RealVectorStateSpace>(static_cast<unsigned>(joints.size()));
    space->setBounds(bounds);
    return space;
}

ob::SpaceInformationPtr certifiedSpace(std::shared_ptr<const CertifiedRobot> robot)
{
    requireRobot(robot);
    auto information = std::make_shared<ob::SpaceInformation>(
        jointSpace(*robot->scene().body.tree, robot->scene().joints));
    information->setStateValidityChecker(
        std::make_shared<CertifiedStateChecker>(information, robot));
    information->setMotionValidator(
        std::make_shared<CertifiedMotionValidator>(information, std::move(robot)));
    information->setup();
    return information;
}
}  // namespace bullet_ccd
