/// How kinematic objects come to where they are.
#ifndef BT_CCD_WAY_H
#define BT_CCD_WAY_H

#include <LinearMath/btTransform.h>

class btRigidBody;

/// Bullet puts a kinematic object where it is to be at once, before the first of the steps of a
/// frame, and gives it the same velocity in all of them. Here it goes from the pose that it had
/// when the step before ended, in as many parts as its velocity says that the frame has steps; at
/// once, if Bullet found no velocity (where the program has set the interpolation transform, too).
/// A velocity that explains the way in no number of steps is believed, and what it does not explain
/// was not covered; so is the velocity of an object that is new. One that is where it was does not
/// move, whatever its velocity.
struct btCcdWay
{
    btTransform m_start = btTransform::getIdentity();  // in this step
    btTransform m_end = btTransform::getIdentity();
    btVector3 m_velocity = btVector3(0, 0, 0);  // likewise
    btVector3 m_spin = btVector3(0, 0, 0);
    bool m_jumped = false;  // it has not come, but been put there
    double m_ahead = 0.0;   // how far Bullet has a point of it from m_start already, at most [m]
    int m_step = kNever;    // the last one in which it was seen

    /// What a step asks of it.
    struct Step
    {
        int m_number = 0;
        double m_duration = 0.0;  // [s]
        double m_rounding = 0.0;  // what does not count [m]
        double m_reach = 0.0;     // of the object about its origin [m]
        bool m_isTold = false;    // that it has jumped
    };
    /// The part of its way that it covers in the step. It has jumped if it came farther than
    /// several times its reach in a step, and more than twice as far as before.
    void go(const btRigidBody& body, const Step& step);
    /// It is not moved in the step.
    void rest(const btRigidBody& body, int step);

private:
    static constexpr int kNever = -2;

    void beginFrame(const btRigidBody& body, const Step& step);
    void takePart(const Step& step);

    btTransform m_from = btTransform::getIdentity();  // in the frame,
    btTransform m_to = btTransform::getIdentity();    // which is where it is
    btVector3 m_bullets = btVector3(0, 0, 0);         // its velocity as Bullet has it in the frame
    double m_length = 0.0;                            // in a step [m]
    int m_part = 0;                                   // of this step in the frame,
    int m_parts = 1;
};

#endif  // BT_CCD_WAY_H
