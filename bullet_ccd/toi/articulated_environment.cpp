#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/toi/articulated/body_boxes.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace bullet_ccd
{
namespace
{
using Eigen::AlignedBox3d;
using Eigen::Isometry3d;
using Eigen::Vector3d;

void checkObstacle(const RigidBody& body, std::size_t index)
{
    // Messages are built only where they are needed: a query is to allocate nothing.
    const RigidMotion& m = body.motion;
    if (body.tree == nullptr || body.tree->nodes().empty())
    {
        throw std::invalid_argument("articulatedToi: obstacle " + std::to_string(index) +
                                    ": there is no hierarchy: build one with buildSsvTree()");
    }
    if (body.userMotion == nullptr && !isPose(m.X_W0))
    {
        failPose("articulatedToi: X_W0 of obstacle " + std::to_string(index), m.X_W0);
    }
    require(body.userMotion != nullptr ||
                (m.v_W.allFinite() && m.w_W.allFinite() && m.reference_B.allFinite()),
            "articulatedToi: a velocity or the reference point of an obstacle is NaN or infinite");
}
}  // namespace

void Environment::reset(std::span<const RigidBody> bodies)
{
    m_bodies.assign(bodies.begin(), bodies.end());
    m_moves.resize(bodies.size());
    m_boxes.resize(bodies.size());
    m_order.resize(bodies.size());
    m_nodes.clear();
    m_movingCount = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i)
    {
        const RigidBody& body = bodies[i];
        checkObstacle(body, i);
        const bool rests = body.userMotion == nullptr && body.motion.v_W.isZero(0.0) &&
                           body.motion.w_W.isZero(0.0);
        m_moves[i] = rests ? 0 : 1;
        m_movingCount += rests ? 0U : 1U;
        m_boxes[i] = boundsOver(body, 0.0, 1.0);
    }
    std::iota(m_order.begin(), m_order.end(), 0);
    if (!m_order.empty())
    {
        build(0, m_order.size());
    }
}

/// Appends the tree over order()[begin, end), parents before their children.
void Environment::build(std::size_t begin, std::size_t end)
{
    const std::size_t index = m_nodes.size();
    m_nodes.push_back({.first = static_cast<std::int32_t>(begin),
                       .count = static_cast<std::int32_t>(end - begin)});
    AlignedBox3d centers;
    AlignedBox3d box;
    for (std::size_t i = begin; i < end; ++i)
    {
        centers.extend(this->box(m_order[i]).center());
        box.extend(this->box(m_order[i]));
    }
    m_nodes[index].box = box;
    if (end - begin <= kLeaf)
    {
        return;
    }
    Eigen::Index axis = 0;
    centers.sizes().maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return m_order.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin),
                     at(middle),
                     at(end),
                     [&](std::int32_t a, std::int32_t b)
                     {
                         const double x = this->box(a).center()[axis];
                         const double y = this->box(b).center()[axis];
                         return x != y ? x < y : a < b;
                     });
    build(begin, middle);
    m_nodes[index].right = static_cast<std::int32_t>(m_nodes.size());
    build(middle, end);
}
}  // namespace bullet_ccd
