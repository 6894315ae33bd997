/// MJCF as this library reads it against MuJoCo's own reading.
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/io/robot_file.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "tests/io/mjcf_texts.h"
#include "tests/io/mjcf_writer.h"
#include "tests/support/temp_folder.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mujoco/mujoco.h>
#include <random>
#include <stdexcept>

namespace bullet_ccd
{
namespace
{
constexpr int kPostures = 1000;

struct MuJoCo
{
    explicit MuJoCo(const std::filesystem::path& path)
    {
        std::array<char, 1000> error{};
        model = mj_loadXML(path.c_str(), nullptr, error.data(), static_cast<int>(error.size()));
        if (model == nullptr)
        {
            throw std::runtime_error(error.data());
        }
        data = mj_makeData(model);
    }
    ~MuJoCo()
    {
        mj_deleteData(data);
        mj_deleteModel(model);
    }
    MuJoCo(const MuJoCo&) = delete;
    MuJoCo& operator=(const MuJoCo&) = delete;

    [[nodiscard]] int find(mjtObj type, const std::string& name) const
    {
        return mj_name2id(model, type, name.c_str());
    }
    [[nodiscard]] Eigen::Isometry3d pose(const mjtNum* position, const mjtNum* rotation) const
    {
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.translation() = Eigen::Vector3d(position[0], position[1], position[2]);
        X.linear() = Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>>(rotation);
        return X;
    }

    mjModel* model = nullptr;
    mjData* data = nullptr;
};

/// Positions within the limits, drivers and followers alike as the couplings say.
std::vector<double> randomPosture(const KinematicTree& tree, std::mt19937& random)
{
    std::vector<double> q(tree.size(), 0.0);
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const Joint& joint = tree.links[i].joint;
        const double low = std::isfinite(joint.lower) ? joint.lower : -3.0;
        const double high = std::isfinite(joint.upper) ? joint.upper : 3.0;
        q[i] = std::uniform_real_distribution(low, high)(random);
    }
    applyMimics(tree, q);
    return q;
}

/// Link poses at random postures, limits, masses, and couplings by the residuals of MuJoCo's own
/// equality constraints.
void expectSame(const std::filesystem::path& path, double massTolerance)
{
    const RobotModel robot = loadRobot(path);
    const MuJoCo mujoco(path);
    const mjModel& model = *mujoco.model;
    const auto at = [](int index) { return static_cast<std::size_t>(index); };
    std::mt19937 random(5);
    double largest = 0.0;
    for (int posture = 0; posture < kPostures; ++posture)
    {
        const std::vector<double> q = randomPosture(robot.tree, random);
        for (std::size_t i = 1; i < robot.tree.size(); ++i)
        {
            if (robot.tree.links[i].joint.isMovable())
            {
                const int joint = mujoco.find(mjOBJ_JOINT, robot.tree.links[i].joint.name);
                ASSERT_GE(joint, 0) << robot.tree.links[i].joint.name;
                mujoco.data->qpos[model.jnt_qposadr[joint]] = q[i];
            }
        }
        mj_forward(mujoco.model, mujoco.data);
        const int root = mujoco.find(mjOBJ_BODY, robot.tree.links[0].name);
        const auto X_WL = linkPoses(
            robot.tree, mujoco.pose(mujoco.data->xpos + 3 * root, mujoco.data->xmat + 9 * root), q);
        for (std::size_t i = 0; i < robot.tree.size(); ++i)
        {
            const int body = mujoco.find(mjOBJ_BODY, robot.tree.links[i].name);
            if (body < 0)
            {
                continue;  // of a body with several joints
            }
            const Eigen::Isometry3d X =
                mujoco.pose(mujoco.data->xpos + 3 * body, mujoco.data->xmat + 9 * body);
            largest = std::max(largest, (X.linear() - X_WL[i].linear()).norm());
            // The frame is at the anchor of the last joint, if that turns.
            const int last = model.body_jntadr[body] + model.body_jntnum[body] - 1;
            const bool turns =
                model.body_jntnum[body] > 0 && model.jnt_type[last] == mjJNT_HINGE && i > 0;
            const mjtNum* const anchor =
                turns ? mujoco.data->xanchor + 3 * last : mujoco.data->xpos + 3 * body;
            largest = std::max(
                largest,
                (Eigen::Vector3d(anchor[0], anchor[1], anchor[2]) - X_WL[i].translation()).norm());
            const Eigen::Vector3d com = X_WL[i] * robot.tree.links[i].centerOfMass;
            const mjtNum* const xipos = mujoco.data->xipos + 3 * body;
            EXPECT_NEAR((com - Eigen::Vector3d(xipos[0], xipos[1], xipos[2])).norm(), 0.0, 1e-4);
        }
        for (int row = 0; row < mujoco.data->nefc; ++row)
        {
            if (mujoco.data->efc_type[row] == mjCNSTR_EQUALITY)
            {
                largest = std::max(largest, std::abs(mujoco.data->efc_pos[row]));
            }
        }
    }
    EXPECT_LT(largest, 1e-9);
    for (std::size_t i = 0; i < robot.tree.size(); ++i)
    {
        const Link& link = robot.tree.links[i];
        SCOPED_TRACE(link.name);
        const int joint = i == 0 ? -1 : mujoco.find(mjOBJ_JOINT, link.joint.name);
        EXPECT_EQ(joint >= 0, link.joint.isMovable());
        if (joint >= 0)
        {
            EXPECT_EQ(model.jnt_limited[joint] != 0, std::isfinite(link.joint.lower));
            if (model.jnt_limited[joint] != 0)
            {
                EXPECT_NEAR(model.jnt_range[2 * joint], link.joint.lower, 1e-12);
                EXPECT_NEAR(model.jnt_range[2 * joint + 1], link.joint.upper, 1e-12);
            }
        }
        const int body = mujoco.find(mjOBJ_BODY, link.name);
        if (body >= 0)
        {
            EXPECT_NEAR(link.mass / model.body_mass[at(body)], 1.0, massTolerance);
            const Eigen::Vector3d moments =
                Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(link.inertia).eigenvalues();
            Eigen::Vector3d theirs(model.body_inertia[3 * body],
                                   model.body_inertia[3 * body + 1],
                                   model.body_inertia[3 * body + 2]);
            std::sort(theirs.data(), theirs.data() + 3);
            EXPECT_NEAR((moments - theirs).norm() / theirs.norm(), 0.0, massTolerance);
        }
    }
}

TEST(MjcfMuJoCo, AHandWithAllKindsOfElements)
{
    const tests::TempFolder folder;
    // Chords of primitives are inscribed.
    expectSame(folder.write("hand.xml", tests::kMjcfHand), 0.03);
}

TEST(MjcfMuJoCo, MeshesWithScaleAndReference)
{
    const tests::TempFolder folder;
    TriangleMesh mesh = makeBox({0.1, 0.2, 0.3});
    transformMesh(mesh, Eigen::Affine3d(Eigen::Translation3d(0.5, 0.0, 0.1)));
    writeObj(mesh, folder.path() / "box.obj");
    for (const std::string asset :
         {"scale=\"0.1 0.2 0.3\" refpos=\"0.1 0.2 0.3\"",
          "scale=\"0.2 0.2 0.2\" refpos=\"0.1 0 0\" refquat=\"1 1 0.5 0\"",
          "scale=\"0.1 -0.2 0.3\""})
    {
        SCOPED_TRACE(asset);
        expectSame(
            folder.write("m.xml",
                         tests::mjcf("<body name=\"p\"><geom type=\"mesh\" mesh=\"box\" "
                                     "pos=\"0.1 0 0\" euler=\"10 20 30\"/></body>",
                                     "<asset><mesh file=\"box.obj\" " + asset + "/></asset>")),
            1e-6);
    }
}

TEST(MjcfMuJoCo, ShippedHandsWrittenAsMjcf)
{
    for (const std::string name :
         {"parallel_gripper", "three_finger_gripper", "anthropomorphic_hand"})
    {
        SCOPED_TRACE(name);
        const tests::TempFolder folder;
        const RobotModel robot =
            loadRobot(std::filesystem::path(BULLET_CCD_SHARE) / "robots" / name / (name + ".urdf"));
        expectSame(tests::writeMjcf(robot, folder.path()), 1e-9);
    }
}
}  // namespace
}  // namespace bullet_ccd
