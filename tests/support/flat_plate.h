/// A flat plate of many triangles, which lies on others of its kind in ties without number.
#pragma once

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>

namespace bullet_ccd::tests
{
/// A square of side `side` in z = 0 about the origin, of 2 * cells^2 triangles.
inline TriangleMesh flatPlate(int cells, double side)
{
    TriangleMesh mesh;
    for (int j = 0; j <= cells; ++j)
    {
        for (int i = 0; i <= cells; ++i)
        {
            mesh.vertices.emplace_back(
                side * (1.0 * i / cells - 0.5), side * (1.0 * j / cells - 0.5), 0.0);
        }
    }
    for (int j = 0; j < cells; ++j)
    {
        for (int i = 0; i < cells; ++i)
        {
            const int a = j * (cells + 1) + i;
            mesh.triangles.push_back({a, a + 1, a + cells + 2});
            mesh.triangles.push_back({a, a + cells + 2, a + cells + 1});
        }
    }
    return mesh;
}

/// A plate of side 1 above one of side 3, whose frame is turned anyhow; at no time is a part of
/// the first beside the second.
struct PlateAbovePlate
{
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();

    /// @param gap of the lowest corner
    PlateAbovePlate(reference::Random& random, double gap, double tilt) : X_WB(random.pose(2.0))
    {
        const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
        X_BA.linear() = (Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()) *
                         Eigen::AngleAxisd(random.uniform(0.0, 6.0), z))
                            .toRotationMatrix();
        X_BA.translation() =
            Eigen::Vector3d(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), 0.0);
        X_BA.translation().z() = gap - lowest();
    }

    /// The height of the lowest corner of A over B, which is their distance.
    [[nodiscard]] double lowest() const
    {
        double height = std::numeric_limits<double>::infinity();
        for (const double x : {-0.5, 0.5})
        {
            for (const double y : {-0.5, 0.5})
            {
                height = std::min(height, (X_BA * Eigen::Vector3d(x, y, 0.0)).z());
            }
        }
        return height;
    }
};
}  // namespace bullet_ccd::tests
