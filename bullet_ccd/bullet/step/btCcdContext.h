/// What all pairs of one dispatcher share.
#ifndef BT_CCD_CONTEXT_H
#define BT_CCD_CONTEXT_H

#include "bullet_ccd/bullet/btCcdSettings.h"
#include "bullet_ccd/bullet/motion/btCcdObjectMotion.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <unordered_map>

class btDispatcher;

/// Settings by object.
struct btCcdObjectSettingsMap
{
    btCcdObjectSettings m_default;
    std::unordered_map<const btCollisionObject*, btCcdObjectSettings> m_own;

    [[nodiscard]] const btCcdObjectSettings& of(const btCollisionObject* object) const
    {
        const auto own = m_own.empty() ? m_own.end() : m_own.find(object);
        return own != m_own.end() ? own->second : m_default;
    }
};

/// One per dispatcher, made on demand. Algorithms come and go with pairs (contactTest makes one for
/// a single question), so nothing that is costly to make lives in them.
class btCcdContext
{
public:
    /// [m]; ten times that of the core, because btScalar may be single (docs/glossary.md).
    static constexpr double kDefaultTolerance = 10.0 * bullet_ccd::kDefaultTolerance;

    /// Made if there is none. Different dispatchers may be used by different threads.
    static btCcdContext& of(const btDispatcher& dispatcher);
    /// Forgets the context: all conversions are freed. The dispatcher must have no pairs left; it
    /// may be gone.
    static void release(const btDispatcher* dispatcher);

    btCcdShapeCache m_shapes;
    double m_tolerance = kDefaultTolerance;
    bool m_anyWithin = false;  ///< see btCcdSettings
    btCcdObjectSettingsMap m_objects;
    btCcdMotionSource* m_motions = nullptr;  ///< while a world is in the middle of its step

    /// The model, or null after having said once (per kind of shape) that it is not covered.
    const btCcdShapeModel* model(const btCollisionShape* shape);
    /// Has no model, and there is nothing to say of it: empty compounds, and soft bodies whose
    /// solver is btCcdDeformableBodySolver.
    [[nodiscard]] static bool needsNoModel(const btCollisionShape& shape);
    /// Makes the model and keeps what belongs into the folder; false if there is none.
    bool prepare(const btCollisionShape* shape);
    /// Says once of a collider whose pose is none that it is taken as turned only.
    void checkPose(const btCollisionObject& object);

    /// Of a pair [m].
    [[nodiscard]] double toleranceOf(const btCollisionObject& a, const btCollisionObject& b) const
    {
        return std::min({m_tolerance, m_objects.of(&a).m_tolerance, m_objects.of(&b).m_tolerance});
    }

private:
    void report(const btCollisionShape& shape, const char* keeps);

    std::mutex m_mutex;
    std::set<int> m_reported;  // shape types
    bool m_isPoseReported = false;
};

#endif  // BT_CCD_CONTEXT_H
