/// The answer to contacts of a step: paths that keep their distance, and impulses.
#ifndef BT_CCD_SOFT_RESPONSE_H
#define BT_CCD_SOFT_RESPONSE_H

#include "bullet_ccd/bullet/soft/btCcdSoftPart.h"
#include "bullet_ccd/deformable/deformable_toi.h"

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <vector>

class btMultiBody;
class btRigidBody;

/// Collects contacts and answers them together.
///
/// Paths and velocities are separate. A path is bent only as far as the distance asks for, with
/// friction, by displacements that leave the common centre of mass where it is; rigid bodies that
/// are awake give way with their masses, too. The velocities get impulses, equal and opposite, with
/// Bullet's friction and restitution; multibodies get their share, of which their joints know from
/// the next step on. Both are Gauss-Seidel iterations over the sums of impulses, so that what
/// pushes never pulls. What a rigid body got from soft ones in a step is where the next one begins.
class btCcdSoftResponse
{
public:
    /// Part of what two surfaces are too near, or too deep in each other, that a step gives back.
    static constexpr double kRecovery = 0.2;

    btCcdSoftResponse();
    ~btCcdSoftResponse();
    /// Before Bullet solves: rigid bodies get what soft ones gave them in the last step (or in the
    /// one before, if that was less: an impact is no support), so that Bullet's contacts between
    /// rigid ones know their weight. begin() takes it back.
    /// @param isThere  whether the body is in the world
    void support(const std::function<bool(const btCollisionObject*)>& isThere, double timeStep);
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
    /// Where a rigid body gives way: how far its end moves and turns [m, rad].
    struct Shift
    {
        btRigidBody* m_body;
        Eigen::Vector3d m_way;
        Eigen::Vector3d m_turn;
    };
    /// What solvePaths() asks of rigid bodies since the last call. The caller moves their ends.
    [[nodiscard]] std::vector<Shift> takeShifts();
    /// Changes the velocities of the soft parts, and those of rigid bodies and multibodies.
    void solveVelocities();
    /// Objects whose momentum reaches what cannot move, by touches that have pushed and by anchors:
    /// static and kinematic objects, pinned nodes, multibodies with a fixed base.
    [[nodiscard]] std::unordered_set<const btCollisionObject*> supportedObjects() const;
    /// True if there is nothing to solve.
    [[nodiscard]] bool isEmpty() const { return m_touches.empty() && m_movers.empty(); }

private:
    using Vector6d = Eigen::Matrix<double, 6, 1>;
    /// A rigid body or multibody that is free to move, by its generalised velocity.
    struct Mover;
    /// Velocity of a point of it along a direction, and what an impulse there does.
    struct Row
    {
        Eigen::VectorXd m_jacobian;
        Eigen::VectorXd m_response;
    };
    /// What moves with a side of a touch. Paths know of rigid bodies, velocities of multibodies,
    /// too.
    struct Lever
    {
        Mover* m_mover = nullptr;
        std::size_t m_rows = 0;  // where m_rows has them, if there is a mover
    };
    /// What the sweeps over paths read and write of a contact; the rest of it is in Touch.
    struct Path
    {
        std::array<std::int64_t*, 6> m_bent{};  // when its ends were last moved, if they can be
        std::int64_t m_solved = -1;             // when this was last looked at
        Eigen::Matrix3d m_axes;                 // rows: normal, two tangents
        std::array<double, 4> m_weight{};       // of the vector between the nearest points
        std::array<double, 4> m_give{};         // weight / mass, 0 of what is not soft
        std::array<const Eigen::Matrix3d*, 4> m_clamp{};  // part of it that is left; null: all
        std::array<Eigen::Vector3d*, 4> m_end{};
        Eigen::Vector3d m_start = Eigen::Vector3d::Zero();     // of that vector
        Eigen::Vector3d m_push = Eigen::Vector3d::Zero();      // along the axes [kg m]
        double m_goal = 0.0;                                   // of the distance at the end [m]
        Eigen::Vector3d m_response = Eigen::Vector3d::Zero();  // of that vector to a push
        double m_friction = 0.0;
        std::array<Lever, 2> m_levers;                         // of A and B
        Eigen::Vector3d m_ofLevers = Eigen::Vector3d::Zero();  // part of m_response

        /// What a push (or impulse) gives to a node.
        [[nodiscard]] Eigen::Vector3d given(std::size_t k, const Eigen::Vector3d& push_W) const
        {
            return m_clamp[k] == nullptr ? Eigen::Vector3d(m_give[k] * push_W)
                                         : Eigen::Vector3d(m_give[k] * (*m_clamp[k] * push_W));
        }
        /// Part of m_response that is of nodes.
        [[nodiscard]] Eigen::Vector3d ofNodes() const;
    };
    /// Of a touch, where it is an obstacle, or where nodes of it hang on a body that forces move.
    struct Side
    {
        btCcdSoftPart* m_obstacle = nullptr;
        btCollisionObject* m_anchor = nullptr;
        double m_share = 1.0;                               // of the weights: 1, or of such nodes
        Eigen::Vector3d m_point = Eigen::Vector3d::Zero();  // at the end
        Eigen::Vector3d m_pathVelocity = Eigen::Vector3d::Zero();
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
        std::uint64_t m_key = 0;  // of what is soft and of the rigid body; 0 if there is none
    };
    /// What a touch came to, in the world.
    struct Support
    {
        Eigen::Vector3d m_push_W = Eigen::Vector3d::Zero();
        Eigen::Vector3d m_impulse_W = Eigen::Vector3d::Zero();
    };

    double m_rest = 0.0;
    double m_timeStep = 0.0;
    std::vector<Touch> m_touches;
    std::vector<Path> m_paths;  // of the touches
    std::vector<std::array<Row, 3>> m_rows;
    std::vector<std::unique_ptr<Mover>> m_movers;
    std::unordered_map<const void*, Mover*> m_moverOf;      // by rigid body or multibody
    std::int64_t m_clock = 0;                               // counts what moved ends of paths
    std::unordered_map<std::uint64_t, Support> m_supports;  // of touches of the step, by key
    std::unordered_map<std::uint64_t, Support> m_before;    // of the step before
    double m_part = 1.0;                                    // of this time step, of the last one
    /// A node between a rigid body and what cannot move.
    struct Clamp
    {
        Eigen::Vector3d m_out;       // of what cannot move
        Eigen::Vector3d m_velocity;  // of what cannot move
        double m_share = 0.0;        // response of a body, times its touches; 0 if there is none
        bool m_isClamped = false;    // and this is the part of its mobility that is left:
        Eigen::Matrix3d m_mobility = Eigen::Matrix3d::Identity();
    };
    std::unordered_map<const std::int64_t*, Clamp> m_clamps;  // by node, as Path has it
    std::size_t m_solvedPaths = 0;                            // those after it have come in since
    struct BodySupport
    {
        btRigidBody* m_body;
        Vector6d m_change;  // of its velocity [m/s, rad/s]
    };
    /// By btCcdProxyId(): what bodies got from what is soft, in the last step and the one before.
    std::map<int, BodySupport> m_bodySupports;
    std::map<int, BodySupport> m_bodySupportsBefore;
    std::vector<BodySupport> m_given;  // by support()

    /// One step of the iteration; returns by how much a distance changed [m], if by more than
    /// `least`.
    double solvePath(Path& path, double least);
    /// The same for velocities [m/s].
    double solveVelocity(Touch& touch, const Path& path);
    [[nodiscard]] Eigen::Vector3d relativeVelocity(const Touch& touch, const Path& path) const;
    void applyImpulse(Touch& touch, const Path& path, const Eigen::Vector3d& impulse);
    void applyPush(Path& path, const Eigen::Vector3d& push);
    /// Begins with what is left of the last step, as far as it does no harm.
    void keepFromBefore(Touch& touch, Path& path);
    /// Nodes between a rigid body and what cannot move count as heavier, so that a sweep passes on
    /// what presses them.
    void findClamped();
    /// From contacts of soft bodies to others, by carry() or press(), as long as it is new to some.
    void spread(bool (btCcdSoftResponse::*pass)(const Path&, double));
    /// What lies on nodes that are carried is carried, too.
    /// @param side  -1: A is below, 1: B is
    [[nodiscard]] bool carry(const Path& path, double side);
    /// What is pressed presses what carries it.
    /// @param side  -1: A presses, 1: B does
    [[nodiscard]] bool press(const Path& path, double side);
    void clamp(std::size_t touch, std::size_t k, Clamp& clamp);
    void addLever(std::size_t side,
                  Mover& mover,
                  const btCollisionObject& object,
                  const Touch& touch,
                  Path& path);
    /// Nodes of a side that hang on a rigid body or link move as it does: what meets them pushes
    /// it. Returns the part of the weights that is of nodes which give way.
    [[nodiscard]] static double takeAnchored(std::size_t side,
                                             std::size_t ofA,
                                             Touch& touch,
                                             const Path& path);
    template <typename Body>
    [[nodiscard]] Mover& moverOf(Body& body);
    void keepSupports();
};

#endif  // BT_CCD_SOFT_RESPONSE_H
