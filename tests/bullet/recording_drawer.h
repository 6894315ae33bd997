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

    std::vector<Eigen::Vector3d> m_colors;  ///< of the lines

    void drawLine(const btVector3& from, const btVector3& to, const btVector3& color) override
    {
        m_lines.emplace_back(btCcdToEigen(from), btCcdToEigen(to));
        m_colors.push_back(btCcdToEigen(color));
    }
    std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> linesOf(
        const Eigen::Vector3d& color) const
    {
        std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> lines;
        for (std::size_t i = 0; i < m_lines.size(); ++i)
        {
            if (m_colors[i] == color)
            {
                lines.push_back(m_lines[i]);
            }
        }
        return lines;
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
