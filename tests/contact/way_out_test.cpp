#include "bullet_ccd/contact/way_out.h"

#include "bullet_ccd/contact/contact_search.h"
#include "bullet_ccd/contact/contact_surface.h"
#include "bullet_ccd/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include <vector>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector3d;
constexpr double kShell = 0.01;

Eigen::Isometry3d turned(const Vector3d& translation)
{
    // Everything lies askew, so that nothing is exact by chance.
    Eigen::Isometry3d X_W(Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, -0.5).normalized()));
    return X_W * Eigen::Translation3d(translation);
}

Vector3d axis(const Vector3d& direction)
{
    return turned(Vector3d::Zero()).linear() * direction;
}

/// A box of half extent 0.1 in one of half extent 1, askew together.
struct Boxes
{
    SsvTree small = buildSsvTree(makeBox({0.1, 0.1, 0.1}));
    SsvTree large = buildSsvTree(makeBox({1.0, 1.0, 1.0}));

    [[nodiscard]] WayOut at(const Vector3d& place, bool areSolid) const
    {
        return {{&small, turned(place), areSolid},
                {&large, turned(Vector3d::Zero()), areSolid},
                kShell};
    }
    [[nodiscard]] std::vector<Contact> contactsAt(const Eigen::Isometry3d& X_WA, double reach) const
    {
        std::vector<Contact> contacts;
        ContactSearchWorkspace search;
        appendContacts(ContactSurface(small),
                       X_WA,
                       ContactSurface(large),
                       turned(Vector3d::Zero()),
                       reach,
                       search,
                       contacts);
        return contacts;
    }
};

void expectWay(const WayOut& out, double depth, const Vector3d& normal)
{
    ASSERT_TRUE(out.isFound());
    EXPECT_NEAR(out.normal().dot(normal), 1.0, 1e-9);
    EXPECT_GE(out.way(), depth + WayOut::kApart * kShell - 1e-9);
    EXPECT_LE(out.way(), depth + kShell + 1e-9);
}
}  // namespace

TEST(WayOut, KnowsWhatHasAnInside)
{
    TriangleMesh box = makeBox({1.0, 2.0, 3.0});
    EXPECT_TRUE(hasInside(box));
    for (Triangle& t : box.triangles)
    {
        std::swap(t[0], t[1]);
    }
    EXPECT_FALSE(hasInside(box)) << "inside out";
    box = makeBox({1.0, 2.0, 3.0});
    box.triangles.pop_back();
    EXPECT_FALSE(hasInside(box)) << "open";
}

TEST(WayOut, OfWhatIsWhollyInsideLeadsToTheNearestSurface)
{
    const Boxes boxes;
    // No way is longer than twice the radius of the small one, 0.346.
    for (const double place : {0.77, 0.8, 0.85})
    {
        WayOut out = boxes.at({place, 0.05, -0.1}, true);
        const Vector3d nearest = out.nearestOut();
        ASSERT_NEAR(nearest.dot(axis(-Vector3d::UnitX())), 1.0, 1e-9);
        out.look(nearest);
        expectWay(out, 1.1 - place, axis(-Vector3d::UnitX()));
    }
    WayOut deep = boxes.at({0.72, 0.05, -0.1}, true);
    deep.look(deep.nearestOut());
    EXPECT_FALSE(deep.isFound());
    EXPECT_TRUE(boxes.at({0.5, 0.05, -0.1}, true).nearestOut().isZero());
    EXPECT_TRUE(boxes.at({0.8, 0.0, 0.0}, false).nearestOut().isZero()) << "nothing is solid";
    EXPECT_TRUE(boxes.at({1.2, 0.0, 0.0}, true).nearestOut().isZero()) << "outside";
    EXPECT_TRUE(boxes.at({1.2, 1.2, 1.2}, true).nearestOut().isZero()) << "beside a corner";
}

TEST(WayOut, OfWhatMeetsIsTheShortest)
{
    const Boxes boxes;
    for (const double deep : {0.03, 0.08, 0.15})
    {
        // Through the face x = 1, and far from all others.
        const Vector3d place(1.1 - deep, 0.3, -0.2);
        for (const bool areSolid : {false, true})
        {
            WayOut out = boxes.at(place, areSolid);
            out.lookAlong(boxes.contactsAt(turned(place), kShell), Vector3d::Zero(), 0.0);
            // The rest of the small box is 0.05 thick at last: hollow, it goes in.
            const bool goesIn = !areSolid && deep > 0.1;
            expectWay(
                out, goesIn ? 0.2 - deep : deep, axis((goesIn ? 1.0 : -1.0) * Vector3d::UnitX()));
        }
    }
}

TEST(WayOut, OfTwoWallsIsBetweenThem)
{
    // The small box is 2 mm in each of two walls of a corner, whose other faces are far away.
    TriangleMesh corner = makeBox({1.0, 1.0, 1.0});
    transformMesh(corner, Eigen::Affine3d(Eigen::Translation3d(-2.0, 2.0, 0.0)));
    appendMesh(corner, makeBox({1.0, 1.0, 1.0}));
    const SsvTree room = buildSsvTree(corner);
    const SsvTree small = buildSsvTree(makeBox({0.1, 0.1, 0.1}));
    const Vector3d place(-1.0 + 0.098, 1.0 + 0.098, 0.0);
    std::vector<Contact> contacts;
    ContactSearchWorkspace search;
    appendContacts(ContactSurface(small),
                   turned(place),
                   ContactSurface(room),
                   turned(Vector3d::Zero()),
                   kShell,
                   search,
                   contacts);
    WayOut out({&small, turned(place), false}, {&room, turned(Vector3d::Zero()), false}, kShell);
    out.lookAlong(contacts, Vector3d::Zero(), 0.0);
    ASSERT_TRUE(out.isFound());
    EXPECT_GT(out.normal().dot(axis(Vector3d(-1.0, -1.0, 0.0).normalized())), 0.95);
    EXPECT_LT(out.way(), 2.0 * (0.002 + kShell));
}

TEST(WayOut, IsTheOneTheyCameUnlessItHasBecomeMuchLonger)
{
    const Boxes boxes;
    const Vector3d place(1.05, 1.0, 0.0);  // 0.05 deep along x, 0.1 along y
    const std::vector<Contact> contacts = boxes.contactsAt(turned(place), kShell);
    const Vector3d alongY = axis(-Vector3d::UnitY());
    WayOut known = boxes.at(place, true);
    known.lookAlong(contacts, alongY, 0.1);
    expectWay(known, 0.1, alongY);
    const Vector3d far(1.08, 0.88, 0.0);  // 0.02 and 0.22
    WayOut other = boxes.at(far, true);
    other.lookAlong(boxes.contactsAt(turned(far), kShell), alongY, 0.02);
    expectWay(other, 0.02, axis(-Vector3d::UnitX()));
}

TEST(WayOut, LeadsBackToWhereTheyMetBefore)
{
    const Boxes boxes;
    const Vector3d place(0.85, 0.2, 0.1);  // wholly inside, by 0.25
    WayOut out = boxes.at(place, true);
    out.comeBack(axis(-Vector3d::UnitX()), 0.24);
    expectWay(out, 0.25, axis(-Vector3d::UnitX()));
    WayOut away = boxes.at({1.3, 0.2, 0.1}, true);
    away.comeBack(axis(-Vector3d::UnitX()), 0.01);
    EXPECT_FALSE(away.isFound()) << "it is out already";
}

TEST(WayOut, TakesContactsBackAsDeepAsTheWay)
{
    const Boxes boxes;
    const Vector3d place(1.02, 0.3, -0.2);  // 0.08 deep
    WayOut out = boxes.at(place, true);
    out.look(axis(-Vector3d::UnitX()));
    ASSERT_TRUE(out.isFound());
    std::vector<Contact> contacts = boxes.contactsAt(out.poseOfA(), kShell + out.way());
    ASSERT_GE(contacts.size(), 4U);
    out.takeBack(contacts, 0, kShell);
    ASSERT_GE(contacts.size(), 4U);
    for (const Contact& contact : contacts)
    {
        EXPECT_GT(contact.normal.dot(out.normal()), 0.0);
        EXPECT_LE(contact.gap, kShell);
        if (contact.normal.dot(out.normal()) > 0.999)
        {
            EXPECT_NEAR(contact.gap, -0.08, 1e-9);
            EXPECT_NEAR((contact.pointA - contact.pointB).dot(out.normal()), 0.08, 1e-9);
        }
    }
}
}  // namespace bullet_ccd::tests
