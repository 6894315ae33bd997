#include "benchmarks/reference/catalogue/case_parts.h"

#include "benchmarks/reference/scenes/random_trees.h"

#include <utility>

namespace bullet_ccd::reference
{
using Eigen::Vector2d;
using Eigen::Vector3d;

TriangleMesh band(const std::vector<Vector2d>& ring,
                  double z,
                  const std::vector<Vector2d>& otherRing,
                  double otherZ)
{
    TriangleMesh mesh;
    for (std::size_t i = 0; i < ring.size(); ++i)
    {
        const std::size_t next = (i + 1) % ring.size();
        const auto at = [](const Vector2d& p, double height)
        { return Vector3d(p.x(), p.y(), height); };
        mesh = merged({mesh,
                       quad(at(ring[i], z),
                            at(ring[next], z),
                            at(otherRing[next], otherZ),
                            at(otherRing[i], otherZ))});
    }
    return mesh;
}

TriangleMesh tube(const std::vector<Vector2d>& ring, double low, double high)
{
    return band(ring, low, ring, high);
}

std::vector<Vector2d> square(double half)
{
    return {{-half, -half}, {half, -half}, {half, half}, {-half, half}};
}

TriangleMesh fan(const Vector3d& apex, double radius, double z, int sides)
{
    TriangleMesh mesh{.vertices = {apex}, .triangles = {}};
    for (const Vector2d& p : circlePoints(radius, circleAngles(sides, 0.0)))
    {
        mesh.vertices.emplace_back(p.x(), p.y(), z);
    }
    for (std::int32_t i = 0; i < sides; ++i)
    {
        mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % sides});
    }
    return mesh;
}

std::vector<TriangleMesh> rods(const std::vector<double>& lengths)
{
    std::vector<TriangleMesh> meshes(1);
    for (const double length : lengths)
    {
        meshes.push_back(segment({0, 0, 0}, {length, 0, 0}));
    }
    return meshes;
}

RigidCase falls(const std::string& id, TriangleMesh body, TriangleMesh ground)
{
    return {.id = id,
            .scene = {.meshA = std::move(body),
                      .meshB = std::move(ground),
                      .motionA = {.v_W = {0, 0, -2}}},
            .answer = {.time = 0.5, .closingSpeed = 2.0}};
}

RigidCase cubeOverFloor(const std::string& id,
                        const RigidMotion& motion,
                        const CaseAnswer& answer,
                        double half,
                        double floorHalf)
{
    return {.id = id,
            .scene = {.meshA = cube(half), .meshB = floorAt(0.0, floorHalf), .motionA = motion},
            .answer = answer};
}

CaseAnswer scaled(CaseAnswer answer, double factor)
{
    answer.length *= factor;
    answer.closingSpeed *= factor;
    answer.closingAcceleration *= factor;
    answer.clearance *= factor;
    return answer;
}

RigidCase inUnits(const std::string& id, RigidCase tested, double factor)
{
    tested.id = id;
    tested.scene = scaled(tested.scene, factor);
    tested.answer = scaled(tested.answer, factor);
    return tested;
}

void moveAsOne(RigidScene& scene, const Vector3d& v, const Vector3d& w, const Vector3d& center)
{
    for (RigidMotion* motion : {&scene.motionA, &scene.motionB})
    {
        motion->v_W = v;
        motion->w_W = w;
        motion->reference_B = motion->X_W0.inverse() * center;
    }
}

ArticulatedCase asJoint(const std::string& id, const RigidCase& rigid)
{
    const RigidScene& scene = rigid.scene;
    return {.id = id,
            .tree = planarChain({1.0}),
            .linkMeshes = {{}, scene.meshA},
            .motion = {.root = {}, .positions = {0, 0}, .rates = {0, scene.motionA.w_W.z()}},
            .obstacles = {placed(scene.meshB, scene.motionB.X_W0)},
            .answer = rigid.answer,
            .links = {1}};
}
}  // namespace bullet_ccd::reference
