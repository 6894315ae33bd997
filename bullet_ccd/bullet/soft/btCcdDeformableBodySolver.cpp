#include "bullet_ccd/bullet/btCcdDeformableBodySolver.h"

#include "bullet_ccd/bullet/soft/btCcdSoftStep.h"
#include "bullet_ccd/math/check.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <LinearMath/btIDebugDraw.h>

#include <cmath>
#include <utility>

namespace
{
bool hasConcavePart(const btCollisionShape& shape)
{
    if (!shape.isCompound())
    {
        return shape.isConcave();
    }
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
    {
        if (hasConcavePart(*compound.getChildShape(i)))
        {
            return true;
        }
    }
    return false;
}

/// True if the solver knows what the nodes of the body are the corners of.
bool hasElements(const btSoftBody& body)
{
    return body.m_faces.size() + body.m_links.size() + body.m_tetras.size() > 0;
}
}  // namespace

btCcdDeformableBodySolver::btCcdDeformableBodySolver() : m_step(std::make_unique<btCcdSoftStep>())
{
}
btCcdDeformableBodySolver::~btCcdDeformableBodySolver() = default;

void btCcdDeformableBodySolver::setCcdSeparation(double separation)
{
    bullet_ccd::require(separation > 0.0 && std::isfinite(separation),
                        "btCcdDeformableBodySolver: the separation must be a positive distance");
    m_step->m_separation = separation;
}

double btCcdDeformableBodySolver::getCcdSeparation() const
{
    return m_step->m_separation;
}

void btCcdDeformableBodySolver::setCcdThreads(int threads)
{
    bullet_ccd::require(threads > 0, "btCcdDeformableBodySolver: it needs at least one thread");
    m_step->m_threads = threads;
}

const btCcdSoftCounters& btCcdDeformableBodySolver::getCcdSoftCounters() const
{
    return m_step->m_counters;
}

void btCcdDeformableBodySolver::resetCcdSoftCounters()
{
    m_step->m_counters = {};
}

void btCcdDeformableBodySolver::forgetCcdShape(const btCollisionShape* shape)
{
    m_step->m_obstacles.forget(shape);
}

void btCcdDeformableBodySolver::debugDraw(btIDebugDraw* drawer)
{
    if (m_isEnabled && drawer != nullptr &&
        (drawer->getDebugMode() & btIDebugDraw::DBG_DrawWireframe) != 0)
    {
        m_step->draw(*drawer);
    }
}

void btCcdDeformableBodySolver::predictMotion(btScalar timeStep)
{
    if (m_isEnabled && m_softBodies.size() > 0 && m_softBodies[0]->m_worldInfo->m_broadphase)
    {
        m_step->begin(*m_softBodies[0]->m_worldInfo->m_broadphase, timeStep);
    }
    btDeformableBodySolver::predictMotion(timeStep);
}

void btCcdDeformableBodySolver::solveDeformableConstraints(btScalar timeStep)
{
    btDeformableBodySolver::solveDeformableConstraints(timeStep);
    for (int i = 0; i < m_softBodies.size() && m_isEnabled; ++i)
    {
        btSoftBody* body = m_softBodies[i];
        if (body->isActive() && hasElements(*body))
        {
            m_leftOut.emplace_back(body, body->getActivationState());
            body->forceActivationState(ISLAND_SLEEPING);
        }
    }
}

void btCcdDeformableBodySolver::applyTransforms(btScalar timeStep)
{
    for (const auto& [body, state] : std::exchange(m_leftOut, {}))
    {
        body->forceActivationState(state);
    }
    if (!m_isEnabled)
    {
        btDeformableBodySolver::applyTransforms(timeStep);
        return;
    }
    m_step->run(m_softBodies, timeStep);
    btDeformableBodySolver::applyTransforms(timeStep);
    m_step->finish();
}

void btCcdDeformableBodySolver::processCollision(btSoftBody* softBody,
                                                 const btCollisionObjectWrapper* collider)
{
    const btCollisionShape* shape = collider->getCollisionObject()->getCollisionShape();
    if (!m_isEnabled || !hasConcavePart(*shape) || !m_step->m_obstacles.isCovered(shape))
    {
        btDeformableBodySolver::processCollision(softBody, collider);
    }
}
