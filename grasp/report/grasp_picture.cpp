#include "grasp/report/grasp_picture.h"

#include "bullet_ccd/math/check.h"
#include "grasp/report/canvas.h"
#include "grasp/report/grasp_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
const Color kPaper(0.985F, 0.985F, 0.99F);
const Color kPaperBelow(0.91F, 0.925F, 0.945F);
const Color kInk(0.25F, 0.28F, 0.33F);
constexpr float kHiddenOpacity = 0.45F;
/// Everything is drawn this much larger and averaged.
constexpr int kSupersampling = 2;

/// Object over hand over obstacles over paper. `front` receives the shape that is nearest in each
/// pixel, obstacles in front of others left out.
Canvas compose(const Layer& hand,
               const Layer& object,
               const Layer& obstacles,
               std::vector<std::int32_t>& front)
{
    Canvas canvas(hand.width, hand.height);
    for (int y = 0; y < canvas.height; ++y)
    {
        const float share = static_cast<float>(y) / static_cast<float>(canvas.height);
        const Color paper = kPaper + share * (kPaperBelow - kPaper);
        for (int x = 0; x < canvas.width; ++x)
        {
            const std::size_t i = hand.at(x, y);
            const bool objectInFront = object.depth[i] < hand.depth[i];
            const bool hasObstacle = obstacles.id[i] != kNone;
            const Color behind = hasObstacle ? obstacles.color[i] : paper;
            Color color = hand.id[i] != kNone ? hand.color[i] : behind;
            if (objectInFront)
            {
                const float cover = hand.id[i] != kNone ? kObjectCover : 1.0F;
                color += cover * (object.color[i] - color);
            }
            front[i] = objectInFront ? object.id[i] : hand.id[i];
            if (front[i] == kNone)
            {
                front[i] = obstacles.id[i];
            }
            else if (hasObstacle && obstacles.depth[i] < std::min(hand.depth[i], object.depth[i]))
            {
                color += kObstacleCover * (obstacles.color[i] - color);
            }
            canvas.at(x, y) = color;
        }
    }
    return canvas;
}

/// Darkens the pixels where one shape ends and another begins, or the depth jumps.
void drawOutlines(Canvas& canvas,
                  const Layer& hand,
                  const Layer& object,
                  const Layer& obstacles,
                  const std::vector<std::int32_t>& front,
                  double jump)
{
    const auto depthAt = [&](std::size_t i)
    {
        const bool isObstacle = hand.id[i] == kNone && object.id[i] == kNone;
        return isObstacle ? obstacles.depth[i] : std::min(hand.depth[i], object.depth[i]);
    };
    for (int y = 0; y + 1 < canvas.height; ++y)
    {
        for (int x = 0; x + 1 < canvas.width; ++x)
        {
            const std::size_t here = hand.at(x, y);
            for (const std::size_t there : {hand.at(x + 1, y), hand.at(x, y + 1)})
            {
                const bool edge =
                    front[here] != front[there] ||
                    (front[here] != kNone && std::abs(depthAt(here) - depthAt(there)) > jump);
                if (edge)
                {
                    canvas.at(x, y) *= 0.62F;
                    break;
                }
            }
        }
    }
}

struct ContactStyle
{
    double arrowLength;  ///< [m]
    double slack;        ///< depth within which a link does not hide the point it touches [m]
    double unit;         ///< width of a thin line [pixels]
};

/// Disc at the point, arrow along the normal into the object; faint where a link hides the point.
void drawContact(Canvas& canvas,
                 const GraspContact& contact,
                 const Camera& camera,
                 const Layer& hand,
                 const ContactStyle& style)
{
    const Eigen::Vector3d place = camera.project(contact.point);
    const Eigen::Vector3d end = camera.project(contact.point + style.arrowLength * contact.normal);
    const bool hidden = isHidden(hand, place, style.slack);
    const float opacity = hidden ? kHiddenOpacity : 1.0F;
    const Ink halo{Color::Ones(), 0.85F * opacity};
    const Ink ink{kContactColor, opacity};

    const double unit = style.unit;
    const Eigen::Vector2d from = place.head<2>();
    const Eigen::Vector2d along = end.head<2>() - from;
    const double length = along.norm();
    const double head = 9.0 * unit;
    if (length > head)
    {
        const Eigen::Vector2d direction = along / length;
        const Eigen::Vector2d neck = from + (length - 0.8 * head) * direction;
        drawLine(canvas, from, neck, 4.4 * unit, halo);
        drawArrowHead(
            canvas, from + (length + 2.0 * unit) * direction, direction, head + 4.0 * unit, halo);
        drawLine(canvas, from, neck, 2.2 * unit, ink);
        drawArrowHead(canvas, from + length * direction, direction, head, ink);
    }
    drawLine(canvas, from, from, 10.0 * unit, halo);
    drawLine(canvas, from, from, 7.0 * unit, ink);
}

/// From the farthest to the nearest.
void drawContacts(Canvas& canvas, const GraspScene& scene, const Camera& camera, const Layer& hand)
{
    std::vector<std::size_t> order(scene.contacts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto depth = [&](std::size_t i) { return camera.project(scene.contacts[i].point).z(); };
    std::stable_sort(order.begin(),
                     order.end(),
                     [&](std::size_t a, std::size_t b) { return depth(a) > depth(b); });
    // Many contacts are drawn smaller, so that single ones can still be told apart.
    const double crowd = order.size() > 24 ? 0.7 : 1.0;
    const ContactStyle style{.arrowLength = 0.34 * crowd * scene.objectRadius,
                             .slack = 0.04 * scene.objectRadius,
                             .unit = crowd * canvas.height / 640.0};
    for (const std::size_t i : order)
    {
        drawContact(canvas, scene.contacts[i], camera, hand, style);
    }
}

/// One edge of a swept box: faint where a surface lies in front of it.
void drawBoxEdge(Canvas& canvas,
                 const Eigen::Vector3d& from,
                 const Eigen::Vector3d& to,
                 const Color& color,
                 const Layer& hand,
                 const Layer& object)
{
    constexpr int kPieces = 48;
    const double unit = canvas.height / 640.0;
    for (int piece = 0; piece < kPieces; ++piece)
    {
        const Eigen::Vector3d begin = from + (to - from) * piece / kPieces;
        const Eigen::Vector3d end = from + (to - from) * (piece + 1) / kPieces;
        const Eigen::Vector3d middle = 0.5 * (begin + end);
        const bool hidden = isHidden(hand, middle, 0.0) || isHidden(object, middle, 0.0);
        drawLine(canvas,
                 begin.head<2>(),
                 end.head<2>(),
                 1.4 * unit,
                 {0.75F * color, hidden ? 0.25F : 0.9F});
    }
}

void drawBoxes(Canvas& canvas,
               const GraspScene& scene,
               const Camera& camera,
               const Layer& hand,
               const Layer& object)
{
    for (const SceneBox& box : scene.boxes)
    {
        for (std::size_t corner = 0; corner < box.corners.size(); ++corner)
        {
            for (const std::size_t axis : {1U, 2U, 4U})
            {
                if ((corner & axis) == 0)
                {
                    drawBoxEdge(canvas,
                                camera.project(box.corners[corner]),
                                camera.project(box.corners[corner | axis]),
                                box.color,
                                hand,
                                object);
                }
            }
        }
    }
}

/// Bar of 1, 2 or 5 times a power of ten millimetres, about a fifth of the panel wide.
void drawScaleBar(Canvas& canvas, double pixelsPerMetre, int left, int panelWidth)
{
    const double wanted = 0.2 * panelWidth / pixelsPerMetre * 1000.0;  // [mm]
    const double power = std::pow(10.0, std::floor(std::log10(wanted)));
    const double mantissa = wanted / power;
    const double millimetres = power * (mantissa >= 5.0 ? 5.0 : (mantissa >= 2.0 ? 2.0 : 1.0));
    if (millimetres < 1.0 || millimetres > 1e6)
    {
        return;  // no whole number of millimetres to write
    }
    const double length = millimetres / 1000.0 * pixelsPerMetre;
    const Ink ink{kInk, 0.9F};
    const double x = left + 18.0;
    const double y = canvas.height - 18.0;
    const std::string text = std::to_string(static_cast<int>(millimetres)) + " mm";
    const int labelLeft = static_cast<int>(std::max(x, x + 0.5 * (length - labelWidth(text, 2))));
    // A pale plate, so that it is read in front of a dark hand, too.
    const double right = std::max(x + length, labelLeft + static_cast<double>(labelWidth(text, 2)));
    const Ink pale{Color(0.97F, 0.98F, 0.99F), 0.8F};
    drawLine(canvas, {x - 6.0, y - 8.0}, {right + 6.0, y - 8.0}, 40.0, pale);
    drawLine(canvas, {x, y}, {x + length, y}, 2.5, ink);
    drawLine(canvas, {x, y - 4.0}, {x, y + 4.0}, 1.5, ink);
    drawLine(canvas, {x + length, y - 4.0}, {x + length, y + 4.0}, 1.5, ink);
    drawLabel(canvas, text, {labelLeft, canvas.height - 42}, 2, ink);
}

/// One view, supersampled.
Canvas drawView(const GraspScene& scene, const Camera& camera)
{
    Layer hand(camera.width, camera.height);
    for (const Shape& shape : scene.hand)
    {
        drawShape(hand, camera, shape);
    }
    Layer object(camera.width, camera.height);
    drawShape(object, camera, scene.object);
    Layer obstacles(camera.width, camera.height);
    for (const Shape& shape : scene.obstacles)
    {
        drawShape(obstacles, camera, shape);
    }
    std::vector<std::int32_t> front(hand.id.size(), kNone);
    Canvas canvas = compose(hand, object, obstacles, front);
    drawOutlines(canvas, hand, object, obstacles, front, 0.08 * scene.objectRadius);
    drawBoxes(canvas, scene, camera, hand, object);
    drawContacts(canvas, scene, camera, hand);
    return canvas;
}
void requireSize(const PictureOptions& options, const std::filesystem::path& file)
{
    require(options.width >= 64 && options.height >= 64,
            file.string() + ": picture of " + std::to_string(options.width) + " x " +
                std::to_string(options.height) + " pixels: ask for at least 64 x 64");
}

void drawArrow(Canvas& canvas,
               const Camera& camera,
               std::span<const Eigen::Vector3d> way,
               const Color& color)
{
    const double unit = canvas.height / 640.0;
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector3d& point : way)
    {
        points.emplace_back(camera.project(point).head<2>());
    }
    for (const Ink& ink : {Ink{Color::Ones(), 0.85F}, Ink{color, 1.0F}})
    {
        const double width = (ink.color == color ? 3.0 : 5.5) * unit;
        for (std::size_t i = 1; i < points.size(); ++i)
        {
            drawLine(canvas, points[i - 1], points[i], width, ink);
        }
    }
    const Eigen::Vector2d last = points.back() - points[points.size() - 2];
    if (last.norm() > 1e-9)
    {
        drawArrowHead(canvas,
                      points.back() + 5.0 * unit * last.normalized(),
                      last.normalized(),
                      13.0 * unit,
                      {color, 1.0F});
    }
}

/// Where the middle of the finger's last link with geometry goes while the hand closes by half.
std::vector<Eigen::Vector3d> wayOfTip(const HandModel& hand,
                                      const Finger& finger,
                                      const Preshape& preshape)
{
    constexpr int kSteps = 24;
    constexpr double kPart = 0.5;
    std::vector<Eigen::Vector3d> way;
    const auto tip =
        std::find_if(finger.links.rbegin(),
                     finger.links.rend(),
                     [&](std::int32_t link)
                     { return hand.linkTrees[static_cast<std::size_t>(link)] != nullptr; });
    if (tip == finger.links.rend())
    {
        return way;
    }
    const auto link = static_cast<std::size_t>(*tip);
    const Eigen::Vector3d middle = bounds(hand.robot.linkMeshes[link]).center();
    const std::vector<double> closed = closedPositions(hand, preshape.positions);
    for (int step = 0; step <= kSteps; ++step)
    {
        std::vector<double> positions = preshape.positions;
        for (std::size_t i = 0; i < positions.size(); ++i)
        {
            positions[i] += kPart * step / kSteps * (closed[i] - positions[i]);
        }
        way.push_back(linkPoses(hand.robot.tree, Eigen::Isometry3d::Identity(), positions)[link] *
                      middle);
    }
    return way;
}
}  // namespace

void drawPreshape(const HandModel& hand,
                  const Preshape& preshape,
                  const PictureOptions& options,
                  const std::filesystem::path& file)
{
    requireSize(options, file);
    const Eigen::Isometry3d& X_RG = graspFrame(hand, preshape);
    Grasp open;
    open.preshape = preshape.name;
    open.positions = preshape.positions;
    open.approach_W = X_RG.linear().col(2);
    GraspScene scene = makeHandScene(hand, open);
    Eigen::AlignedBox3d box;
    for (const std::int32_t link : scene.framed)  // not an arm
    {
        for (const Eigen::Vector3d& vertex : scene.hand[static_cast<std::size_t>(link)].vertices)
        {
            box.extend(vertex);
        }
    }
    scene.objectRadius = 0.25 * box.sizes().norm();  // of what outlines and arrows are shares
    const Eigen::Vector3d x = X_RG.linear().col(0);
    const Eigen::Vector3d y = X_RG.linear().col(1);
    const Eigen::Vector3d z = X_RG.linear().col(2);
    struct Arrow
    {
        std::vector<Eigen::Vector3d> way;
        Color color;
    };
    std::vector<Arrow> arrows;
    for (const Finger& finger : hand.fingers)
    {
        arrows.push_back(
            {wayOfTip(hand, finger, preshape), 0.6F * colorOf(hand, finger.links.front())});
    }
    for (int axis = 0; axis < 3; ++axis)
    {
        Color color = Color::Constant(0.1F);
        color[axis] = 0.8F;
        const Eigen::Vector3d end =
            X_RG.translation() + 0.5 * scene.objectRadius * X_RG.linear().col(axis);
        arrows.push_back({{X_RG.translation(), end}, color});
    }
    for (const Arrow& arrow : arrows)
    {
        scene.marks.insert(scene.marks.end(), arrow.way.begin(), arrow.way.end());
    }
    Canvas picture(options.width, options.height);
    const int panelWidth = options.width / 4;
    int left = 0;
    for (const Eigen::Vector3d& direction : {x, y, z, Eigen::Vector3d(x + y + 0.8 * z)})
    {
        const Camera camera = frameScene(scene,
                                         direction.normalized(),
                                         kSupersampling * panelWidth,
                                         kSupersampling * options.height);
        Canvas view = drawView(scene, camera);
        for (const Arrow& arrow : arrows)
        {
            if (!arrow.way.empty())
            {
                drawArrow(view, camera, arrow.way, arrow.color);
            }
        }
        shrinkInto(picture, left, view);
        drawScaleBar(picture, camera.pixelsPerMetre / kSupersampling, left, panelWidth);
        left += panelWidth;
    }
    writePng(picture, file);
}

void drawMoments(const HandModel& hand,
                 const GraspObject& object,
                 std::span<const Moment> moments,
                 const PictureOptions& options,
                 const std::filesystem::path& file)
{
    requireSize(options, file);
    require(!moments.empty(), file.string() + ": no moments to draw: give one or more");
    std::vector<GraspScene> scenes;
    std::vector<Eigen::Vector3d> marks;
    for (const Moment& moment : moments)
    {
        Grasp grasp;
        grasp.X_WH = moment.X_WH;
        grasp.positions = moment.positions;
        GraspScene& scene = scenes.emplace_back(makeScene(hand, object, grasp, options.obstacles));
        for (Eigen::Vector3d& vertex : scene.object.vertices)
        {
            vertex = moment.X_WO * vertex;
        }
        for (std::array<Eigen::Vector3f, 3>& corner : scene.object.normals)
        {
            for (Eigen::Vector3f& normal : corner)
            {
                normal = moment.X_WO.linear().cast<float>() * normal;
            }
        }
        marks.insert(marks.end(), scene.object.vertices.begin(), scene.object.vertices.end());
        if (options.wholeHand)
        {
            scene.framed.resize(scene.hand.size());
            std::iota(scene.framed.begin(), scene.framed.end(), 0);
        }
        for (const std::int32_t link : scene.framed)
        {
            const Shape& shape = scene.hand[static_cast<std::size_t>(link)];
            marks.insert(marks.end(), shape.vertices.begin(), shape.vertices.end());
        }
    }
    const Eigen::Vector3d direction = chooseViews(scenes.front()).front();
    scenes.front().marks = std::move(marks);
    const auto count = static_cast<int>(scenes.size());
    const int columns = options.columns > 0 ? std::min(options.columns, count) : count;
    const int panelWidth = options.width / columns;
    const int panelHeight = options.height / ((count + columns - 1) / columns);
    const Camera camera = frameScene(
        scenes.front(), direction, kSupersampling * panelWidth, kSupersampling * panelHeight);
    Canvas picture(options.width, options.height);
    for (int k = 0; k < count; ++k)
    {
        shrinkInto(picture,
                   k % columns * panelWidth,
                   drawView(scenes[static_cast<std::size_t>(k)], camera),
                   k / columns * panelHeight);
    }
    drawScaleBar(picture, camera.pixelsPerMetre / kSupersampling, 0, panelWidth);
    writePng(picture, file);
}

void drawBodies(std::span<const RigidBody> bodies,
                const PictureOptions& options,
                const std::filesystem::path& file)
{
    requireSize(options, file);
    GraspScene scene;
    const auto add = [&](const RigidBody& body, const Color& color, std::vector<Shape>& to)
    {
        Shape& shape = to.emplace_back(makeShape(body.tree->mesh(), body.motion.X_W0));
        shape.color = color;
        shape.id = static_cast<std::int32_t>(scene.hand.size() + scene.obstacles.size());
        scene.marks.insert(scene.marks.end(), shape.vertices.begin(), shape.vertices.end());
        scene.objectRadius = std::max(scene.objectRadius, body.tree->radius());
    };
    for (const RigidBody& body : bodies)
    {
        add(body, colorInTurn(scene.hand.size()), scene.hand);
    }
    for (const RigidBody& body : options.obstacles)
    {
        add(body, kObstacleColor, scene.obstacles);
    }
    require(!scene.marks.empty(), file.string() + ": no bodies to draw: give one or more");
    scene.object.id = static_cast<std::int32_t>(scene.hand.size() + scene.obstacles.size()) + 1;
    scene.approach_W = -Eigen::Vector3d::UnitX();
    Canvas picture(options.width, options.height);
    const int panelWidth = options.width / 2;
    int left = 0;
    for (const Eigen::Vector3d& direction :
         {Eigen::Vector3d(-1.0, -0.5, 0.7), Eigen::Vector3d(-0.2, 0.0, 1.0)})
    {
        const Camera camera = frameScene(scene,
                                         direction.normalized(),
                                         kSupersampling * panelWidth,
                                         kSupersampling * options.height);
        shrinkInto(picture, left, drawView(scene, camera));
        drawScaleBar(picture, camera.pixelsPerMetre / kSupersampling, left, panelWidth);
        left += panelWidth;
    }
    writePng(picture, file);
}

void joinPictures(std::span<const std::filesystem::path> pictures,
                  int panels,
                  int columns,
                  const std::filesystem::path& file)
{
    require(!pictures.empty(), file.string() + ": no pictures to join: give one or more");
    const Canvas first = readPng(pictures.front());
    const auto count = static_cast<int>(pictures.size());
    const int across = std::min(columns, count);
    const int width = first.width / panels / 2;
    const int height = first.height / 2;
    Canvas joined(across * width, (count + across - 1) / across * height);
    std::ranges::fill(joined.pixels, Color::Ones());
    for (int k = 0; k < count; ++k)
    {
        const std::filesystem::path& name = pictures[static_cast<std::size_t>(k)];
        Canvas whole = readPng(name);
        require(whole.width == first.width && whole.height == first.height,
                name.string() + ": is of another size than the first picture: draw it anew");
        Canvas panel(2 * width, 2 * height);
        for (int y = 0; y < panel.height; ++y)
        {
            for (int x = 0; x < panel.width; ++x)
            {
                panel.at(x, y) = whole.at(whole.width - panel.width + x, y);
            }
        }
        shrinkInto(joined, k % across * width, panel, k / across * height);
    }
    writePng(joined, file);
}

void drawGrasp(const HandModel& hand,
               const GraspObject& object,
               const Grasp& grasp,
               const PictureOptions& options,
               const std::filesystem::path& file)
{
    requireSize(options, file);
    GraspScene scene = makeScene(hand, object, grasp, options.obstacles);
    if (options.sweptBoxes)
    {
        addSweptBoxes(scene, hand, grasp);
    }
    Canvas picture(options.width, options.height);
    const int panelWidth = options.width / 2;
    int left = 0;
    for (const Eigen::Vector3d& direction : chooseViews(scene))
    {
        const Camera camera = frameScene(
            scene, direction, kSupersampling * panelWidth, kSupersampling * options.height);
        shrinkInto(picture, left, drawView(scene, camera));
        drawScaleBar(picture, camera.pixelsPerMetre / kSupersampling, left, panelWidth);
        left += panelWidth;
    }
    drawLine(picture,
             {panelWidth + 0.0, 0.0},
             {panelWidth + 0.0, options.height + 0.0},
             2.0,
             {Color(0.80F, 0.82F, 0.85F), 1.0F});
    writePng(picture, file);
}
}  // namespace bullet_ccd::grasp
