#include "grasp/report/grasp_picture.h"

#include "bullet_ccd/mesh/triangle_mesh.h"
#include "grasp/report/grasp_scene.h"
#include "tests/grasp/planner/test_hands.h"
#include "tests/grasp/report/report_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <png.h>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace bullet_ccd::grasp
{
namespace
{
using tests::makeBoxGrasp;
using tests::makeBoxHand;

struct Picture
{
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> bytes;  ///< red, green, blue
};

Picture readPng(const std::filesystem::path& file)
{
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_file(&image, file.c_str()), 0) << image.message;
    image.format = PNG_FORMAT_RGB;
    Picture picture;
    picture.width = static_cast<int>(image.width);
    picture.height = static_cast<int>(image.height);
    picture.bytes.resize(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, picture.bytes.data(), 0, nullptr), 0);
    return picture;
}

/// Pixels of the three kinds of things, told by which channel leads.
struct Census
{
    int object = 0;   ///< orange
    int contact = 0;  ///< crimson
    int hand = 0;     ///< blue, green, or grey well below the paper
    int paper = 0;
};

Census countPixels(const Picture& picture, int firstColumn, int lastColumn)
{
    Census census;
    for (int y = 0; y < picture.height; ++y)
    {
        for (int x = firstColumn; x < lastColumn; ++x)
        {
            const std::size_t i = 3 * static_cast<std::size_t>(y * picture.width + x);
            const int r = picture.bytes[i];
            const int g = picture.bytes[i + 1];
            const int b = picture.bytes[i + 2];
            const bool isContact = r > 180 && g < 60 && b < 100;
            const bool isObject = !isContact && r > g + 15 && g > b + 15;
            const bool isPaper = r > 225 && g > 225 && b > 225;
            census.contact += isContact ? 1 : 0;
            census.object += isObject ? 1 : 0;
            census.paper += isPaper ? 1 : 0;
            census.hand += !isContact && !isObject && !isPaper && std::max(g, b) > r ? 1 : 0;
        }
    }
    return census;
}

GraspObject makeBall()
{
    return makeGraspObject("ball", makeSphere(0.05, 3));
}

TEST(DrawGrasp, BothViewsShowHandObjectContactsAndPaper)
{
    const std::filesystem::path file = tests::outputFile("grasp.png");
    drawGrasp(makeBoxHand(), makeBall(), makeBoxGrasp(6), {.width = 800, .height = 420}, file);
    const Picture picture = readPng(file);
    ASSERT_EQ(picture.width, 800);
    ASSERT_EQ(picture.height, 420);
    for (const int first : {0, 400})
    {
        const Census census = countPixels(picture, first, first + 400);
        const int panel = 400 * 420;
        EXPECT_GT(census.object, panel / 50);
        EXPECT_GT(census.hand, panel / 50);
        EXPECT_GT(census.paper, panel / 10);
        EXPECT_GT(census.contact, 100);
        EXPECT_LT(census.contact, panel / 20);
    }
}

TEST(DrawGrasp, WithoutContactsThereIsNoCrimson)
{
    const std::filesystem::path file = tests::outputFile("no_contacts.png");
    drawGrasp(makeBoxHand(), makeBall(), makeBoxGrasp(0), {.width = 400, .height = 300}, file);
    const Census census = countPixels(readPng(file), 0, 400);
    EXPECT_EQ(census.contact, 0);
    EXPECT_GT(census.object, 1000);
}

TEST(DrawGrasp, SweptBoxesHoldTheirLinksAndAreDrawn)
{
    const HandModel hand = tests::makeThreeFingers();
    Grasp grasp;
    grasp.preshape = "open";
    grasp.X_WH = Eigen::Translation3d(0.01, 0.02, -0.06) * Eigen::Quaterniond(0.8, 0.6, 0.0, 0.0);
    grasp.positions = {0.0, 0.4, 0.3, 0.2, 0.7, 0.5, 0.1};
    GraspScene scene = makeScene(hand, makeBall(), grasp);
    addSweptBoxes(scene, hand, grasp);
    ASSERT_EQ(scene.boxes.size(), 6U);  // of all links but the palm
    for (std::size_t link = 1; link < 7; ++link)
    {
        Eigen::AlignedBox3d box;  // in the root link
        for (const Eigen::Vector3d& corner : scene.boxes[link - 1].corners)
        {
            box.extend(grasp.X_WH.inverse() * corner);
        }
        for (const Eigen::Vector3d& vertex : scene.hand[link].vertices)
        {
            EXPECT_LT(box.exteriorDistance(grasp.X_WH.inverse() * vertex), 1e-12);
        }
    }
    const std::filesystem::path with = tests::outputFile("boxes.png");
    const std::filesystem::path without = tests::outputFile("no_boxes.png");
    drawGrasp(hand, makeBall(), grasp, {.width = 300, .height = 200, .sweptBoxes = true}, with);
    drawGrasp(hand, makeBall(), grasp, {.width = 300, .height = 200}, without);
    EXPECT_NE(readPng(with).bytes, readPng(without).bytes);
}

/// A plate below the ball covers paper; a wall between ball and viewer lets it shine through.
TEST(DrawGrasp, ObstaclesAreDrawnAndHideNothing)
{
    const SsvTree plate = buildSsvTree(makeBox({0.3, 0.3, 0.001}));
    const std::vector<RigidBody> floor{
        {.tree = &plate,
         .motion = {.X_W0 = Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, -0.06))}}};
    const auto census = [&](std::span<const RigidBody> obstacles, const std::string& name)
    {
        const std::filesystem::path file = tests::outputFile(name);
        drawGrasp(makeBoxHand(),
                  makeBall(),
                  makeBoxGrasp(6),
                  {.width = 400, .height = 300, .obstacles = obstacles},
                  file);
        return countPixels(readPng(file), 0, 400);
    };
    const Census without = census({}, "no_plate.png");
    const Census with = census(floor, "plate.png");
    EXPECT_LT(with.paper, 0.7 * without.paper);
    EXPECT_NEAR(with.object, without.object, 0.1 * without.object);
    const SsvTree box = buildSsvTree(makeBox({0.3, 0.3, 0.3}));
    const std::vector<RigidBody> around{{.tree = &box, .motion = {}}};
    EXPECT_GT(census(around, "inside.png").object, 0.5 * without.object);
}

TEST(DrawBodies, ShowsThemAmongObstaclesFromTwoSides)
{
    const SsvTree ball = buildSsvTree(makeSphere(0.05, 3));
    const SsvTree table = buildSsvTree(makeBox({0.3, 0.2, 0.01}));
    RigidBody body{.tree = &ball};
    body.motion.X_W0.translation().z() = 0.06;
    const RigidBody below{.tree = &table};
    const std::filesystem::path file = tests::outputFile("bodies.png");
    drawBodies(std::span(&body, 1),
               {.width = 400, .height = 200, .obstacles = std::span(&below, 1)},
               file);
    const Picture picture = readPng(file);
    ASSERT_EQ(picture.width, 400);
    for (const int left : {0, 200})
    {
        const Census census = countPixels(picture, left, left + 200);
        EXPECT_GT(census.hand, 300) << left;    // the ball is blue
        EXPECT_GT(census.paper, 5000) << left;  // nothing is cut
        EXPECT_LT(census.paper, 35000) << left;
    }
    EXPECT_THROW(drawBodies({}, {}, file), std::invalid_argument);
}

TEST(JoinPictures, PutsTheLastPanelsSideBySideAtHalfTheirSize)
{
    const SsvTree ball = buildSsvTree(makeSphere(0.05, 3));
    const RigidBody body{.tree = &ball};
    const std::filesystem::path one = tests::outputFile("one.png");
    drawBodies(std::span(&body, 1), {.width = 400, .height = 160}, one);
    const Picture whole = readPng(one);
    const std::filesystem::path file = tests::outputFile("joined.png");
    const std::vector<std::filesystem::path> three(3, one);
    joinPictures(three, 2, 2, file);
    const Picture joined = readPng(file);
    ASSERT_EQ(joined.width, 200);
    ASSERT_EQ(joined.height, 160);
    const auto red = [](const Picture& picture, int x, int y)
    { return int(picture.bytes[3 * static_cast<std::size_t>(y * picture.width + x)]); };
    for (int y = 0; y < 80; y += 7)
    {
        for (int x = 0; x < 100; x += 9)
        {
            const int mean =
                (red(whole, 200 + 2 * x, 2 * y) + red(whole, 201 + 2 * x, 2 * y) +
                 red(whole, 200 + 2 * x, 2 * y + 1) + red(whole, 201 + 2 * x, 2 * y + 1)) /
                4;
            EXPECT_NEAR(red(joined, x, y), mean, 1);
            EXPECT_NEAR(red(joined, 100 + x, y), mean, 1);
            EXPECT_NEAR(red(joined, x, 80 + y), mean, 1);
            EXPECT_EQ(red(joined, 100 + x, 80 + y), 255);  // there is no fourth one
        }
    }
    EXPECT_THROW(joinPictures({}, 1, 1, file), std::invalid_argument);
    const std::vector<std::filesystem::path> different{one, file};
    EXPECT_THROW(joinPictures(different, 1, 2, tests::outputFile("never.png")),
                 std::invalid_argument);
}

TEST(DrawMoments, OfTheWholeHandStandInRowsAndNothingIsCut)
{
    const HandModel hand = makeBoxHand();
    const GraspObject ball = makeBall();
    const Grasp grasp = makeBoxGrasp(3);
    const Moment moment{.X_WH = grasp.X_WH, .positions = grasp.positions};
    const std::vector<Moment> moments(3, moment);
    const std::filesystem::path file = tests::outputFile("moments.png");
    drawMoments(
        hand, ball, moments, {.width = 600, .height = 400, .columns = 2, .wholeHand = true}, file);
    const Picture picture = readPng(file);
    ASSERT_EQ(picture.width, 600);
    ASSERT_EQ(picture.height, 400);
    for (int y = 0; y < 150; ++y)  // above the bar
    {
        for (int x = 0; x < 900; ++x)
        {
            EXPECT_EQ(picture.bytes[static_cast<std::size_t>(3 * y * 600 + x)],
                      picture.bytes[static_cast<std::size_t>(3 * (y + 200) * 600 + x)]);
        }
    }
    for (const int edge : {0, 299})  // paper all along the left and right edge of a panel
    {
        EXPECT_EQ(countPixels(picture, edge, edge + 1).hand, 0);
        EXPECT_EQ(countPixels(picture, edge, edge + 1).object, 0);
    }
}

TEST(DrawPreshape, ShowsHandFrameAndWaysFromFourSides)
{
    const HandModel hand = tests::makeThreeFingers();
    const std::filesystem::path file = tests::outputFile("preshape.png");
    drawPreshape(hand, hand.preshapes.front(), {.width = 800, .height = 240}, file);
    const Picture picture = readPng(file);
    for (int first = 0; first < 800; first += 200)
    {
        const Census census = countPixels(picture, first, first + 200);
        EXPECT_GT(census.hand, 500);
        EXPECT_GT(census.paper, 200 * 240 / 10);
    }
    EXPECT_THROW(drawPreshape(hand, hand.preshapes.front(), {.width = 10, .height = 10}, file),
                 std::invalid_argument);
}

TEST(DrawGrasp, FiveFingersHaveFiveColours)
{
    HandModel hand;
    for (std::int32_t link = 0; link < 5; ++link)
    {
        hand.fingers.push_back({.name = "finger", .links = {link}});
    }
    for (std::int32_t a = 0; a < 5; ++a)
    {
        for (std::int32_t b = 0; b < a; ++b)
        {
            EXPECT_GT((colorOf(hand, a) - colorOf(hand, b)).norm(), 0.13F) << a << " " << b;
        }
    }
}

TEST(DrawGrasp, TheSameGraspGivesTheSameBytes)
{
    const std::filesystem::path first = tests::outputFile("first.png");
    const std::filesystem::path second = tests::outputFile("second.png");
    drawGrasp(makeBoxHand(), makeBall(), makeBoxGrasp(4), {.width = 300, .height = 200}, first);
    drawGrasp(makeBoxHand(), makeBall(), makeBoxGrasp(4), {.width = 300, .height = 200}, second);
    EXPECT_EQ(readPng(first).bytes, readPng(second).bytes);
}

TEST(DrawGrasp, AFolderThatIsMissingIsNamedInTheError)
{
    const std::filesystem::path file = tests::outputFile("missing") / "folder" / "grasp.png";
    try
    {
        drawGrasp(makeBoxHand(), makeBall(), makeBoxGrasp(2), {.width = 100, .height = 100}, file);
        FAIL() << "no exception";
    }
    catch (const std::runtime_error& error)
    {
        EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
    }
    EXPECT_THROW(drawGrasp(makeBoxHand(), makeBall(), makeBoxGrasp(2), {.width = 10}, file),
                 std::invalid_argument);
}

TEST(GraspScene, BothViewsFrameHandAndObject)
{
    const GraspScene scene = makeScene(makeBoxHand(), makeBall(), makeBoxGrasp(4));
    const auto views = chooseViews(scene);
    EXPECT_LT(views[0].dot(views[1]), std::cos(75.0 / 180.0 * std::numbers::pi) + 1e-9);
    for (const Eigen::Vector3d& direction : views)
    {
        EXPECT_NEAR(direction.norm(), 1.0, 1e-12);
        const Camera camera = frameScene(scene, direction, 300, 200);
        for (const Shape& shape : scene.hand)
        {
            for (const Eigen::Vector3d& vertex : shape.vertices)
            {
                const Eigen::Vector3d pixel = camera.project(vertex);
                EXPECT_GE(pixel.x(), 0.0);
                EXPECT_LE(pixel.x(), 300.0);
                EXPECT_GE(pixel.y(), 0.0);
                EXPECT_LE(pixel.y(), 200.0);
            }
        }
    }
}

TEST(GraspScene, MarksAreInThePicture)
{
    GraspScene scene = makeHandScene(makeBoxHand(), makeBoxGrasp(1));
    const Eigen::Vector3d far(0.3, -0.5, 0.7);  // well outside of the hand
    const auto at = [&]
    { return frameScene(scene, Eigen::Vector3d::UnitY(), 300, 200).project(far); };
    EXPECT_FALSE(at().x() > 0.0 && at().x() < 300.0 && at().y() > 0.0 && at().y() < 200.0);
    scene.marks.push_back(far);
    EXPECT_TRUE(at().x() > 0.0 && at().x() < 300.0 && at().y() > 0.0 && at().y() < 200.0);
}

// Seen along +x, the finger at +x covers the contact there; seen along +y nothing does.
TEST(GraspScene, AContactBehindAFingerIsHidden)
{
    const GraspScene scene = makeScene(makeBoxHand(), makeBall(), makeBoxGrasp(1));
    const auto hiddenFrom = [&](const Eigen::Vector3d& direction)
    {
        const Camera camera = frameScene(scene, direction, 300, 200);
        Layer layer(300, 200);
        for (const Shape& shape : scene.hand)
        {
            drawShape(layer, camera, shape);
        }
        return isHidden(layer, camera.project(scene.contacts[0].point), 0.002);
    };
    EXPECT_TRUE(hiddenFrom(Eigen::Vector3d::UnitX()));
    EXPECT_FALSE(hiddenFrom(Eigen::Vector3d::UnitY()));
}

// The disc of a ball: area and depth by closed form.
TEST(Raster, ABallCoversItsDiscAndIsNearestInTheMiddle)
{
    const Eigen::Isometry3d pose(Eigen::Translation3d(0.1, 0.2, 0.3));
    Shape ball = makeShape(makeSphere(1.0, 4), pose);
    ball.id = 7;
    Camera camera;
    camera.R_CW = lookFrom(Eigen::Vector3d(1, 2, 2) / 3.0, Eigen::Vector3d::UnitZ());
    camera.center_W = pose.translation();
    camera.pixelsPerMetre = 80.0;
    camera.width = 200;
    camera.height = 201;
    Layer layer(200, 201);
    drawShape(layer, camera, ball);
    const auto covered = std::count(layer.id.begin(), layer.id.end(), 7);
    EXPECT_NEAR(static_cast<double>(covered), std::numbers::pi * 80.0 * 80.0, 150.0);
    EXPECT_NEAR(layer.depth[layer.at(100, 100)], -1.0, 2e-3);
    EXPECT_EQ(layer.id[layer.at(1, 1)], kNone);
}
}  // namespace
}  // namespace bullet_ccd::grasp
