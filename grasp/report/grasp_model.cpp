#include "grasp/report/grasp_model.h"

#include "bullet_ccd/math/check.h"
#include "bullet_ccd/math/pose.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/closing/swept_boxes.h"
#include "grasp/report/gltf_builder.h"
#include "grasp/report/grasp_scene.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace bullet_ccd::grasp
{
namespace
{
const Color kSweptColor(0.35F, 0.38F, 0.43F);
constexpr float kConeOpacity = 0.45F;
/// Shares of the object's radius.
constexpr double kBallRadius = 0.03;
constexpr double kConeHeight = 0.34;
constexpr int kConeSegments = 32;

void addHand(GltfBuilder& gltf, int root, const HandModel& hand, const GraspScene& scene)
{
    const int parent = gltf.addNode("hand", root);
    for (const Shape& shape : scene.hand)
    {
        const std::string& name = linkName(hand, shape.id);
        const int material = gltf.addMaterial(name, shape.color, 1.0F);
        gltf.addNode(
            name, parent, gltf.addTriangles(name, shape, material), Eigen::Isometry3d::Identity());
    }
}

void addObject(GltfBuilder& gltf, int root, const GraspObject& object, const GraspScene& scene)
{
    const std::string name = "object: " + object.name;
    const int material = gltf.addMaterial("object", scene.object.color, kObjectCover);
    gltf.addNode(
        name, root, gltf.addTriangles(name, scene.object, material), Eigen::Isometry3d::Identity());
}

void addObstacles(GltfBuilder& gltf, int root, const GraspScene& scene)
{
    if (scene.obstacles.empty())
    {
        return;
    }
    const int parent = gltf.addNode("obstacles", root);
    const int material = gltf.addMaterial("obstacle", kObstacleColor, kObjectCover);
    for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    {
        const std::string name = "obstacle " + std::to_string(i + 1);
        gltf.addNode(name,
                     parent,
                     gltf.addTriangles(name, scene.obstacles[i], material),
                     Eigen::Isometry3d::Identity());
    }
}

Shape ballShape(double radius)
{
    return makeShape(makeSphere(radius, 2), Eigen::Isometry3d::Identity());
}

/// Apex at the origin, open towards +z.
Shape coneShape(double height, double friction)
{
    const std::vector<Eigen::Vector2d> profile = {
        {0.0, 0.0}, {friction * height, height}, {0.0, height}};
    return makeShape(makeRevolved(profile, kConeSegments), Eigen::Isometry3d::Identity());
}

/// At the point, z along the normal.
Eigen::Isometry3d contactPose(const GraspContact& contact)
{
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), contact.normal).toRotationMatrix();
    X.translation() = contact.point;
    return X;
}

/// The same shape at every contact.
void addAtContacts(GltfBuilder& gltf,
                   int root,
                   const HandModel& hand,
                   const GraspScene& scene,
                   const std::string& what,
                   const Shape& shape,
                   float opacity)
{
    const int parent = gltf.addNode(what + "s", root);
    if (scene.contacts.empty())
    {
        return;
    }
    const int material = gltf.addMaterial(what, kContactColor, opacity);
    const int mesh = gltf.addTriangles(what, shape, material);
    for (std::size_t i = 0; i < scene.contacts.size(); ++i)
    {
        const GraspContact& contact = scene.contacts[i];
        gltf.addNode(what + " " + std::to_string(i + 1) + ": " + linkName(hand, contact.link),
                     parent,
                     mesh,
                     contactPose(contact));
    }
}

/// The edges of a cube of side 1 about the origin.
int addCubeEdges(GltfBuilder& gltf, int material)
{
    std::vector<Eigen::Vector3f> corners;
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (std::uint32_t corner = 0; corner < 8; ++corner)
    {
        corners.emplace_back((corner & 1U) != 0 ? 0.5F : -0.5F,
                             (corner & 2U) != 0 ? 0.5F : -0.5F,
                             (corner & 4U) != 0 ? 0.5F : -0.5F);
        for (const std::uint32_t axis : {1U, 2U, 4U})
        {
            if ((corner & axis) == 0)
            {
                edges.push_back({corner, corner | axis});
            }
        }
    }
    return gltf.addLines("swept box", corners, edges, material);
}

void addSweptBoxes(GltfBuilder& gltf, int root, const HandModel& hand, const Grasp& grasp)
{
    const int parent = gltf.addNode("swept boxes", root, kNone, grasp.X_WH);
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    if (preshape == nullptr)
    {
        return;
    }
    const std::vector<Eigen::AlignedBox3d> boxes = sweptBoxes(hand, preshape->positions).closing;
    const int cube = addCubeEdges(gltf, gltf.addMaterial("swept box", kSweptColor, 1.0F));
    for (std::size_t link = 0; link < boxes.size(); ++link)
    {
        if (!boxes[link].isEmpty())
        {
            gltf.addNode("swept box: " + hand.robot.tree.links[link].name,
                         parent,
                         cube,
                         Eigen::Isometry3d(Eigen::Translation3d(boxes[link].center())),
                         boxes[link].sizes());
        }
    }
}

/// Turns z up to y up.
Eigen::Isometry3d yUp()
{
    return Eigen::Isometry3d(Eigen::AngleAxisd(-std::numbers::pi / 2.0, Eigen::Vector3d::UnitX()));
}
}  // namespace

void writeGraspModel(const HandModel& hand,
                     const GraspObject& object,
                     const Grasp& grasp,
                     double friction,
                     const std::filesystem::path& file,
                     std::span<const RigidBody> obstacles)
{
    require(friction > 0.0, "writeGraspModel: friction must be positive");
    require(!grasp.positions.empty(), "writeGraspModel: the grasp was never closed");
    const GraspScene scene = makeScene(hand, object, grasp, obstacles);
    GltfBuilder gltf;
    const int root = gltf.addNode("grasp", kNone, kNone, yUp());
    addHand(gltf, root, hand, scene);
    addObject(gltf, root, object, scene);
    addObstacles(gltf, root, scene);
    addAtContacts(gltf, root, hand, scene, "contact", ballShape(kBallRadius * object.radius), 1.0F);
    addAtContacts(gltf,
                  root,
                  hand,
                  scene,
                  "friction cone",
                  coneShape(kConeHeight * object.radius, friction),
                  kConeOpacity);
    addSweptBoxes(gltf, root, hand, grasp);
    gltf.write(file);
}

void writeMotionModel(const std::string& root,
                      std::span<const float> times,
                      std::span<const MotionTrack> tracks,
                      const std::filesystem::path& file)
{
    GltfBuilder gltf;
    const int parent = gltf.addNode(root, kNone, kNone, yUp());
    std::vector<std::pair<Color, int>> materials;
    for (const MotionTrack& track : tracks)
    {
        auto material = std::ranges::find(materials, track.color, &std::pair<Color, int>::first);
        if (material == materials.end())
        {
            materials.emplace_back(track.color, gltf.addMaterial(track.name, track.color, 1.0F));
            material = materials.end() - 1;
        }
        const Shape shape = makeShape(track.tree->mesh(), Eigen::Isometry3d::Identity());
        const int mesh = gltf.addTriangles(track.name, shape, material->second);
        const int node = gltf.addNode(track.name, parent, mesh, track.poses.front());
        if (track.poses.size() > 1)
        {
            gltf.animate(node, times, track.poses);
        }
    }
    gltf.write(file);
}
}  // namespace bullet_ccd::grasp
