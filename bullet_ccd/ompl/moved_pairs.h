/// How near the links of a robot come to each other and to obstacles in a state: the samples of
/// certified motions.
#pragma once

#include "bullet_ccd/toi/articulated_toi.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <span>
#include <vector>

namespace bullet_ccd
{
struct Ball
{
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    double radius = 0.0;
};

/// The pairs of links and obstacles that a motion moves relative to each other. Links that move as
/// one are placed at once, and looked at one by one only if the ball around them is near. What the
/// body and the environment refer to must outlive the pairs.
class MovedPairs
{
public:
    /// Of one thread.
    struct Scratch
    {
        std::vector<Eigen::Isometry3d> X_WM;  ///< of the movers
        std::vector<Ball> balls;              ///< around them, in W
        std::size_t nearest = 0;  ///< the pair that was found too near last: looked at first
    };

    /// @param body  its motion has a rate for all joints that move, and the positions of the others
    /// @pre no joint is spherical, and the obstacles rest
    MovedPairs(const ArticulatedBody& body,
               const Environment& environment,
               const Eigen::Isometry3d& X_WR);

    /// The smallest distance, at most `enough` [m].
    /// @param any  if there is one below `enough`, it need not be the smallest
    [[nodiscard]] double leastDistance(std::span<const double> positions,
                                       double enough,
                                       bool any,
                                       Scratch& scratch) const;

private:
    /// What turns and slides as one: the links that follow the same moved joint.
    struct Mover
    {
        Joint joint{};
        std::int32_t link = kNone;    ///< whose joint it is; kNone of what rests in W
        std::int32_t parent = kNone;  ///< another mover, before this one
        Eigen::Isometry3d X_PM0 = Eigen::Isometry3d::Identity();  ///< with the joint at 0
        Ball ball{};                                              ///< around its links, in M
    };

    /// A link with its hierarchy, or an obstacle.
    struct Part
    {
        const SsvTree* tree = nullptr;
        std::int32_t mover = 0;
        Eigen::Isometry3d X_MG = Eigen::Isometry3d::Identity();
        Ball ball{};  ///< in M
    };

    struct Pair
    {
        std::int32_t partA = kNone;
        std::int32_t partB = kNone;
        const PairMask* mask = nullptr;
    };

    /// Consecutive pairs of links of one mover with those of another, or with one obstacle.
    struct Group
    {
        std::int32_t moverA = kNone;
        std::int32_t moverB = kNone;
        std::int32_t obstacle = kNone;  ///< its part
        std::size_t end = 0;            ///< of its pairs, which begin where those before it end
    };

    void placeRobot(const ArticulatedBody& body, const Eigen::Isometry3d& X_WR);
    void collectPairs(const ArticulatedBody& body);
    void placeMovers(std::span<const double> positions, Scratch& scratch) const;
    [[nodiscard]] Ball ballOf(const Part& part, const Scratch& scratch) const;
    [[nodiscard]] double distanceOf(const Pair& pair, const Scratch& scratch, double enough) const;

    std::vector<Mover> m_movers;  ///< the first rests in W
    std::vector<Part> m_parts;    ///< the links, whether they have geometry or not, then obstacles
    std::vector<Pair> m_pairs;
    std::vector<Group> m_groups;
};
}  // namespace bullet_ccd
