#include "bullet_ccd/toi/search/pair_scene.h"

#include "bullet_ccd/toi/search/turning_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A gap in double precision is believed less this fraction of the coordinates it was computed from
/// (64 roundings).
constexpr double kRounding = 64.0 * 1.11e-16;

/// The same for a gap or a speed in single precision: 64 roundings of 6e-8, of which the rotation
/// matrix takes about 16, the center 16, the axes and extents 24.
constexpr double kSingleRounding = 4e-6;

/// What steps leave of the tolerance where any distance within it will do: the less, the fewer
/// pairs of volumes are as near as that.
constexpr double kAimOfAny = 1.0 / 32.0;

/// A step beyond the end of any motion.
constexpr float kEndless = 1e30F;

float up(double x)
{
    return static_cast<float>(x) * (1.0F + 2e-7F);
}

Isometry3d treeInBody(const MovingBody& body)
{
    Isometry3d X = body.X_BG;
    X.translation() = body.X_BG * body.tree->origin();
    return X;
}

/// Motion of one tree's frame, seen from the frame of the query.
struct TreeState
{
    Isometry3d X;
    Vector3d v;  ///< velocity of the tree's origin
    Vector3d w;
};

/// Of a body that is not a link.
MotionState bodyStateAt(const MovingBody& body, double t)
{
    if (const auto* user = std::get_if<const UserMotion*>(&body.motion))
    {
        return (*user)->at(t);
    }
    return std::get<RigidMotion>(body.motion).at(t);
}

TreeState treeStateOf(const MotionState& s, const Isometry3d& X_ofTree)
{
    const Isometry3d X = s.X_W * X_ofTree;
    return {.X = X, .v = s.v_W + s.w_W.cross(X.translation() - s.X_W.translation()), .w = s.w_W};
}

TreeState treeStateAt(const PairSide& side, std::int32_t base, double t)
{
    if (side.rests)
    {
        return {.X = side.X_atRest, .v = Vector3d::Zero(), .w = Vector3d::Zero()};
    }
    return treeStateOf(side.frames != nullptr ? side.frames->stateAt(base, side.frame, t)
                                              : bodyStateAt(*side.body, t),
                       side.X);
}

/// At which a body moves that nothing but moves and turns about a point of its own; zero for links.
Vector3d velocityOf(const PairSide& side)
{
    const auto* rigid =
        side.frames == nullptr ? std::get_if<RigidMotion>(&side.body->motion) : nullptr;
    return rigid != nullptr ? rigid->v_W : Vector3d::Zero();
}

/// An axis about which a body turns, at rest in the frame of the query Q, or moving along with the
/// other body. It is the z axis of T.
struct AxisOfTurn
{
    Isometry3d X_QT;
    Isometry3d X_TG;  ///< of the body's tree, at some time
};

/// None for bodies that do anything else.
/// @param v of the other body, in Q
std::optional<AxisOfTurn> axisOfTurn(const PairSide& side, std::int32_t base, const Vector3d& v)
{
    if (side.frames != nullptr)
    {
        const MovingFrame& frame = side.frames->frames()[static_cast<std::size_t>(side.frame)];
        if (!v.isZero(0.0) || side.frame == base || frame.parent != base || frame.slides)
        {
            return std::nullopt;
        }
        return AxisOfTurn{.X_QT = frame.X_PF, .X_TG = side.X};
    }
    const auto* rigid = std::get_if<RigidMotion>(&side.body->motion);
    if (rigid == nullptr || rigid->v_W != v || rigid->w_W.isZero(0.0))
    {
        return std::nullopt;
    }
    Isometry3d X_QT = Isometry3d::Identity();
    X_QT.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), rigid->w_W).matrix();
    X_QT.translation() = rigid->X_W0 * rigid->reference_B;
    return AxisOfTurn{.X_QT = X_QT, .X_TG = X_QT.inverse() * rigid->X_W0 * side.X};
}

/// Pose of the tree of a body that rests in the frame of the query, or that moves in it at the
/// velocity v and does not turn, at the start.
std::optional<Isometry3d> poseAtRest(const PairSide& side,
                                     std::int32_t base,
                                     const Vector3d& v = Vector3d::Zero())
{
    if (side.frames != nullptr)
    {
        return side.frame == base && v.isZero(0.0) ? std::optional(side.X) : std::nullopt;
    }
    const auto* rigid = std::get_if<RigidMotion>(&side.body->motion);
    const bool rests = rigid != nullptr && rigid->v_W == v && rigid->w_W.isZero(0.0);
    return rests ? std::optional<Isometry3d>(rigid->X_W0 * side.X) : std::nullopt;
}

std::optional<AccelerationPlane> planeOf(const PairSide& side, std::int32_t base)
{
    if (side.frames != nullptr)
    {
        return side.frames->accelerationPlane(base, side.frame);
    }
    if (const auto* rigid = std::get_if<RigidMotion>(&side.body->motion))
    {
        constexpr double kDeviation = 1e-12;
        return AccelerationPlane{.normal = rigid->w_W.stableNormalized(),
                                 .across = {.constant = kDeviation * rigid->w_W.squaredNorm() *
                                                        rigid->reference_B.norm(),
                                            .perRadius = kDeviation * rigid->w_W.squaredNorm()}};
    }
    return std::nullopt;
}

/// If both bodies accelerate in one plane, no direction but those in it sees them do so.
void setPlane(ScenePair& pair)
{
    const auto& a = pair.sideA.plane;
    const auto& b = pair.sideB.plane;
    constexpr double kParallel = 1e-14;
    if (!a || !b || a->normal.cross(b->normal).norm() > kParallel)
    {
        return;
    }
    pair.plane = a->normal.isZero(0.0) ? b->normal : a->normal;
    const auto most = [](const PairSide& side, const SsvTree& tree)
    {
        return side.plane->across.constant +
               side.plane->across.perRadius * (side.offset.norm() + tree.radius());
    };
    pair.acrossPlane = most(pair.sideA, *pair.treeA) + most(pair.sideB, *pair.treeB);
}

void setConstants(PairSide& side, std::int32_t base)
{
    if (side.frames != nullptr)
    {
        side.acceleration = side.frames->accelerationBound(base, side.frame);
    }
    else if (const auto* user = std::get_if<const UserMotion*>(&side.body->motion))
    {
        side.acceleration = (*user)->accelerationBound();
    }
    else
    {
        side.acceleration = std::get<RigidMotion>(side.body->motion).accelerationBound();
    }
    side.plane = planeOf(side, base);
    side.offset = side.X.linear().transpose() * side.X.translation();
    if (const auto rest = poseAtRest(side, base))
    {
        side.X_atRest = *rest;
        side.rests = true;
    }
}

void copy(const Vector3d& from, double (&to)[3])
{
    std::copy_n(from.data(), 3, to);
}

void setLane(float (&out)[3][NodeBatch::kLanes], int lane, const double (&x)[3])
{
    for (int k = 0; k < 3; ++k)
    {
        out[k][lane] = static_cast<float>(x[k]);
    }
}

double length(const double (&v)[3])
{
    return Eigen::Map<const Vector3d>(v).norm();
}

/// None of motions that users supply: their bounds need not hold beyond the body itself.
std::optional<RelativeMotion> seenTurning(const ScenePair& pair,
                                          const RelativeMotion& motion,
                                          TurningWith with,
                                          double rest)
{
    const bool ofB = with == TurningWith::B;
    const PairSide& side = ofB ? pair.sideB : pair.sideA;
    if (std::holds_alternative<const UserMotion*>(side.body->motion))
    {
        return std::nullopt;
    }
    return seenFromB(ofB ? motion : swapped(motion),
                     {.perRadius = side.acceleration.perRadius, .arm = side.offset},
                     (ofB ? pair.treeA : pair.treeB)->radius(),
                     rest);
}

template <std::size_t N>
void setAll(float (&out)[N], float x)
{
    std::fill(out, out + N, x);
}
}  // namespace

void PairScene::reset(std::span<const MovingBody> bodies,
                      std::span<const BodyPair> pairs,
                      const ToiOptions& options)
{
    m_bodies = bodies;
    m_bodyPairs = pairs;
    for (PairState& state : m_states)
    {
        state.pair = kNone;
    }
    for (Turned& turned : m_turned)
    {
        turned.state.pair = kNone;
    }
    m_batchPair = kNone;
    m_mayStartTouching = false;
    m_hasFaces = false;
    m_faces = {};
    m_treesUsed = 0;
    m_turningUsed = 0;
    m_pairs.resize(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i)
    {
        const MovingBody& a = bodies[static_cast<std::size_t>(pairs[i].bodyA)];
        const MovingBody& b = bodies[static_cast<std::size_t>(pairs[i].bodyB)];
        m_pairs[i] = {.treeA = a.tree,
                      .treeB = b.tree,
                      .mask = pairs[i].mask,
                      .untilTurn = static_cast<std::int64_t>(a.tree->mesh().triangles.size() +
                                                             b.tree->mesh().triangles.size()),
                      .limits = {.floor = options.minimumSeparation,
                                 .threshold = options.minimumSeparation + options.tolerance,
                                 .aim = options.anyWithin ? kAimOfAny : options.aim,
                                 .anyWithin = options.anyWithin}};
        m_hasFaces = m_hasFaces || !a.tree->faceSlabs().empty() || !b.tree->faceSlabs().empty();
        ScenePair& pair = m_pairs[i];
        pair.sideA = sideOf(a);
        pair.sideB = sideOf(b);
        // Links of one tree are compared in the frame of their common ancestor, all else in W.
        const bool oneTree = pair.sideA.frames != nullptr && pair.sideA.frames == pair.sideB.frames;
        pair.base =
            oneTree ? pair.sideA.frames->commonFrame(pair.sideA.frame, pair.sideB.frame) : 0;
        if (const auto rigid = asRigidBodies(pair))
        {
            pair.isRigid = true;
            pair.rigid = makeRigidPair((*rigid)[0], (*rigid)[1]);
            pair.speedScale = pair.rigid.speed;
            // Beyond this an arm turned in single precision would blur the whole mesh.
            constexpr double kLongestArm = 16.0;
            constexpr double kFastestTurn =
                1e6;  // sines in single precision have been proved up to here
            pair.inBatches = pair.rigid.armA.norm() <= kLongestArm * a.tree->radius() &&
                             pair.rigid.armB.norm() <= kLongestArm * b.tree->radius() &&
                             std::max(pair.rigid.rateA, pair.rigid.rateB) <= kFastestTurn;
            pair.poses = toRigidPoses(pair.rigid);
            continue;
        }
        setConstants(pair.sideA, pair.base);
        setConstants(pair.sideB, pair.base);
        setPlane(pair);
    }
}

/// The two bodies as they move seen from the frame of the query, if both do as rigid bodies: links
/// with one joint between them, too.
std::optional<std::array<MovingBody, 2>> PairScene::asRigidBodies(const ScenePair& pair) const
{
    std::array<MovingBody, 2> bodies;
    for (const PairSide* side : {&pair.sideA, &pair.sideB})
    {
        MovingBody& body = bodies[side == &pair.sideA ? 0 : 1];
        body = *side->body;
        if (side->frames != nullptr)
        {
            RigidMotion motion;
            if (!asRigidMotion(*side->frames, pair.base, side->frame, motion))
            {
                return std::nullopt;
            }
            const auto& link = std::get<LinkMotion>(side->body->motion);
            body.X_BG = side->frames->place(link.link).X_FL * body.X_BG;
            body.motion = motion;
        }
        else if (!std::holds_alternative<RigidMotion>(body.motion))
        {
            return std::nullopt;
        }
    }
    return bodies;
}

MovingFrames& PairScene::framesOf(const LinkMotion& link)
{
    if (link.frames != nullptr)
    {
        return *link.frames;
    }
    // Links of one tree mostly follow each other.
    for (std::size_t i = m_treesUsed; i-- > 0;)
    {
        if (m_trees[i].motion == link.motion)
        {
            return *m_trees[i].frames;
        }
    }
    if (m_treesUsed == m_trees.size())
    {
        m_trees.push_back({.frames = std::make_unique<MovingFrames>()});
    }
    OwnFrames& own = m_trees[m_treesUsed++];
    own.motion = link.motion;
    own.frames->reset(*link.tree, *link.motion);
    return *own.frames;
}

PairSide PairScene::sideOf(const MovingBody& body)
{
    PairSide side{.body = &body, .X = treeInBody(body)};
    if (const auto* link = std::get_if<LinkMotion>(&body.motion))
    {
        side.frames = &framesOf(*link);
        const LinkPlace& place = side.frames->place(link->link);
        side.frame = place.frame;
        side.X = place.X_FL * side.X;
    }
    return side;
}

const PairState& PairScene::stateAt(std::int32_t pair, double t, ToiCounters& counters)
{
    for (std::size_t back = 0; back < m_states.size(); ++back)
    {
        const PairState& known = m_states[(m_latest - back) % m_states.size()];
        if (known.pair == pair && known.time == t)
        {
            return known;
        }
    }
    ++counters.states;
    m_latest = (m_latest + 1) % m_states.size();
    computeState(pair, t, m_states[m_latest]);
    return m_states[m_latest];
}

const PairState& PairScene::turningStateAt(std::int32_t index, double t, ToiCounters& counters)
{
    const bool isRigid = m_pairs[static_cast<std::size_t>(index)].isRigid;
    const PairState* turned = isRigid ? turnedStateAt(index, t, TurningWith::B, counters) : nullptr;
    return turned != nullptr ? *turned : stateAt(index, t, counters);
}

const PairState* PairScene::turnedStateAt(std::int32_t index,
                                          double t,
                                          TurningWith with,
                                          ToiCounters& counters)
{
    const ScenePair& pair = m_pairs[static_cast<std::size_t>(index)];
    const bool ofB = with == TurningWith::B;
    if (pair.isRigid &&
        (ofB ? !pair.rigid.turnsB || pair.rigid.inFrameOfB : pair.rigid.rateA == 0.0))
    {
        return nullptr;
    }
    Turned& turned = m_turned[ofB ? 1 : 0];
    const bool isOther = turned.state.pair != index;
    if (isOther && pair.isRigid)
    {
        const auto bodies = *asRigidBodies(pair);
        turned.rigid = makeRigidPair(bodies[ofB ? 0 : 1], bodies[ofB ? 1 : 0], RigidFrame::OfB);
    }
    if (isOther || turned.state.time != t)
    {
        const PairState& state = stateAt(index, t, counters);
        turned.state = {.pair = index, .time = t, .rounding = state.rounding};
        if (pair.isRigid)
        {
            turned.state.motion = turned.rigid.at(t);
            turned.isUsable = true;
        }
        else
        {
            const auto seen = seenTurning(pair, state.motion, with, 1.0 - t);
            turned.isUsable = seen.has_value();
            turned.state.motion = seen.value_or(state.motion);
        }
    }
    return turned.isUsable ? &turned.state : nullptr;
}

void PairScene::computeState(std::int32_t index, double t, PairState& state)
{
    ScenePair& pair = m_pairs[static_cast<std::size_t>(index)];
    state.pair = index;
    state.time = t;
    RelativeMotion& m = state.motion;
    if (pair.isRigid)
    {
        m = pair.rigid.at(t);
        state.rounding = kRounding * (pair.rigid.reach + length(m.p) + pair.rigid.speed) +
                         1e-15 * pair.rigid.offset;
        return;
    }
    const TreeState a = treeStateAt(pair.sideA, pair.base, t);
    const TreeState b = treeStateAt(pair.sideB, pair.base, t);
    const Matrix3d toB = b.X.linear().transpose();
    const Matrix3d R = toB * a.X.linear();
    for (int i = 0; i < 9; ++i)
    {
        m.R[i] = R(i / 3, i % 3);
    }
    // A's reference is the origin of its tree, B's that of its body, `offsetB` away.
    copy(toB * (a.X.translation() - b.X.translation()), m.p);
    copy(Vector3d::Zero(), m.armA);
    copy(toB * a.w, m.wA);
    copy(toB * b.w, m.wB);
    copy(pair.sideA.offset, m.radiusArmA);
    copy(pair.sideB.offset, m.armB);
    const Vector3d wB = toB * b.w;
    const Vector3d velocity = toB * (a.v - b.v) + wB.cross(pair.sideB.offset);
    copy(velocity, m.velocity);
    m.spinA = a.w.norm();
    m.spinB = b.w.norm();
    m.constant = pair.sideA.acceleration.constant + pair.sideB.acceleration.constant;
    m.perRadiusA = pair.sideA.acceleration.perRadius;
    m.perRadiusB = pair.sideB.acceleration.perRadius;
    m.axisA = 0.0;
    m.axisB = 0.0;
    copy(toB * pair.plane, m.plane);
    m.acrossPlane = pair.acrossPlane;
    const double speed = velocity.norm() + m.spinA * pair.treeA->radius() +
                         m.spinB * (pair.treeB->radius() + pair.sideB.offset.norm());
    pair.speedScale = std::max(pair.speedScale, speed);
    state.rounding =
        kRounding *
        (a.X.translation().norm() + b.X.translation().norm() + pair.treeA->radius() +
         pair.treeB->radius() + pair.treeA->origin().norm() + pair.treeB->origin().norm() + speed);
}

Isometry3d PairScene::worldOfB(std::int32_t pair, double t) const
{
    const BodyPair& bodies = m_bodyPairs[static_cast<std::size_t>(pair)];
    const MovingBody& body = m_bodies[static_cast<std::size_t>(bodies.bodyB)];
    Isometry3d X = geometryPoseAt(body, t);
    X.translation() = X * body.tree->origin();
    return X;
}

bool PairScene::canShareBatch(const NodePair& p, const NodePair& first) const
{
    return p.pair == first.pair || (!m_pairs[static_cast<std::size_t>(p.pair)].inBatches &&
                                    !m_pairs[static_cast<std::size_t>(first.pair)].inBatches);
}

/// What all poses of a rigid pair have in common.
void PairScene::fillConstants(std::int32_t index)
{
    const ScenePair& pair = m_pairs[static_cast<std::size_t>(index)];
    const RigidPair& rigid = pair.rigid;
    NodeBatch& batch = m_batch;
    m_batchPair = index;
    for (int k = 0; k < 3; ++k)
    {
        setAll(batch.armA[k], static_cast<float>(rigid.armA[k]));
        setAll(batch.radiusArmA[k], static_cast<float>(rigid.armA[k]));
        setAll(batch.armB[k], static_cast<float>(rigid.armB[k]));
        setAll(batch.velocity[k], static_cast<float>(rigid.v[k]));
        setAll(batch.wA[k], static_cast<float>(rigid.wA[k]));
        setAll(batch.wB[k], static_cast<float>(rigid.wB[k]));
    }
    setAll(batch.spinA, up(rigid.spinA));
    setAll(batch.spinB, up(rigid.rateB));
    setAll(batch.constant, up(rigid.constant));
    setAll(batch.perRadiusA, up(rigid.perRadiusA));
    setAll(batch.perRadiusB, 0.0F);
    setAll(batch.axisA, static_cast<float>(rigid.axisA));
    setAll(batch.axisB, 1.0F);
    setAll(batch.margin, up(pair.limits.margin()));
    setAll(batch.speedSlack, up(kSingleRounding * rigid.speed));
    batch.turnsB = rigid.turnsB && !rigid.inFrameOfB;
    batch.hasRadius = rigid.perRadiusA > 0.0;
}

/// One lane from the state in double precision: links, motions supplied by the user, and bodies
/// that turn about a far point.
void PairScene::fillLane(int lane, const NodePair& p, ToiCounters& counters)
{
    const RelativeMotion& m = stateAt(p.pair, p.time, counters).motion;
    const ScenePair& pair = m_pairs[static_cast<std::size_t>(p.pair)];
    NodeBatch& batch = m_batch;
    for (int i = 0; i < 9; ++i)
    {
        batch.R[i][lane] = static_cast<float>(m.R[i]);
    }
    // The arm is turned here, in double precision, and the velocity taken at the tree's origin.
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(m.R);
    const Vector3d arm = R * Eigen::Map<const Vector3d>(m.armA);
    double place[3];
    double velocity[3];
    copy(Eigen::Map<const Vector3d>(m.p) + arm, place);
    copy(Eigen::Map<const Vector3d>(m.velocity) + Eigen::Map<const Vector3d>(m.wA).cross(arm),
         velocity);
    setLane(batch.p, lane, place);
    setLane(batch.armA, lane, {0.0, 0.0, 0.0});
    setLane(batch.velocity, lane, velocity);
    setLane(batch.wA, lane, m.wA);
    setLane(batch.wB, lane, m.wB);
    setLane(batch.armB, lane, m.armB);
    setLane(batch.radiusArmA, lane, m.radiusArmA);
    const double reach = pair.treeA->radius() + pair.treeB->radius();
    const auto i = static_cast<std::size_t>(lane);
    // |w x (w x r)| <= |w|^2 |r| in place of the term about the axis.
    batch.spinA[i] = up(m.spinA);
    batch.spinB[i] = up(m.spinB);
    batch.constant[i] = up(m.constant);
    batch.perRadiusA[i] = up(m.perRadiusA + m.axisA * m.spinA * m.spinA);
    batch.perRadiusB[i] = up(m.perRadiusB + m.axisB * m.spinB * m.spinB);
    batch.axisA[i] = 0.0F;
    batch.axisB[i] = 0.0F;
    batch.margin[i] = up(pair.limits.margin());
    batch.slack[i] = up(kSingleRounding * (reach + length(place)));
    batch.speedSlack[i] = up(kSingleRounding * (pair.speedScale + length(velocity)));
}

void PairScene::noteTriangles(std::int32_t index)
{
    m_pairs[static_cast<std::size_t>(index)].sawTriangles = true;
    constexpr std::int64_t kNodePairs = 4;  // cost as much
    spend(index, kNodePairs);
}

/// Notes so many looks at pairs of nodes. When profiles of all triangles cost less than what has
/// been spent, they are made.
void PairScene::spend(std::int32_t index, std::int64_t looks)
{
    ScenePair& pair = m_pairs[static_cast<std::size_t>(index)];
    const bool wasBefore = pair.untilTurn > 0;
    pair.untilTurn -= looks;
    if (wasBefore && pair.untilTurn <= 0)
    {
        lookAtTurn(index);
    }
}

/// Makes the profiles of a pair of which one rests in the frame of the query, or moves on without a
/// turn, and the other turns about an axis that does the same.
void PairScene::lookAtTurn(std::int32_t index)
{
    ScenePair& pair = m_pairs[static_cast<std::size_t>(index)];
    const Vector3d vA = velocityOf(pair.sideA);
    const Vector3d vB = velocityOf(pair.sideB);
    auto axis = axisOfTurn(pair.sideA, pair.base, vB);
    const bool turnsA = axis.has_value();
    const auto rest =
        turnsA ? poseAtRest(pair.sideB, pair.base, vA) : poseAtRest(pair.sideA, pair.base, vB);
    if (!turnsA)
    {
        axis = axisOfTurn(pair.sideB, pair.base, vA);
    }
    const auto isBuilt = [](const SsvTree& tree)
    { return tree.builtTriangles() == tree.mesh().triangles.size(); };
    if (!axis || !rest || !isBuilt(*pair.treeA) || !isBuilt(*pair.treeB))
    {
        return;
    }
    if (m_turningUsed == m_turning.size())
    {
        m_turning.emplace_back();
    }
    pair.turning = static_cast<std::int32_t>(m_turningUsed);
    TurningPair& turning = m_turning[m_turningUsed++];
    const Isometry3d X_TRest = axis->X_QT.inverse() * *rest;
    fillProfiles(*pair.treeA, turnsA ? axis->X_TG : X_TRest, turning.profiles[0]);
    fillProfiles(*pair.treeB, turnsA ? X_TRest : axis->X_TG, turning.profiles[1]);
    turning.rounding =
        kRounding * (pair.treeA->radius() + pair.treeB->radius() + axis->X_TG.translation().norm() +
                     X_TRest.translation().norm() + axis->X_QT.translation().norm());
}

/// The step of a pair of nodes that single precision did not get far.
float PairScene::flatStepOf(const NodePair& p, float step, ToiCounters& counters)
{
    const ScenePair& pair = m_pairs[static_cast<std::size_t>(p.pair)];
    constexpr double kShort = 0.5;
    const double size = static_cast<double>(nodeA(p).size() + nodeB(p).size());
    const bool hasFaces = !pair.treeA->faceSlabs().empty() || !pair.treeB->faceSlabs().empty();
    if (!hasFaces || static_cast<double>(step) * pair.speedScale > kShort * size)
    {
        return step;
    }
    const Step flat = flatStep(*pair.treeA,
                               *pair.treeB,
                               turningStateAt(p.pair, p.time, counters),
                               pair.limits.margin(),
                               p.nodeA,
                               p.nodeB);
    if (p.time == 0.0 && flat.gap <= pair.limits.threshold)
    {
        if (!pair.touchesAtStart)
        {
            return step;  // the triangles are to say whether they touch
        }
        m_mayStartTouching = true;
    }
    constexpr double kRoundDown = 1.0 - 1e-7;
    const auto longer =
        static_cast<float>(kRoundDown * std::min(flat.time, static_cast<double>(kEndless)));
    m_faces.note(longer > 2.0F * step);
    return std::max(step, longer);
}

/// What lies on a flat face is apart from it as a whole, although volumes of round parts and of
/// single precision do not show it: then all pairs of nodes go on at once.
void PairScene::lookAtWhole(std::int32_t index, double t, ToiCounters& counters)
{
    ScenePair& pair = m_pairs[static_cast<std::size_t>(index)];
    pair.nextLook = 4 * counters.nodePairs;
    constexpr bool kByVertices = true;
    const Step whole = flatStep(*pair.treeA,
                                *pair.treeB,
                                turningStateAt(index, t, counters),
                                pair.limits.margin(),
                                0,
                                0,
                                kByVertices);
    if (t == 0.0 && whole.gap <= pair.limits.threshold)
    {
        if (!pair.touchesAtStart)
        {
            return;  // the triangles are to say whether they touch
        }
        m_mayStartTouching = true;
    }
    pair.apartFrom = t;
    pair.apartUntil = std::nextafter(t + whole.time * (1.0 - 1e-15), 0.0);
}

void PairScene::lookAtFaces(std::span<const NodePair> nodePairs, ToiCounters& counters, float* out)
{
    if (m_faces.now())
    {
        for (std::size_t i = 0; i < nodePairs.size(); ++i)
        {
            out[i] = flatStepOf(nodePairs[i], out[i], counters);
        }
    }
    const std::int32_t first = nodePairs[0].pair;
    if (counters.nodePairs > m_pairs[static_cast<std::size_t>(first)].nextLook)
    {
        double earliest = nodePairs[0].time;
        for (const NodePair& p : nodePairs)
        {
            earliest = p.pair == first ? std::min(earliest, p.time) : earliest;
        }
        lookAtWhole(first, earliest, counters);
    }
    for (std::size_t i = 0; i < nodePairs.size(); ++i)
    {
        const ScenePair& pair = m_pairs[static_cast<std::size_t>(nodePairs[i].pair)];
        const double time = nodePairs[i].time;
        if (time >= pair.apartFrom && time < pair.apartUntil)
        {
            const double whole = std::min(static_cast<double>(kEndless), pair.apartUntil - time);
            out[i] = std::max(out[i], std::nextafter(static_cast<float>(whole), 0.0F));
        }
    }
}

void PairScene::steps(std::span<const NodePair> nodePairs, ToiCounters& counters, float* out)
{
    counters.nodePairs += static_cast<std::int64_t>(nodePairs.size());
    const ScenePair& pair = m_pairs[static_cast<std::size_t>(nodePairs[0].pair)];
    double times[NodeBatch::kLanes];
    for (std::size_t i = 0; i < NodeBatch::kLanes; ++i)
    {
        // Lanes without work repeat the first.
        const NodePair& p = nodePairs[i < nodePairs.size() ? i : 0];
        times[i] = p.time;
        m_batch.a[i] = &nodeA(p);
        m_batch.b[i] = &nodeB(p);
    }
    if (pair.inBatches)
    {
        if (m_batchPair != nodePairs[0].pair)
        {
            fillConstants(nodePairs[0].pair);
        }
        ++counters.states;
        rigidPoses(pair.poses,
                   times,
                   static_cast<float>(kSingleRounding),
                   up(kSingleRounding * pair.rigid.reach),
                   m_batch);
    }
    else
    {
        m_batchPair = kNone;
        m_batch.turnsB = true;
        m_batch.hasRadius = true;
        for (int lane = 0; lane < NodeBatch::kLanes; ++lane)
        {
            const auto i = static_cast<std::size_t>(lane);
            fillLane(lane, nodePairs[i < nodePairs.size() ? i : 0], counters);
        }
    }
    nodeSteps(m_batch);
    std::copy(m_batch.step, m_batch.step + nodePairs.size(), out);
    // Most queries are answered before this costs less than it saves.
    constexpr std::int64_t kManyPairs = 1000;
    if (m_hasFaces && counters.nodePairs > kManyPairs)
    {
        lookAtFaces(nodePairs, counters, out);
    }
    for (std::size_t i = 0; i < nodePairs.size(); ++i)
    {
        spend(nodePairs[i].pair, 1);
        if (m_turningUsed > 0 && neverMeets(nodePairs[i]))
        {
            out[i] = kEndless;
            continue;
        }
        if (times[i] == 0.0 && out[i] > 0.0F)
        {
            const PairLimits& limits = m_pairs[static_cast<std::size_t>(nodePairs[i].pair)].limits;
            m_mayStartTouching = m_mayStartTouching || static_cast<double>(m_batch.gap[i]) <=
                                                           limits.threshold - limits.floor;
        }
    }
}
}  // namespace bullet_ccd
