#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/toi/articulated/toi_scratch.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace bullet_ccd
{
ToiWorkspace::ToiWorkspace() : m_scratch(std::make_unique<Scratch>()) {}
ToiWorkspace::~ToiWorkspace() = default;
ToiWorkspace::ToiWorkspace(ToiWorkspace&&) noexcept = default;
ToiWorkspace& ToiWorkspace::operator=(ToiWorkspace&&) noexcept = default;

namespace
{
bool isFinite(const RigidMotion& m)
{
    return m.v_W.allFinite() && m.w_W.allFinite() && m.reference_B.allFinite();
}

bool isFinite(const std::vector<double>& values)
{
    return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

/// Messages are built only where they are needed: a query is to allocate nothing.
[[noreturn]] void fail(std::size_t body, const char* what)
{
    throw std::invalid_argument("time of impact: body " + std::to_string(body) + ": " + what);
}

void checkMotion(const RigidMotion& motion, std::size_t body)
{
    if (!isPose(motion.X_W0))
    {
        failPose("time of impact: X_W0 of body " + std::to_string(body), motion.X_W0);
    }
    if (!isFinite(motion))
    {
        fail(body, "a velocity or the reference point is NaN or infinite");
    }
}

void checkMotion(const LinkMotion& link, std::size_t body)
{
    if (link.tree == nullptr || link.motion == nullptr || link.link < 0 ||
        static_cast<std::size_t>(link.link) >= link.tree->size())
    {
        fail(body, "no kinematic tree, no motion of its joints, or no such link");
    }
    checkMotion(link.motion->root, body);
    if (!isFinite(link.motion->positions) || !isFinite(link.motion->rates) ||
        !std::all_of(link.motion->curves.begin(),
                     link.motion->curves.end(),
                     [](const JointCurve& curve)
                     { return std::isfinite(curve[0] + curve[1] + curve[2] + curve[3]); }))
    {
        fail(body, "a joint position, rate or curve is NaN or infinite");
    }
    if (!link.motion->curves.empty() && link.motion->curves.size() != link.tree->size())
    {
        fail(body, "there is not one curve a link: give one each, or none");
    }
}

void checkMotion(const UserMotion* motion, std::size_t body)
{
    if (motion == nullptr)
    {
        fail(body, "the motion is a null pointer");
    }
}

void checkQuery(std::span<const MovingBody> bodies,
                std::span<const BodyPair> pairs,
                const ToiOptions& options)
{
    checkOptions(options);
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        const MovingBody& body = bodies[i];
        if (body.tree == nullptr || body.tree->nodes().empty())
        {
            fail(i, "there is no hierarchy: build one with buildSsvTree()");
        }
        if (!isPose(body.X_BG))
        {
            failPose("time of impact: X_BG of body " + std::to_string(i), body.X_BG);
        }
        std::visit([i](const auto& motion) { checkMotion(motion, i); }, body.motion);
    }
    const auto count = static_cast<std::int32_t>(bodies.size());
    for (const BodyPair& pair : pairs)
    {
        require(pair.bodyA >= 0 && pair.bodyA < count && pair.bodyB >= 0 && pair.bodyB < count,
                "time of impact: a pair names a body that is not there");
    }
}
}  // namespace

void checkOptions(const ToiOptions& options)
{
    require(options.tolerance > 0.0 && std::isfinite(options.tolerance),
            "time of impact: the tolerance must be positive and finite");
    require(options.minimumSeparation >= 0.0 && std::isfinite(options.minimumSeparation),
            "time of impact: the minimum separation must not be negative and must be finite");
    require(options.aim > 0.0 && options.aim <= 0.5,
            "time of impact: aim must be in (0, 1/2]; 1/4096 is usual");
}

namespace
{
/// The earliest hit, in W, or what is known without one.
FirstContactResult describe(SearchState& state)
{
    if (state.hit.found())
    {
        return describeHit(state);
    }
    FirstContactResult result;
    result.gap = state.options.minimumSeparation + state.options.aim * state.options.tolerance;
    for (std::int32_t i = 0; i < state.scene.size(); ++i)
    {
        result.gap = std::min(result.gap, state.scene.pair(i).limits.margin());
    }
    return result;
}
}  // namespace

FirstContactResult firstContact(std::span<const MovingBody> bodies,
                                std::span<const BodyPair> pairs,
                                const ToiOptions& options,
                                ToiWorkspace& work)
{
    checkQuery(bodies, pairs, options);
    SearchState& state = work.scratch().state;
    state.reset(options);
    state.scene.reset(bodies, pairs, options);
    FirstContactResult result;
    try
    {
        searchScene(state);
        result = describe(state);
        const bool mayPress = state.start.touches || state.scene.mayStartTouching();
        if (result.status == ToiStatus::Hit && mayPress && !state.start.approaches)
        {
            state.start.approaches = pressesFromStart(state);
            state.start.touches = state.start.touches || state.start.approaches;
        }
    }
    catch (const GaveUp& end)
    {
        result.status = end.status;
        result.time = end.time;
        result.pair = end.pair;
    }
    result.counters = state.counters;
    result.startsTouching = state.start.touches;
    result.mayStartTouching = state.scene.mayStartTouching();
    result.startsPressing = state.start.approaches;
    return result;
}

Eigen::Isometry3d geometryPoseAt(const MovingBody& body, double t)
{
    if (const auto* link = std::get_if<LinkMotion>(&body.motion))
    {
        if (link->frames != nullptr)
        {
            const LinkPlace& place = link->frames->place(link->link);
            return link->frames->stateAt(0, place.frame, t).X_W * place.X_FL * body.X_BG;
        }
        return linkStateAt(*link->tree, *link->motion, kNone, link->link, t).X_W * body.X_BG;
    }
    if (const auto* user = std::get_if<const UserMotion*>(&body.motion))
    {
        return (*user)->at(t).X_W * body.X_BG;
    }
    return std::get<RigidMotion>(body.motion).at(t).X_W * body.X_BG;
}
}  // namespace bullet_ccd
