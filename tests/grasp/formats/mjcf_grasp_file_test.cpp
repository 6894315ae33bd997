// Reads exported models by the project's own reader, and by MuJoCo where it is installed.
#include "grasp/formats/mjcf_grasp_file.h"

#include "bullet_ccd/io/robot_file.h"
#include "grasp/force/grasp_forces.h"
#include "tests/grasp/planner/test_hands.h"
#include "tests/support/temp_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <sstream>
#include <stdexcept>

#ifdef BULLET_CCD_HAS_MUJOCO
#include <mujoco/mujoco.h>
#endif

namespace bullet_ccd::grasp
{
namespace
{
using ::testing::HasSubstr;

/// Hand and object of convex bodies at a posture of no meaning.
struct Exported
{
    explicit Exported(HandModel of) : hand(std::move(of))
    {
        KinematicTree& tree = hand.robot.tree;
        grasp.X_WH = Eigen::Translation3d(0.1 / 3.0, -0.02, -0.2) *
                     Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0);
        grasp.positions.assign(tree.size(), 0.0);
        for (std::size_t i = 0; i < tree.size(); ++i)
        {
            Link& link = tree.links[i];
            link.mass = 0.01 * static_cast<double>(i + 1);
            link.centerOfMass = Eigen::Vector3d(0.001, 0.002, 0.01);
            link.inertia = Eigen::Vector3d(2e-5, 3e-5, 4e-5).asDiagonal();
            link.joint.maxEffort = 1.5;
            grasp.positions[i] = 0.01 + 0.003 * static_cast<double>(i);
            pieces.links.push_back({.pieces = {hand.linkTrees[i]->mesh()}, .bulge = 0.0});
        }
        applyMimics(tree, grasp.positions);
        pieces.object = {.pieces = {object.tree.mesh()}, .bulge = 2.5e-4};
        squeeze.efforts = jointEfforts(hand);
        for (const std::int32_t joint : independentJoints(tree))
        {
            squeeze.stiffness.push_back(7.5);
            squeeze.torques.push_back(0.75);
            squeeze.targets.push_back(grasp.positions[static_cast<std::size_t>(joint)] + 0.1);
        }
        writeMjcfMeshes(folder.path() / "meshes", pieces);
        std::ofstream(file()) << text();
    }

    [[nodiscard]] std::filesystem::path file() const { return folder.path() / "grasp.xml"; }
    [[nodiscard]] std::string text() const
    {
        std::ostringstream out;
        writeMjcf(out, hand, object, grasp, squeeze, pieces, options);
        return out.str();
    }

    tests::TempFolder folder;
    HandModel hand;
    GraspObject object = makeGraspObject("cube", makeBox({0.02, 0.03, 0.04}));
    Grasp grasp;
    MjcfPieces pieces;
    Squeeze squeeze;
    MjcfOptions options{.mass = 0.25, .friction = 0.6, .torsion = 0.02};
};

TEST(MjcfGraspFile, OurReaderFindsTheHand)
{
    for (const bool coupled : {false, true})
    {
        const Exported exported(tests::makeGripper(coupled));
        const KinematicTree& full = exported.hand.robot.tree;
        const RobotModel read = loadMjcf(exported.file());
        ASSERT_EQ(read.tree.size(), full.size());
        const auto poses = linkPoses(full, Eigen::Isometry3d::Identity(), exported.grasp.positions);
        std::vector<double> positions(full.size());
        for (std::size_t i = 0; i < full.size(); ++i)
        {
            const Link& link = full.links[i];
            const std::int32_t found = read.tree.findLink(link.name);
            ASSERT_NE(found, kNone);
            const Link& other = read.tree.links[static_cast<std::size_t>(found)];
            positions[static_cast<std::size_t>(found)] = exported.grasp.positions[i];
            EXPECT_EQ(other.mass, link.mass);
            EXPECT_TRUE(other.inertia.isApprox(link.inertia, 1e-12));
            EXPECT_EQ(other.joint.type, link.joint.type);
            EXPECT_EQ(other.joint.mimicOf == kNone, link.joint.mimicOf == kNone);
            if (link.joint.isMovable() && link.joint.mimicOf == kNone)
            {
                EXPECT_EQ(other.joint.lower, link.joint.lower);
                EXPECT_EQ(other.joint.upper, link.joint.upper);
                EXPECT_EQ(other.joint.maxEffort, exported.squeeze.efforts.front().limit);
            }
        }
        const auto others = linkPoses(read.tree, Eigen::Isometry3d::Identity(), positions);
        for (std::size_t i = 0; i < full.size(); ++i)
        {
            const auto found = static_cast<std::size_t>(read.tree.findLink(full.links[i].name));
            EXPECT_TRUE(others[found].isApprox(poses[i], 1e-12));
            EXPECT_EQ(read.linkMeshes[found].triangles.size(),
                      exported.pieces.links[i].pieces[0].triangles.size());
        }
    }
}

TEST(MjcfGraspFile, SaysWhatItsPiecesAre)
{
    EXPECT_THAT(Exported(tests::makeGripper(true)).text(),
                HasSubstr("1 of the object, up to 0.25 mm"));
}

TEST(MjcfGraspFile, ASheetHasInertia)
{
    Exported exported(tests::makeGripper(true));
    TriangleMesh sheet;
    sheet.vertices = {{0.0, 0.0, 0.0}, {0.04, 0.0, 0.0}, {0.04, 0.03, 0.0}, {0.0, 0.03, 0.0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    exported.object = makeGraspObject("sheet", std::move(sheet));
    exported.options.mass = 0.12;
    const std::string text = exported.text();
    const std::string attribute = "fullinertia=\"";
    std::istringstream numbers(text.substr(text.rfind(attribute) + attribute.size()));
    Eigen::Vector3d moments = Eigen::Vector3d::Zero();
    numbers >> moments.x() >> moments.y() >> moments.z();
    const Eigen::Vector3d expected(9e-6, 16e-6, 25e-6);  // m / 12 (b^2 + c^2)
    EXPECT_TRUE(moments.isApprox(expected, 1e-12)) << moments;
}

TEST(MjcfGraspFile, SaysWhatIsWrong)
{
    Exported exported(tests::makeGripper(true));
    exported.options.mass = 0.0;
    EXPECT_THROW((void)exported.text(), std::invalid_argument);
    exported.options.mass = 0.1;
    exported.options.torsion = -1.0;
    EXPECT_THROW((void)exported.text(), std::invalid_argument);
    exported.options.torsion = 0.0;
    exported.pieces.links.pop_back();
    EXPECT_THROW((void)exported.text(), std::invalid_argument);
    exported.grasp.positions.clear();
    EXPECT_THROW((void)exported.text(), std::invalid_argument);
    const std::filesystem::path file = exported.folder.path() / "file";
    std::ofstream(file) << "in the way";
    EXPECT_THROW(writeMjcfMeshes(file / "meshes", exported.pieces), std::runtime_error);
}

HandModel gripperOnALinkCalledWorld()
{
    HandModel hand = tests::makeGripper(false);
    hand.robot.tree.links.front().name = "world";
    return hand;
}

TEST(MjcfGraspFile, ALinkCalledWorldIsNotMuJoCosWorld)
{
    const Exported exported(gripperOnALinkCalledWorld());
    EXPECT_THAT(exported.text(), HasSubstr("<body name=\"world_\""));
#ifdef BULLET_CCD_HAS_MUJOCO
    char error[1000] = "";
    mjModel* const model =
        mj_loadXML(exported.file().string().c_str(), nullptr, error, sizeof error);
    EXPECT_NE(model, nullptr) << error;
    mj_deleteModel(model);
#endif
}

TEST(MjcfGraspFile, MuJoCoFindsTheSamePosture)
{
#ifndef BULLET_CCD_HAS_MUJOCO
    GTEST_SKIP() << "MuJoCo was not there for the build: install libmujoco-dev";
#else
    for (const int which : {0, 1, 2})
    {
        const Exported exported(which == 2 ? tests::makeThreeFingers()
                                           : tests::makeGripper(which == 1));
        const KinematicTree& tree = exported.hand.robot.tree;
        char error[1000] = "";
        mjModel* const model =
            mj_loadXML(exported.file().string().c_str(), nullptr, error, sizeof error);
        ASSERT_NE(model, nullptr) << error;
        mjData* const data = mj_makeData(model);
        EXPECT_EQ(model->njnt, static_cast<int>(tree.size()));  // the root has none, the object one
        EXPECT_EQ(model->neq, which == 1 ? 1 : 0);
        EXPECT_EQ(model->nu, static_cast<int>(exported.squeeze.targets.size()));
        ASSERT_EQ(model->nkey, 2);
        mj_resetDataKeyframe(model, data, mj_name2id(model, mjOBJ_KEY, "squeeze"));
        mj_forward(model, data);
        const auto poses = linkPoses(tree, exported.grasp.X_WH, exported.grasp.positions);
        for (std::size_t i = 0; i < tree.size(); ++i)
        {
            const int body = mj_name2id(model, mjOBJ_BODY, tree.links[i].name.c_str());
            ASSERT_GE(body, 0);
            EXPECT_NEAR(model->body_mass[body], tree.links[i].mass, 1e-12);
            const Eigen::Map<const Eigen::Vector3d> place(data->xpos + 3 * body);
            using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
            const Eigen::Map<const Rows> axes(data->xmat + 9 * body);
            EXPECT_LT((place - poses[i].translation()).norm(), 1e-6);
            EXPECT_LT((axes - poses[i].linear()).norm(), 1e-6);
        }
        // The controllers press with the squeeze's torques.
        for (int j = 0; j < model->nu; ++j)
        {
            EXPECT_NEAR(data->actuator_force[j], 7.5 * 0.1, 1e-9);
            EXPECT_EQ(model->actuator_forcerange[2 * j + 1],
                      exported.squeeze.efforts[static_cast<std::size_t>(j)].limit);
        }
        const int object = mj_name2id(model, mjOBJ_BODY, "object");
        EXPECT_NEAR(model->body_mass[object], 0.25, 1e-12);
        // Of a solid box: m / 12 (y^2 + z^2) about x.
        EXPECT_NEAR(*std::max_element(model->body_inertia + 3 * object,
                                      model->body_inertia + 3 * object + 3),
                    0.25 / 12.0 * (0.06 * 0.06 + 0.08 * 0.08),
                    1e-9);
        mj_deleteData(data);
        mj_deleteModel(model);
    }
#endif
}
}  // namespace
}  // namespace bullet_ccd::grasp
