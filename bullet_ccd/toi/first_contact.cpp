#include "bullet_ccd/toi/first_contact.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/toi/articulated/toi_scratch.h"
#include "bullet_ccd/toi/search/search.h"

#include <algorithm>
#include <cmath>

namespace bullet_ccd
{
ToiWorkspace::ToiWorkspace() : m_scratch(std::make_unique<Scratch>()) {}
ToiWorkspace::~ToiWorkspace() = default;
ToiWorkspace::ToiWorkspace(ToiWorkspace&&) noexcept = default;
ToiWorkspace& ToiWorkspace::operator=(ToiWorkspace&&) noexcept = default;

namespace
{
bool isFinite(const MovingBody& body)
{
    const auto rigid = [](const RigidMotion& m)
    {
        return m.X_W0.matrix().allFinite() && m.v_W.allFinite() && m.w_W.allFinite() &&
               m.reference_B.allFinite();
    };
    const auto all = [](const std::vector<double>& values) {
        return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
    };
    if (const auto* link = std::get_if<LinkMotion>(&body.motion))
    {
        return rigid(link->motion->root) && all(link->motion->positions) &&
               all(link->motion->rates);
    }
    const auto* free = std::get_if<RigidMotion>(&body.motion);
    return free == nullptr || rigid(*free);
}

void checkQuery(std::span<const MovingBody> bodies, const ToiOptions& options)
{
    checkOptions(options);
    for (const MovingBody& body : bodies)
    {
        require(isFinite(body),
                "time of impact: a pose, velocity or joint position is NaN or infinite");
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
    checkQuery(bodies, options);
    SearchState& state = work.scratch().state;
    state.hit = {};
    state.start = {};
    state.counters = {};
    state.begin = 0.0;
    state.end = 1.0;
    state.options = options;
    state.scene.reset(bodies, pairs, options);
    FirstContactResult result;
    try
    {
        searchScene(state);
        result = describe(state);
    }
    catch (const IterationLimitReached& limit)
    {
        result.status = ToiStatus::IterationLimit;
        result.time = limit.time;
        result.pair = limit.pair;
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
        return linkStateAt(*link->tree, *link->motion, kNone, link->link, t).X_W * body.X_BG;
    }
    if (const auto* user = std::get_if<const UserMotion*>(&body.motion))
    {
        return (*user)->at(t).X_W * body.X_BG;
    }
    return std::get<RigidMotion>(body.motion).at(t).X_W * body.X_BG;
}
}  // namespace bullet_ccd
