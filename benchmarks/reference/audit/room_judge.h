/// Judges from outside the bodies of a closed room: only poses, shapes and velocities are read,
/// none of the code under test is asked.
#pragma once

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <array>
#include <map>

namespace bullet_ccd::reference
{
/// A cube about the origin.
struct Room
{
    double half = 2.0;                             ///< of its inner length [m]
    std::array<std::array<double, 2>, 3> walls{};  ///< half their thickness, by axis and side [m]
};

/// How far the body reaches along a direction, from the origin of the world [m]. Spheres, capsules
/// and other convex shapes, btCcdMeshShape, compounds of these.
[[nodiscard]] double reachOf(const btRigidBody& body, const btVector3& direction);

enum class RoomFinding
{
    Nothing,
    NotFinite,     ///< a pose or a velocity
    Out,           ///< in the middle of a wall or beyond
    OutFromAWall,  ///< the same, and it began in a wall and had not come out of it before
    GathersSpeed,  ///< stood still in kHeldSteps steps in a row, and its velocity grew
};

/// What began in a wall and passes it, or is not out of it in time, is counted: stock Bullet does
/// not get everything out either.
class RoomJudge
{
public:
    static constexpr int kHeldSteps = 8;
    /// Of what its speed says: what a motor presses on something goes forth and back in a step.
    static constexpr double kStill = 0.01;
    static constexpr double kGathered = 0.1;       ///< at least, over these steps [m/s]
    static constexpr double kTimeToComeOut = 1.0;  ///< [s]
    static constexpr double kOut = 1e-3;  ///< as deep as Bullet leaves bodies that rest [m]

    RoomJudge(const Room& room, double timeStep) : m_room(room), m_timeStep(timeStep) {}

    /// After every step.
    [[nodiscard]] RoomFinding look(const btRigidBody& body);
    /// The program has put the body where it is, or given it its velocity; before the next step.
    void forget(const btRigidBody& body) { m_seen.erase(&body); }
    /// The same for a body that is deep in this wall now, and that is to come out of it.
    /// @param side 0 or 1: of negative or positive coordinates
    void beginsInWall(const btRigidBody& body, int axis, int side);
    [[nodiscard]] bool isComingOut(const btRigidBody& body) const;
    [[nodiscard]] int begunInWalls() const { return m_begunInWalls; }
    [[nodiscard]] int notComeOut() const { return m_notComeOut; }

private:
    struct Seen
    {
        btVector3 place{0, 0, 0};
        btVector3 velocity{0, 0, 0};
        int held = 0;            // steps in a row,
        double freeSpeed = 0.0;  // and the speed before them [m/s]
        // Of the wall that it began in.
        int axis = 0;
        double side = 0.0;  // -1 or 1; 0: none
        double time = 0.0;
    };
    Room m_room;
    double m_timeStep;
    std::map<const btRigidBody*, Seen> m_seen;
    int m_begunInWalls = 0;
    int m_notComeOut = 0;

    [[nodiscard]] bool isInMiddleOfWall(const btVector3& at) const;
};
}  // namespace bullet_ccd::reference
