/// Objects by name: closed forms, what is tested, and a trajectory that is pushed out of contact.
#include "bullet_ccd/trajectory/contact_manager.h"

#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
using Eigen::Vector3d;

std::shared_ptr<const SsvTree> cubeTree(double half)
{
    return std::make_shared<const SsvTree>(buildSsvTree(cube(half)));
}

/// A cube of edge 1 that flies past one at the origin, 0.3 beside it.
ContactManager flyingCube()
{
    ContactManager manager;
    manager.addObject("post", cubeTree(0.5));
    manager.addObject("flier", cubeTree(0.5));
    manager.setPoses("flier", poseOf({-3, 1.3, 0.1}), poseOf({3, 1.3, 0.1}));
    manager.setActiveObjects({"flier"});
    manager.setMargin(0.5);
    return manager;
}

TEST(ContactManager, ReportsDistancesUpToTheMargin)
{
    ContactManager manager = flyingCube();
    const std::vector<ManagedContact> contacts = manager.contacts(1e-7);
    ASSERT_EQ(contacts.size(), 1U);
    const ManagedContact& contact = contacts[0];
    EXPECT_EQ(contact.nameA, "flier");
    EXPECT_EQ(contact.nameB, "post");
    EXPECT_NEAR(contact.distance, 0.3, 1.1e-7);
    EXPECT_LE(contact.distance, 0.3 + 1e-14);
    EXPECT_NEAR(contact.normal.y(), -1.0, 1e-9);
    EXPECT_NEAR(contact.X_WA.translation().x(), -3.0 + 6.0 * contact.time, 1e-12);
    EXPECT_NEAR((contact.pointB - contact.pointA).norm(), 0.3, 1e-7);
    manager.setMargin(0.29);
    EXPECT_TRUE(manager.contacts(1e-7).empty());
    manager.setMargin("post", "flier", 0.31);
    EXPECT_EQ(manager.contacts(1e-7).size(), 1U);
}

TEST(ContactManager, SurfacesThatMeetAreReportedWhereTheyDoFirst)
{
    ContactManager manager = flyingCube();
    manager.setPoses("flier", poseOf({-3, 0.2, 0.1}), poseOf({3, 0.2, 0.1}));
    const std::vector<ManagedContact> contacts = manager.contacts(1e-7);
    ASSERT_EQ(contacts.size(), 1U);
    EXPECT_EQ(contacts[0].distance, 0.0);
    EXPECT_NEAR(contacts[0].time, 1.0 / 3.0, 1e-7);
    EXPECT_NEAR(contacts[0].normal.x(), 1.0, 1e-9);
}

TEST(ContactManager, TestsWhatIsActiveAndNotAllowed)
{
    ContactManager manager = flyingCube();
    ContactManager copy = manager;
    manager.setAllowed([](const std::string& a, const std::string& b)
                       { return a == "flier" && b == "post"; });
    EXPECT_TRUE(manager.contacts().empty());
    EXPECT_EQ(copy.contacts().size(), 1U);  // a copy is on its own
    copy.setActiveObjects({});
    EXPECT_TRUE(copy.contacts().empty());
    copy.setActiveObjects({"post"});
    ASSERT_EQ(copy.contacts().size(), 1U);
    EXPECT_EQ(copy.contacts()[0].nameA, "post");
    EXPECT_TRUE(copy.removeObject("flier"));
    EXPECT_FALSE(copy.removeObject("flier"));
    EXPECT_FALSE(copy.hasObject("flier"));
    EXPECT_TRUE(copy.contacts().empty());
    EXPECT_THROW(copy.setPose("flier", poseOf({0, 0, 0})), std::invalid_argument);
    EXPECT_THROW(copy.setActiveObjects({"flier"}), std::invalid_argument);
    EXPECT_THROW(copy.setMargin(0.0), std::invalid_argument);
    EXPECT_THROW(copy.addObject("nothing", nullptr), std::invalid_argument);
}

/// No pair is left out that comes within the margin, whatever its motion.
TEST(ContactManager, OfRandomMotionsAgreesWithTheQuery)
{
    Random random(21);
    int found = 0;
    for (int i = 0; i < 200; ++i)
    {
        const RigidScene scene = randomRigidScene(random);
        const auto a = std::make_shared<const SsvTree>(buildSsvTree(scene.meshA));
        const auto b = std::make_shared<const SsvTree>(buildSsvTree(scene.meshB));
        const double margin = random.uniform(0.01, 0.3);
        ContactManager manager;
        manager.addObject("a", a);
        manager.addObject("b", b);
        manager.setMotion("a", scene.motionA);
        manager.setMotion("b", scene.motionB);
        manager.setMargin(margin);
        ToiWorkspace work;
        const LeastDistanceResult least =
            leastDistance(RigidBody{.tree = a.get(), .motion = scene.motionA},
                          RigidBody{.tree = b.get(), .motion = scene.motionB},
                          {.tolerance = 1e-5, .enough = 2.0},
                          work);
        const std::vector<ManagedContact> contacts = manager.contacts(1e-5);
        if (std::abs(least.found - margin) > 2e-5)
        {
            EXPECT_EQ(contacts.size(), least.found < margin ? 1U : 0U) << i;
        }
        for (const ManagedContact& contact : contacts)
        {
            EXPECT_NEAR(contact.distance, least.distance, 2.1e-5) << i;
        }
        found += contacts.empty() ? 0 : 1;
    }
    EXPECT_GT(found, 40);
    EXPECT_LT(found, 190);
}

/// Points of a path, with a cube that moves from each to the next: contacts push the ends of their
/// segment away, and what is straight pulls together, until the whole path keeps its margin.
TEST(ContactManager, ItsNormalsLeadATrajectoryOutOfContact)
{
    constexpr double kMargin = 0.05;
    constexpr std::size_t kPoints = 9;
    ContactManager manager;
    // Taller than the cube, so that one is never inside the other: meshes are soups.
    manager.addObject("post",
                      std::make_shared<const SsvTree>(buildSsvTree(makeBox({0.2, 0.2, 1.0}))));
    manager.addObject("flier", cubeTree(0.2));
    manager.setActiveObjects({"flier"});
    manager.setMargin(kMargin);
    std::vector<Vector3d> path;
    for (std::size_t k = 0; k < kPoints; ++k)
    {
        path.emplace_back(-2.0 + 0.5 * double(k), 0.1 * std::sin(0.4 * double(k)), 0.0);
    }
    const auto contactsOf = [&](std::size_t k)
    {
        manager.setPoses("flier", poseOf(path[k]), poseOf(path[k + 1]));
        return manager.contacts(1e-6);
    };
    int rounds = 0;
    for (bool isFree = false; !isFree && rounds < 500; ++rounds)
    {
        isFree = true;
        std::vector<Vector3d> push(kPoints, Vector3d::Zero());
        for (std::size_t k = 0; k + 1 < kPoints; ++k)
        {
            for (const ManagedContact& contact : contactsOf(k))
            {
                isFree = false;
                // Across the way: along it the other segments are in the way.
                Vector3d away = -contact.normal;
                if (contact.normal.isZero(0.0) || std::abs(away.x()) > 0.9)
                {
                    away = Vector3d::UnitY();
                }
                const Vector3d step = (kMargin - contact.distance + 1e-3) * away;
                push[k] += (1.0 - contact.time) * step;
                push[k + 1] += contact.time * step;
            }
        }
        for (std::size_t k = 1; k + 1 < kPoints; ++k)
        {
            path[k] += push[k];
        }
    }
    EXPECT_GT(rounds, 1);
    EXPECT_LT(rounds, 500);
    for (std::size_t k = 0; k + 1 < kPoints; ++k)
    {
        EXPECT_TRUE(contactsOf(k).empty()) << k;
    }
    EXPECT_EQ(path.front(), Vector3d(-2.0, 0.0, 0.0));
}
}  // namespace
}  // namespace bullet_ccd::tests
