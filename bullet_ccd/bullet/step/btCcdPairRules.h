/// Which two objects a step need not be asked about.
#ifndef BT_CCD_PAIR_RULES_H
#define BT_CCD_PAIR_RULES_H

#include "bullet_ccd/bullet/step/btCcdTracker.h"

class btCcdContext;
struct btBroadphasePair;

/// True if Bullet lets the two collide: groups and masks, user filters, parent-child and
/// self-collision flags, contact response.
[[nodiscard]] bool btCcdMayMeet(btCollisionWorld& world,
                                const btCollisionObject& a,
                                const btCollisionObject& b);

/// What the two may move relative to each other and not cross [m]. Infinite if one of them turns
/// out to have nothing that could be hit.
[[nodiscard]] double btCcdMayLose(btCcdContext& context,
                                  const btCcdTracked& a,
                                  const btCcdTracked& b);

/// Where the object is when the step begins (`done`: when it ends); a link, where the joints of its
/// multibody have it.
[[nodiscard]] btTransform btCcdPoseOf(const btCcdTracked& tracked, bool done);

/// How far the two may certainly move relative to each other, at least, before they come to the
/// distances that matter to contacts and to queries [m]; not positive if that is not known. What is
/// above `enough` need not be the best bound.
[[nodiscard]] double btCcdFreeWay(const btCcdContext& context,
                                  const btCcdTracked& a,
                                  const btCcdTracked& b,
                                  double enough,
                                  bool done);

/// How two simple shapes come near each other in the rest of a step, as seen along one direction:
/// no query is needed to see that most of those that touch, or nearly, come no nearer. A point that
/// turns is off its chord by an eighth of its acceleration times the square of the time, at most.
class btCcdApproach
{
public:
    /// @param pair of the broadphase, for a direction from its contacts; may be null
    /// @param remaining of the step [s]
    btCcdApproach(const btCcdContext& context,
                  const btCcdTracked& a,
                  const btCcdTracked& b,
                  const btBroadphasePair* pair,
                  double remaining,
                  bool done);
    /// The time from now before which a query certainly finds nothing; infinite if it finds nothing
    /// at all, 0 if nothing is known. Of a motion that is done, one of these two.
    [[nodiscard]] double freeTime() const;
    /// True for convex shapes, compounds of few of them, planes and small meshes (btCcdMeshShape):
    /// nothing is known of others.
    [[nodiscard]] static bool isOf(const btCcdTracked& a, const btCcdTracked& b);

private:
    double m_remaining;
    bool m_isDone;
    double m_gap = -1.0;  // beyond what a query leaves to the two, now [m],
    double m_end = -1.0;  // and when the step ends
    double m_bend = 0.0;  // less than the smaller of both by this, on the way
    double m_rate = 0.0;  // how fast it becomes smaller, at most [m/s]

    void look(double tolerance,
              const btCcdTracked& a,
              const btCcdTracked& b,
              const btVector3& normal,
              bool touches);
};

#endif  // BT_CCD_PAIR_RULES_H
