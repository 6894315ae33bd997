/// Quick trial grasps of simple bodies: what a hand is judged by before it has seen an object.
#pragma once

#include "grasp/hand/hand_model.h"

#include <array>
#include <vector>

namespace bullet_ccd::grasp
{
/// A box with rounded edges, about the origin: also a ball (no box) and a bar (a box of one
/// dimension).
struct TrialBody
{
    Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< half extents of what is rounded [m]
    double round = 0.0;                              ///< radius that is added to it [m]

    /// Distance of the point from the surface, negative inside [m].
    [[nodiscard]] double distance(const Eigen::Vector3d& point) const;
    /// Unit, outward, at or near the surface.
    [[nodiscard]] Eigen::Vector3d normal(const Eigen::Vector3d& point) const;
    /// Largest distance of its points from the origin [m].
    [[nodiscard]] double radius() const { return half.norm() + round; }
};

/// Closes a hand on trial bodies. To a body links are points drawn from their surfaces; to each
/// other they are what they are. Closing runs in steps of 3 degrees, and the quality is a bound
/// from a fixed set of directions. So a trial takes a fraction of a millisecond, and is no more
/// than a hint.
class TrialGrasps
{
public:
    /// @param hand `robot`, `linkTrees`, `fingers`, `closingDirections` and `closingSpeeds` are
    /// used
    explicit TrialGrasps(const HandModel& hand);

    /// Moves the hand along the z axis of its grasp frame until it touches the body, or until the
    /// frame's origin is at the body's; draws it back a little; closes it.
    /// @param positions one entry per link [rad or m], mimics applied
    /// @param X_GB      body in the grasp frame where the hand would take it; moved along z
    /// @param speeds    ratios to the usual speed, one entry per link; empty: those of the hand
    /// @return 1 for a firm grasp, 0 for none, in between for weak ones and near misses
    [[nodiscard]] double operator()(const std::vector<double>& positions,
                                    const Eigen::Isometry3d& X_RG,
                                    const TrialBody& body,
                                    const Eigen::Isometry3d& X_GB,
                                    const std::vector<double>& speeds = {}) const;

private:
    using Row = Eigen::Array<float, Eigen::Dynamic, 1, 0, 256, 1>;

    struct LinkPoints
    {
        std::array<Row, 3> points;  // x, y and z, link frame
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        double radius = 0.0;               // of the ball about the middle that holds them
        std::vector<std::size_t> drivers;  // closing joints that move the link

        [[nodiscard]] Eigen::Vector3d point(Eigen::Index k) const;
        [[nodiscard]] bool empty() const { return points[0].size() == 0; }
    };
    /// Links that can touch each other, and the closing joints that move one of them alone.
    struct LinkPair
    {
        std::size_t first = 0;
        std::size_t second = 0;
        std::vector<std::size_t> drivers;
    };
    struct Nearest
    {
        double distance = 0.0;
        Eigen::Index point = 0;
    };

    [[nodiscard]] static Row distances(const LinkPoints& link,
                                       const Eigen::Isometry3d& X_BL,
                                       const TrialBody& body);
    [[nodiscard]] static Nearest nearest(const LinkPoints& link,
                                         const Eigen::Isometry3d& X_BL,
                                         const TrialBody& body);
    [[nodiscard]] double freeTravel(const std::vector<Eigen::Isometry3d>& X_GL,
                                    const TrialBody& body,
                                    Eigen::Isometry3d X_GB) const;
    [[nodiscard]] std::vector<Eigen::Isometry3d> close(std::vector<double> positions,
                                                       const Eigen::Isometry3d& X_BR,
                                                       const TrialBody& body,
                                                       const std::vector<double>& speeds) const;
    [[nodiscard]] bool overlap(const LinkPair& pair,
                               const std::vector<Eigen::Isometry3d>& X_BL) const;
    [[nodiscard]] double quality(const std::vector<Eigen::Isometry3d>& X_BL,
                                 const TrialBody& body) const;

    const HandModel& m_hand;
    std::vector<LinkPoints> m_links;  // one a link; without geometry: no points
    std::vector<LinkPair> m_pairs;
    std::vector<Eigen::Matrix<double, 6, 1>> m_directions;
};
}  // namespace bullet_ccd::grasp
