/// Steps of links by bounds of first order: what the literature does, to be compared with.
#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/toi/search/pair_scene.h"

#include <algorithm>
#include <limits>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Distance of the farthest point of a node from the origin of the frame that its link is fixed to.
double reachOf(const PairSide& side, const SsvNode& node)
{
    return (side.X * place(node).center).norm() + static_cast<double>(node.size());
}

/// Of one side along n, over the time ahead.
double speedOf(const PairSide& side,
               std::int32_t base,
               MotionBound bound,
               const Vector3d& n,
               double t,
               double ahead,
               double reach)
{
    if (side.frames == nullptr)
    {
        // No link: as rigid bodies are bounded, with room for what their speed may change by.
        const MotionState now = std::get<RigidMotion>(side.body->motion).at(t);
        const double spin = now.w_W.norm();
        const double change = ahead * (side.acceleration.constant);
        return n.dot(now.v_W) + change + spin * reach;
    }
    if (bound == MotionBound::Directional)
    {
        return side.frames->directionalSpeed(base, side.frame, n, t, ahead, reach);
    }
    const SpeedBound speed = side.frames->speedBound(base, side.frame);
    return speed.constant + speed.perRadius * reach;
}
}  // namespace

double PairScene::firstOrderTime(const NodePair& p, double gap, const Vector3d& n)
{
    const ScenePair& pair = m_pairs[static_cast<std::size_t>(p.pair)];
    const double reachA = reachOf(pair.sideA, nodeA(p));
    const double reachB = reachOf(pair.sideB, nodeB(p));
    const double left = std::max(1.0 - p.time, 0.0);
    double ahead = left;
    double best = 0.0;
    // The shorter the time ahead, the sharper the bound, which then must not be used beyond it.
    for (int i = 0; i < 4; ++i)
    {
        const double speed = speedOf(pair.sideA, pair.base, m_bound, n, p.time, ahead, reachA) +
                             speedOf(pair.sideB, pair.base, m_bound, -n, p.time, ahead, reachB);
        const double time = speed > 0.0 ? gap / speed : std::numeric_limits<double>::infinity();
        if (time >= ahead)
        {
            return ahead < left ? std::max(best, ahead) : std::numeric_limits<double>::infinity();
        }
        best = std::max(best, time);
        ahead = 2.0 * best;
    }
    return best;
}

double PairScene::firstOrderTime(const NodePair& p, ToiCounters& counters)
{
    const RelativeMotion& m = stateAt(p.pair, p.time, counters).motion;
    ScenePair& pair = m_pairs[static_cast<std::size_t>(p.pair)];
    const double margin = pair.limits.margin() + m_state.rounding;
    const Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.R);
    const PlacedSsv a = place(nodeA(p), R, Eigen::Map<const Vector3d>(m.p));
    const PlacedSsv b = place(nodeB(p));
    const Matrix3d toBase = m_axesOfB;
    double best = 0.0;
    forEachSeparatingAxis(a,
                          b,
                          [&](double gap, const auto& along)
                          {
                              if (gap <= margin)
                              {
                                  return false;
                              }
                              Vector3d n;
                              for (Eigen::Index k = 0; k < 3; ++k)
                              {
                                  n[k] = along(Vector3d(a.axes.row(k).transpose()),
                                               Vector3d(b.axes.row(k).transpose()));
                              }
                              const double time =
                                  firstOrderTime(p, gap - margin, (toBase * n).normalized());
                              best = std::max(best, time);
                              return false;
                          });
    return std::min(best, 2.0);
}

void PairScene::firstOrderSteps(std::span<const NodePair> nodePairs,
                                ToiCounters& counters,
                                float* out)
{
    for (std::size_t i = 0; i < nodePairs.size(); ++i)
    {
        // Rounded towards zero.
        out[i] = static_cast<float>(firstOrderTime(nodePairs[i], counters)) * (1.0F - 2e-7F);
        m_mayStartTouching = m_mayStartTouching || nodePairs[i].time == 0.0;
    }
}

double PairScene::firstOrderTime(const NodePair& p, const TriangleDistance& found)
{
    const ScenePair& pair = m_pairs[static_cast<std::size_t>(p.pair)];
    const double gap = found.distance - pair.limits.margin() - m_state.rounding;
    const Vector3d n = m_axesOfB * (found.pointB - found.pointA).stableNormalized();
    return gap > 0.0 ? std::min(firstOrderTime(p, gap, n), 2.0) : 0.0;
}
}  // namespace bullet_ccd
