/// The contact manifolds of one pair of colliders, from exact distances.
#ifndef BT_CCD_MANIFOLDS_H
#define BT_CCD_MANIFOLDS_H

#include "bullet_ccd/bullet/shapes/btCcdShapeCache.h"
#include "bullet_ccd/contact/near_slots.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <limits>
#include <memory>
#include <span>

namespace bullet_ccd
{
struct Contact;
struct PatchWorkspace;
}  // namespace bullet_ccd
struct btCollisionObjectWrapper;

/// What the contacts of two shapes tell of them at some poses.
struct btCcdKnownOfPair
{
    /// From A to B: moved as far against it, A is outside. As far as the last update tells, and at
    /// most as deep as then. Zero if they do not intersect, or no way out was found.
    Eigen::Vector3d m_wayOut = Eigen::Vector3d::Zero();
    /// One was wholly inside the other in the last update: their surfaces, which are apart, do not
    /// count.
    bool m_isWholly = false;
    /// Bounds of the distance of their surfaces [m].
    double m_least = 0.0;
    double m_most = std::numeric_limits<double>::infinity();
};

/// Owns manifolds for every patch of contact (points of like normals): one where the patch is flat,
/// up to three where a body stands on bumps; at most kMaxManifolds in all.
///
/// Depth is counted from the shell: a point at distance d of the surfaces has depth d - m, m the
/// sum of both margins, so that the solver, which lets a pair close to depth 0, leaves room that
/// the time of impact guards. Points are given for d <= 2 m (for d <= m + kLeastReach if the
/// margins are smaller), plus what the result asks for (m_closestPointDistanceThreshold); where
/// the objects have a contact processing threshold below m, it takes the place of the second m.
/// Without margins m is kLeastShell.
///
/// Surfaces that intersect, or are so near that their contacts have no direction, get the contacts
/// that they have where one of them has been moved out of the other: the way that they came, or the
/// shortest that is found, and as much deeper. So do those of which one has gone wholly into the
/// other since the last update, where surfaces are far from each other.
///
/// Points persist: one that is near an old one of its patch, in the frame of either body (a corner
/// that slides stays where it is in its own), inherits its impulses, age and user data; what is no
/// longer found is dropped at once. gContactStartedCallback and gContactEndedCallback tell of the
/// first and last point of a manifold as in stock Bullet, gContactAddedCallback of every point at
/// every update (if a body has CF_CUSTOM_MATERIAL_CALLBACK), gContactProcessedCallback of those
/// that persist. Points name the triangle of each mesh: m_partId and m_index are those of the mesh
/// interface that the shape was made of (of a btCcdMeshShape: 0 and the index in tree().mesh()).
class btCcdManifolds
{
public:
    static constexpr int kMaxManifolds = 8;
    static constexpr double kLeastShell = 1e-4;  ///< [m]
    static constexpr double kLeastReach = 2e-4;  ///< [m]

    /// The two shapes of a question, and how they are posed.
    struct Sides
    {
        const btCollisionObjectWrapper& m_a;
        const btCcdShapePart& m_partA;
        const btCollisionObjectWrapper& m_b;
        const btCcdShapePart& m_partB;
    };

    explicit btCcdManifolds(btDispatcher& dispatcher) : m_dispatcher(&dispatcher) {}
    ~btCcdManifolds();
    btCcdManifolds(const btCcdManifolds&) = delete;
    btCcdManifolds& operator=(const btCcdManifolds&) = delete;

    /// Brings all manifolds up to date with the poses of the wrappers (a compound child's are not
    /// those of its collision object). The pair may come in either order.
    /// @param shared if not null, the manifold of a parent: all points go there
    /// @pre neither shape is a compound: Bullet's own algorithms take those apart
    void update(const btCollisionObjectWrapper& a,
                const btCcdShapeModel& modelA,
                const btCollisionObjectWrapper& b,
                const btCcdShapeModel& modelB,
                btPersistentManifold* shared,
                btManifoldResult& result);
    /// Where any gap will do (btCcdSettings::m_anyWithin): lets the contacts follow the two if they
    /// have moved relative to each other by no more than a part of the shell since the last
    /// update, or are still farther apart than contacts matter. False if they need an update.
    [[nodiscard]] bool follow(const btCollisionObjectWrapper& a,
                              const btCcdShapeModel& modelA,
                              const btCollisionObjectWrapper& b,
                              const btCcdShapeModel& modelB);
    /// What the last update tells of the two at these poses.
    [[nodiscard]] btCcdKnownOfPair known(const btCollisionObject& a,
                                         const Eigen::Isometry3d& X_WA,
                                         const Eigen::Isometry3d& X_WB) const;
    /// Appends the manifolds that this owns.
    void appendTo(btManifoldArray& manifolds) const;

private:
    /// Contacts that go to one manifold.
    struct Share
    {
        Eigen::Vector3d normal;  // from A to B
        std::span<const bullet_ccd::Contact> contacts;
        btPersistentManifold* manifold = nullptr;
    };

    /// Pairs of triangles of the last two hierarchies.
    struct Kept
    {
        std::shared_ptr<const bullet_ccd::SsvTree> m_treeA;
        std::shared_ptr<const bullet_ccd::SsvTree> m_treeB;
        bullet_ccd::KeptSlots m_slots;
    };

    /// Of the surfaces in the last update: their distance, or one that they are beyond; the poses;
    /// and closest points, in the frames of both objects.
    struct Nearest
    {
        double m_distance = 0.0;  // 0: they may intersect
        bool m_hasPoints = false;
        Eigen::Vector3d m_onA = Eigen::Vector3d::Zero();
        Eigen::Vector3d m_onB = Eigen::Vector3d::Zero();
        Eigen::Isometry3d m_X_BA = Eigen::Isometry3d::Identity();
        Eigen::Matrix3d m_R_WB = Eigen::Matrix3d::Identity();  // when contacts followed last
        Eigen::Vector3d m_centerA = Eigen::Vector3d::Zero();   // of a ball around A
        double m_radiusA = 0.0;
        double m_shell = 0.0;

        /// No point of A has gone farther since then, in the frame of B.
        [[nodiscard]] double wayOf(const Eigen::Isometry3d& X_BA) const;
    };

    /// Of the last update, and where the deepest contact was then, in the frames of both objects.
    struct Inside
    {
        Eigen::Vector3d m_way = Eigen::Vector3d::Zero();
        Eigen::Vector3d m_onA = Eigen::Vector3d::Zero();
        Eigen::Vector3d m_onB = Eigen::Vector3d::Zero();
        Eigen::Vector3d m_apart = Eigen::Vector3d::Zero();  // from B to A, world
        bool m_isWholly = false;
    };

    void recall(const btCollisionObjectWrapper& a,
                const btCollisionObjectWrapper& b,
                bullet_ccd::PatchWorkspace& work) const;
    void assign(const Sides& sides,
                const bullet_ccd::PatchWorkspace& found,
                double reach,
                btManifoldResult& result);
    void chooseManifolds(const btCollisionObjectWrapper& a,
                         const btCollisionObjectWrapper& b,
                         std::span<Share> shares);
    void dropEmpty();
    /// Friction or restitution of the objects are no longer those of the points.
    [[nodiscard]] bool haveMaterialsChanged() const;
    void noteNearest(const Sides& sides,
                     double reach,
                     const std::vector<bullet_ccd::Contact>& found);

    btDispatcher* m_dispatcher;
    btManifoldArray m_manifolds;
    Kept m_kept;
    const btCollisionObject* m_first = nullptr;          // A of the last update,
    Eigen::Vector3d m_normal = Eigen::Vector3d::Zero();  // the normal of its deepest contact,
    double m_way = 0.0;  // how far its mesh was moved out of that of B,
    Inside m_inside;     // and see btCcdKnownOfPair
    Nearest m_nearest;
};

#endif  // BT_CCD_MANIFOLDS_H
