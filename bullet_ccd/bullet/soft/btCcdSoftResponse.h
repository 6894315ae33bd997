/// The answer to contacts of a step: paths that keep their distance, and impulses.
#ifndef BT_CCD_SOFT_RESPONSE_H
#define BT_CCD_SOFT_RESPONSE_H

#include "bullet_ccd/bullet/soft/btCcdSoftPart.h"
#include "bullet_ccd/deformable/deformable_toi.h"

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

class btMultiBody;
class btRigidBody;

/// Collects contacts and answers them together.
///
/// Paths and velocities are separate. A path is bent only as far as the distance asks for, with
/// friction, by displacements that leave the centre of mass of two soft bodies where it is. The
/// velocities get impulses, equal and opposite, with Bullet's friction and restitution; rigid
/// bodies and multibodies get their share, of which their poses know from the next step on. Both
/// are Gauss-Seidel iterations over the sums of impulses, so that what pushes never pulls.
class btCcdSoftResponse
{
public:
    /// Part of what two surfaces are too near, or too deep in each other, that a step gives back.
    static constexpr double kRecovery = 0.2;

    btCcdSoftResponse();
    ~btCcdSoftResponse();
    /// Forgets all contacts, but keeps the memory for them: as much is needed in the next step.
    /// @param rest  distance that surfaces are to keep at the end of the step [m]
    void begin(double rest, double timeStep);

    /// Contacts between what cannot move are left out.
    /// @param partA,partB  the bodies of the contact; they live as long as this
    /// @param isForced     the velocities are answered even if no path had to give way
    void add(const bullet_ccd::DeformableContact& contact,
             btCcdSoftPart& partA,
             btCcdSoftPart& partB,
             bool isForced);
    /// Rigid bodies that are pressed on each other: what holds one back holds the other, too.
    /// Bullet's solver has had their friction and restitution.
    /// @param pointA,pointB  where they touch at the end of the step, in the world [m]
    /// @param normal         from A to B
    void addPressed(btCcdSoftPart& partA,
                    btCcdSoftPart& partB,
                    const Eigen::Vector3d& pointA,
                    const Eigen::Vector3d& pointB,
                    const Eigen::Vector3d& normal);
    /// Changes the ends of the soft parts; if it is not the first time, only where it matters.
    void solvePaths(bool isFirst);
    /// Changes the velocities of the soft parts, and those of rigid bodies and multibodies.
    void solveVelocities();
    [[nodiscard]] bool isEmpty() const { return m_touches.empty(); }

private:
    /// A rigid body or multibody that is free to move, by its generalised velocity.
    struct Mover;
    /// Velocity of a point of it along a direction, and what an impulse there does.
    struct Row
    {
        Eigen::VectorXd m_jacobian;
        Eigen::VectorXd m_response;
    };
    /// What the sweeps over paths read and write of a contact; the rest of it is in Touch.
    struct Path
    {
        std::array<std::int64_t*, 4> m_bent{};  // when its ends were last moved, if they can be
        std::int64_t m_solved = -1;             // when this was last looked at
        Eigen::Matrix3d m_axes;                 // rows: normal, two tangents
        std::array<double, 4> m_weight{};       // of the vector between the nearest points
        std::array<double, 4> m_give{};         // weight / mass, 0 of what is not soft
        std::array<Eigen::Vector3d*, 4> m_end{};
        Eigen::Vector3d m_start = Eigen::Vector3d::Zero();  // of that vector
        Eigen::Vector3d m_push = Eigen::Vector3d::Zero();   // along the axes [kg m]
        double m_goal = 0.0;                                // of the distance at the end [m]
        double m_response = 0.0;                            // sum of w^2 / m over what is soft
        double m_friction = 0.0;
    };
    /// Of a touch, where it is an obstacle.
    struct Side
    {
        btCcdSoftPart* m_obstacle = nullptr;
        Eigen::Vector3d m_point = Eigen::Vector3d::Zero();  // at the end
        Eigen::Vector3d m_pathVelocity = Eigen::Vector3d::Zero();
        Mover* m_mover = nullptr;
        std::size_t m_rows = 0;  // where m_rows has them, if there is a mover
    };
    struct Touch
    {
        bool m_isForced = false;
        std::array<btCcdSoftPart*, 4> m_part{};
        std::array<std::size_t, 4> m_vertex{};
        double m_restitution = 0.0;
        Eigen::Vector3d m_impulse = Eigen::Vector3d::Zero();  // along the axes [kg m/s]
        std::array<Side, 2> m_sides;                          // A and B
        double m_goalSpeed = 0.0;
    };

    double m_rest = 0.0;
    double m_timeStep = 0.0;
    std::vector<Touch> m_touches;
    std::vector<Path> m_paths;  // of the touches
    std::vector<std::array<Row, 3>> m_rows;
    std::map<const void*, std::unique_ptr<Mover>> m_movers;
    std::int64_t m_clock = 0;  // counts what moved ends of paths

    /// One step of the iteration; returns by how much a distance changed [m], if by more than
    /// `least`.
    double solvePath(Path& path, double least);
    /// The same for velocities [m/s].
    double solveVelocity(Touch& touch, const Path& path);
    [[nodiscard]] Eigen::Vector3d relativeVelocity(const Touch& touch, const Path& path) const;
    void applyImpulse(Touch& touch, const Path& path, const Eigen::Vector3d& impulse);
    void findMover(Side& side, const Path& path);
};

#endif  // BT_CCD_SOFT_RESPONSE_H
