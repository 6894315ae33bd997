/// deformableContacts() and deformableToi() against every pair of features by brute force, on every
/// instruction set of the machine, and what they refuse.
#include "bullet_ccd/deformable/deformable_toi.h"

#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/deformable/kernels/surface_kernels.h"
#include "bullet_ccd/mesh/triangle_mesh.h"
#include "bullet_ccd/toi/rigid_toi.h"
#include "tests/deformable/deformable_scenes.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <gmock/gmock.h>
#include <limits>
#include <set>
#include <string>
#include <utility>

namespace bullet_ccd::tests
{
using reference::Random;

namespace
{
/// Surfaces of meshes in their steps, and bodies of them.
struct Bodies
{
    std::vector<DeformableSurface> surfaces;
    std::vector<DeformableBody> bodies;

    explicit Bodies(const std::vector<MovingMesh>& meshes, bool selfCollision = true)
    {
        for (const MovingMesh& moving : meshes)
        {
            surfaces.emplace_back(moving.mesh);
            surfaces.back().setStep(moving.mesh.vertices, moving.end);
        }
        for (const DeformableSurface& surface : surfaces)
        {
            bodies.push_back({.surface = &surface, .selfCollision = selfCollision});
        }
    }
};

void expectSame(const std::vector<DeformableContact>& got,
                const std::vector<DeformableContact>& expected,
                const std::string& what)
{
    ASSERT_EQ(got.size(), expected.size()) << what;
    for (std::size_t i = 0; i < got.size(); ++i)
    {
        ASSERT_EQ(BruteForceContacts::keyOf(got[i]), BruteForceContacts::keyOf(expected[i]))
            << what;
        ASSERT_EQ(got[i].status, expected[i].status) << what;
        ASSERT_EQ(got[i].gap, expected[i].gap) << what;
        ASSERT_EQ(got[i].normal, expected[i].normal) << what;
        ASSERT_EQ(got[i].weights, expected[i].weights) << what;
    }
}

/// While it lives, the kernels of that level are the best.
class SimdLevel
{
public:
    explicit SimdLevel(const char* level)
    {
        const char* before = std::getenv("BULLET_CCD_SIMD");
        m_before = before != nullptr ? before : "";
        ::setenv("BULLET_CCD_SIMD", level, 1);
    }
    ~SimdLevel()
    {
        m_before.empty() ? ::unsetenv("BULLET_CCD_SIMD")
                         : ::setenv("BULLET_CCD_SIMD", m_before.c_str(), 1);
    }
    SimdLevel(const SimdLevel&) = delete;
    SimdLevel& operator=(const SimdLevel&) = delete;

private:
    std::string m_before;
};

std::vector<MovingMesh> randomScene(Random& random, int bodies, bool isFar)
{
    std::vector<MovingMesh> meshes;
    for (int b = 0; b < bodies; ++b)
    {
        meshes.push_back(crumpledCloth(random, random.integer(1, 6), 0.05, 0.15));
        if (isFar)
        {
            const Eigen::Vector3d far(1048576.0, -1048576.0, 1048576.0);
            for (std::size_t v = 0; v < meshes.back().end.size(); ++v)
            {
                meshes.back().mesh.vertices[v] += far;
                meshes.back().end[v] += far;
            }
        }
    }
    return meshes;
}

TEST(DeformableContacts, AreThoseOfEveryPairOfFeatures)
{
    Random random(230);
    DeformableWorkspace work;
    std::size_t found = 0;
    int inScenes = 0;
    std::int64_t pairs = 0;
    std::int64_t examined = 0;
    const int count = longTests() ? 400 : 24;
    for (int i = 0; i < count; ++i)
    {
        const std::vector<MovingMesh> meshes = randomScene(random, 1 + i % 3, i % 5 == 4);
        const bool selfCollision = i % 4 != 3;
        const double tolerance = random.logUniform(1e-6, 1e-2);
        const double separation = i % 2 == 0 ? 0.0 : 0.02;
        const BruteForceContacts expected(
            meshes, selfCollision, {.tolerance = tolerance, .minimumSeparation = separation});
        const Bodies bodies(meshes, selfCollision);
        std::int64_t featurePairs = -1;
        for (const SurfaceKernels& kernels : availableSurfaceKernels())
        {
            const SimdLevel level(kernels.level);
            const std::string what = "scene " + std::to_string(i) + ", " + kernels.level;
            DeformableOptions options{.tolerance = tolerance, .minimumSeparation = separation};
            const DeformableResult all = deformableContacts(bodies.bodies, options, work);
            expectSame(all.contacts, expected.contacts, what);
            // The portable kernels are the reference of the others.
            EXPECT_TRUE(featurePairs < 0 || featurePairs == all.counters.featurePairs) << what;
            featurePairs = all.counters.featurePairs;

            std::vector<DeformableContact> earliest;
            std::ranges::copy_if(expected.contacts,
                                 std::back_inserter(earliest),
                                 [&](const DeformableContact& c)
                                 { return c.time == expected.contacts.front().time; });
            const DeformableResult first = deformableToi(bodies.bodies, options, work);
            expectSame(first.contacts, earliest, what);
            EXPECT_EQ(first.time, earliest.empty() ? 1.0 : earliest.front().time) << what;
            EXPECT_EQ(first.status, all.status) << what;

            options.threads = 3;
            expectSame(
                deformableContacts(bodies.bodies, options, work).contacts, expected.contacts, what);
            expectSame(deformableToi(bodies.bodies, options, work).contacts, earliest, what);
        }
        found += expected.contacts.size();
        inScenes += expected.contacts.empty() ? 0 : 1;
        pairs += expected.pairs;
        examined += featurePairs;
    }
    EXPECT_GT(inScenes, count / 2);
    EXPECT_GT(found, 8U * static_cast<std::size_t>(count));
    EXPECT_LT(examined, pairs / 4) << "boxes leave out most pairs";
}

TEST(DeformableContacts, AreBroughtUpToDateAfterSomePathsHaveChanged)
{
    Random random(231);
    DeformableWorkspace work;
    DeformableWorkspace fresh;
    int appeared = 0;
    std::int64_t examined = 0;
    std::int64_t examinedAnew = 0;
    for (int i = 0; i < 30; ++i)
    {
        std::vector<MovingMesh> meshes = randomScene(random, 1 + i % 3, i % 5 == 4);
        Bodies bodies(meshes);
        const DeformableOptions options{
            .tolerance = 1e-3, .minimumSeparation = i % 2 == 0 ? 0.0 : 0.02, .threads = 1 + i % 2};
        DeformableResult result = deformableContacts(bodies.bodies, options, work);
        for (int round = 0; round < 6; ++round)
        {
            for (std::size_t b = 0; b < meshes.size(); ++b)
            {
                MovingMesh& moving = meshes[b];
                if (random.integer(0, 3) == 0)
                {
                    bodies.surfaces[b].keepStep();
                    continue;
                }
                for (int k = random.integer(0, 3); k > 0; --k)
                {
                    const int v = random.integer(0, int(moving.end.size()) - 1);
                    (round == 3 ? moving.mesh.vertices : moving.end)[std::size_t(v)] +=
                        random.inBox(0.05);
                }
                bodies.surfaces[b].setStep(moving.mesh.vertices, moving.end);
            }
            const std::size_t before = result.contacts.size();
            updateContacts(bodies.bodies, options, work, result);
            const DeformableResult anew = deformableContacts(bodies.bodies, options, fresh);
            expectSame(result.contacts, anew.contacts, "scene " + std::to_string(i));
            EXPECT_EQ(result.status, anew.status);
            EXPECT_EQ(result.time, anew.time);
            appeared += result.contacts.size() > before ? 1 : 0;
            examined += result.counters.featurePairs;
            examinedAnew += anew.counters.featurePairs;
        }
    }
    EXPECT_GT(appeared, 10);
    EXPECT_LT(examined, examinedAnew / 2);
}

TEST(DeformableContacts, AnAnswerThatGaveUpIsUpdatedByAskingAnew)
{
    Random random(232);
    const std::vector<MovingMesh> meshes = randomScene(random, 2, false);
    Bodies bodies(meshes);
    DeformableWorkspace work;
    DeformableResult result = deformableContacts(bodies.bodies, {.maxIterations = 1}, work);
    ASSERT_EQ(result.status, ToiStatus::IterationLimit);
    std::ranges::for_each(bodies.surfaces, &DeformableSurface::keepStep);
    updateContacts(bodies.bodies, {}, work, result);
    const DeformableResult anew = deformableContacts(bodies.bodies, {}, work);
    ASSERT_FALSE(anew.contacts.empty());
    expectSame(result.contacts, anew.contacts, "after a limit");
}

TEST(DeformableContacts, DoNotDependOnTheOrderOfTheBodiesNorOnThreadsOfTheRefit)
{
    Random random(234);
    DeformableWorkspace work;
    int found = 0;
    for (int i = 0; i < 4; ++i)
    {
        std::vector<MovingMesh> meshes = randomScene(random, 3, false);
        meshes.push_back(crumpledCloth(random, 70, 0.002, 0.01));  // large enough for two threads
        const Bodies forward(meshes);
        std::ranges::reverse(meshes);
        Bodies backward(meshes);
        for (std::size_t b = 0; b < meshes.size(); ++b)
        {
            backward.surfaces[b].setStep(meshes[b].mesh.vertices, meshes[b].end, 2);
        }
        const DeformableOptions options{.tolerance = 1e-5, .threads = 2};
        const DeformableResult first = deformableToi(forward.bodies, options, work);
        const DeformableResult again = deformableToi(backward.bodies, options, work);
        EXPECT_EQ(isContact(first.status), isContact(again.status));
        EXPECT_NEAR(first.time, again.time, 1e-3) << "the tolerance over the speed";
        const std::size_t all = deformableContacts(forward.bodies, options, work).contacts.size();
        EXPECT_EQ(deformableContacts(backward.bodies, options, work).contacts.size(), all);
        found += all > 10 ? 1 : 0;
    }
    EXPECT_GT(found, 2);
}

TEST(SurfaceKernels, NeverSeparateFeaturesThatTouch)
{
    // Whole numbers at t = 1/2, the point of contact in eighths: exact contacts.
    Random random(231);
    std::array<std::int64_t, 3> separated{};
    for (int i = 0; i < 20'000; ++i)
    {
        const bool areEdges = i % 2 == 0;
        const bool touch = i % 4 < 2;
        std::array<Eigen::Vector3d, 4> x;
        std::array<VertexStep, 4> steps{};
        for (Eigen::Vector3d& p : x)
        {
            p = Eigen::Vector3d(
                random.integer(-9, 9), random.integer(-9, 9), random.integer(-9, 9));
        }
        if (areEdges)
        {
            x[3] = x[2] + 2.0 * (x[0] + random.integer(0, 8) / 8.0 * (x[1] - x[0]) - x[2]);
        }
        else
        {
            const int a = random.integer(0, 8);
            const int b = random.integer(0, 8 - a);
            x[0] = (a * x[1] + b * x[2] + (8 - a - b) * x[3]) / 8.0;
        }
        FeatureBatch batch{.vertex = {}, .margin = 0.0, .until = 1.0};
        for (std::size_t k = 0; k < 4; ++k)
        {
            const bool isFirst = k == 0 || (k == 1 && areEdges);
            for (int c = 0; c < 3; ++c)
            {
                const double v = random.integer(-9, 9);
                steps[k].start[c] = x[k][c] - v + (isFirst && !touch ? 20.0 : 0.0);
                steps[k].end[c] = x[k][c] + v + (isFirst && !touch ? 20.0 : 0.0);
            }
            std::fill_n(batch.vertex[k], FeatureBatch::kLanes, &steps[k]);
        }
        for (std::size_t level = 0; level < availableSurfaceKernels().size(); ++level)
        {
            const SurfaceKernels& kernels = availableSurfaceKernels()[level];
            const unsigned mask =
                areEdges ? kernels.separatedEdges(batch) : kernels.separatedVertexFaces(batch);
            ASSERT_TRUE(mask == 0U || mask == 255U) << kernels.level;
            ASSERT_FALSE(touch && mask != 0U) << kernels.level << ", pair " << i;
            separated[level] += mask != 0U ? 1 : 0;
        }
    }
    for (std::size_t level = 0; level < availableSurfaceKernels().size(); ++level)
    {
        EXPECT_GT(separated[level], 8'000) << "most of the 10,000 that are apart";
        EXPECT_NEAR(double(separated[level]), double(separated[0]), 20.0);
    }
}

TEST(DeformableContacts, OfAFallingClothComeAtTheClosedFormTime)
{
    // A cloth 0.3 above a plane falls by 1: its lower parts meet the plane at t = 0.3 and beyond.
    MovingMesh floor{.mesh = reference::sheet(4), .end = {}};
    floor.end = floor.mesh.vertices;
    MovingMesh cloth{.mesh = reference::sheet(7), .end = {}};
    for (std::size_t v = 0; v < cloth.mesh.vertices.size(); ++v)
    {
        Eigen::Vector3d& x = cloth.mesh.vertices[v];
        x += Eigen::Vector3d(0.013, 0.017, 0.3 + 0.01 * double(v % 3));
        cloth.end.push_back(x - Eigen::Vector3d::UnitZ());
    }
    const Bodies bodies({floor, cloth});
    DeformableWorkspace work;
    const DeformableResult result = deformableToi(bodies.bodies, {.tolerance = 1e-9}, work);
    EXPECT_EQ(result.status, ToiStatus::Hit);
    EXPECT_NEAR(result.time, 0.3, 1e-8);
    EXPECT_EQ(result.contacts.front().bodyA, 1);
    EXPECT_NEAR(result.contacts.front().normal.z(), -1.0, 1e-9);
    // Nothing within the bodies; both at rest: nothing at all.
    const DeformableResult all = deformableContacts(bodies.bodies, {.tolerance = 1e-9}, work);
    EXPECT_TRUE(std::ranges::all_of(all.contacts,
                                    [](const DeformableContact& c) { return c.bodyA != c.bodyB; }));
    MovingMesh resting = floor;
    const Bodies still({floor, resting});
    EXPECT_EQ(deformableContacts(still.bodies, {}, work).status, ToiStatus::Separated);
}

TEST(DeformableContacts, LeaveOutWhatIsExempt)
{
    Random random(232);
    const std::vector<MovingMesh> meshes = randomScene(random, 2, false);
    const Bodies bodies(meshes);
    DeformableWorkspace work;
    const DeformableResult all = deformableContacts(bodies.bodies, {}, work);
    ASSERT_GT(all.contacts.size(), 10U);
    const auto isExempt = [&](const DeformableContact& c)
    { return c.bodyA != c.bodyB || c.vertices[0] % 2 == 0 || c.time == all.time; };
    std::vector<DeformableContact> left;
    std::ranges::remove_copy_if(all.contacts, std::back_inserter(left), isExempt);
    ASSERT_FALSE(left.empty());
    expectSame(
        deformableContacts(bodies.bodies, {.isExempt = isExempt}, work).contacts, left, "masked");
    EXPECT_EQ(deformableToi(bodies.bodies, {.isExempt = isExempt}, work).time, left.front().time);
}

// A heap of small bodies in a room: each near few others, so that the work grows with their number.
TEST(DeformableContacts, OfManyBodiesAreLookedForAmongNeighbours)
{
    Random random(31);
    std::vector<MovingMesh> meshes;
    for (int i = 0; i < 300; ++i)
    {
        const Eigen::Vector3d place = random.uniform(0.0, 20.0) * random.direction();
        MovingMesh moving{.mesh = reference::octahedron(), .end = {}};
        for (Eigen::Vector3d& x : moving.mesh.vertices)
        {
            x = place + (i % 100 == 0 ? 8.0 : 0.9) * x;
        }
        moving.end = moving.mesh.vertices;
        const Eigen::Vector3d way = 2.0 * random.direction();
        std::ranges::for_each(moving.end, [&](Eigen::Vector3d& x) { x += way; });
        meshes.push_back(moving);
    }
    Bodies bodies(meshes, false);
    for (std::size_t i = 0; i < bodies.bodies.size(); i += 7)
    {
        bodies.bodies[i].deviation = 0.3;
    }
    DeformableOptions options{.tolerance = 0.05, .minimumSeparation = 0.1};
    DeformableWorkspace work;
    // Two at a time there is nothing to sort out.
    std::vector<std::pair<std::int32_t, std::int32_t>> expected;
    for (std::size_t i = 0; i < meshes.size(); ++i)
    {
        for (std::size_t j = i + 1; j < meshes.size(); ++j)
        {
            const std::vector<DeformableBody> two{bodies.bodies[i], bodies.bodies[j]};
            if (!deformableContacts(two, options, work).contacts.empty())
            {
                expected.emplace_back(i, j);
            }
        }
    }
    int asked = 0;
    options.isPairExempt = [&asked](std::int32_t a, std::int32_t b)
    {
        EXPECT_LE(a, b);
        ++asked;
        return false;
    };
    std::set<std::pair<std::int32_t, std::int32_t>> found;
    for (const DeformableContact& c : deformableContacts(bodies.bodies, options, work).contacts)
    {
        found.insert(std::minmax(c.bodyA, c.bodyB));
    }
    EXPECT_GT(expected.size(), 100U);
    EXPECT_THAT(found, testing::ElementsAreArray(expected));
    EXPECT_LT(asked, 15000);  // of 44,850
}

TEST(DeformableContacts, ThatAreTooManyAreNeverCalledFree)
{
    Random random(233);
    MovingMesh ball{.mesh = reference::sheet(12), .end = {}};
    for (Eigen::Vector3d& x : ball.mesh.vertices)  // everything overlaps everything
    {
        x = random.inBox(1.0);
        ball.end.push_back(random.inBox(1.0));
    }
    const Bodies bodies({ball});
    DeformableWorkspace work;
    for (const int threads : {1, 2})
    {
        const DeformableOptions few{.maxIterations = 1000, .threads = threads};
        for (const DeformableResult& result : {deformableContacts(bodies.bodies, few, work),
                                               deformableToi(bodies.bodies, few, work)})
        {
            EXPECT_EQ(result.status, ToiStatus::IterationLimit);
            EXPECT_EQ(result.time, 0.0);
            EXPECT_TRUE(result.contacts.empty());
        }
    }
    EXPECT_EQ(deformableContacts(bodies.bodies, {}, work).status, ToiStatus::Hit);
}

TEST(DeformableSurface, WeldsOrRefusesVerticesAtOnePlace)
{
    // Two squares that share an edge by place, not by index, and fold.
    MovingMesh two{.mesh = reference::sheet(2), .end = {}};
    TriangleMesh other = reference::sheet(2);
    for (Eigen::Vector3d& x : other.vertices)
    {
        x.x() += 1.0;
    }
    appendMesh(two.mesh, other);
    for (const Eigen::Vector3d& x : two.mesh.vertices)
    {
        two.end.push_back(x + Eigen::Vector3d(0.0, 0.0, 0.2 * std::abs(x.x() - 1.0)));
    }
    try
    {
        const DeformableSurface refused(two.mesh);
        FAIL();
    }
    catch (const std::invalid_argument& error)
    {
        EXPECT_THAT(error.what(), ::testing::HasSubstr("vertices 2 and 9 are both at (1.0"));
        EXPECT_THAT(error.what(), ::testing::HasSubstr("weldDuplicates"));
    }
    DeformableWorkspace work;
    DeformableSurface welded(two.mesh, {.weldDuplicates = true});
    welded.setStep(two.mesh.vertices, two.end);
    const std::vector<DeformableBody> bodies{{.surface = &welded}};
    EXPECT_TRUE(deformableContacts(bodies, {}, work).contacts.empty());

    const std::vector<std::array<std::int32_t, 2>> seams{{2, 9}, {5, 12}, {8, 15}};
    EXPECT_NO_THROW(const DeformableSurface sewn(two.mesh, {.seams = seams}));
    const std::vector<std::array<std::int32_t, 2>> wrong{{2, 99}};
    EXPECT_THROW(const DeformableSurface sewn(two.mesh, {.seams = wrong}), std::invalid_argument);
}

TEST(DeformableSurface, RefusesStepsThatAreNotOfItsMesh)
{
    const TriangleMesh mesh = reference::sheet(3);
    DeformableSurface surface(mesh);
    EXPECT_EQ(surface.vertexCount(), 16U);
    EXPECT_EQ(surface.triangleCount(), 18U);
    std::vector<Eigen::Vector3d> end = mesh.vertices;
    const auto messageOf = [&](const std::vector<Eigen::Vector3d>& places) -> std::string
    {
        try
        {
            surface.setStep(mesh.vertices, places);
            return "";
        }
        catch (const std::invalid_argument& error)
        {
            return error.what();
        }
    };
    EXPECT_EQ(messageOf(end), "");
    end[7].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(messageOf(end), ::testing::HasSubstr("vertex 7 is at (1.000000, nan"));
    end[7].y() = std::numeric_limits<double>::infinity();
    EXPECT_THAT(messageOf(end), ::testing::HasSubstr("at the end of the step"));
    end.pop_back();
    EXPECT_THAT(messageOf(end),
                ::testing::HasSubstr("15 vertices at the end of the step instead of 16"));

    EXPECT_THROW(surface.setStep(mesh.vertices, mesh.vertices, 0), std::invalid_argument);

    EXPECT_THROW(DeformableSurface(TriangleMesh{}), std::invalid_argument);
    TriangleMesh broken = mesh;
    broken.triangles[3][1] = 16;
    EXPECT_THROW(DeformableSurface{broken}, std::invalid_argument);
    DeformableWorkspace work;
    const std::vector<DeformableBody> none{{}};
    EXPECT_THROW((void)deformableContacts(none, {}, work), std::invalid_argument);
    const std::vector<DeformableBody> loose{{.surface = &surface, .deviation = -1.0}};
    EXPECT_THROW((void)deformableContacts(loose, {}, work), std::invalid_argument);
}

TEST(DeformableSurface, StaysBelow250BytesPerTriangle)
{
    const DeformableSurface surface(reference::sheet(60));
    EXPECT_LT(surface.memory(), 250U * surface.triangleCount());
}

TEST(RigidStep, BoundsHowFarATurningMeshIsOffItsChords)
{
    const TriangleMesh rod = makeBox({1.0, 0.02, 0.02});
    RigidMotion motion;
    motion.w_W = {0.0, 0.3, 0.2};
    motion.v_W = {0.0, 0.0, -0.4};
    motion.X_W0.translation() = Eigen::Vector3d(0.5, 0.5, 0.5);
    const RigidStep step = rigidStep(rod, motion);
    double worst = 0.0;
    for (int k = 0; k <= 100; ++k)
    {
        const double t = k / 100.0;
        const Eigen::Isometry3d X = motion.at(t).X_W;
        for (std::size_t v = 0; v < rod.vertices.size(); ++v)
        {
            const Eigen::Vector3d chord = (1.0 - t) * step.start[v] + t * step.end[v];
            worst = std::max(worst, (X * rod.vertices[v] - chord).norm());
        }
    }
    EXPECT_LE(worst, step.deviation);
    EXPECT_GT(worst, 0.5 * step.deviation) << "the bound is not wasteful";

    // As an obstacle it stops a cloth at rest: not later than the rod itself comes to it.
    const TriangleMesh cloth = reference::sheet(5);
    DeformableSurface soft(cloth);
    DeformableSurface rigid(rod);
    rigid.setStep(step.start, step.end);
    const std::vector<DeformableBody> bodies{
        {.surface = &soft},
        {.surface = &rigid, .selfCollision = false, .deviation = step.deviation}};
    DeformableWorkspace work;
    const DeformableResult result = deformableToi(bodies, {.tolerance = 1e-6}, work);
    ASSERT_EQ(result.status, ToiStatus::Hit);
    const SsvTree rodTree = buildSsvTree(rod);
    const SsvTree clothTree = buildSsvTree(cloth);
    ToiWorkspace rigidWork;
    const ToiResult exact = rigidToi(
        {.tree = &rodTree, .motion = motion}, {.tree = &clothTree}, {.tolerance = 1e-6}, rigidWork);
    ASSERT_EQ(exact.status, ToiStatus::Hit);
    EXPECT_LE(result.time, exact.time);
    EXPECT_GT(result.time, 0.8 * exact.time);
}
TEST(RigidStep, OfALinkBoundsHowFarTheChainBendsItsPaths)
{
    // Two bars of a metre in the plane z = 0 whose joints turn by a and b; the end of the second
    // one is at (cos a + cos(a + b), sin a + sin(a + b)).
    KinematicTree tree;
    tree.links.resize(3);
    for (std::int32_t i = 1; i < 3; ++i)
    {
        Link& link = tree.links[static_cast<std::size_t>(i)];
        link.parent = i - 1;
        link.joint.type = JointType::Revolute;
        link.joint.axis = Eigen::Vector3d::UnitZ();
        link.X_PL0.translation().x() = i - 1.0;
    }
    const JointMotion motion{.root = restAt(Eigen::Isometry3d::Identity()),
                             .positions = {0.0, 0.2, 0.4},
                             .rates = {0.0, 0.3, 0.5}};
    const TriangleMesh bar = makeTriangle({1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1});
    const RigidStep step = linkStep(bar, tree, motion, 2);
    const auto tipAt = [](double t)
    {
        const double a = 0.2 + 0.3 * t;
        const double both = 0.6 + 0.8 * t;
        return Eigen::Vector3d(std::cos(a) + std::cos(both), std::sin(a) + std::sin(both), 0.0);
    };
    EXPECT_LT((step.start[0] - tipAt(0.0)).norm(), 1e-15);
    EXPECT_LT((step.end[0] - tipAt(1.0)).norm(), 1e-15);
    double worst = 0.0;
    for (int k = 0; k <= 100; ++k)
    {
        const double t = k / 100.0;
        worst = std::max(worst, (tipAt(t) - (1.0 - t) * step.start[0] - t * step.end[0]).norm());
    }
    EXPECT_LE(worst, step.deviation);
    EXPECT_GT(worst, 0.5 * step.deviation) << "the bound is not wasteful";
    JointMotion broken = motion;
    broken.rates[1] = std::numeric_limits<double>::infinity();
    EXPECT_THROW((void)linkStep(bar, tree, broken, 2), std::invalid_argument);
}
}  // namespace
}  // namespace bullet_ccd::tests
