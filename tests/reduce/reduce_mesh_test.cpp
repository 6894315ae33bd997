#include "bullet_ccd/reduce/reduce_mesh.h"

#include "bullet_ccd/distance/tree_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>
#include <random>

namespace bullet_ccd
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

Isometry3d somePose()
{
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    pose.translation() = Vector3d(0.3, -0.2, 0.5);
    return pose;
}

TriangleMesh placed(TriangleMesh mesh)
{
    transformMesh(mesh, Eigen::Affine3d(somePose()));
    return mesh;
}

/// A cup: a wall, a floor, open above.
TriangleMesh cup()
{
    return makeRevolved(
        {{0.0, 0.0}, {0.04, 0.0}, {0.04, 0.1}, {0.036, 0.1}, {0.036, 0.004}, {0.0, 0.004}}, 200);
}

/// What the model promises, measured again.
void expectKept(const TriangleMesh& full, const ReducedModel& model, double accuracy)
{
    EXPECT_LE(model.deviation(), accuracy);
    EXPECT_LE(surfaceDeviation(full, buildSsvTree(model.mesh), 0.0).lower, accuracy * 1.05);
    EXPECT_LE(surfaceDeviation(model.mesh, buildSsvTree(full), 0.0).lower, accuracy);
}

TEST(ReduceMesh, KnowsSimpleShapesWhereverTheyAre)
{
    const double accuracy = 1e-3;
    const auto sphere = reduceMesh(placed(makeSphere(0.1, 4)), {.accuracy = accuracy});
    ASSERT_TRUE(sphere);
    EXPECT_EQ(sphere->kind, ModelKind::Sphere);
    EXPECT_NEAR(sphere->radius, 0.1, accuracy);
    EXPECT_LT((sphere->pose.translation() - somePose().translation()).norm(), accuracy);

    const auto capsule = reduceMesh(placed(makeCapsule(0.03, 0.2, 48)), {.accuracy = accuracy});
    ASSERT_TRUE(capsule);
    EXPECT_EQ(capsule->kind, ModelKind::Capsule);
    EXPECT_NEAR(capsule->radius, 0.03, accuracy);
    EXPECT_NEAR(capsule->height, 0.2, accuracy);

    const TriangleMesh plank = placed(makeBox({0.1, 0.05, 0.02}));
    const auto box = reduceMesh(plank, {.accuracy = accuracy});
    ASSERT_TRUE(box);
    EXPECT_EQ(box->kind, ModelKind::Box);
    Vector3d half = box->halfExtents;
    std::sort(half.data(), half.data() + 3);
    EXPECT_LT((half - Vector3d(0.02, 0.05, 0.1)).norm(), accuracy);
    expectKept(plank, *box, accuracy);
}

TEST(ReduceMesh, TakesAHullOnlyWhereTheBodyIsConvex)
{
    const TriangleMesh cone = makeRevolved({{0.0, 0.0}, {0.05, 0.0}, {0.0, 0.2}}, 300);
    const auto hull = reduceMesh(cone, {.accuracy = 1e-5, .kind = ModelKind::Hull});
    ASSERT_TRUE(hull);
    EXPECT_TRUE(isWatertight(hull->mesh));
    EXPECT_NEAR(massProperties(hull->mesh).volume, massProperties(cone).volume, 1e-9);
    EXPECT_FALSE(reduceMesh(cup(), {.accuracy = 1e-2, .kind = ModelKind::Hull}));
}

TEST(ReduceMesh, KeepsTheInsideOfACup)
{
    const TriangleMesh full = cup();
    std::size_t before = full.triangles.size();
    for (const double accuracy : {1e-5, 1e-4, 1e-3})
    {
        const auto model = reduceMesh(full, {.accuracy = accuracy});
        ASSERT_TRUE(model);
        EXPECT_EQ(model->kind, ModelKind::Mesh);
        EXPECT_LE(model->mesh.triangles.size(), before);
        before = model->mesh.triangles.size();
        expectKept(full, *model, accuracy);
    }
    EXPECT_LT(before, full.triangles.size() / 4);
    // An accuracy of more than the cup is deep allows a solid.
    const auto solid = reduceMesh(full, {.accuracy = 0.2});
    ASSERT_TRUE(solid);
    EXPECT_EQ(solid->kind, ModelKind::Sphere);
}

TEST(ReduceMesh, APlaceThatAllowsNoMoreDoesNotKeepOthers)
{
    // A ball with a thorn: one triangle of it is all that the thorn has.
    TriangleMesh full = makeSphere(0.05, 4);
    full.vertices.front() *= 1.1;
    const double accuracy = 5e-4;
    const auto model = reduceMesh(full, {.accuracy = accuracy, .kind = ModelKind::Mesh});
    ASSERT_TRUE(model);
    expectKept(full, *model, accuracy);
    EXPECT_TRUE(isWatertight(model->mesh));
    // Facets of a sphere that are off by e on one side have an area of 3 sqrt(3) R e / 2 at most:
    // the smallest mesh has about 4 pi R / (2.6 e) triangles.
    const double smallest = 4.0 * std::numbers::pi * 0.05 / (2.6 * accuracy);
    EXPECT_LT(static_cast<double>(model->mesh.triangles.size()), 1.6 * smallest);
}

TEST(ReduceMesh, DistancesAreRightUpToTheDeviations)
{
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> place(-0.12, 0.12);
    std::uniform_real_distribution<double> angle(-3.0, 3.0);
    const TriangleMesh mesh = makeTorus(0.06, 0.02, 120, 60);
    const auto model = reduceMesh(mesh, {.accuracy = 5e-4});
    ASSERT_TRUE(model);
    EXPECT_LT(model->mesh.triangles.size(), mesh.triangles.size() / 2);
    const SsvTree full = buildSsvTree(mesh);
    const SsvTree small = buildSsvTree(model->mesh);
    int apart = 0;
    for (int i = 0; i < 200; ++i)
    {
        Isometry3d pose = Isometry3d::Identity();
        pose.linear() = (Eigen::AngleAxisd(angle(random), Vector3d::UnitX()) *
                         Eigen::AngleAxisd(angle(random), Vector3d::UnitZ()))
                            .toRotationMatrix();
        pose.translation() = Vector3d(place(random), place(random), place(random));
        constexpr double kFar = std::numeric_limits<double>::infinity();
        const double truth = treeDistance(full, full, pose, kFar).distance;
        const double found = treeDistance(small, small, pose, kFar).distance;
        EXPECT_NEAR(found, truth, 2.0 * model->deviation() + 1e-9);
        apart += truth > 0.0 && found != truth ? 1 : 0;
    }
    EXPECT_GT(apart, 50);
}

TEST(ReduceMesh, AModelThatContainsTheBodyIsOutsideOfIt)
{
    const TriangleMesh full = cup();
    const auto model =
        reduceMesh(full, {.accuracy = 2e-3, .contains = true, .kind = ModelKind::Mesh});
    ASSERT_TRUE(model);
    EXPECT_LT(model->mesh.triangles.size(), full.triangles.size() / 2);
    EXPECT_TRUE(isWatertight(model->mesh));
    EXPECT_GT(massProperties(model->mesh).volume, massProperties(full).volume);
    expectKept(full, *model, 2e-3);
    EXPECT_GT(treeDistance(buildSsvTree(full),
                           buildSsvTree(model->mesh),
                           Isometry3d::Identity(),
                           std::numeric_limits<double>::infinity())
                  .distance,
              0.0);
}

TEST(ReduceMesh, FacetsOfRoundModelsContainTheBody)
{
    for (const ModelKind kind : {ModelKind::Sphere, ModelKind::Capsule})
    {
        const TriangleMesh full = placed(makeSphere(1.0, 1));
        const auto model = reduceMesh(full, {.accuracy = 0.3, .contains = true, .kind = kind});
        ASSERT_TRUE(model);
        for (const Triangle& t : model->mesh.triangles)
        {
            const auto corner = [&](std::size_t k)
            { return model->mesh.vertices[static_cast<std::size_t>(t[k])]; };
            const Vector3d normal =
                (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
            for (const Vector3d& vertex : full.vertices)
            {
                ASSERT_LE(normal.dot(vertex - corner(0)), 0.0);
            }
        }
    }
}

TEST(ReduceMesh, EndsWhenItIsStopped)
{
    const TriangleMesh full = makeSphere(0.1, 4);
    for (const bool contains : {false, true})
    {
        ReduceOptions options{.accuracy = 2e-3, .contains = contains, .kind = ModelKind::Mesh};
        ASSERT_TRUE(reduceMesh(full, options));
        options.stop = stopAfter(0.0);
        EXPECT_THROW((void)reduceMesh(full, options), QueryStopped);
        options.stop = stopAfter(5e-3);
        EXPECT_THROW((void)reduceMesh(full, options), QueryStopped);
    }
}

TEST(ReduceMesh, RefusesWhatMakesNoSense)
{
    const auto messageOf = [](const TriangleMesh& mesh, const ReduceOptions& options)
    {
        try
        {
            (void)reduceMesh(mesh, options);
        }
        catch (const std::invalid_argument& error)
        {
            return std::string(error.what());
        }
        return std::string("no exception");
    };
    const TriangleMesh box = makeBox({0.5, 0.5, 0.5});
    for (const double accuracy : {0.0, -1.0, 1e-12, std::nan(""), HUGE_VAL})
    {
        EXPECT_THAT(messageOf(box, {.accuracy = accuracy}), HasSubstr("at least 1e-09"));
    }
    EXPECT_THAT(messageOf({}, {.accuracy = 1.0}), HasSubstr("triangle"));
    const TriangleMesh open = makeTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    EXPECT_THAT(messageOf(open, {.accuracy = 0.1, .contains = true}), HasSubstr("no volume"));
    // A flat soup has no hull and no box, and is still answered.
    const auto flat = reduceMesh(open, {.accuracy = 1e-3});
    ASSERT_TRUE(flat);
    EXPECT_EQ(flat->kind, ModelKind::Mesh);
    EXPECT_EQ(flat->deviation(), 0.0);
}
}  // namespace
}  // namespace bullet_ccd
