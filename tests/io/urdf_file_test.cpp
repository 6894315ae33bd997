#include "bullet_ccd/io/robot_file.h"
#include "tests/io/mesh_texts.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <gmock/gmock.h>
#include <ostream>
#include <stdexcept>

#if defined(__SANITIZE_ADDRESS__)
/// A robot without a root, all of whose links form a loop, never leaves urdfdom: its links own each
/// other.
extern "C" const char* __lsan_default_suppressions()
{
    return "leak:liburdfdom_model";
}
#endif

namespace bullet_ccd
{
namespace
{
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;
using tests::TempFolder;

std::string robot(const std::string& body)
{
    return "<?xml version=\"1.0\"?><robot name=\"r\">" + body + "</robot>";
}

std::string link(const std::string& name,
                 const std::string& geometry = "",
                 const std::string& origin = "")
{
    const std::string collision = geometry.empty() ? ""
                                                   : "<collision>" + origin + "<geometry>" +
                                                         geometry + "</geometry></collision>";
    return "<link name=\"" + name + "\">" + collision + "</link>";
}

std::string joint(const std::string& name,
                  const std::string& type,
                  const std::string& parent,
                  const std::string& child,
                  const std::string& rest = "")
{
    return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/>" + rest + "</joint>";
}

const std::string kLimit = "<limit lower=\"-1\" upper=\"2\" effort=\"3\" velocity=\"4\"/>";

RobotModel load(const TempFolder& folder, const std::string& body)
{
    return loadUrdf(folder.write("r.urdf", robot(body)));
}

std::string loadError(const TempFolder& folder, const std::string& body)
{
    try
    {
        static_cast<void>(load(folder, body));
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return "";
}

const Joint& jointOf(const RobotModel& model, const std::string& name)
{
    return model.tree.links[static_cast<std::size_t>(model.tree.findJoint(name))].joint;
}

TEST(UrdfFile, LinksComeParentsFirstFromTheRoot)
{
    const TempFolder folder;
    const RobotModel model =
        load(folder,
             link("leaf") + link("root") + link("middle") +
                 joint("z", "fixed", "root", "middle", "<origin xyz=\"1 2 3\"/>") +
                 joint("a", "continuous", "middle", "leaf", "<axis xyz=\"0 0 2\"/>"));
    ASSERT_EQ(model.tree.size(), 3U);
    EXPECT_EQ(model.name, "r");
    EXPECT_EQ(model.tree.links[0].name, "root");
    EXPECT_EQ(model.tree.links[0].parent, kNone);
    EXPECT_EQ(model.tree.links[1].name, "middle");
    EXPECT_EQ(model.tree.links[2].parent, 1);
    EXPECT_EQ(model.tree.links[1].X_PL0.translation(), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(model.tree.links[2].joint.type, JointType::Revolute);
    EXPECT_EQ(model.tree.links[2].joint.axis, Eigen::Vector3d::UnitZ());
    EXPECT_TRUE(std::isinf(model.tree.links[2].joint.lower));
    EXPECT_TRUE(std::isinf(model.tree.links[2].joint.upper));
}

TEST(UrdfFile, LimitsAreReadAndZeroMeansUnlimitedWithANote)
{
    const TempFolder folder;
    for (const std::string others : {"effort=\"0\" velocity=\"0\"", "effort=\"0\"", ""})
    {
        const RobotModel model = load(
            folder,
            link("a") + link("b") + link("c") + joint("j", "revolute", "a", "b", kLimit) +
                joint(
                    "k", "prismatic", "a", "c", "<limit lower=\"0\" upper=\"1\" " + others + "/>"));
        EXPECT_EQ(jointOf(model, "j").lower, -1.0);
        EXPECT_EQ(jointOf(model, "j").upper, 2.0);
        EXPECT_EQ(jointOf(model, "j").maxEffort, 3.0);
        EXPECT_EQ(jointOf(model, "j").maxVelocity, 4.0);
        EXPECT_TRUE(std::isinf(jointOf(model, "k").maxEffort));
        EXPECT_THAT(model.notes,
                    Contains(AllOf(HasSubstr("effort limit 0"), HasSubstr("missing: k"))));
        EXPECT_THAT(model.notes, Contains(HasSubstr("velocity limit 0")));
    }
}

TEST(UrdfFile, MimicChainsEndAtTheDrivingJoint)
{
    // q_c = 2 q_b + 1 and q_b = 3 q_a - 0.5, so q_c = 6 q_a.
    const TempFolder folder;
    const RobotModel model =
        load(folder,
             link("l0") + link("l1") + link("l2") + link("l3") +
                 joint("c",
                       "continuous",
                       "l0",
                       "l1",
                       "<mimic joint=\"b\" multiplier=\"2\" offset=\"1\"/>") +
                 joint("b",
                       "continuous",
                       "l1",
                       "l2",
                       "<mimic joint=\"a\" multiplier=\"3\" offset=\"-0.5\"/>") +
                 joint("a", "continuous", "l2", "l3"));
    EXPECT_EQ(jointOf(model, "c").mimicOf, model.tree.findJoint("a"));
    EXPECT_DOUBLE_EQ(jointOf(model, "c").mimicMultiplier, 6.0);
    EXPECT_DOUBLE_EQ(jointOf(model, "c").mimicOffset, 0.0);
    EXPECT_EQ(jointOf(model, "a").mimicOf, kNone);
}

TEST(UrdfFile, MimicThatLeavesItsOwnLimitsIsNoted)
{
    const TempFolder folder;
    const RobotModel model = load(
        folder,
        link("a") + link("b") + link("c") + joint("j", "revolute", "a", "b", kLimit) +
            joint("m", "revolute", "a", "c", kLimit + "<mimic joint=\"j\" multiplier=\"-1\"/>"));
    EXPECT_THAT(model.notes, Contains(AllOf(HasSubstr("leave their own limits"), HasSubstr("m"))));
}

TEST(UrdfFile, SeveralCollisionsOfALinkBecomeOneMeshAtTheirOrigins)
{
    const TempFolder folder;
    const RobotModel model =
        load(folder,
             "<link name=\"a\">"
             "<collision><origin xyz=\"1 0 0\"/><geometry><box size=\"0.2 0.4 0.6\"/></geometry>"
             "</collision>"
             "<collision><origin xyz=\"-1 0 0\" rpy=\"0 1.5707963267948966 0\"/><geometry>"
             "<cylinder radius=\"0.1\" length=\"2\"/></geometry></collision></link>");
    const Eigen::AlignedBox3d box = bounds(model.linkMeshes[0]);
    // The cylinder about z was turned to lie along x, from -2 to 0.
    EXPECT_TRUE(box.min().isApprox(Eigen::Vector3d(-2.0, -0.2, -0.3), 1e-9)) << box.min();
    EXPECT_TRUE(box.max().isApprox(Eigen::Vector3d(1.1, 0.2, 0.3), 1e-9)) << box.max();
    EXPECT_TRUE(isWatertight(model.linkMeshes[0]));
}

TEST(UrdfFile, PrimitivesStayWithinTheChordError)
{
    const TempFolder folder;
    for (const double radius : {0.003, 0.02, 0.1})
    {
        const std::string r = std::to_string(radius);
        const RobotModel model =
            load(folder,
                 link("s", "<sphere radius=\"" + r + "\"/>") +
                     link("c", "<cylinder radius=\"" + r + "\" length=\"0.1\"/>") +
                     joint("j", "fixed", "s", "c"));
        for (std::size_t k = 0; k < 2; ++k)
        {
            double nearest = radius;  // of a triangle's centroid or edge midpoint to centre or axis
            const TriangleMesh& mesh = model.linkMeshes[k];
            for (const Triangle& t : mesh.triangles)
            {
                const auto corner = [&](std::size_t i)
                { return mesh.vertices[static_cast<std::size_t>(t[i])]; };
                Eigen::Vector3d middle = (corner(0) + corner(1) + corner(2)) / 3.0;
                Eigen::Vector3d edge = 0.5 * (corner(0) + corner(1));
                const bool isCap =
                    k == 1 && corner(0).z() == corner(1).z() && corner(1).z() == corner(2).z();
                if (k == 1)
                {
                    middle.z() = edge.z() = 0.0;
                }
                if (!isCap)
                {
                    nearest = std::min({nearest, middle.norm(), edge.norm()});
                }
            }
            EXPECT_LE(radius - nearest, 1.001 * kPrimitiveChordError);
            EXPECT_LT(mesh.triangles.size(), 30000U);
        }
    }
}

TEST(UrdfFile, NegativeMeshScaleMirrorsAndKeepsTheOutside)
{
    const TempFolder folder;
    folder.write("meshes/t.obj", tests::tetraObj());
    const RobotModel model =
        load(folder, link("a", "<mesh filename=\"meshes/t.obj\" scale=\"2 -0.5 0.25\"/>"));
    const MassProperties properties = massProperties(model.linkMeshes[0]);
    EXPECT_NEAR(properties.volume, 0.25 / 6.0, 1e-12);
    EXPECT_TRUE(properties.center.isApprox(Eigen::Vector3d(0.5, -0.125, 0.0625), 1e-12));
}

TEST(UrdfFile, MillimetreMeshesWithTheirScaleRaiseNoQuestion)
{
    const TempFolder folder;
    folder.write("t.obj",
                 "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 0 0 90\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
                 "f 2 3 4\n");
    EXPECT_THAT(load(folder, link("a", "<mesh filename=\"t.obj\"/>")).notes,
                Contains(HasSubstr("millimetres")));
    EXPECT_THAT(
        load(folder, link("a", "<mesh filename=\"t.obj\" scale=\"0.001 0.001 0.001\"/>")).notes,
        testing::Not(Contains(HasSubstr("millimetres"))));
}

TEST(UrdfFile, PackagesAreFoundAboveTheUrdfAndInThePackagePath)
{
    const TempFolder folder;
    folder.write("hand/meshes/t.obj", tests::tetraObj());
    const std::string text = robot(link("a", "<mesh filename=\"package://hand/meshes/t.obj\"/>"));
    const auto inside = folder.write("hand/urdf/deep/r.urdf", text);
    EXPECT_EQ(loadUrdf(inside).linkMeshes[0].triangles.size(), 4U);

    const TempFolder elsewhere;
    const auto outside = elsewhere.write("r.urdf", text);
    EXPECT_THROW(static_cast<void>(loadUrdf(outside)), std::runtime_error);
    for (const std::filesystem::path& entry : {folder.path(), folder.path() / "hand"})
    {
        ::setenv("ROS_PACKAGE_PATH", ("/nowhere:" + entry.string()).c_str(), 1);
        EXPECT_EQ(loadUrdf(outside).linkMeshes[0].triangles.size(), 4U);
    }
    ::unsetenv("ROS_PACKAGE_PATH");
}

TEST(UrdfFile, FileUrisAndAbsolutePathsAreRead)
{
    const TempFolder folder;
    const std::string path = folder.write("t.obj", tests::tetraObj()).string();
    for (const std::string& name : {path, "file://" + path})
    {
        EXPECT_FALSE(load(folder, link("a", "<mesh filename=\"" + name + "\"/>"))
                         .linkMeshes[0]
                         .triangles.empty());
    }
}

TEST(UrdfFile, InertialsAreTurnedIntoTheLinkFrame)
{
    const TempFolder folder;
    const RobotModel model =
        load(folder,
             "<link name=\"a\"><inertial><origin xyz=\"1 2 3\" rpy=\"0 0 1.5707963267948966\"/>"
             "<mass value=\"2\"/><inertia ixx=\"1\" iyy=\"2\" izz=\"2.5\" ixy=\"0\" ixz=\"0\" "
             "iyz=\"0\"/></inertial></link>");
    EXPECT_EQ(model.tree.links[0].mass, 2.0);
    EXPECT_EQ(model.tree.links[0].centerOfMass, Eigen::Vector3d(1, 2, 3));
    EXPECT_TRUE(model.tree.links[0].inertia.isApprox(
        Eigen::Vector3d(2, 1, 2.5).asDiagonal().toDenseMatrix(), 1e-9));
    EXPECT_TRUE(model.notes.empty());
}

TEST(UrdfFile, InertialsThatNoBodyHasAreComputedFromTheMesh)
{
    // A box of 0.1 x 0.2 x 0.3 m at 1000 kg/m^3 weighs 6 kg; Ixx = m (b^2 + c^2) / 12.
    const TempFolder folder;
    const std::string box =
        "<collision><geometry><box size=\"0.1 0.2 0.3\"/></geometry></collision>";
    const auto inertial = [](const std::string& mass, const std::string& ixx)
    {
        return "<inertial><mass value=\"" + mass + "\"/><inertia ixx=\"" + ixx +
               "\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
    };
    for (const std::string& given : {std::string(),
                                     inertial("0", "1"),
                                     inertial("-1", "1"),
                                     inertial("1", "-1"),
                                     inertial("1", "2.5")})
    {
        const RobotModel model = load(folder, "<link name=\"heavy\">" + given + box + "</link>");
        EXPECT_NEAR(model.tree.links[0].mass, 6.0, 1e-9) << given;
        EXPECT_NEAR(model.tree.links[0].inertia(0, 0), 6.0 * 0.13 / 12.0, 1e-9) << given;
        EXPECT_THAT(model.notes, Contains(AllOf(HasSubstr("1000 kg/m^3"), HasSubstr("heavy"))));
    }
}

TEST(UrdfFile, FramesWithoutAnythingWeighAGram)
{
    const TempFolder folder;
    const RobotModel model = load(folder, link("frame"));
    EXPECT_DOUBLE_EQ(model.tree.links[0].mass, 1e-3);
    EXPECT_THAT(model.notes, Contains(AllOf(HasSubstr("1 g"), HasSubstr("frame"))));
}

/// Body of a URDF and what the message must say.
struct BrokenUrdf
{
    std::string body;
    std::vector<std::string> message;
};

void PrintTo(const BrokenUrdf& broken, std::ostream* stream)
{
    *stream << broken.body;
}

class BrokenUrdfFile : public testing::TestWithParam<BrokenUrdf>
{
};

TEST_P(BrokenUrdfFile, SaysWhichElementAndWhat)
{
    const TempFolder folder;
    folder.write("broken.obj", "v 0 0 0\nv 1 0 x\n");
    const std::string message = loadError(folder, GetParam().body);
    EXPECT_THAT(message, StartsWith((folder.path() / "r.urdf").string() + ": "));
    for (const std::string& part : GetParam().message)
    {
        EXPECT_THAT(message, HasSubstr(part));
    }
}

std::string two(const std::string& type, const std::string& rest)
{
    return link("a") + link("b") + joint("j", type, "a", "b", rest);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    BrokenUrdfFile,
    testing::Values(
        BrokenUrdf{"<link", {"Error"}},
        BrokenUrdf{"", {"No link elements"}},
        BrokenUrdf{link("a") + link("a"), {"'a'", "unique"}},
        BrokenUrdf{link("a") + link("b"), {"root"}},
        BrokenUrdf{link("a") + link("b") + joint("j", "fixed", "a", "nobody"), {"nobody"}},
        BrokenUrdf{
            link("a") + link("b") + joint("j", "fixed", "a", "b") + joint("k", "fixed", "b", "a"),
            {"root"}},
        BrokenUrdf{link("r") + link("a") + link("b") + joint("j", "fixed", "a", "b") +
                       joint("k", "fixed", "b", "a"),
                   {"a, b", "loop"}},
        BrokenUrdf{link("a") + link("b") + link("c") + joint("j", "fixed", "a", "b") +
                       joint("k", "fixed", "a", "c") + joint("l", "fixed", "c", "b"),
                   {"link 'b'", "two joints"}},
        BrokenUrdf{two("floating", ""), {"joint 'j'", "floating"}},
        BrokenUrdf{two("planar", "<axis xyz=\"0 0 1\"/>"), {"joint 'j'", "planar"}},
        BrokenUrdf{two("wobbly", ""), {"wobbly"}},
        BrokenUrdf{two("revolute", ""), {"limits"}},
        BrokenUrdf{two("revolute", "<limit lower=\"2\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"),
                   {"joint 'j'", "2.0", "above"}},
        BrokenUrdf{
            two("revolute", "<limit lower=\"nan\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"),
            {"j"}},
        BrokenUrdf{two("revolute", "<limit lower=\"0\" upper=\"1\" effort=\"-1\" velocity=\"1\"/>"),
                   {"joint 'j'", "effort", "negative"}},
        BrokenUrdf{two("revolute", "<axis xyz=\"0 0 0\"/>" + kLimit), {"joint 'j'", "axis"}},
        BrokenUrdf{two("fixed", "<origin xyz=\"0 0\"/>"), {"j"}},
        BrokenUrdf{two("continuous", "<mimic joint=\"finger_9\"/>"),
                   {"joint 'j'", "mimic", "'finger_9' does not exist"}},
        BrokenUrdf{two("continuous", "<mimic joint=\"j\"/>"), {"joint 'j'", "follows itself"}},
        BrokenUrdf{link("a") + link("b") + link("c") +
                       joint("j", "continuous", "a", "b", "<mimic joint=\"k\"/>") +
                       joint("k", "continuous", "a", "c", "<mimic joint=\"j\"/>"),
                   {"mimic follows itself"}},
        BrokenUrdf{link("a") + link("b") + link("c") + joint("k", "fixed", "a", "c") +
                       joint("j", "continuous", "a", "b", "<mimic joint=\"k\"/>"),
                   {"joint 'j'", "'k' is fixed"}},
        BrokenUrdf{link("a", "<mesh filename=\"no.obj\"/>"), {"link 'a'", "no.obj", "missing"}},
        BrokenUrdf{link("a", "<mesh filename=\"package://lost/no.obj\"/>"),
                   {"link 'a'", "package://lost/no.obj", "/lost", "ROS_PACKAGE_PATH"}},
        BrokenUrdf{link("a", "<mesh filename=\"broken.obj\"/>"),
                   {"link 'a'", "broken.obj: line 2"}},
        BrokenUrdf{link("a", "<mesh filename=\"broken.obj\" scale=\"1 0 1\"/>"), {"scale y is 0"}},
        BrokenUrdf{link("a", "<sphere radius=\"0\"/>"), {"link 'a'", "sphere: radius"}},
        BrokenUrdf{link("a", "<box size=\"1 -1 1\"/>"), {"link 'a'", "box: size y"}},
        BrokenUrdf{link("a", "<cylinder radius=\"1\" length=\"0\"/>"), {"cylinder: length"}},
        BrokenUrdf{link("a", "<capsule radius=\"1\"/>"), {"capsule"}}));

TEST(UrdfFile, FilesWithoutAnElementAreRefused)
{
    const TempFolder folder;
    for (const char* text :
         {"<!-- robot -->", "<?xml version=\"1.0\"?>", "<!DOCTYPE robot>\n<!-- -->"})
    {
        folder.write("none.urdf", text);
        EXPECT_THROW(static_cast<void>(loadUrdf(folder.path() / "none.urdf")), std::runtime_error)
            << text;
    }
}

TEST(UrdfFile, MissingFileIsNamed)
{
    EXPECT_THROW(static_cast<void>(loadUrdf("/nowhere/r.urdf")), std::runtime_error);
}

TEST(UrdfFile, EveryArmLoads)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(arms, "arms");
    const RobotModel dual = loadUrdf(arms / "combined/dual_iiwa7_sah.urdf");
    EXPECT_EQ(dual.tree.size(), 55U);
    std::size_t triangles = 0;
    for (const TriangleMesh& mesh : dual.linkMeshes)
    {
        triangles += mesh.triangles.size();
    }
    EXPECT_EQ(triangles, 60528U);
    EXPECT_EQ(loadUrdf(arms / "panda/panda_arm_hand.urdf").tree.size(), 13U);
    EXPECT_EQ(loadUrdf(arms / "xarm7/xarm7.urdf").tree.size(), 9U);
}
/// Everything that a file says of a robot.
void expectSame(const RobotModel& a, const RobotModel& b)
{
    EXPECT_EQ(a.name, b.name);
    ASSERT_EQ(a.tree.size(), b.tree.size());
    for (const Link& link : a.tree.links)
    {
        SCOPED_TRACE(link.name);
        const auto i = static_cast<std::size_t>(a.tree.findLink(link.name));
        const std::int32_t found = b.tree.findLink(link.name);
        ASSERT_NE(found, kNone);
        const auto k = static_cast<std::size_t>(found);
        const Link& other = b.tree.links[k];
        const auto parentOf = [](const RobotModel& robot, const Link& each)
        {
            return each.parent == kNone
                       ? std::string()
                       : robot.tree.links[static_cast<std::size_t>(each.parent)].name;
        };
        EXPECT_EQ(parentOf(a, link), parentOf(b, other));
        EXPECT_TRUE(link.X_PL0.isApprox(other.X_PL0, 1e-12));
        EXPECT_NEAR(link.mass, other.mass, 1e-12);
        EXPECT_TRUE((link.centerOfMass - other.centerOfMass).isZero(1e-12));
        EXPECT_TRUE((link.inertia - other.inertia).isZero(1e-12));
        const Joint& x = link.joint;
        const Joint& y = other.joint;
        EXPECT_EQ(x.name, y.name);
        EXPECT_EQ(x.type, y.type);
        if (x.isMovable())
        {
            EXPECT_TRUE(x.axis.isApprox(y.axis, 1e-12));
            EXPECT_EQ(x.lower, y.lower);
            EXPECT_EQ(x.upper, y.upper);
            EXPECT_EQ(x.maxEffort, y.maxEffort);
            EXPECT_EQ(x.maxVelocity, y.maxVelocity);
        }
        ASSERT_EQ(x.mimicOf == kNone, y.mimicOf == kNone);
        if (x.mimicOf != kNone)
        {
            EXPECT_EQ(a.tree.links[static_cast<std::size_t>(x.mimicOf)].joint.name,
                      b.tree.links[static_cast<std::size_t>(y.mimicOf)].joint.name);
            EXPECT_EQ(x.mimicMultiplier, y.mimicMultiplier);
            EXPECT_EQ(x.mimicOffset, y.mimicOffset);
        }
        const TriangleMesh& mesh = a.linkMeshes[i];
        EXPECT_EQ(mesh.triangles.size(), b.linkMeshes[k].triangles.size());
        if (!mesh.triangles.empty() && !b.linkMeshes[k].triangles.empty())
        {
            const Eigen::AlignedBox3d box = bounds(mesh);
            const Eigen::AlignedBox3d otherBox = bounds(b.linkMeshes[k]);
            EXPECT_TRUE((box.min() - otherBox.min()).isZero(1e-7));
            EXPECT_TRUE((box.max() - otherBox.max()).isZero(1e-7));
        }
    }
}

TEST(WrittenUrdf, ReadsAsTheSameRobot)
{
    const TempFolder folder;
    const std::string origins[] = {"0.3 -0.2 0.9", "0 1.5707963267948966 0.4", "3 -1.2 -2.5"};
    std::string body = link("base", "<box size=\"0.1 0.2 0.3\"/>", "<origin xyz=\"0 0 0.1\"/>") +
                       link("a", "<sphere radius=\"0.05\"/>") + link("b") + link("c &amp; d") +
                       link("e");
    body += joint("j1",
                  "revolute",
                  "base",
                  "a",
                  "<origin xyz=\"0.1 0.2 0.3\" rpy=\"" + origins[0] +
                      "\"/><axis xyz=\"0.6 0 0.8\"/>" + kLimit);
    body += joint("j2", "continuous", "a", "b", "<origin rpy=\"" + origins[1] + "\"/>");
    body += joint("j3",
                  "prismatic",
                  "b",
                  "c &amp; d",
                  "<origin rpy=\"" + origins[2] + "\"/>" + kLimit +
                      "<mimic joint=\"j1\" multiplier=\"-0.7\" offset=\"0.1\"/>");
    body += joint("j4", "fixed", "b", "e");
    const RobotModel first = load(folder, body);
    writeUrdf(first, folder.path() / "again.urdf");
    expectSame(first, loadUrdf(folder.path() / "again.urdf"));
}

TEST(WrittenUrdf, OfRobotsThatAreSold)
{
    BULLET_CCD_TEST_DATA_OR_SKIP(panda, "arms/panda/panda_arm_hand.urdf");
    const TempFolder folder;
    const RobotModel first = loadUrdf(panda);
    writeUrdf(first, folder.path() / "again.urdf");
    expectSame(first, loadUrdf(folder.path() / "again.urdf"));
}

TEST(WrittenUrdf, SaysWhyItIsNotWritten)
{
    const TempFolder folder;
    RobotModel first = load(folder, link("a") + link("b") + joint("j", "fixed", "a", "b"));
    EXPECT_THROW(writeUrdf(first, folder.path() / "none" / "again.urdf"), std::runtime_error);
    first.tree.links[1].joint.type = JointType::Spherical;
    EXPECT_THROW(writeUrdf(first, folder.path() / "again.urdf"), std::runtime_error);
}
}  // namespace
}  // namespace bullet_ccd
