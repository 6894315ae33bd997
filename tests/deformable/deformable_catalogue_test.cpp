/// Deforming features whose first contact is known in closed form, and on which methods fail:
/// cubics that vanish or have double roots, features that are parallel, turning faces, common
/// velocities. No contact may be late, or earlier than the tolerance explains.
#include "benchmarks/reference/oracles/plain_features.h"
#include "benchmarks/reference/scenes/deforming_scenes.h"
#include "benchmarks/reference/scenes/shapes.h"
#include "bullet_ccd/deformable/deformable_toi.h"
#include "tests/deformable/deformable_scenes.h"
#include "tests/support/test_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>

namespace bullet_ccd::tests
{
namespace
{
using Eigen::Vector3d;

struct FeatureCase
{
    std::string name;
    ElementaryPair pair;
    double time;             ///< of first contact
    double speed;            ///< at which the distance closes then
    double curvature = 0.0;  ///< of the distance, where the speed is 0
    double slack = 1e-12;    ///< what rounding of the input does to the time
};

FourPoints moved(FourPoints x, int first, int last, const Vector3d& way)
{
    for (int k = first; k <= last; ++k)
    {
        x[std::size_t(k)] += way;
    }
    return x;
}

std::vector<FeatureCase> featureCases()
{
    constexpr auto kFace = ElementaryKind::VertexFace;
    constexpr auto kEdges = ElementaryKind::EdgeEdge;
    const Vector3d down(0, 0, -1);
    const FourPoints above{
        Vector3d(0.1, 0.1, 1), Vector3d(-1, -1, 0), Vector3d(2, -1, 0), Vector3d(-1, 2, 0)};
    const FourPoints crossed{
        Vector3d(-1, 0.2, 1), Vector3d(1, 0.1, 1), Vector3d(0.3, -1, 0), Vector3d(0.1, 1, 0)};
    const FourPoints parallel{
        Vector3d(0.2, 0, 1), Vector3d(1.2, 0, 1), Vector3d(0, 0, 0), Vector3d(1, 0, 0)};
    const FourPoints collinear{
        Vector3d(-3, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 0, 0), Vector3d(1, 0, 0)};
    const FourPoints inPlane{
        Vector3d(-1, 0.1, 0), Vector3d(0, -1, 0), Vector3d(0, 1, 0), Vector3d(2, 0, 0)};
    const FourPoints wall{
        Vector3d(2, 0, 0), Vector3d(-9, 1, -9), Vector3d(9, 1, -9), Vector3d(0, 1, 9)};
    std::vector<FeatureCase> cases;
    cases.push_back(
        {"a vertex falls on a face", {kFace, above, moved(above, 0, 0, 2 * down)}, 0.5, 2.0});
    // The plane rises by t (0.5 x + 0.3 y + 0.1).
    const FourPoints low{
        Vector3d(0.4, 0.2, 1), Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
    FourPoints tilted = moved(low, 0, 0, 2 * down);
    tilted[1].z() = 0.1;
    tilted[2].z() = 0.6;
    tilted[3].z() = 0.4;
    const double tilt = 1.0 / 2.36;
    cases.push_back({"the face tilts",
                     {kFace, low, tilted},
                     tilt,
                     2.36 / std::hypot(1.0, 0.5 * tilt, 0.3 * tilt)});
    cases.push_back({"edges cross",
                     {kEdges, crossed, moved(moved(crossed, 0, 1, 2 * down), 2, 3, -0.5 * down)},
                     0.4,
                     2.5});
    // The distance in height is (t - 1/2)^2.
    cases.push_back(
        {"a double root",
         {kFace,
          {Vector3d(-0.5, 0, 0.25), Vector3d(-1, 1, 0), Vector3d(-1, -1, 0), Vector3d(1, 0, 0)},
          {Vector3d(0.5, 0, -0.25), Vector3d(-1, 1, 1), Vector3d(-1, -1, 1), Vector3d(1, 0, -1)}},
         0.5,
         0.0,
         2.0 / std::hypot(1.0, 0.5)});
    cases.push_back({"coplanar all the time",
                     {kFace, inPlane, moved(inPlane, 0, 0, Vector3d(4, 0, 0))},
                     0.25,
                     4.0});
    cases.push_back({"edges end to end",
                     {kEdges, collinear, moved(collinear, 0, 1, Vector3d(4, 0, 0))},
                     0.25,
                     4.0});
    cases.push_back(
        {"parallel edges", {kEdges, parallel, moved(parallel, 0, 1, 2.5 * down)}, 0.4, 2.5});
    cases.push_back(
        {"on the chord", {kFace, wall, moved(wall, 0, 0, Vector3d(-2, 2, 0))}, 0.5, 2.0});
    // Coplanar at 0.3, beside the face, and at 0.7.
    cases.push_back(
        {"the second root counts",
         {kFace,
          {Vector3d(0, -1, -0.42), Vector3d(-1, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)},
          {Vector3d(0, 1, 0.58), Vector3d(-1, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 1)}},
         0.7,
         0.8 / std::hypot(1.0, 0.7)});
    cases.push_back(
        {"a large common velocity",
         {kFace, above, moved(moved(above, 0, 0, 2 * down), 0, 3, Vector3d::Constant(1e6))},
         0.5,
         2.0,
         0.0,
         1e-9});
    return cases;
}

class MovingSurface
{
public:
    MovingSurface(const TriangleMesh& mesh, const std::vector<Vector3d>& end) : m_surface(mesh)
    {
        m_surface.setStep(mesh.vertices, end);
    }
    [[nodiscard]] DeformableBody body(bool selfCollision = false) const
    {
        return {.surface = &m_surface, .selfCollision = selfCollision};
    }

private:
    DeformableSurface m_surface;
};
}  // namespace

TEST(DeformableCatalogue, FeaturesMeetAtTheClosedFormTime)
{
    for (const FeatureCase& known : featureCases())
    {
        for (const double tolerance : {1e-3, 1e-6, 1e-9})
        {
            for (const ElementaryDepth depth :
                 {ElementaryDepth::Tolerance, ElementaryDepth::Decide, ElementaryDepth::Exact})
            {
                const std::string what = known.name + ", " + std::to_string(tolerance);
                const ElementaryResult result =
                    elementaryToi(known.pair, {.tolerance = tolerance, .depth = depth});
                ASSERT_TRUE(isContact(result.status)) << what;
                EXPECT_LE(result.time, known.time + known.slack) << what;
                EXPECT_LE(result.gap, tolerance * (1.0 + 1e-9) + known.slack) << what;
                const double early = known.speed > 0.0
                                         ? tolerance / known.speed
                                         : std::sqrt(2.0 * tolerance / known.curvature);
                EXPECT_GE(result.time, known.time - 1.01 * early - known.slack) << what;
            }
        }
    }
}

TEST(DeformableCatalogue, ARigidBodyIsNotLateBecauseItsPathIsAnArc)
{
    // A rod of length 2 turns by 90 degrees and meets the wall y = 1 at 1/3; its tip on the chord
    // would at 1/2.
    const TriangleMesh rod = reference::segment({0, 0, 0}, {2, 0, 0});
    const TriangleMesh wall = reference::wallAtY(1.0, 9.0);
    RigidMotion turning;
    turning.w_W = Vector3d(0, 0, std::numbers::pi / 2.0);
    const RigidStep step = rigidStep(rod, turning);
    DeformableSurface surface(rod);
    surface.setStep(step.start, step.end);
    const MovingSurface fixed(wall, wall.vertices);
    const std::vector<DeformableBody> bodies{
        {.surface = &surface, .selfCollision = false, .deviation = step.deviation}, fixed.body()};
    DeformableWorkspace work;
    EXPECT_LE(deformableToi(bodies, {}, work).time, 1.0 / 3.0);
}

/// A wall is put where a cloth comes farther than ever before at a time that is drawn: the farthest
/// of points that go straight is a convex function of time, so it meets the wall then.
TEST(DeformableCatalogue, AnythingMeetsAWallWhereItIsPut)
{
    reference::Random random(61);
    DeformableWorkspace work;
    const int count = longTests() ? 2000 : 200;
    int met = 0;
    for (int i = 0; i < count; ++i)
    {
        const MovingMesh cloth = crumpledCloth(random, 5, 0.05, 0.3);
        const Vector3d normal = random.direction();
        const auto farthest = [&](double t)
        {
            double most = -std::numeric_limits<double>::infinity();
            for (std::size_t v = 0; v < cloth.end.size(); ++v)
            {
                const Vector3d x = (1.0 - t) * cloth.mesh.vertices[v] + t * cloth.end[v];
                most = std::max(most, normal.dot(x));
            }
            return most;
        };
        const double time = random.uniform(0.05, 0.95);
        const double offset = farthest(time);
        const double speed = (offset - farthest(time - 1e-3)) / 1e-3;  // at most that at the time
        if (!(offset > farthest(0.0) + 1e-3 && speed > 0.01))
        {
            continue;
        }
        ++met;
        const Vector3d u = 10.0 * normal.unitOrthogonal();
        const Vector3d w = u.cross(normal);
        const Vector3d middle = offset * normal;
        const TriangleMesh wall{
            .vertices = {middle - u - w, middle + u - w, middle + u + w, middle - u + w},
            .triangles = {{0, 1, 2}, {0, 2, 3}}};
        const MovingSurface moving(cloth.mesh, cloth.end);
        const MovingSurface fixed(wall, wall.vertices);
        const std::vector<DeformableBody> bodies{moving.body(), fixed.body()};
        for (const double tolerance : {1e-4, 1e-8})
        {
            const DeformableResult result = deformableToi(bodies, {.tolerance = tolerance}, work);
            ASSERT_EQ(result.status, ToiStatus::Hit) << i;
            EXPECT_LE(result.time, time + 1e-13 / speed) << i;
            EXPECT_GE(result.time, time - 1.01 * (tolerance + 1e-13) / speed) << i;
        }
    }
    EXPECT_GT(met, count / 4);
}

/// A rod that turns, in more and more steps: never late, and early by the square of a step's turn.
TEST(DeformableCatalogue, ManySmallStepsOfARigidBodyComeToItsTime)
{
    const TriangleMesh rod = reference::segment({0, 0, 0}, {2, 0, 0});
    const TriangleMesh wall = reference::wallAtY(1.0, 9.0);
    const double turn = std::numbers::pi / 2.0;
    const MovingSurface fixed(wall, wall.vertices);
    DeformableSurface surface(rod);
    DeformableWorkspace work;
    for (const int steps : {1, 3, 10, 30, 100, 300})
    {
        RigidMotion motion;
        motion.w_W = Vector3d(0, 0, turn / steps);
        double time = 2.0;
        double early = 0.0;  // at most, by the deviation and the tolerance
        for (int i = 0; i < steps && time > 1.0; ++i)
        {
            motion.X_W0.linear() =
                Eigen::AngleAxisd(i * turn / steps, Vector3d::UnitZ()).toRotationMatrix();
            const RigidStep step = rigidStep(rod, motion);
            surface.setStep(step.start, step.end);
            const std::vector<DeformableBody> bodies{
                {.surface = &surface, .selfCollision = false, .deviation = step.deviation},
                fixed.body()};
            const DeformableResult result = deformableToi(bodies, {.tolerance = 1e-9}, work);
            time = isContact(result.status) ? (i + result.time) / steps : time;
            early = 2.0 * (step.deviation + 1e-9) / (2.0 * turn * std::cos(std::numbers::pi / 6.0));
            EXPECT_LT(step.deviation, 2.0 * 2.0 * turn * turn / (8.0 * steps * steps));
        }
        EXPECT_LE(time, 1.0 / 3.0 + 1e-12) << steps;
        EXPECT_GE(time, 1.0 / 3.0 - early) << steps;
    }
}

TEST(DeformableCatalogue, AFlapMeetsTheTriangleItHangsOn)
{
    const TriangleMesh flap{.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0.5, 1}},
                            .triangles = {{0, 1, 2}, {1, 0, 3}}};
    std::vector<Vector3d> end = flap.vertices;
    end[3].z() = -0.5;
    const MovingSurface moving(flap, end);
    const std::vector<DeformableBody> bodies{moving.body(true)};
    DeformableWorkspace work;
    for (const double tolerance : {1e-3, 1e-6, 1e-9})
    {
        const DeformableResult result = deformableToi(bodies, {.tolerance = tolerance}, work);
        ASSERT_EQ(result.status, ToiStatus::Hit);
        EXPECT_LE(result.time, 2.0 / 3.0);
        EXPECT_GE(result.time, 2.0 / 3.0 - 1.01 * tolerance / 1.5);
    }
}

TEST(DeformableCatalogue, ABalloonMeetsAllSixWallsAtOnce)
{
    const TriangleMesh balloon = reference::octahedron();
    std::vector<Vector3d> end = balloon.vertices;
    for (Vector3d& x : end)
    {
        x *= 2.0;
    }
    const TriangleMesh room = reference::cube(1.5);
    const MovingSurface a(balloon, end);
    const MovingSurface b(room, room.vertices);
    const std::vector<DeformableBody> bodies{a.body(), b.body()};
    DeformableWorkspace work;
    const DeformableResult all = deformableContacts(bodies, {.tolerance = 1e-9}, work);
    std::set<std::int32_t> poles;
    for (const DeformableContact& contact : all.contacts)
    {
        EXPECT_GE(contact.time, 0.5 - 1e-8);
        if (contact.kind == ElementaryKind::VertexFace && contact.bodyA == 0 && contact.time <= 0.5)
        {
            poles.insert(contact.vertices[0]);
        }
    }
    EXPECT_EQ(poles.size(), 6U);
    EXPECT_LE(all.time, 0.5);
}

TEST(DeformableCatalogue, SheetsThatWaveTogetherNeverMeet)
{
    const int n = longTests() ? 100 : 30;
    TriangleMesh sheets = reference::sheet(n);
    TriangleMesh upper = sheets;
    for (Vector3d& x : upper.vertices)
    {
        x.z() += 1e-3;
    }
    appendMesh(sheets, upper);
    std::vector<Vector3d> end = sheets.vertices;
    for (Vector3d& x : end)
    {
        x += Vector3d(3.0, -2.0, std::sin(20.0 * x.x()) * std::cos(15.0 * x.y()));
    }
    const MovingSurface moving(sheets, end);
    const std::vector<DeformableBody> bodies{moving.body(true)};
    DeformableWorkspace work;
    const DeformableResult result = deformableContacts(bodies, {.tolerance = 1e-6}, work);
    EXPECT_EQ(result.status, ToiStatus::Separated);
    EXPECT_GT(result.counters.featurePairs, n * n);
}

TEST(DeformableCatalogue, AStripThatFoldsFlatMeetsNothing)
{
    // Beside the hinge x = 0 every vertex goes from (x, y, 0) to (-x, y, 1): at 1/2 all triangles
    // are in the plane x = 0.
    TriangleMesh strip;
    for (int y = 0; y < 4; ++y)
    {
        strip.vertices.emplace_back(0.0, y, 0.0);
        strip.vertices.emplace_back(1.0, y, 0.0);
    }
    for (int i = 0; i < 6; i += 2)
    {
        strip.triangles.push_back({i, i + 1, i + 2});
        strip.triangles.push_back({i + 1, i + 3, i + 2});
    }
    std::vector<Vector3d> end = strip.vertices;
    for (Vector3d& x : end)
    {
        x = x.x() > 0.0 ? Vector3d(-x.x(), x.y(), 1.0) : x;
    }
    const MovingSurface moving(strip, end);
    const std::vector<DeformableBody> bodies{moving.body(true)};
    DeformableWorkspace work;
    EXPECT_EQ(deformableContacts(bodies, {.tolerance = 1e-3}, work).status, ToiStatus::Separated);
}

TEST(DeformableCatalogue, ATornMeshIsAnotherSurfaceForTheSameWorkspace)
{
    reference::Random random(12);
    DeformableWorkspace used;
    for (int n = 6; n > 2; --n)
    {
        const MovingMesh whole = crumpledCloth(random, n, 0.05, 0.2);
        MovingMesh torn = whole;
        torn.mesh.triangles.resize(torn.mesh.triangles.size() / 2);
        for (const MovingMesh& mesh : {whole, torn})
        {
            const MovingSurface moving(mesh.mesh, mesh.end);
            const std::vector<DeformableBody> bodies{moving.body(true)};
            DeformableWorkspace fresh;
            const DeformableResult expected = deformableContacts(bodies, {}, fresh);
            const DeformableResult got = deformableContacts(bodies, {}, used);
            ASSERT_EQ(got.contacts.size(), expected.contacts.size());
            EXPECT_EQ(got.time, expected.time);
        }
    }
}

/// Against methods that share no search with ours: boxes over the whole step, then every pair by
/// halving time and places.
TEST(DeformableCatalogue, WholeFramesHaveTheContactsOfPlainMethods)
{
    constexpr double kTolerance = 1e-4;
    DeformableWorkspace work;
    std::size_t met = 0;
    for (const std::string& name : reference::deformingScenes())
    {
        const reference::DeformingScene scene =
            reference::makeDeformingScene(name, longTests() ? 4000 : 1000, 2);
        DeformableSurface surface(scene.mesh);
        for (std::size_t step = 0; step < 2; ++step)
        {
            const auto& start = scene.frames[step];
            const auto& end = scene.frames[step + 1];
            surface.setStep(start, end);
            const std::vector<DeformableBody> bodies{{.surface = &surface}};
            const DeformableResult all =
                deformableContacts(bodies, {.tolerance = kTolerance}, work);
            std::set<std::pair<ElementaryKind, std::array<std::int32_t, 4>>> found;
            for (const DeformableContact& contact : all.contacts)
            {
                found.emplace(contact.kind, contact.vertices);
            }
            for (const reference::FeaturePair& features :
                 reference::UnionBoxes(scene.mesh).overlapping(start, end, kTolerance))
            {
                ElementaryPair pair{.kind = features.kind};
                for (std::size_t k = 0; k < 4; ++k)
                {
                    pair.start[k] = start[std::size_t(features.vertices[k])];
                    pair.end[k] = end[std::size_t(features.vertices[k])];
                }
                const bool isFound = found.erase({features.kind, features.vertices}) > 0;
                // What comes within a hundredth of the tolerance must be there, what stays beyond
                // it must not.
                if (reference::advancementToi(pair, 0.01 * kTolerance) <= 1.0)
                {
                    EXPECT_TRUE(isFound) << name << ", step " << step;
                    EXPECT_LE(reference::bisectionToi(pair, 10.0 * kTolerance), 1.0);
                    ++met;
                }
                else if (isFound)
                {
                    EXPECT_LE(reference::advancementToi(pair, 1.001 * kTolerance), 1.0) << name;
                }
            }
            EXPECT_TRUE(found.empty()) << name << ": contacts whose boxes are apart";
        }
    }
    EXPECT_GT(met, 100U);
}
}  // namespace bullet_ccd::tests
