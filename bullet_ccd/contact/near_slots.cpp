#include "bullet_ccd/contact/near_slots.h"

#include "bullet_ccd/distance/ssv_pair.h"

namespace bullet_ccd
{
namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

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
}  // namespace bullet_ccd
