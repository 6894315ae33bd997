/// Pictures and the page that shows them.
#pragma once

#include "bullet_ccd/export.h"
#include "grasp/formats/grasp_file.h"

#include <filesystem>
#include <span>

namespace bullet_ccd::grasp
{
struct PictureOptions
{
    int width = 1200;  ///< pixels; two views side by side
    int height = 640;
    bool sweptBoxes = false;  ///< the boxes that links pass through while they close
    /// Bodies beside the object: drawn, but see-through where they hide hand or object, and cut by
    /// the frame.
    std::span<const RigidBody> obstacles = {};
    int columns = 0;         ///< of moments; 0: all side by side
    bool wholeHand = false;  ///< moments show all links, an arm above the palm, too
};

/// Renders hand, object and contacts (points and normals) of a grasp to a PNG: two views, shaded,
/// hidden surfaces removed, the object see-through enough that contacts behind it are found,
/// contacts behind a link drawn faintly. Swept boxes are drawn as edges in the colours of their
/// links, faint where a surface hides them. The views are chosen so that few contacts are hidden; a
/// bar gives the scale. Throws std::runtime_error if the file cannot be written,
/// std::invalid_argument for a size below 64 pixels.
BULLET_CCD_API void drawGrasp(const HandModel& hand,
                              const GraspObject& object,
                              const Grasp& grasp,
                              const PictureOptions& options,
                              const std::filesystem::path& file);

/// A hand and an object that move.
struct Moment
{
    Eigen::Isometry3d X_WH = Eigen::Isometry3d::Identity();  ///< of the root link
    std::vector<double> positions{};                         ///< one entry per link [rad or m]
    Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();  ///< of the object's mesh frame
};

/// Renders moments to a PNG, row by row, all from one side and at one scale, with a bar for it.
/// The side is that which shows the hand best at the first moment. Throws as drawGrasp(). Swept
/// boxes of the options are not looked at.
BULLET_CCD_API void drawMoments(const HandModel& hand,
                                const GraspObject& object,
                                std::span<const Moment> moments,
                                const PictureOptions& options,
                                const std::filesystem::path& file);

/// Renders bodies at rest, each in a colour of its own, among the obstacles of the options to a
/// PNG: from behind x = 0, where robots stand, and from above, all of it in the frame. Throws as
/// drawGrasp(). Swept boxes of the options are not looked at.
BULLET_CCD_API void drawBodies(std::span<const RigidBody> bodies,
                               const PictureOptions& options,
                               const std::filesystem::path& file);

/// Puts pictures of one size into one PNG at half of it, row by row, as many a row; of each only
/// the last of `panels` that stand side by side in it. Throws std::runtime_error if a file cannot
/// be read or written, std::invalid_argument for no pictures and for different sizes.
BULLET_CCD_API void joinPictures(std::span<const std::filesystem::path> pictures,
                                 int panels,
                                 int columns,
                                 const std::filesystem::path& file);

/// Renders the hand in a preshape to a PNG, without an object, from four sides: along the axes of
/// its grasp frame, x, y and against z, and obliquely. The grasp frame is drawn (x red, y green, z
/// blue: the way to the object), and for every finger the way of its tip while it closes. Throws as
/// drawGrasp(). Obstacles and swept boxes of the options are not looked at.
BULLET_CCD_API void drawPreshape(const HandModel& hand,
                                 const Preshape& preshape,
                                 const PictureOptions& options,
                                 const std::filesystem::path& file);

/// One HTML page: what was found, the pictures of the best, a table of all grasps that sorts by any
/// column, and the settings of the run. Needs nothing but itself and the pictures, to which it
/// links relative to its own folder.
/// @param grasps    best first
/// @param pictures  of the first grasps, in their order
/// Throws std::runtime_error if the file cannot be written.
BULLET_CCD_API void writeReport(const GraspRun& run,
                                const HandModel& hand,
                                const GraspObject& object,
                                std::span<const Grasp> grasps,
                                std::span<const std::filesystem::path> pictures,
                                const std::filesystem::path& file);
}  // namespace bullet_ccd::grasp
