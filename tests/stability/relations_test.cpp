/// The relations are what they say, and are there for almost every case; more obstacles never delay
/// a contact.
#include "benchmarks/reference/catalogue/relations.h"

#include "benchmarks/reference/oracles/brute_force_toi.h"
#include "benchmarks/reference/scenes/random.h"
#include "benchmarks/reference/scenes/random_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"

#include <gtest/gtest.h>

#include <map>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
double distanceAt(const RigidScene& scene, double t)
{
    return oracleDistanceAt(
        oracleBody(scene.meshA, scene.motionA), oracleBody(scene.meshB, scene.motionB), t);
}

/// Of the angle at which a body is at some time.
double roundingOfTurns(const RigidScene& scene)
{
    return 1.2e-16 * (scene.motionA.w_W.norm() * radiusOf(scene.meshA) +
                      scene.motionB.w_W.norm() * radiusOf(scene.meshB));
}

/// Distances of a variant are those of the case, at the same time of the whole motion.
TEST(Relations, KeepTheDistance)
{
    int compared = 0;
    for (const RigidCase& tested : rigidCases())
    {
        if (tested.scene.meshA.triangles.size() * tested.scene.meshB.triangles.size() > 1000)
        {
            continue;
        }
        for (const Relation relation : kRelations)
        {
            for (const Variant<RigidCase>& variant : variantsOf(tested, relation))
            {
                for (const Leg<RigidCase>& leg : variant.legs)
                {
                    const double end = relation == Relation::Reversed ? 0.0 : leg.end;
                    const double begin = relation == Relation::Reversed ? 1.0 : leg.begin;
                    if (relation == Relation::Reversed && tested.answer.time)
                    {
                        continue;  // from a time that the variant does not tell
                    }
                    const double expected =
                        distanceAt(tested.scene, begin + 0.3 * (end - begin)) * variant.unit;
                    const double rounding =
                        4.0 * (roundingOf(leg.tested.scene) + roundingOfTurns(leg.tested.scene) +
                               variant.unit * roundingOf(tested.scene));
                    EXPECT_NEAR(distanceAt(leg.tested.scene, 0.3), expected, rounding)
                        << tested.id << ", " << nameOf(relation) << ", " << variant.name;
                    ++compared;
                }
            }
        }
    }
    EXPECT_GT(compared, 1000);
}

TEST(Relations, AreDefinedForAlmostEveryCase)
{
    const std::size_t rigid = rigidCases().size();
    std::map<Relation, std::size_t> count;
    for (const Relation relation : kRelations)
    {
        for (const RigidCase& tested : rigidCases())
        {
            count[relation] += variantsOf(tested, relation).empty() ? 0 : 1;
        }
        EXPECT_GE(count[relation] + 12, rigid) << nameOf(relation);
    }
    EXPECT_EQ(count[Relation::Swapped], rigid);
}

TEST(Relations, SubdivisionKeepsTheSurface)
{
    const TriangleMesh mesh = octahedron();
    const TriangleMesh fine = subdivided(mesh);
    EXPECT_EQ(fine.triangles.size(), 4 * mesh.triangles.size());
    double area = 0.0;
    for (const Triangle& t : fine.triangles)
    {
        const auto at = [&](std::size_t k)
        { return fine.vertices[static_cast<std::size_t>(t[k])]; };
        const Eigen::Vector3d n = (at(1) - at(0)).cross(at(2) - at(0));
        area += 0.5 * n.norm();
        EXPECT_GT(n.dot(at(0) + at(1) + at(2)), 0.0) << "turned over";
    }
    EXPECT_NEAR(area, 4.0 * std::sqrt(3.0), 1e-12);
}

/// K10 on every case: a second obstacle, at a random place.
TEST(Supersets, NeverDelayAContact)
{
    Random random(31);
    int earlier = 0;
    for (const RigidCase& tested : rigidCases())
    {
        const double tolerance = tested.answer.finest();
        const ToiResult alone = queryToi(tested.scene, tolerance);
        RigidScene more = tested.scene;
        const double size = radiusOf(more.meshB) + radiusOf(more.meshA);
        more.meshB = merged({more.meshB, soup(random, 5, 0.7 * size, 0.1 * size)});
        const ToiResult both = queryToi(more, tolerance);
        const double lead = tested.answer.time ? 1.1 * leadTime(tested.answer, tolerance) : 0.0;
        EXPECT_LE(both.time, alone.time + lead + 1e-12) << tested.id;
        EXPECT_TRUE(!isContact(alone.status) || isContact(both.status)) << tested.id;
        earlier += both.time < alone.time - lead - 1e-6 ? 1 : 0;
    }
    EXPECT_GT(earlier, 5);
}
}  // namespace
}  // namespace bullet_ccd::tests
