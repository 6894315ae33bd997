#include "bullet_ccd/bullet/step/btCcdContext.h"

#include "bullet_ccd/bullet/btCcdDeformableBodySolver.h"
#include "bullet_ccd/bullet/shapes/btCcdGap.h"

#include <BulletSoftBody/btSoftBodyInternals.h>

#include <cstdio>
#include <map>
#include <memory>
#include <mutex>

namespace
{
struct Contexts
{
    std::mutex m_mutex;
    std::map<const btDispatcher*, std::unique_ptr<btCcdContext>> m_all;
};

Contexts& contexts()
{
    static Contexts all;
    return all;
}
}  // namespace

btCcdContext& btCcdContext::of(const btDispatcher& dispatcher)
{
    const std::lock_guard lock(contexts().m_mutex);
    std::unique_ptr<btCcdContext>& context = contexts().m_all[&dispatcher];
    if (context == nullptr)
    {
        context = std::make_unique<btCcdContext>();
    }
    return *context;
}

void btCcdContext::release(const btDispatcher* dispatcher)
{
    const std::lock_guard lock(contexts().m_mutex);
    contexts().m_all.erase(dispatcher);
}

const btCcdShapeModel* btCcdContext::model(const btCollisionShape* shape)
{
    // Discrete contacts may ask on several threads; models stay where they are.
    const std::lock_guard lock(m_mutex);
    const btCcdShapeModel* model = m_shapes.find(shape);
    if (model == nullptr && !needsNoModel(*shape))
    {
        report(*shape, "it keeps");
    }
    else if (model != nullptr && model->m_uncovered != nullptr)
    {
        report(*model->m_uncovered, "as a child of a compound it keeps");
    }
    return model;
}

bool btCcdContext::needsNoModel(const btCollisionShape& shape)
{
    if (shape.getShapeType() != SOFTBODY_SHAPE_PROXYTYPE)
    {
        return btCcdIsEmpty(shape);
    }
    const btSoftBody* body = static_cast<const btSoftBodyCollisionShape&>(shape).m_body;
    return dynamic_cast<const btCcdDeformableBodySolver*>(body->m_softBodySolver) != nullptr;
}

bool btCcdContext::prepare(const btCollisionShape* shape)
{
    const btCcdShapeModel* found = model(shape);
    if (found != nullptr)
    {
        m_shapes.keep(*found);
    }
    return found != nullptr;
}

void btCcdContext::report(const btCollisionShape& shape, const char* keeps)
{
    if (m_reported.insert(shape.getShapeType()).second)
    {
        std::fprintf(stderr,
                     "bullet_ccd: %s (shape type %d) is not covered by continuous collision "
                     "detection; %s Bullet's discrete contacts\n",
                     shape.getName(),
                     shape.getShapeType(),
                     keeps);
    }
}

void btCcdContext::checkPose(const btCollisionObject& object)
{
    const btMatrix3x3& basis = object.getWorldTransform().getBasis();
    if (m_isPoseReported || btCcdIsRotation(basis))
    {
        return;
    }
    m_isPoseReported = true;
    std::fprintf(stderr,
                 "bullet_ccd: the basis in the transform of a collider (%s) is no rotation; its "
                 "columns are %g, %g and %g long. It is taken as the rotation that is like it: to "
                 "scale a shape, call its setLocalScaling()\n",
                 object.getCollisionShape()->getName(),
                 double(basis.getColumn(0).length()),
                 double(basis.getColumn(1).length()),
                 double(basis.getColumn(2).length()));
}
