#include "bullet_ccd/bullet/step/btCcdTriggers.h"

#include "bullet_ccd/bullet/btCcdConversions.h"
#include "bullet_ccd/bullet/step/btCcdContext.h"
#include "bullet_ccd/bullet/step/btCcdPairToi.h"
#include "bullet_ccd/bullet/step/btCcdStepper.h"
#include "bullet_ccd/bullet/step/btCcdTracker.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

namespace
{
/// A trigger that comes farther than this times its reach, and more than twice as far as before,
/// has been put there.
constexpr double kTriggerJump = 4.0;

int linkOf(const btCollisionObject& object)
{
    const auto* collider = btMultiBodyLinkCollider::upcast(&object);
    return collider != nullptr ? collider->m_link : btCcdImpact::kNoLink;
}

/// A ghost, or a body that is put where it is.
bool isPlaced(const btCollisionObject& object)
{
    return btMultiBodyLinkCollider::upcast(&object) == nullptr &&
           (btRigidBody::upcast(&object) == nullptr || object.isStaticOrKinematicObject());
}

bool isTrigger(const btCcdTracked& tracked)
{
    return tracked.m_usable && !tracked.m_object->hasContactResponse() &&
           tracked.m_object->getBroadphaseHandle() != nullptr;
}

btCcdBox boxOf(const btCcdObjectMotion& motion, double reach)
{
    const Eigen::AlignedBox3d box = motion.boxOf(Eigen::Vector3d::Zero(), reach);
    return {btCcdToBullet(Eigen::Vector3d(box.min())), btCcdToBullet(Eigen::Vector3d(box.max()))};
}

void extend(btCcdBox& box, const btCcdBox& other)
{
    box.m_low.setMin(other.m_low);
    box.m_high.setMax(other.m_high);
}

/// How far any point of the link may come in the step [m]; what is without contact response is not
/// followed elsewhere.
double wayOf(const btMultiBodyLinkCollider& link, double reach, double timeStep)
{
    std::vector<double> speeds;
    btCcdReadSpeeds(*link.m_multiBody, timeStep, speeds);
    const double* speed = &speeds[2 * std::size_t(link.m_link + 1)];
    return timeStep * (speed[0] + speed[1] * reach);
}
}  // namespace

btCcdTriggers::btCcdTriggers(btCollisionWorld& world)
    : m_world(world), m_context(btCcdContext::of(*world.getDispatcher()))
{
}

void btCcdTriggers::begin(btCcdStepper& stepper, btScalar timeStep)
{
    const bool wasActive = m_isActive;
    m_isActive = stepper.tracker().seesTriggers();
    if (!m_isActive && !wasActive)
    {
        return;
    }
    m_passages.clear();
    m_pieces.clear();
    m_timeStep = double(timeStep);
    if (!m_isActive)
    {
        m_states.clear();
        m_places.clear();
        return;
    }
    BT_PROFILE("btCcdTriggers::begin");
    stepper.readyMotions();
    readWays(stepper);
    addPiece(stepper, 0.0, nullptr);
}

/// How triggers that have been put where they are came there since the last step.
void btCcdTriggers::readWays(const btCcdStepper& stepper)
{
    m_ways.clear();
    std::unordered_map<const btCollisionObject*, Place> places;
    for (const btCcdTracked& tracked : stepper.tracker().objects())
    {
        if (!isTrigger(tracked) || !isPlaced(*tracked.m_object))
        {
            continue;
        }
        const btTransform& pose = tracked.m_object->getWorldTransform();
        Place place{tracked.m_proxy, pose, 0.0};
        bullet_ccd::RigidMotion way = bullet_ccd::restAt(btCcdToEigen(pose));
        const auto known = m_places.find(tracked.m_object);
        if (known != m_places.end() && known->second.m_proxy == tracked.m_proxy &&
            !stepper.tracker().isTeleported(*tracked.m_object))
        {
            place.m_length = double((pose.getOrigin() - known->second.m_pose.getOrigin()).length());
            const bool hasJumped = place.m_length > kTriggerJump * tracked.outline().m_reach &&
                                   place.m_length > 2.0 * known->second.m_length;
            if (!hasJumped && !(pose == known->second.m_pose))
            {
                way = bullet_ccd::motionBetween(btCcdToEigen(known->second.m_pose),
                                                btCcdToEigen(pose));
            }
        }
        places.emplace(tracked.m_object, place);
        m_ways.emplace(tracked.m_object, way);
    }
    m_places.swap(places);
}

/// @param others of the world's objects, those that may be near triggers; null: all
void btCcdTriggers::addPiece(btCcdStepper& stepper, double time, const std::vector<int>* others)
{
    const std::vector<btCcdTracked>& objects = stepper.tracker().objects();
    Piece& piece = m_pieces.emplace_back();
    piece.m_time = time;
    btCcdBox all;
    for (const btCcdTracked& tracked : objects)
    {
        if (Path path; isTrigger(tracked) && readPath(stepper, tracked, piece, path))
        {
            extend(all, path.m_box);
            piece.m_paths.push_back(std::move(path));
        }
    }
    piece.m_triggers = piece.m_paths.size();
    const auto meetsTrigger = [&](const btCcdBox& box)
    {
        return box.meets(all) &&
               std::any_of(piece.m_paths.begin(),
                           piece.m_paths.begin() + std::ptrdiff_t(piece.m_triggers),
                           [&](const Path& path) { return path.m_box.meets(box); });
    };
    const auto add = [&](const btCcdTracked& tracked, bool isKnown)
    {
        if (!tracked.m_tracked || isTrigger(tracked) ||
            (!isKnown && !meetsTrigger(stepper.tracker().placeOf(tracked))))
        {
            return;
        }
        const bool goesOn =
            isKnown && !std::ranges::binary_search(stepper.changedObjects(),
                                                   tracked.m_object->getWorldArrayIndex());
        if (Path path;
            ((goesOn && goOn(tracked, path)) || readPath(stepper, tracked, piece, path)) &&
            (!isKnown || meetsTrigger(path.m_box)))
        {
            piece.m_paths.push_back(std::move(path));
        }
    };
    if (others == nullptr)
    {
        for (const btCcdTracked& tracked : objects)
        {
            add(tracked, false);
        }
        return;
    }
    for (const int index : *others)
    {
        add(objects[std::size_t(index)], true);
    }
}

/// The rest of a path of the piece before, of a rigid body that goes on as it did. So it need not
/// be moved to where it is now, which would round its way otherwise. False if there is none.
bool btCcdTriggers::goOn(const btCcdTracked& tracked, Path& path) const
{
    const Piece& last = m_pieces[m_pieces.size() - 2];
    const auto former = std::ranges::find(last.m_paths, tracked.m_object, &Path::m_object);
    if (former == last.m_paths.end() || !(last.m_time < m_timeStep))
    {
        return false;
    }
    const auto* motion = std::get_if<bullet_ccd::RigidMotion>(&former->m_motion.m_motion);
    if (motion == nullptr)
    {
        return false;
    }
    path = *former;
    const double gone = (m_pieces.back().m_time - last.m_time) / (m_timeStep - last.m_time);
    path.m_motion.m_motion = bullet_ccd::partOf(*motion, gone, 1.0);
    return true;
}

/// False if it cannot be told how the object moves.
bool btCcdTriggers::readPath(btCcdStepper& stepper,
                             const btCcdTracked& tracked,
                             Piece& piece,
                             Path& path)
{
    btCollisionObject& object = *tracked.m_object;
    const double reach = tracked.outline().m_reach + 2.0 * m_context.m_tolerance;
    path.m_object = &object;
    path.m_proxy = tracked.m_proxy;
    path.m_isTrigger = isTrigger(tracked);
    const auto* link = btMultiBodyLinkCollider::upcast(&object);
    if (const auto way = m_ways.find(&object); path.m_isTrigger && way != m_ways.end())
    {
        path.m_motion = {bullet_ccd::partOf(way->second, piece.m_time / m_timeStep, 1.0)};
        path.m_isFixed = way->second.v_W.isZero(0.0) && way->second.w_W.isZero(0.0);
    }
    else
    {
        const btCcdObjectMotion* motion = stepper.motionOf(object);
        if (motion == nullptr)
        {
            return false;
        }
        path.m_motion = *motion;
        path.m_isFixed = object.isStaticObject() && !object.isKinematicObject() && link == nullptr;
    }
    const btCcdMultiBodyMotion* links =
        link != nullptr ? stepper.multiBodyMotionOf(object) : nullptr;
    if (links != nullptr)
    {
        // The stepper's own is about to change.
        piece.m_multiBodies.push_back(std::make_unique<btCcdMultiBodyMotion>(*links));
        path.m_motion = btCcdLinkMotion(*link, *piece.m_multiBodies.back());
        path.m_motion.m_way = wayOf(*link, reach, m_timeStep);
    }
    path.m_box = boxOf(path.m_motion, reach);
    return path.m_motion.isFinite();
}

void btCcdTriggers::changed(btCcdStepper& stepper, btScalar time)
{
    if (!m_isActive || m_pieces.back().m_paths.empty())
    {
        return;
    }
    const std::vector<btCcdTracked>& objects = stepper.tracker().objects();
    const Piece& last = m_pieces.back();
    std::vector<int> others;
    for (std::size_t i = last.m_triggers; i < last.m_paths.size(); ++i)
    {
        others.push_back(last.m_paths[i].m_object->getWorldArrayIndex());
    }
    bool all = false;
    const std::size_t known = others.size();
    std::sort(others.begin(), others.end());
    bool isNews = false;
    for (const int index : stepper.changedObjects())
    {
        const btCcdTracked& tracked = objects[std::size_t(index)];
        all = all || isTrigger(tracked);
        const bool isKnown =
            std::binary_search(others.begin(), others.begin() + std::ptrdiff_t(known), index);
        isNews = isNews || isKnown;
        Piece scratch;
        if (Path path;
            !isKnown && tracked.m_tracked && !isTrigger(tracked) &&
            readPath(stepper, tracked, scratch, path) &&
            std::any_of(last.m_paths.begin(),
                        last.m_paths.begin() + std::ptrdiff_t(last.m_triggers),
                        [&](const Path& trigger) { return trigger.m_box.meets(path.m_box); }))
        {
            isNews = true;
            others.push_back(index);
        }
    }
    if (all)
    {
        others.resize(objects.size());
        std::iota(others.begin(), others.end(), 0);
    }
    if (all || isNews)
    {
        addPiece(stepper, double(time), &others);
    }
}

void btCcdTriggers::end()
{
    if (!m_isActive)
    {
        return;
    }
    BT_PROFILE("btCcdTriggers::end");
    for (auto& [key, state] : m_states)
    {
        state.m_isNear = state.m_hasPassage = false;
    }
    for (std::size_t i = 0; i < m_pieces.size(); ++i)
    {
        ask(m_pieces[i], i + 1 < m_pieces.size() ? m_pieces[i + 1].m_time : m_timeStep);
    }
    m_pieces.clear();
    const auto isThere = [this](btCollisionObject* object, int proxy)
    {
        const btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
        return objects.findLinearSearch(object) < objects.size() &&
               object->getBroadphaseHandle() != nullptr &&
               object->getBroadphaseHandle()->m_uniqueId == proxy;
    };
    for (auto& [key, state] : m_states)
    {
        if (state.m_hasPassage && (state.m_isNear || (isThere(key.m_trigger, key.m_triggerProxy) &&
                                                      isThere(key.m_object, key.m_objectProxy))))
        {
            state.m_passage.m_triggerLink = linkOf(*key.m_trigger);
            state.m_passage.m_objectLink = linkOf(*key.m_object);
            m_passages.push_back(state.m_passage);
        }
    }
    std::erase_if(m_states, [](const auto& known) { return !known.second.m_isNear; });
    const auto placeInOrder = [](const btCcdPassage& passage)
    {
        return std::tuple(passage.m_enterTime,
                          passage.m_trigger->getWorldArrayIndex(),
                          passage.m_object->getWorldArrayIndex());
    };
    std::sort(m_passages.begin(),
              m_passages.end(),
              [&](const btCcdPassage& a, const btCcdPassage& b)
              { return placeInOrder(a) < placeInOrder(b); });
}

/// From the begin of the piece until `end`.
void btCcdTriggers::ask(const Piece& piece, double end)
{
    for (auto& [key, state] : m_states)
    {
        state.m_isSeen = false;
    }
    const auto isInside = [this](const Key& key)
    {
        const auto known = m_states.find(key);
        return known != m_states.end() && known->second.m_isInside;
    };
    for (std::size_t i = 0; i < piece.m_triggers; ++i)
    {
        const Path& trigger = piece.m_paths[i];
        for (const Path& object : piece.m_paths)
        {
            const bool isFixed = trigger.m_isFixed && object.m_isFixed;
            if (&object != &trigger && trigger.m_box.meets(object.m_box) &&
                (!isFixed || isInside(keyOf(trigger, object))) &&
                mayMeet(*trigger.m_object, *object.m_object))
            {
                ask(trigger, object, piece, end);
            }
        }
    }
    for (auto& [key, state] : m_states)
    {
        if (state.m_isInside && !state.m_isSeen)
        {
            // It has been put elsewhere, or is not looked at any more.
            btCcdPassage& passage = passageOf(state, key);
            passage.m_isInside = state.m_isInside = false;
            passage.m_exitTime = btScalar(piece.m_time);
        }
    }
}

/// The passage of this step; a new one begins inside if that is the state.
btCcdPassage& btCcdTriggers::passageOf(State& state, const Key& key) const
{
    if (!state.m_hasPassage)
    {
        state.m_hasPassage = true;
        state.m_passage = {};
        state.m_passage.m_trigger = key.m_trigger;
        state.m_passage.m_object = key.m_object;
        state.m_passage.m_wasInside = state.m_passage.m_isInside = state.m_isInside;
        state.m_passage.m_exitTime = btScalar(m_timeStep);
        state.m_passage.m_point.setZero();
        state.m_passage.m_normal.setZero();
    }
    return state.m_passage;
}

/// True for two that stand where they stood when they were asked for last.
bool btCcdTriggers::isAsBefore(State& state, const Path& trigger, const Path& object)
{
    const auto* wayOfTrigger = std::get_if<bullet_ccd::RigidMotion>(&trigger.m_motion.m_motion);
    const auto* wayOfObject = std::get_if<bullet_ccd::RigidMotion>(&object.m_motion.m_motion);
    const auto isStill = [](const bullet_ccd::RigidMotion* way)
    { return way != nullptr && way->v_W.isZero(0.0) && way->w_W.isZero(0.0); };
    if (!isStill(wayOfTrigger) || !isStill(wayOfObject))
    {
        state.m_isStill = false;
        return false;
    }
    const bool isAsBefore = state.m_isStill &&
                            state.m_poseOfTrigger.matrix() == wayOfTrigger->X_W0.matrix() &&
                            state.m_poseOfObject.matrix() == wayOfObject->X_W0.matrix();
    state.m_isStill = true;
    state.m_poseOfTrigger = wayOfTrigger->X_W0;
    state.m_poseOfObject = wayOfObject->X_W0;
    return isAsBefore;
}

void btCcdTriggers::ask(const Path& trigger, const Path& object, const Piece& piece, double end)
{
    if (m_context.model(trigger.m_object->getCollisionShape()) == nullptr ||
        m_context.model(object.m_object->getCollisionShape()) == nullptr)
    {
        return;
    }
    const Key key = keyOf(trigger, object);
    State& state = m_states[key];
    state.m_isNear = state.m_isSeen = true;
    const btVector3 place =
        btCcdToBullet(Eigen::Vector3d(btCcdShapePoseAt(object.m_motion, 0.0).translation()));
    if (state.m_isInside && !state.m_hasPassage)
    {
        passageOf(state, key).m_point = place;
    }
    if (isAsBefore(state, trigger, object))
    {
        return;
    }
    const btCcdPairToi first = touch(trigger, object);
    const bool touchesAtOnce = first.m_status == bullet_ccd::ToiStatus::Overlapping;
    if (state.m_isInside && !touchesAtOnce)
    {
        state.m_isInside = false;
        state.m_passage.m_exitTime = btScalar(piece.m_time);
    }
    const double rest = m_timeStep - piece.m_time;
    const double last = rest > 0.0 ? std::clamp((end - piece.m_time) / rest, 0.0, 1.0) : 0.0;
    if (touchesAtOnce || (first.m_fraction < 1.0 && first.m_fraction <= last))
    {
        if (!state.m_hasPassage)
        {
            btCcdPassage& passage = passageOf(state, key);
            passage.m_enterTime = btCcdRoundDown(piece.m_time + first.m_fraction * rest);
            passage.m_point = touchesAtOnce ? place : btCcdToBullet(first.m_pointB);
            passage.m_normal = touchesAtOnce ? btVector3(0, 0, 0) : btCcdToBullet(first.m_normal);
        }
        const double left = std::max(first.m_fraction, lastTouch(trigger, object, last));
        state.m_isInside = left >= last;
        state.m_passage.m_exitTime =
            btScalar(state.m_isInside ? m_timeStep : piece.m_time + left * rest);
    }
    if (state.m_hasPassage)
    {
        state.m_passage.m_isInside = state.m_isInside;
    }
}

btCcdPairToi btCcdTriggers::touch(const Path& a, const Path& b)
{
    const btCcdShapeModel* modelA = m_context.model(a.m_object->getCollisionShape());
    const btCcdShapeModel* modelB = m_context.model(b.m_object->getCollisionShape());
    return btCcdTimeOfTouch({*modelA, a.m_motion},
                            {*modelB, b.m_motion},
                            m_context.toleranceOf(*a.m_object, *b.m_object));
}

/// The last time at which the two touch, or one is in the other, of the part of their motions up to
/// `last`: the first one on the way back. Negative if they do not touch.
double btCcdTriggers::lastTouch(const Path& a, const Path& b, double last)
{
    std::array<bullet_ccd::JointMotion, 2> links;
    const auto wayBack = [last](const Path& path, bullet_ccd::JointMotion& backwards)
    {
        Path back = path;
        if (auto* rigid = std::get_if<bullet_ccd::RigidMotion>(&back.m_motion.m_motion))
        {
            *rigid = bullet_ccd::partOf(*rigid, last, 0.0);
            return back;
        }
        auto& link = std::get<bullet_ccd::LinkMotion>(back.m_motion.m_motion);
        backwards = bullet_ccd::partOf(*link.motion, last, 0.0);
        link.motion = &backwards;
        return back;
    };
    const btCcdPairToi touching = touch(wayBack(a, links[0]), wayBack(b, links[1]));
    const bool touches =
        touching.m_status == bullet_ccd::ToiStatus::Overlapping || touching.m_fraction < 1.0;
    return touches ? (1.0 - touching.m_fraction) * last : -1.0;
}

/// As Bullet asks before it looks for contacts; also of two that sleep.
bool btCcdTriggers::mayMeet(const btCollisionObject& a, const btCollisionObject& b) const
{
    return a.checkCollideWith(&b) && b.checkCollideWith(&a) &&
           m_world.getPairCache()->needsBroadphaseCollision(
               const_cast<btBroadphaseProxy*>(a.getBroadphaseHandle()),
               const_cast<btBroadphaseProxy*>(b.getBroadphaseHandle())) &&
           (!(a.isActive() || b.isActive()) || m_world.getDispatcher()->needsCollision(&a, &b));
}

void btCcdTriggers::tell(btCcdImpactListener* listener)
{
    if (listener == nullptr || m_passages.empty())
    {
        return;
    }
    // What the listener removes is not told of any more.
    btCollisionObjectArray& objects = m_world.getCollisionObjectArray();
    const auto isGone = [&](const btCcdPassage& passage)
    {
        return objects.findLinearSearch(passage.m_trigger) == objects.size() ||
               objects.findLinearSearch(passage.m_object) == objects.size();
    };
    for (std::size_t i = 0; i < m_passages.size(); ++i)
    {
        if (!isGone(m_passages[i]))
        {
            listener->onPassage(m_passages[i]);
        }
    }
    std::erase_if(m_passages, isGone);
}
