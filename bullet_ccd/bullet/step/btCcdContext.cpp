#include "bullet_ccd/bullet/step/btCcdContext.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>

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

bool btCcdIsEmpty(const btCollisionShape& shape)
{
    return shape.getShapeType() == COMPOUND_SHAPE_PROXYTYPE &&
           static_cast<const btCompoundShape&>(shape).getNumChildShapes() == 0;
}

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
    const btCcdShapeModel* model = m_shapes.find(shape);
    if (model == nullptr && !btCcdIsEmpty(*shape) &&
        m_reported.insert(shape->getShapeType()).second)
    {
        std::fprintf(stderr,
                     "bullet_ccd: %s (shape type %d) is not covered by continuous collision "
                     "detection; it keeps Bullet's discrete contacts\n",
                     shape->getName(),
                     shape->getShapeType());
    }
    return model;
}
