#include "bullet_ccd/contact/near_slots.h"

#include "bullet_ccd/distance/ssv_pair.h"
#include "bullet_ccd/distance/triangle_distance.h"

#include <algorithm>
#include <array>

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRoom = 0.5;         // of kept pairs, over the threshold
constexpr double kMostRoom = 4.0;     // same, where nothing is near
constexpr double kLeastUses = 3.0;    // of kept pairs, as far as the last motion tells
constexpr double kPlaneSlack = 1e-6;  // of a bound, over the threshold, for rounding

/// True if the volumes are farther apart than the threshold along an axis of either. The other nine
/// separating axes cost more than the pairs that they would spare: triangles are told apart by
/// their planes, too.
bool isApart(const PlacedSsv& a, const PlacedSsv& b, double threshold)
{
    const Vector3d D = b.center - a.center;
    const double slack = a.radius + b.radius + threshold + 4e-6 * (a.size() + b.size() + D.norm());
    const double reach = a.coreRadius + b.coreRadius + slack;
    if (D.squaredNorm() > reach * reach)
    {
        return true;
    }
    const Matrix3d C = (a.axes.transpose() * b.axes).cwiseAbs();
    const Vector3d alongA = (a.axes.transpose() * D).cwiseAbs() - a.half - C * b.half;
    const Vector3d alongB = (b.axes.transpose() * D).cwiseAbs() - b.half - C.transpose() * a.half;
    return alongA.maxCoeff() > slack || alongB.maxCoeff() > slack;
}

/// How far x is off the plane of y, at least; negative if the plane cuts it.
double heightOver(const std::array<Vector3d, 3>& y, const std::array<Vector3d, 3>& x)
{
    const Vector3d normal = (y[1] - y[0]).cross(y[2] - y[0]).stableNormalized();
    const auto [low, high] =
        std::minmax({normal.dot(x[0] - y[0]), normal.dot(x[1] - y[0]), normal.dot(x[2] - y[0])});
    return std::max(low, -high);
}
}  // namespace

void collectNearSlots(const SsvTree& treeA,
                      const SsvTree& treeB,
                      const Matrix3d& R,
                      const Vector3d& p,
                      double threshold,
                      IndexPairs& open,
                      IndexPairs& slots,
                      const StopCondition& stop)
{
    StopCheck check(stop);
    const Matrix3d inverseR = R.transpose();
    const Vector3d inverseP = -(inverseR * p);
    const auto nodeA = [&](std::int32_t i) -> const SsvNode&
    { return treeA.nodes()[static_cast<std::size_t>(i)]; };
    const auto nodeB = [&](std::int32_t i) -> const SsvNode&
    { return treeB.nodes()[static_cast<std::size_t>(i)]; };
    slots.clear();
    open.clear();
    if (!isApart(place(nodeA(0), R, p), place(nodeB(0)), threshold))
    {
        open.emplace_back(0, 0);
    }
    while (!open.empty())
    {
        check.look();
        const auto [a, b] = open.back();
        open.pop_back();
        const SsvNode& ofA = nodeA(a);
        const SsvNode& ofB = nodeB(b);
        if (ofA.isLeaf() && ofB.isLeaf())
        {
            slots.emplace_back(ofA.first, ofB.first);
            continue;
        }
        const bool openA = ofB.isLeaf() || (!ofA.isLeaf() && ofA.size() >= ofB.size());
        // In the frame of the one that is opened: only the other has to be turned, once.
        const PlacedSsv whole = openA ? place(ofB, inverseR, inverseP) : place(ofA, R, p);
        const SsvNode& opened = openA ? ofA : ofB;
        (openA ? treeA : treeB).open(opened);
        for (std::int32_t child = opened.first; child < opened.first + opened.count; ++child)
        {
            if (!isApart(place(openA ? nodeA(child) : nodeB(child)), whole, threshold))
            {
                open.emplace_back(openA ? child : a, openA ? b : child);
            }
        }
    }
}

void KeptSlots::collect(const SsvTree& treeA,
                        const SsvTree& treeB,
                        const Matrix3d& R,
                        const Vector3d& p,
                        double threshold,
                        IndexPairs& open,
                        IndexPairs& slots)
{
    const Place now{R, p};
    const double step = m_asked.wayTo(now, treeA.radius());
    double way = m_collected.wayTo(now, treeA.radius());
    m_asked = now;
    if (m_reach < threshold + way)
    {
        const bool isFirst = m_room == 0.0;
        const double room = m_room;
        m_room = kRoom * threshold;
        if (isFirst || kLeastUses * step > room)
        {
            m_reach = -1.0;
            collectNearSlots(treeA, treeB, R, p, threshold, open, slots);
            return;
        }
        m_collected = now;
        m_reach = threshold + room;
        collectNearSlots(treeA, treeB, R, p, m_reach, open, m_slots);
        m_room = m_slots.empty() ? std::min(2.0 * room, kMostRoom * threshold) : m_room;
        boundDistances(treeA, treeB, kPlaneSlack * threshold);
        way = 0.0;
    }
    slots.clear();
    for (std::size_t i = 0; i < m_slots.size(); ++i)
    {
        if (m_bounds[i] <= threshold + way)
        {
            slots.push_back(m_slots[i]);
        }
    }
}

void KeptSlots::boundDistances(const SsvTree& treeA, const SsvTree& treeB, double slack)
{
    m_bounds.clear();
    for (const auto& [a, b] : m_slots)
    {
        TriangleCorners cornersA = treeA.corners(a);
        for (Vector3d& corner : cornersA)
        {
            corner = m_collected.R * corner + m_collected.p;
        }
        const TriangleCorners cornersB = treeB.corners(b);
        double bound = std::max(heightOver(cornersA, cornersB), heightOver(cornersB, cornersA));
        if (bound <= m_reach)
        {
            bound = triangleDistance(cornersA, cornersB).distance;
        }
        m_bounds.push_back(bound - slack);
    }
}
}  // namespace bullet_ccd
