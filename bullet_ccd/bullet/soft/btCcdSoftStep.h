/// The check and answer of one step of a deformable world.
#ifndef BT_CCD_SOFT_STEP_H
#define BT_CCD_SOFT_STEP_H

#include "bullet_ccd/bullet/btCcdDeformableBodySolver.h"
#include "bullet_ccd/bullet/soft/btCcdSoftObstacles.h"
#include "bullet_ccd/bullet/soft/btCcdSoftResponse.h"
#include "bullet_ccd/bullet/soft/btCcdSoftSurface.h"

#include <cstdint>
#include <functional>
#include <map>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

class btCcdSoftStep
{
public:
    btCcdSoftCounters m_counters;
    double m_separation = 1e-3;  ///< [m]
    int m_threads = 1;
    btCcdSoftObstacles m_obstacles;

    /// Before Bullet solves.
    void begin(btBroadphaseInterface& broadphase, btScalar timeStep);
    /// Sets the velocities of nodes such that Bullet's integration leads to where the paths end.
    void run(const btAlignedObjectArray<btSoftBody*>& bodies, btScalar timeStep);
    /// After Bullet's integration: nodes are exactly where their paths end.
    void finish();
    /// Draws the contacts and the bent paths of the step; from the first call on they are kept.
    void draw(btIDebugDraw& drawer);

private:
    struct SeenContact
    {
        btVector3 m_pointA;
        btVector3 m_pointB;
        btVector3 m_normal;
    };
    struct Moved
    {
        btCcdSoftPart* m_part;
        std::vector<std::size_t> m_nodes;
    };
    btCcdSoftSurfaces m_surfaces;
    bullet_ccd::DeformableWorkspace m_work;
    bullet_ccd::DeformableResult m_found;  ///< the last answer of contacts()
    btCcdSoftResponse m_response;          ///< of one step
    std::vector<btCcdSoftPart*> m_parts;   ///< soft bodies first
    std::size_t m_softParts = 0;
    btBroadphaseInterface* m_broadphase = nullptr;
    btDispatcher* m_dispatcher = nullptr;
    Eigen::AlignedBox3d m_box;  ///< in which colliders were looked for
    std::vector<Moved> m_moved;
    /// Kinematic objects that take along rigid bodies (kNone) and nodes of soft bodies in this
    /// step.
    std::map<std::pair<const btCollisionObject*, std::int32_t>, const btCcdSoftPart*> m_carriers;
    /// A rigid body or multibody that this step put elsewhere.
    struct Held
    {
        int m_rank = 0;   ///< one more than that of what it came along with; 0 if it was held back
        int m_times = 0;  ///< it came along
        bool m_isSlowed = false;  ///< it was held back, or came along with another rigid one
    };
    std::unordered_map<const void*, Held> m_held;
    std::unordered_set<const void*>
        m_hasComeAlong;  ///< in the round, or was held back by rigid bodies
    /// A contact of rigid bodies that come deeper into each other than without soft bodies, or
    /// than they were; see btCcdSoftResponse::addPressed().
    struct Pressed
    {
        btCcdSoftPart* m_partA;
        btCcdSoftPart* m_partB;
        Eigen::Vector3d m_pointA;
        Eigen::Vector3d m_pointB;
        Eigen::Vector3d m_normal;  // from A to B
        double m_apart;            // how much farther they are to end than without soft bodies
    };
    std::vector<Pressed> m_pressed;  ///< when the paths were last looked at
    double m_keep = 0.0;             ///< distance that no path goes below [m]
    bool m_isDrawn = false;
    std::vector<SeenContact> m_seenContacts;                   ///< if drawn
    std::vector<std::pair<btVector3, btVector3>> m_bentPaths;  ///< if drawn

    bool gather(const btAlignedObjectArray<btSoftBody*>& bodies, btScalar timeStep);
    /// Looks for colliders wherever paths lead now. False if there was nothing to look for.
    bool gatherObstacles();
    void answer(const bullet_ccd::DeformableContact& contact,
                bool isForced,
                btCcdSoftResponse& response);
    /// Those between the same two points only once. Left out are those of rigid bodies with
    /// something near already that come near later in the step: on their way through what is near,
    /// where normals may be any. Once that has turned their way aside they are found again, if they
    /// are there.
    void answerFirst(const std::vector<bullet_ccd::DeformableContact>& contacts,
                     bool isForced,
                     btCcdSoftResponse& response);
    [[nodiscard]] bool isTested(const btCcdSoftPart& a, const btCcdSoftPart& b) const;
    [[nodiscard]] bool isHeld(const btCcdSoftPart& part) const;
    /// Of colliders neither of which is soft: they have met before, where both went freely.
    [[nodiscard]] bool isTestedAgain(const btCcdSoftPart& a, const btCcdSoftPart& b) const;
    /// Features that come within the separation.
    /// @param isUpdate  the same was asked before, and is in m_found
    [[nodiscard]] const bullet_ccd::DeformableResult& contacts(
        double separation,
        double tolerance,
        bool isUpdate,
        const std::function<bool(const bullet_ccd::DeformableContact&)>& isExempt = nullptr);
    /// What a path must not do: contacts() less those that nothing can answer.
    /// @param isFirst  since the step began
    [[nodiscard]] std::vector<bullet_ccd::DeformableContact> violations(bool isFirst);
    [[nodiscard]] bool isBlocking(const bullet_ccd::DeformableContact& contact);
    /// True if the rigid bodies end nearer to each other there than without soft bodies.
    [[nodiscard]] bool areClosedIn(const bullet_ccd::DeformableContact& contact) const;
    /// What Bullet's contacts say of rigid bodies that the step put elsewhere; adds those of them
    /// that come deeper than they were when it began. (What rests on something may well have cut
    /// into it a little.)
    void addPressed(std::vector<bullet_ccd::DeformableContact>& left);
    /// True if a node of the contact hangs on what it touches.
    [[nodiscard]] bool isAnchored(const bullet_ccd::DeformableContact& contact) const;
    /// True if the normal is that of the surfaces. At the rim of a face it may lean, and what
    /// slides over the seam of two faces would stumble.
    [[nodiscard]] bool hasPlainNormal(const bullet_ccd::DeformableContact& contact) const;
    void bendPaths(btCcdSoftResponse& response);
    /// Moves the ends of rigid bodies.
    void giveWay(const std::vector<btCcdSoftResponse::Shift>& shifts);
    void shortenPaths(btCcdSoftResponse& response);
    /// What takes along the rigid body (kNone) or node; null if nothing does.
    [[nodiscard]] const btCcdSoftPart* carrierOf(const btCollisionObject* object,
                                                 std::int32_t node) const;
    /// The bodies that vertices of the contact are anchored to: they move what meets.
    void forAnchors(const bullet_ccd::DeformableContact& contact,
                    const std::function<void(btCcdSoftPart&)>& visit) const;
    /// The same of any of those that meet: a kinematic object, or what takes one of them along.
    [[nodiscard]] const btCcdSoftPart* carrierOf(
        const bullet_ccd::DeformableContact& contact) const;
    /// Where a path ends that is shortened to nothing: at its start, or where it is taken along.
    [[nodiscard]] btTransform baseOf(const btCcdSoftPart& obstacle) const;
    [[nodiscard]] Eigen::Vector3d baseOf(const btCcdSoftPart& soft, std::int32_t node) const;
    void hold(const bullet_ccd::DeformableContact& contact, double part, bool& hasMoved);
    void holdBody(const btCcdSoftPart& obstacle, double part);
    /// Of two rigid bodies one of which was put elsewhere, the other one comes along: both end
    /// relative to each other as they would have without soft bodies. True if one of them has come
    /// along in this round, false if none can.
    /// @param apart  of B's way, away from A [m]
    bool comeAlong(const btCcdSoftPart& a,
                   const btCcdSoftPart& b,
                   const Eigen::Vector3d& apart = Eigen::Vector3d::Zero());
    /// Sets where parts of colliders end, and what is anchored there.
    void place(const std::unordered_map<const btCollisionObject*, btTransform>& poses);
    void holdAll();
    void commit(btScalar timeStep);
    void keepForDrawing(const std::vector<bullet_ccd::DeformableContact>& contacts);
};

#endif  // BT_CCD_SOFT_STEP_H
