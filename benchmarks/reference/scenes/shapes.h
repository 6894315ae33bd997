/// Meshes for tests with vertices exactly where a closed form needs them. Written apart from
/// bullet_ccd/mesh, so that a scene does not depend on the code under test.
#pragma once

#include "benchmarks/reference/scenes/random.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <Eigen/Geometry>

#include <initializer_list>
#include <vector>

namespace bullet_ccd::reference
{
[[nodiscard]] TriangleMesh triangle(const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);

/// A line segment: one degenerate triangle.
[[nodiscard]] TriangleMesh segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Flat quadrilateral of two triangles, corners in order.
[[nodiscard]] TriangleMesh quad(const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b,
                                const Eigen::Vector3d& c,
                                const Eigen::Vector3d& d);

/// The plane z = `z` as a square of that half edge.
[[nodiscard]] TriangleMesh floorAt(double z, double half);

/// The planes x = `x` and y = `y` as squares of that half edge.
[[nodiscard]] TriangleMesh wallAtX(double x, double half);
[[nodiscard]] TriangleMesh wallAtY(double y, double half);

[[nodiscard]] TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// Cube centred at the origin.
[[nodiscard]] TriangleMesh cube(double half);

/// Inscribed sphere about the origin with one vertex exactly at radius * direction.
[[nodiscard]] TriangleMesh sphereWithPole(double radius,
                                          const Eigen::Vector3d& direction,
                                          int rings = 8);

/// Points at the given angles on a circle about the origin.
[[nodiscard]] std::vector<Eigen::Vector2d> circlePoints(double radius,
                                                        const std::vector<double>& angles);

/// `count` equally spaced angles from `first` on, and `extra` sorted in between.
[[nodiscard]] std::vector<double> circleAngles(int count,
                                               double first,
                                               std::initializer_list<double> extra = {});

/// Convex prism over a counter-clockwise ring of points (x, y).
[[nodiscard]] TriangleMesh prism(const std::vector<Eigen::Vector2d>& ring,
                                 double zLow,
                                 double zHigh);

/// |x| + |y| + |z| <= 1.
[[nodiscard]] TriangleMesh octahedron();

/// Random triangles with centres in a cube of the given half edge and corners `size` about them.
[[nodiscard]] TriangleMesh soup(Random& random, int count, double half, double size);

[[nodiscard]] TriangleMesh merged(std::initializer_list<TriangleMesh> meshes);

[[nodiscard]] TriangleMesh placed(TriangleMesh mesh, const Eigen::Isometry3d& X);
[[nodiscard]] TriangleMesh shifted(TriangleMesh mesh, const Eigen::Vector3d& offset);
[[nodiscard]] TriangleMesh scaled(TriangleMesh mesh, double factor);
/// The same surface with triangles in random order and their corners rotated.
[[nodiscard]] TriangleMesh permuted(TriangleMesh mesh, Random& random);

/// Largest distance of a vertex from the origin of the mesh frame.
[[nodiscard]] double radiusOf(const TriangleMesh& mesh);

/// Rotation by `angle` about `axis` and then a shift.
[[nodiscard]] Eigen::Isometry3d poseOf(const Eigen::Vector3d& translation,
                                       double angle = 0.0,
                                       const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ());
}  // namespace bullet_ccd::reference
