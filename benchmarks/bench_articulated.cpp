/// A walking, running and kicking human of 15 links among 16 chessmen on their board: time per
/// query from one frame of the recorded motion to the next, with every stage of the query switched
/// off in turn, and with each pair of a link and an obstacle on its own.
#include "benchmarks/timing.h"
#include "bullet_ccd/io/mesh_file.h"
#include "bullet_ccd/mesh/make_mesh.h"
#include "bullet_ccd/toi/articulated_toi.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace bullet_ccd::benchmarks
{
namespace
{
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

/// Links of the recording, parents first.
constexpr std::array<std::array<const char*, 2>, 15> kLinks{{{"root", ""},
                                                             {"chest", "root"},
                                                             {"neck", "chest"},
                                                             {"left_shoulder", "chest"},
                                                             {"left_elbow", "left_shoulder"},
                                                             {"left_wrist", "left_elbow"},
                                                             {"right_shoulder", "chest"},
                                                             {"right_elbow", "right_shoulder"},
                                                             {"right_wrist", "right_elbow"},
                                                             {"left_hip", "root"},
                                                             {"left_knee", "left_hip"},
                                                             {"left_ankle", "left_knee"},
                                                             {"right_hip", "root"},
                                                             {"right_knee", "right_hip"},
                                                             {"right_ankle", "right_knee"}}};

/// World poses of the links, frame by frame.
using Recording = std::vector<std::vector<Isometry3d>>;

std::size_t indexOf(const std::string& name)
{
    const auto* found =
        std::find_if(kLinks.begin(), kLinks.end(), [&](const auto& l) { return name == l[0]; });
    if (found == kLinks.end())
    {
        throw std::runtime_error("the recording has a link \"" + name + "\" that is not known");
    }
    return static_cast<std::size_t>(found - kLinks.begin());
}

Recording readRecording(const fs::path& path)
{
    std::ifstream file(path);
    if (!file)
    {
        throw std::runtime_error(path.string() + ": cannot be read: name the data folder");
    }
    Recording frames;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line))
    {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream fields(line);
        std::size_t frame = 0;
        double time = 0.0;
        std::string link;
        Vector3d p;
        Eigen::Quaterniond q;
        fields >> frame >> time >> link >> p.x() >> p.y() >> p.z() >> q.w() >> q.x() >> q.y() >>
            q.z();
        frames.resize(std::max(frames.size(), frame + 1), std::vector<Isometry3d>(kLinks.size()));
        Isometry3d& X = frames[frame][indexOf(link)];
        X = Isometry3d::Identity();
        X.linear() = q.normalized().toRotationMatrix();
        X.translation() = p;
    }
    return frames;
}

/// The tree with spherical joints whose offsets are the mean of those of the recording.
KinematicTree makeTree(const Recording& frames)
{
    KinematicTree tree;
    tree.links.resize(kLinks.size());
    for (std::size_t i = 0; i < kLinks.size(); ++i)
    {
        Link& link = tree.links[i];
        link.name = kLinks[i][0];
        if (i == 0)
        {
            continue;
        }
        link.parent = static_cast<std::int32_t>(indexOf(kLinks[i][1]));
        link.joint.type = JointType::Spherical;
        for (const std::vector<Isometry3d>& poses : frames)
        {
            const Isometry3d& X_WP = poses[static_cast<std::size_t>(link.parent)];
            link.X_PL0.translation() +=
                X_WP.inverse() * poses[i].translation() / static_cast<double>(frames.size());
        }
    }
    return tree;
}

/// From frame f to the next.
JointMotion motionOf(const KinematicTree& tree, const Recording& frames, std::size_t f)
{
    JointMotion motion;
    motion.positions.assign(tree.size(), 0.0);
    motion.rates.assign(tree.size(), 0.0);
    motion.balls.resize(tree.size());
    motion.root = motionBetween(frames[f][0], frames[f + 1][0]);
    for (std::size_t i = 1; i < tree.size(); ++i)
    {
        const auto parent = static_cast<std::size_t>(tree.links[i].parent);
        const auto turn = [&](std::size_t frame) -> Eigen::Matrix3d
        { return frames[frame][parent].linear().transpose() * frames[frame][i].linear(); };
        motion.balls[i] = ballBetween(turn(f), turn(f + 1));
    }
    return motion;
}

struct Scene
{
    std::vector<SsvTree> links;
    std::vector<SsvTree> pieces;
    std::vector<const SsvTree*> linkTrees;
    std::vector<RigidBody> obstacles;
    std::size_t triangles = 0;
};

/// Upright, on y = 0, the tallest (the king) 0.9 m.
std::vector<TriangleMesh> loadPieces(const fs::path& data)
{
    std::vector<TriangleMesh> pieces;
    double kingHeight = 0.0;
    for (const char* name : {"king", "queen", "bishop", "knight", "rook", "pawn"})
    {
        pieces.push_back(loadMeshFile(data / "objects/chess" / (std::string(name) + ".ply")).mesh);
        kingHeight = std::max(kingHeight, bounds(pieces.back()).sizes().maxCoeff());
    }
    for (TriangleMesh& piece : pieces)
    {
        const Eigen::AlignedBox3d box = bounds(piece);
        Eigen::Index up = 0;
        box.sizes().maxCoeff(&up);
        Vector3d base = box.center();
        base[up] = box.min()[up];
        for (Vector3d& vertex : piece.vertices)
        {
            const Vector3d v = (vertex - base) * (0.9 / kingHeight);
            vertex = Vector3d(v[(up + 1) % 3], v[up], v[(up + 2) % 3]);
        }
    }
    return pieces;
}

/// Pieces on alternating sides of the path of the root, `aside` from it.
Scene makeScene(const fs::path& data, const Recording& frames, double aside)
{
    Scene scene;
    const fs::path meshes = data / "motions/humanoid/meshes";
    for (const auto& link : kLinks)
    {
        scene.links.push_back(
            buildSsvTree(loadMeshFile(meshes / (std::string(link[0]) + ".obj")).mesh));
    }
    for (TriangleMesh& mesh : loadPieces(data))
    {
        scene.pieces.push_back(buildSsvTree(mesh));
    }
    scene.pieces.push_back(buildSsvTree(makeBox(Vector3d(4.0, 0.05, 4.0))));
    for (const SsvTree& tree : scene.links)
    {
        scene.linkTrees.push_back(&tree);
    }
    constexpr std::array<std::size_t, 16> kMen{0, 5, 1, 5, 2, 5, 3, 5, 4, 5, 2, 5, 3, 5, 4, 5};
    for (std::size_t i = 0; i < kMen.size(); ++i)
    {
        const std::size_t f = i * (frames.size() - 1) / (kMen.size() - 1);
        Isometry3d X = Isometry3d::Identity();
        const Vector3d at = frames[f][0].translation();
        const double side = i % 2 == 0 ? 1.0 : -1.0;
        X.translation() = Vector3d(at.x(), 0.0, at.z() + side * aside);
        scene.obstacles.push_back({.tree = &scene.pieces[kMen[i]], .motion = restAt(X)});
    }
    Isometry3d X = Isometry3d::Identity();
    X.translation() = Vector3d(frames[frames.size() / 2][0].translation().x(), -0.1, 0.0);
    scene.obstacles.push_back({.tree = &scene.pieces.back(), .motion = restAt(X)});
    for (const RigidBody& body : scene.obstacles)
    {
        scene.triangles += body.tree->mesh().triangles.size();
    }
    return scene;
}

/// A link as a motion that rigidToi() takes: what a caller without articulatedToi() would do.
class LinkAsUserMotion : public UserMotion
{
public:
    LinkAsUserMotion(const KinematicTree& tree, const JointMotion& motion, std::int32_t link)
        : m_tree(tree),
          m_motion(motion),
          m_link(link),
          m_bound(linkAccelerationBound(tree, motion, kNone, link))
    {
    }
    [[nodiscard]] MotionState at(double t) const override
    {
        return linkStateAt(m_tree, m_motion, kNone, m_link, t);
    }
    [[nodiscard]] AccelerationBound accelerationBound() const override { return m_bound; }

private:
    const KinematicTree& m_tree;
    const JointMotion& m_motion;
    std::int32_t m_link;
    AccelerationBound m_bound;
};

/// Earliest contact of all pairs, one by one.
double naiveTime(const Scene& scene,
                 const KinematicTree& tree,
                 const JointMotion& motion,
                 ToiWorkspace& work)
{
    double earliest = 2.0;
    for (std::size_t i = 0; i < tree.size(); ++i)
    {
        const LinkAsUserMotion link(tree, motion, static_cast<std::int32_t>(i));
        const RigidBody body{.tree = scene.linkTrees[i], .motion = {}, .userMotion = &link};
        for (const RigidBody& obstacle : scene.obstacles)
        {
            const ToiResult result = rigidToi(body, obstacle, {.tolerance = 1e-5}, work);
            if (isContact(result.status))
            {
                earliest = std::min(earliest, result.time);
            }
        }
    }
    return earliest;
}

struct Totals
{
    double microseconds = 0.0;
    ArticulatedCounters counters;
    int hits = 0;
    int overlaps = 0;
    int busy = 0;
    double latest = 0.0;  ///< difference from the naive answer
};

struct Stage
{
    const char* name;
    ArticulatedToiOptions options;
};

void add(ArticulatedCounters& sum, const ArticulatedCounters& more)
{
    sum.pairs += more.pairs;
    sum.culledBySpace += more.culledBySpace;
    sum.culledByTime += more.culledByTime;
    sum.nodePairs += more.nodePairs;
    sum.trianglePairs += more.trianglePairs;
    sum.states += more.states;
    sum.subdivisions += more.subdivisions;
}

/// All queries, once to count and a few times to measure.
Totals measure(const Stage& stage,
               const KinematicTree& tree,
               const Scene& scene,
               const std::vector<JointMotion>& motions,
               const std::vector<double>& naive)
{
    constexpr int kRepeats = 5;
    const Environment environment(scene.obstacles);
    ToiWorkspace work;
    Totals totals;
    for (int repeat = 0; repeat <= kRepeats; ++repeat)
    {
        for (std::size_t i = 0; i < motions.size(); ++i)
        {
            const ArticulatedBody body{.tree = &tree,
                                       .linkTrees = scene.linkTrees,
                                       .motion = &motions[i],
                                       .selfPairs = {}};
            ArticulatedToiResult result;
            const double time = microsecondsOf(
                [&] { result = articulatedToi(body, environment, stage.options, work); });
            if (repeat > 0)
            {
                totals.microseconds += time / kRepeats;
                continue;
            }
            const bool isFree = result.status == ToiStatus::Separated;
            const ArticulatedCounters& c = result.counters;
            totals.hits += result.status == ToiStatus::Hit ? 1 : 0;
            totals.overlaps += result.status == ToiStatus::Overlapping ? 1 : 0;
            totals.busy += isFree && c.pairs - c.culledBySpace >= 3 ? 1 : 0;
            totals.latest = std::max(totals.latest, (isFree ? 2.0 : result.time) - naive[i]);
            add(totals.counters, c);
        }
    }
    return totals;
}

void print(const Stage& stage, const Totals& totals, double naiveMicroseconds, double count)
{
    const ArticulatedCounters& c = totals.counters;
    const auto mean = [&](std::int64_t sum) { return static_cast<double>(sum) / count; };
    const auto share = [&](std::int64_t part)
    { return 100.0 * static_cast<double>(part) / static_cast<double>(c.pairs); };
    std::printf(
        "  %-22s %9.2f us  x%.1f  hits %d, overlaps %d, free with 3 pairs %d; pairs %.0f, by space "
        "%.1f %%, by time %.2f %%; nodes %.0f, triangles %.1f, states %.0f, halved %.2f; later "
        "than naive by %.1e\n",
        stage.name,
        totals.microseconds / count,
        naiveMicroseconds / totals.microseconds,
        totals.hits,
        totals.overlaps,
        totals.busy,
        mean(c.pairs),
        share(c.culledBySpace),
        share(c.culledByTime),
        mean(c.nodePairs),
        mean(c.trianglePairs),
        mean(c.states),
        mean(c.subdivisions),
        totals.latest);
}

void run(const fs::path& data, const std::string& name, double aside)
{
    const Recording frames = readRecording(data / "motions/humanoid" / (name + "_poses.csv"));
    const KinematicTree tree = makeTree(frames);
    const Scene scene = makeScene(data, frames, aside);
    std::vector<JointMotion> motions;
    for (std::size_t f = 0; f + 1 < frames.size(); ++f)
    {
        motions.push_back(motionOf(tree, frames, f));
    }
    std::printf("%s: %zu queries, 15 links, %zu obstacles of %zu triangles\n",
                name.c_str(),
                motions.size(),
                scene.obstacles.size(),
                scene.triangles);
    ToiWorkspace work;
    std::vector<double> naive;
    double naiveMicroseconds = 0.0;
    for (const JointMotion& motion : motions)
    {
        naive.push_back(0.0);
        naiveMicroseconds +=
            microsecondsOf([&] { naive.back() = naiveTime(scene, tree, motion, work); });
    }
    const auto count = static_cast<double>(motions.size());
    std::printf("  %-22s %9.2f us\n", "rigidToi per pair", naiveMicroseconds / count);
    const std::array<Stage, 6> stages{
        {{"articulatedToi", {}},
         {"without subdivision", {.toi = {}, .subdivide = false}},
         {"without space", {.toi = {}, .cullBySpace = false}},
         {"without time", {.toi = {}, .cullByTime = false}},
         {"directional bound", {.toi = {}, .bound = MotionBound::Directional}},
         {"sum bound", {.toi = {}, .bound = MotionBound::Sum}}}};
    for (const Stage& stage : stages)
    {
        print(stage, measure(stage, tree, scene, motions, naive), naiveMicroseconds, count);
    }
}
}  // namespace
}  // namespace bullet_ccd::benchmarks

int main(int argc, char** argv)
{
    try
    {
        const std::filesystem::path data = argc > 1 ? argv[1] : "../shared/data";
        const double aside = argc > 2 ? std::atof(argv[2]) : 0.45;
        for (const char* name : {"walk", "run", "kick"})
        {
            bullet_ccd::benchmarks::run(data, name, aside);
        }
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "bench_articulated: %s\n", error.what());
        return 1;
    }
    return 0;
}
