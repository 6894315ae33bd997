#include "grasp/report/grasp_scene.h"

#include "grasp/closing/swept_boxes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bullet_ccd::grasp
{
namespace
{
const Color kPalmColor(0.63F, 0.66F, 0.71F);
const std::array<Color, 5> kFingerColors = {Color(0.36F, 0.56F, 0.72F),
                                            Color(0.40F, 0.66F, 0.62F),
                                            Color(0.53F, 0.53F, 0.75F),
                                            Color(0.52F, 0.68F, 0.45F),
                                            Color(0.72F, 0.53F, 0.63F)};
constexpr double kMargin = 0.06;  ///< of the picture's size, on each side

/// How well the scene is seen from `direction`.
double scoreView(const GraspScene& scene, const Eigen::Vector3d& direction)
{
    constexpr int kSize = 140;
    const Camera camera = frameScene(scene, direction, kSize, kSize);
    Layer handLayer(kSize, kSize);
    for (const Shape& shape : scene.hand)
    {
        drawShape(handLayer, camera, shape);
    }
    Layer objectLayer(kSize, kSize);
    drawShape(objectLayer, camera, scene.object);

    double objectPixels = 0.0;
    double objectInFront = 0.0;
    for (std::size_t i = 0; i < objectLayer.id.size(); ++i)
    {
        const bool there = objectLayer.id[i] != kNone;
        objectPixels += there ? 1.0 : 0.0;
        objectInFront += there && objectLayer.depth[i] < handLayer.depth[i] ? 1.0 : 0.0;
    }
    double visible = 0.0;
    for (const GraspContact& contact : scene.contacts)
    {
        const bool hidden =
            isHidden(handLayer, camera.project(contact.point), 0.04 * scene.objectRadius);
        // Seen from the side a contact shows its arrow, head on only its disc.
        visible += hidden ? 0.0 : 1.0 - 0.5 * std::abs(contact.normal.dot(direction));
    }
    const double contactShare =
        scene.contacts.empty() ? 0.0 : visible / static_cast<double>(scene.contacts.size());
    const double objectShare = objectPixels > 0.0 ? objectInFront / objectPixels : 0.0;
    const double fromSide = 1.0 - std::abs(scene.approach_W.dot(direction));
    return contactShare + 0.5 * objectShare + 0.5 * fromSide;
}
}  // namespace

std::int32_t fingerOf(const HandModel& hand, std::int32_t link)
{
    for (std::size_t i = 0; i < hand.fingers.size(); ++i)
    {
        const std::vector<std::int32_t>& links = hand.fingers[i].links;
        if (std::find(links.begin(), links.end(), link) != links.end())
        {
            return static_cast<std::int32_t>(i);
        }
    }
    return kNone;
}

const Color& colorInTurn(std::size_t index)
{
    return kFingerColors[index % kFingerColors.size()];
}

Color colorOf(const HandModel& hand, std::int32_t link)
{
    const std::int32_t finger = fingerOf(hand, link);
    if (finger == kNone)
    {
        return kPalmColor;
    }
    const std::vector<std::int32_t>& links = hand.fingers[static_cast<std::size_t>(finger)].links;
    const auto place = std::find(links.begin(), links.end(), link) - links.begin();
    // Neighbouring links of a finger alternate a little.
    const float tone = place % 2 == 0 ? 1.0F : 1.14F;
    return tone * colorInTurn(static_cast<std::size_t>(finger));
}

GraspScene makeHandScene(const HandModel& hand, const Grasp& grasp)
{
    const KinematicTree& tree = hand.robot.tree;
    const std::vector<Eigen::Isometry3d> poses = linkPoses(tree, grasp.X_WH, grasp.positions);
    GraspScene scene;
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        if (hand.robot.linkMeshes[i].triangles.empty())
        {
            continue;
        }
        const auto link = static_cast<std::int32_t>(i);
        // Links above the palm (a forearm) may be cut by the frame.
        if (link == hand.palm || fingerOf(hand, link) != kNone)
        {
            scene.framed.push_back(static_cast<std::int32_t>(scene.hand.size()));
        }
        Shape& shape = scene.hand.emplace_back(makeShape(hand.robot.linkMeshes[i], poses[i]));
        shape.color = colorOf(hand, link);
        shape.id = link;
    }
    const Eigen::Vector3d approach = grasp.approach_W;
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    const Eigen::Isometry3d& X_RG = preshape == nullptr ? hand.X_RG : graspFrame(hand, *preshape);
    scene.approach_W = approach.norm() > 0.5
                           ? approach
                           : Eigen::Vector3d(grasp.X_WH.linear() * X_RG.linear().col(2));
    return scene;
}

GraspScene makeScene(const HandModel& hand,
                     const GraspObject& object,
                     const Grasp& grasp,
                     std::span<const RigidBody> obstacles)
{
    GraspScene scene = makeHandScene(hand, grasp);
    scene.object = makeShape(object.tree.mesh(), Eigen::Isometry3d::Identity());
    scene.object.color = kObjectColor;
    scene.object.id = static_cast<std::int32_t>(hand.robot.tree.size());
    for (const RigidBody& body : obstacles)
    {
        Shape& shape = scene.obstacles.emplace_back(makeShape(body.tree->mesh(), body.motion.X_W0));
        shape.color = kObstacleColor;
        shape.id = scene.object.id + static_cast<std::int32_t>(scene.obstacles.size());
    }
    scene.contacts = grasp.contacts;
    scene.objectRadius = object.radius;
    return scene;
}

void addSweptBoxes(GraspScene& scene, const HandModel& hand, const Grasp& grasp)
{
    const Preshape* preshape = findPreshape(hand, grasp.preshape);
    if (preshape == nullptr)
    {
        return;
    }
    const std::vector<Eigen::AlignedBox3d> boxes = sweptBoxes(hand, preshape->positions).closing;
    for (std::size_t link = 0; link < boxes.size(); ++link)
    {
        const auto index = static_cast<std::int32_t>(link);
        if (boxes[link].isEmpty() || fingerOf(hand, index) == kNone)
        {
            continue;
        }
        SceneBox& box = scene.boxes.emplace_back();
        box.color = colorOf(hand, index);
        for (std::size_t k = 0; k < box.corners.size(); ++k)
        {
            box.corners[k] =
                grasp.X_WH * boxes[link].corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
        }
    }
}

Camera frameScene(const GraspScene& scene, const Eigen::Vector3d& direction, int width, int height)
{
    // World z is up in the picture, unless seen along it: then the hand comes from above.
    const bool alongZ = std::abs(direction.z()) > 0.95;
    const Eigen::Vector3d up =
        alongZ ? Eigen::Vector3d(-scene.approach_W) : Eigen::Vector3d::UnitZ();
    Camera camera;
    camera.R_CW = lookFrom(direction, up);
    camera.width = width;
    camera.height = height;
    Eigen::AlignedBox3d box;
    const auto extend = [&](const Shape& shape)
    {
        for (const Eigen::Vector3d& vertex : shape.vertices)
        {
            box.extend(camera.R_CW * vertex);
        }
    };
    extend(scene.object);
    for (const std::int32_t i : scene.framed)
    {
        extend(scene.hand[static_cast<std::size_t>(i)]);
    }
    for (const SceneBox& swept : scene.boxes)
    {
        for (const Eigen::Vector3d& corner : swept.corners)
        {
            box.extend(camera.R_CW * corner);
        }
    }
    for (const Eigen::Vector3d& mark : scene.marks)
    {
        box.extend(camera.R_CW * mark);
    }
    const Eigen::Vector3d size = box.sizes().cwiseMax(1e-9);
    camera.center_W = camera.R_CW.transpose() * box.center();
    camera.pixelsPerMetre = (1.0 - 2.0 * kMargin) * std::min(width / size.x(), height / size.y());
    return camera;
}

std::array<Eigen::Vector3d, 2> chooseViews(const GraspScene& scene)
{
    struct View
    {
        Eigen::Vector3d direction;
        double score;
    };
    std::vector<View> views;
    for (const double elevation : {0.25, 0.7})
    {
        constexpr int kAround = 10;
        for (int i = 0; i < kAround; ++i)
        {
            const double azimuth = 2.0 * std::numbers::pi * (i + 0.25) / kAround;
            const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                            std::cos(elevation) * std::sin(azimuth),
                                            std::sin(elevation));
            views.push_back({direction, scoreView(scene, direction)});
        }
    }
    const auto better = [](const View& a, const View& b) { return a.score < b.score; };
    const View first = *std::max_element(views.begin(), views.end(), better);
    std::erase_if(views,
                  [&](const View& view) {
                      return view.direction.dot(first.direction) >
                             std::cos(75.0 / 180.0 * std::numbers::pi);
                  });
    const View second = *std::max_element(views.begin(), views.end(), better);
    return {first.direction, second.direction};
}

bool isHidden(const Layer& handLayer, const Eigen::Vector3d& projected, double slack)
{
    const double x = std::floor(projected.x());
    const double y = std::floor(projected.y());
    if (!(x >= 0.0 && y >= 0.0 && x < handLayer.width && y < handLayer.height))
    {
        return false;
    }
    const std::size_t pixel = handLayer.at(static_cast<int>(x), static_cast<int>(y));
    return handLayer.depth[pixel] < projected.z() - slack;
}
}  // namespace bullet_ccd::grasp
