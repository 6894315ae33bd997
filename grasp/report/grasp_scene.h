/// A grasp as shapes in W, and the two directions from which it is seen best.
#pragma once

#include "bullet_ccd/toi/rigid_toi.h"
#include "grasp/grasp_types.h"
#include "grasp/hand/hand_model.h"
#include "grasp/report/raster.h"

#include <array>
#include <span>
#include <vector>

namespace bullet_ccd::grasp
{
/// Of points of contact and what is drawn at them.
inline const Color kContactColor(0.86F, 0.07F, 0.24F);
inline const Color kObjectColor(0.93F, 0.62F, 0.27F);
inline const Color kObstacleColor(0.62F, 0.60F, 0.56F);
/// Share of an obstacle's colour where it lies in front of the hand or the object.
inline constexpr float kObstacleCover = 0.25F;
/// Share of the object's colour where it lies in front of a link.
inline constexpr float kObjectCover = 0.6F;

/// A box that a link sweeps, in W; corner k has the upper end along axis i where bit i of k is set.
struct SceneBox
{
    std::array<Eigen::Vector3d, 8> corners;
    Color color;
};

struct GraspScene
{
    std::vector<Shape> hand;       ///< one a link with geometry; id = link
    Shape object;                  ///< id = number of links
    std::vector<Shape> obstacles;  ///< bodies beside the object; ids follow that of the object
    std::vector<GraspContact> contacts;
    Eigen::Vector3d approach_W = Eigen::Vector3d::UnitZ();
    double objectRadius = 0.0;             ///< [m]
    std::vector<std::int32_t> framed;      ///< entries of `hand` that must be in the picture
    std::vector<SceneBox> boxes;           ///< empty until addSweptBoxes()
    std::vector<Eigen::Vector3d> marks{};  ///< points that must be in the picture, too
};

/// Each finger has its own, the rest of the hand another.
[[nodiscard]] Color colorOf(const HandModel& hand, std::int32_t link);

/// One of some colours that are told apart, and that of links of fingers.
[[nodiscard]] const Color& colorInTurn(std::size_t index);

/// Finger that the link belongs to, or kNone.
[[nodiscard]] std::int32_t fingerOf(const HandModel& hand, std::int32_t link);

/// The hand alone.
[[nodiscard]] GraspScene makeHandScene(const HandModel& hand, const Grasp& grasp);

[[nodiscard]] GraspScene makeScene(const HandModel& hand,
                                   const GraspObject& object,
                                   const Grasp& grasp,
                                   std::span<const RigidBody> obstacles = {});

/// Adds the boxes of all links of fingers while they close from the grasp's preshape; none if the
/// hand does not have it.
void addSweptBoxes(GraspScene& scene, const HandModel& hand, const Grasp& grasp);

/// Camera of the given size in pixels that looks from `direction` with the object, palm, fingers,
/// boxes and marks filling the picture up to a margin.
[[nodiscard]] Camera frameScene(const GraspScene& scene,
                                const Eigen::Vector3d& direction,
                                int width,
                                int height);

/// Unit directions towards the viewer. The first shows most contacts that no link hides, most of
/// the object, and the approach from the side; the second does so from at least 75 degrees away.
[[nodiscard]] std::array<Eigen::Vector3d, 2> chooseViews(const GraspScene& scene);

/// True if a link lies in front of the point: `handDepth` is a layer of the hand alone.
[[nodiscard]] bool isHidden(const Layer& handLayer, const Eigen::Vector3d& projected, double slack);
}  // namespace bullet_ccd::grasp
