#include "bullet_ccd/ompl/certified_planning.h"

#include "bullet_ccd/distance/tree_distance.h"
#include "bullet_ccd/math/check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <string>
#include <tbb/enumerable_thread_specific.h>

namespace bullet_ccd
{
namespace ob = ::ompl::base;

namespace
{
/// A link, and an obstacle or another link, that the planned joints move relative to each other.
struct TestedPair
{
    std::int32_t link = kNone;
    std::int32_t obstacle = kNone;
    std::int32_t otherLink = kNone;
    const PairMask* mask = nullptr;
};

const PairMask* maskOf(const ArticulatedBody& body, const TestedPair& pair)
{
    const auto mask = std::ranges::find_if(body.masks,
                                           [&](const LinkMask& each)
                                           {
                                               return each.link == pair.link &&
                                                      each.obstacle == pair.obstacle &&
                                                      each.otherLink == pair.otherLink;
                                           });
    return mask == body.masks.end() ? nullptr : mask->mask;
}

/// Distance of the spheres around two hierarchies: never above theirs.
double sphereGap(const SsvTree& a,
                 const Eigen::Isometry3d& X_WA,
                 const SsvTree& b,
                 const Eigen::Isometry3d& X_WB)
{
    return (X_WA * a.origin() - X_WB * b.origin()).norm() - a.radius() - b.radius();
}

std::span<const double> valuesOf(const ob::State* state, std::size_t count)
{
    return {state->as<ob::RealVectorStateSpace::StateType>()->values, count};
}

void requireSpace(const ob::SpaceInformation& information, const CertifiedRobot& robot)
{
    require(information.getStateSpace()->getType() == ob::STATE_SPACE_REAL_VECTOR &&
                information.getStateDimension() == robot.scene().joints.size(),
            "certified planning: the space must be a RealVectorStateSpace with a dimension for "
            "each of the " +
                std::to_string(robot.scene().joints.size()) +
                " planned joints: jointSpace() makes one");
}
}  // namespace

struct CertifiedRobot::Impl
{
    std::vector<TestedPair> pairs;
    mutable tbb::enumerable_thread_specific<ToiWorkspace> work;
};

CertifiedRobot::CertifiedRobot(PlanningScene scene)
    : m_scene(std::move(scene)), m_impl(std::make_unique<Impl>())
{
    require(m_scene.body.tree != nullptr && m_scene.environment != nullptr,
            "certified planning: there is no kinematic tree, or no environment");
    require(m_scene.environment->movingCount() == 0,
            "certified planning: an obstacle moves: all must rest while motions are planned");
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
    ArticulatedBody body = m_scene.body;
    body.motion = &motion;
    ToiWorkspace work;
    (void)articulatedToi(body, Environment(), {.toi = m_scene.toi}, work);
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const auto link = static_cast<std::int32_t>(i);
        if (body.linkTrees[i] == nullptr || !moves(tree, motion, kNone, link))
        {
            continue;
        }
        for (std::size_t k = 0; k < m_scene.environment->bodies().size(); ++k)
        {
            m_impl->pairs.push_back({.link = link, .obstacle = static_cast<std::int32_t>(k)});
        }
    }
    for (const auto& [a, b] : body.selfPairs)
    {
        const std::int32_t base = commonAncestor(tree, a, b);
        if (moves(tree, motion, base, a) || moves(tree, motion, base, b))
        {
            m_impl->pairs.push_back({.link = a, .otherLink = b});
        }
    }
    for (TestedPair& pair : m_impl->pairs)
    {
        pair.mask = maskOf(body, pair);
    }
}

CertifiedRobot::~CertifiedRobot() = default;

std::vector<double> CertifiedRobot::positionsOf(std::span<const double> q) const
{
    require(q.size() == m_scene.joints.size(),
            "certified planning: give one position for each planned joint");
    std::vector<double> positions = m_scene.positions;
    for (std::size_t k = 0; k < q.size(); ++k)
    {
        positions[static_cast<std::size_t>(m_scene.joints[k])] = q[k];
    }
    applyMimics(*m_scene.body.tree, positions);
    return positions;
}

bool CertifiedRobot::isFree(std::span<const double> q) const
{
    // Less than a query leaves at the end of a motion that it stops, more than rounding.
    const double touching = m_scene.toi.minimumSeparation + 1e-3 * m_scene.toi.tolerance;
    return clearance(q, touching) == touching;
}

double CertifiedRobot::clearance(std::span<const double> q, double enough) const
{
    const ArticulatedBody& body = m_scene.body;
    const std::vector<Eigen::Isometry3d> X_W = linkPoses(*body.tree, m_scene.X_WR, positionsOf(q));
    const std::span<const RigidBody> obstacles = m_scene.environment->bodies();
    double least = enough;
    for (const TestedPair& pair : m_impl->pairs)
    {
        const auto a = static_cast<std::size_t>(pair.link);
        const bool isSelf = pair.otherLink != kNone;
        const auto b = static_cast<std::size_t>(isSelf ? pair.otherLink : pair.obstacle);
        const SsvTree& treeA = *body.linkTrees[a];
        const SsvTree& treeB = isSelf ? *body.linkTrees[b] : *obstacles[b].tree;
        const Eigen::Isometry3d& X_WB = isSelf ? X_W[b] : obstacles[b].motion.X_W0;
        if (sphereGap(treeA, X_W[a], treeB, X_WB) < least)
        {
            least = treeDistance(treeA,
                                 treeB,
                                 X_WB.inverse() * X_W[a],
                                 least,
                                 pair.mask != nullptr ? pair.mask->nodeMarks() : NodeMarks{})
                        .distance;
        }
    }
    return least;
}

ArticulatedToiResult CertifiedRobot::motionToi(std::span<const double> from,
                                               std::span<const double> to) const
{
    JointMotion motion{
        .root = restAt(m_scene.X_WR), .positions = positionsOf(from), .rates = positionsOf(to)};
    for (std::size_t i = 0; i < motion.rates.size(); ++i)
    {
        motion.rates[i] -= motion.positions[i];
    }
    ArticulatedBody body = m_scene.body;
    body.motion = &motion;
    return articulatedToi(body, *m_scene.environment, {.toi = m_scene.toi}, m_impl->work.local());
}

CertifiedStateChecker::CertifiedStateChecker(const ob::SpaceInformationPtr& information,
                                             std::shared_ptr<const CertifiedRobot> robot)
    : ob::StateValidityChecker(information), m_robot(std::move(robot))
{
    requireSpace(*information, *m_robot);
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
    : ob::MotionValidator(information), m_robot(std::move(robot))
{
    requireSpace(*information, *m_robot);
}

bool CertifiedMotionValidator::count(bool isFree) const
{
    std::atomic_ref(isFree ? valid_ : invalid_).fetch_add(1, std::memory_order_relaxed);
    return isFree;
}

bool CertifiedMotionValidator::checkMotion(const ob::State* from, const ob::State* to) const
{
    const std::size_t count = m_robot->scene().joints.size();
    return this->count(m_robot->motionToi(valuesOf(from, count), valuesOf(to, count)).status ==
                       ToiStatus::Separated);
}

bool CertifiedMotionValidator::checkMotion(const ob::State* from,
                                           const ob::State* to,
                                           std::pair<ob::State*, double>& lastValid) const
{
    const std::size_t count = m_robot->scene().joints.size();
    const ArticulatedToiResult result =
        m_robot->motionToi(valuesOf(from, count), valuesOf(to, count));
    if (result.status != ToiStatus::Separated)
    {
        lastValid.second = result.time;
        if (lastValid.first != nullptr)
        {
            si_->getStateSpace()->interpolate(from, to, result.time, lastValid.first);
        }
    }
    return this->count(result.status == ToiStatus::Separated);
}

ob::StateSpacePtr jointSpace(const KinematicTree& tree, std::span<const std::int32_t> joints)
{
    ob::RealVectorBounds bounds(static_cast<unsigned>(joints.size()));
    for (std::size_t k = 0; k < joints.size(); ++k)
    {
        const Joint& joint = tree.links[static_cast<std::size_t>(joints[k])].joint;
        const double widest = joint.type == JointType::Prismatic ? 1.0 : std::numbers::pi;
        bounds.low[k] = std::isfinite(joint.lower) ? joint.lower : -widest;
        bounds.high[k] = std::isfinite(joint.upper) ? joint.upper : widest;
    }
    auto space = std::make_shared<ob::RealVectorStateSpace>(static_cast<unsigned>(joints.size()));
    space->setBounds(bounds);
    return space;
}

ob::SpaceInformationPtr certifiedSpace(std::shared_ptr<const CertifiedRobot> robot)
{
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
