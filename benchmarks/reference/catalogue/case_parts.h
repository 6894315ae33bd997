/// What several files of the catalogue, and tests of the same scenes, build their cases of.
#pragma once

#include "benchmarks/reference/catalogue/cases.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <numbers>
#include <string>
#include <vector>

namespace bullet_ccd::reference
{
inline constexpr double kPi = std::numbers::pi;

/// Walls between two rings of as many points, at two heights: a tube, or a flat frame.
[[nodiscard]] TriangleMesh band(const std::vector<Eigen::Vector2d>& ring,
                                double z,
                                const std::vector<Eigen::Vector2d>& otherRing,
                                double otherZ);
/// The same over one ring, open at both ends.
[[nodiscard]] TriangleMesh tube(const std::vector<Eigen::Vector2d>& ring, double low, double high);
[[nodiscard]] std::vector<Eigen::Vector2d> square(double half);
/// From an apex to the corners of a polygon about z.
[[nodiscard]] TriangleMesh fan(const Eigen::Vector3d& apex, double radius, double z, int sides);
/// Segments from the origin along x for a chain of those lengths; the base has no geometry.
[[nodiscard]] std::vector<TriangleMesh> rods(const std::vector<double>& lengths);

/// A gap of 1 that is closed at speed 2.
[[nodiscard]] RigidCase falls(const std::string& id, TriangleMesh body, TriangleMesh ground);

/// A cube moves over the plane z = 0, which is a square.
[[nodiscard]] RigidCase cubeOverFloor(const std::string& id,
                                      const RigidMotion& motion,
                                      const CaseAnswer& answer,
                                      double half = 1.0,
                                      double floorHalf = 10.0);

/// A segment of that length turns about its end from along x towards the wall y = h.
[[nodiscard]] RigidCase rodToWall(const std::string& id, double length, double h, double w);

/// A bar of half thickness 0.05 turns about its end by `w` over the motion into a round pin of
/// radius 0.1 at polar (1.5, 1.2); contact on the bar's side.
[[nodiscard]] RigidCase barToPin(const std::string& id, double w);

/// Polygons of as many sides: a shaft turns in a bearing whose inscribed circle has radius 1.
[[nodiscard]] RigidCase shaftInBearing(const std::string& id,
                                       int sides,
                                       double radius,
                                       const CaseAnswer& answer);

/// A cube meets and leaves a sheet of no thickness in a thousandth of the motion.
[[nodiscard]] RigidCase throughSheet(const std::string& id, double half, double from);

/// Unit spheres pass at that offset: tangent at 2.
[[nodiscard]] RigidCase passingSpheres(const std::string& id, double offset);

/// A rod turns half around, its tip `excess` beyond a wall; negative: short of it.
[[nodiscard]] RigidCase grazingRod(const std::string& id, double excess);

/// A point at radius 1 + excess of a wheel that rolls on the plane comes down in a cusp.
[[nodiscard]] RigidCase rollingSpike(const std::string& id, double excess);

/// The answer in a unit of length `factor` times as small.
[[nodiscard]] CaseAnswer scaled(CaseAnswer answer, double factor);

/// The case in units of which `factor` make up one.
[[nodiscard]] RigidCase inUnits(const std::string& id, RigidCase tested, double factor);

/// A rigid case in which A turns about z at the origin and B rests, as a chain of one joint.
[[nodiscard]] ArticulatedCase asJoint(const std::string& id, const RigidCase& rigid);

/// The two bodies turn and fly as one about a point on the way of both.
void moveAsOne(RigidScene& scene,
               const Eigen::Vector3d& v,
               const Eigen::Vector3d& w,
               const Eigen::Vector3d& center);

/// Mirrored fingers meet with their tips over a small ball.
[[nodiscard]] ArticulatedCase fingersMeet(const std::string& id);
}  // namespace bullet_ccd::reference
