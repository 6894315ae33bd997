/// A btIDebugDraw that remembers what it was asked to draw.
#pragma once

#include "bullet_ccd/bullet/btCcdConversions.h"

#include <Eigen/Geometry>
#include <LinearMath/btIDebugDraw.h>

#include <utility>
#include <vector>

namespace bullet_ccd::tests
{
class RecordingDrawer : public btIDebugDraw
{
public:
    std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> m_lines;

    void drawLine(const btVector3& from, const btVector3& to, const btVector3&) override
    {
        m_lines.emplace_back(btCcdToEigen(from), btCcdToEigen(to));
    }
    void drawContactPoint(
        const btVector3&, const btVector3&, btScalar, int, const btVector3&) override
    {
    }
    void reportErrorWarning(const char*) override {}
    void draw3dText(const btVector3&, const char*) override {}
    void setDebugMode(int mode) override { m_mode = mode; }
    int getDebugMode() const override { return m_mode; }

private:
    int m_mode = DBG_DrawWireframe;
};
}  // namespace bullet_ccd::tests
